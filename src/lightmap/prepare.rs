//! From a file to a scene whose surfaces have their part of a lightmap, and back to a file.

use std::io::Cursor;
use std::path::Path;

use glam::DMat3;
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use serde_json::json;

use super::pack::{Packed, pack};
use super::unwrap::{Layout, Part, Unwrap};
use crate::scene::edit::{Edit, Replacement, Surface};
use crate::scene::{Lightmap, Scene};
use crate::{Error, Result, file};

/// Texels along a side that every Vulkan device has (limit `maxImageDimension2D`).
const MAX_SIDE: u32 = 4096;

/// Sides are multiples of this, so that block compression fits.
const BLOCK: u32 = 4;

/// How many texels surfaces get.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Density {
    /// Texels along a metre.
    TexelsPerMetre(f64),
    /// As many as fit a square map of this side.
    Side(u32),
}

/// A file on its way to a lightmap.
pub struct Prepared {
    /// What the file shows now: instances have [`Instance::lightmap`](crate::scene::Instance::lightmap).
    pub scene: Scene,
    /// The map's width and height in texels.
    pub size: [u32; 2],
    /// Texels along a metre of surface, where a mesh is largest.
    pub texels_per_metre: f64,
    edit: Edit,
    static_light_nodes: Vec<usize>,
}

/// Reads a file, makes lightmap coordinates where its TEXCOORD_1 cannot serve, and gives every node that draws something lit a part
/// of the map.
///
/// TEXCOORD_1 serves if all lit primitives of the mesh have one within \[0, 1\] in which no triangle covers another. Else it is
/// made (or replaced): the surface is cut into charts. Meshes that several nodes draw have one set of coordinates, and
/// each node a part of the map.
///
/// # Errors
/// As [`Scene::load`]; [`Error::Input`] if a TEXCOORD_1 cannot serve and materials need it as it is, or nothing is lit;
/// [`Error::Unsupported`] if the surfaces do not fit a map of at most 4096 texels a side.
pub fn prepare(path: &Path, density: Density) -> Result<Prepared> {
    let mut edit = Edit::read(path)?;
    let surfaces = edit.surfaces()?;
    if surfaces.is_empty() {
        let remedy = "name a scene with surfaces that are not KHR_materials_unlit";
        return Err(Error::input(path, "nodes", "nothing in the scene is lit", remedy));
    }
    let parts: Vec<Vec<Part>> = surfaces.iter().map(parts_of).collect();
    let unwraps: Vec<_> =
        surfaces.iter().zip(&parts).map(|(surface, parts)| Unwrap::new(parts, &largest(surface))).collect();
    for (surface, unwrap) in surfaces.iter().zip(&unwraps) {
        check_free(path, surface, unwrap)?;
    }
    let (texels_per_metre, layouts, packed) = fit(path, &surfaces, &unwraps, density)?;
    let size = packed.size.map(|side| side.max(1).next_multiple_of(BLOCK));

    let mut places = packed.places.into_iter();
    for (surface, layout) in surfaces.iter().zip(&layouts) {
        for (node, _) in &surface.nodes {
            let place = places.next().expect("a place for every node");
            let part = |k: usize, texels: u32| f64::from(texels) / f64::from(size[k]);
            let rect = [
                part(0, place[0] + layout.border),
                part(1, place[1] + layout.border),
                part(0, layout.size[0]),
                part(1, layout.size[1]),
            ];
            edit.set_extra(&format!("/nodes/{node}"), "lightmap", json!(rect));
        }
    }
    let vertices: Vec<_> =
        (0..surfaces.len()).filter_map(|i| Some((i, unwraps[i].vertices(&parts[i], &layouts[i])?))).collect();
    let replacements: Vec<_> = vertices
        .iter()
        .flat_map(|(i, vertices)| {
            surfaces[*i].parts.iter().zip(vertices).map(|(part, new)| (&surfaces[*i], part, new))
        })
        .map(|(surface, part, new)| Replacement {
            mesh: surface.mesh,
            primitive: part.primitive,
            sources: &new.sources,
            texcoords: &new.texcoords,
            indices: &new.indices,
        })
        .collect();
    edit.replace_vertices(&replacements)?;
    let mut scene = edit.scene()?;
    let light_nodes = edit.light_nodes()?;
    scene.drop_default_lights();
    let fixed = light_nodes.into_iter().zip(&scene.lights).filter(|(_, light)| !light.dynamic);
    let static_light_nodes = fixed.map(|(node, _)| node).collect();
    Ok(Prepared { scene, size, texels_per_metre, edit, static_light_nodes })
}

