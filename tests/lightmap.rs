//! Lightmaps: what is baked into a file, and what comes of it when the file is loaded again.

#[path = "common/gltf_build.rs"]
#[allow(dead_code, reason = "each test file uses some of this")]
mod gltf_build;

use gltf_build::Gltf;
use ontile::Result;
use ontile::glam::{DVec3, Vec2, Vec3};
use ontile::lightmap::{Density, Prepared, Settings, bake, prepare};
use ontile::reference::lightmap::Lookup;
use ontile::reference::path::{Paths, Receiver};
use ontile::scene::{Lightmap, Scene};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

const SETTINGS: Settings = Settings { size: [0, 0], samples: 64, bounces: 2 };

/// A file in a folder of its own.
struct File {
    folder: tempfile::TempDir,
    gltf: Gltf,
}

impl File {
    fn new(gltf: Gltf) -> Self {
        Self { folder: tempfile::tempdir().expect("a temporary folder"), gltf }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("scene.glb")
    }

    fn prepare(&self, density: Density) -> Result<Prepared> {
        gltf_build::write(self.folder.path(), "scene.glb", &self.gltf.to_glb());
        prepare(&self.path(), density)
    }

    /// Bakes into another file, and what that one shows.
    fn bake(&self, density: Density) -> Scene {
        self.bake_with(density, SETTINGS.samples)
    }

    fn bake_with(&self, density: Density, samples: u32) -> Scene {
        let prepared = self.prepare(density).unwrap_or_else(|e| panic!("{e}"));
        let settings = Settings { size: prepared.size, samples, ..SETTINGS };
        let lightmap = bake(&prepared.scene, &settings, || ()).unwrap_or_else(|e| panic!("{e}"));
        let baked = self.folder.path().join("baked.glb");
        prepared.write(&lightmap, &baked).unwrap_or_else(|e| panic!("{e}"));
        let scene = Scene::load(&baked).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(scene.lightmap.as_ref(), Some(&lightmap), "what was baked is what is loaded");
        scene
    }
}

/// A mesh of this many squares, side by side along X, 1 m each, facing +Z, without texture coordinates.
fn squares(gltf: &mut Gltf, count: usize) -> Value {
    let mut positions = Vec::new();
    let mut indices: Vec<u16> = Vec::new();
    for i in 0..count {
        let (x, first) = (i as f32, i as u16 * 4);
        positions.extend([x, 0.0, 0.0, x + 1.0, 0.0, 0.0, x + 1.0, 1.0, 0.0, x, 1.0, 0.0]);
        indices.extend([0, 1, 2, 0, 2, 3].map(|k| first + k));
    }
    let vertices = gltf.floats("VEC3", &positions);
    let indices = gltf.accessor(&gltf_build::shorts(&indices), gltf_build::U16, "SCALAR", indices.len());
    json!({"attributes": {"POSITION": vertices}, "indices": indices, "material": 0})
}

/// A square under a sun that comes at 60 degrees: 0.5 * 4 lx everywhere.
fn sunny() -> Gltf {
    let mut gltf = Gltf::empty();
    gltf.push("materials", json!({"pbrMetallicRoughness": {"metallicFactor": 0.0}}));
    let square = squares(&mut gltf, 1);
    gltf.push("meshes", json!({"primitives": [square]}));
    gltf.root_node(json!({"mesh": 0}));
    add_sun(&mut gltf, json!({}));
    gltf
}

