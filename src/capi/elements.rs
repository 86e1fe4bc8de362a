//! Descriptions of what a world consists of.

use std::ffi::c_char;

/// The name of an element of a world; 0 is none.
pub type OntileId = u64;

/// Indexed triangles in object space, metres, with one material. Lists that are null are left out.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct OntileMesh {
    /// For messages; may be null.
    pub name: *const c_char,
    /// How many vertices there are.
    pub vertex_count: usize,
    /// x, y, z of each vertex.
    pub positions: *const f32,
    /// x, y, z of each vertex, of unit length; lit materials want them.
    pub normals: *const f32,
    /// x, y, z, and the bitangent's sign, of each vertex; normal textures want them.
    pub tangents: *const f32,
    /// u, v of each vertex: TEXCOORD_0.
    pub texcoords_0: *const f32,
    /// u, v of each vertex: TEXCOORD_1.
    pub texcoords_1: *const f32,
    /// r, g, b, a of each vertex, linear.
    pub colors: *const f32,
    /// Three a triangle.
    pub index_count: usize,
    /// Each below vertex_count.
    pub indices: *const u32,
    /// Of a material.
    pub material: OntileId,
}

/// A texture as a slot of a material uses it.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct OntileTextureRef {
    /// Of a texture; 0 leaves the slot empty, and the rest of this is ignored then.
    pub texture: OntileId,
    /// 0 or 1: which of the mesh's texture coordinates.
    pub texcoord: u32,
    /// Two rows: uv = (row 0 . (u, v, 1), row 1 . (u, v, 1)). All zero counts as no transform.
    pub uv_from_texcoord: [[f32; 3]; 2],
}

/// What alpha does.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OntileAlphaMode {
    /// Nothing.
    Opaque = 0,
    /// What is below the cutoff is not there.
    Mask = 1,
    /// It is laid over what is behind.
    Blend = 2,
}

/// A surface as glTF 2.0 section 3.9 describes it. ontile_material_default gives one that is white and rough.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct OntileMaterial {
    /// For messages; may be null.
    pub name: *const c_char,
    /// Linear Rec.709 and alpha.
    pub base_color_factor: [f32; 4],
    /// sRGB-encoded, linear alpha.
    pub base_color_texture: OntileTextureRef,
    /// 0 dielectric to 1 metal.
    pub metallic_factor: f32,
    /// Perceptual.
    pub roughness_factor: f32,
    /// Green roughness, blue metallicness.
    pub metallic_roughness_texture: OntileTextureRef,
    /// In tangent space.
    pub normal_texture: OntileTextureRef,
    /// Of x and y of the normal texture.
    pub normal_scale: f32,
    /// Red.
    pub occlusion_texture: OntileTextureRef,
    /// 0 to 1.
    pub occlusion_strength: f32,
    /// Linear Rec.709, cd/m2.
    pub emissive_factor: [f32; 3],
    /// sRGB-encoded.
    pub emissive_texture: OntileTextureRef,
    /// An OntileAlphaMode.
    pub alpha_mode: u32,
    /// Of ONTILE_ALPHA_MODE_MASK.
    pub alpha_cutoff: f32,
    /// Drawn from both sides.
    pub double_sided: bool,
    /// Shown as its base colour.
    pub unlit: bool,
    /// The share of light that goes through, 0 to 1; at 0 nothing below counts (KHR_materials_transmission, _ior, _volume).
    pub transmission_factor: f32,
    /// Index of refraction, at least 1.
    pub ior: f32,
    /// The longest way through, metres; 0 is a thin pane.
    pub thickness: f32,
    /// What is left of white light after attenuation_distance: linear Rec.709.
    pub attenuation_color: [f32; 3],
    /// Metres; 0 counts as infinite.
    pub attenuation_distance: f32,
}

/// A picture, 8 bits a channel, rows from the top.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct OntileImage {
    /// For messages; may be null.
    pub name: *const c_char,
    /// Texels.
    pub width: u32,
    /// Texels.
    pub height: u32,
    /// width * height * 4 bytes: red, green, blue, alpha.
    pub rgba8: *const u8,
    /// Null, or a KTX 2.0 file in memory, which is taken instead of all but the name.
    pub ktx2: *const u8,
    /// Bytes of that file.
    pub ktx2_bytes: usize,
}

/// What lies beyond a picture's edges.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OntileWrap {
    /// The picture again.
    Repeat = 0,
    /// The picture again, every other time mirrored.
    MirroredRepeat = 1,
    /// Its edge.
    ClampToEdge = 2,
}

/// How mip levels are used.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OntileMips {
    /// Level 0 alone.
    None = 0,
    /// The nearest.
    Nearest = 1,
    /// Two are blended.
    Linear = 2,
}

