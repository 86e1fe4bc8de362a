//! The hall's materials.

use super::super::glb::{Glb, Material};
use super::super::texture::picture;
use super::surface;
use glam::Vec3;

/// Material indices.
pub struct Palette {
    pub floor: usize,
    pub wall: usize,
    pub door: usize,
    pub steel: usize,
    pub casing: usize,
    pub wood: usize,
    /// Glows.
    pub screen: usize,
    /// Glows, warm.
    pub lamp: usize,
    /// Glows, cool.
    pub fixture: usize,
}

impl Palette {
    /// Draws the textures and adds all materials.
    pub fn new(glb: &mut Glb) -> Self {
        let floor = glb.textured("tread plate", &surface::tread(), 1.0);
        let wall = glb.textured("wall panels", &surface::panels(), 0.5);
        let door = glb.textured("hazard stripes", &surface::hazard(), 1.0);
        let steel = glb.textured("steel", &surface::steel(), 2.0);
        let casing = glb.textured("casing", &surface::casing(), 2.0);
        let wood = glb.textured("crate", &surface::crate_side(), 1.0);
        let shown = glb.texture("screen", &picture(128, surface::screen));
        let glowing = |name, emissive: Vec3, emissive_strength| Material {
            name,
            base_color: Vec3::splat(0.1),
            emissive,
            emissive_strength,
            ..steel.clone()
        };
        let screen = Material { emissive_texture: Some(shown), ..glowing("screen", Vec3::ONE, 1.5) };
        Self {
            screen: glb.material(&screen),
            lamp: glb.material(&glowing("lamp", Vec3::new(1.0, 0.78, 0.5), 3.0)),
            fixture: glb.material(&glowing("fixture", Vec3::new(0.7, 0.9, 1.0), 1.6)),
            floor: glb.material(&floor),
            wall: glb.material(&wall),
            door: glb.material(&door),
            steel: glb.material(&steel),
            casing: glb.material(&casing),
            wood: glb.material(&wood),
        }
    }
}