fn add_sun(gltf: &mut Gltf, extras: Value) -> usize {
    *gltf.at("/extensionsUsed") = json!(["KHR_lights_punctual"]);
    *gltf.at("/extensions") =
        json!({"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 4.0}]}});
    let turn = std::f32::consts::FRAC_PI_6;
    gltf.root_node(json!({
        "rotation": [turn.sin(), 0.0, 0.0, turn.cos()],
        "extensions": {"KHR_lights_punctual": {"light": 0}},
        "extras": {"ontile": extras},
    }))
}

/// The lightmap at a place of an instance's triangle, and that place with its normal in the world.
fn texel(scene: &Scene, instance: usize, triangle: usize) -> (DVec3, DVec3) {
    let instance = &scene.instances[instance];
    let mesh = &scene.meshes[instance.mesh];
    let corners = [0, 1, 2].map(|k| mesh.indices[triangle * 3 + k] as usize);
    let mean2 = corners.iter().map(|&i| mesh.texcoords[1][i]).sum::<Vec2>() / 3.0;
    let mean3 = corners.iter().map(|&i| mesh.positions[i]).sum::<Vec3>() / 3.0;
    let map: &Lightmap = scene.lightmap.as_ref().expect("it was baked");
    let uv = instance.lightmap.expect("it has a part").uv(mean2);
    let position = instance.world_from_object.transform_point3(mean3).as_dvec3();
    (Lookup::new(map, None).irradiance(uv.as_dvec2()), position)
}

#[test]
fn a_sunny_square_is_lit_evenly() {
    let file = File::new(sunny());
    for density in [Density::Side(16), Density::Side(64), Density::TexelsPerMetre(20.0)] {
        let scene = file.bake(density);
        let map = scene.lightmap.as_ref().unwrap();
        let side = map.width.max(map.height);
        assert!(if let Density::Side(most) = density { side <= most && side > most / 2 } else { side <= 32 });
        for triangle in 0..2 {
            let (irradiance, _) = texel(&scene, 0, triangle);
            assert!((irradiance - 2.0).abs().max_element() < 0.02, "{density:?}: {irradiance}");
        }
        // Its light is in the map.
        assert!(scene.lights[0].baked && scene.lights[0].is_dark());
    }
}

#[test]
fn what_moves_is_left_out() {
    let mut gltf = sunny();
    // A lid over the square that would block the sun; a square that wants no map; a light that moves.
    let square = gltf.json["meshes"][0].clone();
    gltf.push("meshes", square);
    let lid = json!({
        "mesh": 1, "translation": [-5, -5, 0.5], "scale": [10, 10, 1], "extras": {"ontile": {"dynamic": true}},
    });
    gltf.root_node(lid);
    gltf.root_node(json!({"mesh": 0, "translation": [9, 0, 0], "extras": {"ontile": {"lightmap": false}}}));
    add_sun(&mut gltf, json!({"dynamic": true}));
    let scene = File::new(gltf).bake(Density::Side(32));
    assert!(
        (texel(&scene, 0, 0).0 - 2.0).abs().max_element() < 0.02,
        "the moving sun is left out, and so is the lid"
    );
    let parts: Vec<_> = scene.instances.iter().map(|i| (i.dynamic, i.lightmap.is_some())).collect();
    assert_eq!(parts, [(false, true), (true, false), (false, false)]);
    let lights: Vec<_> = scene.lights.iter().map(|l| (l.dynamic, l.baked)).collect();
    assert_eq!(lights, [(false, true), (true, false)]);
}

/// A room of 3 x 2.5 x 4 m: six squares as one mesh, another of them inside it twice, lit by a lamp and a glowing panel.
fn room() -> Gltf {
    let mut gltf = Gltf::empty();
    gltf.push(
        "materials",
        json!({"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.6, 0.5, 1.0]}, "doubleSided": true}),
    );
    gltf.push("materials", json!({"emissiveFactor": [1.0, 0.9, 0.7]}));
    let square = squares(&mut gltf, 1);
    gltf.push("meshes", json!({"name": "wall", "primitives": [square]}));
    let mut panel = squares(&mut gltf, 1);
    panel["material"] = json!(1);
    gltf.push("meshes", json!({"name": "panel", "primitives": [panel]}));
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let walls = [
        ([0.0, 0.0, 0.0], [3.0, 2.5, 1.0], [0.0, 0.0, 0.0, 1.0]),
        ([3.0, 0.0, 4.0], [3.0, 2.5, 1.0], [0.0, 1.0, 0.0, 0.0]),
        ([0.0, 0.0, 4.0], [4.0, 2.5, 1.0], [0.0, half, 0.0, half]),
        ([3.0, 0.0, 0.0], [4.0, 2.5, 1.0], [0.0, -half, 0.0, half]),
        ([0.0, 0.0, 4.0], [3.0, 4.0, 1.0], [-half, 0.0, 0.0, half]),
        ([0.0, 2.5, 0.0], [3.0, 4.0, 1.0], [half, 0.0, 0.0, half]),
        ([1.0, 0.4, 2.0], [1.0, 1.5, 1.0], [-half, 0.0, 0.0, half]),
    ];
    for (translation, scale, rotation) in walls {
        gltf.root_node(json!({"mesh": 0, "translation": translation, "scale": scale, "rotation": rotation}));
    }
    gltf.root_node(json!({"mesh": 1, "translation": [1, 1, 3.9], "rotation": [0, 1, 0, 0]}));
    *gltf.at("/extensionsUsed") = json!(["KHR_lights_punctual"]);
    *gltf.at("/extensions") =
        json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 3.0}]}});
    gltf.root_node(
        json!({"translation": [2.2, 1.9, 1.1], "extensions": {"KHR_lights_punctual": {"light": 0}}}),
    );
    gltf
}

