//! A second rasteriser draws the scenes as lavapipe does: what a driver may choose is small, and nothing rests on one
//! driver's kindness.

mod common;

use common::render::{LAVAPIPE, on_device};
use common::{scenes, swiftshader::swiftshader_env};
use ontile::gpu::{RendererConfig, View};
use ontile::picture::{Picture, Pixels};
use ontile::plan::{
    BloomWay, DecalWay, Edges, Layout, LightWay, Needs, Options, Plan, Refraction, Show, Translucency,
};
use ontile::scene::Scene;
use std::path::{Path, PathBuf};
use std::process::Command;

const SIZE: [u32; 2] = [320, 180];

/// How far apart pixels may be that are no outliers, in 8-bit steps. A step of the light target, 2 / 1023, is 6.4 of
/// them in the dark (255 * 12.92 * 2 / 1023), and drivers may round to either neighbour; the output's own step comes on
/// top.
const MOST_STEPS: u8 = 8;

/// The share of pixels that may be further apart although no neighbour explains it: thin things that only one driver's
/// sample positions hit, highlights of a pixel, and changes of mip level, whose choice Vulkan leaves to the driver.
const UNEXPLAINED_SHARE: f64 = 0.003;

/// The share of pixels that may be further apart where a neighbour explains it: the pixel lies within what the other
/// driver drew around it, so an edge fell to the other side of a sample. Vulkan lets drivers choose sub-pixel precision
/// (subPixelPrecisionBits), and a horizon that passes through sample centres moves a whole row.
const EDGE_SHARE: f64 = 0.02;

/// Mean difference of red, green and blue, in 8-bit steps. Half a step of the light target, which lavapipe rounds down
/// and SwiftShader to nearest, is 3.2 in the dark and 0.3 at white.
const MOST_MEAN_STEPS: f64 = 2.0;

/// Tells the child process where to put its pictures, and by its device's name which driver it must find.
const FOLDER: &str = "ONTILE_TEST_FOLDER";
const DEVICE: &str = "ONTILE_TEST_DEVICE";

/// Without shadows: along their edges two drivers' maps differ by a texel, which no edge of a surface explains.
fn all_scenes() -> Vec<Case> {
    let plain = |scene: Scene| (scene.name.clone(), scene.without_shadows(), small());
    scenes::built().into_iter().chain(scenes::shipped()).map(plain).chain(options()).collect()
}

/// A name, and what is drawn under it.
type Case = (String, Scene, Options);

fn small() -> Options {
    Options { size: SIZE, ..Options::default() }
}

/// What the options bring.
fn options() -> Vec<Case> {
    let lights = scenes::lights_only;
    let shadowed = scenes::shadow_scenes::chosen;
    let glass = scenes::glass_scenes::glass_in_fog;
    let every = scenes::every_feature;
    let ways = [Edges::All, Edges::Compare, Edges::Coverage];
    let samples =
        ways.map(|edges| (format!("4 samples, {edges}"), every(), Options { samples: 4, edges, ..small() }));
    let translucency =
        [Translucency::Weighted, Translucency::Peeled, Translucency::Oit].map(|translucency| {
            let layout =
                if translucency == Translucency::Oit { Layout::Packed128 } else { Layout::Metallic128 };
            (format!("glass {translucency}"), glass(), Options { translucency, layout, ..small() })
        });
    let decals = scenes::decal_scenes::color_decals();
    let others = [
        // Its fence and hedge are edges all over where they are small.
        (
            "stop, 4 samples",
            scenes::tram_stop(),
            Options { samples: 4, size: SIZE.map(|n| 2 * n), ..small() },
        ),
        ("bloom", scenes::emissive(), Options { bloom: BloomWay::Previous, bloom_strength: 0.2, ..small() }),
        ("refraction", scenes::media_scenes::water(), Options { refraction: Refraction::Pass, ..small() }),
        ("edge filter", lights(), Options { edge_filter: true, ..small() }),
        ("shadow volumes", Scene { lights: shadowed().lights[..1].to_vec(), ..shadowed() }, small()),
        ("shown channels", every(), Options { show: Show::Channels, lights: LightWay::Clusters, ..small() }),
        (
            "shown normals of words",
            every(),
            Options { show: Show::Normal, layout: Layout::Packed128, ..small() },
        ),
        ("shown lights", lights(), Options { show: Show::Lights, lights: LightWay::Clusters, ..small() }),
        (
            "decals fixed",
            decals,
            Options { decals: DecalWay::Fixed, layout: Layout::Thibieroz128, ..small() },
        ),
    ];
    let others = others.map(|(name, scene, options)| (name.to_owned(), scene, options));
    let shadows = |(name, scene, options): Case| match name.as_str() {
        "shadow volumes" => (name, scene, options),
        _ => (name, scene.without_shadows(), options),
    };
    samples.into_iter().chain(translucency).chain(others).map(shadows).collect()
}

fn picture_of(name: &str, folder: &Path) -> PathBuf {
    folder.join(format!("{name}.png"))
}

