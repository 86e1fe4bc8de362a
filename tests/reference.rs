//! The reference's whole path, from a scene to a picture, against analytic images.

use ontile::glam::{DVec3, Mat4, Vec2, Vec3, Vec4, camera::rh::view::look_at_mat4};
use ontile::plan::{GBuffer, Options, Tonemap};
use ontile::reference::texture::linear_from_srgb;
use ontile::reference::{Frame, Settings, Stored, View, encode, render, shade_gbuffer};
use ontile::scene::{
    Camera, Image, Instance, Light, LightKind, Material, Mesh, Projection, Sampler, Scene, Texture,
    TextureRef,
};

const PERSPECTIVE: Projection = Projection::Perspective { yfov_rad: 0.6, znear_m: 0.1, zfar_m: Some(100.0) };
const ORTHOGRAPHIC: Projection =
    Projection::Orthographic { xmag_m: 2.0, ymag_m: 1.5, znear_m: 0.1, zfar_m: 50.0 };

fn camera(eye: Vec3, target: Vec3, projection: Projection) -> Camera {
    Camera { name: "test".into(), world_from_view: look_at_mat4(eye, target, Vec3::Y).inverse(), projection }
}

fn light(kind: LightKind, position_world: Vec3, direction_world: Vec3) -> Light {
    Light { position_world, ..Light::new(kind).towards(direction_world) }
}

/// A latitude-longitude unit sphere with smooth normals.
fn sphere(rings: u32, sectors: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for ring in 0..=rings {
        for sector in 0..=sectors {
            let theta = std::f32::consts::PI * ring as f32 / rings as f32;
            let phi = std::f32::consts::TAU * sector as f32 / sectors as f32;
            mesh.positions.push(Vec3::new(theta.sin() * phi.sin(), theta.cos(), theta.sin() * phi.cos()));
            if ring < rings && sector < sectors {
                let a = ring * (sectors + 1) + sector;
                let b = a + sectors + 1;
                mesh.indices.extend([a, b, a + 1, a + 1, b, b + 1]);
            }
        }
    }
    mesh.normals = mesh.positions.clone();
    mesh
}

/// A square of half extent `half` in the plane z = 0, facing +Z.
fn square(half: f32) -> Mesh {
    let corners = [Vec2::new(-1.0, 1.0), Vec2::new(-1.0, -1.0), Vec2::new(1.0, -1.0), Vec2::new(1.0, 1.0)];
    Mesh {
        positions: corners.map(|c| c.extend(0.0) * half).to_vec(),
        normals: vec![Vec3::Z; 4],
        tangents: vec![Vec3::X.extend(1.0); 4],
        texcoords: [corners.map(|c| (c * Vec2::new(1.0, -1.0) + 1.0) * 0.5).to_vec(), Vec::new()],
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Mesh::default()
    }
}

fn scene(material: Material, mesh: Mesh, world_from_object: Mat4) -> Scene {
    Scene {
        meshes: vec![mesh],
        instances: vec![Instance::new(0, world_from_object)],
        materials: vec![material],
        ..Scene::default()
    }
}

/// No specular part to speak of: metallic 0, rough, and the 4 % coat accounted for by each test.
fn matte(albedo: f32) -> Material {
    Material {
        base_color_factor: Vec3::splat(albedo).extend(1.0),
        metallic_factor: 0.0,
        ..Material::default()
    }
}

fn settings(size: [u32; 2]) -> Settings {
    Settings { size, tonemap: Tonemap::Linear, ..Settings::default() }
}

/// A white dielectric of roughness 1 for unit vectors, written out from scratch: D = 1 / pi,
/// V = 1 / (2 (n.l + n.v)).
fn rough_dielectric(albedo: f64, n: DVec3, v: DVec3, l: DVec3) -> f64 {
    let pi = std::f64::consts::PI;
    let half = (v + l).normalize();
    let fresnel = 0.04 + 0.96 * (1.0 - v.dot(half)).powi(5);
    let specular = 1.0 / (pi * 2.0 * (n.dot(l) + n.dot(v)));
    (1.0 - fresnel) * albedo / pi + fresnel * specular
}

