//! Scenes in which particles add light.

use ontile::scene::{Particle, Particles, Wrap};

use super::glass_scenes::{glass, glass_before_sky};
use super::*;

/// All of them.
pub fn all() -> Vec<Scene> {
    vec![sparks(), sparks_in_fog(), sparks_and_glass(), sparks_before_sky(), sparks_alone(), sparks_unlit()]
}

/// [`lights_only`] with sparks that floor and balls cut, some of them turned and textured, one behind a ball, and dark ones.
pub fn sparks() -> Scene {
    with_sparks("sparks", lights_only())
}

/// [`foggy`] likewise, before a background colour.
pub fn sparks_in_fog() -> Scene {
    with_sparks("sparks_in_fog", foggy())
}

/// [`glass`] likewise.
pub fn sparks_and_glass() -> Scene {
    with_sparks("sparks_and_glass", glass())
}

/// [`glass_before_sky`] likewise.
pub fn sparks_before_sky() -> Scene {
    with_sparks("sparks_before_sky", glass_before_sky())
}

/// Nothing else, before a background colour.
pub fn sparks_alone() -> Scene {
    let background = Background::Color(Vec3::new(0.1, 0.2, 0.4));
    let dark = Scene { cameras: vec![camera()], background, ..Scene::default() };
    with_sparks("sparks_alone", dark)
}

/// [`wholly_unlit`] likewise.
pub fn sparks_unlit() -> Scene {
    with_sparks("sparks_unlit", wholly_unlit())
}

/// Adds them in three lists: plain, textured, and of a material that emits nothing.
pub fn with_sparks(name: &str, mut scene: Scene) -> Scene {
    scene.name = name.into();
    let texture = glow(&mut scene);
    let emissive_factor = Vec3::new(0.9, 0.5, 0.2);
    let plain = Material { name: "plain spark".into(), emissive_factor, ..Material::default() };
    let textured = Material {
        name: "glow spark".into(),
        emissive_factor: Vec3::new(0.3, 0.6, 1.2),
        emissive_texture: Some(TextureRef { texture, texcoord: 0, uv_from_texcoord: TextureRef::IDENTITY }),
        ..Material::default()
    };
    let dark = Material { name: "dark spark".into(), ..Material::default() };
    let first = scene.materials.len();
    scene.materials.extend([plain, textured, dark]);
    let spark = |x: f32, y: f32, z: f32, size_m: f32, rotation_rad: f32| Particle {
        position_world: Vec3::new(x, y, z),
        size_m,
        rotation_rad,
        color: Vec3::new(1.0, 0.5 + 0.25 * x, 0.5),
    };
    let low = vec![
        spark(-0.6, 0.05, 0.9, 0.7, 0.0),
        spark(0.5, 0.1, 1.2, 0.5, 0.7),
        spark(0.0, 0.5, 0.0, 0.9, 0.2),
    ];
    let high = vec![
        spark(0.2, 0.6, 0.6, 1.1, 0.4),
        spark(-0.9, 0.5, 0.3, 0.8, -0.9),
        spark(1.1, 0.2, 0.8, 0.6, 2.0),
    ];
    let lists = [(first, 0.3, low), (first + 1, 0.15, high.clone()), (first + 2, 0.1, high)];
    scene.particles = lists.map(|(material, soft_m, list)| Particles::new(material, soft_m, list)).to_vec();
    scene
}

/// A round glow that is 0 at the square's edge, brighter on one side, in few texels: it is magnified wherever it is seen.
fn glow(scene: &mut Scene) -> usize {
    const SIDE: u32 = 12;
    let texel = |i: u32| {
        let at = Vec2::new((i % SIDE) as f32 + 0.5, (i / SIDE) as f32 + 0.5) / SIDE as f32 * 2.0 - 1.0;
        let left = (1.0 - at.length() * 1.1).clamp(0.0, 1.0);
        [left * 255.0, left * (140.0 + 100.0 * at.x), left * left * 255.0, 255.0].map(|x| x as u8)
    };
    let rgba8 = (0..SIDE * SIDE).flat_map(texel).collect();
    scene.images.push(Image { width: SIDE, height: SIDE, texels: rgba8, name: "glow".into() });
    let sampler = Sampler { wrap_u: Wrap::ClampToEdge, wrap_v: Wrap::ClampToEdge, ..Sampler::default() };
    scene.textures.push(Texture { image: scene.images.len() - 1, sampler });
    scene.textures.len() - 1
}
