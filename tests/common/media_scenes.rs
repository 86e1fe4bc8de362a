//! Scenes in which light goes through surfaces.

use ontile::scene::Transmission;

use super::glass_scenes::pane;
use super::particle_scenes::sparks_and_glass;
use super::*;

/// All of them.
pub fn all() -> Vec<Scene> {
    vec![water(), water_in_fog(), water_and_more(), water_alone()]
}

/// [`lights_only`] under water that balls stand out of, with a window of thin tinted glass over it and a block of clear glass.
pub fn water() -> Scene {
    with_water("water", lights_only())
}

/// [`foggy`] likewise, before a background colour.
pub fn water_in_fog() -> Scene {
    with_water("water_in_fog", foggy())
}

/// [`sparks_and_glass`] likewise.
pub fn water_and_more() -> Scene {
    with_water("water_and_more", sparks_and_glass())
}

/// Nothing else, before a background colour.
pub fn water_alone() -> Scene {
    let background = Background::Color(Vec3::new(0.5, 0.4, 0.3));
    let dark = Scene { cameras: vec![camera()], lights: lights(), background, ..Scene::default() };
    with_water("water_alone", dark)
}

/// Adds them.
pub fn with_water(name: &str, mut scene: Scene) -> Scene {
    scene.name = name.into();
    let sea = Transmission {
        factor: 0.9,
        ior: 1.333,
        thickness_m: 3.0,
        attenuation_color: Vec3::new(0.2, 0.6, 0.8),
        attenuation_distance_m: 0.5,
    };
    let medium = |name: &str, color, transmission| Material {
        roughness_factor: 0.3,
        transmission: Some(transmission),
        ..rough(name, color)
    };
    let lying = |y: f32, half: f32| {
        at(0.0, y, 0.8)
            * Mat4::from_rotation_x(-std::f32::consts::FRAC_PI_2)
            * Mat4::from_scale(Vec3::splat(half))
    };
    add(&mut scene, pane(), medium("sea", Vec3::new(0.9, 0.95, 1.0), sea), &[lying(0.3, 1.6)]);
    let thin = Transmission { factor: 0.7, ..Transmission::default() };
    let standing = at(-0.5, 0.7, 1.3) * Mat4::from_scale(Vec3::splat(0.3));
    add(&mut scene, pane(), medium("thin", Vec3::new(0.9, 0.5, 0.2), thin), &[standing]);
    // Half of it is there, and it lets metals' share through to nobody.
    let half = Material {
        base_color_factor: Vec4::new(0.8, 0.9, 0.7, 0.5),
        alpha_mode: AlphaMode::Blend,
        metallic_factor: 0.3,
        ..medium("half", Vec3::ONE, Transmission { thickness_m: 0.2, ..sea })
    };
    add(&mut scene, pane(), half, &[at(0.6, 0.8, 1.2) * Mat4::from_scale(Vec3::splat(0.25))]);
    scene
}
