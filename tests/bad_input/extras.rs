//! Extras that this program reads.

use serde_json::{Value, json};

use crate::gltf_build::{Gltf, load_bytes, png};
use crate::{expect_input_error, lit_by, set};

/// A triangle with one texture, lit by one light.
fn lit(type_: &str) -> Gltf {
    let mut file = Gltf::triangle();
    file.texture(&png(1, 1, &[255; 4]));
    lit_by(&mut file, json!({"type": type_, "spot": {}}));
    file
}

#[test]
fn wrong_values_are_told_with_their_place() {
    let sized = |size: Value| json!({"box": {"size": size}});
    let mapped = |map: Value| json!({"globe_map": map});
    let cases: Vec<(&str, Value, &str, &str)> = vec![
        ("point", json!([]), "", "must be an object"),
        ("point", json!({"shadows": true}), ".shadows", "not a name"),
        ("point", json!({"shadow": "yes"}), ".shadow", "must be an object"),
        ("point", json!({"shadow": {"spread": 1}}), ".shadow.spread", "not a name"),
        ("point", json!({"shadow": {"bias_texels": -1}}), ".shadow.bias_texels", "from 0 to 64"),
        ("point", json!({"shadow": {"bias_texels": 65}}), ".shadow.bias_texels", "from 0 to 64"),
        ("point", json!({"shadow": {"volume": 1}}), ".shadow.volume", "true or false"),
        ("point", json!({"shadow": {"spread_texels": 12.5}}), ".shadow.spread_texels", "from 0 to 12"),
        ("point", json!({"dynamic": 1}), ".dynamic", "true or false"),
        ("point", json!({"priority": "high"}), ".priority", "a number"),
        ("point", json!({"priority": 1e39}), ".priority", "a number"),
        ("spot", json!({"back_color": [1, 1, 1]}), ".back_color", "directional"),
        ("point", json!({"ground_color": [1, 1, 1]}), ".ground_color", "directional"),
        ("spot", sized(json!([1, 1, 1])), ".box", "directional"),
        ("directional", json!({"back_color": [1, 1]}), ".back_color", "3 numbers"),
        ("directional", json!({"back_color": [1, -1, 1]}), ".back_color", "at least 0"),
        ("directional", json!({"back_color": [1, 1e39, 1]}), ".back_color", "3 numbers"),
        ("directional", json!({"ground_color": "blue"}), ".ground_color", "3 numbers"),
        (
            "directional",
            json!({"ground_color": [1, 1, 1], "back_color": [1, 1, 1]}),
            ".back_color",
            "ground_color",
        ),
        ("directional", json!({"ground_color": [1, 1, 1], "shadow": true}), ".shadow", "no shadows"),
        ("directional", json!({"ground_color": [1, 1, 1], "box": {}}), ".ground_color", "no box"),
        ("directional", json!({"box": {}}), ".box", "no size"),
        ("directional", sized(json!(1)), ".box.size", "3 numbers above 0"),
        ("directional", sized(json!([1, 0, 1])), ".box.size", "above 0"),
        ("directional", json!({"box": {"size": [1, 1, 1], "falloff": -0.1}}), ".box.falloff", "at least 0"),
        ("directional", json!({"box": {"size": [1, 1, 1], "radius": 1}}), ".box.radius", "not a name"),
        ("directional", mapped(json!({"texture": 0})), ".globe_map", "spot, box and point"),
        ("spot", mapped(json!(0)), ".globe_map", "must be an object"),
        ("spot", mapped(json!({"rotation": 1})), ".globe_map", "no texture"),
        ("spot", mapped(json!({"texture": -1})), ".globe_map.texture", "an index"),
        ("spot", mapped(json!({"texture": 1})), ".globe_map.texture", "but there are 1"),
        ("spot", mapped(json!({"textures": [0, 0, 0, 0, 0, 0]})), ".globe_map.textures", "not a name"),
        ("spot", mapped(json!({"texture": 0, "rotation": "90"})), ".globe_map.rotation", "degrees"),
        ("point", mapped(json!({"texture": 0})), ".globe_map.texture", "not a name"),
        ("point", mapped(json!({"textures": [0, 0, 0, 0, 0]})), ".globe_map.textures", "6 indices"),
        (
            "point",
            mapped(json!({"textures": [0, 0, 0, 0, 0, 9]})),
            ".globe_map.textures[5]",
            "but there are 1",
        ),
    ];
    for (type_, extras, element, problem) in cases {
        let name = format!("{type_} {extras}");
        let (mut of_node, mut of_light) = (lit(type_), lit(type_));
        let extras = json!({"ontile": extras});
        set(&mut of_node, "/nodes/0/extras", extras.clone());
        let place = format!("nodes[0].extras.ontile{element}");
        expect_input_error(&name, of_node.load(), &place, problem);
        set(&mut of_light, "/extensions/KHR_lights_punctual/lights/0/extras", extras);
        let place = format!("extensions.KHR_lights_punctual.lights[0].extras.ontile{element}");
        expect_input_error(&name, of_light.load(), &place, problem);
    }
}

