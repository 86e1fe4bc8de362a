//! What extras add to lights.

use std::f32::consts::{FRAC_PI_2, PI};

use ontile::glam::{Quat, Vec3};
use ontile::scene::{GlobePicture, Light, LightKind, Scene, Shadow};
use serde_json::{Value, json};

use crate::close;
use crate::gltf_build::{Gltf, png};

/// A triangle and lights of these types, each with extras of its own and of its node.
fn lit(lights: &[(&str, Value, Value)]) -> Gltf {
    let mut file = Gltf::triangle();
    let texel = |red: u8| png(1, 1, &[red, 0, 0, 255]);
    (0..6).for_each(|red| _ = file.texture(&texel(red)));
    let list: Vec<_> = lights
        .iter()
        .map(|(type_, extras, _)| json!({"type": type_, "spot": {}, "intensity": 2, "extras": extras}))
        .collect();
    *file.at("/extensions") = json!({"KHR_lights_punctual": {"lights": list}});
    for (light, (_, _, extras)) in lights.iter().enumerate() {
        file.root_node(json!({
            "extensions": {"KHR_lights_punctual": {"light": light}},
            "translation": [light, 0, 0],
            "rotation": Quat::from_rotation_x(-FRAC_PI_2).to_array(),
            "scale": [3, 3, 3],
            "extras": extras,
        }));
    }
    file
}

fn ontile(extras: Value) -> Value {
    json!({"ontile": extras})
}

fn load(lights: &[(&str, Value, Value)]) -> Scene {
    let scene = lit(lights).load().unwrap();
    assert_eq!(scene.warnings, Vec::<String>::new());
    scene
}

#[test]
fn without_extras_lights_cast_shadows_and_nothing_more() {
    // Extras may be anything.
    for extras in [json!(null), json!(7), json!([1]), json!({"ontile_too": 1}), ontile(json!({}))] {
        for light in
            &load(&[("directional", extras.clone(), json!(null)), ("spot", json!(null), extras)]).lights
        {
            let plain = Light {
                name: light.name.clone(),
                position_world: light.position_world,
                shadow: Some(Shadow::default()),
                direction_world: light.direction_world,
                up_world: light.up_world,
                ..Light::new(light.kind)
            };
            assert_eq!(*light, plain);
            // A turn of -90 degrees about X takes +Y to -Z.
            assert!(close(light.up_world, [0.0, 0.0, -1.0]) && close(light.right_world(), [1.0, 0.0, 0.0]));
        }
    }
}

#[test]
fn extras_of_the_node_count_before_those_of_the_light() {
    let own = ontile(json!({"shadow": false, "priority": 2.5, "dynamic": true}));
    let node = ontile(json!({"shadow": {"spread_texels": 4, "volume": true}, "priority": -1}));
    let scene = load(&[("point", own.clone(), node), ("point", own, json!(null))]);
    let [both, own] = &scene.lights[..] else { panic!() };
    assert_eq!(both.shadow, Some(Shadow { spread_texels: 4.0, volume: Some(true), ..Shadow::default() }));
    assert_eq!((both.priority, both.dynamic), (-1.0, true));
    assert_eq!((own.shadow, own.priority, own.dynamic), (None, 2.5, true));
}

#[test]
fn what_hangs_from_a_moving_node_moves() {
    let dynamic = |extras: &[(&str, bool)]| {
        let mut file = lit(&[("point", json!(null), json!(null)), ("spot", json!(null), json!(null))]);
        // 0 has the triangle, 1 and 2 the lights, 3 to 5 nothing: 5 > 4 > 1, and 3 > 0 and 2.
        for children in [json!([0, 2]), json!([1]), json!([4])] {
            file.push("nodes", json!({"children": children}));
        }
        *file.at("/scenes/0/nodes") = json!([3, 5]);
        extras.iter().for_each(|(node, on)| *file.at(node) = ontile(json!({"dynamic": on})));
        let scene = file.load().unwrap();
        (scene.instances[0].dynamic, scene.lights[0].dynamic, scene.lights[1].dynamic)
    };
    assert_eq!(dynamic(&[]), (false, false, false));
    assert_eq!(dynamic(&[("/nodes/5/extras", true)]), (false, true, false));
    assert_eq!(dynamic(&[("/nodes/3/extras", true), ("/nodes/0/extras", false)]), (true, false, true));
}

#[test]
fn directional_lights_become_boxes_and_hemispheres() {
    let scene = load(&[
        (
            "directional",
            ontile(json!({"box": {"size": [1, 2, 3.5], "falloff": 0.25}, "back_color": [1, 0, 0.5]})),
            json!(null),
        ),
        ("directional", ontile(json!({"ground_color": [0.5, 0.25, 0]})), json!(null)),
        ("directional", ontile(json!({"back_color": [0, 0, 1]})), json!(null)),
        ("directional", ontile(json!({"box": {"size": [1, 1, 1]}})), json!(null)),
    ]);
    let kinds: Vec<_> = scene.lights.iter().map(|l| l.kind).collect();
    let illuminance_lx = 2.0;
    let sized = |size_m, falloff_m| LightKind::Box { illuminance_lx, size_m, falloff_m };
    assert_eq!(
        kinds,
        [
            sized(Vec3::new(1.0, 2.0, 3.5), 0.25),
            LightKind::Hemisphere { illuminance_lx },
            LightKind::Directional { illuminance_lx },
            sized(Vec3::ONE, 0.0)
        ]
    );
    let backs: Vec<_> = scene.lights.iter().map(|l| l.back_color.to_array()).collect();
    assert_eq!(backs, [[1.0, 0.0, 0.5], [0.5, 0.25, 0.0], [0.0, 0.0, 1.0], [0.0; 3]]);
    let shadows: Vec<_> = scene.lights.iter().map(|l| l.shadow.is_some()).collect();
    assert_eq!(shadows, [true, false, true, true]);
    assert_eq!(scene.lights[3].position_world, Vec3::X * 3.0);
}

#[test]
fn globe_maps_name_textures() {
    let flat = |texture| ontile(json!({"globe_map": {"texture": texture, "rotation": 90}}));
    let boxed = json!({"box": {"size": [1, 1, 1]}, "globe_map": {"texture": 3}});
    let scene = load(&[
        ("spot", flat(4), json!(null)),
        ("directional", ontile(boxed), json!(null)),
        (
            "point",
            ontile(json!({"globe_map": {"textures": [5, 4, 3, 2, 1, 0], "rotation": -180}})),
            json!(null),
        ),
    ]);
    let maps: Vec<_> = scene.lights.iter().map(|l| l.globe_map.unwrap()).collect();
    assert_eq!(maps.iter().map(|m| m.rotation_rad).collect::<Vec<_>>(), [FRAC_PI_2, 0.0, -PI]);
    let red = |image: usize| scene.images[image].rgba8()[0];
    let pictures: Vec<Vec<u8>> = maps
        .iter()
        .map(|m| match m.picture {
            GlobePicture::Flat { image } => vec![red(image)],
            GlobePicture::Cube { images } => images.map(red).to_vec(),
        })
        .collect();
    assert_eq!(pictures, [vec![4], vec![3], vec![5, 4, 3, 2, 1, 0]]);
    // The scene's own textures are materials'; each picture is decoded once.
    assert_eq!((scene.textures.len(), scene.images.len()), (0, 6));
}
