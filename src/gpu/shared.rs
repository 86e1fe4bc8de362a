//! What buffers hold, as GLSL declares it. A test compares every offset with the compiled SPIR-V.
//!
//! World space is right-handed, +Y up, in metres; colours are linear Rec.709.

use bytemuck::{Pod, Zeroable};

/// What one frame has once: `Frame` in `glsl/frame.glsl`, std140.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct FrameUniforms {
    /// Column-major; Vulkan clip space, y down, reversed depth.
    pub clip_from_world: [[f32; 4]; 4],
    /// xyz the camera's place, w 1 for a perspective and 0 for an orthographic projection.
    pub camera_position_world: [f32; 4],
    /// The way of NDC +x, as long as half the image is wide: at distance 1 (perspective) or in metres
    /// (orthographic). w unused.
    pub right_world: [f32; 4],
    /// The way of NDC +y, as long as half the image is high, likewise. w unused.
    pub down_world: [f32; 4],
    /// The way the camera looks, unit length. w unused.
    pub forward_world: [f32; 4],
    /// `[p, q, r, s]` of [`crate::scene::Projection::distance_from_depth`].
    pub distance_from_depth: [f32; 4],
    /// 1 / width and 1 / height, per pixel.
    pub inverse_size: [f32; 2],
    /// Multiplies light: 2^EV.
    pub exposure: f32,
    /// The light target holds exposed light times this; 1 for float targets.
    pub light_scale: f32,
    /// Radiance from every direction, cd/m². w unused.
    pub ambient_nt: [f32; 4],
    /// How many directional, point, spot and box lights there are; lights are sorted in this order.
    pub light_counts: [u32; 4],
    /// Irradiance of all hemisphere lights together: of colour channel `c`, in lux, `dot(hemispheres[c], (normal, 1))`.
    pub hemispheres: [[f32; 4]; 3],
    /// The share of light that is scattered, and by what to multiply what is stored of it. zw unused.
    pub bloom: [f32; 4],
}

/// A placement of a mesh, indexed by the instance index: `Instance` in `glsl/geometry.vert`, std430.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct InstanceData {
    /// The first three rows of the affine transform: `world[i] = dot(rows[i], (object, 1))`.
    pub world_from_object_rows: [[f32; 4]; 3],
}

/// A material's numbers: `Material` in `glsl/material.glsl`, std140.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct MaterialData {
    /// Colour and alpha; multiplies texture and vertex colour.
    pub base_color_factor: [f32; 4],
    /// xyz emitted light in cd/m², w the alpha below which a mask cuts.
    pub emissive_factor_alpha_cutoff: [f32; 4],
    /// 0 dielectric to 1 metal.
    pub metallic_factor: f32,
    /// Perceptual roughness, 0 to 1.
    pub roughness_factor: f32,
    /// Multiplies x and y of sampled normals.
    pub normal_scale: f32,
    /// 0 ignores sampled occlusion, 1 applies it fully.
    pub occlusion_strength: f32,
    /// Per kind of texture (base colour, metallic-roughness, normal, occlusion, emissive) the two rows of
    /// [`crate::scene::TextureRef::uv_from_texcoord`]; the fourth component is unused.
    pub uv_rows: [[[f32; 4]; 2]; super::shader::KIND_COUNT],
}

/// What fills the space behind a material that light goes through: `Medium` in `glsl/medium.glsl`, std140.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct MediumData {
    /// See [`crate::scene::Transmission::absorption_per_m`].
    pub absorption_per_m: [f32; 3],
    /// The longest way through, metres.
    pub thickness_m: f32,
    /// The share of light that enters and is not scattered back.
    pub factor: f32,
    /// Reflectance at normal incidence.
    pub f0: f32,
    /// 1 / index of refraction.
    pub inverse_ior: f32,
    /// Unused.
    pub padding: f32,
}

