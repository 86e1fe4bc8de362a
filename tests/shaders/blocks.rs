//! The structs that Rust and GLSL share.

use ontile::gpu::shared::{
    ClusterGrid, DecalData, EnvironmentUniforms, FrameUniforms, InstanceData, LightData, LightPush,
    MaterialData, MediumData, ParticleData, PosePush, ProbeData, ShadowPush, ShadowViewData, VolumePush,
};

use crate::reflect::{Block, block};

/// Each, as Rust lays it out.
pub fn blocks() -> [Block; 15] {
    [
        block!(
            "Frame" = FrameUniforms {
                clip_from_world,
                camera_position_world,
                right_world,
                down_world,
                forward_world,
                distance_from_depth,
                inverse_size,
                exposure,
                light_scale,
                ambient_nt,
                light_counts,
                hemispheres,
                bloom,
            }
        ),
        block!("Instance" = InstanceData { world_from_object_rows }),
        block!(
            "Material" = MaterialData {
                base_color_factor,
                emissive_factor_alpha_cutoff,
                metallic_factor,
                roughness_factor,
                normal_scale,
                occlusion_strength,
                uv_rows,
            }
        ),
        block!(
            "Light" = LightData {
                place,
                intensity,
                edge,
                direction_world,
                spot_offset,
                up_world,
                globe_rotation,
                back_intensity,
                shadow,
                half_size,
                globe_map,
            }
        ),
        block!("Medium" = MediumData { absorption_per_m, thickness_m, factor, f0, inverse_ior, padding }),
        block!("LightPush" = LightPush { light }),
        block!(
            "Particle" = ParticleData { center_world, inverse_soft, color, padding, half_axis, padding_2 }
        ),
        block!(
            "VolumePush" =
                VolumePush { light, first_place, first_triangle, first_edge, edge_vertices, turned, unused }
        ),
        block!("ClusterGrid" = ClusterGrid { tile_shift, columns, rows, slices, slice_scale, slice_bias }),
        block!(
            "ShadowView" =
                ShadowViewData { map_from_world, tile, texel_m, spread_texels, offset_texels, lift_texels }
        ),
        block!(
            "PosePush" = PosePush {
                vertices,
                first_source,
                influences,
                first_influence,
                rest_position,
                rest_normal,
                rest_tangent,
                first_joint,
                first_target,
                targets,
                position,
                position_stride,
                normal,
                tangent,
            }
        ),
        block!("ShadowPush" = ShadowPush { clip_from_world, nearest_depth }),
        block!("Probe" = ProbeData { probe_from_world_rows, half_size, falloff, rotation, scale, padding }),
        block!("Environment" = EnvironmentUniforms { irradiance, rotation, scale, last_level }),
        block!(
            "Decal" = DecalData {
                world_from_decal_rows,
                decal_from_world_rows,
                opacity,
                inverse_falloff,
                handedness,
                facing,
                whole_image,
                padding,
            }
        ),
    ]
}
