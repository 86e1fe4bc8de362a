//! Which shader modules a pipeline consists of.

use super::super::shader::{
    DecalConstants, GBufferConstants, GeometryConstants, KIND_COUNT, LightLoop, LightingConstants,
    LightmapConstants, Module, OutputConstants, SampleConstants, SkyConstants, Specialization, TextureSlot,
    shared, target_number,
};
use crate::environment::TexelFormat;
use crate::plan::{
    Around, DecalKind, DecalWay, Edges, Form, Format, Pipeline, Plan, ShadowNeed, SurfaceKind, Translucency,
    VolumeShape,
};
use crate::visible::ShadowShape;

/// Vertex and fragment shader of a pipeline, the latter where it has one (what only tests depth has none), and what they
/// are specialised with.
pub(super) fn modules(plan: &Plan, pipeline: &Pipeline) -> (Module, Option<Module>, Specialization) {
    let surface = |kind| surface_constants(plan, kind).specialization();
    let (vertex, fragment, own) = match pipeline {
        Pipeline::Depth(kind) => {
            (Module::GeometryVertex, kind.alpha_mask.then_some(Module::Mask), surface(kind))
        }
        Pipeline::Absorb(kind) | Pipeline::Surface(kind) if kind.transmits => {
            let absorbs = Specialization::medium(matches!(pipeline, Pipeline::Absorb(_)), plan.refracts());
            let behind = Specialization::behind(depth_behind(plan));
            // What absorbs has no light of its own.
            let own = match pipeline {
                Pipeline::Absorb(_) => SurfaceKind { around: Around::Nothing, emissive: false, ..*kind },
                _ => *kind,
            };
            (Module::GeometryVertex, Some(Module::Medium), surface(&own).and(absorbs).and(behind))
        }
        Pipeline::Surface(kind) | Pipeline::Absorb(kind) => {
            let fragment = if plan.lights_as_drawn(kind) {
                // Without a light target what is unlit needs no more than its material.
                if kind.unlit && plan.folded { Module::Unlit } else { Module::Forward }
            } else if plan.has_gbuffer() {
                Module::GeometryFragment
            } else {
                Module::Base
            };
            (Module::GeometryVertex, Some(fragment), surface(kind))
        }
        Pipeline::Light(kind) => (Module::GeometryVertex, Some(Module::Light), surface(kind)),
        Pipeline::Sky => {
            let constants = SkyConstants { rgbm: is_rgbm(plan), probes: !plan.needs.probes.is_empty() };
            (Module::Fullscreen, Some(Module::Sky), constants.specialization())
        }
        Pipeline::Lighting | Pipeline::EdgeLighting => {
            let has_environment = plan.needs.environment.is_some();
            let around = Specialization::around(plan.needs.painted_around, is_rgbm(plan), has_environment);
            (Module::Fullscreen, Some(Module::Lighting), around)
        }
        Pipeline::Edges => (Module::Fullscreen, Some(Module::Edges), Specialization::default()),
        Pipeline::LightMask(shape) => (Module::LightVolume, None, shape_constant(*shape)),
        Pipeline::Decal(kind) => {
            let surface =
                GeometryConstants { textures: textures(&kind.surface()), ..GeometryConstants::default() };
            let decal = decal_constants(plan, kind).specialization();
            (Module::DecalVertex, Some(Module::Decal), surface.specialization().and(decal))
        }
        Pipeline::LightVolume(shape) | Pipeline::EdgeVolume(shape) => {
            (Module::LightVolume, Some(Module::Lighting), shape_constant(*shape))
        }
        Pipeline::ShadowNearEnds => (Module::ShadowNearEndsVertex, None, Specialization::default()),
        Pipeline::ShadowVolume => (Module::ShadowVolumeVertex, None, Specialization::default()),
        Pipeline::ShadowedLight => {
            let of_instance = Specialization::volume(const { shared("VOLUME_OF_INSTANCE") });
            (Module::LightVolume, Some(Module::Lighting), of_instance)
        }
        Pipeline::Tonemap => (Module::Fullscreen, Some(Module::Tonemap), Specialization::default()),
        Pipeline::Backdrop => {
            (Module::Fullscreen, Some(Module::Backdrop), Specialization::behind(depth_behind(plan)))
        }
        Pipeline::Composite => (Module::Fullscreen, Some(Module::Composite), Specialization::default()),
        Pipeline::Peel { kind, first } => {
            // The first has nothing behind it where nothing is opaque.
            let opaque = depth_behind(plan);
            let fragment = (!first || opaque.is_some()).then_some(Module::Peel);
            let behind_opaque = *first && opaque == Some(true);
            (Module::GeometryVertex, fragment, surface(kind).and(Specialization::behind(Some(behind_opaque))))
        }
        Pipeline::Fog => (Module::Fullscreen, Some(Module::Fog), Specialization::default()),
        Pipeline::Show | Pipeline::ShowEdges => {
            (Module::Fullscreen, Some(Module::Show), show(plan, pipeline))
        }
        Pipeline::Overlay => (Module::OverlayVertex, Some(Module::Overlay), Specialization::default()),
        Pipeline::Particles(kind) => {
            let textures = textures(&kind.surface());
            let surface = GeometryConstants { textures, ..GeometryConstants::default() };
            let behind = Specialization::behind(depth_behind(plan));
            (Module::ParticleVertex, Some(Module::Particle), surface.specialization().and(behind))
        }
    };
    let lighting = lighting_constants(plan, pipeline).specialization();
    let output = output_constants(plan, pipeline).specialization();
    let gbuffer = gbuffer_constants(plan).specialization();
    let brdf = Specialization::brdf(plan.options.brdf);
    let samples = sample_constants(plan, pipeline).specialization();
    // Of what draws surfaces, only layers, what is peeled and what absorbs look at samples.
    let transmits = matches!(pipeline, Pipeline::Surface(kind) | Pipeline::Absorb(kind) if kind.transmits);
    let reads = !pipeline.is_of_surfaces() || transmits || reads_samples(plan, pipeline);
    let fragment = fragment.map(|m| if plan.options.samples > 1 && reads { m.multisampled() } else { m });
    let all = samples.and(lighting).and(output).and(gbuffer).and(brdf).and(own);
    let all = match pipeline.is_of_blended() || *pipeline == Pipeline::Composite {
        true => all.and(translucency_constants(plan)),
        false => all,
    };
    (vertex, fragment, all)
}

