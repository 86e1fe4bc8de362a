//! The environment that `extras` of the scene name.
//!
//! | `extras.ontile` of | | value | without it |
//! |---|---|---|---|
//! | `scenes[i]` | `environment` | `{"file": "sky.hdr", "rotation": degrees, "intensity": number}`: a file beside the glTF file ([`Environment::load`]), turned about +Y, brighter or darker | none; rotation 0, intensity 1 |

use super::document::Document;
use super::extras::{Extra, Extras};
use super::{node, source};
use crate::Result;
use crate::scene::Environment;

/// The environment of the scene that is drawn.
pub fn read_environment(doc: &Document) -> Result<Option<Environment>> {
    let extras = node::extras_of_scene(doc)?;
    let Some(extra) = extras.get("environment") else { return Ok(None) };
    let values = extra.object(&["file", "rotation", "intensity"])?;
    Ok(Some(Environment {
        rotation_deg: values.number_or("rotation", 0.0, " of degrees", |_| true)?,
        intensity: values.number_or("intensity", 1.0, " that is at least 0", |v| v >= 0.0)?,
        ..load(extra, &values)?
    }))
}

/// The file that `file` names.
fn load(extra: &Extra, values: &Extras) -> Result<Environment> {
    let Some(file) = values.get("file") else {
        return Err(extra.bad("has no file", "name an .hdr, .exr or .ktx2 file beside this one"));
    };
    let path = source::beside(extra.doc().path, file.text()?)
        .map_err(|problem| file.bad(problem, "put the file beside the glTF file"))?;
    Environment::load(&path)
}
