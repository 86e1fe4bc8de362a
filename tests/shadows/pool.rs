//! The map is shared out by importance, and is no larger than it must be.

use crate::common::scenes::shadow_scenes::{one_light_each, room};
use ontile::glam::Vec3;
use ontile::plan::{Limits, Needs, Options, Plan, ShadowFormat, ShadowOptions};
use ontile::scene::{Light, LightKind, Scene, Shadow};

fn plan(scene: &Scene, shadows: ShadowOptions) -> Plan {
    Plan::new(Needs::of(scene), Options { shadows, ..Options::default() }, &Limits::default()).unwrap()
}

/// Ten lights of each shape, those of later tens more important.
fn many_lights() -> Scene {
    let mut scene = room();
    for priority in 0..10 {
        for light in one_light_each().into_iter().flat_map(|s| s.lights) {
            let name = format!("{} {priority}", light.name);
            scene.lights.push(Light { name, priority: priority as f32, ..light });
        }
    }
    scene
}

/// Whether of the lights of each shape none has smaller tiles than one that comes later; some must have larger ones.
fn no_less_than_later_ones<'a>(
    lights: impl Iterator<Item = &'a Light>,
    texels: impl Fn(&Light) -> u32,
) -> bool {
    let lights: Vec<_> = lights.collect();
    let shape = |light: &Light| light.name.split(' ').next().map(str::to_owned);
    let mut pairs = Vec::new();
    for (i, a) in lights.iter().enumerate() {
        pairs.extend(lights[i + 1..].iter().filter(|b| shape(a) == shape(b)).map(|b| (texels(a), texels(b))));
    }
    pairs.iter().all(|(a, b)| a >= b) && pairs.iter().any(|(a, b)| a > b)
}

#[test]
fn tiles_share_the_map_without_overlap() {
    let scene = many_lights();
    for most_texels in [600, 1024, 4096] {
        let options = ShadowOptions { most_texels, ..ShadowOptions::default() };
        let plan = plan(&scene, options.clone());
        assert_eq!(plan, self::plan(&scene, options), "the same again");
        let map = plan.shadow_map.as_ref().unwrap();
        let [width, height] = map.size;
        assert!(width.max(height) <= most_texels, "{:?}", map.size);
        let mut used = vec![false; (width * height / 64 / 64) as usize];
        for tile in &map.tiles {
            assert!(tile.x + tile.texels <= width && tile.y + tile.texels <= height, "{tile:?}");
            for y in (tile.y..tile.y + tile.texels).step_by(64) {
                for x in (tile.x..tile.x + tile.texels).step_by(64) {
                    let cell = &mut used[(y / 64 * (width / 64) + x / 64) as usize];
                    assert!(!*cell, "{tile:?} overlaps another tile");
                    *cell = true;
                }
            }
        }
        let texels = |l: &Light| map.lights.iter().find(|m| m.name == l.name).map_or(0, |m| m.size.texels);
        assert!(no_less_than_later_ones(scene.lights.iter().rev(), texels));
        // Among equals the first of the scene.
        let mut equal = scene.clone();
        equal.lights.iter_mut().for_each(|light| light.priority = 0.0);
        let plan_of_equals = self::plan(&equal, ShadowOptions { most_texels, ..ShadowOptions::default() });
        let map_of_equals = plan_of_equals.shadow_map.unwrap();
        let texels =
            |l: &Light| map_of_equals.lights.iter().find(|m| m.name == l.name).map_or(0, |m| m.size.texels);
        assert!(no_less_than_later_ones(equal.lights.iter(), texels));
        // Who lost something is told of; 50 lights ask for more than any of these maps has.
        let noted = |name: &str| {
            plan.notes.iter().chain(&plan.warnings).any(|n| n.contains(&format!("light '{name}'")))
        };
        for light in &scene.lights {
            let has = map.lights.iter().any(|l| l.name == light.name);
            assert!(has || noted(&light.name), "{}", light.name);
        }
        assert!(noted("bulb 0"), "{:?}", plan.notes);
    }
}

#[test]
fn a_map_is_no_larger_than_what_is_in_it() {
    let size = |scene: &Scene, shadows| plan(scene, shadows).shadow_map.map(|m| m.size);
    let default = ShadowOptions::default;
    let scenes = one_light_each();
    let sizes: Vec<_> = scenes.iter().map(|s| (s.name.as_str(), size(s, default()).unwrap())).collect();
    // 1280 pixels: tiles of 1024, a cube's of 512. 3 cascades; 1; 1; 6 faces; 6 faces.
    let expected = [
        ("sun", [2048, 2048]),
        ("slab", [1024, 1024]),
        ("spot", [1024, 1024]),
        ("wide", [2048, 1024]),
        ("bulb", [2048, 1024]),
    ];
    assert_eq!(sizes, expected);
    let small = ShadowOptions { tile_texels: Some(300), cascades: 2, ..default() };
    assert_eq!(size(&scenes[0], small), Some([512, 256]));
    let bytes = |scene: &Scene, format| {
        plan(scene, ShadowOptions { format, ..default() }).shadow_map.unwrap().bytes()
    };
    let formats = [ShadowFormat::D32, ShadowFormat::D16, ShadowFormat::Auto];
    assert_eq!(formats.map(|format| bytes(&scenes[1], format)), [4 << 20, 2 << 20, 2 << 20]);
    assert_eq!(formats.map(|format| bytes(&scenes[2], format)), [4 << 20, 2 << 20, 4 << 20]);
}

#[test]
fn no_shadow_costs_nothing() {
    let map = |scene: &Scene| plan(scene, ShadowOptions::default()).shadow_map;
    let lit = &one_light_each()[2];
    assert!(map(lit).is_some());
    let mut dark = lit.clone();
    dark.lights[0].color = Vec3::ZERO;
    let mut unlit = lit.clone();
    unlit.materials.iter_mut().for_each(|m| m.unlit = true);
    let mut alone = lit.clone();
    alone.instances.clear();
    let hemisphere = Light::new(LightKind::Hemisphere { illuminance_lx: 1.0 });
    let sky = Light { shadow: Some(Shadow::default()), ..hemisphere };
    let around = Scene { lights: vec![sky], ..lit.clone() };
    // Nor does a static map exist where everything stands still or everything moves, or where the light itself moves.
    let has_static_map = |light: bool, instances: &[bool]| {
        let mut scene = lit.clone();
        scene.lights[0].dynamic = light;
        scene.instances.iter_mut().zip(instances).for_each(|(instance, dynamic)| instance.dynamic = *dynamic);
        map(&scene).unwrap().has_static_map
    };
    let all = vec![true; lit.instances.len()];
    let found = [(false, &[][..]), (false, &all), (true, &[true]), (false, &[true])];
    assert_eq!(found.map(|(light, instances)| has_static_map(light, instances)), [false, false, false, true]);
    for scene in [lit.clone().without_shadows(), dark, unlit, alone, around] {
        assert_eq!(map(&scene), None);
    }
}
