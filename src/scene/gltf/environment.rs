//! Environments that `extras` name.
//!
//! | `extras.ontile` of | | value | without it |
//! |---|---|---|---|
//! | `scenes[i]` | `environment` | `{"file": "sky.hdr", "rotation": degrees, "intensity": number}`: a file in the folder of the glTF file or below ([`Environment::load`]), turned about +Y, brighter or darker | none; rotation 0, intensity 1 |
//! | `nodes[i]` | `probe` | `{"size": [x, y, z], "falloff": number, "file": "room.hdr", "rotation": degrees, "intensity": number}`: metres along the node's axes, its scale ignored ([`Probe`]); the file is what is seen from the node, along those axes | none; falloff 0, rotation 0, intensity 1 |

use glam::{DMat3, DQuat, Vec3};

use super::document::Document;
use super::extras::{Extra, Extras};
use super::node::NodeTree;
use super::{node, source};
use crate::scene::{Environment, Probe};
use crate::{Error, Result};

/// The environment of the scene that is drawn.
pub fn read_environment(doc: &Document) -> Result<Option<Environment>> {
    let extras = node::extras_of_scene(doc)?;
    let Some(extra) = extras.get("environment") else { return Ok(None) };
    load(extra, &extra.object(&["file", "rotation", "intensity"])?).map(Some)
}

/// The probes of the drawn nodes.
pub fn read_probes(doc: &Document, tree: &NodeTree) -> Result<Vec<Probe>> {
    let mut probes = Vec::new();
    for &i in &tree.drawn {
        let extras = node::extras(doc, i)?;
        let Some(extra) = extras.get("probe") else { continue };
        let values = extra.object(&["size", "falloff", "file", "rotation", "intensity"])?;
        let Some(size) = values.get("size") else {
            return Err(extra.bad("has no size", "give the box's size in metres: [x, y, z]"));
        };
        let size = size.numbers(" above 0", |v| v > 0.0)?;
        let world = &tree.world_from_node[i];
        let axes = DMat3::from_mat4(*world);
        // The box keeps -Z and the plane of Y, as cameras do.
        let back = axes.z_axis.try_normalize();
        let right = back.and_then(|back| axes.y_axis.cross(back).try_normalize());
        let (Some(back), Some(right)) = (back, right) else {
            let problem = "has a probe, but its scale of 0 leaves no axes for the box";
            return Err(doc.bad(format!("nodes[{i}]"), problem, "give the node a scale other than 0"));
        };
        let world_from_probe = DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back));
        probes.push(Probe {
            name: doc.root.nodes[i].name.clone().unwrap_or_else(|| format!("probe {}", probes.len())),
            position_world: world.w_axis.truncate().as_vec3(),
            world_from_probe: world_from_probe.as_quat().normalize(),
            half_size_m: Vec3::from_array(size) * 0.5,
            falloff_m: values.number_or("falloff", 0.0, " that is at least 0", |v| v >= 0.0)?,
            environment: load(extra, &values)?,
        });
    }
    Ok(probes)
}

/// The file that `file` names, turned and scaled as the others say.
fn load(extra: &Extra, values: &Extras) -> Result<Environment> {
    let rotation_deg = values.number_or("rotation", 0.0, " of degrees", |_| true)?;
    let intensity = values.number_or("intensity", 1.0, " that is at least 0", |v| v >= 0.0)?;
    let Some(file) = values.get("file") else {
        return Err(extra.bad("has no file", "name an .hdr, .exr or .ktx2 file beside this one"));
    };
    let path = source::below(extra.doc().path, file.text()?)
        .map_err(|problem| file.bad(problem, "put the file beside the glTF file"))?;
    let read = Environment::load(&path).map_err(|error| match error {
        Error::Io { path, source, .. } => {
            let problem = format!("cannot read {}: {source}", path.display());
            file.bad(problem, "put the file there, or correct the name")
        }
        Error::Input { path, element, problem, remedy } => {
            file.bad(format!("{}: {element}: {problem}", path.display()), remedy)
        }
        other => other,
    })?;
    let environment = Environment { rotation_deg, intensity, ..read };
    match environment.too_bright() {
        None => Ok(environment),
        Some(problem) => Err(values.get("intensity").unwrap_or(extra).bad(problem, "lower the intensity")),
    }
}
