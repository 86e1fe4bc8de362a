//! Lights: KHR_lights_punctual, and what `extras` add to it.
//!
//! | `extras.ontile` | on | value | without it |
//! |---|---|---|---|
//! | `shadow` | all but hemispheres | `true`, `false`, or `{"spread_texels": 0 to 12, "bias_texels": 0 to 64, "volume": true or false}` ([`Shadow`]) | `true` |
//! | `dynamic` | all | `true` or `false`; nodes below have it too ([`Light::dynamic`]) | `false` |
//! | `baked` | all | `true` or `false` ([`Light::baked`]) | `false` |
//! | `priority` | all | number ([`Light::priority`]) | 0 |
//! | `back_color` | directional | `[r, g, b]`, linear: a second light from behind ([`Light::back_color`]) | none |
//! | `ground_color` | directional | `[r, g, b]`, linear: makes it a hemisphere, which occlusion textures do not dim ([`LightKind::Hemisphere`]) | none |
//! | `box` | directional | `{"size": [x, y, z], "falloff": number}`, metres along the node's axes, its scale ignored: makes it a box around the node ([`LightKind::Box`]) | none; falloff 0 |
//! | `globe_map` | spot, box | `{"texture": index, "rotation": degrees}` ([`GlobeMap`]) | none; rotation 0 |
//! | `globe_map` | point | `{"textures": [+X, -X, +Y, -Y, +Z, -Z], "rotation": degrees}` | none; rotation 0 |
//!
//! They may stand in the node's extras and in the light's own; where both have one, the node's counts. Of textures the
//! image is used, not the sampler.

use glam::{DVec3, Vec3};
use gltf::json::extensions::scene::khr_lights_punctual as punctual;

use super::document::Document;
use super::extras::{Extra, Extras, OF_NODES};
use super::material::Materials;
use super::node::NodeTree;
use crate::Result;
use crate::scene::light::up_of;
use crate::scene::{GlobeMap, GlobePicture, Light, LightKind, Shadow};

const LIST: &str = "extensions.KHR_lights_punctual.lights";

/// The drawn nodes that have a light, in the order of [`read_lights`].
pub fn nodes<'a>(doc: &'a Document, tree: &'a NodeTree) -> impl Iterator<Item = usize> + 'a {
    let has_light =
        |i: &&usize| doc.root.nodes[**i].extensions.as_ref().is_some_and(|e| e.khr_lights_punctual.is_some());
    tree.drawn.iter().filter(has_light).copied()
}

/// The lights of the drawn nodes.
pub fn read_lights(doc: &Document, tree: &NodeTree, materials: &mut Materials) -> Result<Vec<Light>> {
    let defined = doc.root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    let defined = defined.map_or(&[][..], |e| &e.lights);
    let mut lights = Vec::new();
    for &i in &tree.drawn {
        let node = &doc.root.nodes[i];
        let Some(used) = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref()) else {
            continue;
        };
        let index = used.light;
        let json =
            doc.get(defined, LIST, index, format!("nodes[{i}].extensions.KHR_lights_punctual.light"))?;
        let elements =
            [(&json.extras, format!("{LIST}[{}]", index.value())), (&node.extras, format!("nodes[{i}]"))];
        let extras = Extras::read(doc, &elements, &OF_NODES)?;
        let kind = with_extent(light_kind(doc, json, index.value())?, &extras)?;
        let world = &tree.world_from_node[i];
        let direction = -world.z_axis.truncate();
        let direction = match (direction.try_normalize(), kind) {
            (Some(direction), _) => direction,
            (None, LightKind::Point { .. }) => DVec3::NEG_Z,
            (None, _) => {
                let problem = "has a light, but its scale of 0 leaves no direction to shine in";
                let remedy = "give the node a scale other than 0";
                return Err(doc.bad(format!("nodes[{i}]"), problem, remedy));
            }
        };
        let name = json.name.clone().or_else(|| node.name.clone());
        let light = Light {
            name: name.unwrap_or_else(|| format!("light {}", index.value())),
            color: Vec3::from_array(json.color),
            back_color: back_color(kind, &extras)?,
            position_world: world.w_axis.truncate().as_vec3(),
            direction_world: direction.as_vec3(),
            up_world: up_of(direction, world.y_axis.truncate()).as_vec3(),
            range_m: json.range.filter(|_| matches!(kind, LightKind::Point { .. } | LightKind::Spot { .. })),
            globe_map: globe_map(kind, &extras, materials)?,
            shadow: shadow(kind, &extras)?,
            dynamic: tree.dynamic[i] || extras.get("dynamic").map_or(Ok(false), Extra::bool)?,
            baked: extras.get("baked").map_or(Ok(false), Extra::bool)?,
            priority: extras.number_or("priority", 0.0, "", |_| true)?,
            ..Light::new(kind)
        };
        let brightest = light.color.max(light.back_color) * light.intensity();
        if !brightest.is_finite() {
            let problem = format!("times colour is {brightest}, which exceeds what f32 can hold");
            return Err(doc.bad(format!("{LIST}[{}].intensity", index.value()), problem, "dim the light"));
        }
        lights.push(light);
    }
    Ok(lights)
}

