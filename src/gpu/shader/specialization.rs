//! Specialisation constants: what a pipeline knows when it is compiled.

mod decals;
mod shadow_filter;

use glam::Vec3;

use super::post_constants::curve;
use super::{KIND_COUNT, shared};
use crate::plan::{
    Around, BloomWay, Brdf, DepthStore, Form, GBuffer, Gamma, Normals, ResolveWay, ShadowFilter, Tonemap,
};
use crate::scene::Fog;

pub use decals::DecalConstants;
use shadow_filter::shadow_filter;

/// Values for specialisation constants: `data[i]` is that of constant `ids[i]`.
///
/// Every constant is 32 bits wide (a bool is 0 or 1, a float its bits), so the i-th begins at byte `4 * i` of `data`. Ids that a
/// module does not have are without effect.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Specialization {
    /// Constant ids.
    pub ids: Vec<u32>,
    /// Values; signed ones in two's complement.
    pub data: Vec<u32>,
}

impl Specialization {
    /// Both sets of constants.
    pub fn and(mut self, other: Self) -> Self {
        self.ids.extend(other.ids);
        self.data.extend(other.data);
        self
    }

    /// The constant of [`super::Module::LightVolume`]: one of the numbers `VOLUME_*` of `glsl/shared.h`.
    pub fn volume(shape: u32) -> Self {
        Self::from_pairs(&[(const { shared("ID_VOLUME_SHAPE") }, shape)])
    }

    /// The constant of all modules that evaluate reflection.
    pub fn brdf(brdf: Brdf) -> Self {
        let value = match brdf {
            Brdf::Exact => const { shared("BRDF_EXACT") },
            Brdf::Fitted => const { shared("BRDF_FITTED") },
            Brdf::Mediump => const { shared("BRDF_MEDIUMP") },
        };
        Self::from_pairs(&[(const { shared("ID_BRDF") }, value)])
    }

    pub(super) fn from_pairs(pairs: &[(u32, u32)]) -> Self {
        Self {
            ids: pairs.iter().map(|(id, _)| *id).collect(),
            data: pairs.iter().map(|(_, value)| *value).collect(),
        }
    }
}

/// How a material samples one kind of texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TextureSlot {
    /// Index into the material's descriptors.
    pub slot: u32,
    /// Whether TEXCOORD_1 is used instead of TEXCOORD_0.
    pub second_texcoord: bool,
    /// Whether the texture coordinate is transformed.
    pub transformed: bool,
}

/// Constants of the modules that draw surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GeometryConstants {
    /// Base colour, metallic-roughness, normal, occlusion, emissive: those that the material has.
    pub textures: [Option<TextureSlot>; KIND_COUNT],
    /// Fragments below the alpha cutoff are discarded.
    pub alpha_mask: bool,
    /// The normals of back faces are reversed.
    pub double_sided: bool,
    /// The base colour is the light; nothing is left to be lit.
    pub unlit: bool,
    /// The base colour is multiplied by the vertex colour.
    pub vertex_color: bool,
    /// The surface emits light.
    pub emissive: bool,
    /// What arrives from all around; nothing without a light target.
    pub around: Around,
    /// Radiance is stored as RGBM.
    pub rgbm: bool,
    /// Beside probes the scene has an environment.
    pub has_environment: bool,
    /// Whether a lightmap brings the diffuse light, and how.
    pub lightmap: Option<LightmapConstants>,
    /// The light is laid over what is behind.
    pub blend: bool,
}

/// How a lightmap is stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightmapConstants {
    /// Irradiance in lux of the decoded value 1.
    pub unit_lx: f32,
    /// Irradiance is stored as RGBM.
    pub rgbm: bool,
}

impl GeometryConstants {
    /// The number of descriptors: one more than the highest slot, at least 1 (what the array is declared with where
    /// a module has one).
    pub fn texture_count(&self) -> u32 {
        self.textures.iter().flatten().map(|t| t.slot + 1).max().unwrap_or(1)
    }

