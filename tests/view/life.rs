//! What a window goes through.

use super::*;

/// Sizes, none at all, surfaces taken away, scenes and options that change, some of which cannot be: all as before in the end.
#[test]
fn what_a_window_goes_through_leaves_nothing_behind() {
    let Some(screen) = Screen::new() else { return };
    let folder = tempfile::tempdir().unwrap();
    let [lamps, unlit] = ["lamps.glb", "unlit.glb"].map(asset);
    // So many that all images of the window were shown again, and what it had before is gone.
    let begin = "frames 12\n";
    let mut script = format!("{begin}screenshot before.png\nlive before.json\n");
    for i in 0_u32..60 {
        let [width, height] = [1 + 37 * i % 400, 1 + 53 * i % 300];
        script += &format!("size {width}x{height}\nframes {}\n", i % 3);
        if i % 10 == 0 {
            script += "size 0x0\nframes 2\nsuspend\nframes 1\nlow-memory\nlive low.json\nresume\n";
        }
    }
    script += "size 160x90\nframes 12\nlive calm.json\nsize 200x120\nlive resized.json\nsize 160x90\nopen none.glb\nset samples 3\nset lamps 1\n";
    for i in 0..SCENE_CHANGES {
        script += &format!("open {}\nframes {}\n", if i % 2 == 0 { &unlit } else { &lamps }, i % 3);
    }
    for (name, value, again) in [("layout", "packed128", "metallic128"), ("samples", "4", "1")] {
        script += &format!("set {name} {value}\nframes 1\nset {name} {again}\n");
    }
    script += &format!("{begin}screenshot after.png\nlive after.json\ndrag 30 10\nscreenshot turned.png\n");
    let told = view(folder.path(), &screen.display, &script, &[&lamps, "--size", "160x90"]);
    let lines: Vec<_> = told.lines().collect();
    assert_eq!(lines.len(), 3, "{told}");
    for (line, part) in lines.iter().zip(["none.glb: cannot read", "3 samples", "no option 'lamps'"]) {
        assert!(line.contains(part), "{line}");
    }
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert!(read("before.json").contains("\"swapchain_khr\":1"), "{}", read("before.json"));
    assert_eq!(read("after.json"), read("before.json"));
    // A new size waits for nothing: what frames on their way use is there until they were shown.
    assert!(read("calm.json").contains("\"swapchain_khr\":1"), "{}", read("calm.json"));
    assert!(read("resized.json").contains("\"swapchain_khr\":2"), "{}", read("resized.json"));
    // Where memory is short and nobody looks, what frames are submitted with is all that stays.
    let low = read("low.json");
    assert!(low.contains("\"allocations\":0,\"bytes\":0") && !low.contains("pipeline\":"), "{low}");
    let picture = |name: &str| Picture::read(&folder.path().join(name)).unwrap();
    assert_eq!(difference(&picture("after.png"), &picture("before.png")), None);
    assert!(difference(&picture("turned.png"), &picture("before.png")).is_some(), "a drag turns the camera");
}

/// What lies in the folder of the open scene can be opened from the list of it.
#[test]
fn scenes_are_picked_from_a_list() {
    let Some(screen) = Screen::new() else { return };
    let folder = tempfile::tempdir().unwrap();
    let picture = |name: &str| Picture::read(&folder.path().join(name)).unwrap();
    for name in ["unlit.glb", "lamps.glb"] {
        std::fs::copy(asset(name), folder.path().join(name)).unwrap();
    }
    std::fs::write(folder.path().join("broken.glb"), "no scene").unwrap();
    let script = "scenes list.txt\npick 2\nframes 2\nscreenshot unlit.png\npick 0\npick 1\nframes 2\nscreenshot lamps.png";
    let told = view(folder.path(), &screen.display, script, &["lamps.glb", "--size", "160x90"]);
    assert!(told.contains("broken.glb") && told.lines().count() == 1, "{told}");
    let list = std::fs::read_to_string(folder.path().join("list.txt")).unwrap();
    assert_eq!(list, "broken.glb\nlamps.glb\nunlit.glb\n");
    for name in ["unlit", "lamps"] {
        let scene = format!("{name}.glb");
        ontile(folder.path(), "", &["render", &scene, "--size", "160x90", "-o", "render.png"]);
        let difference = difference(&picture(&format!("{name}.png")), &picture("render.png"));
        assert_eq!(difference, None, "{name}");
    }
}

/// Each makes a plan, pipelines and buffers.
const SCENE_CHANGES: usize = 200;
