//! The scene's numbers as shaders read them.

use glam::{DVec4, Vec3};

use super::shared::{InstanceData, LightData, MaterialData, MediumData};
use crate::plan::SurfaceKind;
use crate::scene::{AlphaMode, GlobeMap, Light, LightKind, Material, TextureRef, Transmission};

pub(super) fn instance(world_from_object: &glam::Mat4) -> InstanceData {
    let m = world_from_object;
    InstanceData { world_from_object_rows: [m.row(0), m.row(1), m.row(2)].map(|r| r.to_array()) }
}

pub(super) fn placement(instance: &InstanceData) -> glam::Mat4 {
    let [x, y, z] = instance.world_from_object_rows;
    glam::Mat4::from_cols_array_2d(&[x, y, z, [0.0, 0.0, 0.0, 1.0]]).transpose()
}

pub(super) fn material(m: &Material) -> MaterialData {
    let cutoff = match m.alpha_mode {
        AlphaMode::Opaque | AlphaMode::Blend => 0.0,
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

pub(super) fn medium(t: &Transmission) -> MediumData {
    MediumData {
        absorption_per_m: t.absorption_per_m().as_vec3().to_array(),
        thickness_m: t.thickness_m,
        factor: t.factor,
        f0: t.f0() as f32,
        inverse_ior: 1.0 / t.ior,
        ..MediumData::default()
    }
}

/// `globe_map` is the first layer of its globe map.
pub(super) fn light(l: &Light, globe_map: Option<u32>) -> LightData {
    let (half_size, edge, spot_offset) = match l.kind {
        LightKind::Box { size_m, falloff_m, .. } => (size_m * 0.5, falloff_m, 0.0),
        LightKind::Spot { inner_cone_rad, outer_cone_rad, .. } => {
            // KHR_lights_punctual, "Inner and Outer Cone Angles".
            let outer = outer_cone_rad.cos();
            let scale = 1.0 / (inner_cone_rad.cos() - outer).max(0.001);
            let picture = Vec3::splat(outer_cone_rad.min(GlobeMap::MOST_CONE_RAD).tan());
            (picture, scale, -outer * scale)
        }
        _ => (Vec3::ZERO, 0.0, 0.0),
    };
    LightData {
        place: l.position_world.extend(l.range_m.map_or(0.0, f32::recip)).to_array(),
        intensity: (l.color * l.intensity()).to_array(),
        edge,
        direction_world: l.direction_world.to_array(),
        spot_offset,
        up_world: l.up_world.to_array(),
        back_intensity: if l.has_back() { l.back_color * l.intensity() } else { Vec3::ZERO }.to_array(),
        half_size: half_size.to_array(),
        globe_rotation: l.globe_map.map_or(0.0, |map| map.rotation_rad),
        globe_map: globe_map.map_or(0, |layer| layer + 1),
        ..LightData::default()
    }
}

/// The irradiance of hemisphere lights as [`super::shared::FrameUniforms::hemispheres`] has it, summed in f64. Of one
/// light: `mix(back, color, 0.5 + 0.5 n·up)`, and up is where its light comes from.
pub(super) fn hemispheres<'a>(lights: impl Iterator<Item = &'a LightData>) -> [[f32; 4]; 3] {
    let mut rows = [DVec4::ZERO; 3];
    for light in lights {
        let up = -Vec3::from(light.direction_world).as_dvec3();
        for (channel, row) in rows.iter_mut().enumerate() {
            let [sky, ground] =
                [light.intensity, light.back_intensity].map(|lx| 0.5 * f64::from(lx[channel]));
            *row += (up * (sky - ground)).extend(sky + ground);
        }
    }
    rows.map(|row| row.as_vec4().to_array())
}
