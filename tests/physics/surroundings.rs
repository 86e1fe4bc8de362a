//! Fog, background and lightmaps against the reference, however the frame is arranged.

use ontile::environment::TexelFormat;
use ontile::glam::{DVec3, Vec2, Vec3};
use ontile::picture::Pixels;
use ontile::plan::{Layout, OutputFormat, Path, Tonemap};
use ontile::reference::{Pixel, render};
use ontile::scene::{Background, Fog, FogHeight, LightmapRect, Scene};

use crate::common::{environments, scenes as common};
use crate::error::{Errors, FLOOR, MAX_RELATIVE_ERROR, PROMISED_PART};
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
            let ask = Ask { layout, path, tonemap, exposure_ev: -2.0, output, ..Ask::EXACT };
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

const PATHS: [Path; 2] = [Path::Deferred, Path::Forward];

/// Surfaces that a lightmap lights: alone, and in its part of light from all around.
fn lightmapped() -> [Scene; 3] {
    let alone = common::lightmapped_alone();
    let ambient_nt = Vec3::new(0.2, 0.3, 0.1);
    let ambient = Scene { name: "and ambient".into(), ambient_nt, ..alone.clone() };
    let environment = Scene { environment: environments::environment().environment, ..alone.clone() };
    [alone, ambient, Scene { name: "and an environment".into(), ..environment }]
}

#[test]
fn lightmaps_are_the_references() {
    let Some(gpu) = Gpu::open() else { return };
    let faults: [fn(&mut Scene); 4] = [
        |s| s.lightmap.as_mut().unwrap().unit_lx *= 1.01,
        |s| s.instances[0].lightmap.as_mut().unwrap().origin.x += 1.0 / 64.0,
        |s| s.lightmap = None,
        // Its light is in the map.
        |s| s.lights[0].baked = false,
    ];
    for scene in lightmapped() {
        let camera = &scene.cameras[0];
        for (path, lightmap) in PATHS.into_iter().flat_map(|path| FLOATS.map(|format| (path, format))) {
            let rendered = gpu.render(&scene, camera, Ask { path, lightmap, ..Ask::EXACT });
            let of = |scene: &Scene| {
                Errors::of_display(&render(scene, camera, &rendered.settings), &rendered.light())
            };
            let errors = of(&scene);
            println!("{}, {path}, {lightmap}: {errors}", scene.name);
            errors.check().unwrap_or_else(|e| panic!("{}, {path}, {lightmap}: {e}", scene.name));
            for (i, fault) in faults.iter().enumerate() {
                let mut faulty = scene.clone();
                fault(&mut faulty);
                let errors = of(&faulty);
                assert!(errors.check().is_err(), "{}: fault {i} is not caught, {errors}", scene.name);
            }
        }
    }
    gpu.finish();
}

/// What a driver filters in floats. lavapipe filters textures of 8 bits in 8 bits.
const FLOATS: [TexelFormat; 3] = [TexelFormat::E5B9G9R9, TexelFormat::Rgba16F, TexelFormat::B10G11R11];

#[test]
fn a_lightmap_in_rgbm_is_the_references_but_for_the_filters_bits() {
    /// Of a filter in 8 bits: half a step of 255 of the factor, and of colours near 1; factors here are at least 0.3, and the
    /// product is squared. Rounding of the weights to 8 bits is as much again.
    const FILTER: f64 = 2.0 * (0.5 / 255.0 + 0.5 / (255.0 * 0.3)) * 2.0;
    let Some(gpu) = Gpu::open() else { return };
    let scene = common::lightmapped_alone();
    // Each surface in one texel, at whose centre no filter is at work.
    let mut even = scene.clone();
    for (i, instance) in even.instances.iter_mut().enumerate() {
        let origin = Vec2::new(10.5 + 13.0 * i as f32, 20.5) / 64.0;
        instance.lightmap = Some(LightmapRect { origin, size: Vec2::ZERO });
    }
    let ask = Ask { lightmap: TexelFormat::Rgbm, ..Ask::EXACT };
    let camera = &scene.cameras[0];
    let rendered = gpu.render(&even, camera, ask);
    let errors = Errors::of_display(&render(&even, camera, &rendered.settings), &rendered.light());
    println!("rgbm, at texels' centres: {errors}");
    errors.check().unwrap();

    let rendered = gpu.render(&scene, camera, ask);
    let light = rendered.light();
    let worst = |scene: &Scene| {
        let reference = render(scene, camera, &rendered.settings);
        let pixels = reference.pixels.iter().zip(&light).filter(|(p, _)| p.covered && !p.edge);
        let error = |(pixel, found): (&Pixel, &DVec3)| {
            (*found - pixel.display).abs().max_element() / pixel.display.max_element()
        };
        let mut errors: Vec<_> = pixels.map(error).collect();
        errors.sort_by(f64::total_cmp);
        errors[(errors.len() as f64 * PROMISED_PART) as usize]
    };
    let error = worst(&scene);
    println!("rgbm: 99.9 % within {error:.1e} of the brightest channel");
    assert!(error <= FILTER, "{error}");
    let mut moved = scene.clone();
    for instance in &mut moved.instances {
        instance.lightmap.as_mut().unwrap().origin.x += 1.0 / 64.0;
    }
    assert!(worst(&moved) > FILTER, "a texel to the side is not seen");
    gpu.finish();
}

#[test]
fn the_sky_is_the_environment_and_lies_behind_all_surfaces() {
    let Some(gpu) = Gpu::open() else { return };
    for scene in [common::before_sky(), common::sky_unlit(), common::sky_alone(), environments::probes()] {
        let camera = &scene.cameras[0];
        for path in PATHS {
            let ask = Ask { path, exposure_ev: -1.0, ..Ask::EXACT };
            let rendered = gpu.render(&scene, camera, ask);
            let light = rendered.light();
            let worst = |scene: &Scene| {
                let reference = render(scene, camera, &rendered.settings);
                let sky = reference.pixels.iter().zip(&light).filter(|(p, _)| !p.covered && !p.edge);
                let error = |(pixel, found): (&Pixel, &DVec3)| {
                    ((*found - pixel.display).abs() / pixel.display.max(DVec3::splat(FLOOR))).max_element()
                };
                let mut errors: Vec<_> = sky.map(error).collect();
                errors.sort_by(f64::total_cmp);
                assert!(errors.len() > 5000, "{}: {} pixels of sky", scene.name, errors.len());
                errors[(errors.len() as f64 * PROMISED_PART) as usize]
            };
            let quantile = worst(&scene);
            println!("{}, {path}: 99.9 % within {quantile:.1e}", scene.name);
            assert!(quantile <= MAX_RELATIVE_ERROR, "{}, {path}: {quantile}", scene.name);
            let mut turned = scene.clone();
            turned.environment.as_mut().unwrap().rotation_deg += 1.0;
            assert!(worst(&turned) > MAX_RELATIVE_ERROR, "{}: a turned sky is not seen", scene.name);

            let before_black = Scene { background: Background::Black, ..scene.clone() };
            let reference = render(&before_black, camera, &rendered.settings);
            if !reference.pixels.iter().any(|p| p.covered) {
                continue;
            }
            let surfaces = gpu.render(&before_black, camera, ask).light();
            let same = |(index, pixel): (usize, &Pixel)| {
                !pixel.covered || pixel.edge || surfaces[index].abs_diff_eq(light[index], 1e-6)
            };
            assert!(reference.pixels.iter().enumerate().all(same), "{}, {path}: sky on surfaces", scene.name);
        }
    }
    gpu.finish();
}
