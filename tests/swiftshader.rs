//! A second rasteriser draws the scenes as lavapipe does: what a driver may choose is small, and nothing rests on one
//! driver's kindness.

mod common;

use common::render::{LAVAPIPE, on_device};
use common::{scenes, swiftshader::swiftshader_env};
use ontile::picture::{Picture, Pixels};
use ontile::plan::Options;
use ontile::scene::Scene;
use std::path::{Path, PathBuf};
use std::process::Command;

const SIZE: [u32; 2] = [320, 180];

/// How far apart pixels may be that are no outliers, in 8-bit steps. A step of the light target, 2 / 1023, is 6.4 of
/// them in the dark (255 * 12.92 * 2 / 1023), and drivers may round to either neighbour; the output's own step comes on
/// top.
const MOST_STEPS: u8 = 8;

/// The share of pixels that may be further apart: edges of triangles and of alpha masks, where coverage is decided with
/// other sub-pixel precision, and changes of mip level, whose choice Vulkan leaves to the driver. Measured: 0.02 %.
const OUTLIER_SHARE: f64 = 0.002;

/// Mean difference of red, green and blue, in 8-bit steps; half a step of the light target is 3.2 in the dark and 0.3 at
/// white. Measured: at most 1.2.
const MOST_MEAN_STEPS: f64 = 2.0;

/// Tells the child process where to put its pictures, and by its device's name which driver it must find.
const FOLDER: &str = "ONTILE_TEST_FOLDER";
const DEVICE: &str = "ONTILE_TEST_DEVICE";

fn all_scenes() -> Vec<Scene> {
    scenes::built().into_iter().chain(scenes::shipped()).collect()
}

fn picture_of(scene: &Scene, folder: &Path) -> PathBuf {
    folder.join(format!("{}.png", scene.name))
}

#[test]
#[ignore = "the other test runs it, in a process of its own for each driver"]
fn draw_all_scenes() {
    let (Some(folder), Ok(device)) = (std::env::var_os(FOLDER), std::env::var(DEVICE)) else {
        panic!("{FOLDER} and {DEVICE} are not set");
    };
    on_device(Some(&device), |gpu| {
        for scene in all_scenes() {
            let plan = gpu.plan(&scene, Options { size: SIZE, ..Options::default() });
            gpu.picture(&scene, plan, 0.0).write(&picture_of(&scene, Path::new(&folder))).unwrap();
        }
    });
}

/// Share of outliers and mean difference.
fn distance(a: &Picture, b: &Picture) -> (f64, f64) {
    assert_eq!([a.width, a.height], [b.width, b.height]);
    let [Pixels::Rgba8(a), Pixels::Rgba8(b)] = [&a.pixels, &b.pixels] else { panic!("PNGs have 8 bits") };
    let steps = |(a, b): (&[u8], &[u8])| [0, 1, 2].map(|c| a[c].abs_diff(b[c]));
    let steps: Vec<_> = a.chunks(4).zip(b.chunks(4)).map(steps).collect();
    let outliers = steps.iter().filter(|pixel| pixel.iter().any(|&s| s > MOST_STEPS)).count() as f64;
    let sum: f64 = steps.iter().flatten().map(|&s| f64::from(s)).sum();
    (outliers / steps.len() as f64, sum / (3 * steps.len()) as f64)
}

fn agree((outliers, mean): (f64, f64)) -> bool {
    outliers <= OUTLIER_SHARE && mean <= MOST_MEAN_STEPS
}

#[test]
fn swiftshader_draws_what_lavapipe_draws() {
    let Some(swiftshader) = swiftshader_env() else { return };
    let folders = [(); 2].map(|()| tempfile::tempdir().unwrap());
    let mut children = [LAVAPIPE, "SwiftShader"].map(|device| {
        let mut child = Command::new(std::env::current_exe().expect("this program's path"));
        child.args(["--exact", "draw_all_scenes", "--ignored", "--nocapture"]).env(DEVICE, device);
        child
    });
    children[1].envs(swiftshader);
    for (child, folder) in children.iter_mut().zip(&folders) {
        let output = child.env(FOLDER, folder.path()).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{child:?}:\n{said}");
        if said.contains("ignored: ") {
            common::ignored(&said);
            return;
        }
    }
    let mut failures = Vec::new();
    for scene in all_scenes() {
        let [a, b] = [0, 1].map(|i| Picture::read(&picture_of(&scene, folders[i].path())).unwrap());
        let apart = distance(&a, &b);
        println!("{}: {:.3} % outliers, mean {:.3} steps", scene.name, 100.0 * apart.0, apart.1);
        if !agree(apart) {
            failures.push(format!(
                "{}: {:.3} % outliers, mean {:.3} steps",
                scene.name,
                100.0 * apart.0,
                apart.1
            ));
        }
        // Able to fail: the picture a pixel aside.
        let Pixels::Rgba8(mut channels) = b.pixels else { unreachable!() };
        channels.rotate_right(4);
        let aside = Picture { pixels: Pixels::Rgba8(channels), ..b };
        assert!(!agree(distance(&a, &aside)), "{}: a pixel aside is not seen", scene.name);
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