#[test]
fn a_room_holds_what_paths_bring_to_its_walls() {
    /// Noise of 256 paths a texel, a texel's extent, and 8 bits.
    const MEAN_ERROR: f64 = 0.05;
    let file = File::new(room());
    let scene = file.bake_with(Density::Side(64), 256);
    let mut before = file.prepare(Density::Side(64)).unwrap().scene;
    before.lights.iter_mut().for_each(|l| l.baked = false);
    let paths = Paths::new(&before, before.lights.iter().collect(), SETTINGS.bounces);
    let (mut sum, mut count) = (0.0, 0.0);
    for instance in 0..7 {
        for triangle in 0..2 {
            let (found, position) = texel(&scene, instance, triangle);
            let normal = scene.instances[instance].world_from_object.z_axis.truncate().normalize().as_dvec3();
            let at = Receiver { position_world: position, normal_world: normal, plane_normal_world: normal };
            let expected = paths.irradiance(&at, 4096, 1);
            assert!(expected.min_element() > 0.0);
            sum += ((found - expected) / expected).abs().element_sum() / 3.0;
            count += 1.0;
        }
    }
    assert!(sum / count < MEAN_ERROR, "{}", sum / count);
}

#[test]
fn the_map_does_not_depend_on_the_number_of_threads() {
    let prepared = File::new(room()).prepare(Density::Side(48)).unwrap();
    let settings = Settings { size: prepared.size, samples: 8, bounces: 1 };
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| bake(&prepared.scene, &settings, || ()).unwrap())
    };
    let one = with(1);
    assert_eq!(one, with(3));
    assert!(one.scale8.iter().any(|m| *m > 0));
}

#[test]
fn a_baked_file_can_be_baked_again() {
    let file = File::new(room());
    file.bake(Density::Side(64));
    let again = prepare(&file.folder.path().join("baked.glb"), Density::Side(64)).unwrap();
    let settings = Settings { size: again.size, ..SETTINGS };
    let map = bake(&again.scene, &settings, || ()).unwrap();
    // The lamp counts although the file says that it is baked.
    let brightest = |map: &Lightmap| {
        let all = (0..map.width * map.height).map(|i| map.texel(i % map.width, i / map.width).x);
        all.fold(0.0, f64::max)
    };
    let first = Scene::load(&file.folder.path().join("baked.glb")).unwrap().lightmap.unwrap();
    let ratio = brightest(&map) / brightest(&first);
    assert!((ratio - 1.0).abs() < 0.2, "{ratio}");
}

fn error(gltf: Gltf, density: Density) -> String {
    let file = File::new(gltf);
    let prepared = file.prepare(density);
    let baked = prepared.and_then(|p| bake(&p.scene, &Settings { size: p.size, ..SETTINGS }, || ()));
    baked.expect_err("it cannot be baked").to_string()
}

