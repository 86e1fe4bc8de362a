//! A whole picture: visibility, surfaces, light and curve for every pixel.

use std::cell::Cell;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::around::Around;
use super::decals::Painter;
use super::edges::{SNAP_PX, is_creased, is_torn};
use super::fog::fogged;
use super::gbuffer::{Attributes, attributes, emitting};
use super::layers::{Blended, Layer, over};
use super::media::{Film, behind};
use super::particles::{Shine, Sparks};
use super::quantise::{Stored, blend_light, decode, quantise, store_light};
use super::refraction::Backdrop;
use super::settings::{Behind, Settings};
use super::shade::reflected_parts;
use super::shadow::Occlusion;
use super::through::Through;
use super::tonemap::tonemap;
use super::view::{Ray, View};
use super::visibility::{Hit, Visibility};
use crate::plan::{GBuffer, Layout};
use crate::scene::{Background, Camera, Scene};

/// One pixel of a [`Frame`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pixel {
    /// Whether the ray through the centre hits something.
    pub covered: bool,
    /// Whether a rasteriser may rightly see something else here, or near here: another instance, nothing, or
    /// another part of a surface that does not continue this one smoothly.
    pub edge: bool,
    /// Exposed scene light, linear Rec.709.
    pub linear: DVec3,
    /// `linear` after the curve: linear display light, not clamped.
    pub display: DVec3,
    /// What was shaded, after the layout's formats if there is one.
    pub attributes: Attributes,
    /// Bit i: the i-th of the first 64 lights would shine on this, but something stands in its way.
    pub shadowed: u64,
}

/// A picture, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// `size[0] * size[1]` pixels.
    pub pixels: Vec<Pixel>,
}

impl Frame {
    /// The pixel in column `x` of row `y`.
    pub fn pixel(&self, x: u32, y: u32) -> &Pixel {
        &self.pixels[(y * self.size[0] + x) as usize]
    }

    /// The display light as four floats a pixel, alpha 1: what an RGBA32F output image holds.
    pub fn to_rgba32f(&self) -> Vec<f32> {
        self.pixels.iter().flat_map(|p| p.display.as_vec3().extend(1.0).to_array()).collect()
    }

    /// The display light clamped to \[0, 1\] as four bytes a pixel, sRGB-encoded, alpha 255.
    pub fn to_rgba8_srgb(&self) -> Vec<u8> {
        let code = |x: f64| (super::texture::srgb_from_linear(x.clamp(0.0, 1.0)) * 255.0).round() as u8;
        self.pixels
            .iter()
            .flat_map(|p| [code(p.display.x), code(p.display.y), code(p.display.z), u8::MAX])
            .collect()
    }
}

/// Renders the scene as the settings say. The same input gives the same frame, whatever the number of threads.
///
/// # Panics
/// If an index within the scene is out of range.
pub fn render(scene: &Scene, camera: &Camera, settings: &Settings) -> Frame {
    Tracer::new(scene, settings).render(camera, settings)
}

/// A scene made ready for rays, to render several pictures of it.
pub struct Tracer<'a> {
    scene: &'a Scene,
    visibility: Visibility<'a>,
    blended: Option<Blended<'a>>,
    around: Around<'a>,
    decals: Painter<'a>,
    particles: Sparks<'a>,
}

impl<'a> Tracer<'a> {
    /// Of the settings, those about light from all around, about the lightmap and about reflection of such light count here, and no more in
    /// [`Self::render`].
    ///
    /// # Panics
    /// If an index within the scene is out of range.
    pub fn new(scene: &'a Scene, settings: &Settings) -> Self {
        let around = Around::new(scene, settings.around).with_lightmap(scene, settings.lightmap);
        let around = around.with_brdf(settings.brdf);
        Self {
            scene,
            visibility: Visibility::new(scene),
            blended: Blended::new(scene),
            around,
            decals: Painter::new(scene),
            particles: Sparks::new(scene),
        }
    }

    /// As [`render`].
    ///
    /// # Panics
    /// If an index within the scene is out of range.
    pub fn render(&self, camera: &Camera, settings: &Settings) -> Frame {
        let refracts = settings.behind == Behind::Picture && self.blended.is_some();
        let backdrop = refracts.then(|| Backdrop::new(self.draw(camera, settings, None, false)));
        self.draw(camera, settings, backdrop.as_ref(), true)
    }

