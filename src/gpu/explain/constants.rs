//! Why pipelines are specialised.

use super::elements::Elements;
use crate::scene::LightKind;

/// Of numbers with a fraction: these names' values are bits of floats.
const FLOATS: &[&str] = &[
    "BACKGROUND_RED",
    "BACKGROUND_GREEN",
    "BACKGROUND_BLUE",
    "FOG_RED",
    "FOG_GREEN",
    "FOG_BLUE",
    "FOG_DENSITY",
    "FOG_BASE",
    "FOG_INVERSE_HEIGHT",
    "LIGHTMAP_UNIT",
];

/// A constant's value as people read it.
pub(super) fn shown(name: &str, value: u32) -> String {
    match FLOATS.contains(&name) {
        true => f32::from_bits(value).to_string(),
        false => (value as i32).to_string(),
    }
}

impl Elements<'_> {
    /// The reason for a constant of a pipeline that exists for `element`.
    pub(super) fn constant(&self, name: &str, value: u32, element: &str) -> String {
        let options = &self.plan.options;
        let has = |what: &str| format!("{element} has {what}");
        let is = |what: &str| format!("{element} is {what}");
        let by = |wanted: fn(&LightKind) -> bool| self.light(|light| wanted(&light.kind));
        match name {
            "TEXTURE_COUNT" => has(&format!("{value} textures")),
            "SLOT_BASE_COLOR" => has("a base colour texture"),
            "SLOT_METALLIC_ROUGHNESS" => has("a metallic-roughness texture"),
            "SLOT_NORMAL" => has("a normal texture"),
            "SLOT_OCCLUSION" => format!("{} and {}", has("an occlusion texture"), self.around()),
            "SLOT_EMISSIVE" => has("an emissive texture"),
            "TEXCOORD_BITS" => has("a texture at TEXCOORD_1"),
            "TRANSFORM_BITS" => has("a transformed texture"),
            "ALPHA_MASK" => is("cut by an alpha mask"),
            "DOUBLE_SIDED" => is("double-sided"),
            "UNLIT" => is("unlit"),
            "VERTEX_COLOR" => format!("the mesh of {element} has vertex colours"),
            "EMISSIVE" => is("emissive"),
            "COLLECTED" | "LAYER_COUNT" => format!("the option translucency is {}", options.translucency),
            "LAYER_PAIRS" => format!("layers have the words of the G-buffer {}", options.layout),
            "BEHIND_OPAQUE" => format!("the G-buffer {} has depth in the depth attachment", options.layout),
            "HAS_BEHIND" => format!("{element} fade in front of what is opaque"),
            "ABSORBS" => format!("{element} lets through a part of what is behind it"),
            "REFRACTS" => format!("{element} bends light; the option refraction is {}", options.refraction),
            "BLEND" => is("blended over what is behind it"),
            "TRANSLUCENCY" => {
                let over = self.plan.needs.over_light();
                over.map(|first| format!("{first} leaves a part of the background")).unwrap_or_default()
            }
            "HAS_DIRECTIONAL" => by(|kind| matches!(kind, LightKind::Directional { .. })),
            "HAS_POINT" => by(|kind| matches!(kind, LightKind::Point { .. })),
            "HAS_SPOT" => by(|kind| matches!(kind, LightKind::Spot { .. })),
            "HAS_BOX" => by(|kind| matches!(kind, LightKind::Box { .. })),
            "HAS_HEMISPHERE" => by(|kind| matches!(kind, LightKind::Hemisphere { .. })),
            "HAS_BACK" => {
                let is_hemisphere = |kind| matches!(kind, LightKind::Hemisphere { .. });
                self.light(|light| light.has_back() && !is_hemisphere(light.kind)) + " has a back colour"
            }
            "CLUSTERS" => format!("the way of lights is {}", self.plan.light_way),
            "ONE_LIGHT" => format!("the way of lights is {}: one at a time", self.plan.light_way),
            "VOLUME_SHAPE" => format!("the shape of {element}"),
            "GLOBE_MAPS" => self.globe_light(),
            "SHADOWS" => self.shadow_lights(),
            "SHADOW_VOLUMES" => self.volume_lights(),
            "SHADOW_FILTER" => {
                format!("{}; the option shadow filter is {}", self.shadow_lights(), options.shadows.filter)
            }
            "FOLD" => "no light exists before lighting, which applies the tone curve itself".into(),
            "LIGHT_TARGET" => match (self.plan.needs.prelit.first(), &self.plan.needs.blended) {
                (Some(prelit), _) => prelit.clone(),
                (None, Some(blended)) => format!("{blended} is blended over it"),
                (None, None) => "light is summed before the tone curve".into(),
            },
            "OCCLUSION_TARGET" => {
                let occluded = self.plan.needs.occlusion.clone().unwrap_or_default();
                format!("{occluded} is occluded, which lighting has to know once decals are painted")
            }
            "AMBIENT" => format!("{element} receives {}", self.around()),
            "ENVIRONMENT" => format!("{element} receives {}", self.around()),
            "PROBES" => format!("{element} receives {}", self.around()),
            "HAS_ENVIRONMENT" => format!("environment '{}' is seen beside probes", self.environment()),
            "RGBM" => format!("radiance is stored as rgbm: {}", self.around()),
            "LIGHTMAP" => format!("{element} has a part of the lightmap"),
            "LIGHTMAP_UNIT" => "the lightmap's unit".into(),
            "LIGHTMAP_RGBM" => format!("the option lightmap format is {}", options.lightmap_format),
            "BRDF" => format!("the option brdf is {}", options.brdf),
            "TONEMAP" => format!("the option tonemap is {}", options.tonemap),
            "DITHER" => "the option dither".into(),
            "BACKGROUND" | "BACKGROUND_RED" | "BACKGROUND_GREEN" | "BACKGROUND_BLUE" => {
                "the scene's background is a colour".into()
            }
            "FOG" | "FOG_RED" | "FOG_GREEN" | "FOG_BLUE" | "FOG_DENSITY" => "the scene has fog".into(),
            "FOG_BASE" | "FOG_INVERSE_HEIGHT" => "the scene's fog gets thinner with height".into(),
            "DECAL_BASE_COLOR" => format!("{element} paints base colour"),
            "DECAL_NORMAL" => format!("{element} paints normals"),
            "DECAL_ROUGHNESS" => format!("{element} paints roughness"),
            "DECAL_METALLIC" => format!("{element} paints metallicness"),
            "DECAL_TARGETS" => "what of the G-buffer the scene's decals change".into(),
            "DECAL_BLENDED" => "decals are mixed by fixed-function blending".into(),
            "FORM" | "DEPTH_TARGET" | "NORMALS" | "GAMMA" | "GBUFFER" | "LIGHT_READ" | "LIGHT_ADDED"
            | "LIGHT_ALPHA" => {
                format!("how the G-buffer {} and the light target store it", options.layout)
            }
            "BLOOM" | "BLOOM_STORED" | "BLOOM_STEP" | "BLOOM_DISPLAYED" => {
                format!("the option bloom is {}", options.bloom)
            }
            "SHOW" | "SHOW_STRIPS" | "SHOW_STRIP_COUNT" | "SHOW_EDGE" => {
                format!("the option show is {}", options.show)
            }
            "DEPTH_STEP" => "the depth that the edge filter samples has steps".into(),
            _ => "asked for by the options".into(),
        }
    }
}
