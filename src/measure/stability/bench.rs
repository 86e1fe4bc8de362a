//! Pictures of a device, next to the reference's.

use std::cell::RefCell;
use std::collections::BTreeSet;

use glam::{DVec2, DVec3, Vec3};

use crate::gpu::{
    Device, Headless, HeadlessOptions, Offscreen, PipelineCache, RendererConfig, View, expected_advice,
};
use crate::measure::magma;
use crate::picture::{Picture, Pixels};
use crate::plan::{Layout, Needs, Options, OutputFormat, Plan, Tonemap};
use crate::reference::around::Method;
use crate::reference::{self, Behind, Frame, Settings, Tracer};
use crate::scene::{Projection, Scene};
use crate::{Error, Result};

/// A device that draws for sweeps.
pub struct Bench {
    host: Headless,
    cache: PipelineCache,
    /// What the validation layer may say of the plans so far.
    excused: RefCell<BTreeSet<&'static str>>,
}

impl std::fmt::Debug for Bench {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Bench({})", self.device().caps().name)
    }
}

impl Bench {
    /// Opens a device.
    ///
    /// # Errors
    /// As [`Headless::new`].
    pub fn open(options: &HeadlessOptions) -> Result<Self> {
        let host = Headless::new(options)?;
        let cache = PipelineCache::new(host.device(), &[])?;
        Ok(Self { host, cache, excused: RefCell::default() })
    }

    /// The device.
    pub fn device(&self) -> &Device {
        self.host.device()
    }

    /// Closes the device and returns what the validation layer said, but for what the plans give reason to.
    pub fn finish(self) -> Vec<String> {
        let Self { host, cache, excused } = self;
        drop(cache);
        let mut messages = host.finish();
        let excused = excused.into_inner();
        messages.retain(|message| !excused.iter().any(|excuse| message.contains(excuse)));
        messages
    }

    /// A scene's renderer with an image of its own.
    pub(super) fn offscreen(&self, scene: &Scene, options: Options) -> Result<Offscreen> {
        self.offscreen_with(scene, options, RendererConfig::default())
    }

    pub(super) fn offscreen_with(
        &self,
        scene: &Scene,
        options: Options,
        config: RendererConfig,
    ) -> Result<Offscreen> {
        let plan = Plan::new(Needs::of(scene), options, &self.device().limits())?;
        self.excused.borrow_mut().extend(expected_advice(&plan));
        Offscreen::new(self.device(), scene, plan, config, &self.cache)
    }

    /// One frame of the scene's first camera.
    pub(super) fn picture(&self, scene: &Scene, options: Options, exposure_ev: f32) -> Result<Picture> {
        let mut offscreen = self.offscreen(scene, options)?;
        offscreen.render(&View { camera: &scene.cameras[0], exposure_ev })?;
        Ok(offscreen.picture())
    }

    /// The true frame of the scene's first camera, and what this device's rasteriser may make of it.
    pub(super) fn truth(&self, scene: &Scene, options: &Options, exposure_ev: f32) -> Truth {
        let plan = Plan::new(Needs::of(scene), options.clone(), &self.device().limits());
        let behind = plan.map_or_else(|_| Behind::default(), |plan| Behind::of(&plan));
        let settings = Settings { behind, ..settings(options, exposure_ev) };
        let tracer = Tracer::new(scene, &settings);
        let frame = |shift_px| tracer.render(&scene.cameras[0], &Settings { shift_px, ..settings.clone() });
        let half_a_step_px = 0.5 * f64::from(self.device().caps().sub_pixel_precision_bits).exp2().recip()
            + transform_px(scene, options.size);
        let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
        Truth {
            frame: frame(DVec2::ZERO),
            moved: corners.map(|(x, y)| frame(DVec2::new(x, y) * half_a_step_px)),
        }
    }
}