#[test]
#[ignore = "the other test runs it, in a process of its own for each driver"]
fn draw_all_scenes() {
    let (Some(folder), Ok(device)) = (std::env::var_os(FOLDER), std::env::var(DEVICE)) else {
        panic!("{FOLDER} and {DEVICE} are not set");
    };
    on_device(Some(&device), |gpu| {
        for (name, scene, options) in all_scenes() {
            // What this driver has not is said by the plan.
            if let Err(refused) = Plan::new(Needs::of(&scene), options.clone(), &gpu.device().limits()) {
                println!("{name}: {refused}");
                continue;
            }
            let frames = if options.bloom == BloomWay::Off { 1 } else { 2 };
            let mut offscreen = gpu.offscreen(&scene, gpu.plan(&scene, options), RendererConfig::default());
            let view = View { camera: &scene.cameras[0], exposure_ev: 0.0 };
            // Bloom is of the frame before.
            (0..frames).for_each(|_| offscreen.render(&view).unwrap());
            offscreen.picture().write(&picture_of(&name, Path::new(&folder))).unwrap();
        }
    });
}

/// How two pictures differ.
struct Distance {
    unexplained: f64,
    edges: f64,
    mean_steps: f64,
}

impl Distance {
    fn between(a: &Picture, b: &Picture) -> Self {
        assert_eq!([a.width, a.height], [b.width, b.height]);
        let [Pixels::Rgba8(pa), Pixels::Rgba8(pb)] = [&a.pixels, &b.pixels] else {
            panic!("PNGs have 8 bits")
        };
        let (width, height) = (a.width as usize, a.height as usize);
        let (mut unexplained, mut edges, mut sum) = (0.0, 0.0, 0.0);
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let channel = |p: &[u8], x: usize, y: usize, c: usize| p[4 * (y * width + x) + c];
            let steps = [0, 1, 2].map(|c| channel(pa, x, y, c).abs_diff(channel(pb, x, y, c)));
            sum += steps.iter().map(|&s| f64::from(s)).sum::<f64>();
            if steps.iter().all(|&s| s <= MOST_STEPS) {
                continue;
            }
            let around = (y.saturating_sub(1)..=(y + 1).min(height - 1))
                .flat_map(|y| (x.saturating_sub(1)..=(x + 1).min(width - 1)).map(move |x| (x, y)));
            let within = |c: usize| {
                let values = around.clone().map(|(x, y)| channel(pb, x, y, c));
                let (least, most) = values.fold((u8::MAX, 0), |(l, m), v| (l.min(v), m.max(v)));
                let value = channel(pa, x, y, c);
                value >= least.saturating_sub(MOST_STEPS) && value <= most.saturating_add(MOST_STEPS)
            };
            if (0..3).all(within) { edges += 1.0 } else { unexplained += 1.0 }
        }
        let pixels = (width * height) as f64;
        Self { unexplained: unexplained / pixels, edges: edges / pixels, mean_steps: sum / (3.0 * pixels) }
    }

    fn is_small(&self) -> bool {
        self.unexplained <= UNEXPLAINED_SHARE
            && self.edges <= EDGE_SHARE
            && self.mean_steps <= MOST_MEAN_STEPS
    }
}

impl std::fmt::Display for Distance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [unexplained, edges] = [self.unexplained, self.edges].map(|share| 100.0 * share);
        write!(f, "{unexplained:.3} % unexplained, {edges:.3} % edges, mean {:.3} steps", self.mean_steps)
    }
}

fn aside(picture: &Picture) -> Picture {
    let Pixels::Rgba8(mut channels) = picture.pixels.clone() else { panic!("PNGs have 8 bits") };
    channels.rotate_right(8);
    Picture { pixels: Pixels::Rgba8(channels), ..*picture }
}

#[test]
fn swiftshader_draws_what_lavapipe_draws() {
    let Some(swiftshader) = swiftshader_env() else { return };
    let folders = [(); 2].map(|()| tempfile::tempdir().unwrap());
    let mut children = [LAVAPIPE, "SwiftShader"].map(|device| {
        let mut child = Command::new(std::env::current_exe().expect("this program's path"));
        child.args(["--exact", "draw_all_scenes", "--ignored", "--nocapture"]).env(DEVICE, device);
        child
    });
    children[1].envs(swiftshader);
    for (child, folder) in children.iter_mut().zip(&folders) {
        let output = child.env(FOLDER, folder.path()).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{child:?}:\n{said}");
        if said.contains("ignored: ") {
            common::ignored(&said);
            return;
        }
    }
    let (mut failures, mut telling, mut compared) = (Vec::new(), 0, 0);
    for (name, ..) in all_scenes() {
        let paths = folders.each_ref().map(|folder| picture_of(&name, folder.path()));
        if paths.iter().any(|path| !path.exists()) {
            println!("{name}: not on both");
            continue;
        }
        compared += 1;
        let [a, b] = paths.map(|path| Picture::read(&path).unwrap());
        let distance = Distance::between(&a, &b);
        println!("{name}: {distance}");
        if !distance.is_small() {
            failures.push(format!("{name}: {distance}"));
        }
        // Able to fail: SwiftShader's picture two pixels aside, where lavapipe's own would be seen aside.
        if !Distance::between(&a, &aside(&a)).is_small() {
            telling += 1;
            let seen = !Distance::between(&a, &aside(&b)).is_small();
            assert!(seen, "{name}: two pixels aside are not seen");
        }
    }
    assert!(compared + 3 >= all_scenes().len(), "only {compared} of {}", all_scenes().len());
    assert!(telling > 5, "only {telling} scenes have enough edges to tell");
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
