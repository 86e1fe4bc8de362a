//! Untextured scenes, built by hand, that have between them every feature of the shading.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use crate::light_scenes;
use ontile::glam::camera::rh::view::look_at_mat4;
use ontile::glam::{EulerRot, Mat4, Quat, Vec3, Vec4};
use ontile::scene::{AlphaMode, Camera, Instance, Light, LightKind, Material, Mesh, Projection, Scene};

/// Every scene, with at least one camera each.
pub fn all() -> Vec<Scene> {
    vec![
        lights(),
        materials(),
        placements(),
        surfaces(),
        grazing(),
        orthographic_along_light(),
        light_scenes::extents(),
        light_scenes::degenerate(),
        light_scenes::inside_a_box(),
    ]
}

/// The same scene in a world that is turned as a whole: the picture stays, but no normal lies along an axis any more.
pub fn turned(mut scene: Scene) -> Scene {
    let turn = Mat4::from_euler(EulerRot::XYZ, 0.3, 0.5, 0.2);
    for instance in &mut scene.instances {
        instance.world_from_object = turn * instance.world_from_object;
    }
    for light in &mut scene.lights {
        light.position_world = turn.transform_point3(light.position_world);
        light.direction_world = turn.transform_vector3(light.direction_world).normalize();
        light.up_world = turn.transform_vector3(light.up_world).normalize();
    }
    for decal in &mut scene.decals {
        decal.world_from_decal = turn * decal.world_from_decal;
    }
    for camera in &mut scene.cameras {
        camera.world_from_view = turn * camera.world_from_view;
    }
    scene
}

fn camera(name: &str, eye: Vec3, target: Vec3, projection: Projection) -> Camera {
    let world_from_view = look_at_mat4(eye, target, Vec3::Y).inverse();
    Camera { name: name.into(), world_from_view, projection }
}

/// Finite, infinite and parallel from about the same place.
pub fn cameras(eye: Vec3, target: Vec3) -> Vec<Camera> {
    let perspective = |zfar_m| Projection::Perspective { yfov_rad: 0.7, znear_m: 0.1, zfar_m };
    let half = 0.36 * (target - eye).length();
    let orthographic = Projection::Orthographic { xmag_m: half, ymag_m: half, znear_m: 0.1, zfar_m: 40.0 };
    vec![
        camera("finite far", eye, target, perspective(Some(60.0))),
        camera("infinite far", eye + Vec3::new(0.9, 0.2, 0.0), target, perspective(None)),
        camera("orthographic", eye, target, orthographic),
    ]
}

pub fn light(
    kind: LightKind,
    color: Vec3,
    position_world: Vec3,
    target: Vec3,
    range_m: Option<f32>,
) -> Light {
    let light = Light { name: "light".into(), color, position_world, range_m, ..Light::new(kind) };
    light.towards(target - position_world)
}

/// Base colours of 0.5 are avoided: that is the sRGB code 187.52, nearly a tie.
pub fn material(base: Vec3, metallic: f32, roughness: f32) -> Material {
    Material {
        base_color_factor: base.extend(1.0),
        metallic_factor: metallic,
        roughness_factor: roughness,
        ..Material::default()
    }
}

/// A unit sphere with smooth normals, fine enough that its outline is round at the size of the pictures.
pub fn sphere() -> Mesh {
    const RINGS: u32 = 48;
    const SECTORS: u32 = 96;
    let mut mesh = Mesh { name: "sphere".into(), ..Mesh::default() };
    for ring in 0..=RINGS {
        for sector in 0..=SECTORS {
            let theta = PI * ring as f32 / RINGS as f32;
            let phi = TAU * sector as f32 / SECTORS as f32;
            mesh.positions.push(Vec3::new(theta.sin() * phi.sin(), theta.cos(), theta.sin() * phi.cos()));
            if ring < RINGS && sector < SECTORS {
                let a = ring * (SECTORS + 1) + sector;
                let b = a + SECTORS + 1;
                mesh.indices.extend([a, b, a + 1, a + 1, b, b + 1]);
            }
        }
    }
    mesh.normals = mesh.positions.clone();
    mesh
}

