//! A generator hall at night: the interior of "Deferred versus forward shading" (4.8.2). 72 instances of meshes with
//! colour, roughness and normal textures, a few of which glow; the moon through the roof, three spots with shadows,
//! and five point lights without. Most lights do not overlap; those between the two generators do.

mod furniture;
mod palette;
mod surface;

use super::glb::{Glb, Light, LightKind, Pose};
use super::mesh::Mesh;
use glam::Vec3;
use palette::Palette;

/// Inside, from wall to wall, x and z; up to the beams.
const HALL_M: [f32; 2] = [16.0, 12.0];
const HEIGHT_M: f32 = 5.0;
/// Edge of floor and wall panels.
const PANEL_M: f32 = 4.0;
/// Where the generators stand: x and z.
const GENERATORS_M: [[f32; 2]; 2] = [[-2.6, -1.6], [2.6, -1.6]];
/// Where the ceiling lamps with spots hang.
const SPOTS_M: [[f32; 2]; 3] = [[-5.6, 3.2], [0.0, -1.4], [5.8, 2.6]];
/// The lower edge of their shades.
const LAMP_HEIGHT_M: f32 = HEIGHT_M - 1.1;
/// Where the point lights' fixtures are.
const POINTS_M: [[f32; 3]; 5] =
    [[-7.94, 2.6, -2.8], [7.94, 2.6, -2.8], [0.0, 2.4, -5.94], [-7.94, 2.6, 3.4], [4.4, 1.2, 5.94]];
/// The meshes that are placed; the test counts them.
#[cfg(test)]
const INSTANCES: usize = 72;

/// The file's bytes.
pub fn glb() -> Vec<u8> {
    let mut glb = Glb::default();
    let palette = Palette::new(&mut glb);
    shell(&mut glb, &palette);
    furniture::build(&mut glb, &palette);
    lights(&mut glb);
    let view = |from: [f32; 3], target: [f32; 3]| Pose::looking(Vec3::from(from), Vec3::from(target));
    glb.perspective("main", 58.0, view([-6.3, 2.1, 5.3], [1.6, 1.25, -2.2]));
    glb.perspective("door", 60.0, view([6.9, 2.3, -2.9], [-2.0, 1.3, 1.2]));
    glb.perspective("above", 62.0, view([0.0, 4.7, 5.6], [0.0, 0.4, -1.6]));
    glb.finish("interior")
}

/// From the nearest wall into the room.
fn inward([x_m, _, z_m]: [f32; 3]) -> Vec3 {
    let [half_x, half_z] = HALL_M.map(|m| m / 2.0);
    if half_x - x_m.abs() < half_z - z_m.abs() { Vec3::X * -x_m.signum() } else { Vec3::Z * -z_m.signum() }
}

/// One mesh of one material, for any number of places.
fn part(glb: &mut Glb, name: &str, shape: &Mesh, material: usize) -> usize {
    let geometry = glb.geometry(&shape.clone().with_tangents());
    glb.mesh(name, &[(&geometry, material)])
}

