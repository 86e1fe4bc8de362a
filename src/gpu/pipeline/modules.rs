//! Which shader modules a pipeline consists of.

use super::super::shader::{
    GeometryConstants, LightLoop, LightingConstants, Module, OutputConstants, Specialization, TextureSlot,
    shared,
};
use crate::plan::{LightWay, Pipeline, Plan, SurfaceKind, VolumeShape};

/// Vertex and fragment shader of a pipeline, the latter where it has one, and what they are specialised with.
pub(super) fn modules(plan: &Plan, pipeline: &Pipeline) -> (Module, Option<Module>, Specialization) {
    let layout = plan.options.layout;
    let output = OutputConstants { tonemap: plan.options.tonemap, dither: plan.options.dither };
    let lighting = LightingConstants {
        has_directional: plan.needs.directional_lights > 0,
        has_point: plan.needs.point_lights > 0,
        has_spot: plan.needs.spot_lights > 0,
        fold: plan.folded.then_some(output),
    };
    let clusters = plan.clusters.is_some();
    let one_by_one = matches!(plan.light_way, LightWay::Volumes | LightWay::Stencil);
    match pipeline {
        Pipeline::Surface(kind) => {
            let textured = kind.textures != 0;
            let constants = surface_constants(kind).specialization();
            let vertex = vertex_module(kind);
            if plan.has_gbuffer() {
                let light_target = plan.has_light_target();
                (vertex, Some(Module::GeometryFragment { layout, light_target, textured }), constants)
            } else if kind.unlit {
                (vertex, Some(Module::Unlit { textured }), constants.and(output.specialization()))
            } else {
                let module = Module::Forward { textured, clusters };
                (vertex, Some(module), constants.and(lighting.specialization()))
            }
        }
        Pipeline::Lighting => {
            let lights = if clusters { LightLoop::Cluster } else { LightLoop::All };
            let lighting = if one_by_one { lighting.only_global() } else { lighting };
            (Module::Fullscreen, Some(Module::Lighting { layout, lights }), lighting.specialization())
        }
        Pipeline::LightMask(shape) => (Module::LightVolume, None, shape_constant(*shape)),
        Pipeline::LightVolume(shape) => {
            let module = Module::Lighting { layout, lights: LightLoop::One };
            let constants = lighting.only_local().specialization().and(shape_constant(*shape));
            (Module::LightVolume, Some(module), constants)
        }
        Pipeline::Tonemap => (Module::Fullscreen, Some(Module::Tonemap), output.specialization()),
    }
}

fn shape_constant(shape: VolumeShape) -> Specialization {
    Specialization::volume(match shape {
        VolumeShape::Screen => const { shared("VOLUME_SCREEN") },
        VolumeShape::Sphere => const { shared("VOLUME_SPHERE") },
        VolumeShape::Cone => const { shared("VOLUME_CONE") },
    })
}

fn vertex_module(kind: &SurfaceKind) -> Module {
    Module::GeometryVertex {
        normal: !kind.unlit,
        texcoord: kind.textures != 0,
        tangent: kind.needs_tangents(),
        color: kind.vertex_color,
    }
}

fn surface_constants(kind: &SurfaceKind) -> GeometryConstants {
    let slot = |slot: usize| {
        kind.texture_index(slot).map(|index| TextureSlot {
            slot: index as u32,
            second_texcoord: kind.second_texcoord & (1 << slot) != 0,
            transformed: kind.transformed & (1 << slot) != 0,
        })
    };
    GeometryConstants {
        textures: std::array::from_fn(slot),
        alpha_mask: kind.alpha_mask,
        double_sided: kind.double_sided,
        unlit: kind.unlit,
        vertex_color: kind.vertex_color,
        emissive: kind.emissive,
        ambient: kind.ambient,
    }
}