    /// As ids and values.
    pub fn specialization(&self) -> Specialization {
        let bits = |wanted: fn(&TextureSlot) -> bool| {
            (0..KIND_COUNT)
                .filter(|&kind| self.textures[kind].as_ref().is_some_and(wanted))
                .fold(0, |bits, kind| bits | 1 << kind)
        };
        let slot = |kind: u32| self.textures[kind as usize].map_or(-1_i32 as u32, |t| t.slot);
        Specialization::from_pairs(&[
            (const { shared("ID_TEXTURE_COUNT") }, self.texture_count()),
            (const { shared("ID_SLOT_BASE_COLOR") }, slot(const { shared("KIND_BASE_COLOR") })),
            (
                const { shared("ID_SLOT_METALLIC_ROUGHNESS") },
                slot(const { shared("KIND_METALLIC_ROUGHNESS") }),
            ),
            (const { shared("ID_SLOT_NORMAL") }, slot(const { shared("KIND_NORMAL") })),
            (const { shared("ID_SLOT_OCCLUSION") }, slot(const { shared("KIND_OCCLUSION") })),
            (const { shared("ID_SLOT_EMISSIVE") }, slot(const { shared("KIND_EMISSIVE") })),
            (const { shared("ID_TEXCOORD_BITS") }, bits(|t| t.second_texcoord)),
            (const { shared("ID_TRANSFORM_BITS") }, bits(|t| t.transformed)),
            (const { shared("ID_ALPHA_MASK") }, self.alpha_mask.into()),
            (const { shared("ID_DOUBLE_SIDED") }, self.double_sided.into()),
            (const { shared("ID_UNLIT") }, self.unlit.into()),
            (const { shared("ID_BLEND") }, self.blend.into()),
            (const { shared("ID_VERTEX_COLOR") }, self.vertex_color.into()),
            (const { shared("ID_EMISSIVE") }, self.emissive.into()),
            (const { shared("ID_AMBIENT") }, (self.around >= Around::Ambient).into()),
            (const { shared("ID_ENVIRONMENT") }, (self.around >= Around::Environment).into()),
            (const { shared("ID_RGBM") }, self.rgbm.into()),
            (const { shared("ID_PROBES") }, (self.around >= Around::Probes).into()),
            (const { shared("ID_HAS_ENVIRONMENT") }, self.has_environment.into()),
            (const { shared("ID_LIGHTMAP") }, self.lightmap.is_some().into()),
            (const { shared("ID_LIGHTMAP_UNIT") }, self.lightmap.map_or(0.0, |map| map.unit_lx).to_bits()),
            (const { shared("ID_LIGHTMAP_RGBM") }, self.lightmap.is_some_and(|map| map.rgbm).into()),
        ])
    }
}

/// The lights that a pixel looks at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum LightLoop {
    /// All.
    #[default]
    All,
    /// Those that shine everywhere and those in the list of its cluster.
    Cluster,
    /// The one that is drawn.
    One,
}

/// Constants of the modules that shade surfaces by lights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightingConstants {
    /// Which lights a pixel looks at.
    pub scan: LightLoop,
    /// The scene has directional lights.
    pub has_directional: bool,
    /// The scene has point lights.
    pub has_point: bool,
    /// The scene has spot lights.
    pub has_spot: bool,
    /// The scene has box lights.
    pub has_box: bool,
    /// The scene has hemisphere lights.
    pub has_hemisphere: bool,
    /// Some directional or box light has a back colour.
    pub has_back: bool,
    /// Some light shines through a globe map.
    pub globe_maps: bool,
    /// How shadow maps are sampled, where lights have them.
    pub shadow_filter: Option<ShadowFilter>,
    /// Lights with shadow volumes are left out.
    pub shadow_volumes: bool,
    /// Lighting writes the output itself, as [`OutputConstants`] say; else it adds to the light target.
    pub fold: bool,
}

