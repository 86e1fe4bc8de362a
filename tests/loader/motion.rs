//! Animations: what they move, and where.

use std::f32::consts::FRAC_1_SQRT_2;

use ontile::glam::{Mat4, Quat, Vec3};
use ontile::scene::{Light, LightKind, Particles, Play, Scene, World};
use serde_json::json;

use crate::close;
use crate::gltf_build::{Gltf, U8, animate};

fn at(scene: &Scene, time_s: f64) -> Scene {
    let mut scene = scene.clone();
    scene.animate(&[Play { animation: 0, time_s }]).unwrap();
    scene
}

const UP: &[f32] = &[0.0, 0.0, 0.0, 0.0, 2.0, 0.0];

/// A parent that rises with a triangle, a lamp, a camera, a decal and two sparks hanging from it, and a triangle that stays.
fn lift() -> Gltf {
    let mut file = Gltf::triangle();
    file.root_node(json!({"mesh": 0, "translation": [9, 0, 0]}));
    file.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    file.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    file.push("cameras", json!({"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}));
    let lamp = json!({"translation": [1, 0, 0], "extensions": {"KHR_lights_punctual": {"light": 0}}});
    let positions = file.floats("VEC3", &[0.0, 0.0, 0.0, 0.5, 0.0, 0.0]);
    let points = json!({"attributes": {"POSITION": positions}, "mode": 0});
    let sparks = file.push("meshes", json!({"primitives": [points]}));
    let hanging = [
        json!({"mesh": 0, "translation": [0, 0, 1]}),
        lamp,
        json!({"camera": 0, "scale": [2, 2, 2]}),
        json!({"extras": {"ontile": {"decal": {"material": 0, "size": [1, 2, 3]}}}}),
        json!({"mesh": sparks, "scale": [2, 2, 2], "extras": {"ontile": {"particles": {}}}}),
    ]
    .map(|node| file.push("nodes", node));
    let parent = file.root_node(json!({"children": hanging}));
    animate(&mut file, &[(parent, "translation", "LINEAR", &[1.0, 3.0], "VEC3", UP)]);
    file
}

#[test]
fn all_that_hangs_from_a_node_goes_with_it() {
    let file = lift();
    let (still, moving) = (file.load().unwrap(), file.load_moving().unwrap());
    assert!(still.motion.is_none());
    let dynamic = |scene: &Scene| scene.instances.iter().map(|i| i.dynamic).collect::<Vec<_>>();
    assert_eq!(dynamic(&still), [false; 3]);
    assert_eq!(dynamic(&moving), [false, false, true]);
    assert!(moving.lights[0].dynamic);
    for (time, y) in [(0.0, 0.0), (1.5, 0.5), (3.0, 2.0), (99.0, 2.0)] {
        let scene = at(&moving, time);
        let places = [0, 1, 2].map(|i| scene.instances[i].world_from_object.w_axis.truncate());
        assert_eq!(places, [Vec3::ZERO, Vec3::new(9.0, 0.0, 0.0), Vec3::new(0.0, y, 1.0)]);
        assert_eq!(scene.lights[0].position_world, Vec3::new(1.0, y, 0.0));
        assert_eq!(scene.cameras[0].world_from_view, Mat4::from_translation(Vec3::new(0.0, y, 0.0)));
        let size = Mat4::from_scale(Vec3::new(1.0, 2.0, 3.0));
        assert_eq!(scene.decals[0].world_from_decal, Mat4::from_translation(Vec3::new(0.0, y, 0.0)) * size);
        let sparks: Vec<_> = scene.particles[0].list.iter().map(|p| (p.position_world, p.size_m)).collect();
        assert_eq!(sparks, [(Vec3::new(0.0, y, 0.0), 0.1), (Vec3::new(1.0, y, 0.0), 0.1)]);
        scene.check().unwrap();
    }
}

#[test]
fn a_world_notes_what_moves_and_lets_go_of_what_is_removed() {
    let mut world = World::from(lift().load_moving().unwrap());
    let play = |time_s| [Play { animation: 0, time_s }];
    world.animate(&play(0.5)).unwrap();
    assert!(world.changes().is_empty(), "all is still where it was");
    world.animate(&play(2.0)).unwrap();
    assert!(!world.changes().is_empty() && !world.changes().is_structural());
    let light = world.ids::<Light>().next().unwrap();
    world.remove(light).unwrap();
    let other = world.add(Light::new(LightKind::Point { intensity_cd: 1.0 })).unwrap();
    assert_eq!(other.index(), light.index());
    world.animate(&play(3.0)).unwrap();
    assert_eq!(world.get(other).unwrap().position_world, Vec3::ZERO, "it was never on the lift");
    let sparks = world.ids::<Particles>().next().unwrap();
    let of = |world: &World| world.get(sparks).unwrap().list.clone();
    let fewer = Particles { list: of(&world)[..1].to_vec(), ..world.get(sparks).unwrap().clone() };
    world.set(sparks, fewer).unwrap();
    world.animate(&play(1.5)).unwrap();
    assert_eq!(of(&world)[0].position_world, Vec3::new(0.0, 0.5, 0.0), "those there are go on");
    world.remove(sparks).unwrap();
    world.animate(&play(2.0)).unwrap();
}

/// Of every property, by a quarter turn that small integers hold, a spline, and steps; two animations at once.
#[test]
fn every_property_and_interpolation() {
    let mut file = Gltf::triangle();
    let turns = file.accessor(&[0, 0, 0, 127, 0, 90, 0, 90], 5120, "VEC4", 2);
    *file.at(&format!("/accessors/{turns}/normalized")) = json!(true);
    let scales = [[0.0; 3], [1.0; 3], [0.0; 3], [0.0; 3], [3.0; 3], [0.0; 3]].concat();
    animate(&mut file, &[(0, "rotation", "LINEAR", &[0.0, 2.0], "VEC4", &[0.0; 8])]);
    *file.at("/animations/0/samplers/0/output") = json!(turns);
    animate(
        &mut file,
        &[
            (0, "scale", "CUBICSPLINE", &[0.0, 2.0], "VEC3", &scales),
            (0, "translation", "STEP", &[0.0, 1.5], "VEC3", UP),
        ],
    );
    let mut scene = file.load_moving().unwrap();
    scene.animate(&[0, 1].map(|animation| Play { animation, time_s: 1.0 })).unwrap();
    let turn = Quat::from_xyzw(0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2);
    let half = Quat::IDENTITY.slerp(turn, 0.5);
    let world = scene.instances[0].world_from_object;
    for (axis, wanted) in [(Vec3::X, half * Vec3::X), (Vec3::Z, half * Vec3::Z)] {
        assert!(close(world.transform_vector3(axis), (wanted * 2.0).to_array()), "{axis}");
    }
    assert_eq!(world.w_axis.truncate(), Vec3::ZERO);
    scene.animate(&[Play { animation: 1, time_s: 1.5 }]).unwrap();
    assert!(close(scene.instances[0].world_from_object.w_axis.truncate(), [0.0, 2.0, 0.0]));
    assert!(scene.animate(&[Play { animation: 2, time_s: 0.0 }]).is_err());
    assert!(scene.animate(&[Play { animation: 0, time_s: f64::NAN }]).is_err());
    assert_eq!(scene.motion.as_ref().unwrap().animation("go").unwrap(), 0);
}

/// Two joints, the second of which goes up, each with a vertex of its own and one between them; the mesh's own node counts for nothing.
/// More than four joints a vertex, and weights that add up to 2, are as good.
#[test]
fn joints_take_vertices_along() {
    let mut file = Gltf::triangle();
    let joints = file.accessor(&[0, 0, 0, 0, 1, 0, 0, 0, 0, 9, 0, 0], U8, "VEC4", 3);
    let weights = file.floats("VEC4", &[1., 0., 0., 0., 0.5, 0., 0., 0., 1., 0., 0., 0.]);
    let more = file.accessor(&[0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0], U8, "VEC4", 3);
    let more_weights = file.floats("VEC4", &[1., 0., 0., 0., 0.5, 0., 0., 0., 1., 0., 0., 0.]);
    for (name, accessor) in
        [("JOINTS_0", joints), ("WEIGHTS_0", weights), ("JOINTS_1", more), ("WEIGHTS_1", more_weights)]
    {
        *file.at(&format!("/meshes/0/primitives/0/attributes/{name}")) = json!(accessor);
    }
    let first = file.root_node(json!({"translation": [5, 0, 0]}));
    let second = file.root_node(json!({"translation": [5, 0, 0]}));
    let binds: Vec<f32> =
        [Mat4::IDENTITY, Mat4::from_translation(Vec3::Z)].iter().flat_map(|m| m.to_cols_array()).collect();
    let binds = file.floats("MAT4", &binds);
    file.push("skins", json!({"joints": [first, second], "inverseBindMatrices": binds}));
    *file.at("/nodes/0") = json!({"mesh": 0, "skin": 0, "translation": [0, 0, 7]});
    let up: Vec<f32> = vec![5.0, 0.0, 0.0, 5.0, 2.0, 0.0];
    animate(&mut file, &[(second, "translation", "LINEAR", &[0.0, 1.0], "VEC3", &up)]);
    let scene = at(&file.load_moving().unwrap(), 1.0);
    scene.check().unwrap();
    let instance = &scene.instances[0];
    let posed = scene.meshes[instance.mesh].posed();
    let places = [0, 1, 2].map(|v| instance.world_from_object.transform_point3(posed.positions[v]));
    assert!(close(places[0], [5.0, 0.0, 0.0]), "{places:?}");
    assert!(close(places[1], [6.0, 2.0, 1.0]), "{places:?}");
    assert!(close(places[2], [5.0, 2.0, 0.5]), "half way between both: {places:?}");
    // What does not move is placed once and for all.
    let still = file.load().unwrap();
    assert!(still.meshes[0].deformation.is_none());
    assert!(close(still.meshes[0].positions[1], [6.0, 0.0, 1.0]));
}

/// Weights of the file's animation in place of the node's, and normals beside positions.
#[test]
fn targets_are_added_by_weight() {
    let mut file = Gltf::triangle();
    let up = file.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let turn = file.floats("VEC3", &[1.0, 0.0, -1.0, 1.0, 0.0, -1.0, 1.0, 0.0, -1.0]);
    *file.at("/meshes/0/primitives/0/targets") = json!([{"POSITION": up}, {"NORMAL": turn}]);
    *file.at("/meshes/0/weights") = json!([0.25, 0.0]);
    animate(&mut file, &[(0, "weights", "LINEAR", &[0.0, 1.0], "SCALAR", &[0.0, 0.0, 4.0, 1.0])]);
    let moving = file.load_moving().unwrap();
    let rest = moving.meshes[0].posed();
    assert_eq!((rest.positions[1], rest.normals[1]), (Vec3::new(1.0, 0.0, 0.25), Vec3::Z));
    let scene = at(&moving, 0.5);
    let posed = scene.meshes[0].posed();
    assert_eq!(posed.positions[1], Vec3::new(1.0, 0.0, 2.0));
    assert!(close(posed.normals[1], [FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2]));
    assert_eq!(file.load().unwrap().meshes[0].positions[1], Vec3::new(1.0, 0.0, 0.25));
}

/// What is changed, and where and what the message says.
type Fault = (fn(&mut Gltf), &'static str, &'static str);

#[test]
fn what_is_wrong_is_named() {
    const PARENT: usize = 7;
    fn times(file: &mut Gltf, times: &[f32]) {
        let input = file.floats("SCALAR", times);
        *file.at("/animations/0/samplers/0/input") = json!(input);
    }
    fn values(file: &mut Gltf, path: &str, kind: &str, values: &[f32]) {
        let output = file.floats(kind, values);
        *file.at("/animations/0/samplers/0/output") = json!(output);
        *file.at("/animations/0/channels/0/target/path") = json!(path);
    }
    const SAMPLER: &str = "animations[0].samplers[0]";
    const CHANNEL: &str = "animations[0].channels[0]";
    let faults: [Fault; 14] = [
        (|f| times(f, &[1.0, 1.0]), SAMPLER, "not later"),
        (|f| times(f, &[2.0, 1.0]), SAMPLER, "not later"),
        (|f| times(f, &[-1.0, 1.0]), SAMPLER, "before 0"),
        (|f| times(f, &[0.0, 1.0, 2.0]), SAMPLER, "6 numbers for its keys, not 9"),
        (|f| times(f, &[0.0, f32::NAN]), "animations[0].samplers[0].input", "not finite"),
        (|f| values(f, "translation", "VEC4", &[0.0; 8]), "animations[0].samplers[0].output", "Vec4"),
        (|f| values(f, "rotation", "VEC4", &[0.0; 8]), SAMPLER, "length 0"),
        (
            |f| {
                let target = json!({"node": PARENT, "path": "weights"});
                let channel = json!({"sampler": 0, "target": target});
                f.json["animations"][0]["channels"].as_array_mut().unwrap().push(channel);
            },
            "animations[0].channels[1]",
            "no morph targets",
        ),
        (
            |f| *f.at("/animations/0/samplers/0/interpolation") = json!("CUBICSPLINE"),
            SAMPLER,
            "6 numbers for its keys, not 18",
        ),
        (
            |f| *f.at("/animations/0/samplers/0/interpolation") = json!("SMOOTH"),
            "animations[0].samplers[0].interpolation",
            "does not define",
        ),
        (
            |f| *f.at("/animations/0/channels/0/sampler") = json!(7),
            "animations[0].channels[0].sampler",
            "there are 1",
        ),
        (
            |f| *f.at("/animations/0/channels/0/target/node") = json!(99),
            "animations[0].channels[0].target.node",
            "nodes[99]",
        ),
        (
            |f| f.json["nodes"][PARENT]["matrix"] = json!(Mat4::IDENTITY.to_cols_array()),
            CHANNEL,
            "which has a matrix",
        ),
        (
            |f| {
                let first = f.json["animations"][0]["channels"][0].clone();
                f.json["animations"][0]["channels"].as_array_mut().unwrap().push(first);
            },
            "animations[0].channels[1]",
            "another channel",
        ),
    ];
    for (index, (change, place, part)) in faults.into_iter().enumerate() {
        let mut file = lift();
        change(&mut file);
        let error = file.load_moving().unwrap_err().to_string();
        assert!(error.contains(place) && error.contains(part), "{index}: {error}");
    }
}