#[test]
fn a_sphere_under_a_directional_light_is_the_analytic_image() {
    /// A mesh of 128 rings deviates from the sphere by 1 - cos(pi / 256) = 7.5e-5 of its radius. Interpolated
    /// normals are exact to the square of the facet's half angle; near the rim the hit slides along the surface.
    const FACETS: f64 = 2e-3;
    let mut scene = scene(matte(0.8), sphere(128, 256), Mat4::IDENTITY);
    let to_light = DVec3::new(0.6, 0.48, 0.64);
    scene.lights =
        vec![light(LightKind::Directional { illuminance_lx: 2.5 }, Vec3::ZERO, -to_light.as_vec3())];
    for projection in [PERSPECTIVE, ORTHOGRAPHIC] {
        let camera = camera(Vec3::Z * 5.0, Vec3::ZERO, projection);
        let settings = settings([96, 72]);
        let frame = render(&scene, &camera, &settings);
        let view = View::new(&camera, settings.size);
        let mut compared = 0;
        for y in 0..72 {
            for x in 0..96 {
                // Ray and unit sphere: |o + t d|² = 1.
                let ray = view.ray_through_pixel([x, y]);
                let (a, b) = (ray.direction.length_squared(), ray.origin.dot(ray.direction));
                let discriminant = b * b - a * (ray.origin.length_squared() - 1.0);
                let pixel = frame.pixel(x, y);
                if discriminant.abs() < 0.05 {
                    continue;
                }
                assert_eq!(pixel.covered, discriminant > 0.0, "{x} {y}");
                if !pixel.covered {
                    assert_eq!(pixel.linear, DVec3::ZERO);
                    continue;
                }
                let n = ray.origin + ray.direction * ((-b - discriminant.sqrt()) / a);
                let n_dot_l = n.dot(to_light);
                let brdf = rough_dielectric(0.8, n, -ray.direction.normalize(), to_light);
                let expected = if n_dot_l > 0.0 { 2.5 * n_dot_l * brdf } else { 0.0 };
                assert!((pixel.linear.y - expected).abs() < FACETS, "{x} {y}: {} {expected}", pixel.linear);
                compared += 1;
            }
        }
        assert!(compared > 800, "{compared}");
    }
}

#[test]
fn a_plane_is_hit_where_it_is() {
    let (eye, size) = (Vec3::new(0.5, 0.25, 4.0), [64_u32, 32]);
    let scene = scene(matte(0.5), square(50.0), Mat4::IDENTITY);
    for projection in [PERSPECTIVE, ORTHOGRAPHIC] {
        let frame = render(&scene, &camera(eye, eye - Vec3::Z, projection), &settings(size));
        for y in 0..32 {
            for x in 0..64 {
                let ndc_x = (f64::from(x) + 0.5) / 32.0 - 1.0;
                let ndc_y = (f64::from(y) + 0.5) / 16.0 - 1.0;
                // Twice as wide as high; 4 metres away.
                let half_height = match projection {
                    Projection::Perspective { .. } => 4.0 * (f64::from(0.6_f32) / 2.0).tan(),
                    Projection::Orthographic { .. } => 1.5,
                };
                let expected = DVec3::new(0.5 + 2.0 * half_height * ndc_x, 0.25 - half_height * ndc_y, 0.0);
                let attributes = frame.pixel(x, y).attributes;
                // The camera's matrix is an f32 inverse.
                assert!((attributes.position_world - expected).length() < 1e-5);
                assert_eq!(attributes.normal_world, DVec3::Z);
            }
        }
    }
}