/// Whether it draws blended surfaces and reads, of each sample, what was left of others.
fn reads_samples(plan: &Plan, pipeline: &Pipeline) -> bool {
    let keeps_layers = plan.options.translucency == Translucency::Oit;
    matches!(pipeline, Pipeline::Surface(kind) if kind.blend && !kind.transmits && keeps_layers && !plan.folded)
        || matches!(pipeline, Pipeline::Peel { .. })
}

fn sample_constants(plan: &Plan, pipeline: &Pipeline) -> SampleConstants {
    SampleConstants {
        samples: plan.options.samples,
        per_sample: plan.edges == Edges::All
            || pipeline.per_pixel() != *pipeline
            || matches!(pipeline, Pipeline::Fog | Pipeline::Composite | Pipeline::Decal(_))
            || reads_samples(plan, pipeline),
        edge_target: plan.edges == Edges::Coverage,
        edge_masks: plan.needs.kinds.iter().any(|need| need.kind.alpha_mask),
        // A surface that is drawn by sample is where its sample is.
        sample_depth: plan.has_gbuffer() && plan.gbuffer.reads_depth_attachment()
            || pipeline.is_of_surfaces(),
        resolve: plan.options.resolve,
    }
}

/// Whether lighting reads the depth of what is opaque too; `None` if there is no such depth.
fn depth_behind(plan: &Plan) -> Option<bool> {
    let opaque = plan.attachments.iter().find(|a| a.format.is_depth() && a.name.starts_with("depth"))?;
    // Of a copy lighting knows nothing.
    Some(opaque.name.split('/').next() == Some("depth") && !plan.refracts())
}

fn translucency_constants(plan: &Plan) -> Specialization {
    let pairs = plan.attachments.iter().any(|a| a.name.contains("layer_") && a.format == Format::Rgba32Uint);
    Specialization::translucency(plan.options.translucency, plan.options.layers(), pairs)
}

pub(in crate::gpu) fn gbuffer_constants(plan: &Plan) -> GBufferConstants {
    let new = GBufferConstants::new(&plan.gbuffer);
    GBufferConstants {
        exists: plan.has_gbuffer(),
        // Where there is none, light is summed in one target.
        form: if plan.has_gbuffer() { new.form } else { Form::Metallic },
        light_target: plan.has_light_target(),
        light_alpha: plan.light_target().is_none_or(|light| light.has_alpha()),
        light_read: plan.light_is_read(),
        light_added: plan.light_is_read() && !plan.folded,
        occlusion: plan.has_gbuffer() && plan.needs.occlusion.is_some(),
        ..new
    }
}

