//! What a surface is like where a ray meets it: the counterpart of the geometry stage.

use glam::{DVec3, DVec4};

use super::around::Around;
use super::media::remaining;
use super::texture::{self, Encoding};
use super::view::View;
use super::visibility::{Hit, Visibility};
use crate::scene::{Material, Mesh, TextureRef, Transmission};

/// The content of one G-buffer pixel. The default is the background: not lit, dark.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Attributes {
    /// Whether lights apply: false for the background and for unlit materials.
    pub lit: bool,
    /// Reversed depth, 0 in the background.
    pub depth: f64,
    /// World space, metres.
    pub position_world: DVec3,
    /// World space, unit length, normal map included; zero where not lit.
    pub normal_world: DVec3,
    /// Perceptual, as in the material: not yet clamped.
    pub roughness: f64,
    /// Linear Rec.709.
    pub base_color: DVec3,
    /// 0 dielectric to 1 metal.
    pub metallic: f64,
    /// Reflectance at normal incidence where it was stored by itself, and the base colour is all diffuse (specular workflow);
    /// else it follows from base colour and metallicness.
    pub reflectance: Option<DVec3>,
    /// Light that needs no light source, in cd/m² before exposure: emission and ambient light, or an unlit
    /// material's base colour.
    pub prelit: DVec3,
}

/// A triangle's vertex attributes weighted by the barycentric coordinates of a hit.
///
/// Linear on the triangle in world space, which is what a rasteriser's perspective-correct interpolation gives.
pub(super) struct Interpolated<'a> {
    pub mesh: &'a Mesh,
    pub material: &'a Material,
    /// From vertex normals of unit length in world space; not normalised again.
    pub normal_world: DVec3,
    /// Vertex colour, 1 without.
    pub color: DVec4,
}

pub(super) fn interpolate<'a>(visibility: &Visibility<'a>, hit: &Hit) -> Interpolated<'a> {
    let triangle = &visibility.triangles[hit.triangle as usize];
    let scene = visibility.scene;
    let mesh = &scene.meshes[scene.instances[triangle.instance as usize].mesh];
    let normal_world = match corner_normals(visibility, hit.triangle) {
        Some(normals) => weighted(hit, |k| normals[k]),
        None => visibility.front_normal(hit),
    };
    let color = if mesh.colors.is_empty() {
        DVec4::ONE
    } else {
        let corner = |k: usize| mesh.colors[triangle.vertices[k] as usize].as_dvec4() * hit.barycentric[k];
        corner(0) + corner(1) + corner(2)
    };
    Interpolated { mesh, material: &scene.materials[mesh.material], normal_world, color }
}

/// The vertex normals of a triangle in world space, unit length (or zero); `None` if its mesh has none.
pub(super) fn corner_normals(visibility: &Visibility, triangle: u32) -> Option<[DVec3; 3]> {
    let triangle = &visibility.triangles[triangle as usize];
    let placement = &visibility.placements[triangle.instance as usize];
    let index = visibility.scene.instances[triangle.instance as usize].mesh;
    let mesh = &visibility.scene.meshes[index];
    let normal = |vertex: u32| {
        let normal = match &visibility.posed[index] {
            Some(posed) => posed.normals[vertex as usize],
            None => mesh.normals[vertex as usize].as_dvec3(),
        };
        (placement.normal_world_from_object * normal).normalize_or_zero()
    };
    (!mesh.normals.is_empty()).then(|| triangle.vertices.map(normal))
}

fn weighted(hit: &Hit, corner: impl Fn(usize) -> DVec3) -> DVec3 {
    (0..3).map(|k| corner(k) * hit.barycentric[k]).sum()
}

/// The alpha that masks: factor, texture and vertex alpha multiplied.
pub(super) fn alpha(visibility: &Visibility, hit: &Hit) -> f64 {
    let surface = interpolate(visibility, hit);
    base_color(visibility, hit, &surface).w
}

fn base_color(visibility: &Visibility, hit: &Hit, surface: &Interpolated) -> DVec4 {
    let texture = slot(visibility, hit, surface.mesh, &surface.material.base_color_texture, Encoding::Srgb);
    surface.material.base_color_factor.as_dvec4() * texture * surface.color
}

/// What a surface that light goes through is made of: its transmission, base colour and metallicness; `None` if it lets none through.
pub(super) fn medium<'a>(visibility: &Visibility<'a>, hit: &Hit) -> Option<(&'a Transmission, DVec3, f64)> {
    let surface = interpolate(visibility, hit);
    let transmission = surface.material.transmits()?;
    let color = base_color(visibility, hit, &surface).truncate();
    let slot =
        slot(visibility, hit, surface.mesh, &surface.material.metallic_roughness_texture, Encoding::Linear);
    Some((transmission, color, f64::from(surface.material.metallic_factor) * slot.z))
}

/// The part of arriving light that the surface reflects in all, to whichever directions: 0 where it is unlit.
pub(super) fn diffuse_albedo(visibility: &Visibility, hit: &Hit) -> DVec3 {
    let surface = interpolate(visibility, hit);
    if surface.material.unlit {
        return DVec3::ZERO;
    }
    // glTF allows vertex colours above 1, which no surface reflects.
    base_color(visibility, hit, &surface).truncate().clamp(DVec3::ZERO, DVec3::ONE)
}

/// Radiance in cd/m² that the surface sends whatever arrives: emission, or an unlit material's base colour.
pub(super) fn own_light(visibility: &Visibility, hit: &Hit) -> DVec3 {
    let surface = interpolate(visibility, hit);
    if surface.material.unlit {
        return base_color(visibility, hit, &surface).truncate();
    }
    emission(visibility, hit, &surface)
}

