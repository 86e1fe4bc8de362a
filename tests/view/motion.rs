//! Animations that play, and cameras that fly.

use super::*;
use gltf_build::{Channel, Gltf, animate};
use ontile::scene::Flight;
use serde_json::json;

/// A triangle that shrinks to nothing and comes back mirrored, another beside it that turns, a lamp that passes by and a camera that
/// nears; by a second animation the first one slides.
fn moving_parts() -> Vec<u8> {
    let mut file = Gltf::triangle();
    let other = file.root_node(json!({"mesh": 0, "translation": [-1, 0, 0]}));
    file.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 8}]}});
    file.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    file.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}));
    let lamp = json!({"translation": [0, 0, 1], "extensions": {"KHR_lights_punctual": {"light": 0}}});
    let (lamp, camera) =
        (file.root_node(lamp), file.root_node(json!({"camera": 0, "translation": [0, 0, 3]})));
    let sizes = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, -1.0, 1.0, 1.0];
    let channels: [Channel; 4] = [
        (0, "scale", "STEP", &[0.0, 0.25, 0.5], "VEC3", &sizes),
        (other, "rotation", "LINEAR", &[0.0, 0.75], "VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.6, 0.8]),
        (lamp, "translation", "LINEAR", &[0.0, 0.75], "VEC3", &[-1.0, 0.0, 1.0, 1.0, 1.0, 1.0]),
        (camera, "translation", "LINEAR", &[0.0, 0.75], "VEC3", &[0.0, 0.0, 3.0, 0.5, 0.0, 2.0]),
    ];
    animate(&mut file, &channels);
    let slide: Channel = (0, "translation", "LINEAR", &[0.0, 0.5], "VEC3", &[0.0, 0.0, 0.0, 0.5, 0.0, 0.0]);
    animate(&mut file, &[slide]);
    file.to_gltf()
}

/// A window that goes from one time to another shows what `render` shows of it at once; hundreds of frames that play leave nothing.
#[test]
fn what_plays_is_the_picture_of_its_time_and_leaves_nothing_behind() {
    let Some(screen) = Screen::new() else { return };
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("parts.gltf"), moving_parts()).unwrap();
    let charmer = asset("charmer.glb");
    let picture = |name: &str| Picture::read(&folder.path().join(name)).unwrap();
    let cases: [(&str, &[&str], [f64; 4]); 4] = [
        ("parts.gltf", &["--animation", "all"], [0.6, 0.3, 0.1, 0.7]),
        (
            "parts.gltf",
            &["--strategy", "separate", "--samples", "4", "--animation", "0"],
            [0.3, 0.0, 0.6, 9.0],
        ),
        (&charmer, &[], [1.3, 0.2, 2.9, 0.0]),
        (&charmer, &["--shadow-volumes", "--frames-in-flight", "3"], [0.4, 1.3, 1.3, -1.0]),
    ];
    for (scene, options, times) in cases {
        let args = [&[scene, "--size", "160x90"], options].concat();
        let mut script = String::from("frames 4\nscreenshot begin.png\nlive before.json\n");
        for (i, time) in times.iter().enumerate() {
            script += &format!("time {time}\nframes {}\nscreenshot {i}.png\n", i % 3);
        }
        script += &format!("speed 3\nplay\nframes {PLAYED}\noverlay on\nframes 20\noverlay off\npause\n");
        script += "time 0\nframes 4\nscreenshot end.png\nlive after.json\n";
        let told = view(folder.path(), &screen.display, &script, &args);
        assert_eq!(told, "", "{args:?}");
        let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
        assert_eq!(read("after.json"), read("before.json"), "{args:?}");
        assert_eq!(difference(&picture("end.png"), &picture("begin.png")), None, "{args:?}");
        for (name, time) in ["begin", "0", "1", "2", "3"].into_iter().zip([0.0].iter().chain(&times)) {
            let time = time.to_string();
            let of_window = ["--frames-in-flight", "3"];
            let rest: Vec<_> = args.iter().copied().filter(|arg| !of_window.contains(arg)).collect();
            let at = [&["render"], &rest[..], &["--time", &time, "-o", "render.png"]].concat();
            ontile(folder.path(), "", &at);
            let difference = difference(&picture(&format!("{name}.png")), &picture("render.png"));
            assert_eq!(difference, None, "{args:?} at {time} s");
        }
        let moves = times
            .iter()
            .zip(0..)
            .any(|(_, i)| difference(&picture(&format!("{i}.png")), &picture("begin.png")).is_some());
        assert!(moves, "{args:?}: nothing moves");
    }
}

/// Frames that play: several times round at any rate.
const PLAYED: usize = 300;

/// A camera that is turned by hand, recorded and flown again; `render` flies the same way.
#[test]
fn a_camera_path_is_recorded_and_flown() {
    let Some(screen) = Screen::new() else { return };
    let folder = tempfile::tempdir().unwrap();
    let picture = |name: &str| Picture::read(&folder.path().join(name)).unwrap();
    let lamps = asset("lamps.glb");
    let args = [lamps.as_str(), "--size", "160x90"];
    let script = "frames 3\nscreenshot begin.png\nrecord way.flight\nframes 2\ndrag 40 5\nframes 2\ndrag 30 -3\nframes 2\nstop\n\
                  camera 0\nfly way.flight\nscreenshot flown.png\ncamera 0\nscreenshot back.png\nrecord whole.flight\nframes 1";
    assert_eq!(view(folder.path(), &screen.display, script, &args), "");
    let way = Flight::load(&folder.path().join("way.flight")).unwrap();
    let mut eyes: Vec<_> = way.keys().iter().map(|key| key.eye_m).collect();
    eyes.dedup();
    assert_eq!(eyes.len(), 3, "{way:?}");
    assert!(way.keys().iter().all(|key| key.yfov_rad == way.keys()[0].yfov_rad));
    assert!(Flight::load(&folder.path().join("whole.flight")).is_ok(), "what is not stopped is written too");
    assert_eq!(difference(&picture("back.png"), &picture("begin.png")), None);
    assert!(difference(&picture("flown.png"), &picture("begin.png")).is_some(), "it flies");
    let render =
        ["render", &lamps, "--size", "160x90", "--flight", "way.flight", "--frames", "3", "-o", "render.png"];
    ontile(folder.path(), "", &render);
    assert_eq!(difference(&picture("flown.png"), &picture("render.png")), None);
    // A flight to begin with.
    view(
        folder.path(),
        &screen.display,
        "frames 300\nscreenshot end.png",
        &[&args[..], &["--flight", "way.flight"]].concat(),
    );
    assert_eq!(difference(&picture("end.png"), &picture("flown.png")), None);
}
