//! Which shader modules a pipeline consists of.

use super::super::shader::{
    GeometryConstants, LightInputs, LightLoop, LightingConstants, Module, OutputConstants, Specialization,
    TextureSlot, shared,
};
use crate::environment::TexelFormat;
use crate::plan::{LightWay, Pipeline, Plan, SurfaceKind, VolumeShape};

/// Vertex and fragment shader of a pipeline, the latter where it has one (what only tests depth has none), and what they
/// are specialised with.
pub(super) fn modules(plan: &Plan, pipeline: &Pipeline) -> (Module, Option<Module>, Specialization) {
    let layout = plan.options.layout;
    let output = OutputConstants {
        tonemap: plan.options.tonemap,
        dither: plan.options.dither,
        background: plan.needs.background,
        fog: plan.needs.fog,
    };
    let lighting = LightingConstants {
        has_directional: plan.needs.directional_lights > 0,
        has_point: plan.needs.point_lights > 0,
        has_spot: plan.needs.spot_lights > 0,
        has_box: plan.needs.box_lights > 0,
        has_hemisphere: plan.needs.hemisphere_lights > 0,
        has_back: plan.needs.back_colors > 0,
        shadow_filter: plan.shadow_map.as_ref().map(|_| plan.options.shadows.filter),
        fold: plan.folded.then_some(output),
    };
    let lights = LightInputs {
        scan: if plan.clusters.is_some() { LightLoop::Cluster } else { LightLoop::All },
        shadows: plan.shadow_map.is_some(),
        globe_maps: plan.needs.globe_maps > 0,
    };
    let one_light = LightInputs { scan: LightLoop::One, ..lights };
    let one_by_one = matches!(plan.light_way, LightWay::Volumes | LightWay::Stencil);
    let (vertex, fragment, constants) = match pipeline {
        Pipeline::Depth(kind) => {
            let textured = kind.textures != 0;
            let vertex = Module::GeometryVertex {
                normal: false,
                texcoord: textured,
                tangent: false,
                color: kind.vertex_color,
            };
            let mask = kind.alpha_mask.then_some(Module::Mask { textured });
            return (vertex, mask, surface_constants(plan, kind).specialization());
        }
        Pipeline::Surface(kind) => {
            let textured = kind.textures != 0;
            let constants = surface_constants(plan, kind).specialization();
            let vertex = vertex_module(kind);
            if plan.has_gbuffer() {
                let light_target = plan.has_light_target();
                let around = kind.around;
                (vertex, Module::GeometryFragment { layout, light_target, textured, around }, constants)
            } else if plan.has_light_target() {
                let around = kind.around;
                let constants = constants.and(lighting.specialization()).and(output.specialization());
                (vertex, Module::Base { textured, around }, constants)
            } else if kind.unlit {
                (vertex, Module::Unlit { textured }, constants.and(output.specialization()))
            } else {
                let around = kind.around;
                let module = Module::Forward { textured, lights, around };
                (vertex, module, constants.and(lighting.specialization()))
            }
        }
        Pipeline::Light(kind) => {
            let constants = surface_constants(plan, kind)
                .specialization()
                .and(lighting.specialization())
                .and(output.specialization());
            (
                vertex_module(kind),
                Module::Light { textured: kind.textures != 0, lights: one_light },
                constants,
            )
        }
        Pipeline::Lighting => {
            let lighting = if one_by_one { lighting.only_global() } else { lighting };
            let module = Module::Lighting { layout, lights };
            (Module::Fullscreen, module, lighting.specialization())
        }
        Pipeline::LightMask(shape) => return (Module::LightVolume, None, shape_constant(*shape)),
        Pipeline::LightVolume(shape) => {
            let module = Module::Lighting { layout, lights: one_light };
            let constants = lighting.only_local().specialization().and(shape_constant(*shape));
            (Module::LightVolume, module, constants)
        }
        Pipeline::Tonemap => {
            let fog = plan.needs.fog.is_some() && plan.has_gbuffer();
            (Module::Fullscreen, Module::Tonemap { fog }, output.specialization())
        }
    };
    (vertex, Some(fragment), constants)
}

fn shape_constant(shape: VolumeShape) -> Specialization {
    Specialization::volume(match shape {
        VolumeShape::Screen => const { shared("VOLUME_SCREEN") },
        VolumeShape::Sphere => const { shared("VOLUME_SPHERE") },
        VolumeShape::Cone => const { shared("VOLUME_CONE") },
        VolumeShape::Box => const { shared("VOLUME_BOX") },
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

fn surface_constants(plan: &Plan, kind: &SurfaceKind) -> GeometryConstants {
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
        rgbm: plan.environment_texels().is_some_and(|(format, _)| format == TexelFormat::Rgbm),
    }
}