impl LightingConstants {
    /// For lights that shine everywhere alone; globe maps are of others.
    pub fn only_global(self, shadows: bool) -> Self {
        let shadow_filter = self.shadow_filter.filter(|_| shadows);
        Self { has_point: false, has_spot: false, has_box: false, globe_maps: false, shadow_filter, ..self }
    }

    /// For one light that has a place.
    pub fn one_local(self, shadows: bool) -> Self {
        let shadow_filter = self.shadow_filter.filter(|_| shadows);
        Self { scan: LightLoop::One, has_directional: false, has_hemisphere: false, shadow_filter, ..self }
    }

    /// For one light of any kind, whose shadow was counted.
    pub fn one_counted(self) -> Self {
        Self {
            scan: LightLoop::One,
            has_box: false,
            has_hemisphere: false,
            shadow_filter: None,
            shadow_volumes: false,
            ..self
        }
    }

    /// Whether there are lights that are listed in a buffer: all but hemispheres.
    pub fn has_listed(self) -> bool {
        self.has_directional || self.has_point || self.has_spot || self.has_box
    }

    /// As ids and values.
    pub fn specialization(&self) -> Specialization {
        Specialization::from_pairs(&[
            (const { shared("ID_CLUSTERS") }, (self.scan == LightLoop::Cluster).into()),
            (const { shared("ID_ONE_LIGHT") }, (self.scan == LightLoop::One).into()),
            (const { shared("ID_HAS_DIRECTIONAL") }, self.has_directional.into()),
            (const { shared("ID_HAS_POINT") }, self.has_point.into()),
            (const { shared("ID_HAS_SPOT") }, self.has_spot.into()),
            (const { shared("ID_HAS_BOX") }, self.has_box.into()),
            (const { shared("ID_HAS_HEMISPHERE") }, self.has_hemisphere.into()),
            (const { shared("ID_HAS_BACK") }, self.has_back.into()),
            (const { shared("ID_GLOBE_MAPS") }, self.globe_maps.into()),
            (const { shared("ID_SHADOWS") }, self.shadow_filter.is_some().into()),
            (const { shared("ID_SHADOW_FILTER") }, self.shadow_filter.map_or(0, shadow_filter)),
            (const { shared("ID_SHADOW_VOLUMES") }, self.shadow_volumes.into()),
            (const { shared("ID_FOLD") }, self.fold.into()),
        ])
    }
}

/// Constants of the modules that write or read a G-buffer or a light target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GBufferConstants {
    /// Whether there is a G-buffer at all.
    pub exists: bool,
    /// What it consists of.
    pub form: Form,
    /// Whether depth has a colour target.
    pub depth_target: bool,
    /// How normals are encoded.
    pub normals: Normals,
    /// How colours are encoded.
    pub gamma: Gamma,
    /// There is a light target.
    pub light_target: bool,
    /// Surfaces and background are told apart by the light target's alpha.
    pub light_alpha: bool,
    /// Light is in the G-buffer.
    pub light_read: bool,
    /// Lights are added to it one by one.
    pub light_added: bool,
    /// Geometry leaves occlusion to lighting.
    pub occlusion: bool,
}

impl GBufferConstants {
    /// Without light that exists before lighting.
    pub fn new(gbuffer: &GBuffer) -> Self {
        Self {
            exists: true,
            form: gbuffer.form,
            depth_target: gbuffer.depth == DepthStore::R32f,
            normals: gbuffer.normals,
            gamma: gbuffer.gamma,
            light_target: false,
            light_alpha: true,
            light_read: false,
            light_added: false,
            occlusion: false,
        }
    }

