//! Shadows: where they fall, that they stay there, and what they cost.

mod common;

use common::render::{Gpu, difference, on_device};
use common::scenes::shadow_scenes::{one_light_each, room, shadows};
use ontile::glam::{DVec3, Mat4, Vec3};
use ontile::gpu::{Offscreen, RecordedShadows, RendererConfig, View};
use ontile::picture::{Picture, Pixels};
use ontile::plan::{
    Layout, Limits, Needs, Options, OutputFormat, Plan, ShadowFilter, ShadowFormat, ShadowOptions, Tonemap,
};
use ontile::reference::{self, Frame, Settings};
use ontile::scene::{Camera, Light, LightKind, Scene, Shadow};

const SIZE: [u32; 2] = [320, 180];

fn options(filter: ShadowFilter) -> Options {
    Options {
        size: SIZE,
        layout: Layout::Exact,
        tonemap: Tonemap::Linear,
        output: OutputFormat::Rgba32Float,
        // Texels that are smaller than pixels, so that filters reach over few pixels.
        shadows: ShadowOptions { filter, tile_texels: Some(1024), ..ShadowOptions::default() },
        ..Options::default()
    }
}

fn light_of(picture: &Picture) -> Vec<DVec3> {
    let Pixels::Rgba32F(values) = &picture.pixels else { panic!("a float picture was asked for") };
    let pixel = |p: &[f32]| DVec3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]));
    values.chunks_exact(4).map(pixel).collect()
}

/// How a picture differs from the reference.
#[derive(Debug)]
struct Disagreement {
    /// Pixels that are compared, as a share of all: those that are not at an edge of a surface or near one of a shadow.
    compared: f64,
    /// Of these, the share that is neither as light nor as dark as the reference.
    wrong: f64,
    /// Pixels in shadow by the reference, as a share of all.
    shadowed: f64,
}

impl Disagreement {
    /// A filter of this many pixels reaches over an edge; so does the lattice of texels.
    const REACH_PX: u32 = 4;
    /// Of the reference's light: shadow or not is a matter of all of it.
    const TOLERANCE: f64 = 0.02;

    fn new(frame: &Frame, actual: &[DVec3], dump: Option<&str>) -> Self {
        let [width, height] = frame.size;
        let near = |x: u32, y: u32| {
            let range =
                |n: u32, size: u32| n.saturating_sub(Self::REACH_PX)..(n + Self::REACH_PX + 1).min(size);
            range(y, height).flat_map(move |y| range(x, width).map(move |x| (x, y)))
        };
        let (mut compared, mut wrong, mut shadowed) = (0, 0, 0);
        let mut marks = Vec::new();
        for y in 0..height {
            for x in 0..width {
                let pixel = frame.pixel(x, y);
                shadowed += usize::from(pixel.shadowed != 0);
                let edge = near(x, y).any(|(x, y)| {
                    let other = frame.pixel(x, y);
                    other.edge || other.shadowed != pixel.shadowed
                });
                let error = (actual[(y * width + x) as usize] - pixel.linear).abs().max_element();
                let differs = error > Self::TOLERANCE * pixel.linear.max_element().max(0.05);
                marks.extend(match (edge, differs) {
                    (true, false) => [0.1, 0.1, 0.1, 1.0],
                    (true, true) => [0.2, 0.2, 0.6, 1.0],
                    (false, true) => [1.0, 0.0, 0.0, 1.0],
                    (false, false) => [0.0, 0.3, 0.0, 1.0],
                });
                if !edge {
                    compared += 1;
                    wrong += usize::from(differs);
                }
            }
        }
        if let Some(path) = dump {
            let picture = Picture { width, height, pixels: Pixels::Rgba32F(marks) };
            picture.to_srgb8().write(path.as_ref()).unwrap();
        }
        let all = (width * height) as f64;
        let share = |n: usize, of: f64| n as f64 / of;
        Self {
            compared: share(compared, all),
            wrong: share(wrong, compared as f64),
            shadowed: share(shadowed, all),
        }
    }
}

fn expected(scene: &Scene) -> Frame {
    let settings = Settings { size: SIZE, tonemap: Tonemap::Linear, ..Settings::default() };
    reference::render(scene, &scene.cameras[0], &settings)
}

/// Away from edges a pixel is in shadow or not, whatever the filter. What is left are slivers that are narrower than texels:
/// where a shadow meets what casts it.
const WRONG_SHARE: f64 = 0.002;

