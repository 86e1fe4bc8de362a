//! Two ways to draw one scene.

use super::*;
use ontile::picture::Pixels;

/// A left of the divider and B right of it are the two pictures bit for bit, the difference of equal ones is black, and what is told of
/// others is true; the divider moves, the window changes its size, and nothing is left behind.
#[test]
fn two_ways_to_draw_are_compared() {
    let Some(screen) = Screen::new() else { return };
    let folder = tempfile::tempdir().unwrap();
    let script = "frames 3\nscreenshot a.png\nlive before.json\nset b.layout packed128\nset b.samples 4\nset b.tonemap aces\n\
                  split 0.25\nframes 3\nscreenshot quarter.png\nsplit 0.7\nscreenshot most.png\noverlay on\nframes 3\n\
                  size 200x120\nframes 2\nsize 160x90\nframes 2\noverlay off\nsuspend\nframes 1\nresume\nframes 2\n\
                  screenshot again.png\nmeasure apart.json\ndifference 2\nframes 3\nscreenshot apart.png\noverlay on\nframes 3\n\
                  size 200x120\nframes 2\nsize 160x90\noverlay off\nset layout packed128\nset samples 4\nset tonemap aces\n\
                  frames 2\nscreenshot none.png\nmeasure none.json\nset edge-filter true\ndifference off\nframes 2\nscreenshot b.png\n\
                  set layout metallic128\nset samples 1\nset tonemap neutral\nframes 3\nscreenshot after.png\nlive after.json\n";
    let lamps = asset("lamps.glb");
    let told = view(folder.path(), &screen.display, script, &[&lamps, "--size", "160x90"]);
    assert!(told.lines().count() == 1 && told.contains("--edge-filter out"), "{told}");
    let bytes = |name: &str| match Picture::read(&folder.path().join(name)).unwrap().pixels {
        Pixels::Rgba8(bytes) => bytes,
        Pixels::Rgba32F(_) => panic!("{name} has floats"),
    };
    let (a, b) = (bytes("a.png"), bytes("b.png"));
    for (name, at) in [("quarter.png", 40), ("most.png", 112), ("again.png", 112)] {
        let found = bytes(name);
        let wrong =
            (0..a.len()).filter(|i| found[*i] != if i / 4 % 160 < at { a[*i] } else { b[*i] }).count();
        assert_eq!(wrong, 0, "{name}");
    }
    let colors = || (0..a.len()).filter(|i| i % 4 < 3);
    let none = bytes("none.png");
    assert!(colors().all(|i| none[i] == 0), "equal pictures differ");
    let apart = bytes("apart.png");
    for i in colors() {
        let expected = 2.0 * f32::from(a[i].abs_diff(b[i]));
        // Both are decoded by the device's approximation, each off by up to half a step.
        assert!((f32::from(apart[i]) - expected.min(255.0)).abs() <= 2.5, "{} {expected}", apart[i]);
    }
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let most = colors().map(|i| a[i].abs_diff(b[i])).max().unwrap();
    let squares: f64 = colors().map(|i| f64::from(a[i].abs_diff(b[i])).powi(2)).sum();
    let psnr_db = 10.0 * (255.0_f64.powi(2) * colors().count() as f64 / squares).log10();
    let measured: serde_json::Value = serde_json::from_str(&read("apart.json")).unwrap();
    assert!(most > 20 && measured["most"] == most, "{measured}, {most}");
    assert!((measured["psnr_db"].as_f64().unwrap() - psnr_db).abs() < 1e-9, "{measured}, {psnr_db}");
    assert_eq!(read("none.json"), r#"{"most":0,"psnr_db":null}"#);
    assert_eq!(bytes("after.png"), a);
    assert_eq!(read("after.json"), read("before.json"));
}