pub(super) fn lighting_constants(plan: &Plan, pipeline: &Pipeline) -> LightingConstants {
    let all = LightingConstants {
        scan: if plan.clusters.is_some() { LightLoop::Cluster } else { LightLoop::All },
        has_directional: plan.needs.directional_lights > 0,
        has_point: plan.needs.point_lights > 0,
        has_spot: plan.needs.spot_lights > 0,
        has_box: plan.needs.box_lights > 0,
        has_hemisphere: plan.needs.hemisphere_lights > 0,
        has_back: plan.needs.back_colors > 0,
        globe_maps: plan.needs.globe_maps > 0,
        shadow_filter: plan.shadow_map.as_ref().map(|_| plan.options.shadows.filter),
        shadow_volumes: !plan.volume_lights.is_empty(),
        fold: plan.folded,
    };
    let one_by_one = plan.light_way.is_one_by_one();
    match pipeline.per_pixel() {
        Pipeline::ShadowedLight => {
            let counted = |need: &&ShadowNeed| plan.volume_lights.contains(&need.light);
            let any = |is: fn(&ShadowNeed) -> bool| plan.needs.shadows.lights.iter().filter(counted).any(is);
            LightingConstants {
                has_directional: any(|light| light.shape.is_parallel()),
                has_point: any(|light| light.is_point),
                has_spot: any(|light| !light.is_point && !light.shape.is_parallel()),
                globe_maps: any(|light| light.has_globe_map),
                ..all.one_counted()
            }
        }
        Pipeline::Lighting if one_by_one => all.only_global(has_shadows(plan, ShadowShape::Cascades)),
        Pipeline::LightVolume(_) => all.one_local(
            [ShadowShape::Slab, ShadowShape::Cone, ShadowShape::Cube].iter().any(|&s| has_shadows(plan, s)),
        ),
        _ => all,
    }
}

fn has_shadows(plan: &Plan, shape: ShadowShape) -> bool {
    plan.shadow_map.iter().flat_map(|map| &map.lights).any(|light| light.shape == shape)
}

fn output_constants(plan: &Plan, pipeline: &Pipeline) -> OutputConstants {
    // Fog comes before light that is complete.
    let applies_fog = match pipeline.per_pixel() {
        Pipeline::Lighting | Pipeline::LightVolume(_) | Pipeline::ShadowedLight => plan.folded,
        Pipeline::Tonemap => plan.has_gbuffer() && plan.needs.over_light().is_none(),
        _ => true,
    };
    OutputConstants {
        translucency: plan.needs.over_light().is_some(),
        tonemap: plan.options.tonemap,
        dither: plan.options.dither,
        float: plan.options.output.is_float(),
        background: plan.needs.background,
        fog: plan.needs.fog.filter(|_| applies_fog),
        bloom: plan.options.bloom,
    }
}

fn show(plan: &Plan, pipeline: &Pipeline) -> Specialization {
    let strips = plan.strips();
    Specialization::show(plan.options.show, &strips, *pipeline == Pipeline::ShowEdges)
}

fn shape_constant(shape: VolumeShape) -> Specialization {
    Specialization::volume(match shape {
        VolumeShape::Screen => const { shared("VOLUME_SCREEN") },
        VolumeShape::Sphere => const { shared("VOLUME_SPHERE") },
        VolumeShape::Cone => const { shared("VOLUME_CONE") },
        VolumeShape::Box => const { shared("VOLUME_BOX") },
    })
}

fn textures(kind: &SurfaceKind) -> [Option<TextureSlot>; KIND_COUNT] {
    std::array::from_fn(|slot| {
        kind.texture_index(slot).map(|index| TextureSlot {
            slot: index as u32,
            second_texcoord: kind.second_texcoord & (1 << slot) != 0,
            transformed: kind.transformed & (1 << slot) != 0,
        })
    })
}

fn decal_constants(plan: &Plan, kind: &DecalKind) -> DecalConstants {
    let stage = plan.passes.iter().flat_map(|p| &p.subpasses).find(|s| s.name == "decals");
    let blended = plan.decal_way == Some(DecalWay::Fixed);
    // What is blended is written whole.
    let targets = stage.filter(|_| !blended).map_or(&[][..], |stage| &stage.color_names);
    let numbers = targets.iter().filter_map(|name| target_number(name));
    DecalConstants {
        channels: kind.channels,
        targets: numbers.fold(0, |bits, target| bits | 1 << target),
        blended,
    }
}

fn surface_constants(plan: &Plan, kind: &SurfaceKind) -> GeometryConstants {
    GeometryConstants {
        textures: textures(kind),
        alpha_mask: kind.alpha_mask,
        double_sided: kind.double_sided,
        unlit: kind.unlit,
        vertex_color: kind.vertex_color,
        blend: kind.blend,
        emissive: kind.emissive,
        around: kind.around,
        rgbm: is_rgbm(plan),
        has_environment: plan.needs.environment.is_some(),
        lightmap: plan.needs.lightmap.filter(|_| kind.has_lightmap()).map(|map| LightmapConstants {
            unit_lx: map.unit_lx,
            rgbm: plan.options.lightmap_format == TexelFormat::Rgbm,
        }),
    }
}

fn is_rgbm(plan: &Plan) -> bool {
    plan.environment_texels().is_some_and(|(format, _)| format == TexelFormat::Rgbm)
}
