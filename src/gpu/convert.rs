//! The scene's numbers as shaders read them.

use super::shared::{InstanceData, LightData, MaterialData};
use crate::plan::SurfaceKind;
use crate::scene::{AlphaMode, Light, LightKind, Material, TextureRef};

pub(super) fn instance(world_from_object: &glam::Mat4) -> InstanceData {
    let m = world_from_object;
    InstanceData { world_from_object_rows: [m.row(0), m.row(1), m.row(2)].map(|r| r.to_array()) }
}

pub(super) fn material(m: &Material) -> MaterialData {
    let cutoff = match m.alpha_mode {
        AlphaMode::Opaque => 0.0,
        AlphaMode::Mask { cutoff } => cutoff,
    };
    let rows = |texture: Option<TextureRef>| {
        let rows = texture.map_or(TextureRef::IDENTITY, |t| t.uv_from_texcoord);
        rows.map(|r| r.extend(0.0).to_array())
    };
    MaterialData {
        base_color_factor: m.base_color_factor.to_array(),
        emissive_factor_alpha_cutoff: m.emissive_factor.extend(cutoff).to_array(),
        metallic_factor: m.metallic_factor,
        roughness_factor: m.roughness_factor,
        normal_scale: m.normal_scale,
        occlusion_strength: m.occlusion_strength,
        uv_rows: SurfaceKind::textures_of(m).map(rows),
    }
}

pub(super) fn light(l: &Light) -> LightData {
    let (spot_scale, spot_offset) = match l.kind {
        LightKind::Spot { inner_cone_rad, outer_cone_rad, .. } => {
            // KHR_lights_punctual, "Inner and Outer Cone Angles".
            let outer = outer_cone_rad.cos();
            let scale = 1.0 / (inner_cone_rad.cos() - outer).max(0.001);
            (scale, -outer * scale)
        }
        _ => (0.0, 0.0),
    };
    LightData {
        position_world: l.position_world.to_array(),
        inverse_range: l.range_m.map_or(0.0, f32::recip),
        intensity: (l.color * l.intensity()).to_array(),
        spot_scale,
        direction_world: l.direction_world.to_array(),
        spot_offset,
        ..LightData::default()
    }
}
