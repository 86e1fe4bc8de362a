//! Primitives into meshes.

use glam::{Vec2, Vec3, Vec4};
use gltf::json;
use gltf::json::mesh::{Mode, Semantic};
use gltf::json::validation::Checked;

use super::accessor::{Format, Reader};
use super::document::{Document, MAX_INDICES, MAX_VERTICES};
use super::pose::{self, Bend};
use super::tangent;
use crate::Result;
use crate::scene::{Material, Mesh};

/// What has been read so far, against what a scene may hold.
#[derive(Default)]
pub struct Budget {
    vertices: usize,
    indices: usize,
}

impl Budget {
    fn take(&mut self, doc: &Document, element: &str, vertices: usize, indices: usize) -> Result<()> {
        self.vertices = self.vertices.saturating_add(vertices);
        self.indices = self.indices.saturating_add(indices);
        if self.vertices <= MAX_VERTICES && self.indices <= MAX_INDICES {
            return Ok(());
        }
        let problem =
            format!("brings the scene to more than {MAX_VERTICES} vertices or {MAX_INDICES} indices");
        Err(doc.bad(element, problem, "split the scene into smaller files"))
    }
}

/// A primitive and where it is in the file.
pub struct Primitive<'a> {
    pub json: &'a json::mesh::Primitive,
    pub name: String,
    /// `meshes[i].primitives[j]`
    pub element: String,
    /// A node that draws it has a part of the lightmap.
    pub lightmapped: bool,
}

