//! Fog and background against the reference, however the frame is arranged.

use ontile::glam::Vec3;
use ontile::picture::Pixels;
use ontile::plan::{Layout, OutputFormat, Path, Tonemap};
use ontile::reference::render;
use ontile::scene::{Background, Fog, FogHeight, Scene};

use crate::error::Errors;
use crate::gpu::{Ask, Gpu};
use crate::scenes;

fn fog(height: Option<FogHeight>) -> Fog {
    Fog { color_nt: Vec3::new(0.3, 0.35, 0.5), density_per_m: 0.08, height }
}

/// Folded, with a light target, and without any lighting.
fn arrangements() -> [Scene; 3] {
    let mut unlit = scenes::lights();
    unlit.name = "unlit".into();
    unlit.materials.iter_mut().for_each(|m| m.unlit = true);
    [scenes::lights(), scenes::surfaces(), unlit]
}

#[test]
fn fog_is_the_references() {
    let Some(gpu) = Gpu::open() else { return };
    let layer = FogHeight { base_m: 0.4, scale_m: 0.5 };
    let mut failed = Vec::new();
    for mut scene in arrangements() {
        for height in [None, Some(layer)] {
            scene.fog = Some(fog(height));
            let forward = (&scene.cameras[0], Path::Forward);
            let deferred = scene.cameras.iter().map(|camera| (camera, Path::Deferred));
            for (camera, path) in deferred.chain([forward]) {
                let rendered = gpu.render(&scene, camera, Ask { exposure_ev: 1.0, path, ..Ask::EXACT });
                let of = |scene: &Scene| {
                    Errors::of_display(&render(scene, camera, &rendered.settings), &rendered.light())
                };
                let errors = of(&scene);
                println!("{}, {}, {path}, {height:?}: {errors}", scene.name, camera.name);
                failed.extend(errors.check().err());
                if camera.name != scene.cameras[0].name || path != Path::Deferred {
                    continue;
                }
                // The comparison must see the smallest things that could be wrong.
                let right = scene.fog.unwrap();
                let off = FogHeight { base_m: 0.41, ..layer };
                let faults = [
                    None,
                    Some(Fog { density_per_m: right.density_per_m * 1.02, ..right }),
                    Some(Fog { color_nt: right.color_nt * 1.01, ..right }),
                    Some(Fog { height: if height.is_some() { Some(off) } else { Some(layer) }, ..right }),
                ];
                for fog in faults {
                    let errors = of(&Scene { fog, ..scene.clone() });
                    assert!(errors.check().is_err(), "{}, {fog:?}: not caught, {errors}", scene.name);
                }
            }
        }
    }
    gpu.finish();
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn a_background_colour_is_seen_as_it_was_typed() {
    let Some(gpu) = Gpu::open() else { return };
    for mut scene in arrangements() {
        scene.background = Background::from_hex("#1e90ff").expect("a colour");
        scene.fog = Some(fog(None));
        let camera = &scene.cameras[0];
        let cases = [
            (Layout::Metallic128, Path::Deferred, Tonemap::Aces),
            (Layout::Exact, Path::Deferred, Tonemap::Neutral),
            (Layout::Exact, Path::Forward, Tonemap::Reinhard),
        ];
        for (layout, path, tonemap) in cases {
            let output = OutputFormat::Rgba8Srgb;
            let ask = Ask { layout, path, tonemap, exposure_ev: -2.0, output };
            let rendered = gpu.render(&scene, camera, ask);
            let frame = render(&scene, camera, &rendered.settings);
            let Pixels::Rgba8(bytes) = &rendered.picture.pixels else {
                unreachable!("8 bits were asked for")
            };
            let (mut seen, mut lit) = (0, 0);
            for (pixel, bytes) in frame.pixels.iter().zip(bytes.chunks(4)).filter(|(p, _)| !p.edge) {
                let is_background = bytes == [0x1e, 0x90, 0xff, 0xff];
                assert_eq!(is_background, !pixel.covered, "{}, {layout}, {path}: {bytes:x?}", scene.name);
                seen += u32::from(!pixel.covered);
                lit += u32::from(pixel.covered);
            }
            assert!(seen > 100 && lit > 100, "{}: {seen} and {lit} pixels", scene.name);
        }
    }
    gpu.finish();
}
