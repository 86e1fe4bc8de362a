//! Shadow maps: shadow where there is none, light where there is none, and edges that swim.

use std::f32::consts::FRAC_PI_2;

use glam::{DVec3, Mat4, Vec3};

use super::bench::{light_of, truth};
use super::parts::{add, camera, floor, plain, sphere, square, sun};
use super::{Answer, Bench, Bound, Case, Figure, Findings, Lab, Sweep, Worst, exact};
use crate::Result;
use crate::gpu::{Offscreen, RendererConfig, View};
use crate::measure::plot::{Axis, Plot};
use crate::picture::{Picture, Pixels};
use crate::plan::{Options, ShadowFilter, ShadowFormat, ShadowOptions, Tile};
use crate::reference::Frame;
use crate::scene::{Light, LightKind, Scene, Shadow};

pub const ACNE: Sweep = Sweep {
    name: "shadow-acne",
    title: "Shadow where there is none",
    varies: "the sun's height above a floor, 90 to 1 degree, with a ball on it",
    about: "A texel of the map holds one depth for a slanted piece of surface: half of it lies behind. The lower the light, the \
            longer the piece.",
    needs_device: true,
    find: acne,
};

pub const PANNING: Sweep = Sweep {
    name: "shadow-gap",
    title: "Shadows that do not touch what casts them",
    varies: "side of the light's part of the map, 128 to 1024 texels; a plate of 2 cm under a spot light",
    about: "What keeps acne away moves shadows away from their casters: Peter Pan's flies.",
    needs_device: true,
    find: panning,
};

pub const SHIMMER: Sweep = Sweep {
    name: "shadow-shimmer",
    title: "Shadows that swim while the camera moves",
    varies: "frames of a walk by 5 mm and 1 mrad each, less than a texel, all maps drawn anew in each",
    about: "Cascades follow the camera. Unless they do so by whole texels, every edge crawls.",
    needs_device: true,
    find: shimmer,
};

fn options(size: [u32; 2], filter: ShadowFilter, tile_texels: u32) -> Options {
    let shadows = ShadowOptions { filter, tile_texels: Some(tile_texels), ..ShadowOptions::default() };
    Options { shadows, ..exact(size) }
}

/// A floor with a ball on it.
fn floor_and_ball() -> Scene {
    let mut scene = Scene::default();
    scene.cameras.push(camera(Vec3::new(0.0, 3.0, 5.0), Vec3::ZERO));
    add(&mut scene, square(), plain(Vec3::splat(0.6), 0.0, 0.8), floor(5.0));
    let ball = Mat4::from_translation(Vec3::new(0.0, 0.5, 0.0)) * Mat4::from_scale(Vec3::splat(0.5));
    add(&mut scene, sphere(), plain(Vec3::new(0.7, 0.4, 0.3), 0.0, 0.8), ball);
    scene
}

/// Filters soften shadows over so many pixels at most: nearer to one, neither light nor shadow is wrong.
const REACH_PX: u32 = 6;
/// A filter's samples weigh a 25th at least, grid3's a 9th; what is darker by less is rounding.
const DARKER: f64 = 0.93;

/// Whether no pixel nearby is in shadow, or at the edge of a surface.
fn is_wholly_lit(frame: &Frame, x: u32, y: u32) -> bool {
    let [width, height] = frame.size;
    let range = |n: u32, size: u32| n.saturating_sub(REACH_PX)..(n + REACH_PX + 1).min(size);
    !frame.pixel(x, y).edge
        && range(y, height).all(|y| range(x, width).all(|x| frame.pixel(x, y).shadowed == 0))
}

