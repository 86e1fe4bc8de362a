//! What the file's extras say of the scene as a whole: background, fog and lightmap.

use glam::{Vec2, Vec3};
use gltf::json::Index;
use serde::Deserialize;
use serde_json::Value;

use super::document::Document;
use super::{extras, image};
use crate::Result;
use crate::scene::{Background, Fog, FogHeight, Lightmap, LightmapRect};

/// `"fog": {"density": 0.02, "color": [0.5, 0.6, 0.7], "base": 0, "scale": 10}`; the last two belong together.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FogExtra {
    density: f32,
    color: [f32; 3],
    base: Option<f32>,
    scale: Option<f32>,
}

/// `"lightmap": {"color_image": 3, "scale_image": 4, "unit_lx": 0.5}`
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LightmapExtra {
    color_image: usize,
    scale_image: usize,
    unit_lx: f32,
}

/// `"background": "#87ceeb"`
pub fn read_background(doc: &Document) -> Result<Background> {
    let Some(text) = extras::get::<String>(doc, &doc.root.extras, "", "background")? else {
        return Ok(Background::default());
    };
    Background::from_hex(&text).ok_or_else(|| {
        let problem = format!("is '{}'", super::source::shortened(&text));
        doc.bad("extras.ontile.background", problem, "write a colour as six hexadecimal digits: #87ceeb")
    })
}

pub fn read_fog(doc: &Document) -> Result<Option<Fog>> {
    let Some(extra) = extras::get::<FogExtra>(doc, &doc.root.extras, "", "fog")? else { return Ok(None) };
    let check = |holds: bool, field: &str, rule: &str| match holds {
        true => Ok(()),
        false => Err(doc.bad(format!("extras.ontile.fog.{field}"), format!("is not {rule}"), "correct it")),
    };
    let fine = |x: f32| x.is_finite() && x >= 0.0;
    check(fine(extra.density), "density", "a finite number of 0 or more")?;
    check(extra.color.iter().all(|c| fine(*c)), "color", "three finite numbers of 0 or more")?;
    check(extra.base.is_none_or(f32::is_finite), "base", "a finite number")?;
    check(extra.scale.is_none_or(|s| s.is_finite() && s > 0.0), "scale", "a finite number above 0")?;
    check(extra.base.is_some() == extra.scale.is_some(), "scale", "given together with base")?;
    Ok(Some(Fog {
        color_nt: Vec3::from_array(extra.color),
        density_per_m: extra.density,
        height: extra.base.zip(extra.scale).map(|(base_m, scale_m)| FogHeight { base_m, scale_m }),
    }))
}

pub fn read_lightmap(doc: &Document) -> Result<Option<Lightmap>> {
    const PLACE: &str = "extras.ontile.lightmap";
    let Some(extra) = extras::get::<LightmapExtra>(doc, &doc.root.extras, "", "lightmap")? else {
        return Ok(None);
    };
    if !(extra.unit_lx.is_finite() && extra.unit_lx > 0.0) {
        let problem = format!("is {}, but must be finite and above 0", extra.unit_lx);
        return Err(doc.bad(format!("{PLACE}.unit_lx"), problem, "bake the lightmap again"));
    }
    let indices = [(extra.color_image, "color_image"), (extra.scale_image, "scale_image")];
    for (index, field) in indices {
        doc.get(&doc.root.images, "images", Index::new(index as u32), format!("{PLACE}.{field}"))?;
    }
    let [color, scale] = <[_; 2]>::try_from(image::decode_all(doc, &indices.map(|(i, _)| i))?)
        .unwrap_or_else(|_| unreachable!("two were asked for"));
    if [color.width, color.height] != [scale.width, scale.height] {
        let problem = format!(
            "has images of {}x{} and {}x{} texels",
            color.width, color.height, scale.width, scale.height
        );
        return Err(doc.bad(PLACE, problem, "bake the lightmap again"));
    }
    Ok(Some(Lightmap {
        width: color.width,
        height: color.height,
        color_rgba8: color.rgba8,
        scale8: scale.rgba8.chunks_exact(4).map(|texel| texel[0]).collect(),
        unit_lx: extra.unit_lx,
    }))
}

/// A node's part of the lightmap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NodeLightmap {
    /// `"lightmap": false`: it shall have none.
    Never,
    /// `"lightmap": [x, y, width, height]`, in texture coordinates.
    Rect(LightmapRect),
}

pub fn node_lightmap(doc: &Document, node: usize) -> Result<Option<NodeLightmap>> {
    let element = format!("nodes[{node}]");
    let Some(value) = extras::get::<Value>(doc, &doc.root.nodes[node].extras, &element, "lightmap")? else {
        return Ok(None);
    };
    if value == Value::Bool(false) {
        return Ok(Some(NodeLightmap::Never));
    }
    let numbers: Option<[f32; 4]> = serde_json::from_value(value).ok();
    // Just outside may be rounding; f32 as wide as JSON's numbers become infinite.
    let inside = |n: &[f32; 4]| n.iter().all(|x| (-1e-3..=1.001).contains(x));
    match numbers.filter(inside) {
        Some([x, y, width, height]) => Ok(Some(NodeLightmap::Rect(LightmapRect {
            origin: Vec2::new(x, y),
            size: Vec2::new(width, height),
        }))),
        None => Err(doc.bad(
            format!("{element}.extras.ontile.lightmap"),
            "is neither false nor four numbers from 0 to 1",
            "bake the lightmap again",
        )),
    }
}
