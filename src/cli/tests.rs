use std::ffi::OsString;

use clap::{Args, CommandFactory, FromArgMatches};
use ontile::environment::TexelFormat;
use ontile::glam::Vec3;
use ontile::picture::{FileFormat, Picture, Pixels};
use ontile::plan::{Layout, Options, OutputFormat, Strategy, Tonemap};
use ontile::scene::{Background, FogHeight};

use super::bake::LightmapArgs;
use super::bake_environment::EnvironmentArgs;
use super::info::InfoArgs;
use super::model::ModelArgs;
use super::plan::PlanCommandArgs;
use super::progress::Progress;
use super::render::{self, RenderArgs};

fn command<T: Args>() -> clap::Command {
    T::augment_args(clap::Command::new("ontile"))
}

fn parse<T: Args>(line: &str) -> Result<T, clap::Error> {
    let words = std::iter::once("ontile").chain(line.split_whitespace());
    let matches = command::<T>().try_get_matches_from(words)?;
    Ok(T::from_arg_matches(&matches).unwrap())
}

fn usage_error<T: Args + std::fmt::Debug>(line: &str) -> String {
    let error = parse::<T>(line).unwrap_err();
    assert_eq!(error.exit_code(), 2, "{line}");
    error.to_string()
}

#[test]
fn definitions_are_sound() {
    super::Cli::command().debug_assert();
    command::<RenderArgs>().debug_assert();
    command::<PlanCommandArgs>().debug_assert();
    command::<InfoArgs>().debug_assert();
    command::<EnvironmentArgs>().debug_assert();
    command::<ModelArgs>().debug_assert();
    command::<LightmapArgs>().debug_assert();
}

#[test]
fn defaults_are_the_librarys() {
    let args: RenderArgs = parse("scene.glb -o out.png").unwrap();
    assert_eq!(args.options(), Options::default());
    assert_eq!(args.scene.scene.to_str(), Some("scene.glb"));
    assert_eq!((args.scene.camera, args.scene.ambient, args.scene.max_lights), (None, None, None));
    assert_eq!((args.scene.max_shadows, args.scene.no_shadows), (8, false));
    assert_eq!((args.run.frames, args.run.report, args.run.device), (1, None, None));
    assert!(!args.run.validate && !args.run.capture);
    assert_eq!(args.plan.exposure, 0.0);
}

#[test]
fn what_is_around_arrives() {
    let args: RenderArgs =
        parse("s.glb -o o.png --background #ff0080 --fog 0.02 --fog-color 1,2,0.5 --fog-height -3,8.5")
            .unwrap();
    assert_eq!(args.scene.background, Background::from_hex("#ff0080"));
    assert_eq!(args.scene.fog, Some(0.02));
    assert_eq!(args.scene.fog_color, Some(Vec3::new(1.0, 2.0, 0.5)));
    assert_eq!(args.scene.fog_height, Some(FogHeight { base_m: -3.0, scale_m: 8.5 }));
    for (flag, values) in [
        ("background", &["ff0080", "#ff008", "blue"][..]),
        ("fog", &["-1", "NaN", "inf", "much"]),
        ("fog-color", &["1,2", "1,2,3,4", "-1,0,0", "NaN,0,0", "1,2,"]),
        ("fog-height", &["1", "0,0", "0,-1", "inf,1", "0,NaN"]),
    ] {
        for value in values {
            let message = usage_error::<RenderArgs>(&format!("s.glb -o o.png --{flag} {value}"));
            assert!(message.contains("give "), "{flag} {value}: {message}");
        }
    }
}

#[test]
fn every_flag_arrives() {
    let args: RenderArgs = parse(
        "scene.gltf -o out.EXR --size 640x360 --camera north --strategy separate --layout exact --tonemap aces \
         --exposure -2.5 --ambient 30 --frames 9 --report r.json --device llvm --validate --capture --dither \
         --no-recycle --no-fold --max-lights 20 --max-shadows 3",
    )
    .unwrap();
    let expected = Options {
        size: [640, 360],
        strategy: Strategy::Separate,
        layout: Layout::Exact,
        tonemap: Tonemap::Aces,
        output: OutputFormat::Rgba32Float,
        recycle: false,
        fold: false,
        dither: true,
        ..Options::default()
    };
    assert_eq!(args.options(), expected);
    assert_eq!(args.output.format, FileFormat::Exr);
    assert_eq!((args.plan.exposure, args.scene.ambient), (-2.5, Some(30.0)));
    assert_eq!(args.scene.camera.as_deref(), Some("north"));
    assert_eq!((args.scene.max_lights, args.scene.max_shadows), (Some(20), 3));
    assert_eq!((args.run.frames, args.run.device.as_deref()), (9, Some("llvm")));
    assert_eq!(args.run.report.unwrap().to_str(), Some("r.json"));
    assert!(args.run.validate && args.run.capture);
}