fn acne(lab: &Lab<'_>) -> Result<Findings> {
    let bench = lab.bench()?;
    let all = [90.0, 75.0, 60.0, 45.0, 30.0, 20.0, 10.0, 5.0, 3.0, 2.0, 1.0];
    let few = [90.0, 30.0, 5.0, 1.0];
    let heights = lab.pick(&few[..], &all[..]);
    let size = lab.pick([120, 68], [320, 180]);
    let mut findings = Findings::default();
    let mut curves = Vec::new();
    let mut pictured = 0.0;
    let filters = ShadowFilter::ALL.iter().map(|filter| (filter.to_string(), *filter, Shadow::default()));
    let unmoved_bias = Shadow { bias_texels: 0.0, ..Shadow::default() };
    let unmoved = ("hardware, bias 0".to_owned(), ShadowFilter::Hardware, unmoved_bias);
    for (method, filter, shadow) in filters.chain([unmoved]) {
        let options = options(size, filter, lab.pick(256, 1024));
        let mut worst = Worst::new();
        let mut curve: Vec<[f64; 2]> = Vec::new();
        for &height in heights {
            let mut scene = floor_and_ball();
            let angle = f32::to_radians(height);
            let light = sun(2.0, Vec3::new(-angle.cos(), -angle.sin(), -0.2 * angle.cos()));
            scene.lights = vec![Light { shadow: Some(Shadow::default()), ..light }];
            let (picture, frame) =
                (bench.picture(&scene, options.clone(), 0.0)?, truth(&scene, &options, 0.0));
            let found = light_of(&picture)?;
            let (mut lit, mut wrong) = (0, vec![false; found.len()]);
            for (i, pixel) in frame.pixels.iter().enumerate() {
                let (x, y) = (i as u32 % size[0], i as u32 / size[0]);
                if pixel.display.y > 0.0 && is_wholly_lit(&frame, x, y) {
                    lit += 1;
                    wrong[i] = found[i].y < DARKER * pixel.display.y;
                }
            }
            let share = 100.0 * wrong.iter().filter(|w| **w).count() as f64 / f64::from(lit.max(1));
            // A sun that lights nothing shows nothing.
            let share = if lit == 0 { f64::NAN } else { share };
            curve.push([f64::from(height), share]);
            worst.add(share, || height);
            if share > pictured {
                pictured = share;
                let caption =
                    format!("{method}, the sun {height} degrees high; in red what should not be in shadow");
                findings.figures = vec![Figure::picture("worst", caption, marked(size, &found, &wrong))];
            }
        }
        curve.reverse();
        curves.push((method.clone(), curve));
        findings.cases.push(Case {
            method,
            worst: worst.error,
            at: format!("the sun {} degrees high", worst.at.unwrap_or_default()),
            bound: Bound {
                name: "SHADOWED",
                unit: "% of lit pixels",
                good: 0.0,
                most: 0.2,
                reason: "texels and filters move a shadow's edge, not the light far from it; a fifth of a percent is the foot of the ball, \
                         where the light grazes and the map has a texel or two",
            },
            answer: (shadow == unmoved_bias).then_some(Answer::Guarded),
            remedy: "more texels (--shadow-tile) or a larger bias of the light; the price is the gap of the next sweep".into(),
        });
    }
    findings.figures.push(Figure::plot(
        "share",
        "Pixels that are dark and should not be, away from true shadows.",
        Plot {
            title: "Acne by the height of the sun".into(),
            x_label: "degrees above the floor".into(),
            y_label: "% of lit pixels".into(),
            axes: [Axis::Logarithmic, Axis::Linear],
            curves,
            levels: Vec::new(),
        },
    ));
    Ok(findings)
}

/// A picture with some pixels in red.
pub(super) fn marked(size: [u32; 2], light: &[DVec3], marks: &[bool]) -> Picture {
    let times = (640 / size[0].max(1)).clamp(1, 8);
    let [width, height] = size.map(|side| side * times);
    let pixel = |i: u32| {
        let from = (i / width / times * size[0] + i % width / times) as usize;
        let [r, g, b] = if marks[from] { [1.0, 0.0, 0.0] } else { light[from].as_vec3().to_array() };
        [r, g, b, 1.0]
    };
    Picture { width, height, pixels: Pixels::Rgba32F((0..width * height).flat_map(pixel).collect()) }
}

/// Half of the plate's width and of its thickness.
const PLATE_HALF_M: [f32; 2] = [0.3, 0.01];

/// A thin plate that stands on a floor in the light of a spot, seen from the side of its shadow.
fn plate() -> (Scene, f32) {
    let mut scene = Scene::default();
    scene.cameras.push(camera(Vec3::new(0.0, 1.2, 1.6), Vec3::new(0.0, 0.0, 0.4)));
    add(&mut scene, square(), plain(Vec3::splat(0.6), 0.0, 0.8), floor(3.0));
    let [wide, thick] = PLATE_HALF_M;
    for (turn, half, away) in [(0.0, wide, thick), (1.0, thick, wide), (2.0, wide, thick), (3.0, thick, wide)]
    {
        let place =
            Mat4::from_translation(Vec3::new(0.0, 0.5, 0.0)) * Mat4::from_rotation_y(turn * FRAC_PI_2);
        let side = Mat4::from_translation(Vec3::Z * away) * Mat4::from_scale(Vec3::new(half, 0.5, 1.0));
        add(&mut scene, square(), plain(Vec3::splat(0.5), 0.0, 0.8), place * side);
    }
    let spot = LightKind::Spot { intensity_cd: 20.0, inner_cone_rad: 0.4, outer_cone_rad: 0.5 };
    let at = Vec3::new(0.0, 3.0, -2.0);
    let light =
        Light { position_world: at, shadow: Some(Shadow::default()), ..Light::new(spot) }.towards(-at);
    scene.lights = vec![light];
    // Across the cone at the plate's foot.
    (scene, 2.0 * at.length() * 0.5_f32.tan())
}