    /// As ids and values.
    pub fn specialization(&self) -> Specialization {
        let form = match self.form {
            Form::Metallic => const { shared("FORM_METALLIC") },
            Form::Specular => const { shared("FORM_SPECULAR") },
            Form::Thibieroz128 => const { shared("FORM_THIBIEROZ128") },
            Form::Thibieroz96 => const { shared("FORM_THIBIEROZ96") },
            Form::Rasa128 => const { shared("FORM_RASA128") },
            Form::Dissertation192 => const { shared("FORM_DISSERTATION192") },
            Form::Metallic256 => const { shared("FORM_METALLIC256") },
            Form::Specular256 => const { shared("FORM_SPECULAR256") },
            Form::Packed128 => const { shared("FORM_PACKED128") },
        };
        let normals = match self.normals {
            Normals::Xyz8 => const { shared("NORMALS_XYZ") },
            Normals::Oct8 => const { shared("NORMALS_OCTAHEDRAL_8") },
            Normals::Oct10 => const { shared("NORMALS_OCTAHEDRAL_10") },
            Normals::Oct12 => const { shared("NORMALS_OCTAHEDRAL_12") },
            Normals::Oct16 => const { shared("NORMALS_OCTAHEDRAL_16") },
            Normals::Sphere12 => const { shared("NORMALS_SPHEREMAP_12") },
            Normals::View12 => const { shared("NORMALS_VIEW_12") },
            Normals::Float => const { shared("NORMALS_FLOAT") },
        };
        let gamma = match self.gamma {
            Gamma::Srgb | Gamma::Linear | Gamma::Float => const { shared("GAMMA_BY_FORMAT") },
            Gamma::Power22 => const { shared("GAMMA_2_2") },
            Gamma::Power20 => const { shared("GAMMA_2_0") },
        };
        Specialization::from_pairs(&[
            (const { shared("ID_GBUFFER") }, self.exists.into()),
            (const { shared("ID_FORM") }, form),
            (const { shared("ID_DEPTH_TARGET") }, self.depth_target.into()),
            (const { shared("ID_NORMALS") }, normals),
            (const { shared("ID_GAMMA") }, gamma),
            (const { shared("ID_LIGHT_TARGET") }, self.light_target.into()),
            (const { shared("ID_LIGHT_ALPHA") }, self.light_alpha.into()),
            (const { shared("ID_LIGHT_READ") }, self.light_read.into()),
            (const { shared("ID_LIGHT_ADDED") }, self.light_added.into()),
            (const { shared("ID_OCCLUSION_TARGET") }, self.occlusion.into()),
        ])
    }
}

/// Constants of modules that read several samples a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleConstants {
    /// How many.
    pub samples: u32,
    /// A fragment is a sample; else a pixel.
    pub per_sample: bool,
    /// Geometry says where triangles cover only some samples.
    pub edge_target: bool,
    /// Some surfaces have alpha masks.
    pub edge_masks: bool,
    /// Depth is that of the depth attachment, of each sample; else that of the pixel's centre.
    pub sample_depth: bool,
    /// What the tone curve is applied to.
    pub resolve: ResolveWay,
}

impl SampleConstants {
    /// As ids and values.
    pub fn specialization(&self) -> Specialization {
        Specialization::from_pairs(&[
            (const { shared("ID_SAMPLE_COUNT") }, self.samples),
            (const { shared("ID_PER_SAMPLE") }, self.per_sample.into()),
            (const { shared("ID_EDGE_TARGET") }, self.edge_target.into()),
            (const { shared("ID_EDGE_MASKS") }, self.edge_masks.into()),
            (const { shared("ID_SAMPLE_DEPTH") }, self.sample_depth.into()),
            (const { shared("ID_RESOLVE_PLAIN") }, (self.resolve == ResolveWay::Plain).into()),
        ])
    }
}

/// Constants of [`super::Module::Sky`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkyConstants {
    /// Radiance is stored as RGBM.
    pub rgbm: bool,
    /// There are probes beside the environment.
    pub probes: bool,
}

impl SkyConstants {
    /// As ids and values.
    pub fn specialization(&self) -> Specialization {
        Specialization::from_pairs(&[
            (const { shared("ID_RGBM") }, self.rgbm.into()),
            (const { shared("ID_PROBES") }, self.probes.into()),
        ])
    }
}