/// What does not change about an environment: `Environment` in `glsl/light/environment.glsl`, std140.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct EnvironmentUniforms {
    /// Irradiance over pi in cd/m², coefficients of [`crate::environment::basis`]. w unused.
    pub irradiance: [[f32; 4]; 9],
    /// Cosine and sine of the angle by which the environment is turned about +Y.
    pub rotation: [f32; 2],
    /// cd/m² of a stored 1.
    pub scale: f32,
    /// The level for roughness 1.
    pub last_level: f32,
}

/// A light with a place or a direction: `Light` in `glsl/light/punctual.glsl`, std430.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LightData {
    /// Position in metres, of a box its centre; the fourth is 1 / range in 1 / metres, and 0 reaches everywhere. Unused
    /// by directional lights.
    pub place: [f32; 4],
    /// Colour times candela, or times lux for directional and box lights.
    pub intensity: [f32; 3],
    /// Of a spot `1 / max(0.001, cos(inner) - cos(outer))` of the cone's half angles (KHR_lights_punctual); of a box the
    /// width of the falloff within each face, metres.
    pub edge: f32,
    /// The way the light travels, unit length; unused by point lights.
    pub direction_world: [f32; 3],
    /// `-cos(outer) * edge`.
    pub spot_offset: f32,
    /// The light's +Y, unit length; used by boxes and globe maps.
    pub up_world: [f32; 3],
    /// Of the globe map, radians.
    pub globe_rotation: f32,
    /// Colour times lux on surfaces that face away from directional and box lights.
    pub back_intensity: [f32; 3],
    /// The light's first [`ShadowViewData`] + 1 and, 16 bits up, how many it has; 0: no shadow.
    pub shadow: u32,
    /// Half the extent of a box, metres; of a spot that of its globe map at a distance of 1 m.
    pub half_size: [f32; 3],
    /// The first layer of the light's globe map + 1; 0: none.
    pub globe_map: u32,
}

/// A tile of the shadow map: `ShadowView` in `glsl/light/shadow.glsl`, std430.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ShadowViewData {
    /// Column-major, homogeneous: xy the whole map's texture coordinates, z reversed depth. All 0: nothing is inside.
    pub map_from_world: [[f32; 4]; 4],
    /// Least and greatest xy that samples may have.
    pub tile: [f32; 4],
    /// Width of a texel at w = 1, metres.
    pub texel_m: f32,
    /// Radius of the filter, texels.
    pub spread_texels: f32,
    /// How far receivers are moved along their normal where light grazes, texels.
    pub offset_texels: f32,
    /// How far receivers are moved towards the light, texels.
    pub lift_texels: f32,
}

/// What draws of casters share within a tile: `ShadowPush` in `glsl/shadow.vert`, std430.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ShadowPush {
    /// Column-major; the tile's clip space.
    pub clip_from_world: [[f32; 4]; 4],
    /// Nothing is drawn nearer to the light than at this depth.
    pub nearest_depth: f32,
}

/// What glossy surfaces reflect inside a box: `Probe` in `glsl/light/environment.glsl`, std430.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ProbeData {
    /// The first three rows of the transform into the box's space, metres along its axes from its centre.
    pub probe_from_world_rows: [[f32; 4]; 3],
    /// Half the box's size, metres.
    pub half_size: [f32; 3],
    /// Within each face, metres.
    pub falloff: f32,
    /// Cosine and sine of the angle by which the captured picture is turned about the box's +Y.
    pub rotation: [f32; 2],
    /// cd/m² of a stored 1.
    pub scale: f32,
    /// Unused.
    pub padding: f32,
}

/// How a view is cut into cells: `ClusterGrid` in `glsl/light/clusters.glsl`, std430. The cells' lists follow it
/// ([`crate::visible::Clusters::words`]).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ClusterGrid {
    /// Tiles are squares of 2 to this power pixels.
    pub tile_shift: u32,
    /// Tiles across the image.
    pub columns: u32,
    /// Tiles down the image.
    pub rows: u32,
    /// Cuts by distance.
    pub slices: u32,
    /// See [`crate::visible::Grid::slice_scale`].
    pub slice_scale: f32,
    /// Likewise.
    pub slice_bias: f32,
}