#[test]
fn shadows_fall_where_rays_say() {
    let folder = std::env::var_os("ONTILE_SHADOW_PICTURES");
    on_device(None, |gpu| {
        for scene in one_light_each() {
            let frame = expected(&scene);
            for &filter in ShadowFilter::ALL {
                let picture = gpu.picture(&scene, gpu.plan(&scene, options(filter)), 0.0);
                let name = |what| {
                    let folder = folder.as_ref()?.to_str()?;
                    Some(format!("{folder}/{}_{filter}_{what}.png", scene.name))
                };
                if let Some(path) = name("picture") {
                    picture.to_srgb8().write(path.as_ref()).unwrap();
                }
                let found = Disagreement::new(&frame, &light_of(&picture), name("marks").as_deref());
                println!("{}, {filter}: {found:?}", scene.name);
                assert!(found.shadowed > 0.02 && found.compared > 0.4, "the test sees nothing: {found:?}");
                assert!(found.wrong <= WRONG_SHARE, "{}, {filter}: {found:?}", scene.name);
            }
            // Without shadows it is another picture, and this test sees that.
            let bare = scene.clone().without_shadows();
            let picture = gpu.picture(&bare, gpu.plan(&bare, options(ShadowFilter::Grid3)), 0.0);
            let found = Disagreement::new(&frame, &light_of(&picture), None);
            assert!(found.wrong > 5.0 * WRONG_SHARE, "{}: {found:?}", scene.name);
        }
    });
}

/// What recording the last frame took for shadows.
fn taken(offscreen: &Offscreen) -> RecordedShadows {
    offscreen.renderer().recorded().shadows
}

fn render(offscreen: &mut Offscreen, camera: &Camera) -> Picture {
    offscreen.render(&View { camera, exposure_ev: 0.0 }).unwrap();
    offscreen.picture()
}

fn offscreen(gpu: &Gpu<'_>, scene: &Scene, config: RendererConfig) -> Offscreen {
    gpu.offscreen(scene, gpu.plan(scene, options(ShadowFilter::Grid3)), config)
}

/// The room with a sun, a spot and a bulb.
fn three_lights() -> Scene {
    let mut scene = room();
    let lights = one_light_each().into_iter().filter(|s| ["sun", "spot", "bulb"].contains(&&*s.name));
    scene.lights = lights.flat_map(|s| s.lights).collect();
    scene
}

/// Of the room's instances: floor, wall, ball, post, post.
const BALL: usize = 2;

#[test]
fn maps_are_kept_until_what_they_show_changes() {
    on_device(None, |gpu| {
        let scene = three_lights();
        let mut offscreen = offscreen(gpu, &scene, RendererConfig::default());
        let mut camera = scene.cameras[0].clone();
        let first = render(&mut offscreen, &camera);
        let map = offscreen.renderer().plan().shadow_map.clone().unwrap();
        let all = taken(&offscreen);
        let cascades = map.lights.iter().find(|l| l.name == "sun").unwrap().tiles.len();
        // A cascade may be of no use.
        let used = all.tiles - 1 - 6;
        assert!((1..=cascades).contains(&used), "{all:?}");
        assert!(all.draws >= all.tiles && all.casters >= all.draws && all.waiting == 0, "{all:?}");

        // The same again, and closer by less than a texel: nothing is drawn.
        assert_eq!(difference(&first, &render(&mut offscreen, &camera)), None);
        assert_eq!(taken(&offscreen), RecordedShadows::default());
        for _ in 0..4 {
            camera.world_from_view *= Mat4::from_translation(Vec3::new(1e-4, -1e-4, 2e-4));
            render(&mut offscreen, &camera);
            assert_eq!(taken(&offscreen), RecordedShadows::default());
        }
        // A long way: cascades only, and not the one that holds everything.
        camera.world_from_view *= Mat4::from_translation(Vec3::new(0.5, 0.0, -1.5));
        render(&mut offscreen, &camera);
        assert!(taken(&offscreen).tiles <= used, "{:?}", taken(&offscreen));
        render(&mut offscreen, &scene.cameras[0]);

        // A light that moves has its tiles drawn again, one that changes in strength has not.
        let index = |name: &str| scene.lights.iter().position(|l| l.name == name).unwrap();
        let mut bulb = scene.lights[index("bulb")].clone();
        bulb.color *= 0.5;
        offscreen.renderer_mut().set_light(index("bulb"), &bulb).unwrap();
        render(&mut offscreen, &scene.cameras[0]);
        assert_eq!(taken(&offscreen).tiles, 0);
        bulb.position_world.x += 0.1;
        offscreen.renderer_mut().set_light(index("bulb"), &bulb).unwrap();
        render(&mut offscreen, &scene.cameras[0]);
        assert_eq!(taken(&offscreen).tiles, 6);
        let spot = Light { direction_world: Vec3::NEG_Y, ..scene.lights[index("spot")].clone() };
        offscreen.renderer_mut().set_light(index("spot"), &spot).unwrap();
        render(&mut offscreen, &scene.cameras[0]);
        assert_eq!(taken(&offscreen).tiles, 1);
        // Without a shadow a light needs no map.
        let mut lit = spot.clone();
        lit.shadow = None;
        offscreen.renderer_mut().set_light(index("spot"), &lit).unwrap();
        render(&mut offscreen, &scene.cameras[0]);
        assert_eq!(taken(&offscreen).tiles, 0);
        // A cone too wide for its one view would need others.
        let kind = LightKind::Spot { intensity_cd: 30.0, inner_cone_rad: 0.1, outer_cone_rad: 1.5 };
        let error = offscreen.renderer_mut().set_light(index("spot"), &Light { kind, ..spot }).unwrap_err();
        assert!(error.to_string().contains("spot"), "{error}");
    });
}