#[test]
fn what_cannot_be_baked_is_explained() {
    let mut unlit = sunny();
    *unlit.at("/materials/0/extensions") = json!({"KHR_materials_unlit": {}});
    let mut dark = sunny();
    dark.json["nodes"].as_array_mut().unwrap().pop();
    dark.json["scenes"][0]["nodes"] = json!([0]);
    let mut overlapping = sunny();
    let texcoords = overlapping.floats("VEC2", &[0.0, 0.0, 2.0, 0.0, 2.0, 2.0, 0.0, 2.0]);
    *overlapping.at("/meshes/0/primitives/0/attributes/TEXCOORD_1") = json!(texcoords);
    let picture = gltf_build::png(1, 1, &[255; 4]);
    let texture = overlapping.texture(&picture);
    *overlapping.at("/materials/0/pbrMetallicRoughness/baseColorTexture") =
        json!({"index": texture, "texCoord": 1});
    let cases = [
        (unlit, Density::Side(64), "nothing in the scene is lit"),
        (dark, Density::Side(64), "no light to bake"),
        (overlapping, Density::Side(64), "meshes[0].primitives[0].attributes.TEXCOORD_1"),
        (sunny(), Density::TexelsPerMetre(1e5), "ask for"),
        (room(), Density::Side(2), "do not fit a lightmap of 2x2"),
    ];
    for (gltf, density, expected) in cases {
        let message = error(gltf, density);
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn bad_extras_are_refused() {
    let node = |value: Value| ("/nodes/0/extras", json!({"ontile": {"lightmap": value}}));
    let root = |key: &str, value: Value| ("/scenes/0/extras", json!({"ontile": {key: value}}));
    let cases = [
        (node(json!(true)), "nodes[0].extras.ontile.lightmap"),
        (node(json!([0, 0, 1])), "nodes[0].extras.ontile.lightmap"),
        (node(json!([0, 0, 1, 1e99])), "nodes[0].extras.ontile.lightmap"),
        (node(json!([0, 0, 1, 1])), "no TEXCOORD_1"),
        (("/nodes/0/extras", json!({"ontile": 7})), "nodes[0].extras.ontile: is 7"),
        (("/nodes/0/extras", json!({"ontile": {"dynamic": 1}})), "nodes[0].extras.ontile.dynamic"),
        (("/nodes/1/extras", json!({"ontile": {"baked": "yes"}})), "nodes[1].extras.ontile.baked"),
        (root("lightmap", json!({"color_image": 0, "scale_image": 1, "unit_lx": 1})), "refers to images[0]"),
        (root("lightmap", json!({"color_image": 0})), "has no unit_lx"),
        (root("background", json!("blue")), "#87ceeb"),
        (root("background", json!(7)), "must be a text"),
        (root("fog", json!({"density": -1, "color": [0, 0, 0]})), "fog.density"),
        (root("fog", json!({"density": 1, "color": [0, -1, 0]})), "fog.color"),
        (root("fog", json!({"density": 1, "color": [0, 0, 0], "base": 3})), "stands alone"),
        (root("fog", json!({"density": 1, "color": [0, 0, 0], "base": 3, "scale": 0})), "fog.scale"),
        (root("fog", json!({"density": 1, "color": [0, 0, 0], "colour": 3})), "use one of"),
    ];
    for ((pointer, extras), expected) in cases {
        let mut gltf = sunny();
        *gltf.at(pointer) = extras.clone();
        let message = gltf.load().err().unwrap_or_else(|| panic!("{extras} is taken")).to_string();
        assert!(message.contains(expected), "{extras}: {message}");
    }
    let mut fine = sunny();
    let fog = json!({"density": 0.5, "color": [1, 2, 3], "base": -1, "scale": 4});
    *fine.at("/scenes/0/extras") = json!({"ontile": {"background": "#010203", "fog": fog}, "other": [1]});
    let scene = fine.load().unwrap();
    let fog = scene.fog.unwrap();
    assert_eq!((fog.density_per_m, fog.color_nt), (0.5, Vec3::new(1.0, 2.0, 3.0)));
    assert_eq!(fog.height.map(|h| (h.base_m, h.scale_m)), Some((-1.0, 4.0)));
    assert_ne!(scene.background, ontile::scene::Background::Black);
}

#[test]
fn a_cut_mesh_keeps_its_other_attributes() {
    // Two squares that share no chart: their vertices are copied with normals, colours and a morph target.
    let mut gltf = sunny();
    let mut square = squares(&mut gltf, 2);
    let normals = gltf.floats("VEC3", &[0.0, 0.0, 1.0].repeat(8));
    let colors: Vec<u8> = (0..8).flat_map(|i| [i * 10, 255 - i, 7, 255]).collect();
    let colors = gltf.accessor(&colors, gltf_build::U8, "VEC4", 8);
    gltf.json["accessors"][colors]["normalized"] = json!(true);
    let morph = gltf.floats("VEC3", &[0.0, 0.0, 0.25].repeat(8));
    square["attributes"]["NORMAL"] = json!(normals);
    square["attributes"]["COLOR_0"] = json!(colors);
    square["targets"] = json!([{"POSITION": morph}]);
    *gltf.at("/meshes/0") = json!({"primitives": [square], "weights": [1.0]});
    let before = gltf.load().unwrap();
    let after = File::new(gltf).bake(Density::Side(64));
    let corners = |scene: &Scene| -> Vec<_> {
        let mesh = &scene.meshes[0];
        mesh.indices
            .iter()
            .map(|&i| (mesh.positions[i as usize], mesh.normals[i as usize], mesh.colors[i as usize]))
            .collect()
    };
    assert_eq!(corners(&before), corners(&after));
    assert!(before.meshes[0].texcoords[1].is_empty() && !after.meshes[0].texcoords[1].is_empty());
}

#[test]
fn shipped_scenes_get_maps_in_which_no_texel_is_used_twice() {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    for name in ["grid", "lamps"] {
        let prepared = prepare(&assets.join(name).with_extension("glb"), Density::Side(512)).unwrap();
        let mut rects: Vec<_> = prepared.scene.instances.iter().filter_map(|i| i.lightmap).collect();
        assert!(!rects.is_empty());
        // Primitives of one node share its part.
        rects.dedup();
        for (i, a) in rects.iter().enumerate() {
            for b in &rects[..i] {
                const ROUNDING: f32 = 1e-6;
                let ends = |r: &ontile::scene::LightmapRect| r.origin + r.size - ROUNDING;
                let apart = ends(a).cmple(b.origin) | ends(b).cmple(a.origin);
                assert!(apart.any(), "{name}: {a:?} {b:?}");
            }
        }
        for mesh in prepared.scene.meshes.iter().filter(|m| !prepared.scene.materials[m.material].unlit) {
            let inside = |uv: &Vec2| uv.min_element() >= 0.0 && uv.max_element() <= 1.0;
            assert!(
                !mesh.texcoords[1].is_empty() && mesh.texcoords[1].iter().all(inside),
                "{name}: {}",
                mesh.name
            );
        }
    }
}
