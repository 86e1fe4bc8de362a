//! Light that goes through surfaces, against the reference, which knows the exact way through them.

use ontile::glam::Vec3;
use ontile::plan::{Layout, Refraction, Translucency};
use ontile::reference::render;
use ontile::scene::{Background, Camera, Projection, Scene, Transmission};

use crate::common::scenes::media_scenes::{water, water_alone, water_and_more};
use crate::error::Errors;
use crate::gpu::{Ask, Gpu};
use crate::over_light::{catches, differing, misty};

/// Without particles' texture, whose filter differs by driver.
fn with_others() -> Scene {
    let mut scene = water_and_more();
    scene.materials.iter_mut().filter(|m| m.name == "glow spark").for_each(|m| m.emissive_texture = None);
    scene
}

#[test]
fn light_that_is_let_through_is_the_references() {
    let Some(gpu) = Gpu::open() else { return };
    let failed = differing(&gpu, Ask::EXACT, [water(), misty(water()), with_others(), water_alone()]);
    gpu.finish();
    assert!(failed.is_empty(), "{failed:#?}");
}

/// What is below all that is blended is the same with each way of that, and with each layout.
#[test]
fn water_is_alike_with_every_layout_and_way_of_translucency() {
    /// What light targets and surfaces in few bits may be off by, of the light.
    const MAX_ERROR: f64 = 0.05;
    let Some(gpu) = Gpu::open() else { return };
    let mut scene = water();
    scene.lights.clear();
    scene.ambient_nt = Vec3::new(0.5, 0.6, 0.7);
    let mut failed = Vec::new();
    for &layout in Layout::ALL.iter().filter(|l| **l != Layout::Ontile64) {
        let rendered = gpu.render(&scene, &scene.cameras[0], Ask { layout, ..Ask::EXACT });
        let expected = render(&scene, &scene.cameras[0], &rendered.settings);
        let errors = Errors::of_display(&expected, &rendered.light());
        failed.extend(errors.check_within(MAX_ERROR).err().map(|e| format!("{layout}: {e}")));
    }
    for translucency in [Translucency::Sorted, Translucency::Weighted, Translucency::Peeled] {
        let rendered = gpu.render(&scene, &scene.cameras[0], Ask { translucency, ..Ask::EXACT });
        let expected = render(&scene, &scene.cameras[0], &rendered.settings);
        let errors = Errors::of_display(&expected, &rendered.light());
        failed.extend(errors.check().err().map(|e| format!("{translucency}: {e}")));
    }
    gpu.finish();
    assert!(failed.is_empty(), "{failed:#?}");
}

/// A way in which the renderer might be wrong, done to what the reference is given instead.
type Fault = (&'static str, fn(&mut Transmission));

const FAULTS: &[Fault] = &[
    ("absorbs nothing", |t| t.attenuation_distance_m = f32::INFINITY),
    ("absorbs 2 % more", |t| t.attenuation_distance_m *= 0.98),
    ("the longest way left out", |t| t.thickness_m = 1e6),
    ("reflects as glass", |t| t.ior = 1.5),
    ("lets through 1 % more", |t| t.factor *= 1.01),
];

fn spoilt_media(faults: &'static [Fault]) -> impl Iterator<Item = (&'static str, Scene)> {
    faults.iter().map(|(name, fault)| {
        let mut faulty = water();
        faulty.materials.iter_mut().filter_map(|m| m.transmission.as_mut()).for_each(fault);
        (*name, faulty)
    })
}

#[test]
fn every_fault_of_media_is_caught() {
    let spoilt = spoilt_media(FAULTS);
    catches(&water(), Ask::EXACT, spoilt);
}

const BENT: Ask = Ask { refraction: Refraction::Pass, ..Ask::EXACT };

/// Where neighbours are sampled, on every path, in fog, before a background's colour, below panes and particles.
#[test]
fn light_that_is_bent_is_the_references() {
    let Some(gpu) = Gpu::open() else { return };
    let background = Background::Color(Vec3::new(0.5, 0.4, 0.3));
    let on_paper = Scene { background, ..water() };
    let parallel = Scene { cameras: vec![orthographic()], name: "parallel".into(), ..water() };
    let failed = differing(&gpu, BENT, [water(), misty(on_paper), with_others(), parallel]);
    gpu.finish();
    assert!(failed.is_empty(), "{failed:#?}");
}

/// The same place and direction.
fn orthographic() -> Camera {
    let projection = Projection::Orthographic { xmag_m: 1.6, ymag_m: 0.9, znear_m: 0.1, zfar_m: 10.0 };
    Camera { name: "parallel".into(), projection, ..water().cameras[0].clone() }
}

const BENT_FAULTS: &[Fault] = &[
    ("bends 1 % less", |t| t.ior *= 0.99),
    ("does not bend", |t| t.ior = 1.0),
    ("bends for no longer than a tenth of the thickness", |t| t.thickness_m *= 0.1),
    ("absorbs 2 % more", |t| t.attenuation_distance_m *= 0.98),
];

#[test]
fn every_fault_of_refraction_is_caught() {
    catches(&water(), BENT, spoilt_media(BENT_FAULTS));
}