#[test]
fn exposure_and_lights_add_up() {
    let mut scene = scene(matte(0.5), square(5.0), Mat4::IDENTITY);
    let lamps = [
        light(LightKind::Point { intensity_cd: 9.0 }, Vec3::new(0.3, 0.4, 2.0), Vec3::NEG_Z),
        light(
            LightKind::Spot { intensity_cd: 20.0, inner_cone_rad: 0.1, outer_cone_rad: 0.4 },
            Vec3::Z * 3.0,
            Vec3::NEG_Z,
        ),
    ];
    let camera = camera(Vec3::Z * 4.0, Vec3::ZERO, PERSPECTIVE);
    let mut shot = |lights: &[Light], exposure_ev: f64| {
        scene.lights = lights.to_vec();
        render(&scene, &camera, &Settings { exposure_ev, ..settings([16, 16]) })
    };
    let (first, second) = (shot(&lamps[..1], 0.0), shot(&lamps[1..], 0.0));
    let both = shot(&lamps, -2.0);
    for ((a, b), sum) in first.pixels.iter().zip(&second.pixels).zip(&both.pixels) {
        assert!(a.linear.x > 0.0);
        assert!((sum.linear * 4.0 - a.linear - b.linear).length() < 1e-12);
    }
}

#[test]
fn unlit_and_emissive_surfaces_need_no_light() {
    let color = Vec4::new(0.3, 0.6, 0.1, 1.0);
    let camera = camera(Vec3::Z * 4.0, Vec3::ZERO, PERSPECTIVE);
    let unlit = Material { base_color_factor: color, unlit: true, ..Material::default() };
    let frame = render(&scene(unlit, square(9.0), Mat4::IDENTITY), &camera, &settings([4, 4]));
    assert_eq!(frame.pixels[5].linear, color.truncate().as_dvec3());
    assert!(!frame.pixels[5].attributes.lit);

    let emissive = Material { emissive_factor: Vec3::new(5.0, 0.0, 1.0), ..Material::default() };
    let frame = render(&scene(emissive, square(9.0), Mat4::IDENTITY), &camera, &settings([4, 4]));
    assert_eq!(frame.pixels[5].linear, DVec3::new(5.0, 0.0, 1.0));
    assert_eq!(frame.to_rgba32f()[..4], [5.0, 0.0, 1.0, 1.0]);
    assert_eq!(frame.to_rgba8_srgb()[..4], [255, 0, 255, 255]);
}

#[test]
fn double_sided_surfaces_face_the_viewer() {
    let material = Material { double_sided: true, ..matte(0.5) };
    let scene = scene(material, square(9.0), Mat4::from_rotation_y(std::f32::consts::PI));
    let frame = render(&scene, &camera(Vec3::Z * 4.0, Vec3::ZERO, PERSPECTIVE), &settings([4, 4]));
    assert!((frame.pixels[0].attributes.normal_world - DVec3::Z).length() < 1e-6);
}

/// A square whose normal map says one direction everywhere, placed by `placement`.
fn normal_mapped(texel: [u8; 3], placement: Mat4) -> Frame {
    let [r, g, b] = texel;
    let normal_texture = Some(TextureRef { texture: 0, texcoord: 0, uv_from_texcoord: TextureRef::IDENTITY });
    let mut scene = scene(Material { normal_texture, ..matte(0.5) }, square(9.0), placement);
    scene.textures = vec![Texture { image: 0, sampler: Sampler::default() }];
    scene.images = vec![Image { name: "n".into(), width: 1, height: 1, texels: vec![r, g, b, 255].into() }];
    render(&scene, &camera(Vec3::Z * 4.0, Vec3::ZERO, PERSPECTIVE), &settings([4, 4]))
}

#[test]
fn normal_maps_lean_along_the_objects_own_axes() {
    let decode = |byte: u8| f64::from(byte) / 255.0 * 2.0 - 1.0;
    let lean = DVec3::new(decode(200), decode(160), decode(230)).normalize();
    let upright = normal_mapped([200, 160, 230], Mat4::IDENTITY);
    assert!((upright.pixels[6].attributes.normal_world - lean).length() < 1e-12);
    // Mirrored in x the surface's picture is mirrored, and so are its normals: x changes sign, y does not.
    let mirrored = normal_mapped([200, 160, 230], Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0)));
    let expected = lean * DVec3::new(-1.0, 1.0, 1.0);
    assert!((mirrored.pixels[6].attributes.normal_world - expected).length() < 1e-12);
    // A scale along the axes of a flat square tilts nothing: tangents are of unit length in the world.
    let stretched = normal_mapped([200, 160, 230], Mat4::from_scale(Vec3::new(3.0, 0.5, 2.0)));
    assert!((stretched.pixels[6].attributes.normal_world - lean).length() < 1e-6);
}

