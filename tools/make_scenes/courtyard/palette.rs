//! The courtyard's materials.

use super::super::glb::{Glb, Material};
use super::super::texture::{linear, masked_picture, picture, srgb};
use super::surface;
use glam::Vec3;

/// Material indices.
pub struct Palette {
    pub paving: usize,
    pub wall: usize,
    pub limestone: usize,
    pub distant: usize,
    pub bronze: usize,
    pub copper: usize,
    pub iron: usize,
    pub wood: usize,
    pub water: usize,
    pub terracotta: usize,
    pub lattice: usize,
    pub leaves: usize,
    pub awning: usize,
    /// Crimson, teal.
    pub banners: [usize; 2],
    pub lantern_glass: usize,
    pub window: usize,
    /// Gold, coral, turquoise, violet.
    pub bulbs: [usize; 4],
    pub sky: usize,
}

/// Linear Rec.709 of the festoon's bulbs, in the order of [`Palette::bulbs`]; their lights share it.
pub const BULB_COLORS: [Vec3; 4] = [
    Vec3::new(1.0, 0.52, 0.12),
    Vec3::new(1.0, 0.18, 0.1),
    Vec3::new(0.06, 0.8, 0.7),
    Vec3::new(0.38, 0.2, 1.0),
];

/// Linear Rec.709 of a flame behind amber glass.
pub const AMBER: Vec3 = Vec3::new(1.0, 0.44, 0.12);

impl Palette {
    /// Draws the textures and adds all materials.
    pub fn new(glb: &mut Glb) -> Self {
        let paving = glb.textured("paving", &surface::paving(), 1.0 / 3.0);
        let wall = glb.textured("sandstone", &surface::wall(), 1.0 / 2.4);
        let limestone = glb.textured("limestone", &surface::limestone(), 1.0);
        let bronze = glb.textured("bronze", &surface::bronze(), 2.0);
        let iron = glb.textured("iron", &surface::iron(), 4.0);
        let wood = glb.textured("oak", &surface::wood(), 1.0 / 1.2);
        let weave = glb.texture("weave normal", &surface::cloth().normal());
        let ripples = glb.texture("ripples normal", &surface::water().normal());
        let banner_pictures =
            [("crimson banner", 0xb01c28), ("teal banner", 0x167a80)].map(|(name, field)| {
                glb.texture(name, &picture(256, |uv| surface::banner_color(uv, srgb(field))))
            });
        let lattice = glb.texture("lattice", &masked_picture(256, surface::lattice));
        let leaves = glb.texture("leaves", &masked_picture(256, surface::leaves));
        let plain = Material::default();
        let cloth = Material {
            roughness: 0.9,
            // One unit of the banner's texture coordinate is about a metre and a half.
            normal_texture: Some(weave.scaled(9.0)),
            double_sided: true,
            ..plain.clone()
        };
        let glowing = |name, emissive: Vec3, emissive_strength| Material {
            name,
            base_color: Vec3::splat(0.02),
            roughness: 0.3,
            emissive,
            emissive_strength,
            ..plain.clone()
        };
        let bulb_names = ["bulb gold", "bulb coral", "bulb turquoise", "bulb violet"];
        Self {
            distant: glb.material(&Material {
                name: "distant stone",
                base_color: linear(0x8a8694),
                roughness: 0.95,
                ..plain.clone()
            }),
            copper: glb.material(&Material {
                name: "copper",
                base_color: linear(0xf0a080),
                metallic: 1.0,
                roughness: 0.32,
                normal_texture: bronze.normal_texture,
                normal_scale: 0.6,
                ..plain.clone()
            }),
            water: glb.material(&Material {
                name: "water",
                base_color: linear(0x0e3038),
                roughness: 0.08,
                normal_texture: Some(ripples.scaled(1.0 / 1.5)),
                ..plain.clone()
            }),
            terracotta: glb.material(&Material {
                name: "terracotta",
                base_color: linear(0xa85a3a),
                roughness: 0.8,
                normal_texture: limestone.normal_texture,
                occlusion_texture: limestone.occlusion_texture,
                ..plain.clone()
            }),
            lattice: glb.material(&Material {
                name: "wrought iron lattice",
                base_color_texture: Some(lattice.scaled(2.5)),
                metallic: 0.6,
                roughness: 0.5,
                alpha_cutoff: Some(0.5),
                double_sided: true,
                ..plain.clone()
            }),
            leaves: glb.material(&Material {
                name: "leaves",
                base_color_texture: Some(leaves),
                roughness: 0.55,
                alpha_cutoff: Some(0.4),
                double_sided: true,
                ..plain.clone()
            }),
            awning: glb.material(&Material { name: "awning", ..cloth.clone() }),
            banners: banner_pictures.map(|emblem| {
                let base_color_texture = Some(emblem);
                glb.material(&Material { name: "banner", base_color_texture, ..cloth.clone() })
            }),
            lantern_glass: glb.material(&glowing("lantern glass", AMBER, 2.2)),
            window: glb.material(&glowing("lit window", Vec3::new(0.9, 0.5, 0.16), 1.0)),
            bulbs: [0, 1, 2, 3].map(|i| glb.material(&glowing(bulb_names[i], BULB_COLORS[i], 2.5))),
            sky: glb.material(&Material { name: "dusk sky", unlit: true, ..plain.clone() }),
            paving: glb.material(&paving),
            wall: glb.material(&wall),
            limestone: glb.material(&limestone),
            bronze: glb.material(&bronze),
            iron: glb.material(&iron),
            wood: glb.material(&wood),
        }
    }
}