/// A square of half extent 1 in the plane y = 0 that faces +Y, in a few pieces: drivers warn of tiny draws.
pub fn floor() -> Mesh {
    const CELLS: u32 = 4;
    let mut mesh = Mesh { name: "floor".into(), ..Mesh::default() };
    for row in 0..=CELLS {
        for column in 0..=CELLS {
            let at = |i: u32| i as f32 * 2.0 / CELLS as f32 - 1.0;
            mesh.positions.push(Vec3::new(at(column), 0.0, at(row)));
            if row < CELLS && column < CELLS {
                let a = row * (CELLS + 1) + column;
                let b = a + CELLS + 1;
                mesh.indices.extend([a, b, a + 1, a + 1, b, b + 1]);
            }
        }
    }
    mesh.normals = vec![Vec3::Y; mesh.positions.len()];
    mesh
}

/// The floor's square, standing: it faces +Z.
pub fn wall(at: Vec3, half: f32) -> Mat4 {
    Mat4::from_translation(at) * Mat4::from_rotation_x(FRAC_PI_2) * Mat4::from_scale(Vec3::splat(half))
}

/// A scene with one instance of each mesh.
pub struct Builder(pub Scene);

impl Builder {
    pub fn new(name: &str, cameras: Vec<Camera>, lights: Vec<Light>) -> Self {
        Self(Scene { name: name.into(), cameras, lights, ..Scene::default() })
    }

    pub fn add(mut self, mesh: Mesh, material: Material, world_from_object: Mat4) -> Self {
        let scene = &mut self.0;
        scene.instances.push(Instance::new(scene.meshes.len(), world_from_object));
        scene.meshes.push(Mesh { material: scene.materials.len(), ..mesh });
        scene.materials.push(material);
        self
    }
}

pub fn on_floor(x: f32, z: f32, radius: f32) -> Mat4 {
    Mat4::from_translation(Vec3::new(x, radius, z)) * Mat4::from_scale(Vec3::splat(radius))
}

pub fn big_floor() -> Mat4 {
    Mat4::from_scale(Vec3::new(6.0, 1.0, 6.0))
}

/// Each type of light, coloured, with and without range, within and beyond it; one behind everything.
pub fn lights() -> Scene {
    use LightKind::{Directional, Point, Spot};
    let spot =
        |intensity_cd, inner_cone_rad, outer_cone_rad| Spot { intensity_cd, inner_cone_rad, outer_cone_rad };
    let lights = vec![
        light(
            Directional { illuminance_lx: 0.4 },
            Vec3::new(1.0, 0.9, 0.8),
            Vec3::new(2.0, 4.0, 3.0),
            Vec3::ZERO,
            None,
        ),
        light(
            Point { intensity_cd: 1.5 },
            Vec3::new(1.0, 0.2, 0.1),
            Vec3::new(-1.8, 1.2, 0.6),
            Vec3::ZERO,
            None,
        ),
        light(
            Point { intensity_cd: 4.0 },
            Vec3::new(0.1, 0.3, 1.0),
            Vec3::new(1.9, 0.9, 0.4),
            Vec3::ZERO,
            Some(1.7),
        ),
        light(
            spot(6.0, 0.2, 0.45),
            Vec3::new(0.2, 1.0, 0.3),
            Vec3::new(0.0, 3.0, 1.5),
            Vec3::new(0.2, 0.0, 0.0),
            None,
        ),
        light(
            spot(9.0, 0.0, 0.6),
            Vec3::new(1.0, 1.0, 0.2),
            Vec3::new(-3.0, 2.0, -1.0),
            Vec3::new(-1.5, 0.0, -1.8),
            Some(3.5),
        ),
        light(
            spot(2.0, 0.3, FRAC_PI_2),
            Vec3::ONE,
            Vec3::new(3.0, 1.5, -2.0),
            Vec3::new(3.0, 0.0, -2.5),
            None,
        ),
        light(Point { intensity_cd: 5.0 }, Vec3::ONE, Vec3::new(0.0, -3.0, 0.0), Vec3::ZERO, None),
    ];
    Builder::new("lights", cameras(Vec3::new(0.0, 2.4, 6.0), Vec3::new(0.0, 0.6, 0.0)), lights)
        .add(floor(), material(Vec3::new(0.7, 0.65, 0.6), 0.0, 0.6), big_floor())
        .add(floor(), material(Vec3::new(0.52, 0.6, 0.7), 0.0, 0.9), wall(Vec3::new(0.0, 2.0, -3.0), 5.0))
        .add(sphere(), material(Vec3::new(0.9, 0.9, 0.9), 0.0, 0.5), on_floor(-1.2, 0.0, 0.6))
        .add(sphere(), material(Vec3::new(1.0, 0.8, 0.4), 1.0, 0.5), on_floor(0.3, 0.3, 0.5))
        .add(sphere(), material(Vec3::new(0.2, 0.3, 0.9), 0.5, 0.4), on_floor(1.6, -0.4, 0.7))
        .0
}