    /// `over`: with what lies over what is opaque.
    fn draw(&self, camera: &Camera, settings: &Settings, backdrop: Option<&Backdrop>, over: bool) -> Frame {
        let view = settings.view(camera);
        let Tracer { scene, visibility, blended, around, decals, particles } = self;
        let occlusion = Occlusion::new(scene, visibility);
        let occlusion = settings.shadows.then_some(&occlusion);
        let [width, height] = settings.size;

        let centers = Lattice::trace(visibility, &view, [width, height], 0.5);
        let corners = Lattice::trace(visibility, &view, [width + 1, height + 1], 0.0);
        let blended = blended.as_ref().filter(|_| over).map(|blended| {
            let trace = |size, start_px| blended.trace(visibility, &view, size, start_px);
            (blended, trace([width, height], 0.5), trace([width + 1, height + 1], 0.0))
        });
        let pixels = (0..width * height).into_par_iter().map(|index| {
            let (x, y) = (index % width, index / width);
            let mut edge = is_edge(visibility, &view, &centers, &corners, x, y);
            let ray = view.ray_through_pixel([x, y]);
            let opaque_m = centers.at(x, y).map_or(f64::INFINITY, |hit| hit.distance);
            let (mut films, mut layers) = (Vec::new(), Vec::new());
            if let Some((blended, centers, corners)) = &blended {
                edge = edge || blended.is_edge(visibility, &view, [centers, corners], [x, y]);
                for hit in centers.at(x, y) {
                    let position_world = ray.at(hit.distance);
                    let exact = attributes(blended.visibility(), around, &view, position_world, hit);
                    let own = Settings { gbuffer: None, ..settings.clone() };
                    let none = Over::default();
                    let light = finish(
                        scene,
                        (&view, [x, y]),
                        &own,
                        occlusion,
                        exact,
                        [exact.prelit, DVec3::ZERO],
                        none,
                    )
                    .linear;
                    let alpha = blended.alpha(hit);
                    let shown = (exact.normal_world, alpha, light);
                    let (of, exposure) = (blended.visibility(), settings.exposure());
                    let film = match backdrop {
                        Some(b) => b.film(of, (&view, [x, y]), exposure, (&ray, hit), shown),
                        None if settings.behind == Behind::Rays => {
                            let (opaque, view) = (visibility, &view);
                            let through = Through { opaque, blended: of, around, occlusion, view, settings };
                            through.film((&ray, hit), shown).map(|film| (film, false))
                        }
                        None => {
                            Film::new(of, &view, exposure, (&ray, hit, opaque_m), shown).map(|f| (f, false))
                        }
                    };
                    match film {
                        Some((film, torn)) => {
                            films.push(film);
                            edge = edge || torn;
                        }
                        None => layers.push(Layer { light, alpha }),
                    }
                }
            }
            let shine = if over { particles.shine(&view, &ray, opaque_m) } else { Shine::default() };
            edge = edge || shine.edge;
            let over = Over { films: &films, layers: &layers, added_nt: shine.light_nt };
            let Some(hit) = centers.at(x, y) else {
                let none = Attributes::default();
                let sky = match scene.background {
                    Background::Environment => {
                        around.sky(view.ray_through_pixel([x, y]).direction.normalize())
                    }
                    Background::Black | Background::Color(_) => DVec3::ZERO,
                };
                return Pixel {
                    edge,
                    ..finish(scene, (&view, [x, y]), settings, None, none, [sky, DVec3::ZERO], over)
                };
            };
            let position_world = view.ray_through_pixel([x, y]).at(hit.distance);
            let (exact, arrives) = match decals.changes_light() {
                true => emitting(visibility, &view, position_world, hit),
                false => (attributes(visibility, around, &view, position_world, hit), 1.0),
            };
            let light_factor = settings.exposure() * settings.light_scale;
            let stored = |surface: &Attributes| match &settings.gbuffer {
                Some(gbuffer) => quantise(gbuffer, surface, &view, [x, y], light_factor),
                None => *surface,
            };
            let surface = decals.paint(stored(&exact), stored);
            let edge = edge || decals.is_at_edge(position_world);
            let prelit = if settings.stores_prelit() { surface.prelit } else { exact.prelit };
            let surface = Attributes { prelit, ..surface };
            let is_rounded = settings.gbuffer.as_ref().is_some_and(|gbuffer| gbuffer.layout != Layout::Exact);
            let arrives = if is_rounded { (arrives * 255.0).round() / 255.0 } else { arrives };
            let late = || around.reflected(&surface, view.to_viewer(position_world), arrives);
            let light = [prelit, if decals.changes_light() && surface.lit { late() } else { DVec3::ZERO }];
            Pixel { edge, ..finish(scene, (&view, [x, y]), settings, occlusion, surface, light, over) }
        });
        Frame { size: settings.size, pixels: pixels.collect() }
    }
}