fn not_negative(v: f32) -> bool {
    v >= 0.0
}

/// Boxes and hemispheres are directional lights to those who do not know better.
fn with_extent(kind: LightKind, extras: &Extras) -> Result<LightKind> {
    let (ground, bounds) = (extras.get("ground_color"), extras.get("box"));
    let LightKind::Directional { illuminance_lx } = kind else {
        return match ground.or(bounds) {
            Some(extra) => Err(extra.bad("is for directional lights", "make the light directional")),
            None => Ok(kind),
        };
    };
    match (ground, bounds) {
        (Some(extra), Some(_)) => Err(extra.bad("a hemisphere has no box", "remove ground_color or box")),
        (Some(_), None) => Ok(LightKind::Hemisphere { illuminance_lx }),
        (None, None) => Ok(kind),
        (None, Some(extra)) => {
            let bounds = extra.object(&["size", "falloff"])?;
            let Some(size) = bounds.get("size") else {
                return Err(extra.bad("has no size", "add \"size\": [x, y, z] in metres"));
            };
            Ok(LightKind::Box {
                illuminance_lx,
                size_m: size.numbers::<3>(" above 0", |v| v > 0.0)?.into(),
                falloff_m: bounds.number_or("falloff", 0.0, " of at least 0", not_negative)?,
            })
        }
    }
}

fn back_color(kind: LightKind, extras: &Extras) -> Result<Vec3> {
    let is_hemisphere = matches!(kind, LightKind::Hemisphere { .. });
    let color = |extra: &Extra| Ok(extra.numbers::<3>(" of at least 0", not_negative)?.into());
    match (extras.get("back_color"), kind) {
        (None, _) if is_hemisphere => extras.get("ground_color").map_or(Ok(Vec3::ZERO), color),
        (None, _) => Ok(Vec3::ZERO),
        (Some(extra), LightKind::Directional { .. } | LightKind::Box { .. }) => color(extra),
        (Some(extra), _) if is_hemisphere => {
            Err(extra.bad("of a hemisphere is its ground_color", "remove back_color or ground_color"))
        }
        (Some(extra), _) => Err(extra.bad("is for directional lights", "remove it")),
    }
}