/// Floor, walls, door, columns and the beams that let the moon in: 12 + 14 + 1 + 8 + 5.
fn shell(glb: &mut Glb, palette: &Palette) {
    use super::shape::cuboid;
    let [half_x, half_z] = HALL_M.map(|m| m / 2.0);
    let floor = part(glb, "floor", &cuboid(Vec3::new(PANEL_M, 0.2, PANEL_M), 0.012), palette.floor);
    for x in 0..4 {
        for z in 0..3 {
            let [x_m, z_m] = [(x as f32 - 1.5) * PANEL_M, (z as f32 - 1.0) * PANEL_M];
            glb.place("floor", floor, Pose::at(x_m, -0.1, z_m));
        }
    }
    let panel = part(glb, "wall", &furniture::wall_panel(PANEL_M, HEIGHT_M), palette.wall);
    // Every panel's front is +z.
    for i in 0..4 {
        let x_m = (i as f32 - 1.5) * PANEL_M;
        glb.place("wall north", panel, Pose::at(x_m, 0.0, -half_z));
        glb.place("wall south", panel, Pose::at(x_m, 0.0, half_z).turned(0.5));
    }
    for i in 0..3 {
        let z_m = (i as f32 - 1.0) * PANEL_M;
        glb.place("wall west", panel, Pose::at(-half_x, 0.0, z_m).turned(0.25));
        glb.place("wall east", panel, Pose::at(half_x, 0.0, z_m).turned(-0.25));
    }
    let door = part(glb, "door", &furniture::door(), palette.door);
    glb.place("door", door, Pose::at(half_x - 0.06, 0.0, 0.0).turned(-0.25));
    let column = part(glb, "column", &furniture::column(HEIGHT_M), palette.steel);
    for x_m in [-half_x + 0.3, -PANEL_M / 2.0 - 2.0, PANEL_M / 2.0 + 2.0, half_x - 0.3] {
        for z_m in [-half_z + 0.3, half_z - 0.3] {
            glb.place("column", column, Pose::at(x_m, 0.0, z_m));
        }
    }
    let beam = part(glb, "beam", &cuboid(Vec3::new(0.3, 0.42, HALL_M[1]), 0.03), palette.steel);
    for i in 0..5 {
        glb.place("beam", beam, Pose::at((i as f32 - 2.0) * 3.6, HEIGHT_M - 0.21, 0.0));
    }
}

/// The moon, three spots with shadows, five points without. Candela are such that surfaces a metre or two away come
/// out near 1 nit.
fn lights(glb: &mut Glb) {
    let moon = LightKind::Directional { illuminance_lx: 1.1 };
    let moon = Light { name: "moon", color: Vec3::new(0.45, 0.62, 1.0), kind: moon };
    glb.light(moon, Pose::looking(Vec3::new(2.6, 6.0, 3.4), Vec3::ZERO));
    let warm = Vec3::new(1.0, 0.76, 0.48);
    for [x_m, z_m] in SPOTS_M {
        let kind = LightKind::Spot { intensity_cd: 150.0, range_m: 7.0, inner_rad: 0.36, outer_rad: 0.62 };
        let from = Vec3::new(x_m, LAMP_HEIGHT_M - 0.02, z_m);
        glb.light(Light { name: "spot", color: warm, kind }, Pose::looking(from, from - Vec3::Y));
    }
    let colors = [
        Vec3::new(0.25, 0.9, 1.0),
        Vec3::new(1.0, 0.35, 0.18),
        Vec3::new(0.35, 1.0, 0.55),
        Vec3::new(0.6, 0.5, 1.0),
        Vec3::new(1.0, 0.62, 0.25),
    ];
    for (at, color) in POINTS_M.into_iter().zip(colors) {
        let kind = LightKind::Point { intensity_cd: 8.0, range_m: 4.2 };
        let at = Vec3::from(at) + 0.4 * inward(at);
        let node = glb.light(Light { name: "lamp", color, kind }, Pose::at(at.x, at.y, at.z));
        glb.extras(node, serde_json::json!({"shadow": false}));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hall_has_what_the_dissertation_counts() {
        let file = glb();
        let length = u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize;
        let json: serde_json::Value = serde_json::from_slice(&file[20..20 + length]).unwrap();
        let nodes = json["nodes"].as_array().unwrap();
        let with = |key: &str| nodes.iter().filter(|n| n.get(key).is_some()).count();
        assert_eq!(with("mesh"), INSTANCES);
        assert_eq!(with("extensions"), 1 + 3 + 5);
        assert_eq!(with("extras"), 5);
        for material in json["materials"].as_array().unwrap() {
            let pbr = &material["pbrMetallicRoughness"];
            let textured = !pbr["baseColorTexture"].is_null() && !pbr["metallicRoughnessTexture"].is_null();
            assert!(textured && !material["normalTexture"].is_null(), "{material}");
        }
    }
}
