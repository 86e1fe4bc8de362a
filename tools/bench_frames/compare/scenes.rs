//! The scenes that are compared. Those built here stand on the floor of the other measurements, seen from straight above, so
//! that what a light covers follows from its range and the camera's height.

use std::f32::consts::PI;

use glam::{Mat4, Vec3, vec3};
use ontile::glam;
use ontile::scene::{Camera, Light, LightKind, Mesh, Projection, Scene};
use ontile::{Error, Result};

use super::super::make_scenes;
use super::super::scenes::{FLOOR_M, add, floor, hue};

const OBJECTS: usize = 64;

/// The canyon, with some light from the sky.
pub fn exterior() -> Result<Scene> {
    let mut scene = load("canyon", &make_scenes::canyon::glb())?;
    scene.ambient_nt = vec3(0.18, 0.22, 0.3);
    Ok(scene)
}

/// The generator hall, with a little light from everywhere.
pub fn interior() -> Result<Scene> {
    let mut scene = load("interior", &make_scenes::Shipped::Interior.glb())?;
    scene.ambient_nt = Vec3::splat(0.03);
    Ok(scene)
}

/// The scene of `tools/scenes bench`: 64 objects on 24 m of floor under lights of 2 m range, seen from the side. Without
/// shadows, which the first few lights of a file would cast.
pub fn many_lights(lights: usize) -> Result<Scene> {
    let options = make_scenes::bench::Options {
        lights,
        objects: OBJECTS,
        range_m: 2.0,
        padding_bytes: 0,
        distinct: false,
    };
    Ok(load("floor", &make_scenes::bench::glb(&options))?.without_shadows())
}

/// As a file would be loaded: through one.
fn load(name: &str, glb: &[u8]) -> Result<Scene> {
    let folder = std::env::temp_dir();
    let file = tempfile::Builder::new().prefix(name).suffix(".glb").tempfile_in(&folder);
    let file = file.map_err(|e| Error::io(&folder, "write to", e))?;
    std::fs::write(file.path(), glb).map_err(|e| Error::io(file.path(), "write", e))?;
    let mut scene = Scene::load(file.path())?;
    scene.name = name.to_owned();
    Ok(scene)
}

/// The floor and its objects without lights, seen from above by a camera that sees `height_m` of the floor from top to
/// bottom. It stands so high that perspective changes sizes by few per cent.
fn seen_from_above(height_m: f32) -> Scene {
    let mut scene = floor(OBJECTS, 0, false);
    scene.cameras = vec![above(height_m)];
    scene
}

const CAMERA_M: f32 = 30.0;

fn above(height_m: f32) -> Camera {
    let yfov_rad = 2.0 * (height_m / 2.0 / CAMERA_M).atan();
    Camera {
        name: "above".into(),
        world_from_view: Mat4::from_translation(Vec3::Y * CAMERA_M) * Mat4::from_rotation_x(-PI / 2.0),
        projection: Projection::Perspective { yfov_rad, znear_m: 0.1, zfar_m: None },
    }
}

/// `count` lights that each light a disc of about 1 % of the screen, in an order that spreads them.
pub fn small_lights(count: usize, aspect: f32) -> Scene {
    const SIDE: usize = 16;
    // The screen is so high that all lights lie on the floor.
    let height_m = (FLOOR_M - 2.0) / aspect.max(1.0);
    let (width_m, range_m) = (height_m * aspect, disc_radius_m(0.01, height_m, aspect));
    let mut scene = seen_from_above(height_m);
    scene.name = format!("{count} lights of 1 % of the screen");
    scene.lights = (0..count)
        .map(|i| {
            // 107 and the number of cells have no common factor, so every cell is met once.
            let cell = (i * 107 + SIDE / 2 * (SIDE + 1)) % (SIDE * SIDE);
            let place =
                |cell: usize, extent_m: f32| ((cell as f32 + 0.5) / SIDE as f32 - 0.5) * (extent_m - range_m);
            point(i, vec3(place(cell % SIDE, width_m), 0.3, place(cell / SIDE, height_m)), range_m)
        })
        .collect();
    scene
}

/// 64 lights on a grid, so large that every pixel of the floor is in the range of `overlap` of them on average.
pub fn overlapping_lights(overlap: f32, aspect: f32) -> Scene {
    const SIDE: usize = 8;
    let height_m = (FLOOR_M - 2.0) / aspect.max(1.0);
    let range_m = disc_radius_m(overlap / (SIDE * SIDE) as f32, height_m, aspect);
    let mut scene = seen_from_above(height_m);
    scene.name = format!("64 lights, {overlap} at each pixel");
    scene.lights = (0..SIDE * SIDE)
        .map(|i| {
            let place = |cell: usize, extent_m: f32| ((cell as f32 + 0.5) / SIDE as f32 - 0.5) * extent_m;
            point(i, vec3(place(i % SIDE, height_m * aspect), 0.3, place(i / SIDE, height_m)), range_m)
        })
        .collect();
    scene
}

