//! What pairs of features cost beyond what each does, by hand.

use super::listed;
use super::table::Feature;

/// What two features bring that neither has by itself.
struct Joint {
    /// Beginnings of the one's name, and of the other's; none is any.
    of: [&'static [&'static str]; 2],
    /// Beginnings of what they bring together.
    objects: &'static str,
}

const AROUND: &[&str] = &["ambient light", "an environment", "probes"];
const SUMMING: &[&str] = &[
    "emission",
    "ambient light",
    "an environment",
    "probes",
    "a lightmap",
    "an unlit neighbour",
    "a blended neighbour",
    "particles",
    "light that goes through",
    "a shadow volume",
];
const SHADOWED: &str = "lighting: binding shadow, lighting: SHADOWS, image shadow map, buffer shadow views, buffer casters, \
                        pipeline shadow, shadow caster:";

const JOINT: &[Joint] = &[
    // An array of two.
    Joint { of: [&[], &[]], objects: "surface lit: TEXTURE_COUNT, surface unlit: TEXTURE_COUNT" },
    // One has a texture, the other makes it needed.
    Joint {
        of: [&["occlusion without"], AROUND],
        objects: "image picture, surface lit: attribute texture coordinates, surface lit: binding textures, surface lit: SLOT_OCCLUSION",
    },
    Joint {
        of: [&["emissive texture without"], &["emission"]],
        objects: "image picture, surface lit: attribute texture coordinates, surface lit: binding textures, surface lit: SLOT_EMISSIVE",
    },
    // There is something for the shadow to fall on.
    Joint {
        of: [&["a shadow on nothing"], &["second triangle", "an unlit neighbour", "light that goes through"]],
        objects: SHADOWED,
    },
    // What has no volume is in a map.
    Joint {
        of: [&["a shadow volume"], &["light from behind", "a blended neighbour", "light that goes through"]],
        objects: SHADOWED,
    },
    Joint { of: [&["a shadow volume"], &["light from behind"]], objects: "attachment depth_test" },
    // Beside depth, the stencil.
    Joint { of: [&["a shadow volume"], &["particles"]], objects: "particles: input depth_stencil_test" },
    // What is summed is fogged, and tells surfaces from background, afterwards.
    Joint { of: [&["fog"], SUMMING], objects: "tonemap: FOG, tonemap: input depth" },
    Joint { of: [&["background colour"], SUMMING], objects: "tonemap: BACKGROUND" },
    // What is fogged before something is blended over it; and the part of a colour that it covers.
    Joint { of: [&["fog"], &["a blended neighbour"]], objects: "pipeline fog, fog:, blended surface: FOG" },
    Joint {
        of: [&["fog"], &["particles", "light that goes through"]],
        objects: "subpass fog, pipeline fog, fog:, particles: FOG, medium: FOG, medium: input depth_test, medium: HAS_BEHIND",
    },
    Joint {
        of: [&["background colour"], &["a blended neighbour", "particles", "light that goes through"]],
        objects: "tonemap: TRANSLUCENCY",
    },
    // It is lit.
    Joint { of: [&["light that goes through"], &[]], objects: "medium:" },
    // Beyond the boxes.
    // Lighting adds light from all around on what decals have painted.
    Joint {
        of: [&["a colour decal", "a decal"], AROUND],
        objects: "lighting: AMBIENT, lighting: ENVIRONMENT, lighting: PROBES, lighting: HAS_ENVIRONMENT, lighting: binding, \
          attachment occlusion, lighting: OCCLUSION_TARGET, lighting: input occlusion, surface lit: OCCLUSION_TARGET",
    },
    Joint { of: [&["an environment"], &["probes"]], objects: "surface lit: HAS_ENVIRONMENT" },
];

/// Whether two features may bring this together.
pub fn is_joint(features: [&Feature; 2], object: &str) -> bool {
    let begins = |text: &str, all: &[&str]| all.is_empty() || all.iter().any(|begin| text.starts_with(begin));
    let [a, b] = features.map(|feature| feature.name);
    JOINT.iter().filter(|joint| listed(joint.objects).any(|begin| object.starts_with(&begin))).any(|joint| {
        let [one, other] = joint.of;
        (begins(a, one) && begins(b, other)) || (begins(b, one) && begins(a, other))
    })
}