#[test]
fn what_moved_casts_the_shadow_of_a_scene_made_so() {
    on_device(None, |gpu| {
        for fresh in one_light_each() {
            let mut moved = fresh.clone();
            let place =
                Mat4::from_translation(Vec3::new(0.4, 0.3, 0.5)) * fresh.instances[BALL].world_from_object;
            let mut there = offscreen(gpu, &moved, RendererConfig::default());
            let before = render(&mut there, &fresh.cameras[0]);
            there.renderer_mut().set_instance(BALL, &place).unwrap();
            let after = render(&mut there, &fresh.cameras[0]);
            assert!(taken(&there).tiles > 0);
            moved.instances[BALL].world_from_object = place;
            let expected = render(&mut offscreen(gpu, &moved, RendererConfig::default()), &moved.cameras[0]);
            assert!(difference(&before, &after).is_some(), "{}: the move is not seen", fresh.name);
            assert_eq!(difference(&expected, &after), None, "{}", fresh.name);
        }
    });
}

/// Tiles that are composed of what stands still and what moves are, bit for bit, those that are drawn whole.
#[test]
fn what_moves_is_drawn_over_what_stands_still() {
    on_device(None, |gpu| {
        for still in one_light_each() {
            let name = still.name.clone();
            let camera = &still.cameras[0];
            let mut moving = still.clone();
            moving.instances[BALL].dynamic = true;
            let [mut composed, mut whole] =
                [&moving, &still].map(|scene| offscreen(gpu, scene, RendererConfig::default()));
            let map = |offscreen: &Offscreen| offscreen.renderer().plan().shadow_map.clone().unwrap();
            assert_eq!(map(&composed).bytes(), 2 * map(&whole).bytes(), "{name}: one more map");
            let mut pictures = Vec::new();
            // Out of sight and back at last.
            for (step, x) in [0.0, 0.4, 0.45, -0.8, 30.0, 0.2].into_iter().enumerate() {
                let shift = Mat4::from_translation(Vec3::new(x, 0.3 * x.abs(), 0.5 * x));
                let place = shift * still.instances[BALL].world_from_object;
                let [a, b] = [&mut composed, &mut whole].map(|offscreen| {
                    offscreen.renderer_mut().set_instance(BALL, &place).unwrap();
                    render(offscreen, camera)
                });
                assert_eq!(difference(&a, &b), None, "{name}: step {step}");
                pictures.push(a);
                let [a, b] = [&composed, &whole].map(taken);
                println!("{name}, step {step}: {a:?}, whole {b:?}");
                assert_eq!((a.tiles, b.composed + b.static_tiles), (b.tiles, 0), "{name}: step {step}");
                match step {
                    // Nothing has stood still yet.
                    0 => assert_eq!(a, b, "{name}"),
                    // A cascade has to be deeper for what is far away.
                    4 if name == "sun" => assert_eq!(a.composed, 0),
                    4 | 5 => {}
                    _ => {
                        assert!(a.tiles > 0 && a.composed == a.tiles, "{name}: {a:?}");
                        assert_eq!(a.static_tiles > 0, step == 1, "{name}: {a:?}");
                    }
                }
                if (2..4).contains(&step) {
                    assert_eq!(a.casters + a.culled, a.tiles, "{name}: one ball each, at most");
                    // The ball's box is around the bulb, and so in every part of every face.
                    assert!(name == "bulb" || a.stored_bytes < b.stored_bytes / 2, "{name}: {a:?}, {b:?}");
                    assert!(
                        a.copied_bytes == a.stored_bytes && a.casters < b.casters,
                        "{name}: {a:?}, {b:?}"
                    );
                }
            }
            assert!(difference(&pictures[1], &pictures[3]).is_some(), "{name}: the move is not seen");
        }
    });
}