impl Primitive<'_> {
    /// The corners of its triangles, three each; `None`, and why in `warnings`, if there are none.
    pub fn triangles(
        &self,
        doc: &Document,
        budget: &mut Budget,
        warnings: &mut Vec<String>,
    ) -> Result<Option<Vec<u32>>> {
        let element = &self.element;
        let mode = doc.valid(self.json.mode, format!("{element}.mode"))?;
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            warnings.push(format!("{element}: points and lines are not supported and were left out"));
            return Ok(None);
        }
        let vertices = self.vertex_count(doc)?;
        budget.take(doc, element, vertices, 0)?;
        let indices = triangulate(mode, self.corners(doc, vertices, budget)?);
        if indices.is_empty() {
            warnings.push(format!("{element}: it has no triangles and was left out"));
            return Ok(None);
        }
        Ok(Some(indices))
    }

    /// The mesh of these triangles with what its material needs.
    pub fn read(
        &self,
        doc: &Document,
        indices: Vec<u32>,
        material: &Material,
        bend: &Bend,
        budget: &mut Budget,
        warnings: &mut Vec<String>,
    ) -> Result<Mesh> {
        let element = &self.element;
        let mut mesh = self.attributes(doc, material)?;
        mesh.indices = indices;
        mesh.deformation = bend.read(doc, &mesh, self.json, element)?;
        pose::turn_mirrored(&mut mesh);
        if !bend.moves {
            mesh = mesh.posed().into_owned();
        }
        if !mesh.positions.iter().all(|p| p.is_finite()) {
            let problem = "the posed positions exceed what f32 can hold";
            return Err(doc.bad(element, problem, "scale the scene down"));
        }
        self.complete(doc, &mut mesh, material, budget, warnings)?;
        Ok(mesh)
    }

    /// Makes what the material needs and the file leaves out.
    fn complete(
        &self,
        doc: &Document,
        mesh: &mut Mesh,
        material: &Material,
        budget: &mut Budget,
        warnings: &mut Vec<String>,
    ) -> Result<()> {
        if material.unlit {
            return Ok(());
        }
        let element = &self.element;
        if mesh.normals.is_empty() {
            if mesh.deformation.is_some() {
                warnings.push(format!(
                    "{element}: it has no normals; those of its bind pose's triangles are bent with it"
                ));
            }
            budget.take(doc, element, mesh.indices.len(), 0)?;
            tangent::make_flat_normals(mesh);
        } else {
            let lost = tangent::normalize_normals(mesh);
            if lost > 0 {
                warnings.push(format!(
                    "{element}.attributes.NORMAL: {lost} normals of length 0 were replaced by flat ones"
                ));
            }
        }
        if let Some(normal_texture) = &material.normal_texture {
            if mesh.tangents.is_empty() {
                budget.take(doc, element, mesh.indices.len(), 0)?;
                if let Err(why) = tangent::make_tangents(mesh, normal_texture) {
                    warnings.push(format!("{element}: {why}; its tangents are arbitrary"));
                }
            } else {
                tangent::normalize_tangents(mesh);
            }
        }
        Ok(())
    }

    /// The elements of an attribute; empty if the primitive has none.
    pub fn floats<const N: usize>(
        &self,
        doc: &Document,
        semantic: Semantic,
        format: Format,
    ) -> Result<Vec<[f32; N]>> {
        let name = semantic.to_string();
        let Some(index) = self.accessor(semantic) else { return Ok(Vec::new()) };
        Reader::new(doc, index, format!("{}.attributes.{name}", self.element), format)?.floats(doc)
    }

    fn accessor(&self, semantic: Semantic) -> Option<json::Index<json::Accessor>> {
        self.json.attributes.get(&Checked::Valid(semantic)).copied()
    }

    /// The number of vertices, which all attributes must agree on.
    pub fn vertex_count(&self, doc: &Document) -> Result<usize> {
        let attributes = format!("{}.attributes", self.element);
        let count = |index, name: &str| {
            let accessor =
                doc.get(&doc.root.accessors, "accessors", index, format!("{attributes}.{name}"))?;
            Ok(accessor.count.0)
        };
        let Some(positions) = self.accessor(Semantic::Positions) else {
            let problem = "is missing";
            return Err(doc.bad(format!("{attributes}.POSITION"), problem, "export the file again"));
        };
        let vertices = count(positions, "POSITION")?;
        if vertices == 0 {
            let problem = "has no elements";
            return Err(doc.bad(format!("{attributes}.POSITION"), problem, "export the file again"));
        }
        for (semantic, &index) in &self.json.attributes {
            let Checked::Valid(semantic) = semantic else { continue };
            let name = semantic.to_string();
            let found = count(index, &name)?;
            if found != vertices {
                let problem = format!("has {found} elements, but POSITION has {vertices}");
                return Err(doc.bad(format!("{attributes}.{name}"), problem, "export the file again"));
            }
        }
        Ok(usize::try_from(vertices).unwrap_or(usize::MAX))
    }

    /// The vertex of each corner, in the order of the file.
    fn corners(&self, doc: &Document, vertices: usize, budget: &mut Budget) -> Result<Vec<u32>> {
        let Some(index) = self.json.indices else {
            budget.take(doc, &self.element, 0, vertices)?;
            return Ok((0..vertices as u32).collect());
        };
        let element = format!("{}.indices", self.element);
        let reader = Reader::new(doc, index, &element, Format::INDICES)?;
        budget.take(doc, &element, 0, reader.count)?;
        let corners: Vec<u32> = reader.integers::<1>().into_iter().map(|[i]| i).collect();
        match corners.iter().position(|&i| i as usize >= vertices) {
            None => Ok(corners),
            Some(at) => Err(doc.bad(
                element,
                format!("index {at} is {}, but there are {vertices} vertices", corners[at]),
                "export the file again",
            )),
        }
    }

    fn attributes(&self, doc: &Document, material: &Material) -> Result<Mesh> {
        let floats3 = |semantic, format| -> Result<Vec<Vec3>> {
            Ok(self.floats::<3>(doc, semantic, format)?.into_iter().map(Vec3::from_array).collect())
        };
        let mut mesh = Mesh { name: self.name.clone(), ..Mesh::default() };
        mesh.positions = floats3(Semantic::Positions, Format::VEC3)?;
        if !material.unlit {
            mesh.normals = floats3(Semantic::Normals, Format::VEC3)?;
        }
        // Without normals, given tangents are to be ignored.
        if material.normal_texture.is_some() && !mesh.normals.is_empty() {
            let tangents = self.floats::<4>(doc, Semantic::Tangents, Format::VEC4)?;
            mesh.tangents = tangents.into_iter().map(Vec4::from_array).collect();
        }
        for (set, texcoords) in mesh.texcoords.iter_mut().enumerate() {
            let by_lightmap = set == 1 && self.lightmapped && !material.unlit;
            if by_lightmap || material.uses_texcoord(set) {
                let found = self.floats::<2>(doc, Semantic::TexCoords(set as u32), Format::TEXCOORD)?;
                *texcoords = found.into_iter().map(Vec2::from_array).collect();
            }
        }
        mesh.colors = self.colors(doc)?;
        Ok(mesh)
    }

    /// COLOR_0 with alpha; empty if the primitive has none.
    pub fn colors(&self, doc: &Document) -> Result<Vec<Vec4>> {
        let Some(index) = self.accessor(Semantic::Colors(0)) else { return Ok(Vec::new()) };
        let r = Reader::new(doc, index, format!("{}.attributes.COLOR_0", self.element), Format::COLOR)?;
        Ok(match r.width {
            3 => r.floats::<3>(doc)?.into_iter().map(|c| Vec3::from_array(c).extend(1.0)).collect(),
            _ => r.floats::<4>(doc)?.into_iter().map(Vec4::from_array).collect(),
        })
    }
}

impl Material {
    pub(super) fn uses_texcoord(&self, set: usize) -> bool {
        let slots = [
            &self.base_color_texture,
            &self.metallic_roughness_texture,
            &self.normal_texture,
            &self.occlusion_texture,
            &self.emissive_texture,
        ];
        slots.into_iter().flatten().any(|texture| texture.texcoord == set)
    }
}

/// Triangle lists from the three triangle modes (glTF 2.0 section 3.7.2.1); odd corners at the end are dropped.
fn triangulate(mode: Mode, mut corners: Vec<u32>) -> Vec<u32> {
    let triangles = corners.len().saturating_sub(2);
    match mode {
        Mode::TriangleStrip => (0..triangles)
            .map(|i| [corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]])
            // Strips are joined by triangles without area.
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .flatten()
            .collect(),
        Mode::TriangleFan => {
            (0..triangles).flat_map(|i| [corners[i + 1], corners[i + 2], corners[0]]).collect()
        }
        _ => {
            corners.truncate(corners.len() / 3 * 3);
            corners
        }
    }
}
