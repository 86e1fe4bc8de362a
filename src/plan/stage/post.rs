//! What passes after the frame's own want of it.

use super::{Asked, Frame, Resource, Use};
use crate::plan::layout::Form;
use crate::plan::{BloomWay, Format};

/// Marks what is sampled later, and adds what only later passes need.
pub(super) fn add(frame: &mut Frame, asked: &Asked) {
    let options = asked.options;
    if options.bloom == BloomWay::Previous || options.edge_filter {
        frame.resources[Frame::OUTPUT].sampled = true;
    }
    if options.bloom == BloomWay::Store {
        frame.resources.push(Resource {
            name: "bloom_light",
            format: Format::B10g11r11Float,
            holds: "rgb: exposed light before the tone curve, scattered light left out",
            samples: 1,
            clear: None,
            kept: false,
            sampled: true,
            why: "bloom spreads it for the next frame".into(),
        });
        let light = frame.resources.len() - 1;
        if let Some(last) = frame.stages.last_mut() {
            last.uses.push((light, Use::Write));
        }
    }
    if options.edge_filter {
        frame.resources[Frame::OUTPUT].holds = "the picture before its edges are smoothed";
        let normals = normals(asked.gbuffer.form);
        let is_depth = |r: &Resource| r.format.is_depth() && r.name.starts_with("depth");
        let wanted = |r: &&mut Resource| is_depth(r) || normals.contains(&r.name);
        for resource in frame.resources.iter_mut().filter(wanted) {
            resource.sampled = true;
            resource.why += "; the edge filter samples it";
        }
    }
}

/// The targets that hold normals.
fn normals(form: Form) -> &'static [&'static str] {
    match form {
        Form::Metallic | Form::Specular => &["normal_roughness"],
        Form::Thibieroz128 | Form::Rasa128 | Form::Dissertation192 => &["normal"],
        Form::Thibieroz96 => &["base_metallic", "normal_xy"],
        Form::Metallic256 | Form::Specular256 => &["more_words"],
        Form::Packed128 => &["words"],
    }
}
