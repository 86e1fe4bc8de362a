//! Which textures are on the device, and in what order pipelines have them.

use std::collections::BTreeSet;

use super::objects::Batch;
use super::scene_data::surface;
use super::{ColorEncoding, TextureKey};
use crate::plan::{Pipeline, Plan, SLOTS, SurfaceKind};
use crate::scene::Scene;

/// The textures of a material in the order of its descriptors.
pub(super) fn material_textures<'a>(
    scene: &'a Scene,
    kind: &'a SurfaceKind,
    material: usize,
) -> impl Iterator<Item = TextureKey> + 'a {
    let textures = SurfaceKind::textures_of(&scene.materials[material]);
    (0..SLOTS.len()).filter(|&slot| kind.samples(slot)).map(move |slot| TextureKey {
        texture: textures[slot].expect("only present textures are sampled").texture,
        encoding: if SurfaceKind::is_srgb(slot) { ColorEncoding::Srgb } else { ColorEncoding::Linear },
    })
}

/// Every texture that some pipeline samples, once.
pub(super) fn texture_keys(
    scene: &Scene,
    plan: &Plan,
    batches: &[Batch],
    others: &[(usize, usize)],
) -> Vec<TextureKey> {
    let of_objects = batches.iter().map(|b| (b.pipeline, b.material));
    let used: BTreeSet<(usize, usize)> = of_objects.chain(others.iter().copied()).collect();
    let mut seen = Vec::new();
    for (pipeline, material) in used {
        for key in material_textures(scene, &material_kind(plan, pipeline), material) {
            seen.extend((!seen.contains(&key)).then_some(key));
        }
    }
    seen
}

/// How a pipeline that has a material uses it.
pub(super) fn material_kind(plan: &Plan, pipeline: usize) -> SurfaceKind {
    match &plan.pipelines[pipeline].1 {
        Pipeline::Decal(kind) => kind.surface(),
        Pipeline::Particles(kind) => kind.surface(),
        _ => *surface(plan, pipeline),
    }
}
