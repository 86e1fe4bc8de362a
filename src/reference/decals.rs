//! What decals make of a surface before it is lit: the counterpart of `decal.frag`.

use glam::{DMat4, DVec2, DVec3, DVec4};

use super::brdf::DIELECTRIC_F0;
use super::gbuffer::Attributes;
use super::texture::{self, Encoding};
use crate::plan::{Channels, DecalKind};
use crate::scene::{Decal, Instance, Material, Scene, TextureRef};

/// A scene's decals in the order of painting.
pub(super) struct Painter<'a> {
    scene: &'a Scene,
    decals: Vec<Placed<'a>>,
}

struct Placed<'a> {
    decal: &'a Decal,
    material: &'a Material,
    textures: [Option<TextureRef>; 3],
    channels: Channels,
    decal_from_world: DMat4,
    axes_world: [DVec3; 3],
}

/// What of a surface comes from which of two.
fn replace(old: &Attributes, new: &Attributes, channels: Channels) -> Attributes {
    let color = channels.base_color || channels.metallic;
    Attributes {
        normal_world: if channels.normal { new.normal_world } else { old.normal_world },
        roughness: if channels.roughness { new.roughness } else { old.roughness },
        base_color: if color { new.base_color } else { old.base_color },
        metallic: if color { new.metallic } else { old.metallic },
        reflectance: if color { new.reflectance } else { old.reflectance },
        ..*old
    }
}

impl<'a> Painter<'a> {
    /// # Panics
    /// If a decal's material is none of the scene's.
    pub(super) fn new(scene: &'a Scene) -> Self {
        let mut order: Vec<&Decal> = scene.decals.iter().collect();
        order.sort_by(|a, b| a.priority.total_cmp(&b.priority));
        let placed = |decal: &'a Decal| {
            let material = &scene.materials[decal.material];
            let kind = DecalKind::new(scene, decal)?;
            Some(Placed {
                decal,
                material,
                textures: decal.textures(material),
                channels: kind.channels,
                decal_from_world: decal.decal_from_world(),
                axes_world: decal.axes_world(),
            })
        };
        Self { scene, decals: order.into_iter().filter_map(placed).collect() }
    }

    /// The surface after all decals. `store` is what storing a surface leaves of it; only channels that a decal has painted are
    /// stored anew.
    pub(super) fn paint(&self, surface: Attributes, store: impl Fn(&Attributes) -> Attributes) -> Attributes {
        if !surface.lit {
            return surface;
        }
        self.decals.iter().fold(surface, |surface, placed| match placed.paint(self.scene, &surface) {
            Some(painted) => replace(&surface, &store(&painted), placed.channels),
            None => surface,
        })
    }

    /// Whether what surfaces reflect of light from all around is looked at once they are painted: not where a lightmap has the diffuse
    /// part of it.
    pub(super) fn changes_light(&self) -> bool {
        let has_part = |instance: &Instance| {
            let mesh = &self.scene.meshes[instance.mesh];
            let is_lit = !self.scene.materials[mesh.material].unlit;
            instance.lightmap.is_some() && !mesh.texcoords[1].is_empty() && is_lit
        };
        let is_lightmapped = self.scene.lightmap.is_some() && self.scene.drawn_instances().any(has_part);
        !self.decals.is_empty() && !is_lightmapped
    }

    /// Whether rounding of the place may decide whether a decal is painted there: it is at a face without falloff.
    pub(super) fn is_at_edge(&self, position_world: DVec3) -> bool {
        /// As a share of the box.
        const NEAR: f64 = 1e-3;
        self.decals.iter().any(|placed| {
            let place = placed.decal_from_world.transform_point3(position_world).abs();
            let falloff = placed.decal.falloff_share();
            let beside = 0.5 - place;
            beside.min_element() > -NEAR && (0..3).any(|axis| beside[axis] < NEAR && falloff[axis] < NEAR)
        })
    }
}

impl Placed<'_> {
    /// `None` where nothing is painted.
    fn paint(&self, scene: &Scene, surface: &Attributes) -> Option<Attributes> {
        let Self { decal, material, channels, .. } = self;
        let normal = surface.normal_world;
        let place = self.decal_from_world.transform_point3(surface.position_world);
        let weight = decal.weight_at(place) * decal.weight_facing(normal.dot(self.axes_world[2]));
        let texcoord = DVec2::new(place.x + 0.5, 0.5 - place.y);
        let texel = |slot: usize, encoding| {
            self.textures[slot].as_ref().map(|slot| texture::sample(scene, slot, texcoord, encoding))
        };
        let color = material.base_color_factor.as_dvec4() * texel(0, Encoding::Srgb).unwrap_or(DVec4::ONE);
        let weight = weight * color.w;
        // As there, what is no number paints nothing.
        if weight.is_nan() || weight <= 0.0 {
            return None;
        }
        let [base_color, of_normal, roughness, metallic] =
            decal.channels.to_array().map(|opacity| f64::from(opacity) * weight);
        let texel_mr = texel(1, Encoding::Linear).unwrap_or(DVec4::ONE);
        let mut painted = *surface;
        if channels.base_color || channels.metallic {
            let (old_color, old_metallic) = base_metallic(surface);
            let new_color =
                old_color.lerp(color.truncate(), if channels.base_color { base_color } else { 0.0 });
            let own = f64::from(material.metallic_factor) * texel_mr.z;
            let new_metallic =
                old_metallic + (own - old_metallic) * if channels.metallic { metallic } else { 0.0 };
            painted =
                Attributes { base_color: new_color, metallic: new_metallic, reflectance: None, ..painted };
        }
        if channels.roughness {
            let own = f64::from(material.roughness_factor) * texel_mr.y;
            painted.roughness += (own - painted.roughness) * roughness;
        }
        if channels.normal {
            let texel = texel(2, Encoding::Linear).unwrap_or(DVec4::new(0.5, 0.5, 1.0, 1.0)).truncate();
            painted.normal_world = self.normal_world(normal, texel, of_normal);
        }
        Some(painted)
    }

    /// Reoriented, then mixed and made unit length; see [`Decal`].
    fn normal_world(&self, normal: DVec3, texel: DVec3, weight: f64) -> DVec3 {
        let right = self.axes_world[0];
        let tangent = (right - normal * right.dot(normal)).normalize_or_zero();
        let bitangent = normal.cross(tangent) * self.decal.handedness();
        let scale = f64::from(self.material.normal_scale);
        let sampled = ((texel * 2.0 - 1.0) * DVec3::new(scale, scale, 1.0)).normalize_or_zero();
        let mixed = DVec3::Z.lerp(sampled, weight);
        (tangent * mixed.x + bitangent * mixed.y + normal * mixed.z).normalize_or_zero()
    }
}

