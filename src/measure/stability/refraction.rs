//! Media that bend light, where what is behind them is looked for in a picture or is not bent at all.

use glam::{DVec2, DVec3, Mat4, Vec3, Vec4};

use super::bench::{FLOOR, frame_behind, light_of, side_by_side};
use super::parts::{add, camera, floor, plain, square, sun};
use super::{Bound, Case, Figure, Findings, Lab, Sweep, difference, display_steps, exact};
use crate::Result;
use crate::measure::canvas::short;
use crate::measure::plot::{Axis, Plot};
use crate::plan::{Options, Refraction};
use crate::reference::{Behind, Frame, View, refract};
use crate::scene::{Camera, Material, Mesh, Projection, Scene, Transmission};

pub const REFRACTION: Sweep = Sweep {
    name: "refraction",
    title: "Water that bends light: deep, seen at a grazing angle, with steps below it, at the picture's edge, over other water",
    varies: "depth from 0.02 to 5 m, the view's elevation from 80 down to 3 degrees, the height of a step below the surface, the field of \
             view, the thickness from 1 mm to 100 m, and the gap between two surfaces",
    about: "What a bent ray meets is looked for in the picture of what is opaque, at a place that the depth straight ahead says: where the \
            bottom is not parallel to the surface, or not in the picture, something else is shown. Light that is not bent at all is \
            absorbed on the wrong way and shows the wrong place. Truth is a ray in f64 that is bent at each surface.",
    needs_device: true,
    find: refraction,
};

/// Smooth bands in both directions, so that a wrong place is a wrong colour, and no edge is.
fn bands() -> Mesh {
    const SIDE: u32 = 96;
    let mut mesh = Mesh::default();
    for i in 0..(SIDE + 1) * (SIDE + 1) {
        let [x, y] = [i % (SIDE + 1), i / (SIDE + 1)].map(|c| c as f32 / SIDE as f32 * 2.0 - 1.0);
        let band = |along: f32| 0.5 + 0.4 * (along * 20.0).sin();
        mesh.positions.push(Vec3::new(x, y, 0.0));
        mesh.colors.push(Vec4::new(band(x), band(y), 0.5, 1.0));
        let (column, row) = (i % (SIDE + 1), i / (SIDE + 1));
        if column < SIDE && row < SIDE {
            let above = i + SIDE + 1;
            mesh.indices.extend([i, i + 1, above, above, i + 1, above + 1]);
        }
    }
    mesh.normals = vec![Vec3::Z; mesh.positions.len()];
    mesh
}

/// From this elevation at the middle of the water.
fn from_above(elevation_deg: f32, yfov_rad: f32) -> Camera {
    let (sine, cosine) = elevation_deg.to_radians().sin_cos();
    let mut camera = camera(Vec3::new(0.0, sine, cosine) * 4.0, Vec3::ZERO);
    camera.projection = Projection::Perspective { yfov_rad, znear_m: 0.1, zfar_m: None };
    camera
}

/// Half the side of the water and its bottom.
const HALF_M: f32 = 12.0;
const ELEVATION_DEG: f32 = 40.0;
const YFOV_RAD: f32 = 0.4;
const WIDE_RAD: f32 = 1.0;

/// A bottom so far below the surface at height 0.
fn bottom(depth_m: f32, camera: Camera) -> Scene {
    let mut scene = Scene { lights: vec![sun(2.5, Vec3::new(0.2, -1.0, -0.3))], ..Scene::default() };
    scene.cameras.push(camera);
    let place = Mat4::from_translation(Vec3::NEG_Y * depth_m) * floor(HALF_M);
    add(&mut scene, bands(), plain(Vec3::ONE, 0.0, 1.0), place);
    scene
}

fn medium(ior: f32, thickness_m: f32, color: Vec3) -> Material {
    let transmission =
        Transmission { factor: 1.0, ior, thickness_m, attenuation_color: color, attenuation_distance_m: 1.0 };
    Material { transmission: Some(transmission), ..plain(Vec3::ONE, 0.0, 0.6) }
}

const SEA: Vec3 = Vec3::new(0.4, 0.7, 0.8);
const WATER: f32 = 1.333;

fn surface(scene: &mut Scene, height_m: f32, material: Material) {
    let place = Mat4::from_translation(Vec3::Y * height_m) * floor(HALF_M);
    // Drivers warn of tiny draws.
    add(scene, Mesh { colors: Vec::new(), ..bands() }, material, place);
}

fn pool(depth_m: f32, thickness_m: f32, camera: Camera) -> Scene {
    let mut scene = bottom(depth_m, camera);
    surface(&mut scene, 0.0, medium(WATER, thickness_m, SEA));
    scene
}