#[test]
fn tiles_wait_for_their_frame() {
    on_device(None, |gpu| {
        let scene = three_lights();
        let config = RendererConfig { shadow_tiles_per_frame: 2, ..RendererConfig::default() };
        let [mut slow, mut fast] = [config, RendererConfig::default()].map(|c| offscreen(gpu, &scene, c));
        // Nothing to show yet: the first frame is whole.
        let camera = &scene.cameras[0];
        assert_eq!(difference(&render(&mut slow, camera), &render(&mut fast, camera)), None);
        let place = Mat4::from_translation(Vec3::Y * 0.3) * scene.instances[BALL].world_from_object;
        for renderer in [&mut slow, &mut fast] {
            renderer.renderer_mut().set_instance(BALL, &place).unwrap();
        }
        let expected = render(&mut fast, camera);
        let all = taken(&fast).tiles;
        assert!(all > 4, "{all}");
        let mut drawn = 0;
        while drawn < all {
            let picture = render(&mut slow, camera);
            let RecordedShadows { tiles, waiting, .. } = taken(&slow);
            drawn += tiles;
            assert_eq!((tiles, waiting), (2.min(all + tiles - drawn), all - drawn));
            assert_eq!(difference(&expected, &picture).is_none(), waiting == 0, "{waiting} tiles wait");
        }
        render(&mut slow, camera);
        assert_eq!(taken(&slow), RecordedShadows::default());
    });
}

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
        // No light has larger tiles than a more important one of its shape.
        for (i, a) in map.lights.iter().enumerate() {
            for b in map.lights[i + 1..].iter().filter(|b| b.shape == a.shape) {
                assert!(a.size.texels >= b.size.texels, "{} {}", a.name, b.name);
            }
        }
        // Who lost something is told of; 50 lights ask for more than any of these maps has.
        let noted = |name: &str| plan.notes.iter().any(|n| n.contains(&format!("light '{name}'")));
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
    let bytes = |format| plan(&scenes[1], ShadowOptions { format, ..default() }).shadow_map.unwrap().bytes();
    assert_eq!([ShadowFormat::D32, ShadowFormat::D16].map(bytes), [4 << 20, 2 << 20]);
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

/// All filters and both formats under validation, with casters of all kinds; and half of them move.
#[test]
fn every_choice_is_valid() {
    on_device(None, |gpu| {
        let still = shadows();
        let mut moving = still.clone();
        moving.instances.iter_mut().step_by(2).for_each(|instance| instance.dynamic = true);
        for &filter in ShadowFilter::ALL {
            for &format in ShadowFormat::ALL {
                let shadows = ShadowOptions { filter, format, most_texels: 1024, ..ShadowOptions::default() };
                let options = Options { shadows, ..options(filter) };
                let [whole, composed] = [&still, &moving].map(|scene| {
                    let plan = gpu.plan(scene, options.clone());
                    let mut offscreen = gpu.offscreen(scene, plan, RendererConfig::default());
                    render(&mut offscreen, &scene.cameras[0]);
                    for (index, instance) in scene.instances.iter().enumerate().step_by(2) {
                        let place = Mat4::from_translation(Vec3::Y * 0.1) * instance.world_from_object;
                        offscreen.renderer_mut().set_instance(index, &place).unwrap();
                    }
                    (render(&mut offscreen, &scene.cameras[0]), taken(&offscreen).composed)
                });
                assert_eq!(difference(&whole.0, &composed.0), None, "{filter}, {format}");
                assert!(composed.1 > 0 && whole.1 == 0, "{filter}, {format}");
            }
        }
    });
}
