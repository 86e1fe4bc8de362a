//! What is drawn over the picture.

use super::*;
use gltf_build::{Channel, Gltf, animate};
use ontile::picture::Pixels;
use serde_json::json;

/// The overlay covers a part of the picture, by whatever the frame is drawn, and leaves no trace when it goes.
#[test]
fn the_overlay_comes_and_goes() {
    let Some(screen) = Screen::new() else { return };
    let folder = tempfile::tempdir().unwrap();
    let picture = |name: &str| Picture::read(&folder.path().join(name)).unwrap();
    let lamps = asset("lamps.glb");
    let mut script = String::from(
        "frames 3\nscreenshot before.png\nlive before.json\noverlay on\nframes 3\nscreenshot over.png\n",
    );
    for (name, value) in OVER {
        script += &format!("set {name} {value}\nframes 2\nscreenshot {name}-{value}.png\n");
    }
    script += "size 200x120\nframes 2\nsize 640x360\noverlay off\nset strategy subpasses\nset samples 1\nset layout metallic128\n";
    script += "frames 3\nscreenshot after.png\nlive after.json\n";
    let told = view(folder.path(), &screen.display, &script, &[&lamps, "--size", "640x360"]);
    assert_eq!(told, "");
    assert_eq!(difference(&picture("after.png"), &picture("before.png")), None);
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert_eq!(read("after.json"), read("before.json"));
    for (name, value) in OVER {
        let over = picture(&format!("{name}-{value}.png"));
        assert!(difference(&over, &picture("before.png")).is_some(), "{name} {value}: no overlay");
        let (found, expected) = (letters(&over), letters(&picture("over.png")));
        assert!(
            found.abs_diff(expected) * 10 < expected,
            "{name} {value}: {found} pixels of letters, not {expected}"
        );
    }
}

/// How many pixels of the panel's title are as bright as its letters.
fn letters(picture: &Picture) -> usize {
    let Pixels::Rgba8(bytes) = &picture.pixels else { panic!("bytes") };
    let at = (14..40).flat_map(|y| (60..400).map(move |x| 4 * (y * picture.width as usize + x)));
    at.filter(|at| bytes[*at..at + 3].iter().all(|channel| *channel > 90)).count()
}

/// Options that change what the overlay is drawn over.
const OVER: [(&str, &str); 6] = [
    ("strategy", "separate"),
    ("samples", "4"),
    ("strategy", "subpasses"),
    ("layout", "packed128"),
    // All letters of this one were there before.
    ("tonemap", "aces"),
    ("tonemap", "neutral"),
];