/// Roughness from 0 to 1 across, metallicness from 0 to 1 upwards: spheres in front of tilted tiles.
pub fn materials() -> Scene {
    use LightKind::{Directional, Point};
    let toward = Vec3::new(0.4, 0.8, 1.0);
    let lights = vec![
        light(Directional { illuminance_lx: 1.0 }, Vec3::ONE, toward, Vec3::ZERO, None),
        light(
            Point { intensity_cd: 12.0 },
            Vec3::new(1.0, 0.8, 0.6),
            Vec3::new(-2.0, 3.0, 5.0),
            Vec3::ZERO,
            None,
        ),
    ];
    let mut builder = Builder::new("materials", cameras(Vec3::new(0.0, 0.0, 7.0), Vec3::ZERO), lights);
    for row in 0..4 {
        for column in 0..7 {
            let (metallic, roughness) = (row as f32 / 3.0, column as f32 / 6.0);
            let at = Vec3::new(column as f32 * 1.1 - 3.3, row as f32 * 1.1 - 1.65, 0.0);
            let tilt = Quat::from_euler(
                EulerRot::XYZ,
                FRAC_PI_2 - 0.03 * (row as f32 + 1.0),
                0.0,
                // Never 0: the code of a normal's component of 0 is a tie, 127.5.
                0.02 * (column as f32 - 3.3),
            );
            let placement = Mat4::from_scale_rotation_translation(Vec3::splat(0.5), tilt, at);
            builder =
                builder.add(floor(), material(Vec3::new(0.9, 0.52, 0.3), metallic, roughness), placement);
            let sphere_at = at + Vec3::new(0.0, 0.0, 0.3);
            let placement = Mat4::from_translation(sphere_at) * Mat4::from_scale(Vec3::splat(0.35));
            builder =
                builder.add(sphere(), material(Vec3::new(0.3, 0.6, 0.9), metallic, roughness), placement);
        }
    }
    builder.0
}

