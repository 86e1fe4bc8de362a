//! Extras that this program reads.

use serde_json::{Value, json};

use crate::gltf_build::{Gltf, png};
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
        ("point", json!({"shadow": {"bias_texels": -1}}), ".shadow.bias_texels", "at least 0"),
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
