//! Particles that `extras` of nodes describe.
//!
//! | `extras.ontile` of | | value | without it |
//! |---|---|---|---|
//! | `nodes[i]` | `particles` | `{...}`: each vertex of the primitives of mode POINTS of the node's mesh is a square that faces the camera and adds the emission of the primitive's material, times COLOR_0 ([`Particles`]) | points are not drawn |
//! | | `particles.size` | metres above 0: the square's side, times the attribute `_SIZE` (a float) where there is one | 0.1 |
//! | | `particles.soft` | metres of at least 0: how far behind a particle something opaque is where it is seen whole | its size |
//!
//! The attribute `_ROTATION` (a float), where there is one, turns each square, radians. The node's transform places the points, and its
//! scale counts for places alone. They follow a node that is animated.

use glam::Vec3;
use gltf::json::mesh::{Mode, Semantic};
use gltf::json::validation::Checked;

use super::accessor::Format;
use super::document::Document;
use super::extras::Extra;
use super::material::Materials;
use super::mesh::Primitive;
use super::motion::{Followers, Moving};
use super::node::{self, NodeTree};
use crate::Result;
use crate::scene::{Follows, Particle, Particles};

/// More squares than this a frame are a mistake.
const MOST: usize = 1 << 20;

/// Whether the primitive is of points.
pub fn is_points(primitive: &gltf::json::mesh::Primitive) -> bool {
    primitive.mode == Checked::Valid(Mode::Points)
}

/// What a node says of the points of its mesh.
pub fn said<'a>(doc: &'a Document<'a>, node: usize) -> Result<Option<Extra<'a>>> {
    Ok(node::extras(doc, node)?.take("particles"))
}

/// The particles of the drawn nodes.
pub fn read_particles(
    doc: &Document,
    tree: &NodeTree,
    moving: &Moving,
    followers: &mut Followers,
    materials: &mut Materials,
    warnings: &mut Vec<String>,
) -> Result<Vec<Particles>> {
    let mut all: Vec<Particles> = Vec::new();
    for &i in &tree.drawn {
        let Some(extra) = said(doc, i)? else { continue };
        let values = extra.object(&["size", "soft"])?;
        let size_m = values.number_or("size", 0.1, " above 0", |v| v > 0.0)?;
        let soft_m = values.number_or("soft", size_m, " of at least 0", |v| v >= 0.0)?;
        let node = &doc.root.nodes[i];
        let mesh = match node.mesh {
            Some(mesh) => {
                Some((mesh.value(), doc.get(&doc.root.meshes, "meshes", mesh, format!("nodes[{i}].mesh"))?))
            }
            None => None,
        };
        let of_points = mesh.iter().flat_map(|(index, mesh)| {
            let points = mesh.primitives.iter().enumerate().filter(|(_, primitive)| is_points(primitive));
            points.map(move |(j, json)| (format!("meshes[{index}].primitives[{j}]"), json))
        });
        let before = all.len();
        for (element, json) in of_points {
            let primitive = Primitive { json, name: String::new(), element, lightmapped: false };
            primitive.vertex_count(doc)?;
            let positions = primitive.floats::<3>(doc, Semantic::Positions, Format::VEC3)?;
            let positions_node: Vec<_> = positions.into_iter().map(Vec3::from).collect();
            let colors = primitive.colors(doc)?;
            let own = |name: &str| primitive.floats::<1>(doc, Semantic::Extras(name.into()), Format::SCALAR);
            let (sizes, rotations) = (own("SIZE")?, own("ROTATION")?);
            let element = &primitive.element;
            if all.iter().map(|p: &Particles| p.list.len()).sum::<usize>() + positions_node.len() > MOST {
                let problem = format!("brings the scene to more than {MOST} particles");
                return Err(doc.bad(element, problem, "use fewer and larger ones"));
            }
            let list = positions_node.iter().enumerate().map(|(n, at)| Particle {
                position_world: tree.world_from_node[i].transform_point3(at.as_dvec3()).as_vec3(),
                size_m: size_m * sizes.get(n).map_or(1.0, |s| s[0]),
                rotation_rad: rotations.get(n).map_or(0.0, |r| r[0]),
                color: colors.get(n).map_or(Vec3::ONE, |c| c.truncate()),
            });
            let material = materials.use_material(doc, json.material, &format!("{element}.material"))?;
            let particles = Particles {
                name: node.name.clone().unwrap_or_else(|| format!("particles {}", all.len())),
                ..Particles::new(material, soft_m, list.collect())
            };
            if let Some(problem) = particles.numbers_problem() {
                return Err(doc.bad(element, problem, "correct the points' attributes"));
            }
            if !particles.shine(&materials.materials[material]) {
                warnings
                    .push(format!("{element}: its material emits nothing, so its particles are not seen"));
            }
            if moving.place(i) {
                followers.list.push((i, Follows::Particles { particles: all.len(), positions_node }));
            }
            all.push(particles);
        }
        if all.len() == before {
            return Err(
                extra.bad("is said of a node without points", "give its mesh a primitive of mode 0 (POINTS)")
            );
        }
    }
    Ok(all)
}
