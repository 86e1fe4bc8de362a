//! Lights with an extent, and lights whose numbers go to an end of what they may be.

use std::f32::consts::FRAC_PI_2;

use ontile::glam::{Mat4, Quat, Vec3};
use ontile::scene::{GlobeMap, GlobePicture, Image, Light, LightKind, Scene};

use crate::scenes::{Builder, big_floor, cameras, floor, light, material, on_floor, sphere, wall};

const SIZES: [Vec3; 2] = [Vec3::new(1.8, 1.2, 3.0), Vec3::new(1.4, 1.6, 2.2)];

fn boxed(illuminance_lx: f32, size_m: Vec3, falloff_m: f32) -> LightKind {
    LightKind::Box { illuminance_lx, size_m, falloff_m }
}

/// The light, turned about the way it shines.
fn rolled(light: Light, angle: f32) -> Light {
    let roll = Quat::from_axis_angle(light.direction_world, angle);
    Light { up_world: (roll * light.up_world).normalize(), ..light }
}

fn stage(name: &str, lights: Vec<Light>) -> Scene {
    Builder::new(name, cameras(Vec3::new(0.0, 2.4, 6.0), Vec3::new(0.0, 0.6, 0.0)), lights)
        .add(floor(), material(Vec3::new(0.7, 0.65, 0.6), 0.0, 0.6), big_floor())
        .add(floor(), material(Vec3::new(0.52, 0.6, 0.7), 0.0, 0.9), wall(Vec3::new(0.0, 2.0, -3.0), 5.0))
        .add(sphere(), material(Vec3::new(0.9, 0.9, 0.9), 0.0, 0.5), on_floor(-1.2, 0.0, 0.6))
        .add(sphere(), material(Vec3::new(1.0, 0.8, 0.4), 1.0, 0.5), on_floor(0.3, 0.3, 0.5))
        .add(sphere(), material(Vec3::new(0.2, 0.3, 0.9), 0.5, 0.4), on_floor(1.6, -0.4, 0.7))
        .0
}

/// Boxes (tilted, rolled; soft, with more falloff than there is room for, with an edge), hemispheres, back colours.
pub fn extents() -> Scene {
    let white = Vec3::ONE;
    let back = Vec3::new(0.2, 0.5, 1.0);
    let sun = LightKind::Directional { illuminance_lx: 0.3 };
    let hemisphere = |illuminance_lx| LightKind::Hemisphere { illuminance_lx };
    let sun = light(sun, Vec3::new(1.0, 0.9, 0.8), Vec3::new(-2.0, 3.0, 1.0), Vec3::ZERO, None);
    let sky = light(hemisphere(0.4), Vec3::new(0.5, 0.7, 1.0), Vec3::new(0.3, 4.0, -0.5), Vec3::ZERO, None);
    let side = light(hemisphere(0.1), Vec3::new(1.0, 0.3, 0.1), Vec3::X, Vec3::ZERO, None);
    let soft =
        light(boxed(2.0, SIZES[0], 0.5), white, Vec3::new(-1.4, 0.9, 0.3), Vec3::new(-1.0, 0.0, 0.0), None);
    let full =
        light(boxed(1.5, SIZES[1], 9.0), white, Vec3::new(1.5, 0.6, -0.2), Vec3::new(1.2, 0.0, -0.9), None);
    let sharp = light(
        boxed(1.0, Vec3::new(1.0, 3.0, 2.0), 0.0),
        white,
        Vec3::new(0.4, 1.9, -3.0),
        Vec3::new(0.1, 1.0, -4.0),
        None,
    );
    let lights = vec![
        Light { back_color: back, ..sun },
        Light { back_color: Vec3::new(0.4, 0.3, 0.2), ..sky },
        side,
        Light { color: Vec3::new(1.0, 0.4, 0.3), back_color: back, ..rolled(soft, 0.5) },
        Light { color: Vec3::new(0.3, 1.0, 0.3), ..rolled(full, -1.1) },
        rolled(sharp, 0.2),
    ];
    stage("extents", lights)
}

/// How far light that comes through [`globes`]' maps may be off, relatively: samplers may decode sRGB half a code wrongly
/// (as Direct3D's and so most hardware's rules have it), which is most at the darkest code.
pub const DECODED: f64 = 2.4 * 0.5 / DARKEST as f64;
const DARKEST: u32 = 150;

/// A picture whose colours change slowly, so that a sampler's few bits of weight do not matter, each side its own.
fn ramp(side: usize) -> Image {
    const SIDE: u32 = 64;
    let texel = |i: u32| {
        let at = |n: u32| (DARKEST + 105 * n / (SIDE - 1)) as u8;
        let mut color = [at(i % SIDE), at(i / SIDE), 255 - 20 * side as u8];
        color.rotate_left(side % 3);
        [color[0], color[1], color[2], 255]
    };
    let rgba8 = (0..SIDE * SIDE).flat_map(texel).collect();
    Image { name: format!("ramp {side}"), width: SIDE, height: SIDE, texels: rgba8 }
}

