//! Light that particles add, against the reference, which goes by exact distances.

use ontile::plan::{DepthStore, Layout};
use ontile::reference::render;
use ontile::scene::Scene;

use crate::common::scenes::particle_scenes::{sparks, sparks_alone, sparks_and_glass};
use crate::error::Errors;
use crate::gpu::{Ask, Gpu};
use crate::over_light::{Fault, catches, differing, misty, spoilt};

/// What a texture filter of 8 fractional bits may be off by where a glow is dim, of the light.
const MAX_FILTER_ERROR: f64 = 0.04;

/// Without the texture, whose filter differs by driver.
fn plain(mut scene: Scene) -> Scene {
    scene.materials.iter_mut().filter(|m| m.name == "glow spark").for_each(|m| m.emissive_texture = None);
    scene
}

#[test]
fn added_light_is_the_references() {
    let Some(gpu) = Gpu::open() else { return };
    let failed = differing(
        &gpu,
        Ask::EXACT,
        [sparks(), misty(sparks()), sparks_and_glass(), sparks_alone()].map(plain),
    );
    let scene = sparks();
    let rendered = gpu.render(&scene, &scene.cameras[0], Ask::EXACT);
    let errors =
        Errors::of_display(&render(&scene, &scene.cameras[0], &rendered.settings), &rendered.light());
    assert_eq!(errors.check_within(MAX_FILTER_ERROR), Ok(()), "textured");
    gpu.finish();
    assert!(failed.is_empty(), "{failed:#?}");
}

/// Wherever a layout has its depth, particles fade by that of the depth attachment.
#[test]
fn they_fade_alike_with_every_layout() {
    /// What light targets and surfaces in few bits may be off by, of the light.
    const MAX_ERROR: f64 = 0.05;
    let Some(gpu) = Gpu::open() else { return };
    let mut scene = sparks();
    // Light of particles alone, so that no surface is in the way.
    scene.lights.clear();
    for &layout in Layout::ALL {
        let rendered = gpu.render(&scene, &scene.cameras[0], Ask { layout, ..Ask::EXACT });
        let expected = render(&scene, &scene.cameras[0], &rendered.settings);
        let errors = Errors::of_display(&expected, &rendered.light());
        assert_eq!(errors.check_within(MAX_ERROR), Ok(()), "{layout}");
    }
    let ask = Ask { depth: Some(DepthStore::D32), layout: Layout::Ontile128, ..Ask::EXACT };
    let rendered = gpu.render(&scene, &scene.cameras[0], ask);
    let expected = render(&scene, &scene.cameras[0], &rendered.settings);
    assert_eq!(Errors::of_display(&expected, &rendered.light()).check_within(MAX_ERROR), Ok(()));
    gpu.finish();
}

const FAULTS: &[Fault] = &[
    ("nothing added", |scene| scene.particles.clear()),
    ("cut hard", |scene| scene.particles.iter_mut().for_each(|p| p.soft_m = 0.0)),
    ("a soft distance off by 3 %", |scene| scene.particles.iter_mut().for_each(|p| p.soft_m *= 1.03)),
    ("turned the other way", |scene| {
        scene.particles.iter_mut().flat_map(|p| &mut p.list).for_each(|p| p.rotation_rad = -p.rotation_rad);
    }),
    ("light off by 1 %", |scene| {
        scene.particles.iter_mut().flat_map(|p| &mut p.list).for_each(|p| p.color *= 1.01);
    }),
    ("in front of what hides them", |scene| scene.particles[0].list[2].position_world.z += 0.7),
];

#[test]
fn every_fault_of_particles_is_caught() {
    let scene = plain(sparks());
    catches(&scene, Ask::EXACT, spoilt(&scene, FAULTS));
}
