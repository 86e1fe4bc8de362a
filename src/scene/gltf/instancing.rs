//! EXT_mesh_gpu_instancing: a node that draws its mesh many times.

use std::collections::HashMap;

use glam::{DMat4, DQuat, DVec4, Vec3};
use gltf::json::{self, Index};

use super::accessor::{Format, Reader};
use super::document::{Document, MAX_INSTANCES};
use crate::Result;

/// By name, the accessors that say where a node's instances are.
pub type Attributes = HashMap<String, Index<json::Accessor>>;

/// Where in a node's space its instances are; `None` if its mesh is drawn once, where it is.
pub fn placements(doc: &Document, node: usize) -> Result<Option<Vec<DMat4>>> {
    let Some(attributes) = &doc.instancing[node] else { return Ok(None) };
    let name = format!("nodes[{node}].extensions.EXT_mesh_gpu_instancing");
    let mut names: Vec<&String> = attributes.keys().collect();
    names.sort();
    let mut count = None;
    for attribute in names {
        let element = format!("{name}.attributes.{attribute}");
        let own = doc.get(&doc.root.accessors, "accessors", attributes[attribute], &element)?.count.0;
        if own != *count.get_or_insert(own) {
            let problem = format!("has {own} elements, but another attribute has {}", count.unwrap_or(own));
            return Err(doc.bad(element, problem, "give all attributes as many elements"));
        }
        if own > MAX_INSTANCES as u64 {
            let problem = format!("has {own} elements; at most {MAX_INSTANCES} meshes are drawn");
            return Err(doc.bad(element, problem, "split the scene into smaller files"));
        }
    }
    let Some(count) = count else {
        return Err(doc.bad(format!("{name}.attributes"), "is empty", "name at least TRANSLATION"));
    };
    let read = |attribute: &str, format| {
        let index = attributes.get(attribute);
        index
            .map(|&index| Reader::new(doc, index, format!("{name}.attributes.{attribute}"), format))
            .transpose()
    };
    let vectors = |attribute: &str| -> Result<Option<Vec<[f32; 3]>>> {
        read(attribute, Format::PLACES)?.map(|reader| reader.floats::<3>(doc)).transpose()
    };
    let (translations, scales) = (vectors("TRANSLATION")?, vectors("SCALE")?);
    let rotations = read("ROTATION", Format::ROTATIONS)?.map(|reader| reader.floats::<4>(doc)).transpose()?;
    let place = |i: usize| {
        let vector = |list: &Option<Vec<[f32; 3]>>, default| {
            list.as_ref().map_or(default, |list| Vec3::from(list[i])).as_dvec3()
        };
        let rotation = match &rotations {
            Some(list) => {
                let rotation = DVec4::from(list[i].map(f64::from)).try_normalize().ok_or_else(|| {
                    let problem = format!("element {i} is a quaternion of length 0");
                    doc.bad(format!("{name}.attributes.ROTATION"), problem, "use unit quaternions")
                })?;
                DQuat::from_vec4(rotation)
            }
            None => DQuat::IDENTITY,
        };
        let (translation, scale) = (vector(&translations, Vec3::ZERO), vector(&scales, Vec3::ONE));
        Ok(DMat4::from_scale_rotation_translation(scale, rotation, translation))
    };
    (0..count as usize).map(place).collect::<Result<Vec<_>>>().map(Some)
}