#[test]
fn plan_takes_the_same_scene_and_frame_flags() {
    let line = "s.glb --size 8x9 --camera 1 --strategy separate --layout exact --tonemap linear --exposure 1 \
                --ambient 0 --dither --no-recycle --no-fold";
    let plan: PlanCommandArgs = parse(&format!("{line} --json")).unwrap();
    let render: RenderArgs = parse(&format!("{line} -o o.png")).unwrap();
    assert!(plan.json);
    assert_eq!(plan.plan.options(OutputFormat::Rgba8Srgb), render.options());
    assert_eq!(plan.scene.scene, render.scene.scene);
    assert_eq!(plan.scene.camera, render.scene.camera);
    assert_eq!(plan.scene.ambient, Some(0.0));
    assert!(parse::<InfoArgs>("--json").unwrap().json);
}

#[test]
fn environments_arrive() {
    let args: RenderArgs = parse(
        "s.glb -o o.png --environment sky.hdr --environment-rotation -45 --environment-intensity 0.5 \
         --environment-format rgbm",
    )
    .unwrap();
    assert_eq!(args.scene.far.environment.as_deref(), Some("sky.hdr".as_ref()));
    let numbers = (args.scene.far.environment_rotation, args.scene.far.environment_intensity);
    assert_eq!(numbers, (Some(-45.0), Some(0.5)));
    assert_eq!(args.options().environment_format, TexelFormat::Rgbm);
    let args: EnvironmentArgs = parse("sky.hdr -o sky.ktx2 --size 128 --environment-format rgba16f").unwrap();
    assert_eq!((args.size, args.environment_format), (128, TexelFormat::Rgba16F));
    let args: EnvironmentArgs = parse("sky.hdr -o sky.ktx2").unwrap();
    assert_eq!((args.size, args.environment_format), (256, Options::default().environment_format));
    for size in ["100", "8", "2048", "-16", "big"] {
        assert!(
            usage_error::<EnvironmentArgs>(&format!("a -o b --size {size}")).contains("16 to 1024"),
            "{size}"
        );
    }
}

#[test]
fn backgrounds_and_lightmap_formats_arrive() {
    let args: RenderArgs = parse("s.glb -o o.png --background environment --lightmap-format rgbm").unwrap();
    assert_eq!(args.scene.background, Some(Background::Environment));
    assert_eq!(args.options().lightmap_format, TexelFormat::Rgbm);
    let args: RenderArgs = parse("s.glb -o o.png").unwrap();
    assert_eq!(args.scene.background, None);
    assert_eq!(args.options().lightmap_format, Options::default().lightmap_format);
}

#[test]
fn usage_errors_say_what_is_right() {
    let cases = [
        ("s.glb", "--output"),
        ("-o o.png", "SCENE"),
        ("s.glb -o o.bmp", "use .png (8 bits, sRGB) or .exr"),
        ("s.glb -o out", "use .png (8 bits, sRGB) or .exr"),
        ("s.glb -o o.png --size 640", "as in 1280x720"),
        ("s.glb -o o.png --size 640x", "as in 1280x720"),
        ("s.glb -o o.png --size +6x4", "as in 1280x720"),
        ("s.glb -o o.png --size 0x360", "from 1 to 32768"),
        ("s.glb -o o.png --size 640x40000", "from 1 to 32768"),
        ("s.glb -o o.png --size 640x99999999999", "as in 1280x720"),
        ("s.glb -o o.png --layout fat", "packed128, exact, auto"),
        ("s.glb -o o.png --tonemap agx", "neutral, aces, reinhard, linear"),
        ("s.glb -o o.png --strategy subpass", "subpasses, separate"),
        ("s.glb -o o.png --exposure NaN", "from -64 to 64"),
        ("s.glb -o o.png --exposure bright", "from -64 to 64"),
        ("s.glb -o o.png --ambient -1", "0 or more"),
        ("s.glb -o o.png --ambient inf", "0 or more"),
        ("s.glb -o o.png --max-lights few", "--max-lights"),
        ("s.glb -o o.png --no-shadows --max-shadows 2", "cannot be used with"),
        ("s.glb -o o.png --environment-rotation NaN", "an angle in degrees"),
        ("s.glb -o o.png --environment-intensity -1", "0 or more"),
        ("s.glb -o o.png --environment-format rgb9e5", "rgbm, b10g11r11, e5b9g9r9, rgba16f"),
        ("s.glb -o o.png --max-lights -1", "0 or more"),
        ("s.glb -o o.png --max-shadows x", "0 or more"),
        ("s.glb -o o.png --max-shadows -1", "0 or more"),
        ("s.glb -o o.png --frames 0", "--frames"),
        ("s.glb -o o.png --frames -1", "-1 is not in 1.."),
        ("s.glb -o o.png --unknown", "--unknown"),
    ];
    for (line, expected) in cases {
        let message = usage_error::<RenderArgs>(line);
        assert!(message.contains(expected), "{line}: {message}");
    }
}