#[test]
fn light_that_no_number_holds() {
    let mut file = lit("directional");
    set(&mut file, "/extensions/KHR_lights_punctual/lights/0/intensity", json!(1e38));
    set(&mut file, "/nodes/0/extras", json!({"ontile": {"back_color": [100, 0, 0]}}));
    expect_input_error(
        "overflow",
        file.load(),
        "extensions.KHR_lights_punctual.lights[0].intensity",
        "exceeds",
    );
}

#[test]
fn what_scenes_say() {
    let map = |map: Value| json!({"lightmap": map});
    let fog = |fog: Value| json!({"fog": fog});
    let grey = [0.5, 0.5, 0.5];
    let cases = [
        (json!({"sky": 1}), ".sky", "not a name"),
        (json!({"background": 7}), ".background", "a text"),
        (json!({"background": "blue"}), ".background", "is 'blue'"),
        (fog(json!(0.1)), ".fog", "an object"),
        (fog(json!({"density": 0.1})), ".fog", "no color"),
        (fog(json!({"density": -1, "color": grey})), ".fog.density", "at least 0"),
        (fog(json!({"density": 1, "color": [1, 1]})), ".fog.color", "3 numbers"),
        (fog(json!({"density": 1, "color": grey, "base": 1})), ".fog.base", "alone"),
        (fog(json!({"density": 1, "color": grey, "base": 1, "scale": 0})), ".fog.scale", "above 0"),
        (map(json!(0)), ".lightmap", "an object"),
        (map(json!({"color_image": 0, "scale_image": 1})), ".lightmap", "no unit_lx"),
        (map(json!({"color_image": 0, "scale_image": 1, "unit_lx": 0})), ".lightmap.unit_lx", "above 0"),
        (map(json!({"color_image": 0, "unit_lx": 1})), ".lightmap", "no scale_image"),
        (
            map(json!({"color_image": 0, "scale_image": 3, "unit_lx": 1})),
            ".lightmap.scale_image",
            "but there are 2",
        ),
        (map(json!({"color_image": 0, "scale_image": 1, "unit_lx": 1})), ".lightmap", "[1, 1] and [2, 1]"),
    ];
    for (extras, element, problem) in cases {
        let name = extras.to_string();
        let mut file = lit("point");
        // Of another size than the first.
        file.texture(&png(2, 1, &[255; 8]));
        set(&mut file, "/scenes/0/extras", json!({"ontile": extras}));
        expect_input_error(&name, file.load(), &format!("scenes[0].extras.ontile{element}"), problem);
    }
}

#[test]
fn extras_of_a_scene_that_the_file_has() {
    let mut file = lit("point");
    set(&mut file, "/extras", json!({"ontile": {"background": "#000000"}}));
    expect_input_error("root", file.load(), "extras.ontile", "belongs to a scene");
    set(&mut file, "/extras", json!({"others": true}));
    file.load().expect("what is not ours is nobody's business");
}

#[test]
fn parts_of_lightmaps() {
    for (value, problem) in [
        (json!(true), "4 numbers"),
        (json!([0, 0, 1]), "4 numbers"),
        (json!([0, 0, 2, 1]), "from 0 to 1"),
        (json!([0, -0.5, 1, 1]), "from 0 to 1"),
    ] {
        let name = value.to_string();
        let mut file = lit("point");
        set(&mut file, "/nodes/0/extras", json!({"ontile": {"lightmap": value}}));
        expect_input_error(&name, file.load(), "nodes[0].extras.ontile.lightmap", problem);
    }
}

#[test]
fn probes() {
    let room = |change: fn(&mut Value)| {
        let mut probe = json!({"size": [4, 3, 5], "falloff": 0.5, "file": "room.hdr"});
        change(&mut probe);
        probe
    };
    for (value, element, problem) in [
        (json!(3), "", "must be an object"),
        (room(|p| p["extent"] = json!(1)), ".extent", "not a name"),
        (room(|p| _ = p.as_object_mut().unwrap().remove("size")), "", "no size"),
        (room(|p| p["size"] = json!([4, 3])), ".size", "3 numbers above 0"),
        (room(|p| p["size"] = json!([4, 0, 5])), ".size", "3 numbers above 0"),
        (room(|p| p["size"] = json!([4, 1e39, 5])), ".size", "3 numbers above 0"),
        (room(|p| p["falloff"] = json!(-1)), ".falloff", "at least 0"),
        (room(|p| p["intensity"] = json!(-1)), ".intensity", "at least 0"),
        (room(|p| p["rotation"] = json!("north")), ".rotation", "degrees"),
        (room(|p| _ = p.as_object_mut().unwrap().remove("file")), "", "no file"),
        (room(|p| p["file"] = json!("http://rooms.example/room.hdr")), ".file", ""),
    ] {
        let name = value.to_string();
        let mut file = lit("point");
        set(&mut file, "/nodes/0/extras", json!({"ontile": {"probe": value}}));
        let place = format!("nodes[0].extras.ontile.probe{element}");
        expect_input_error(&name, file.load(), &place, problem);
    }
    let mut flat = lit("point");
    let node = flat.root_node(json!({"scale": [0, 0, 0]}));
    set(&mut flat, &format!("/nodes/{node}/extras"), json!({"ontile": {"probe": room(|_| ())}}));
    expect_input_error("no axes", flat.load(), &format!("nodes[{node}]"), "leaves no axes");
    let mut missing = lit("point");
    set(&mut missing, "/nodes/0/extras", json!({"ontile": {"probe": room(|_| ())}}));
    expect_input_error(
        "absent",
        missing.load(),
        "nodes[0].extras.ontile.probe.file",
        "room.hdr: No such file",
    );
}