fn panning(lab: &Lab<'_>) -> Result<Findings> {
    let bench = lab.bench()?;
    let size = lab.pick([160, 120], [640, 480]);
    let sides = lab.pick(&[128, 512][..], &[128, 256, 512, 1024][..]);
    let (scene, span_m) = plate();
    let frame = truth(&scene, &exact(size), 0.0);
    let bare = truth(&scene.clone().without_shadows(), &exact(size), 0.0);
    let mut findings = Findings::default();
    let mut curves = Vec::new();
    for &filter in ShadowFilter::ALL {
        let mut worst = Worst::new();
        let mut curve = Vec::new();
        for &texels in sides {
            let found = light_of(&bench.picture(&scene, options(size, filter, texels), 0.0)?)?;
            // Along the middle of the shadow, from the plate's foot to half its length.
            let (mut gap, mut seen) = (0.0, 0);
            for ((pixel, bare), found) in frame.pixels.iter().zip(&bare.pixels).zip(&found) {
                let at = pixel.attributes.position_world;
                let away = at.z - f64::from(PLATE_HALF_M[1]);
                let is_shadow = pixel.covered && !pixel.edge && pixel.shadowed != 0 && at.y.abs() < 1e-6;
                if is_shadow && at.x.abs() < 0.03 && (0.0..0.3).contains(&away) {
                    seen += 1;
                    if found.y > 0.5 * bare.display.y {
                        gap = f64::max(gap, away);
                    }
                }
            }
            let texel_m = f64::from(span_m) / f64::from(texels);
            let in_texels = if seen > 0 { gap / texel_m } else { f64::NAN };
            curve.push([f64::from(texels), 100.0 * gap]);
            worst.add(in_texels, || texels);
        }
        curves.push((filter.to_string(), curve));
        findings.cases.push(Case {
            method: filter.to_string(),
            worst: worst.error,
            at: format!("{} texels across the cone", worst.at.unwrap_or_default()),
            bound: Bound {
                name: "MOVED",
                unit: "texels",
                good: 1.0,
                most: 4.0,
                reason: "casters are pushed away from the light by the filter's radius of 1.5 texels and one more, along the plate's slope \
                         to the light, tan 56 degrees = 1.5; receivers move along their normal, which here is up and opens no gap",
            },
            answer: None,
            remedy: "texels that are small: --shadow-tile, or --shadow-filter hardware, which moves least".into(),
        });
    }
    findings.figures.push(Figure::plot(
        "gap",
        "Light between a plate's foot and its shadow.",
        Plot {
            title: "The gap between a plate and its shadow".into(),
            x_label: "texels across 3.9 m".into(),
            y_label: "cm".into(),
            axes: [Axis::Logarithmic, Axis::Linear],
            curves,
            levels: Vec::new(),
        },
    ));
    Ok(findings)
}

/// A tile's texels.
struct Texels {
    side: usize,
    depths: Vec<f32>,
}

impl Texels {
    fn of(offscreen: &Offscreen, tile: &Tile, map_width: u32) -> Result<Self> {
        let map = offscreen.shadow_map()?;
        let [x, y, side] = [tile.x, tile.y, tile.texels].map(|n| n as usize);
        let depths = (y..y + side).flat_map(|y| map[y * map_width as usize + x..][..side].to_vec()).collect();
        Ok(Self { side, depths })
    }

    /// How many texels differ by more than this from those of `before`, which are this many texels further right and down.
    fn changed(&self, before: &Self, shift: [isize; 2], tolerance: f32) -> usize {
        let side = self.side as isize;
        let range = |shift: isize| 0.max(-shift)..side.min(side - shift);
        let at = |texels: &Self, x: isize, y: isize| texels.depths[(y * side + x) as usize];
        let differ = |a: f32, b: f32| a.to_bits() != b.to_bits() && (a - b).abs() > tolerance;
        let rows = range(shift[1]).map(|y| {
            range(shift[0])
                .filter(|x| differ(at(self, *x, y), at(before, x + shift[0], y + shift[1])))
                .count()
        });
        rows.sum()
    }
}