#[test]
fn normals_of_a_stretched_sphere_stand_on_its_ellipsoid() {
    let stretch = Vec3::new(1.0, 0.5, 2.0);
    let scene = scene(matte(0.5), sphere(96, 192), Mat4::from_scale(stretch));
    let frame = render(&scene, &camera(Vec3::Z * 6.0, Vec3::ZERO, PERSPECTIVE), &settings([48, 48]));
    let mut compared = 0;
    for pixel in frame.pixels.iter().filter(|p| p.covered && !p.edge) {
        // The gradient of |p / stretch|².
        let squared = stretch.as_dvec3() * stretch.as_dvec3();
        let expected = (pixel.attributes.position_world / squared).normalize();
        assert!((pixel.attributes.normal_world - expected).length() < 3e-3);
        compared += 1;
    }
    assert!(compared > 100, "{compared}");
}

#[test]
fn edges_are_found_and_smooth_surfaces_have_none() {
    let camera = camera(Vec3::new(0.1, 0.2, 4.0), Vec3::ZERO, PERSPECTIVE);
    let smooth = render(&scene(matte(0.5), sphere(64, 128), Mat4::IDENTITY), &camera, &settings([96, 96]));
    for y in 1..95 {
        for x in 1..95 {
            let pixel = smooth.pixel(x, y);
            let neighbours = [(0, 1), (2, 1), (1, 0), (1, 2)];
            if neighbours.iter().any(|(i, j)| smooth.pixel(x + i - 1, y + j - 1).covered != pixel.covered) {
                assert!(pixel.edge, "{x} {y}: the silhouette");
            }
            let facing = pixel.attributes.normal_world.z;
            assert!(!(pixel.edge && facing > 0.6), "{x} {y}: the inside of the disc, n.z = {facing}");
        }
    }
    // The same sphere with a normal of its own for each triangle: its creases can be seen.
    let mut faceted = sphere(64, 128);
    let round = faceted.clone();
    faceted.positions = round.indices.iter().map(|&i| round.positions[i as usize]).collect();
    faceted.normals = Vec::new();
    faceted.indices = (0..faceted.positions.len() as u32).collect();
    let faceted = render(&scene(matte(0.5), faceted, Mat4::IDENTITY), &camera, &settings([96, 96]));
    let edges = |frame: &Frame| frame.pixels.iter().filter(|p| p.covered && p.edge).count();
    assert!(edges(&faceted) > edges(&smooth) + 100, "{} {}", edges(&faceted), edges(&smooth));
}

/// Two lamps over a tilted square, with ambient light: every part of the shading at work.
fn lamp_lit() -> Scene {
    let material = Material {
        base_color_factor: Vec4::new(0.9, 0.5, 0.2, 1.0),
        metallic_factor: 0.7,
        roughness_factor: 0.4,
        ..Material::default()
    };
    let mut scene = scene(material, square(1.0), Mat4::from_rotation_x(-0.4));
    scene.ambient_nt = Vec3::splat(0.05);
    scene.lights = vec![
        light(LightKind::Point { intensity_cd: 0.5 }, Vec3::new(0.5, 0.8, 1.0), Vec3::NEG_Z),
        light(LightKind::Directional { illuminance_lx: 0.3 }, Vec3::ZERO, Vec3::NEG_Z),
    ];
    scene
}