fn emission(visibility: &Visibility, hit: &Hit, surface: &Interpolated) -> DVec3 {
    let texel = slot(visibility, hit, surface.mesh, &surface.material.emissive_texture, Encoding::Srgb);
    surface.material.emissive_factor.as_dvec3() * texel.truncate()
}

/// A texture slot's value at the hit; 1 in every channel for an empty slot.
fn slot(
    visibility: &Visibility,
    hit: &Hit,
    mesh: &Mesh,
    slot: &Option<TextureRef>,
    encoding: Encoding,
) -> DVec4 {
    let vertices = visibility.triangles[hit.triangle as usize].vertices;
    slot.as_ref().map_or(DVec4::ONE, |slot| {
        texture::sample_at(visibility.scene, mesh, vertices, hit.barycentric, slot, encoding)
    })
}

/// The shading normal, glTF 2.0 section 3.9.3: the normal map in the interpolated tangent frame (as
/// MikkTSpace asks, neither normalised nor orthogonalised again), reversed on back faces.
fn normal_world(visibility: &Visibility, hit: &Hit, surface: &Interpolated) -> DVec3 {
    let facing = if hit.front_facing { 1.0 } else { -1.0 };
    let normal = surface.normal_world;
    if surface.material.normal_texture.is_none() {
        return normal.normalize_or_zero() * facing;
    }
    let texel =
        slot(visibility, hit, surface.mesh, &surface.material.normal_texture, Encoding::Linear).truncate();
    let scale = f64::from(surface.material.normal_scale);
    let mapped = (texel * 2.0 - 1.0) * DVec3::new(scale, scale, 1.0);

    let triangle = &visibility.triangles[hit.triangle as usize];
    let placement = &visibility.placements[triangle.instance as usize];
    let posed = &visibility.posed[visibility.scene.instances[triangle.instance as usize].mesh];
    let tangent_object = |k: usize| -> (DVec3, f64) {
        let vertex = triangle.vertices[k] as usize;
        let own = || {
            let tangent = surface.mesh.tangents[vertex];
            (tangent.truncate().as_dvec3(), f64::from(tangent.w))
        };
        posed.as_ref().map_or_else(own, |posed| posed.tangents[vertex])
    };
    let tangent = weighted(hit, |k| {
        let (tangent, _) = tangent_object(k);
        placement.world_from_object.transform_vector3(tangent).normalize_or_zero()
    });
    // A mirroring transform turns cross(n, t) round, but not the surface's own bitangent.
    let mirror = if placement.mirrored { -1.0 } else { 1.0 };
    let bitangent = normal.cross(tangent) * (tangent_object(0).1 * mirror);
    (tangent * mapped.x + bitangent * mapped.y + normal * mapped.z).normalize_or_zero() * facing
}

/// Irradiance of the lightmap, if the instance has a part of it.
fn lightmap_lx(visibility: &Visibility, around: &Around, hit: &Hit, mesh: &Mesh) -> Option<DVec3> {
    let map = around.lightmap.as_ref()?;
    let rect = visibility.scene.instances[visibility.instance(hit)].lightmap?;
    let vertices = visibility.triangles[hit.triangle as usize].vertices;
    let texcoords = mesh.texcoords.get(1).filter(|set| !set.is_empty())?;
    let corner = |k: usize| texcoords[vertices[k] as usize].as_dvec2() * hit.barycentric[k];
    let texcoord = corner(0) + corner(1) + corner(2);
    Some(map.irradiance(rect.origin.as_dvec2() + texcoord * rect.size.as_dvec2()))
}

/// The surface at a hit as the geometry stage would write it, without quantisation.
pub fn attributes(
    visibility: &Visibility,
    around: &Around,
    view: &View,
    position_world: DVec3,
    hit: &Hit,
) -> Attributes {
    let (mut attributes, occlusion) = emitting(visibility, view, position_world, hit);
    if attributes.lit {
        let mesh = interpolate(visibility, hit).mesh;
        let to_viewer = view.to_viewer(position_world);
        attributes.prelit += match lightmap_lx(visibility, around, hit, mesh) {
            Some(light) => around.reflected_with_lightmap(&attributes, to_viewer, occlusion, light),
            None => around.reflected(&attributes, to_viewer, occlusion),
        };
    }
    attributes
}

/// The same without what it reflects of light from all around, and the share of that light which arrives.
pub fn emitting(visibility: &Visibility, view: &View, position_world: DVec3, hit: &Hit) -> (Attributes, f64) {
    let surface = interpolate(visibility, hit);
    let material = surface.material;
    let base_color = base_color(visibility, hit, &surface).truncate();
    let depth = view.depth_from_distance(hit.distance);
    if material.unlit {
        let unlit =
            Attributes { depth, position_world, base_color, prelit: base_color, ..Attributes::default() };
        return (unlit, 1.0);
    }
    let texel = |texture, encoding| slot(visibility, hit, surface.mesh, texture, encoding);
    let metallic_roughness = texel(&material.metallic_roughness_texture, Encoding::Linear);
    let mut attributes = Attributes {
        lit: true,
        depth,
        position_world,
        normal_world: normal_world(visibility, hit, &surface),
        roughness: f64::from(material.roughness_factor) * metallic_roughness.y,
        base_color,
        metallic: f64::from(material.metallic_factor) * metallic_roughness.z,
        reflectance: None,
        prelit: emission(visibility, hit, &surface),
    };
    if let Some(transmission) = material.transmits() {
        attributes = remaining(transmission, &attributes);
    }
    // glTF 2.0 section 3.9.3: 1 + strength * (sample - 1).
    let occlusion = texel(&material.occlusion_texture, Encoding::Linear).x;
    (attributes, 1.0 + f64::from(material.occlusion_strength) * (occlusion - 1.0))
}
