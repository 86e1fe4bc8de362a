//! Scenes whose lights cast shadows.

use super::*;
use ontile::scene::Shadow;

/// [`lit_textures`] with a light of every kind that casts shadows: solid, masked, mirrored and double-sided casters.
pub fn shadows() -> Scene {
    let mut scene = Scene { name: "shadows".into(), ..lit_textures() };
    for light in &mut scene.lights {
        light.shadow = Some(Shadow::default());
    }
    scene.lights.extend([slab(), wide_cone()]);
    scene
}

/// A light of each kind over a floor and before a wall, on which a ball and two posts cast shadows; nothing is textured.
/// What the camera sees is small parts of the floor and the wall and all of the rest.
pub fn one_light_each() -> Vec<Scene> {
    let sun = Light::new(LightKind::Directional { illuminance_lx: 2.0 }).towards(Vec3::new(-0.9, -1.0, -0.3));
    let spot = LightKind::Spot { intensity_cd: 30.0, inner_cone_rad: 0.5, outer_cone_rad: 0.6 };
    let spot = Light { position_world: Vec3::new(1.6, 3.4, 2.4), ..Light::new(spot) };
    let spot = spot.towards(Vec3::new(-0.5, -1.0, -0.8));
    let bulb = Light::new(LightKind::Point { intensity_cd: 12.0 });
    // Between the posts: shadows fall on all faces of the cube around it.
    let bulb = Light { position_world: Vec3::new(0.3, 1.3, 0.2), range_m: Some(9.0), ..bulb };
    [("sun", sun), ("slab", slab()), ("spot", spot), ("wide", wide_cone()), ("bulb", bulb)]
        .map(|(name, light)| {
            let light = Light { name: name.into(), shadow: Some(Shadow::default()), ..light };
            Scene { name: name.into(), lights: vec![light], ..room() }
        })
        .to_vec()
}

/// [`room`] under five lights: sun and bulb ask for volumes, which the box that asks for one cannot have; the spot asks for the map, and
/// the wide cone for neither.
pub fn chosen() -> Scene {
    let volume = |name: &str| match name {
        "spot" => Some(false),
        "wide" => None,
        _ => Some(true),
    };
    let mut scene = Scene { name: "chosen shadows".into(), ..room() };
    scene.lights = one_light_each().into_iter().flat_map(|scene| scene.lights).collect();
    for light in &mut scene.lights {
        light.shadow = Some(Shadow { volume: volume(&light.name), ..Shadow::default() });
    }
    scene
}

/// Floor, wall, ball and posts in the dark.
pub fn room() -> Scene {
    let mut scene = Scene { name: "room".into(), cameras: vec![camera()], ..Scene::default() };
    let floor = Mat4::from_rotation_x(-PI / 2.0) * Mat4::from_scale(Vec3::splat(4.0));
    let wall = at(0.0, 2.0, -2.0) * Mat4::from_scale(Vec3::splat(4.0));
    add(&mut scene, square(), rough("floor", Vec3::splat(0.6)), &[floor, wall]);
    let ball = at(-0.3, 0.8, 0.3) * Mat4::from_scale(Vec3::splat(0.5));
    add(&mut scene, sphere(), rough("ball", Vec3::new(0.7, 0.4, 0.3)), &[ball]);
    let posts =
        [at(1.0, 0.8, -0.4), at(0.6, 0.4, 1.1)].map(|m| m * Mat4::from_scale(Vec3::new(0.15, 0.8, 0.15)));
    add(&mut scene, cube(), rough("post", Vec3::new(0.4, 0.5, 0.7)), &posts);
    scene
}

/// A light in a box that ends above the floor at one side.
fn slab() -> Light {
    let kind = LightKind::Box { illuminance_lx: 2.5, size_m: Vec3::new(4.0, 3.0, 6.0), falloff_m: 0.4 };
    let light = Light { name: "slab".into(), position_world: Vec3::new(0.0, 1.5, 0.5), ..Light::new(kind) };
    Light { shadow: Some(Shadow::default()), ..light.towards(Vec3::new(0.6, -1.0, -0.5)) }
}

/// A spot light that takes six views.
fn wide_cone() -> Light {
    let kind = LightKind::Spot { intensity_cd: 10.0, inner_cone_rad: 0.8, outer_cone_rad: 1.4 };
    let light = Light { name: "wide".into(), position_world: Vec3::new(-1.2, 2.2, 1.4), ..Light::new(kind) };
    Light { shadow: Some(Shadow::default()), ..light.towards(Vec3::new(0.4, -1.0, -0.6)) }
}

/// Of half extent 1, with hard edges.
fn cube() -> Mesh {
    let mut mesh = Mesh::default();
    for axis in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z] {
        let (a, b) = axis.any_orthonormal_pair();
        // (a, b, axis) is right-handed.
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(s, t)| axis + a * s + b * t);
        let first = mesh.positions.len() as u32;
        mesh.indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
        mesh.positions.extend(corners);
        mesh.normals.extend([axis; 4]);
    }
    mesh
}
