//! The pictures that every G-buffer's are compared with.

use glam::{DVec2, DVec3};

use super::data::{Errors, Truth};
use crate::gpu::{Device, Offscreen, PipelineCache, RendererConfig, View};
use crate::measure::{compare, stored};
use crate::picture::{Picture, Pixels};
use crate::plan::{Brdf, Choice, Layout, Needs, Options, OutputFormat, Plan, Tonemap};
use crate::reference::around::Method;
use crate::reference::{Behind, Frame, Settings, Stored, render, shade_gbuffer};
use crate::scene::{Camera, Scene};
use crate::{Error, Result};

/// What is drawn, and by whom.
pub(in crate::measure) struct Stage<'a> {
    pub device: &'a Device,
    pub cache: &'a PipelineCache,
    /// Without shadows: where their edges lie is a matter of shadow maps, not of the G-buffer.
    pub scene: &'a Scene,
    pub camera: &'a Camera,
    /// The size, the curve and all that is not the G-buffer's.
    pub options: Options,
    pub exposure_ev: f32,
}

/// A frame as the display shows it, in 8 bits, and its light, exposed but without a curve.
struct Pictures {
    display: Picture,
    light: Picture,
}

/// See the module.
pub(super) struct Truths {
    reference: Pictures,
    exact: Pictures,
    /// White where pixels are compared.
    mask: Picture,
    pub truth: Truth,
    pub left_out: f64,
}

impl Stage<'_> {
    fn frame(&self, scene: &Scene, options: Options) -> Result<Offscreen> {
        let plan = Plan::new(Needs::of(scene), options, &self.device.limits())?;
        let mut offscreen = Offscreen::new(self.device, scene, plan, RendererConfig::default(), self.cache)?;
        offscreen.render(&View { camera: self.camera, exposure_ev: self.exposure_ev })?;
        Ok(offscreen)
    }

    /// Linear light in floats.
    fn in_floats(&self, choice: Choice) -> Options {
        let options =
            Options { tonemap: Tonemap::Linear, output: OutputFormat::Rgba32Float, ..self.options.clone() };
        choice.apply(&options)
    }

    fn pictures(&self, choice: Choice) -> Result<Pictures> {
        let display = self.frame(self.scene, choice.apply(&self.options))?.picture();
        let light = self.frame(self.scene, self.in_floats(choice))?.picture();
        Ok(Pictures { display, light })
    }

    /// What the `exact` G-buffer holds.
    pub(in crate::measure) fn surfaces(&self) -> Result<(Vec<Stored>, Settings)> {
        let exact = Choice::of(Layout::Exact);
        let options = Options { keep_gbuffer: true, ..self.in_floats(exact) };
        let offscreen = self.frame(self.scene, options.clone())?;
        let settings = self.settings(offscreen.renderer().plan());
        let dark = || Scene { lights: Vec::new(), ..self.scene.clone() };
        let dark = settings.light_target.then(|| self.frame(&dark(), options)).transpose()?;
        Ok((stored(&offscreen, dark.as_ref())?, settings))
    }

    fn settings(&self, plan: &Plan) -> Settings {
        Settings {
            size: self.options.size,
            window: None,
            shift_px: DVec2::ZERO,
            exposure_ev: f64::from(self.exposure_ev),
            tonemap: self.options.tonemap,
            gbuffer: None,
            light_target: plan.has_light_target(),
            light_scale: f64::from(plan.light_scale()),
            shadows: false,
            brdf: Brdf::Exact,
            around: Method::Prefiltered(plan.options.environment_format),
            lightmap: Some(plan.options.lightmap_format),
            behind: Behind::of(plan),
        }
    }
}

impl Truths {
    /// Draws and computes them; the reference takes its time.
    ///
    /// # Errors
    /// As [`Offscreen::new`]; [`Error::Unsupported`] if nothing in view is lit, or only edges are.
    pub fn new(stage: &Stage<'_>) -> Result<Self> {
        let exact = Choice::of(Layout::Exact);
        let plan = Plan::new(Needs::of(stage.scene), stage.in_floats(exact), &stage.device.limits())?;
        if !plan.has_gbuffer() {
            return Err(Error::unsupported(
                format!("nothing in {} is lit, so that it has no G-buffer", stage.scene.name),
                "chart scenes with lit surfaces",
            ));
        }
        let (frame, truth) = if is_textured(stage.scene) {
            let (surfaces, settings) = stage.surfaces()?;
            let mut frame = shade_gbuffer(stage.scene, stage.camera, &settings, &surfaces);
            for pixel in &mut frame.pixels {
                // Nothing clears the depth of pixels that no surface covers: it does not tell them.
                pixel.covered = pixel.attributes.lit || pixel.attributes.prelit != DVec3::ZERO;
            }
            (frame, Truth::Surfaces)
        } else {
            (render(stage.scene, stage.camera, &stage.settings(&plan)), Truth::Scene)
        };
        let covered = frame.pixels.iter().filter(|p| p.covered).count();
        let compared = frame.pixels.iter().filter(|p| p.covered && !p.edge).count();
        if compared == 0 {
            return Err(Error::unsupported(
                format!("the camera {} of {} sees no surface", stage.camera.name, stage.scene.name),
                "choose another with --camera",
            ));
        }
        Ok(Self {
            mask: mask(&frame),
            reference: pictures_of(&frame),
            exact: stage.pictures(exact)?,
            truth,
            left_out: 1.0 - compared as f64 / covered as f64,
        })
    }

    /// The errors of a G-buffer against the reference, and against the `exact` one.
    ///
    /// # Errors
    /// As [`Offscreen::new`].
    pub fn errors(&self, stage: &Stage<'_>, choice: Choice) -> Result<[Errors; 2]> {
        let found = stage.pictures(choice)?;
        let against = |truth: &Pictures| {
            let display = compare(&truth.display, &found.display, Some(&self.mask))?;
            let light = compare(&truth.light, &found.light, Some(&self.mask))?;
            Ok(Errors::new(&display, &light))
        };
        Ok([against(&self.reference)?, against(&self.exact)?])
    }
}

/// Whether a texture changes what the scene looks like.
pub(in crate::measure) fn is_textured(scene: &Scene) -> bool {
    Needs::of(scene).kinds.iter().any(|need| need.kind.textures != 0)
}

fn mask(frame: &Frame) -> Picture {
    let texel = |white: bool| [if white { 255 } else { 0 }; 4];
    let texels = frame.pixels.iter().flat_map(|p| texel(p.covered && !p.edge)).collect();
    let [width, height] = frame.size;
    Picture { width, height, pixels: Pixels::Rgba8(texels) }
}

fn pictures_of(frame: &Frame) -> Pictures {
    let [width, height] = frame.size;
    let light = frame.pixels.iter().flat_map(|p| p.linear.as_vec3().extend(1.0).to_array()).collect();
    Pictures {
        display: Picture { width, height, pixels: Pixels::Rgba8(frame.to_rgba8_srgb()) },
        light: Picture { width, height, pixels: Pixels::Rgba32F(light) },
    }
}
