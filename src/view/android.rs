//! The app on Android: what NativeActivity starts.
//!
//! It shows the scene that the intent names, else the first of the package: `adb shell am start -n
//! org.ontile.view/android.app.NativeActivity --es scene PATH` (a file that the app may read, or the name of one of the
//! package's assets), or a `.glb` that a file manager hands over. The panel "Scenes" lists the package's, and the files of the app's
//! external folder.

use std::ffi::CString;
use std::fs::File;
use std::io::Read;
use std::os::fd::FromRawFd;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use android_logger::Config;
use jni::objects::{JObject, JString};
use jni::{Env, JavaVM, jni_sig, jni_str};
use log::LevelFilter;
use winit::event_loop::EventLoop;
use winit::platform::android::EventLoopBuilderExtAndroid;
use winit::platform::android::activity::AndroidApp;

use super::{Viewer, no_window, scenes};
use crate::{Error, Result, file};

/// Shown where nothing else was asked for.
const FIRST_SCENE: &str = "courtyard.glb";

/// Called by the activity's native half on a thread of its own.
// SAFETY: the name is the one that android-activity calls, with this signature.
#[unsafe(no_mangle)]
fn android_main(app: AndroidApp) {
    android_logger::init_once(Config::default().with_max_level(LevelFilter::Info).with_tag("ontile"));
    if let Err(error) = run(app) {
        log::error!("{error}");
    }
}

fn run(app: AndroidApp) -> Result<()> {
    let asked = intent(&app).unwrap_or_else(|e| {
        log::warn!("the intent cannot be read: {e}");
        None
    });
    let folder = app.internal_data_path().ok_or_else(|| {
        Error::unsupported("the system gives the app no folder", "start it as an activity of a package")
    })?;
    let scene = match asked {
        Some(Asked::File(path)) if path.is_file() => path,
        Some(Asked::File(path)) => asset(&app, &folder, &path.to_string_lossy())?,
        Some(Asked::Opened(file)) => copy(file, &folder)?,
        None => asset(&app, &folder, FIRST_SCENE)?,
    };
    let mut viewer = Viewer::new(scene);
    let (of_package, load) = (app.clone(), viewer.load);
    let own = folder.clone();
    viewer.load = Arc::new(move |path| {
        // What the list names of the package becomes a file when it is wanted.
        let name = path.file_name().and_then(|name| name.to_str());
        match name.filter(|_| path.parent() == Some(&own) && !path.exists()) {
            Some(name) => load(&asset(&of_package, &own, name)?),
            None => load(path),
        }
    });
    let of_package = app.clone();
    viewer.list = Arc::new(move |_| list(&of_package, &folder));
    let events = EventLoop::builder().with_android_app(app).build().map_err(|e| no_window(&e))?;
    viewer.run_on(events)
}

/// The package's scenes, and those in the folder that the app shows to the outside: `Android/data/org.ontile.view/files`, for adb and
/// USB.
fn list(app: &AndroidApp, folder: &Path) -> Vec<PathBuf> {
    let names = app.asset_manager().open_dir(c"").into_iter().flatten();
    let assets = names.filter_map(|name| name.into_string().ok()).map(|name| folder.join(name));
    let mut all: Vec<_> = assets.filter(|path| scenes::is_scene(path)).collect();
    all.sort();
    all.extend(app.external_data_path().iter().flat_map(|folder| scenes::of_folder(folder)));
    all
}

/// What the intent wants to see.
enum Asked {
    /// The extra `scene`.
    File(PathBuf),
    /// The data of a VIEW intent.
    Opened(File),
}

fn intent(app: &AndroidApp) -> jni::errors::Result<Option<Asked>> {
    // SAFETY: the pointer is the process' virtual machine, which lives as long as it.
    let vm = unsafe { JavaVM::from_raw(app.vm_as_ptr().cast()) };
    vm.attach_current_thread(|env| {
        let activity = app.activity_as_ptr().cast();
        // SAFETY: the activity is alive while `app` is, and the reference stays its owner's.
        let activity = unsafe { env.as_cast_raw::<JObject>(&activity)? };
        let intent = env
            .call_method(&*activity, jni_str!("getIntent"), jni_sig!("()Landroid/content/Intent;"), &[])?
            .l()?;
        let key = JString::from_str(env, "scene")?;
        let extra = env
            .call_method(
                &intent,
                jni_str!("getStringExtra"),
                jni_sig!("(Ljava/lang/String;)Ljava/lang/String;"),
                &[(&key).into()],
            )?
            .l()?;
        if !extra.is_null() {
            let path = env.cast_local::<JString>(extra)?.try_to_string(env)?;
            return Ok(Some(Asked::File(path.into())));
        }
        let uri = env.call_method(&intent, jni_str!("getData"), jni_sig!("()Landroid/net/Uri;"), &[])?.l()?;
        if uri.is_null() { Ok(None) } else { opened(env, &activity, &uri).map(Some) }
    })
}

/// The file behind a URI of any content provider.
fn opened(env: &mut Env, activity: &JObject, uri: &JObject) -> jni::errors::Result<Asked> {
    let resolver = env
        .call_method(
            activity,
            jni_str!("getContentResolver"),
            jni_sig!("()Landroid/content/ContentResolver;"),
            &[],
        )?
        .l()?;
    let mode = JString::from_str(env, "r")?;
    let descriptor = env
        .call_method(
            &resolver,
            jni_str!("openFileDescriptor"),
            jni_sig!("(Landroid/net/Uri;Ljava/lang/String;)Landroid/os/ParcelFileDescriptor;"),
            &[uri.into(), (&mode).into()],
        )?
        .l()?;
    let number = env.call_method(&descriptor, jni_str!("detachFd"), jni_sig!("()I"), &[])?.i()?;
    // SAFETY: detaching makes the caller the owner of the descriptor.
    Ok(Asked::Opened(unsafe { File::from_raw_fd(number) }))
}

/// One of the package's assets as a file, with all that is no scene beside it: it may name an environment.
fn asset(app: &AndroidApp, folder: &Path, name: &str) -> Result<PathBuf> {
    let assets = app.asset_manager();
    let content = |name: &str| -> Option<Vec<u8>> {
        let mut asset = assets.open(&CString::new(name).ok()?)?;
        let mut bytes = Vec::new();
        asset.read_to_end(&mut bytes).ok()?;
        Some(bytes)
    };
    let Some(scene) = content(name) else {
        let remedy = "name a file that the app may read, or one of the package's scenes";
        return Err(Error::input(Path::new(name), "scene", "is neither a file nor an asset", remedy));
    };
    for beside in assets.open_dir(c"").into_iter().flatten().filter_map(|name| name.into_string().ok()) {
        if let Some(bytes) = content(&beside).filter(|_| !beside.ends_with(".glb")) {
            file::write_whole(&folder.join(&beside), &bytes)?;
        }
    }
    let path = folder.join(name);
    file::write_whole(&path, &scene)?;
    Ok(path)
}

fn copy(mut opened: File, folder: &Path) -> Result<PathBuf> {
    let path = folder.join("opened.glb");
    let mut bytes = Vec::new();
    opened.read_to_end(&mut bytes).map_err(|e| Error::io(&path, "read", e))?;
    file::write_whole(&path, &bytes)?;
    Ok(path)
}