fn shadow(kind: LightKind, extras: &Extras) -> Result<Option<Shadow>> {
    let is_hemisphere = matches!(kind, LightKind::Hemisphere { .. });
    let Some(extra) = extras.get("shadow") else { return Ok((!is_hemisphere).then(Shadow::default)) };
    let shadow = match extra.as_bool() {
        Some(on) => on.then(Shadow::default),
        None => {
            let numbers = extra.object(&["spread_texels", "bias_texels", "volume"])?;
            let default = Shadow::default();
            let spread = |n| (0.0..=Shadow::MOST_SPREAD_TEXELS).contains(&n);
            let bias = |n| (0.0..=Shadow::MOST_BIAS_TEXELS).contains(&n);
            Some(Shadow {
                spread_texels: numbers.number_or(
                    "spread_texels",
                    default.spread_texels,
                    " from 0 to 12",
                    spread,
                )?,
                bias_texels: numbers.number_or("bias_texels", default.bias_texels, " from 0 to 64", bias)?,
                volume: numbers.get("volume").map(Extra::bool).transpose()?,
            })
        }
    };
    if shadow.is_some() && is_hemisphere {
        return Err(extra.bad("a hemisphere casts no shadows", "remove it"));
    }
    Ok(shadow)
}

fn globe_map(kind: LightKind, extras: &Extras, materials: &mut Materials) -> Result<Option<GlobeMap>> {
    let Some(extra) = extras.get("globe_map") else { return Ok(None) };
    let image = match kind {
        LightKind::Spot { .. } | LightKind::Box { .. } => "texture",
        LightKind::Point { .. } => "textures",
        LightKind::Directional { .. } | LightKind::Hemisphere { .. } => {
            let problem = "is for spot, box and point lights: others have no place to put it";
            return Err(extra.bad(problem, "remove it, or give a directional light a box"));
        }
    };
    let map = extra.object(&[image, "rotation"])?;
    let Some(textures) = map.get(image) else {
        return Err(extra.bad(format!("has no {image}"), format!("add \"{image}\"")));
    };
    let doc = extra.doc();
    let picture = match image {
        "texture" => {
            let image = materials.use_image(doc, textures.index()?, textures.element())?;
            GlobePicture::Flat { image }
        }
        _ => {
            let mut images = [0; 6];
            for (image, (index, element)) in images.iter_mut().zip(textures.indices::<_, 6>()?) {
                *image = materials.use_image(doc, index, &element)?;
            }
            GlobePicture::Cube { images }
        }
    };
    let rotation = map.number_or("rotation", 0.0, " of degrees", |_| true)?;
    Ok(Some(GlobeMap { picture, rotation_rad: rotation.to_radians() }))
}

/// The kind, with all values of the light checked.
fn light_kind(doc: &Document, light: &punctual::Light, index: usize) -> Result<LightKind> {
    let check = |holds: bool, field: &str, problem: String| match holds {
        true => Ok(()),
        false => Err(doc.bad(format!("{LIST}[{index}].{field}"), problem, "correct the light")),
    };
    let fine = |v: f32| v.is_finite() && v >= 0.0;
    let intensity = light.intensity;
    check(
        light.color.iter().all(|&c| fine(c)),
        "color",
        format!("{:?} must be finite and not negative", light.color),
    )?;
    check(fine(intensity), "intensity", format!("is {intensity}, but must be finite and not negative"))?;
    if let Some(range) = light.range {
        check(fine(range) && range > 0.0, "range", format!("is {range}, but must be finite and above 0"))?;
    }
    let type_ = doc.valid(light.type_, format!("{LIST}[{index}].type"))?;
    Ok(match type_ {
        punctual::Type::Directional => LightKind::Directional { illuminance_lx: intensity },
        punctual::Type::Point => LightKind::Point { intensity_cd: intensity },
        punctual::Type::Spot => {
            let spot = light.spot.as_ref();
            check(spot.is_some(), "spot", "is missing".into())?;
            let (inner, outer) =
                spot.map_or((0.0, std::f32::consts::FRAC_PI_4), |s| (s.inner_cone_angle, s.outer_cone_angle));
            check(
                0.0 <= inner && inner < outer && outer <= std::f32::consts::FRAC_PI_2,
                "spot",
                format!("its cones are {inner} and {outer}, but 0 <= inner < outer <= pi / 2 must hold"),
            )?;
            LightKind::Spot { intensity_cd: intensity, inner_cone_rad: inner, outer_cone_rad: outer }
        }
    })
}
