//! What the options ask to show in place of the picture is what the G-buffer holds: shown as floats, against what the reference decodes
//! of the same frame's kept G-buffer.

use ontile::glam::{DVec3, dvec3};
use ontile::plan::{GBuffer, LightPlace, LightWay, Show, heat};
use ontile::reference::{Attributes, View, decode};
use ontile::scene::{Camera, LightKind, Scene};

use crate::SIZE;
use crate::gpu::{Ask, Gpu};
use crate::layouts::{choices, layouts};
use crate::scenes;

/// Relative to values of 1 and more: f32 arithmetic, of which square roots and divisions of normals' encodings take most.
const ARITHMETIC: f64 = 2e-5;

/// Of depth and position, which are reconstructed from plane equations: as `crate::gbuffer` has it for positions.
const RECONSTRUCTED: f64 = 2e-5;

/// Vulkan leaves a device an approximation when it decodes sRGB: lavapipe's is off by up to 0.2 % of white.
const SRGB_DECODER: f64 = 2e-3;

fn expected(show: Show, a: &Attributes, camera: &Camera, exposure: f64) -> DVec3 {
    let to_camera = camera.world_from_view.as_dmat4();
    let forward = -to_camera.z_axis.truncate();
    let distance = (a.position_world - to_camera.w_axis.truncate()).dot(forward);
    match show {
        Show::BaseColor => a.base_color,
        Show::Metallic => DVec3::splat(a.metallic),
        Show::Diffuse => a.diffuse(),
        Show::Reflectance => a.f0(),
        Show::Normal => a.normal_world,
        Show::Roughness => DVec3::splat(a.roughness),
        Show::Depth => DVec3::splat(distance),
        Show::Light => a.prelit * exposure,
        _ => unreachable!("{show} is no quantity of surfaces"),
    }
}

/// The channels of a layout that were compared; panics where one is not what was stored.
fn compared(gpu: &Gpu, name: &str, ask: Ask, scene: &Scene) -> Vec<Show> {
    let camera = &scene.cameras[0];
    let gbuffer = GBuffer::new(&ask.options()).unwrap();
    let Some((rendered, stored)) = gpu.try_with_gbuffer(scene, camera, ask) else { return Vec::new() };
    let (view, exposure) = (View::new(camera, SIZE), rendered.settings.exposure());
    let factor = exposure * rendered.settings.light_scale;
    let channels = Show::CHANNELS.iter().filter(|&&show| show != Show::Occlusion);
    let shown = |show: &&Show| {
        let Some(found) = gpu.shown(scene, camera, ask, **show) else { return false };
        let mut lit = 0;
        for (index, (stored, found)) in stored.iter().zip(&found).enumerate() {
            let place = [index as u32 % SIZE[0], index as u32 / SIZE[0]];
            let kept = decode(&gbuffer, stored, &view, place, factor);
            lit += u32::from(kept.lit);
            // Depth is shown of unlit surfaces too, where it is stored; light of all.
            let expected = match **show {
                Show::Depth if !kept.lit => continue,
                Show::Light => expected(**show, &kept, camera, exposure),
                _ if !kept.lit => DVec3::ZERO,
                _ => expected(**show, &kept, camera, exposure),
            };
            let most = match **show {
                Show::Depth => ARITHMETIC + RECONSTRUCTED,
                Show::BaseColor | Show::Diffuse | Show::Reflectance => ARITHMETIC + SRGB_DECODER,
                _ => ARITHMETIC,
            };
            let error = ((*found - expected).abs() / expected.abs().max(DVec3::ONE)).max_element();
            assert!(error <= most, "{name}, {}: {show} at {place:?} is {found}, not {expected}", scene.name);
        }
        assert!(lit > 1000, "{name}, {}: {lit} pixels are lit", scene.name);
        true
    };
    channels.filter(shown).copied().collect()
}

#[test]
fn what_is_shown_is_what_is_stored() {
    let Some(gpu) = Gpu::open() else { return };
    for (name, ask) in layouts().into_iter().chain(choices()) {
        let gbuffer = GBuffer::new(&ask.options()).unwrap();
        for scene in [scenes::surfaces(), scenes::materials()] {
            let seen = compared(&gpu, &name, ask, &scene);
            let products = gbuffer.has_products();
            let is_least = |show: Show| match show {
                Show::BaseColor => !products,
                Show::Diffuse | Show::Normal | Show::Depth => true,
                _ => false,
            };
            let refused = gbuffer.light == LightPlace::Nowhere && seen.is_empty();
            let least: Vec<_> = Show::CHANNELS.iter().copied().filter(|show| is_least(*show)).collect();
            assert!(refused || least.iter().all(|show| seen.contains(show)), "{name}: {seen:?}");
        }
    }
    gpu.finish();
}