/// Shades a G-buffer that a renderer wrote, rows from the top: what its lighting and tonemap should have made of
/// it, whatever its rasteriser and its texture filter did. `settings.gbuffer` says what it is (`None`
/// counts as `exact`); what is blended over it is left out; [`Stored::light`] counts only with a light target, and is
/// what geometry wrote, before any light was added. [`Pixel::edge`] is always false.
///
/// # Panics
/// If `gbuffer` does not hold one element a pixel.
pub fn shade_gbuffer(scene: &Scene, camera: &Camera, settings: &Settings, gbuffer: &[Stored]) -> Frame {
    let view = settings.view(camera);
    let [width, height] = settings.size;
    assert_eq!(gbuffer.len(), (width * height) as usize, "one element a pixel");
    let exact = GBuffer::exact();
    let layout = settings.gbuffer.as_ref().unwrap_or(&exact);
    let cast = settings.shadows && scene.lights.iter().any(|light| light.shadow.is_some());
    let visibility = cast.then(|| Visibility::new(scene));
    let occlusion = visibility.as_ref().map(|visibility| Occlusion::new(scene, visibility));
    let light_factor = settings.exposure() * settings.light_scale;
    let pixels = gbuffer.par_iter().enumerate().map(|(index, stored)| {
        let pixel = [index as u32 % width, index as u32 / width];
        let light = if settings.light_target { stored.light } else { DVec3::ZERO };
        let surface = decode(layout, &Stored { light, ..*stored }, &view, pixel, light_factor);
        let prelit = surface.prelit;
        finish(
            scene,
            (&view, pixel),
            settings,
            occlusion.as_ref(),
            surface,
            [prelit, DVec3::ZERO],
            Over::default(),
        )
    });
    Frame { size: settings.size, pixels: pixels.collect() }
}

/// What lies over a surface.
#[derive(Clone, Copy, Default)]
struct Over<'a> {
    /// What light goes through, from near to far.
    films: &'a [Film],
    /// What is blended over that, likewise.
    layers: &'a [Layer],
    /// What particles add as it arrives at the viewer, cd/m².
    added_nt: DVec3,
}

/// Adds the lights' reflection, and light that is `late`, to `prelit`, then fog, then what lies over it, and applies the curve. The viewer is where the pixel's ray comes from, also
/// where a stored position is beside it.
fn finish(
    scene: &Scene,
    (view, pixel): (&View, [u32; 2]),
    settings: &Settings,
    occlusion: Option<&Occlusion>,
    attributes: Attributes,
    [prelit, late]: [DVec3; 2],
    Over { films, layers, added_nt }: Over,
) -> Pixel {
    let shadowed = Cell::new(0_u64);
    let hidden = |light: usize, to_light| {
        let hides = occlusion.is_some_and(|o| {
            o.hides(&scene.lights[light], attributes.position_world, attributes.normal_world, to_light)
        });
        shadowed.update(|bits| bits | u64::from(hides).unbounded_shl(light as u32));
        hides
    };
    let to_viewer = -view.ray_through_pixel(pixel).direction.normalize();
    let [diffuse, specular] = reflected_parts(settings.brdf, &attributes, to_viewer, scene, hidden);
    // Complete, as specular light is.
    let specular = specular + late;
    let factor = settings.exposure() * settings.light_scale;
    let linear = match settings.added_light() {
        Some((format, true)) => {
            let diffuse = blend_light(format, DVec3::ZERO, diffuse * factor) * attributes.diffuse();
            let other = store_light(format, prelit * factor);
            (diffuse + blend_light(format, other, specular * factor)) / settings.light_scale
        }
        Some((format, false)) => {
            let reflected = diffuse * attributes.diffuse() + specular;
            blend_light(format, store_light(format, prelit * factor), reflected * factor)
                / settings.light_scale
        }
        None => (prelit + diffuse * attributes.diffuse() + specular) * settings.exposure(),
    };
    let covered = attributes.depth > 0.0;
    let linear = match &scene.fog {
        Some(fog) if covered => {
            let at = attributes.position_world;
            fogged(fog, linear, settings.exposure(), view.ray_start(at), at)
        }
        _ => linear,
    };
    let (linear, under) = behind(linear, films);
    let (linear, over_it) = over(linear, layers);
    let over_it = 1.0 - (1.0 - under) * (1.0 - over_it);
    let linear = linear + added_nt * settings.exposure();
    let display = match scene.background {
        // A colour of the display: what is blended lies over it as a picture on a page.
        Background::Color(color) if !covered => {
            tonemap(settings.tonemap, linear) + color.as_dvec3() * (1.0 - over_it)
        }
        _ => tonemap(settings.tonemap, linear),
    };
    Pixel {
        covered: covered || over_it > 0.0 || added_nt != DVec3::ZERO,
        linear,
        display,
        attributes,
        shadowed: shadowed.get(),
        ..Pixel::default()
    }
}

