//! Shadows fall where rays say, in every filter, format and path.

use crate::common::render::on_device;
use crate::common::scenes::shadow_scenes::one_light_each;
use crate::{BALL, SIZE, options};
use ontile::glam::{DVec3, Mat4, Vec3};
use ontile::picture::{Picture, Pixels};
use ontile::plan::{Options, Path, ShadowFilter, ShadowFormat, Tonemap};
use ontile::reference::{self, Frame, Settings};
use ontile::scene::{LightKind, Scene};

pub fn light_of(picture: &Picture) -> Vec<DVec3> {
    let Pixels::Rgba32F(values) = &picture.pixels else { panic!("a float picture was asked for") };
    let pixel = |p: &[f32]| DVec3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]));
    values.chunks_exact(4).map(pixel).collect()
}

/// How a picture differs from the reference.
#[derive(Debug)]
pub struct Disagreement {
    /// Pixels that are compared, as a share of all: those that are not at an edge of a surface or near one of a shadow.
    pub compared: f64,
    /// Of these, the share that is neither as light nor as dark as the reference.
    pub wrong: f64,
    /// The same of all pixels, with those that a filter makes soft.
    pub wrong_of_all: f64,
    /// Pixels in shadow by the reference, as a share of all.
    pub shadowed: f64,
}

impl Disagreement {
    /// A filter of this many pixels reaches over an edge; so does the lattice of texels.
    const REACH_PX: u32 = 4;
    /// Of the reference's light: shadow or not is a matter of all of it.
    const TOLERANCE: f64 = 0.02;

    pub fn new(frame: &Frame, actual: &[DVec3], dump: Option<&str>) -> Self {
        let [width, height] = frame.size;
        let near = |x: u32, y: u32| {
            let range =
                |n: u32, size: u32| n.saturating_sub(Self::REACH_PX)..(n + Self::REACH_PX + 1).min(size);
            range(y, height).flat_map(move |y| range(x, width).map(move |x| (x, y)))
        };
        let (mut compared, mut wrong, mut wrong_of_all, mut shadowed) = (0, 0, 0, 0);
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
                wrong_of_all += usize::from(differs);
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
            wrong_of_all: share(wrong_of_all, all),
            shadowed: share(shadowed, all),
        }
    }
}

pub fn expected(scene: &Scene) -> Frame {
    let settings = Settings { size: SIZE, tonemap: Tonemap::Linear, ..Settings::default() };
    reference::render(scene, &scene.cameras[0], &settings)
}

/// Away from edges a pixel is in shadow or not: exactly, without a filter. Filters reach over more than
/// [`Disagreement::REACH_PX`] pixels where light grazes a wall far away.
const WRONG_SHARE: f64 = 0.001;

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
                let most = if filter == ShadowFilter::Hardware { 0.0 } else { WRONG_SHARE };
                assert!(found.wrong <= most, "{}, {filter}: {found:?}", scene.name);
            }
            // However light reaches surfaces.
            let deferred = gpu.picture(&scene, gpu.plan(&scene, options(ShadowFilter::Hardware)), 0.0);
            for path in [Path::Forward, Path::ForwardMultipass] {
                let plan = gpu.plan(&scene, Options { path, ..options(ShadowFilter::Hardware) });
                let lit = light_of(&gpu.picture(&scene, plan, 0.0));
                let found = Disagreement::new(&frame, &lit, None);
                assert_eq!(found.wrong, 0.0, "{}, {path}: {found:?}", scene.name);
                let differs = |(a, b): &(DVec3, DVec3)| {
                    (*a - *b).abs().max_element() > Disagreement::TOLERANCE * b.max_element().max(0.05)
                };
                let far = light_of(&deferred).into_iter().zip(lit).filter(differs).count();
                assert_eq!(far, 0, "{}: pixels of {path} and deferred lighting", scene.name);
            }
            // Without shadows it is another picture, and this test sees that.
            let bare = scene.clone().without_shadows();
            let picture = gpu.picture(&bare, gpu.plan(&bare, options(ShadowFilter::Grid3)), 0.0);
            let found = Disagreement::new(&frame, &light_of(&picture), None);
            assert!(found.wrong > 5.0 * WRONG_SHARE, "{}: {found:?}", scene.name);
        }
    });
}

/// The scene so many times as large.
fn enlarged(scene: &Scene, factor: f32) -> Scene {
    let larger = |m: &mut Mat4| m.w_axis = (m.w_axis.truncate() * factor).extend(1.0);
    let mut scene = scene.clone();
    for instance in &mut scene.instances {
        instance.world_from_object = Mat4::from_scale(Vec3::splat(factor)) * instance.world_from_object;
    }
    scene.cameras.iter_mut().for_each(|camera| larger(&mut camera.world_from_view));
    for light in &mut scene.lights {
        light.position_world *= factor;
        light.range_m = light.range_m.map(|range| range * factor);
        match &mut light.kind {
            LightKind::Box { size_m, falloff_m, .. } => {
                (*size_m, *falloff_m) = (*size_m * factor, *falloff_m * factor)
            }
            LightKind::Point { intensity_cd } | LightKind::Spot { intensity_cd, .. } => {
                *intensity_cd *= factor * factor;
            }
            _ => {}
        }
    }
    scene
}

/// `cargo test --test shadows half_the -- --nocapture` prints what each format gets wrong.
#[test]
fn half_the_bytes_do_where_light_is_parallel() {
    on_device(None, |gpu| {
        println!("scene         format  wrong pixels  with soft edges      bytes");
        let measure = |scene: &Scene, name: String| {
            let frame = expected(scene);
            [ShadowFormat::D32, ShadowFormat::D16].map(|format| {
                let mut options = options(ShadowFilter::Grid3);
                options.shadows.format = format;
                let plan = gpu.plan(scene, options);
                let bytes = plan.shadow_map.as_ref().unwrap().bytes();
                let found = Disagreement::new(&frame, &light_of(&gpu.picture(scene, plan, 0.0)), None);
                let [wrong, soft] = [found.wrong, found.wrong_of_all].map(|share| 100.0 * share);
                println!("{name:<12}  {format:<6} {wrong:>11.4} % {soft:>14.3} % {bytes:>10}");
                found.wrong
            })
        };
        for (scene, factor) in one_light_each().iter().flat_map(|s| [1.0, 10.0, 100.0].map(|f| (s, f))) {
            let name = format!("{} {} m", scene.name, 4.0 * factor);
            let [d32, d16] = measure(&enlarged(scene, factor), name.clone());
            assert!(d32 <= WRONG_SHARE, "{name}: {d32}");
            // Its steps are 2.4 cm at 4 m from a lamp, and grow with the square of the distance.
            let is_parallel = ["sun", "slab"].contains(&scene.name.as_str());
            assert_eq!(d16 <= WRONG_SHARE, is_parallel || factor < 100.0, "{name}: {d16}");
        }
        // A room in a landscape: the sun's map is deep. Texels become large before steps of depth do.
        let room = one_light_each().remove(0);
        for m in [100.0, 1000.0] {
            let mut landscape = room.clone();
            let mut far = room.instances[BALL];
            far.world_from_object = Mat4::from_translation(Vec3::new(m, m, -m)) * far.world_from_object;
            landscape.instances.push(far);
            let [d32, d16] = measure(&landscape, format!("sun in {m} m"));
            assert!(d16 <= d32 + WRONG_SHARE, "{m} m: {d16}, {d32}");
        }
    });
}