/// How far f32 may move a vertex in the middle of the scene, pixels: clip space is a sum of four products, of which the largest is as the
/// camera's distance from the origin, and rounding does not get smaller with the field of view.
fn transform_px(scene: &Scene, [width, height]: [u32; 2]) -> f64 {
    let camera = &scene.cameras[0];
    let clip_from_view = camera.projection.clip_from_view(width as f32 / height as f32);
    let eye = camera.world_from_view.w_axis.truncate();
    let middle = scene.bounds_world().map_or(Vec3::ZERO, |b| (b.min + b.max) * 0.5);
    let w = match camera.projection {
        Projection::Perspective { znear_m, .. } => {
            (-camera.world_from_view.inverse().transform_point3(middle).z).max(znear_m)
        }
        Projection::Orthographic { .. } => 1.0,
    };
    let largest = f64::from(clip_from_view.y_axis.y.abs() * (eye.length() + middle.length()));
    3.0 * (-24.0_f64).exp2() * largest / f64::from(w) * f64::from(height) * 0.5
}

/// The true frame of the scene's first camera, with media that find what is behind them in this way.
pub(super) fn frame_behind(scene: &Scene, options: &Options, behind: Behind) -> Frame {
    reference::render(scene, &scene.cameras[0], &Settings { behind, ..settings(options, 0.0) })
}

/// A frame in f64, and what may be seen of it through a rasteriser that rounds vertices to a lattice of
/// `subPixelPrecisionBits` (Vulkan 1.3, 28.9 "Basic Polygon Rasterization"). A corner that is moved by so much moves what is
/// interpolated at a pixel by no more than moving the pixel does, to first order: barycentric coordinates are a convex
/// combination.
#[derive(Clone, Debug)]
pub struct Truth {
    /// At the pixels' centres.
    pub frame: Frame,
    /// As far to each side of them as lattice and f32 move vertices.
    moved: [Frame; 4],
}

impl Truth {
    /// How far a pixel's display light may be off by that.
    pub(super) fn slack(&self, pixel: usize) -> DVec3 {
        let here = self.frame.pixels[pixel].display;
        let off = |frame: &Frame| (frame.pixels[pixel].display - here).abs();
        self.moved.iter().map(off).fold(DVec3::ZERO, DVec3::max)
    }
}

/// Linear light in floats from floats: nothing but arithmetic between the scene and the picture.
pub(super) fn exact(size: [u32; 2]) -> Options {
    Options {
        size,
        layout: Layout::Exact,
        tonemap: Tonemap::Linear,
        output: OutputFormat::Rgba32Float,
        ..Options::default()
    }
}

/// The true frame of the scene's first camera: in f64, without a G-buffer.
pub(super) fn truth(scene: &Scene, options: &Options, exposure_ev: f32) -> Frame {
    reference::render(scene, &scene.cameras[0], &settings(options, exposure_ev))
}

fn settings(options: &Options, exposure_ev: f32) -> Settings {
    Settings {
        size: options.size,
        exposure_ev: exposure_ev.into(),
        tonemap: options.tonemap,
        around: Method::Prefiltered(options.environment_format),
        lightmap: Some(options.lightmap_format),
        ..Settings::default()
    }
}

/// The first step of an 8-bit sRGB display above black: darker light is not told from black.
pub(super) const FLOOR: f64 = 1.0 / (255.0 * 12.92);

/// The relative error that the renderer promises for 99.9 % of all pixels.
const PROMISED: f64 = 1e-3;

/// How far a picture is from the reference.
#[derive(Clone, Debug)]
pub struct Difference {
    /// The largest relative error of a channel, of the true value or the floor that was given, but for what the rasteriser explains
    /// beyond a thousandth; infinite where a pixel is not finite.
    pub worst: f64,
    /// The pixel where that is.
    pub at: [u32; 2],
    /// What should be there and what is.
    pub values: [DVec3; 2],
    /// Pixels that are not finite or negative.
    pub unsound: usize,
    /// Covered pixels that were compared.
    pub compared: usize,
}