/// Within this share of a light's end, of its cone's cosine or of a surface's edge either answer is right.
const AT_THE_END: f64 = 1e-4;

/// Lights that reach a surface and that it does not face away from, at least and at most, and those whose cones hold it too.
fn lights_at(scene: &Scene, surface: &Attributes) -> [u32; 3] {
    let mut count = [0; 3];
    for light in scene.lights.iter().filter(|light| !light.is_dark()) {
        let (sure, perhaps) = match light.kind {
            LightKind::Directional { .. } => (true, true),
            LightKind::Point { .. } | LightKind::Spot { .. } => {
                let to_light = light.position_world.as_dvec3() - surface.position_world;
                let range = light.range_m.map_or(f64::INFINITY, f64::from);
                let (share, cos) =
                    (to_light.length() / range, surface.normal_world.dot(to_light.normalize()));
                let reaches = |room: f64| share < 1.0 + room && cos > -room;
                let off_axis = -to_light.normalize().dot(light.direction_world.as_dvec3());
                let is_outside = matches!(light.kind, LightKind::Spot { outer_cone_rad, .. }
                    if off_axis < f64::from(outer_cone_rad).cos() + AT_THE_END);
                count[2] += u32::from(reaches(-AT_THE_END) && !is_outside);
                (reaches(-AT_THE_END), reaches(AT_THE_END))
            }
            _ => (false, true),
        };
        count[2] += u32::from(matches!(light.kind, LightKind::Directional { .. }));
        count[0] += u32::from(sure);
        count[1] += u32::from(perhaps);
    }
    count
}

/// Without lists those that reach a surface are counted, with lists those of its cell, which leave out what none of it is lit by.
#[test]
fn lights_are_counted() {
    let Some(gpu) = Gpu::open() else { return };
    let scene = scenes::lights();
    let camera = &scene.cameras[0];
    let ask = Ask::EXACT;
    let gbuffer = GBuffer::exact();
    let (rendered, stored) = gpu.render_with_gbuffer(&scene, camera, ask);
    let (view, factor) = (View::new(camera, SIZE), rendered.settings.light_scale);
    let counted = |lights| {
        gpu.shown(&scene, camera, Ask { lights, ..ask }, Show::Lights).expect("lights can be counted")
    };
    let (reach, listed) = (counted(LightWay::Fullscreen), counted(LightWay::Clusters));
    let all = scene.lights.iter().filter(|light| !light.is_dark()).count() as f64;
    let mut numbers = std::collections::BTreeSet::new();
    for (index, stored) in stored.iter().enumerate() {
        let place = [index as u32 % SIZE[0], index as u32 / SIZE[0]];
        let surface = decode(&gbuffer, stored, &view, place, factor);
        let [least, most, lit] = if surface.lit { lights_at(&scene, &surface) } else { [0; 3] };
        let found = reach[index].x;
        assert!(
            (f64::from(least)..=f64::from(most)).contains(&found),
            "{place:?}: {found}, {least} to {most}"
        );
        let (listed, most) = (listed[index].x, if surface.lit { all } else { 0.0 });
        assert!((f64::from(lit)..=most).contains(&listed), "{place:?}: {listed} listed, {lit} to {most}");
        numbers.insert(found as u32);
    }
    assert!(numbers.len() > 3, "{numbers:?}");
    assert!(
        listed.iter().zip(&reach).any(|(listed, reach)| listed.x > reach.x),
        "a list has more than reach"
    );
    assert!(listed.iter().any(|listed| listed.x > 0.0 && listed.x < all), "a list has not all");
    gpu.finish();
}

/// The colours of the legend: what a picture of bytes has for a number that one of floats tells.
#[test]
fn heat_is_the_legends() {
    assert_eq!(heat(0), [0.0; 3]);
    assert_eq!(heat(63), [1.0; 3]);
    assert_eq!(heat(1_000_000), [1.0; 3]);
    let Some(gpu) = Gpu::open() else { return };
    let scene = scenes::lights();
    let camera = &scene.cameras[0];
    let numbers = gpu.shown(&scene, camera, Ask::EXACT, Show::Lights).unwrap();
    let bytes = gpu.shown_codes(&scene, camera, Ask::EXACT, Show::Lights);
    for (number, bytes) in numbers.iter().zip(&bytes) {
        let expected = heat(number.x as u32).map(|x| x * 255.0);
        let found = dvec3(bytes[0].into(), bytes[1].into(), bytes[2].into());
        // Half a step of rounding, and the encoder's approximation.
        assert!(
            (found - DVec3::from(expected)).abs().max_element() < 1.0,
            "{number}: {bytes:?}, {expected:?}"
        );
    }
    gpu.finish();
}