/// What a draw of shadow volumes is of: `VolumePush` in `glsl/shadow_volume.vert`, std430.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct VolumePush {
    /// A light's place and 1, or the way towards a directional light and 0; world space.
    pub light: [f32; 4],
    /// Where the mesh's places are among the casters.
    pub first_place: u32,
    /// Likewise its triangles.
    pub first_triangle: u32,
    /// Likewise its edges.
    pub first_edge: u32,
    /// Six an edge; six a triangle follow.
    pub edge_vertices: u32,
    /// 1: triangles are clockwise from the front.
    pub turned: u32,
    /// To a multiple of 16 bytes.
    pub unused: [u32; 3],
}

/// How large an image is that triangles are drawn over: `Push` in `glsl/overlay.vert`, std430.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct OverlayPush {
    /// 2 / the picture's size in points, turned as the image is.
    pub clip_from_point: [[f32; 2]; 2],
    /// The left upper corner of the picture.
    pub origin_clip: [f32; 2],
}

/// Which light a draw adds: `LightPush` in `glsl/light.frag`, std430.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LightPush {
    /// Its number among the frame's lights.
    pub light: u32,
}

/// A particle: `Particle` in `glsl/particle.glsl`, std430.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ParticleData {
    /// Metres.
    pub center_world: [f32; 3],
    /// 1 / the soft distance, per metre.
    pub inverse_soft: f32,
    /// Multiplies the material's emission.
    pub color: [f32; 3],
    /// Unused.
    pub padding: f32,
    /// Half a side of the square, as a vector on the image: right and up, metres.
    pub half_axis: [f32; 2],
    /// Unused.
    pub padding_2: [f32; 2],
}

/// A decal: `Decal` in `glsl/decal.glsl`, std430.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct DecalData {
    /// The first three rows of what turns the cube from -0.5 to 0.5 into the box.
    pub world_from_decal_rows: [[f32; 4]; 3],
    /// The first three rows of the inverse.
    pub decal_from_world_rows: [[f32; 4]; 3],
    /// Of base colour, normal, roughness and metallicness, 0 to 1.
    pub opacity: [f32; 4],
    /// 1 / the falloff inside the faces as a share of the box's size.
    pub inverse_falloff: [f32; 3],
    /// Of the box's axes: 1, or -1 where it is mirrored.
    pub handedness: f32,
    /// See [`crate::scene::Decal::angle_line`].
    pub facing: [f32; 2],
    /// Not 0: the box's far side is not whole, so that a triangle over the image is drawn.
    pub whole_image: u32,
    /// Unused.
    pub padding: u32,
}

/// What a dispatch poses: `PosePush` in `glsl/pose.comp`, std430. Lists of rest poses and of what is written are counted in words, poses in
/// elements of 16 bytes; `u32::MAX` says that there is no list.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PosePush {
    /// How many are written.
    pub vertices: u32,
    /// The vertex that each of them is.
    pub first_source: u32,
    /// Influences of each vertex.
    pub influences: u32,
    /// Where they begin.
    pub first_influence: u32,
    /// Positions before they are posed.
    pub rest_position: u32,
    /// Likewise normals; none are written without.
    pub rest_normal: u32,
    /// Likewise tangents.
    pub rest_tangent: u32,
    /// The joints' rows.
    pub first_joint: u32,
    /// Morph targets that have a weight.
    pub first_target: u32,
    /// How many.
    pub targets: u32,
    /// Where positions are written.
    pub position: u32,
    /// Words from one to the next.
    pub position_stride: u32,
    /// Where normals are written.
    pub normal: u32,
    /// Where tangents are written.
    pub tangent: u32,
}