/// Base colour and metallicness; of a surface whose products of both are known, what they may have been: exact for dielectrics and
/// metals, and of other answers one with little metal.
fn base_metallic(surface: &Attributes) -> (DVec3, f64) {
    let Some(f0) = surface.reflectance else { return (surface.base_color, surface.metallic) };
    let diffuse = surface.base_color;
    let metal = (f0 - DIELECTRIC_F0).max(DVec3::ZERO).max_element();
    let most = metal + diffuse.max_element();
    let metallic = if most > 0.0 { metal / most } else { 0.0 };
    ((diffuse + f0 - DIELECTRIC_F0 * (1.0 - metallic)).max(DVec3::ZERO), metallic)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::DecalChannels;
    use glam::{Mat4, Vec3, Vec4};

    fn scene(decals: Vec<Decal>) -> Scene {
        let red = Material {
            base_color_factor: Vec4::new(1.0, 0.0, 0.0, 0.5),
            metallic_factor: 1.0,
            roughness_factor: 0.2,
            ..Material::default()
        };
        Scene { materials: vec![red], decals, ..Scene::default() }
    }

    fn surface() -> Attributes {
        Attributes {
            lit: true,
            depth: 0.5,
            normal_world: DVec3::Z,
            roughness: 0.8,
            base_color: DVec3::splat(0.4),
            ..Attributes::default()
        }
    }

    fn painted(scene: &Scene, surface: Attributes) -> Attributes {
        Painter::new(scene).paint(surface, |s| *s)
    }

    #[test]
    fn channels_are_painted_by_themselves_and_by_alpha() {
        let whole = Decal::new(0, Mat4::IDENTITY);
        let only = |channels| scene(vec![Decal { channels, ..whole.clone() }]);
        let all = painted(&scene(vec![whole.clone()]), surface());
        assert!((all.base_color - DVec3::new(0.7, 0.2, 0.2)).length() < 1e-6, "{}", all.base_color);
        assert!((all.metallic - 0.5).abs() < 1e-6 && (all.roughness - 0.5).abs() < 1e-6);
        let rough = painted(&only(DecalChannels { roughness: 1.0, ..DecalChannels::NONE }), surface());
        assert_eq!((rough.base_color, rough.metallic), (surface().base_color, 0.0));
        assert_eq!(rough.roughness, all.roughness);
        assert_eq!(painted(&only(DecalChannels::NONE), surface()), surface());
    }

    #[test]
    fn what_is_outside_or_faces_away_or_is_not_lit_stays() {
        let decals = scene(vec![Decal::new(0, Mat4::IDENTITY)]);
        for other in [
            Attributes { position_world: DVec3::new(0.0, 0.0, 0.51), ..surface() },
            Attributes { normal_world: DVec3::X, ..surface() },
            Attributes { normal_world: DVec3::NEG_Z, ..surface() },
            Attributes { lit: false, ..surface() },
        ] {
            assert_eq!(painted(&decals, other), other);
        }
    }

    #[test]
    fn later_ones_and_higher_priorities_are_on_top() {
        let opaque = Decal { channels: DecalChannels::COLOR, ..Decal::new(0, Mat4::IDENTITY) };
        let mut scene = scene(vec![opaque.clone(), Decal { material: 1, ..opaque }]);
        scene.materials[0].base_color_factor.w = 1.0;
        scene
            .materials
            .push(Material { base_color_factor: Vec4::new(0.0, 0.0, 1.0, 1.0), ..Material::default() });
        assert_eq!(painted(&scene, surface()).base_color, DVec3::Z);
        scene.decals[0].priority = 1.0;
        assert_eq!(painted(&scene, surface()).base_color, DVec3::X);
        scene.decals[0].world_from_decal = Mat4::from_translation(Vec3::X * 2.0);
        assert_eq!(painted(&scene, surface()).base_color, DVec3::Z);
    }

    #[test]
    fn products_are_taken_apart() {
        for (color, metallic) in [(DVec3::new(0.8, 0.3, 0.1), 0.0), (DVec3::new(0.9, 0.6, 0.2), 1.0)] {
            let whole = Attributes { base_color: color, metallic, ..surface() };
            let products = Attributes {
                base_color: whole.diffuse(),
                metallic: 0.0,
                reflectance: Some(whole.f0()),
                ..surface()
            };
            let (again, metal) = base_metallic(&products);
            assert!((again - color).length() < 1e-9 && (metal - metallic).abs() < 1e-9, "{again}, {metal}");
        }
    }
}
