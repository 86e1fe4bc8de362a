//! What of a scene is brought to the device, and how pipelines use it.

use std::collections::{BTreeMap, BTreeSet};

use super::super::objects::{Batch, Objects};
use super::super::pipeline::{FamilyLayout, Pipelines};
use super::super::{ColorEncoding, Streams, TextureKey, Textures};
use crate::Result;
use crate::plan::{Pipeline, Plan, SLOTS, SurfaceKind};
use crate::scene::Scene;

/// The kind of surface that a pipeline draws.
pub(in crate::gpu) fn surface(plan: &Plan, pipeline: usize) -> &SurfaceKind {
    match &plan.pipelines[pipeline].1 {
        Pipeline::Surface(kind) => kind,
        other => unreachable!("batches are made for surfaces, not for {other:?}"),
    }
}

/// What each mesh's pipelines read. A mesh has one material, so its pipelines differ in winding only.
pub(in crate::gpu) fn streams(scene: &Scene, plan: &Plan, batches: &[Batch]) -> Vec<Option<Streams>> {
    let mut streams = vec![None; scene.meshes.len()];
    for batch in batches {
        streams[batch.mesh] = Some(vertex_streams(surface(plan, batch.pipeline)));
    }
    streams
}

/// The vertex attributes that a kind of surface reads.
pub(in crate::gpu) fn vertex_streams(kind: &SurfaceKind) -> Streams {
    Streams {
        normals: !kind.unlit,
        tangents: kind.needs_tangents(),
        texcoords: kind.texcoord_sets(),
        colors: kind.vertex_color,
    }
}

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

/// Every texture that some pipeline samples, once; `others` are pipelines and materials of what is no object.
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

/// What the images of all textures hold that some pipeline samples; `others` as for [`texture_keys`].
pub(in crate::gpu) fn texture_bytes(
    scene: &Scene,
    plan: &Plan,
    objects: &Objects,
    others: &[(usize, usize)],
) -> Result<u64> {
    let keys = texture_keys(scene, plan, objects.batches(), others);
    Textures::bytes(&scene.images, &scene.textures, &keys)
}

/// Those of these materials that light goes through.
pub(super) fn media(scene: &Scene, materials: &BTreeSet<usize>) -> BTreeSet<usize> {
    materials.iter().copied().filter(|&i| scene.materials[i].transmits().is_some()).collect()
}

/// A layout of each [`Family::frame`].
pub(super) fn frame_layouts(pipelines: &Pipelines) -> BTreeMap<u32, &FamilyLayout> {
    let read = pipelines.layouts.iter().filter(|(family, _)| family.frame() != 0);
    read.map(|(family, layout)| (family.frame(), layout)).collect()
}