/// Lights of all kinds that shine through globe maps, turned; two narrow, one as wide as spots can be.
pub fn globes() -> Scene {
    let flat = |image, rotation_rad| Some(GlobeMap { picture: GlobePicture::Flat { image }, rotation_rad });
    let cube = GlobePicture::Cube { images: [0, 1, 2, 3, 4, 5] };
    let spot =
        |intensity_cd, outer_cone_rad| LightKind::Spot { intensity_cd, inner_cone_rad: 0.0, outer_cone_rad };
    let slide =
        light(spot(40.0, 0.4), Vec3::ONE, Vec3::new(-2.0, 3.0, 3.0), Vec3::new(-0.8, 0.6, -1.0), None);
    let wide = light(
        spot(2.0, FRAC_PI_2),
        Vec3::ONE,
        Vec3::new(2.5, 1.5, 1.0),
        Vec3::new(1.0, 0.5, -1.0),
        Some(6.0),
    );
    let window = light(
        boxed(1.0, Vec3::new(2.5, 1.5, 6.0), 0.2),
        Vec3::ONE,
        Vec3::new(1.0, 1.5, 0.0),
        Vec3::new(0.5, 0.0, -0.6),
        None,
    );
    let lantern = LightKind::Point { intensity_cd: 2.0 };
    let lantern = light(lantern, Vec3::ONE, Vec3::new(0.2, 1.9, 0.6), Vec3::new(0.0, 1.0, -2.0), None);
    let lights = vec![
        Light { globe_map: flat(0, 0.4), ..rolled(slide, 0.3) },
        Light { globe_map: flat(1, 0.0), ..wide },
        Light { globe_map: flat(2, -0.7), back_color: Vec3::splat(0.1), ..rolled(window, 0.8) },
        Light {
            globe_map: Some(GlobeMap { picture: cube, rotation_rad: 1.1 }),
            ..rolled(lantern.clone(), -0.4)
        },
        // The wrong sort of picture is none.
        Light { globe_map: flat(3, 0.0), color: Vec3::splat(0.1), ..lantern },
    ];
    Scene { images: (0..6).map(ramp).collect(), ..stage("globes", lights) }
}

/// Lights at the ends of what their numbers may be, most of them dark; a dim sun shows the surfaces.
pub fn degenerate() -> Scene {
    let spot = |inner_cone_rad, outer_cone_rad| LightKind::Spot {
        intensity_cd: 2.0,
        inner_cone_rad,
        outer_cone_rad,
    };
    let sun = LightKind::Directional { illuminance_lx: 0.2 };
    let sun = light(sun, Vec3::ONE, Vec3::new(-2.0, 3.0, 1.0), Vec3::ZERO, None);
    let at =
        |kind| Light { position_world: Vec3::new(0.3, 0.8, 0.6), ..Light::new(kind) }.towards(Vec3::NEG_Y);
    let point = at(LightKind::Point { intensity_cd: 1.0 });
    let cube = at(boxed(1.0, Vec3::ONE, 0.1));
    let hemisphere = at(LightKind::Hemisphere { illuminance_lx: 0.1 });
    let ends = [
        spot(0.0, FRAC_PI_2),
        spot(FRAC_PI_2 - 1e-4, FRAC_PI_2),
        spot(0.0, 1e-4),
        spot(0.3, 0.3),
        boxed(1.0, Vec3::splat(1e-6), 0.0),
        boxed(1.0, Vec3::new(1e-6, 5.0, 5.0), 1e-6),
        boxed(1.0, Vec3::ONE, 1e30),
        boxed(1.0, Vec3::splat(1e30), 1e30),
        boxed(1.0, Vec3::new(1.0, 0.0, 1.0), 0.0),
        boxed(f32::NAN, Vec3::ONE, 0.0),
        boxed(-1.0, Vec3::ONE, 0.0),
        LightKind::Hemisphere { illuminance_lx: f32::INFINITY },
        LightKind::Directional { illuminance_lx: -1.0 },
    ];
    let mut lights: Vec<_> = std::iter::once(sun).chain(ends.map(at)).collect();
    lights.extend(
        [0.0, -1.0, 1e-30, 1e-6, f32::NAN].map(|range| Light { range_m: Some(range), ..point.clone() }),
    );
    // On a surface, and in the middle of one.
    lights.push(Light { position_world: Vec3::new(0.3, 0.0, 1.5), ..point.clone() });
    lights.push(Light { color: Vec3::new(1.0, f32::NAN, 1.0), ..point.clone() });
    lights.push(Light { color: Vec3::new(1.0, -1.0, 1.0), ..point.clone() });
    lights.push(Light { position_world: Vec3::NAN, ..point });
    lights.push(Light { back_color: Vec3::new(0.0, -1.0, 0.0), ..cube.clone() });
    lights.push(Light { up_world: Vec3::NAN, ..cube.clone() });
    lights.push(Light { color: Vec3::ZERO, back_color: Vec3::ONE, ..cube });
    lights.push(Light { color: Vec3::ZERO, ..hemisphere });
    stage("degenerate", lights)
}

/// The same floor and spheres seen from within a box light.
pub fn inside_a_box() -> Scene {
    let mut scene = extents();
    scene.name = "inside a box".into();
    let size = Vec3::new(14.0, 9.0, 14.0);
    let around =
        light(boxed(1.0, size, 3.0), Vec3::ONE, Vec3::new(0.5, 2.0, 2.0), Vec3::new(0.0, 0.0, 1.0), None);
    scene.lights = vec![rolled(around, 0.3)];
    let turn = Mat4::from_rotation_y(0.2);
    scene.instances[3].world_from_object = turn * scene.instances[3].world_from_object;
    scene
}