#[test]
fn negative_numbers_are_values() {
    assert_eq!(
        parse::<RenderArgs>("s.glb -o o.png --camera -1").unwrap().scene.camera.as_deref(),
        Some("-1")
    );
    for (flag, range) in [("size", "16..=4096"), ("samples", "1..=1048576"), ("bounces", "0..=1000")] {
        let message = usage_error::<LightmapArgs>(&format!("s.glb -o o.glb --{flag} -1"));
        assert!(message.contains(&format!("-1 is not in {range}")), "{message}");
    }
}

#[cfg(unix)]
#[test]
fn paths_need_not_be_unicode() {
    use std::os::unix::ffi::OsStringExt;
    let path = OsString::from_vec(b"out-\xff.png".to_vec());
    let words = ["ontile".into(), "s.glb".into(), "-o".into(), path.clone()];
    let matches = command::<RenderArgs>().try_get_matches_from(words).unwrap();
    assert_eq!(RenderArgs::from_arg_matches(&matches).unwrap().output.path.as_os_str(), path);
}

#[test]
fn help_explains_every_flag_with_its_default() {
    for mut command in [
        command::<RenderArgs>(),
        command::<PlanCommandArgs>(),
        command::<InfoArgs>(),
        command::<EnvironmentArgs>(),
    ] {
        let help = command.render_long_help().to_string();
        assert!(help.contains("Examples:\n  ontile "), "{help}");
        for arg in command.get_arguments() {
            let id = arg.get_id();
            assert!(arg.get_help().is_some(), "{id} has no help");
            if let Some(long) = arg.get_long() {
                assert!(help.contains(&format!("--{long}")), "{id} is missing in:\n{help}");
            }
            let says_default = help_of(arg).contains("[default: ") || !arg.get_default_values().is_empty();
            let needs_default = !arg.is_required_set() && id != "json" && id != "help";
            assert!(says_default || !needs_default, "{id} does not say its default");
        }
    }
}

fn help_of(arg: &clap::Arg) -> String {
    arg.get_long_help().or(arg.get_help()).map(ToString::to_string).unwrap_or_default()
}

#[test]
fn render_writes_picture_and_report_or_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let picture = Picture { width: 1, height: 1, pixels: Pixels::Rgba8(vec![1, 2, 3, 4]) };
    let render = |output: &str, report: &str, fails: bool| {
        let args: RenderArgs = parse(&format!("s.glb -o {} --report {}", at(output), at(report))).unwrap();
        let mut called = false;
        let done = render::run_with(&args, || {
            called = true;
            let failure = || ontile::Error::unsupported("nothing works", "give up");
            if fails { Err(failure()) } else { Ok((picture.clone(), serde_json::json!({"passes": 1}))) }
        });
        (done.map_err(|e| e.to_string()), called)
    };
    let files = || std::fs::read_dir(folder.path()).unwrap().count();

    for (output, report) in [("absent/o.png", "r.json"), ("o.png", "absent/r.json")] {
        let (done, called) = render(output, report, false);
        assert!(done.unwrap_err().contains("its folder does not exist"));
        assert!(!called, "long work was done for nothing");
    }
    let (done, called) = render("o.png", "../", false);
    assert!(done.unwrap_err().contains("it is a folder"));
    assert!(!called, "long work was done for nothing");
    let (done, called) = render("o.png", "./o.png", false);
    assert!(done.unwrap_err().contains("it would replace"));
    assert!(!called, "long work was done for nothing");
    assert_eq!(render("o.png", "r.json", true).0.unwrap_err(), "nothing works; give up");
    assert_eq!(files(), 0);

    if cfg!(target_os = "linux") {
        assert!(render("o.png", "/dev/full", false).0.unwrap_err().contains("/dev/full: cannot write"));
        assert_eq!(files(), 0, "the picture of a run that failed");
    }
    render("o.png", "r.json", false).0.unwrap();
    assert_eq!(Picture::read(&folder.path().join("o.png")).unwrap(), picture);
    let report: serde_json::Value = serde_json::from_slice(&std::fs::read(at("r.json")).unwrap()).unwrap();
    assert_eq!(report["passes"], 1);
    assert_eq!(files(), 2);
}

#[test]
fn progress_can_be_made_stepped_and_dropped_anywhere() {
    let steps = Progress::of_steps("Rendering", 3);
    (0..5).for_each(|_| steps.step());
    drop(Progress::of("Loading"));
}