impl Prepared {
    /// Writes a copy of the file with the lightmap, as GLB. Lights that it holds are marked as such.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn write(mut self, lightmap: &Lightmap, path: &Path) -> Result<()> {
        let color: Vec<u8> =
            lightmap.color_rgba8.chunks_exact(4).flat_map(|texel| &texel[..3]).copied().collect();
        let size = [lightmap.width, lightmap.height];
        let color = png(path, &color, size, ExtendedColorType::Rgb8)?;
        let scale = png(path, &lightmap.scale8, size, ExtendedColorType::L8)?;
        let color = self.edit.add_png("lightmap colour", &color);
        let scale = self.edit.add_png("lightmap scale", &scale);
        let extra = json!({"color_image": color, "scale_image": scale, "unit_lx": lightmap.unit_lx});
        self.edit.set_scene_extra("lightmap", extra);
        for node in self.static_light_nodes {
            self.edit.set_extra(&format!("/nodes/{node}"), "baked", json!(true));
        }
        file::write_whole(path, &self.edit.to_glb())
    }
}

fn parts_of(surface: &Surface) -> Vec<Part<'_>> {
    let parts = surface.parts.iter();
    parts.map(|p| Part { positions: &p.positions, texcoords: &p.texcoords, indices: &p.indices }).collect()
}

/// How the mesh stands where its determinant, and so about its area, is largest.
fn largest(surface: &Surface) -> DMat3 {
    let linear = surface.nodes.iter().map(|(_, world_from_node)| DMat3::from_mat4(*world_from_node));
    let larger = |a: DMat3, b: DMat3| if b.determinant().abs() > a.determinant().abs() { b } else { a };
    linear.reduce(larger).unwrap_or(DMat3::IDENTITY)
}

/// Coordinates that must be replaced are used by nothing else.
fn check_free(path: &Path, surface: &Surface, unwrap: &Unwrap) -> Result<()> {
    let needed = surface.parts.iter().find(|part| part.uses_texcoords);
    let (Unwrap::Charts { .. }, Some(part)) = (unwrap, needed) else { return Ok(()) };
    Err(Error::input(
        path,
        format!("meshes[{}].primitives[{}].attributes.TEXCOORD_1", surface.mesh, part.primitive),
        "is used by the material's textures, but cannot hold a lightmap: it leaves 0 to 1, or its triangles overlap",
        "unwrap it without overlap, or let the textures use TEXCOORD_0",
    ))
}

/// Density, layout of each surface, and the places of all their nodes.
fn fit(
    path: &Path,
    surfaces: &[Surface],
    unwraps: &[Unwrap],
    density: Density,
) -> Result<(f64, Vec<Layout>, Packed)> {
    let at = |texels_per_metre: f64, side: u32| {
        let layouts: Vec<_> = unwraps.iter().map(|u| u.lay_out(texels_per_metre)).collect();
        let of_nodes = |(s, l): (&Surface, &Layout)| vec![l.outer_size(); s.nodes.len()];
        let sizes: Vec<_> = surfaces.iter().zip(&layouts).flat_map(of_nodes).collect();
        let packed = pack(&sizes, side);
        let fits = packed.size.iter().all(|s| *s <= side);
        fits.then_some((texels_per_metre, layouts, packed))
    };
    let fullest = |side: u32| {
        // Twice as many texels a metre need four times the space: from far too many down, then closer.
        let mut low = (0..64)
            .map(|i| f64::from(MAX_SIDE) * 1024.0 / f64::exp2(i.into()))
            .find(|d| at(*d, side).is_some())?;
        for factor in [1.5, 1.25, 1.125, 1.0625, 1.03125] {
            low = if at(low * factor, side).is_some() { low * factor } else { low };
        }
        at(low, side)
    };
    match density {
        Density::TexelsPerMetre(wanted) => {
            let sides = (3..=MAX_SIDE.ilog2()).map(|power| 1 << power);
            sides.into_iter().find_map(|side| at(wanted, side)).ok_or_else(|| {
                let remedy = match fullest(MAX_SIDE) {
                    Some((most, ..)) => format!("ask for {} texels a metre at most", most.floor().max(most)),
                    None => "split the scene into smaller files".into(),
                };
                let what = format!(
                    "{}: at {wanted} texels a metre its surfaces need a lightmap of more than {MAX_SIDE}x{MAX_SIDE} texels",
                    path.display()
                );
                Error::unsupported(what, remedy)
            })
        }
        Density::Side(side) => fullest(side).ok_or_else(|| {
            let what =
                format!("{}: its surfaces do not fit a lightmap of {side}x{side} texels", path.display());
            Error::unsupported(what, "choose a larger size, or split the scene into smaller files")
        }),
    }
}

fn png(path: &Path, bytes: &[u8], [width, height]: [u32; 2], color: ExtendedColorType) -> Result<Vec<u8>> {
    let mut out = Cursor::new(Vec::new());
    let written = PngEncoder::new(&mut out).write_image(bytes, width, height, color);
    written.map_err(|e| Error::io(path, "encode the lightmap for", std::io::Error::other(e)))?;
    Ok(out.into_inner())
}