/// Mirrored and stretched instances, flattened ones, and vertex colours.
pub fn placements() -> Scene {
    use LightKind::{Directional, Point};
    let lights = vec![
        light(Directional { illuminance_lx: 1.5 }, Vec3::ONE, Vec3::new(-3.0, 4.0, 2.0), Vec3::ZERO, None),
        light(
            Point { intensity_cd: 3.0 },
            Vec3::new(0.6, 0.7, 1.0),
            Vec3::new(2.0, 2.0, 2.5),
            Vec3::ZERO,
            None,
        ),
    ];
    let mut colored = sphere();
    colored.colors = colored.positions.iter().map(|p| (*p * 0.5 + 0.5).extend(1.0)).collect();
    let turn = Quat::from_euler(EulerRot::YXZ, 0.5, 0.4, 0.3);
    let place = |scale: Vec3, at: Vec3| Mat4::from_scale_rotation_translation(scale, turn, at);
    let grey = || material(Vec3::splat(0.8), 0.0, 0.45);
    Builder::new("placements", cameras(Vec3::new(0.0, 2.0, 6.0), Vec3::new(0.0, 0.7, 0.0)), lights)
        .add(floor(), grey(), big_floor())
        .add(sphere(), grey(), place(Vec3::new(-0.6, 0.6, 0.6), Vec3::new(-2.2, 0.7, 0.0)))
        .add(
            sphere(),
            material(Vec3::new(0.9, 0.6, 0.3), 1.0, 0.4),
            place(Vec3::new(0.9, 0.3, 0.5), Vec3::new(-0.6, 0.8, 0.0)),
        )
        .add(colored.clone(), grey(), place(Vec3::new(0.3, -0.8, 0.5), Vec3::new(0.8, 0.9, 0.2)))
        .add(colored, material(Vec3::ONE, 0.3, 0.6), place(Vec3::splat(-0.5), Vec3::new(2.1, 0.7, 0.3)))
        .add(
            sphere(),
            grey(),
            Mat4::from_translation(Vec3::new(0.0, 1.9, -1.5)) * Mat4::from_scale(Vec3::new(1.5, 0.6, 0.0)),
        )
        .0
}

/// Light without lights: emission, ambient, unlit; both sides; a mask cut by vertex alpha.
pub fn surfaces() -> Scene {
    use LightKind::{Directional, Point};
    let lights = vec![
        light(
            Directional { illuminance_lx: 1.0 },
            Vec3::new(1.0, 0.95, 0.9),
            Vec3::new(1.0, 3.0, 2.0),
            Vec3::ZERO,
            None,
        ),
        light(
            Point { intensity_cd: 2.0 },
            Vec3::new(0.5, 0.6, 1.0),
            Vec3::new(-1.0, 1.5, 1.5),
            Vec3::ZERO,
            None,
        ),
    ];
    let mut masked = floor();
    masked.colors = masked.positions.iter().map(|p| Vec4::new(1.0, 0.8, 0.6, p.x * 0.5 + 0.5)).collect();
    let glow = Material { emissive_factor: Vec3::new(0.3, 0.8, 0.1), ..material(Vec3::splat(0.4), 0.0, 0.7) };
    let unlit = Material { unlit: true, ..material(Vec3::new(0.25, 0.52, 0.8), 0.0, 0.5) };
    let sheet = Material { double_sided: true, ..material(Vec3::new(0.8, 0.7, 0.25), 0.2, 0.5) };
    let mask = Material { alpha_mode: AlphaMode::Mask { cutoff: 0.4 }, ..sheet.clone() };
    let standing = |at: Vec3, turn: f32| {
        Mat4::from_translation(at) * Mat4::from_rotation_y(turn) * wall(Vec3::ZERO, 0.6)
    };
    let mut scene =
        Builder::new("surfaces", cameras(Vec3::new(0.0, 2.0, 6.0), Vec3::new(0.0, 0.7, 0.0)), lights)
            .add(floor(), material(Vec3::splat(0.52), 0.0, 0.8), big_floor())
            .add(sphere(), glow, on_floor(-2.4, 0.0, 0.6))
            .add(sphere(), unlit, on_floor(-1.0, 0.5, 0.4))
            .add(floor(), sheet.clone(), standing(Vec3::new(0.1, 0.7, 0.0), 0.5))
            .add(floor(), sheet, standing(Vec3::new(1.3, 0.7, 0.0), PI + 0.4))
            .add(masked.clone(), mask.clone(), standing(Vec3::new(2.6, 0.7, 0.2), 0.3))
            .add(masked, mask, standing(Vec3::new(1.9, 0.7, -1.5), PI))
            .add(sphere(), material(Vec3::new(1.0, 0.7, 0.3), 1.0, 0.3), on_floor(-0.6, -1.5, 0.9))
            .0;
    scene.ambient_nt = Vec3::new(0.05, 0.07, 0.1);
    scene
}