/// A picture and how it is sampled.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct OntileTexture {
    /// Of an image.
    pub image: OntileId,
    /// Linear, else nearest.
    pub mag_linear: bool,
    /// Likewise.
    pub min_linear: bool,
    /// An OntileMips.
    pub mips: u32,
    /// An OntileWrap, along u.
    pub wrap_u: u32,
    /// An OntileWrap, along v.
    pub wrap_v: u32,
    /// Samples where a pixel covers a long, narrow part of the picture: 16 at most; 0 and 1 are none.
    pub max_anisotropy: u8,
}

/// A placement of a mesh.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct OntileInstance {
    /// Of a mesh.
    pub mesh: OntileId,
    /// Affine, column by column.
    pub world_from_object: [f32; 16],
    /// It will move: nothing that depends on its place is kept.
    pub dynamic: bool,
    /// As if it were not there.
    pub hidden: bool,
}

/// What a light is.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OntileLightKind {
    /// Infinitely far; intensity in lux.
    Directional = 0,
    /// Alike in all directions; intensity in candela.
    Point = 1,
    /// Within a cone; intensity in candela.
    Spot = 2,
    /// Directional, within a box; intensity in lux.
    Box = 3,
    /// From all around, above another than below; intensity in lux.
    Hemisphere = 4,
}

/// How a light casts shadows.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OntileShadow {
    /// Not at all.
    None = 0,
    /// As the options say.
    Default = 1,
    /// By its part of the shadow map.
    Map = 2,
    /// By counting volumes in the stencil, where that can be.
    Volume = 3,
}

/// A light. ontile_light_default gives a white one of no intensity.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct OntileLight {
    /// For messages; may be null.
    pub name: *const c_char,
    /// An OntileLightKind.
    pub kind: u32,
    /// Linear Rec.709.
    pub color: [f32; 3],
    /// What surfaces get that face away; a hemisphere's ground.
    pub back_color: [f32; 3],
    /// Lux or candela, as the kind says.
    pub intensity: f32,
    /// World space, metres.
    pub position: [f32; 3],
    /// World space: the way the light travels.
    pub direction: [f32; 3],
    /// Metres; 0 has no end.
    pub range: f32,
    /// Radians from a spot's axis: full intensity within.
    pub inner_cone: f32,
    /// Radians from a spot's axis: dark outside.
    pub outer_cone: f32,
    /// A box's extent along the light's X, Y and Z, metres.
    pub box_size: [f32; 3],
    /// A box's light fades over this distance inside each face, metres.
    pub box_falloff: f32,
    /// An OntileShadow.
    pub shadow: u32,
    /// It may change from frame to frame: nothing of it is kept.
    pub dynamic: bool,
    /// Those of higher priority get their shadows first.
    pub priority: f32,
}

/// A box that paints a material over what lies in it.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct OntileDecal {
    /// Of a material.
    pub material: OntileId,
    /// Turns the cube from -0.5 to 0.5 into the box, column by column; it projects along its -Z.
    pub world_from_decal: [f32; 16],
    /// How much is painted of base colour, normal, roughness and metallicness: 0 to 1.
    pub channels: [f32; 4],
    /// Metres inside the faces across X, Y and Z within which it fades.
    pub falloff: [f32; 3],
    /// Those of lower priority are painted first.
    pub priority: f32,
}

/// A square that faces the camera and adds light.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct OntileParticle {
    /// Its middle, world space, metres.
    pub position: [f32; 3],
    /// Its side, metres.
    pub size: f32,
    /// Counter-clockwise on the image, radians.
    pub rotation: f32,
    /// Multiplies the material's emission; linear Rec.709.
    pub color: [f32; 3],
}

/// Particles of one material.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct OntileParticles {
    /// For messages; may be null.
    pub name: *const c_char,
    /// Of a material, whose emission is what they add.
    pub material: OntileId,
    /// They fade where something opaque is no farther behind them, metres.
    pub soft: f32,
    /// How many there are.
    pub count: usize,
    /// May be null where there are none.
    pub particles: *const OntileParticle,
    /// How many there may be later without anything being made anew; what is less than count counts as count.
    pub most: usize,
}

/// How view space becomes an image.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OntileProjection {
    /// Pinhole.
    Perspective = 0,
    /// Parallel.
    Orthographic = 1,
}

/// A view point.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct OntileCamera {
    /// Rigid, column by column: it looks along its -Z, +Y is up.
    pub world_from_view: [f32; 16],
    /// An OntileProjection.
    pub projection: u32,
    /// Perspective: vertical field of view, radians. Orthographic: half the height, metres.
    pub vertical: f32,
    /// Metres.
    pub z_near: f32,
    /// Metres; of a perspective 0 is infinite.
    pub z_far: f32,
}