/// Constants of the modules that write the output: [`super::Module::Tonemap`], [`super::Module::Unlit`],
/// [`super::Module::Forward`] and folded [`super::Module::Lighting`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutputConstants {
    /// Tone curve.
    pub tonemap: Tonemap,
    /// Ordered noise of half an 8-bit sRGB step either way; it also clamps to [0, 1], so it is for such outputs only.
    pub dither: bool,
    /// The output holds floats of any size.
    pub float: bool,
    /// A colour where no surface is, as linear display light.
    pub background: Option<[f32; 3]>,
    /// Fog before surfaces.
    pub fog: Option<Fog>,
    /// Light's alpha says how much of the background is covered, not only whether.
    pub translucency: bool,
    /// Whether scattered light is mixed in, and what is to be scattered stored.
    pub bloom: BloomWay,
}

impl OutputConstants {
    /// As ids and values.
    pub fn specialization(&self) -> Specialization {
        let [red, green, blue] = self.background.unwrap_or_default().map(f32::to_bits);
        let fog = self.fog.unwrap_or(Fog { color_nt: Vec3::ZERO, density_per_m: 0.0, height: None });
        let (base_m, inverse_height) = fog.height.map_or((0.0, 0.0), |h| (h.base_m, h.scale_m.recip()));
        Specialization::from_pairs(&[
            (const { shared("ID_TONEMAP") }, curve(self.tonemap)),
            (const { shared("ID_DITHER") }, self.dither.into()),
            (const { shared("ID_FLOAT_OUTPUT") }, self.float.into()),
            (const { shared("ID_BACKGROUND") }, self.background.is_some().into()),
            (const { shared("ID_BACKGROUND_RED") }, red),
            (const { shared("ID_BACKGROUND_GREEN") }, green),
            (const { shared("ID_BACKGROUND_BLUE") }, blue),
            (const { shared("ID_TRANSLUCENCY") }, self.translucency.into()),
            (const { shared("ID_FOG") }, self.fog.is_some().into()),
            (const { shared("ID_FOG_RED") }, fog.color_nt.x.to_bits()),
            (const { shared("ID_FOG_GREEN") }, fog.color_nt.y.to_bits()),
            (const { shared("ID_FOG_BLUE") }, fog.color_nt.z.to_bits()),
            (const { shared("ID_FOG_DENSITY") }, fog.density_per_m.to_bits()),
            (const { shared("ID_FOG_BASE") }, base_m.to_bits()),
            (const { shared("ID_FOG_INVERSE_HEIGHT") }, inverse_height.to_bits()),
            (const { shared("ID_BLOOM") }, (self.bloom != BloomWay::Off).into()),
            (const { shared("ID_BLOOM_STORED") }, (self.bloom == BloomWay::Store).into()),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn textures_become_slots_and_bits() {
        let texture =
            |slot, second_texcoord, transformed| Some(TextureSlot { slot, second_texcoord, transformed });
        let constants = GeometryConstants {
            textures: [texture(0, false, true), None, texture(2, true, false), texture(1, true, true), None],
            ..Default::default()
        };
        let Specialization { ids, data } = constants.specialization();
        let value = |id| data[ids.iter().position(|i| *i == id).unwrap()];
        assert_eq!(value(shared("ID_TEXTURE_COUNT")), 3);
        assert_eq!(value(shared("ID_SLOT_BASE_COLOR")), 0);
        assert_eq!(value(shared("ID_SLOT_METALLIC_ROUGHNESS")) as i32, -1);
        assert_eq!(value(shared("ID_SLOT_NORMAL")), 2);
        assert_eq!(value(shared("ID_SLOT_OCCLUSION")), 1);
        assert_eq!(value(shared("ID_SLOT_EMISSIVE")) as i32, -1);
        assert_eq!(value(shared("ID_TEXCOORD_BITS")), 0b01100);
        assert_eq!(value(shared("ID_TRANSFORM_BITS")), 0b01001);
    }
}
