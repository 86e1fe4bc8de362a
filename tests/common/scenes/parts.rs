//! What the scenes are put together from.

use super::*;

pub fn camera() -> Camera {
    let world_from_view = look_at_mat4(Vec3::new(0.0, 1.6, 4.0), Vec3::new(0.0, 0.5, 0.0), Vec3::Y).inverse();
    let projection = Projection::Perspective { yfov_rad: 0.7, znear_m: 0.1, zfar_m: None };
    Camera { name: "test".into(), world_from_view, projection }
}

/// One light of each kind.
pub fn lights() -> Vec<Light> {
    let light = |name: &str, color, kind, position_world, range_m| {
        let light = Light { name: name.into(), color, position_world, range_m, ..Light::new(kind) };
        light.towards(Vec3::new(-0.3, -1.0, -0.4))
    };
    let spot = LightKind::Spot { intensity_cd: 12.0, inner_cone_rad: 0.2, outer_cone_rad: 0.5 };
    vec![
        light(
            "sun",
            Vec3::new(1.0, 0.95, 0.9),
            LightKind::Directional { illuminance_lx: 1.5 },
            Vec3::ZERO,
            None,
        ),
        light(
            "bulb",
            Vec3::new(0.4, 0.6, 1.0),
            LightKind::Point { intensity_cd: 4.0 },
            Vec3::new(-1.5, 1.5, 1.0),
            Some(6.0),
        ),
        light("torch", Vec3::new(1.0, 0.5, 0.3), spot, Vec3::new(1.3, 2.6, 1.5), None),
    ]
}

pub fn rough(name: &str, base_color: Vec3) -> Material {
    Material {
        name: name.into(),
        base_color_factor: base_color.extend(1.0),
        metallic_factor: 0.0,
        roughness_factor: 0.6,
        ..Material::default()
    }
}

pub fn texture(texture: usize) -> TextureRef {
    TextureRef { texture, texcoord: 0, uv_from_texcoord: TextureRef::IDENTITY }
}

pub fn at(x: f32, y: f32, z: f32) -> Mat4 {
    Mat4::from_translation(Vec3::new(x, y, z))
}

pub fn add(scene: &mut Scene, mesh: Mesh, material: Material, placements: &[Mat4]) {
    let index = scene.meshes.len();
    scene.meshes.push(Mesh { material: scene.materials.len(), name: material.name.clone(), ..mesh });
    scene.materials.push(material);
    let place = |&world_from_object| Instance::new(index, world_from_object);
    scene.instances.extend(placements.iter().map(place));
}

/// A latitude-longitude sphere of radius 1.
pub fn sphere() -> Mesh {
    const RINGS: u32 = 12;
    const SECTORS: u32 = 24;
    let mut mesh = Mesh::default();
    for ring in 0..=RINGS {
        for sector in 0..=SECTORS {
            let uv = Vec2::new(sector as f32 / SECTORS as f32, ring as f32 / RINGS as f32);
            let (theta, phi) = (PI * uv.y, TAU * uv.x);
            mesh.positions.push(Vec3::new(theta.sin() * phi.sin(), theta.cos(), theta.sin() * phi.cos()));
            mesh.tangents.push(Vec4::new(phi.cos(), 0.0, -phi.sin(), 1.0));
            mesh.texcoords[0].push(uv * Vec2::new(4.0, 2.0));
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

/// The square from -1 to 1 in the plane z = 0, facing +Z; TEXCOORD_1 runs twice as fast as TEXCOORD_0.
pub fn square() -> Mesh {
    let corners = [Vec2::new(-1.0, 1.0), Vec2::new(-1.0, -1.0), Vec2::new(1.0, -1.0), Vec2::new(1.0, 1.0)];
    let uv = corners.map(|c| (c * Vec2::new(1.0, -1.0) + 1.0) * 0.5);
    Mesh {
        positions: corners.map(|c| c.extend(0.0)).to_vec(),
        normals: vec![Vec3::Z; 4],
        tangents: vec![Vec3::X.extend(1.0); 4],
        texcoords: [uv.to_vec(), uv.map(|c| c * 2.0).to_vec()],
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Mesh::default()
    }
}

pub fn image(name: &str, texel: impl Fn(u32, u32) -> [u8; 4]) -> Image {
    const SIDE: u32 = 32;
    let rgba8 = (0..SIDE * SIDE).flat_map(|i| texel(i % SIDE, i / SIDE)).collect();
    Image { name: name.into(), width: SIDE, height: SIDE, texels: rgba8 }
}

/// Light and dark tiles, all channels different; every other one is transparent.
pub fn tiles() -> Image {
    image("tiles", |x, y| {
        let dark = (x / 8 + y / 8) % 2 == 1;
        if dark { [90, 60, 150, 0] } else { [200 + (x % 8) as u8, 220, 120, 255] }
    })
}

/// Normals of rounded bumps.
pub fn bumps() -> Image {
    image("bumps", |x, y| {
        let slope = |t: u32| 0.5 * (TAU * (t as f32 + 0.5) / 16.0).sin();
        let n = Vec3::new(slope(x), slope(y), 1.0).normalize() * 0.5 + 0.5;
        let [r, g, b] = n.to_array().map(|c| (c * 255.0).round() as u8);
        [r, g, b, 255]
    })
}