#[test]
fn decals() {
    let decal = |change: fn(&mut Value)| {
        let mut decal = json!({"material": 0, "size": [1, 2, 0.5], "channels": {"base_color": 1}});
        change(&mut decal);
        decal
    };
    for (value, element, problem) in [
        (json!(0), "", "must be an object"),
        (decal(|d| d["opacity"] = json!(1)), ".opacity", "not a name"),
        (decal(|d| _ = d.as_object_mut().unwrap().remove("material")), "", "no material"),
        (decal(|d| d["material"] = json!("red")), ".material", "an index"),
        (decal(|d| d["material"] = json!(-1)), ".material", "an index"),
        (decal(|d| d["material"] = json!(7)), ".material", "but there are 1"),
        (decal(|d| d["size"] = json!(1)), ".size", "3 numbers above 0"),
        (decal(|d| d["size"] = json!([1, 0, 1])), ".size", "3 numbers above 0"),
        (decal(|d| d["size"] = json!([1, 1e39, 1])), ".size", "3 numbers above 0"),
        (decal(|d| d["channels"] = json!(["normal"])), ".channels", "must be an object"),
        (decal(|d| d["channels"] = json!({"colour": 1})), ".channels.colour", "not a name"),
        (decal(|d| d["channels"] = json!({"normal": 1.5})), ".channels.normal", "from 0 to 1"),
        (decal(|d| d["channels"] = json!({"roughness": -0.1})), ".channels.roughness", "from 0 to 1"),
        (decal(|d| d["angle"] = json!(45)), ".angle", "2 numbers from 0 to 90"),
        (decal(|d| d["angle"] = json!([0, 91])), ".angle", "2 numbers from 0 to 90"),
        (decal(|d| d["angle"] = json!([60, 30])), ".angle", "ends before it begins"),
        (decal(|d| d["falloff"] = json!(0.1)), ".falloff", "3 numbers of at least 0"),
        (decal(|d| d["falloff"] = json!([0, -1, 0])), ".falloff", "3 numbers of at least 0"),
        (decal(|d| d["priority"] = json!("top")), ".priority", "a number"),
    ] {
        let name = value.to_string();
        let mut file = lit("point");
        set(&mut file, "/nodes/0/extras", json!({"ontile": {"decal": value}}));
        let place = format!("nodes[0].extras.ontile.decal{element}");
        expect_input_error(&name, file.load(), &place, problem);
    }
    for scale in [json!([0, 0, 0]), json!([1, 0, 1]), json!([1e-40, 1, 1])] {
        let mut flat = lit("point");
        let node = flat.root_node(json!({"scale": scale}));
        set(&mut flat, &format!("/nodes/{node}/extras"), json!({"ontile": {"decal": decal(|_| ())}}));
        expect_input_error("no volume", flat.load(), &format!("nodes[{node}]"), "no volume");
    }
}

/// JSON allows numbers that no float holds: they must not take what stands beside them away.
#[test]
fn numbers_that_are_too_large_are_told() {
    let load = |pointer: &str, extras: Value| {
        let mut file = lit("directional");
        set(&mut file, pointer, extras);
        let text = String::from_utf8(file.to_gltf()).unwrap();
        load_bytes("a.gltf", text.replace("\"@1e999\"", "1e999").as_bytes())
    };
    for (place, extras) in [
        ("nodes[0]", json!({"shadow": false, "priority": "@1e999"})),
        ("nodes[0]", json!({"box": {"size": [1, "@1e999", 1]}})),
        ("nodes[0]", json!({"shadows": false, "unknown": "@1e999"})),
        ("scenes[0]", json!({"fog": "@1e999"})),
    ] {
        let pointer = format!("/{}/extras", place.replace('[', "/").replace(']', ""));
        let got = load(&pointer, json!({"ontile": extras}));
        expect_input_error(&extras.to_string(), got, &format!("{place}.extras.ontile"), "out of range");
    }
    let got = load("/extras", json!({"ontile": {"fog": "@1e999"}}));
    expect_input_error("root", got, "extras.ontile", "belongs to a scene");
    let others = load("/nodes/0/extras", json!({"weight": "@1e999", "ontile": {"shadow": false}})).unwrap();
    assert!(others.lights[0].shadow.is_none(), "numbers of others are nobody's business");
}