/// What became of the frames of a walk.
struct Walk {
    /// Cascades moved by whole texels.
    jumps: usize,
    /// The most texels that changed in a frame, if the map is moved by whole texels as well as can be.
    changed: usize,
}

/// Side of the tiles, and of the lattice on which cascades move.
const TILE: u32 = 256;
const LATTICE: isize = TILE as isize / 16;

fn walk(bench: &Bench, frames: usize, stable: bool, format: ShadowFormat, rounding: f32) -> Result<Walk> {
    let mut scene = floor_and_ball();
    let wall = Mat4::from_translation(Vec3::new(0.0, 2.0, -2.0)) * Mat4::from_scale(Vec3::splat(4.0));
    add(&mut scene, square(), plain(Vec3::splat(0.6), 0.0, 0.8), wall);
    scene.instances[0].world_from_object = floor(4.0);
    scene.cameras = vec![camera(Vec3::new(0.0, 1.6, 4.0), Vec3::new(0.0, 0.5, 0.0))];
    let light = sun(2.0, Vec3::new(-0.9, -1.0, -0.3));
    scene.lights = vec![Light { shadow: Some(Shadow::default()), ..light }];
    let mut options = options([160, 90], ShadowFilter::Grid3, TILE);
    (options.shadows.stable, options.shadows.format) = (stable, format);
    let config = RendererConfig { capture: true, ..RendererConfig::default() };
    let mut offscreen = bench.offscreen_with(&scene, options, config)?;
    let mut camera = scene.cameras[0].clone();
    let map = offscreen.renderer().plan().shadow_map.as_ref().map(|map| (map.tiles[0], map.size[0]));
    let (tile, map_width) =
        map.ok_or_else(|| crate::Error::unsupported("there is no shadow map", "report this as a bug"))?;
    let mut before: Option<Texels> = None;
    let mut walk = Walk { jumps: 0, changed: 0 };
    for _ in 0..frames {
        offscreen.render(&View { camera: &camera, exposure_ev: 0.0 })?;
        let texels = Texels::of(&offscreen, &tile, map_width)?;
        if let Some(before) = before.filter(|before| texels.changed(before, [0, 0], 0.0) > 0) {
            let steps = [0, LATTICE, -LATTICE];
            let shifts = steps.into_iter().flat_map(|x| steps.map(|y| [x, y]));
            let changed = shifts.map(|shift| (texels.changed(&before, shift, rounding), shift)).min();
            let (changed, shift) = changed.expect("there are shifts");
            walk.jumps += usize::from(shift != [0, 0]);
            walk.changed = walk.changed.max(changed);
        }
        before = Some(texels);
        // A texel is some 2 cm wide.
        let turn = Mat4::from_rotation_y(1e-3);
        camera.world_from_view *= Mat4::from_translation(Vec3::new(0.004, 0.002, -0.003)) * turn;
        offscreen.renderer_mut().redraw_shadows();
    }
    Ok(walk)
}

fn shimmer(lab: &Lab<'_>) -> Result<Findings> {
    let frames = lab.pick(80, 400);
    // After a jump the planes through triangles begin elsewhere in the tile. Of the map's depth, some 10 m, the rounding is 20
    // micrometres, a thousandth of a texel; in 16 bits it is a step either way.
    const ROUNDING: f32 = 2e-6;
    let d16 = 2.0 / 65535.0 + ROUNDING;
    let methods = [
        ("whole texels, d32", true, ShadowFormat::D32, ROUNDING),
        ("whole texels, d16", true, ShadowFormat::D16, d16),
        ("as the camera goes, d32", false, ShadowFormat::D32, ROUNDING),
    ];
    let mut findings = Findings::default();
    for (method, stable, format, rounding) in methods {
        let walk = walk(lab.bench()?, frames, stable, format, rounding)?;
        findings.cases.push(Case {
            method: method.into(),
            // Cascades that never moved have shown nothing.
            worst: if stable && walk.jumps == 0 {
                f64::NAN
            } else {
                100.0 * walk.changed as f64 / f64::from(TILE * TILE)
            },
            at: format!("{frames} frames, {} steps of whole texels", walk.jumps),
            bound: Bound {
                name: "NOT_A_TEXEL",
                unit: "% of texels",
                good: 0.0,
                most: 0.01,
                reason: "while a cascade stays, its depths are the same to the bit, and when it moves by whole texels they move along, but \
                         for a few at edges of triangles, whose planes and ties are computed from another corner of the tile",
            },
            answer: (!stable).then_some(Answer::Mended),
            remedy: if stable { String::new() } else { "cascades move by whole texels unless ShadowOptions::stable is off".into() },
        });
    }
    Ok(findings)
}
