//! Decals that `extras` of nodes describe.
//!
//! | `extras.ontile` of | | value | without it |
//! |---|---|---|---|
//! | `nodes[i]` | `decal` | `{"material": index, ...}`: paints a glTF material over the surfaces in a box around the node, along its -Z ([`Decal`]) | none |
//! | | `decal.size` | `[x, y, z]`: the box in the node's own units, so that its scale counts | `[1, 1, 1]` |
//! | | `decal.channels` | `{"base_color": 0 to 1, "normal": 0 to 1, "roughness": 0 to 1, "metallic": 0 to 1}`: how much of each is painted; those that are left out are not | all of the material |
//! | | `decal.angle` | `[begin, end]`, degrees from 0 to 90 between the surface's normal and the node's +Z: whole up to the first, nothing from the second on | `[60, 80]` |
//! | | `decal.falloff` | `[x, y, z]`, metres inside the faces over which it fades | `[0, 0, 0]` |
//! | | `decal.priority` | number: those of higher priority are painted over others; of equal ones later nodes | 0 |
//!
//! The alpha of the material's base colour says where there is something to paint, whatever its `alphaMode`. Of texture
//! coordinates there is one set, the box's own: (0, 0) is at -X and +Y, (1, 1) at +X and -Y.

use glam::{DMat4, Vec3};

use super::document::Document;
use super::extras::{Extra, Extras};
use super::material::Materials;
use super::node::{self, NodeTree};
use crate::Result;
use crate::scene::decal::has_volume;
use crate::scene::{Decal, DecalChannels};

const FIELDS: [&str; 6] = ["material", "size", "channels", "angle", "falloff", "priority"];

/// The decals of the drawn nodes.
pub fn read_decals(doc: &Document, tree: &NodeTree, materials: &mut Materials) -> Result<Vec<Decal>> {
    let mut decals = Vec::new();
    for &i in &tree.drawn {
        let extras = node::extras(doc, i)?;
        let Some(extra) = extras.get("decal") else { continue };
        let values = extra.object(&FIELDS)?;
        let Some(material) = values.get("material") else {
            return Err(extra.bad("has no material", "name one of the file's materials by its index"));
        };
        let size = size_in(&values)?;
        let world_from_decal = tree.world_from_node[i] * DMat4::from_scale(size.as_dvec3());
        if !has_volume(&world_from_decal) {
            let problem = "has a decal, but its box has no volume";
            return Err(doc.bad(format!("nodes[{i}]"), problem, "give the node a scale other than 0"));
        }
        let name = doc.root.nodes[i].name.clone().unwrap_or_else(|| format!("decal {}", decals.len()));
        let material = materials.use_material(doc, Some(material.index()?), material.element())?;
        decals.push(Decal {
            name,
            channels: channels(&values)?,
            angle_rad: angle(&values)?,
            falloff_m: match values.get("falloff") {
                Some(falloff) => falloff.numbers::<3>(" of at least 0", |v| v >= 0.0)?.into(),
                None => Vec3::ZERO,
            },
            priority: values.number_or("priority", 0.0, "", |_| true)?,
            ..Decal::new(material, world_from_decal.as_mat4())
        });
    }
    Ok(decals)
}

/// The box of a node that has a decal.
pub fn size(doc: &Document, node: usize) -> Result<Option<Vec3>> {
    let extras = node::extras(doc, node)?;
    let values = extras.get("decal").map(|extra| extra.object(&FIELDS)).transpose()?;
    values.map(|values| size_in(&values)).transpose()
}

fn size_in(values: &Extras) -> Result<Vec3> {
    let size = values.get("size").map(|size| size.numbers::<3>(" above 0", |v| v > 0.0)).transpose()?;
    Ok(size.map_or(Vec3::ONE, Vec3::from_array))
}

fn channels(values: &Extras) -> Result<DecalChannels> {
    let Some(extra) = values.get("channels") else { return Ok(DecalChannels::ALL) };
    let channels = extra.object(&["base_color", "normal", "roughness", "metallic"])?;
    let opacity = |name| channels.number_or(name, 0.0, " from 0 to 1", |v| (0.0..=1.0).contains(&v));
    Ok(DecalChannels {
        base_color: opacity("base_color")?,
        normal: opacity("normal")?,
        roughness: opacity("roughness")?,
        metallic: opacity("metallic")?,
    })
}

fn angle(values: &Extras) -> Result<[f32; 2]> {
    let Some(extra) = values.get("angle") else { return Ok(Decal::ANGLE_RAD) };
    let angle: [f32; 2] = Extra::numbers(extra, " from 0 to 90", |v| (0.0..=90.0).contains(&v))?;
    if angle[0] > angle[1] {
        return Err(extra.bad("ends before it begins", "give the smaller angle first"));
    }
    // Radians of 90 degrees round up.
    Ok(angle.map(|degrees| degrees.to_radians().min(std::f32::consts::FRAC_PI_2)))
}