/// A quantity, its values with the scene of each, and what the ways may be off by.
struct Series {
    name: &'static str,
    axis: Axis,
    scenes: Vec<(f64, Scene)>,
    /// How deep a bottom is that is parallel to the surface, by the value; only rays that end in the picture count then.
    flat_m: Option<fn(f64) -> f64>,
    /// Of what is looked for in the picture.
    pass: (f64, &'static str),
}

fn series(all: bool) -> Vec<Series> {
    let made = |few: &[f32], more: &[f32], scene: &dyn Fn(f32) -> Scene| {
        let mut values: Vec<_> = few.iter().chain(more.iter().filter(|_| all)).copied().collect();
        values.sort_by(f32::total_cmp);
        values.into_iter().map(|value| (f64::from(value), scene(value))).collect()
    };
    let usual = || from_above(ELEVATION_DEG, YFOV_RAD);
    let deep = |depth_m| pool(depth_m, 20.0, from_above(ELEVATION_DEG, WIDE_RAD));
    let grazing = |elevation_deg| pool(0.5, 20.0, from_above(elevation_deg, WIDE_RAD));
    let step = |height_m: f32| {
        let mut scene = pool(1.0, 10.0, usual());
        let place = Mat4::from_translation(Vec3::new(0.0, -1.0 + height_m, -0.6)) * floor(0.5);
        let front = Mat4::from_translation(Vec3::new(0.0, -1.0 + 0.5 * height_m, -0.1))
            * Mat4::from_scale(Vec3::new(0.5, 0.5 * height_m, 1.0));
        for place in [place, front] {
            add(&mut scene, square(), plain(Vec3::new(0.8, 0.2, 0.1), 0.0, 1.0), place);
        }
        scene
    };
    let narrow = |yfov_rad| pool(1.0, 10.0, from_above(ELEVATION_DEG, yfov_rad));
    let thick = |thickness_m| pool(0.5, thickness_m, usual());
    let over = |gap_m: f32| {
        // Which bends nothing, so that nothing but the ways through both is measured.
        let mut scene = bottom(0.8, usual());
        surface(&mut scene, -gap_m, medium(1.0, 10.0, SEA));
        surface(&mut scene, 0.0, medium(1.0, 10.0, Vec3::new(0.9, 0.6, 0.4)));
        scene
    };
    let flat = "the bottom is parallel to the surface: what is shown is where the ray ends, between pixels";
    vec![
        Series {
            name: "metres of water",
            axis: Axis::Logarithmic,
            scenes: made(&[0.02, 0.5, 3.0], &[0.1, 0.25, 1.0, 2.0], &deep),
            flat_m: Some(|depth_m| depth_m),
            pass: (4.0, flat),
        },
        Series {
            name: "degrees above the surface",
            axis: Axis::Linear,
            scenes: made(&[80.0, 30.0, 6.0], &[60.0, 45.0, 20.0, 10.0], &grazing),
            flat_m: Some(|_| 0.5),
            pass: (4.0, flat),
        },
        Series {
            name: "metres of a step, in 1 m of water",
            axis: Axis::Linear,
            scenes: made(&[0.1, 0.9], &[0.3, 0.5, 0.7], &step),
            flat_m: None,
            pass: (
                12.0,
                "how deep the ray goes is what the depth straight ahead says, which jumps at a step: there it is seen \
                          twice or not at all",
            ),
        },
        Series {
            name: "radians of the field of view",
            axis: Axis::Logarithmic,
            scenes: made(&[0.4, 0.05], &[1.2, 0.8, 0.2, 0.1], &narrow),
            flat_m: None,
            pass: (
                15.0,
                "rays that leave the picture show its edge: of a narrow field of view they are many",
            ),
        },
        Series {
            name: "metres of thickness, over 0.5 m of water",
            axis: Axis::Logarithmic,
            scenes: made(&[1e-3, 0.5, 100.0], &[0.01, 0.1, 0.3, 0.7, 1.0], &thick),
            flat_m: None,
            pass: (
                25.0,
                "a ray ends where the medium does, as the material says, though what is opaque is farther: that is shown as if \
                          it were no farther",
            ),
        },
        Series {
            name: OVER,
            axis: Axis::Logarithmic,
            scenes: made(&[0.01, 0.7], &[0.05, 0.2, 0.4], &over),
            flat_m: None,
            pass: (75.0, TWICE),
        },
    ]
}

const OVER: &str = "metres between two surfaces, in 0.8 m";
const TWICE: &str =
    "each surface takes its whole way to what is opaque, so that the way below both counts twice";

/// The mean of each pixel's worst channel, over those that count.
fn mean_error(truth: &Frame, found: &[DVec3], counts: impl Fn([u32; 2]) -> bool) -> f64 {
    let place = |i: usize| [i as u32 % truth.size[0], i as u32 / truth.size[0]];
    let counted: Vec<_> = (0..found.len()).filter(|&i| counts(place(i))).collect();
    let off = |&i: &usize| {
        let expected = truth.pixels[i].display;
        (0..3).map(|c| display_steps(found[i][c], expected[c])).fold(0.0, f64::max)
    };
    counted.iter().map(off).sum::<f64>() / counted.len().max(1) as f64
}

/// Whether a pixel's ray, bent at height 0, meets a bottom so far below that in a place that the picture shows too, and straight
/// ahead is the same bottom.
fn ends_in_picture(view: &View, pixel: [u32; 2], depth_m: f64) -> bool {
    let ray = view.ray_through_pixel(pixel);
    let direction = ray.direction.normalize();
    if direction.y >= 0.0 {
        return false;
    }
    let surface = ray.origin - direction * (ray.origin.y / direction.y);
    let bent = refract(direction, DVec3::Y, 1.0 / f64::from(WATER));
    let end = surface - bent * (depth_m / bent.y);
    let ahead = surface - direction * (depth_m / direction.y);
    let there = |place: DVec3| place.x.abs().max(place.z.abs()) < f64::from(HALF_M);
    let inside = |place: DVec2| (0..2).all(|c| (0.5..=f64::from(view.size[c]) - 0.5).contains(&place[c]));
    there(ahead) && there(end) && view.place(end).is_some_and(inside)
}

fn refraction(lab: &Lab<'_>) -> Result<Findings> {
    let bench = lab.bench()?;
    let size = lab.pick([64, 36], [192, 108]);
    let mut findings = Findings::default();
    for Series { name, axis, scenes, flat_m, pass } in series(lab.pick(false, true)) {
        let truths: Vec<_> =
            scenes.iter().map(|(_, scene)| frame_behind(scene, &exact(size), Behind::Rays)).collect();
        let mut curves = Vec::new();
        for &refraction in Refraction::ALL {
            let options = Options { refraction, ..exact(size) };
            let (mut worst, mut model) = ((0.0, String::new()), (0.0, String::new()));
            let mut curve = Vec::new();
            for ((value, scene), truth) in scenes.iter().zip(&truths) {
                let picture = bench.picture(scene, options.clone(), 0.0)?;
                let view = View::new(&scene.cameras[0], size);
                let counts = |pixel| flat_m.is_none_or(|depth| ends_in_picture(&view, pixel, depth(*value)));
                let error = mean_error(truth, &light_of(&picture)?, counts);
                curve.push([*value, error.max(1e-3)]);
                let of_model = difference(&bench.truth(scene, &options, 0.0), &picture, FLOOR)?;
                if of_model.worst >= model.0 {
                    model = (of_model.worst, format!("{}, {}", short(*value), of_model.place()));
                }
                if error >= worst.0 {
                    worst = (error, short(*value));
                    let file = format!("{refraction}-{}", slug(name));
                    let caption = format!(
                        "{name} ({}), `--refraction {refraction}`: drawn, true, and the difference ({} steps on average)",
                        short(*value),
                        short(error)
                    );
                    findings.figures.retain(|figure| figure.name != file);
                    findings.figures.push(Figure::picture(
                        file,
                        caption,
                        side_by_side(truth, &picture, FLOOR, 1.0)?,
                    ));
                }
            }
            let (most, reason) = match refraction {
                Refraction::Pass => pass,
                Refraction::None if name == OVER => (75.0, TWICE),
                Refraction::None => {
                    (100.0, "nothing is bent: bottoms are seen straight ahead, and absorbed on the way there")
                }
            };
            let remedy = match refraction {
                _ if name == OVER => "one surface, whose colour is that of both",
                Refraction::Pass => {
                    "water that is as thick as deep, and a picture larger than what is shown of it"
                }
                Refraction::None => "--refraction pass",
            };
            findings.cases.push(Case {
                method: format!("{refraction}, {name}"),
                worst: worst.0,
                at: worst.1,
                bound: Bound {
                    name: "WHERE_RAYS_END",
                    unit: "steps of 8-bit sRGB on average",
                    good: 1.0,
                    most,
                    reason,
                },
                answer: None,
                remedy: remedy.into(),
            });
            findings.cases.push(Case {
                method: format!("{refraction}, {name}, by its own model"),
                worst: model.0,
                at: model.1,
                bound: Bound {
                    name: "LIKE_THE_MODEL",
                    unit: "of the light",
                    good: 2e-3,
                    most: 0.02,
                    reason: "places in f32, from depths in f32: between pixels they are off by some thousandths of one",
                },
                answer: None,
                remedy: "report it: nothing but rounding is allowed here".into(),
            });
            curves.push((refraction.to_string(), curve));
        }
        let plot = Plot {
            title: "Against rays that are bent".into(),
            x_label: name.into(),
            y_label: "steps of 8-bit sRGB on average".into(),
            axes: [axis, Axis::Logarithmic],
            curves,
            levels: vec![("seen".into(), 1.0)],
        };
        findings.figures.push(Figure::plot(slug(name), format!("The mean error by {name}."), plot));
    }
    Ok(findings)
}

fn slug(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' }).collect()
}