#[test]
fn a_gbuffer_read_back_shades_like_the_surface_it_holds() {
    let scene = lamp_lit();
    let camera = camera(Vec3::Z * 4.0, Vec3::ZERO, PERSPECTIVE);
    let ideal = Settings { exposure_ev: 0.5, tonemap: Tonemap::Aces, ..settings([40, 30]) };
    let truth = render(&scene, &camera, &ideal);
    let (gbuffer, view) = (GBuffer::exact(), View::new(&camera, ideal.size));
    let stored: Vec<Stored> =
        truth.pixels.iter().map(|p| encode(&gbuffer, &p.attributes, &view, ideal.exposure())).collect();
    let exact = Settings { gbuffer: Some(gbuffer), light_target: true, ..ideal };
    let frame = shade_gbuffer(&scene, &camera, &exact, &stored);
    for (a, b) in frame.pixels.iter().zip(&truth.pixels) {
        assert_eq!(a.covered, b.covered);
        // Floats in, doubles on: what is left is the rounding of the G-buffer's channels.
        assert!(
            (a.linear - b.linear).length() < 1e-5 * (b.linear.length() + 1e-3),
            "{} {}",
            a.linear,
            b.linear
        );
        assert!((a.display - b.display).length() < 1e-5);
    }
}

#[test]
fn metallic128_changes_the_picture_a_little() {
    let scene = lamp_lit();
    let camera = camera(Vec3::Z * 4.0, Vec3::ZERO, PERSPECTIVE);
    let ideal = settings([40, 30]);
    let truth = render(&scene, &camera, &ideal);
    let stored = Settings {
        gbuffer: Some(GBuffer::new(&Options::default()).unwrap()),
        light_target: true,
        ..ideal.clone()
    };
    let frame = render(&scene, &camera, &stored);
    let difference = |p: usize| (frame.pixels[p].linear - truth.pixels[p].linear).abs().max_element();
    let worst = (0..truth.pixels.len()).map(difference).fold(0.0, f64::max);
    // Base colour within half of sRGB's widest step (0.9 %), a normal within 0.4 degrees of a lobe of alpha 0.16.
    assert!(worst > 1e-4 && worst < 0.05, "{worst}");
    // With a light target every stored value is a whole number of 1023rds.
    for pixel in &frame.pixels {
        let code = pixel.linear * 1023.0;
        assert!((code - code.round()).abs().max_element() < 1e-9);
    }
    // Brighter than the target can hold: clamped, unless scaled down.
    let bright = Settings { exposure_ev: 5.0, ..stored.clone() };
    let brightest = |s: &Settings| {
        let frame = render(&scene, &camera, s);
        frame.pixels.iter().map(|p| p.linear.max_element()).fold(0.0, f64::max)
    };
    assert_eq!(brightest(&bright), 1.0);
    assert!(brightest(&Settings { light_scale: 1.0 / 64.0, ..bright }) > 1.5);
}

#[test]
fn textures_and_vertex_colours_multiply() {
    let base_color_texture =
        Some(TextureRef { texture: 0, texcoord: 0, uv_from_texcoord: TextureRef::IDENTITY });
    let material = Material { base_color_texture, unlit: true, ..matte(0.5) };
    let mut mesh = square(9.0);
    mesh.colors = vec![Vec4::new(1.0, 0.5, 0.25, 1.0); 4];
    let mut scene = scene(material, mesh, Mat4::IDENTITY);
    scene.textures = vec![Texture { image: 0, sampler: Sampler::default() }];
    scene.images =
        vec![Image { name: "c".into(), width: 1, height: 1, texels: vec![255, 188, 188, 255].into() }];
    let frame = render(&scene, &camera(Vec3::Z * 4.0, Vec3::ZERO, PERSPECTIVE), &settings([2, 2]));
    let encoded = linear_from_srgb(188.0 / 255.0);
    let expected = DVec3::new(0.5, 0.25 * encoded, 0.125 * encoded);
    assert!((frame.pixels[0].linear - expected).length() < 1e-12);
}

#[test]
fn threads_do_not_change_the_frame() {
    let scene = lamp_lit();
    let camera = camera(Vec3::Z * 4.0, Vec3::ZERO, PERSPECTIVE);
    let shot = || render(&scene, &camera, &settings([40, 30]));
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    assert_eq!(pool(1).install(shot), pool(4).install(shot));
}