/// A ball of polished silver that fills the height, seen in parallel from +Z.
pub fn mirror() -> Scene {
    let projection = Projection::Orthographic { xmag_m: 1.0, ymag_m: 1.0, znear_m: 0.5, zfar_m: 20.0 };
    let camera = camera("front", Vec3::Z * 5.0, Vec3::ZERO, projection);
    Builder::new("mirror", vec![camera], Vec::new())
        .add(sphere(), material(Vec3::ONE, 1.0, 0.0), Mat4::IDENTITY)
        .0
}

/// A low eye and a low sun over a long floor.
pub fn grazing() -> Scene {
    use LightKind::{Directional, Point};
    let lights = vec![
        light(
            Directional { illuminance_lx: 3.0 },
            Vec3::new(1.0, 0.8, 0.6),
            Vec3::new(0.5, 0.4, -4.0),
            Vec3::ZERO,
            None,
        ),
        light(Point { intensity_cd: 1.0 }, Vec3::ONE, Vec3::new(-1.0, 0.15, -1.0), Vec3::ZERO, None),
    ];
    Builder::new("grazing", cameras(Vec3::new(0.0, 0.25, 5.0), Vec3::new(0.0, 0.2, 0.0)), lights)
        .add(floor(), material(Vec3::new(0.6, 0.6, 0.65), 0.0, 0.35), big_floor())
        .add(sphere(), material(Vec3::new(0.8, 0.3, 0.3), 0.0, 0.4), on_floor(0.8, 0.0, 0.4))
        .add(sphere(), material(Vec3::new(0.9, 0.9, 0.9), 1.0, 0.6), on_floor(-0.9, -0.5, 0.5))
        .0
}

/// Parallel views exactly along a directional light, from in front and from behind: seen from behind, the half
/// vector of viewer and light vanishes everywhere.
pub fn orthographic_along_light() -> Scene {
    let projection = Projection::Orthographic { xmag_m: 2.0, ymag_m: 2.0, znear_m: 0.5, zfar_m: 20.0 };
    // Axes of the world, so that viewer and light are opposite to the last bit.
    let look = |name: &str, turn: f32| {
        let axes =
            if turn == 0.0 { Mat4::IDENTITY } else { Mat4::from_diagonal(Vec4::new(-1.0, 1.0, -1.0, 1.0)) };
        let eye = axes.transform_point3(Vec3::Z * 6.0);
        Camera { name: name.into(), world_from_view: Mat4::from_translation(eye) * axes, projection }
    };
    let mut sun = light(LightKind::Directional { illuminance_lx: 2.0 }, Vec3::ONE, Vec3::Z, Vec3::ZERO, None);
    sun.direction_world = Vec3::NEG_Z;
    let both = |m: Material| Material { double_sided: true, ..m };
    Builder::new("along light", vec![look("from the light", 0.0), look("towards the light", 1.0)], vec![sun])
        .add(
            sphere(),
            material(Vec3::new(0.9, 0.52, 0.25), 0.0, 0.3),
            Mat4::from_translation(Vec3::new(-1.5, 0.0, 0.0)),
        )
        .add(
            sphere(),
            material(Vec3::splat(0.8), 1.0, 0.6),
            Mat4::from_translation(Vec3::new(1.5, 0.8, 0.0)) * Mat4::from_scale(Vec3::splat(0.8)),
        )
        .add(floor(), both(material(Vec3::splat(0.52), 0.0, 0.0)), wall(Vec3::new(1.5, -1.0, 0.0), 0.6))
        .0
}
