//! A second rasteriser draws the shipped scenes as lavapipe does: what a driver may choose is small, and nothing rests on
//! one driver's kindness.

mod common;

use common::render::LAVAPIPE;
use common::{ignored_unless_required, scenes, swiftshader::swiftshader_env};
use ontile::picture::{Picture, Pixels};
use std::path::Path;
use std::process::Command;

const SIZE: &str = "320x180";

/// How far apart pixels may be that are no outliers, in 8-bit steps: rounding of a metal's highlight through normals
/// of 8 bits, and of trilinear weights, which Vulkan leaves to the driver (SwiftShader has fewer bits of them).
const MOST_STEPS: u8 = 8;

/// The share of pixels that may be further apart: edges of triangles, where coverage is decided with other sub-pixel
/// precision, and edges of alpha masks.
const OUTLIER_SHARE: f64 = 0.02;

/// Mean difference of all channels, in 8-bit steps: no part of the picture may be another.
const MOST_MEAN_STEPS: f64 = 0.5;

fn command(scene: &Path, picture: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ontile"));
    command.arg("render").arg(scene).arg("-o").arg(picture).args(["--size", SIZE]);
    command
}

fn run(mut command: Command) -> Result<(), String> {
    let output = command.output().map_err(|e| format!("{command:?}: {e}"))?;
    let said = || String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.success() { Ok(()) } else { Err(format!("{command:?}: {}", said())) }
}

/// Share of outliers and mean difference.
fn distance(a: &Picture, b: &Picture) -> (f64, f64) {
    assert_eq!([a.width, a.height], [b.width, b.height]);
    let [Pixels::Rgba8(a), Pixels::Rgba8(b)] = [&a.pixels, &b.pixels] else { panic!("PNGs have 8 bits") };
    let steps: Vec<_> = a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).collect();
    let outliers = steps.chunks(4).filter(|pixel| pixel.iter().any(|&s| s > MOST_STEPS)).count();
    let mean = steps.iter().map(|&s| f64::from(s)).sum::<f64>() / steps.len() as f64;
    (outliers as f64 / (steps.len() / 4) as f64, mean)
}

fn agree((outliers, mean): (f64, f64)) -> bool {
    outliers <= OUTLIER_SHARE && mean <= MOST_MEAN_STEPS
}

#[test]
fn swiftshader_draws_what_lavapipe_draws() {
    let Some(swiftshader) = swiftshader_env() else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut previous: Option<Picture> = None;
    for scene in scenes::shipped_files() {
        let [on_lavapipe, on_swiftshader] = ["lavapipe", "swiftshader"].map(|n| folder.path().join(format!("{n}.png")));
        let mut lavapipe = command(&scene, &on_lavapipe);
        lavapipe.args(["--device", LAVAPIPE]);
        if let Err(error) = run(lavapipe) {
            assert!(!error.contains("glTF"), "{error}");
            ignored_unless_required(&error);
            return;
        }
        let mut other = command(&scene, &on_swiftshader);
        other.args(["--device", "SwiftShader"]).envs(swiftshader.clone());
        run(other).unwrap();
        let [a, b] = [on_lavapipe, on_swiftshader].map(|path| Picture::read(&path).unwrap());
        let apart = distance(&a, &b);
        println!("{}: {:.3} % outliers, mean {:.4} steps", scene.display(), 100.0 * apart.0, apart.1);
        assert!(agree(apart), "{}: {apart:?}", scene.display());
        // Able to fail: another scene, and the same one a pixel aside, do not agree.
        let mut aside = b.clone();
        let Pixels::Rgba8(channels) = &mut aside.pixels else { unreachable!() };
        channels.rotate_right(4);
        assert!(!agree(distance(&a, &aside)), "{}: a pixel aside is not seen", scene.display());
        assert!(previous.is_none_or(|p| !agree(distance(&p, &b))), "{}: as the scene before", scene.display());
        previous = Some(a);
    }
    assert!(previous.is_some(), "assets/ ships no scene");
}