impl Difference {
    pub(super) fn place(&self) -> String {
        format!("pixel ({}, {})", self.at[0], self.at[1])
    }
}

/// Compares a picture of floats with the truth, but for pixels at edges, where a rasteriser may rightly see something else.
/// Errors are relative to the channel's true value, or to `floor` where that is less. Of those above a thousandth what vertices on the
/// rasteriser's lattice explain is taken away, down to that.
///
/// # Errors
/// [`Error::Unsupported`] if the picture is none of floats, or of another size.
pub fn difference(truth: &Truth, picture: &Picture, floor: f64) -> Result<Difference> {
    let frame = &truth.frame;
    let found = light_of(picture)?;
    if [picture.width, picture.height] != frame.size {
        return Err(Error::unsupported("two pictures differ in size", "compare two of one size"));
    }
    let mut all = Difference { worst: 0.0, at: [0; 2], values: [DVec3::ZERO; 2], unsound: 0, compared: 0 };
    for (i, (pixel, found)) in frame.pixels.iter().zip(found).enumerate() {
        let sound = found.is_finite() && found.min_element() >= 0.0;
        all.unsound += usize::from(!sound);
        if pixel.edge && sound {
            continue;
        }
        all.compared += usize::from(pixel.covered);
        let unit = pixel.display.abs().max(DVec3::splat(floor));
        let error = (found - pixel.display).abs() / unit;
        let unexplained = (error - truth.slack(i) / unit).max(DVec3::splat(PROMISED));
        let error = error.min(unexplained).max_element();
        let error = if sound { error } else { f64::INFINITY };
        if error > all.worst {
            all.worst = error;
            all.at = [i as u32 % frame.size[0], i as u32 / frame.size[0]];
            all.values = [pixel.display, found];
        }
    }
    Ok(all)
}

/// Red, green and blue of a picture of floats.
pub(super) fn light_of(picture: &Picture) -> Result<Vec<DVec3>> {
    let Pixels::Rgba32F(values) = &picture.pixels else {
        return Err(Error::unsupported("the picture has 8 bits a channel", "render to floats"));
    };
    let pixel = |p: &[f32; 4]| DVec3::new(p[0].into(), p[1].into(), p[2].into());
    Ok(values.as_chunks::<4>().0.iter().map(pixel).collect())
}

/// What is drawn, what should be, and their relative difference up to `full` in false colours, side by side; small ones enlarged.
pub(super) fn side_by_side(frame: &Frame, picture: &Picture, floor: f64, full: f64) -> Result<Picture> {
    let [width, height] = frame.size.map(|side| side as usize);
    let found = light_of(picture)?;
    let times = (320 / width.max(height).max(1)).clamp(1, 16);
    let cut = |side: usize| side.min(640);
    let (shown_width, shown_height) = (cut(width) * times, cut(height) * times);
    let false_color = |i: usize| {
        let truth = frame.pixels[i].display;
        let error = ((found[i] - truth).abs() / truth.abs().max(DVec3::splat(floor))).max_element();
        let [r, g, b] = if found[i].is_finite() { magma((error / full).min(1.0)) } else { [0, 255, 255] };
        [r, g, b].map(|c| crate::picture::linear_from_srgb(f32::from(c) / 255.0))
    };
    let panels: [&dyn Fn(usize) -> [f32; 3]; 3] =
        [&|i| found[i].as_vec3().to_array(), &|i| frame.pixels[i].display.as_vec3().to_array(), &false_color];
    let mut pixels = Vec::with_capacity(3 * shown_width * shown_height * 4);
    for y in 0..shown_height {
        for panel in panels {
            for x in 0..shown_width {
                let [r, g, b] = panel(y / times * width + x / times);
                pixels.extend([r, g, b, 1.0]);
            }
        }
    }
    Ok(Picture {
        width: 3 * shown_width as u32,
        height: shown_height as u32,
        pixels: Pixels::Rgba32F(pixels),
    })
}
