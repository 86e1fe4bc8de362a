//! What extras say of the scene as a whole, and the part of nodes in its lightmap.
//!
//! | `extras.ontile` of | | value |
//! |---|---|---|
//! | `scenes[i]` | `background` | `"#RRGGBB"` ([`Background::Color`]) or `"environment"` |
//! | `scenes[i]` | `fog` | `{"density": number, "color": [r, g, b], "base": number, "scale": number}`; the last two belong together and may be left out ([`Fog`]) |
//! | `scenes[i]` | `lightmap` | `{"color_image": index, "scale_image": index, "unit_lx": number}` ([`Lightmap`]) |
//! | `nodes[i]` | `lightmap` | `[x, y, width, height]`, texture coordinates ([`LightmapRect`]); `false`: it shall have none |
//! | `nodes[i]` | `dynamic` | `true` or `false`; nodes below have it too ([`Instance::dynamic`](crate::scene::Instance::dynamic)) |

use glam::{Vec2, Vec3};
use gltf::json;

use super::document::Document;
use super::extras::{Extra, Extras};
use super::{image, node, source};
use crate::Result;
use crate::scene::{Background, Fog, FogHeight, Lightmap, LightmapRect};

pub fn read_background(doc: &Document) -> Result<Background> {
    let extras = node::extras_of_scene(doc)?;
    let Some(extra) = extras.get("background") else { return Ok(Background::default()) };
    let text = extra.text()?;
    if text == "environment" {
        return Ok(Background::Environment);
    }
    Background::from_hex(text).ok_or_else(|| {
        let problem = format!("is '{}'", source::shortened(text));
        extra.bad(problem, "write environment, or a colour as six hexadecimal digits: #87ceeb")
    })
}

fn not_negative(v: f32) -> bool {
    v >= 0.0
}

fn needed<'e, 'a>(all: &'e Extras<'a>, whole: &Extra, name: &str) -> Result<&'e Extra<'a>> {
    all.get(name).ok_or_else(|| whole.bad(format!("has no {name}"), "add it"))
}

pub fn read_fog(doc: &Document) -> Result<Option<Fog>> {
    let extras = node::extras_of_scene(doc)?;
    let Some(whole) = extras.get("fog") else { return Ok(None) };
    let fog = whole.object(&["density", "color", "base", "scale"])?;
    let height = match (fog.get("base"), fog.get("scale")) {
        (None, None) => None,
        (Some(base), Some(scale)) => Some(FogHeight {
            base_m: base.number("", |_| true)?,
            scale_m: scale.number(" above 0", |v| v > 0.0)?,
        }),
        (Some(lone), None) | (None, Some(lone)) => {
            return Err(lone.bad("stands alone", "give base and scale, or neither"));
        }
    };
    Ok(Some(Fog {
        color_nt: Vec3::from_array(needed(&fog, whole, "color")?.numbers(" of at least 0", not_negative)?),
        density_per_m: needed(&fog, whole, "density")?.number(" of at least 0", not_negative)?,
        height,
    }))
}

pub fn read_lightmap(doc: &Document) -> Result<Option<Lightmap>> {
    let extras = node::extras_of_scene(doc)?;
    let Some(whole) = extras.get("lightmap") else { return Ok(None) };
    let parts = whole.object(&["color_image", "scale_image", "unit_lx"])?;
    let unit_lx = needed(&parts, whole, "unit_lx")?.number(" above 0", |v| v > 0.0)?;
    let index = |name| -> Result<usize> {
        let extra = needed(&parts, whole, name)?;
        let index: json::Index<json::Image> = extra.index()?;
        doc.get(&doc.root.images, "images", index, extra.element())?;
        Ok(index.value())
    };
    let indices = [index("color_image")?, index("scale_image")?];
    let [color, scale] = <[_; 2]>::try_from(image::decode_all(doc, &indices)?)
        .unwrap_or_else(|_| unreachable!("two were asked for"));
    if [color.width, color.height] != [scale.width, scale.height] {
        let (a, b) = ([color.width, color.height], [scale.width, scale.height]);
        return Err(whole.bad(format!("has images of {a:?} and {b:?} texels"), "bake the lightmap again"));
    }
    Ok(Some(Lightmap {
        width: color.width,
        height: color.height,
        color_rgba8: color.rgba8().to_vec(),
        scale8: scale.rgba8().chunks_exact(4).map(|texel| texel[0]).collect(),
        unit_lx,
    }))
}

/// A node's part of the lightmap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NodeLightmap {
    /// It shall have none.
    Never,
    /// This one.
    Rect(LightmapRect),
}

pub fn node_lightmap(doc: &Document, node: usize) -> Result<Option<NodeLightmap>> {
    let extras = node::extras(doc, node)?;
    let Some(extra) = extras.get("lightmap") else { return Ok(None) };
    if extra.as_bool() == Some(false) {
        return Ok(Some(NodeLightmap::Never));
    }
    // A little outside is rounding.
    let rule = " from 0 to 1, or false";
    let [x, y, width, height] = extra.numbers::<4>(rule, |v| (-1e-3..=1.001).contains(&v))?;
    let rect = LightmapRect { origin: Vec2::new(x, y), size: Vec2::new(width, height) };
    Ok(Some(NodeLightmap::Rect(rect)))
}