/// Of a disc that is this share of the screen.
fn disc_radius_m(share: f32, height_m: f32, aspect: f32) -> f32 {
    (share * height_m * height_m * aspect / PI).sqrt()
}

fn point(i: usize, position_world: Vec3, range_m: f32) -> Light {
    Light {
        name: format!("light {i}"),
        color: hue(i + 3),
        position_world,
        range_m: Some(range_m),
        ..Light::new(LightKind::Point { intensity_cd: 2.0 })
    }
}

fn spot(position_world: Vec3, range_m: f32, outer_cone_rad: f32) -> Light {
    let kind = LightKind::Spot { intensity_cd: 80.0, inner_cone_rad: 0.6 * outer_cone_rad, outer_cone_rad };
    Light { name: "spot".into(), position_world, range_m: Some(range_m), ..Light::new(kind) }
        .towards(Vec3::NEG_Y)
}

/// One spot that shines down, or two that overlap; `close` is so near that they light all that is seen.
pub fn spots(count: usize, close: bool) -> Scene {
    // The cone's disc on the floor has a radius of 3.5 m, which is about half of 8.8 m by 6.6 m.
    const ABOVE_M: f32 = 5.0;
    const DISC_M: f32 = 3.5;
    let apart_m = if count > 1 { 2.0 } else { 0.0 };
    let mut scene = seen_from_above(if close { 2.4 } else { 7.8 });
    scene.lights = (0..count)
        .map(|i| {
            let x_m = (i as f32 - (count - 1) as f32 / 2.0) * apart_m;
            spot(vec3(x_m, ABOVE_M, 0.0), 9.0, (DISC_M / ABOVE_M).atan())
        })
        .collect();
    scene
}

/// A small light on the floor and, if `floating`, a spot whose cone fills most of the screen and touches nothing.
pub fn floating(floating: bool) -> Scene {
    const FLOATING_M: f32 = 12.0;
    let mut scene = seen_from_above(6.0);
    scene.lights = vec![point(0, vec3(0.0, 0.3, 0.0), 1.0)];
    if floating {
        // It ends 6 m above the floor.
        scene.lights.push(spot(vec3(0.0, FLOATING_M, 0.0), 6.0, 1.0));
    }
    scene
}

/// One mesh of this many screen-filling layers, the farthest first, under 16 lights of which each pixel sees some. Being
/// one mesh, they cannot be sorted.
pub fn layers(count: usize) -> Scene {
    const STEP_M: f32 = 0.05;
    const QUADS: usize = 16;
    let mut scene = floor(1, 0, false);
    let height_m = 12.0;
    scene.cameras = vec![above(height_m)];
    let mut mesh = Mesh { name: "layers".into(), material: 0, ..Mesh::default() };
    for layer in 0..count {
        for z in 0..=QUADS {
            for x in 0..=QUADS {
                let [x_m, z_m] = [x, z].map(|i| (i as f32 / QUADS as f32 - 0.5) * FLOOR_M);
                mesh.positions.push(vec3(x_m, STEP_M * layer as f32, z_m));
                mesh.normals.push(Vec3::Y);
            }
        }
        for quad in 0..QUADS * QUADS {
            let side = QUADS as u32 + 1;
            let first = layer as u32 * side * side + (quad / QUADS) as u32 * side + (quad % QUADS) as u32;
            mesh.indices.extend([0, side, 1, 1, side, side + 1].map(|i| first + i));
        }
    }
    scene.meshes.clear();
    scene.instances.clear();
    add(&mut scene, mesh, Vec3::ZERO);
    let top_m = STEP_M * count as f32;
    scene.lights = (0..16)
        .map(|i| point(i, vec3((i % 4) as f32 * 5.0 - 7.5, top_m + 0.5, (i / 4) as f32 * 3.0 - 4.5), 4.0))
        .collect();
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_are_as_their_tables_say() {
        let lights = small_lights(256, 16.0 / 9.0).lights;
        let mut places: Vec<_> =
            lights.iter().map(|l| l.position_world.to_array().map(f32::to_bits)).collect();
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len(), 256, "two lights at one place");
        assert!(lights.iter().all(|l| l.position_world.abs().max_element() < FLOOR_M / 2.0));
        // The floating cone ends above everything that stands on the floor.
        let scene = floating(true);
        let cone = &scene.lights[1];
        let top_m = scene.bounds_world().unwrap().max.y;
        assert!(cone.position_world.y - cone.range_m.unwrap() > top_m);
        assert_eq!(floating(false).lights.len(), 1);
        let three = layers(3);
        assert_eq!((three.instances.len(), three.triangle_count()), (1, 3 * 2 * 16 * 16));
        assert_eq!((exterior().unwrap().instances.len(), interior().unwrap().instances.len()), (4, 72));
    }
}