/// A wall, seen by a parallel camera, with 100 pixels a metre in pictures 400 pixels high; a bright lamp just before it ends 1.5 m
/// around a place 2 m to the right of the middle, a second later 1 m further. A second camera is 1 m to the right.
fn lamp_at_a_wall() -> Vec<u8> {
    let mut file = Gltf::triangle();
    file.json["nodes"][0] = json!({"mesh": 0, "translation": [-20, -20, 0], "scale": [80, 80, 1]});
    file.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    let lamp = json!({"type": "point", "intensity": 1e5, "range": 1.5, "color": [1, 0.2, 0.2]});
    file.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [lamp]}});
    file.push(
        "cameras",
        json!({"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 2, "znear": 1, "zfar": 9}}),
    );
    let lamp = json!({"translation": [2, 0, 0.1], "extensions": {"KHR_lights_punctual": {"light": 0}}});
    let lamp = file.root_node(lamp);
    let way: Channel = (lamp, "translation", "LINEAR", &[0.0, 1.0], "VEC3", &[2.0, 0.0, 0.1, 3.0, 0.0, 0.1]);
    animate(&mut file, &[way]);
    // What casts a shadow, below the panel.
    file.root_node(json!({"mesh": 0, "translation": [-4, 0, 0.5]}));
    file.root_node(json!({"camera": 0, "translation": [0, 0, 5]}));
    file.root_node(json!({"camera": 0, "translation": [1, 0, 5]}));
    file.to_gltf()
}

const WALL: [u32; 2] = [1000, 400];
/// The panel is left of this.
const FREE_FROM: u32 = 400;

/// Where a picture differs from another, right of the panel.
fn drawn(over: &Picture, without: &Picture) -> Vec<[f64; 2]> {
    let (Pixels::Rgba8(a), Pixels::Rgba8(b)) = (&over.pixels, &without.pixels) else { panic!("bytes") };
    let differs = a.chunks(4).zip(b.chunks(4)).enumerate().filter(|(_, (a, b))| a != b);
    let at = differs.map(|(i, _)| [i as u32 % WALL[0], i as u32 / WALL[0]]).filter(|at| at[0] >= FREE_FROM);
    at.map(|at| at.map(|c| f64::from(c) + 0.5)).collect()
}

/// Outlines are where what they outline ends in the picture, on turned screens too; without a shadow they are dashed; the cells
/// shown are those that `--show lights` says are evaluated.
#[test]
fn outlines_are_where_lights_end() {
    let Some(screen) = Screen::new() else { return };
    let folder = tempfile::tempdir().unwrap();
    let picture = |name: &str| Picture::read(&folder.path().join(name)).unwrap();
    std::fs::write(folder.path().join("wall.gltf"), lamp_at_a_wall()).unwrap();
    let run = |script: &str, size: &str, more: &[&str]| {
        let args = [&["wall.gltf", "--size", size][..], more].concat();
        assert_eq!(view(folder.path(), &screen.display, script, &args), "");
    };
    let script = "screenshot lit.png\nlive before.json\noverlay on\nframes 2\nscreenshot over.png\nvolumes on\nframes 2\nscreenshot lines.png\ncamera 1\ntime 0.5\nscreenshot there.png\ntime 1\nscreenshot then.png\ncamera 0\ntime 0\n\
                  volumes off\nframes 2\nscreenshot off.png\noverlay off\nframes 3\nlive after.json";
    for (turn, size, more) in
        [(0, "1000x400", &[][..]), (90, "400x1000", &[]), (270, "400x1000", &["--no-shadows"])]
    {
        run(&format!("frames 1\nturn {turn}\nframes 2\n{script}"), size, more);
        let [lit, over, lines, off] = ["lit.png", "over.png", "lines.png", "off.png"].map(picture);
        assert_eq!(drawn(&off, &over), [[0.0; 2]; 0], "{turn}: nothing is left");
        let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
        assert_eq!(read("after.json"), read("before.json"), "{turn}");
        let lines = drawn(&lines, &over);
        // At once where camera and lamp have gone: half a metre to the left, and back.
        for (name, x) in [("there.png", 650.0), ("then.png", 700.0)] {
            let moved = drawn(&picture(name), &over);
            let is_on =
                |[at, y]: &[f64; 2]| ((at - x).hypot(y - 200.0) - 150.0).abs() < 2.0 && (at - x).abs() > 60.0;
            for is_left in [true, false] {
                let count = moved.iter().filter(|at| is_on(at) && (at[0] < x) == is_left).count();
                let least = if more.is_empty() { 250 } else { 60 };
                assert!(count > least, "{turn}: {name}: {count} pixels of the circle");
            }
        }
        let from_lamp = |[x, y]: [f64; 2]| [x - 700.0, y - 200.0];
        let on_circle = |at: [f64; 2]| {
            let [x, y] = from_lamp(at);
            (x.hypot(y) - 150.0).abs() < 2.0
        };
        // Two of the ball's great circles are seen from their side, and the lamp is a dot.
        let is_outline = |at: &[f64; 2]| {
            let [x, y] = from_lamp(*at);
            on_circle(*at) || x.abs().min(y.abs()) < 2.0 && x.hypot(y) < 152.0 || x.hypot(y) < 5.0
        };
        let stray: Vec<_> = lines.iter().filter(|at| !is_outline(at)).collect();
        assert!(stray.is_empty(), "{turn}: {stray:?}");
        let circle: Vec<_> = lines.iter().copied().filter(|at| on_circle(*at)).collect();
        // Of 72 directions, those in which the circle is drawn; with a shadow all of them.
        let is_drawn = |n: &i32| {
            let (sin, cos) = (f64::from(*n) * std::f64::consts::TAU / 72.0).sin_cos();
            circle.iter().any(|[x, y]| (x - 700.0 - 150.0 * cos).hypot(y - 200.0 - 150.0 * sin) < 2.0)
        };
        let count = (0..72).filter(is_drawn).count();
        assert!(
            if more.is_empty() { count == 72 } else { (18..62).contains(&count) },
            "{turn}: {count} of 72"
        );
        // And the picture ends where the circle is: by the wall's distance from the lamp 0.3 pixels nearer.
        let Pixels::Rgba8(bytes) = &lit.pixels else { panic!("bytes") };
        for y in (60..340).step_by(20) {
            let is_lit = |x: &u32| bytes[4 * (y * WALL[0] + x) as usize] > 0;
            let ends = [(FREE_FROM..WALL[0]).find(is_lit), (FREE_FROM..WALL[0]).rfind(is_lit)];
            let half = (150.0_f64.powi(2) - (f64::from(y) + 0.5 - 200.0).powi(2)).sqrt();
            for (end, expected) in ends.iter().zip([700.0 - half, 700.0 + half]) {
                let end = f64::from(end.expect("the lamp shines on the wall")) + 0.5;
                assert!((end - expected).abs() < 3.0, "{turn}: row {y} ends at {end}, not {expected}");
            }
        }
    }
    let script = "overlay on\nframes 3\nscreenshot over.png\nclusters most\nframes 2\nscreenshot cells.png\n\
                  clusters 0\nframes 2\nscreenshot first.png\nclusters off\noverlay off\nset show lights\nframes 2\nscreenshot show.png";
    run(&format!("frames 2\n{script}"), "1000x400", &["--lights", "clusters"]);
    let [over, cells, first, show] = ["over.png", "cells.png", "first.png", "show.png"].map(picture);
    let Pixels::Rgba8(show) = &show.pixels else { panic!("bytes") };
    let inside = |over: &[[f64; 2]], x: u32, y: u32| over.contains(&[x, y].map(|c| f64::from(c) + 0.5));
    let (cells, first) = (drawn(&cells, &over), drawn(&first, &over));
    let mut count = 0;
    // A place in each tile of 32 pixels that neither its edges nor its number cover.
    for (y, x) in
        (0..WALL[1] / 32).flat_map(|row| (13..31).map(move |column| (32 * row + 6, 32 * column + 6)))
    {
        let is_listed = show[4 * (y * WALL[0] + x) as usize + 2] > 0;
        assert_eq!(inside(&cells, x, y), is_listed, "{x}, {y}");
        count += u32::from(is_listed);
    }
    assert!((60..120).contains(&count), "{count} tiles");
    // The nearest slice cuts the ball's near end off.
    let middle = inside(&first, 678, 198);
    assert!(middle && first.len() * 4 < cells.len() * 3, "{} of {} pixels", first.len(), cells.len());
}