/// Hits on a regular grid, one pixel apart.
struct Lattice {
    width: u32,
    height: u32,
    /// Where the first ray goes, in pixels from the image's corner, along both axes.
    start_px: f64,
    hits: Vec<Option<Hit>>,
}

impl Lattice {
    fn trace(visibility: &Visibility, view: &View, [width, height]: [u32; 2], start_px: f64) -> Self {
        let place = |i: u32| DVec2::new(f64::from(i % width), f64::from(i / width)) + start_px;
        let hits =
            (0..width * height).into_par_iter().map(|i| visibility.trace(&view.ray(place(i)))).collect();
        Self { width, height, start_px, hits }
    }

    fn at(&self, x: u32, y: u32) -> Option<&Hit> {
        self.hits[(y * self.width + x) as usize].as_ref()
    }

    /// The hits in columns `x` and rows `y` as far as the grid goes, with their rays.
    fn around(
        &self,
        view: &View,
        x: std::ops::RangeInclusive<u32>,
        y: std::ops::RangeInclusive<u32>,
    ) -> impl Iterator<Item = (Ray, Option<&Hit>)> {
        let (last_x, last_y) = ((*x.end()).min(self.width - 1), (*y.end()).min(self.height - 1));
        (*y.start()..=last_y).flat_map(move |row| (*x.start()..=last_x).map(move |column| (column, row))).map(
            move |(column, row)| {
                let place = DVec2::new(f64::from(column), f64::from(row)) + self.start_px;
                (view.ray(place), self.at(column, row))
            },
        )
    }
}

/// Whether anything in the 3x3 neighbourhood of centres and the pixel's corners differs in kind, or anything
/// within [`SNAP_PX`] differs measurably.
fn is_edge(
    visibility: &Visibility,
    view: &View,
    centers: &Lattice,
    corners: &Lattice,
    x: u32,
    y: u32,
) -> bool {
    let hit = centers.at(x, y);
    let ray = view.ray_through_pixel([x, y]);
    let torn = |(other_ray, other): (Ray, Option<&Hit>)| match (hit, other) {
        (None, None) => false,
        (Some(a), Some(b)) => is_torn(visibility, (&ray, a), (&other_ray, b)),
        _ => true,
    };
    let neighbours = centers.around(view, x.saturating_sub(1)..=x + 1, y.saturating_sub(1)..=y + 1);
    if neighbours.chain(corners.around(view, x..=x + 1, y..=y + 1)).any(torn) {
        return true;
    }
    let center_px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
    [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)].into_iter().any(|(dx, dy)| {
        let near_ray = view.ray(center_px + DVec2::new(dx, dy) * SNAP_PX);
        match (hit, visibility.trace(&near_ray)) {
            (None, None) => false,
            (Some(a), Some(b)) => is_creased(visibility, a, &near_ray, &b),
            _ => true,
        }
    })
}
