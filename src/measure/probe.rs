//! What a G-buffer will cost a scene's picture, without a GPU: small windows of the picture, shaded in f64 from what each
//! G-buffer's formats leave of the surfaces there.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::flip::{PIXELS_PER_DEGREE, flip};
use super::metrics::{ErrorStats, percentile, psnr_db};
use super::{ciede2000, lab_from_linear};
use crate::plan::{GBuffer, LightPlace, Options, Plan};
use crate::reference::around::Method;
use crate::reference::texture::{linear_from_srgb, srgb_from_linear};
use crate::reference::{Frame, Pixel, Settings, Tracer, View, Window, encode, shade_gbuffer};
use crate::scene::{Camera, Scene};
use crate::{Error, Result};

/// Side of a window, pixels: wider than FLIP's filters. Many small ones miss less than few large ones.
const WINDOW_PX: u32 = 24;
/// Windows along both sides of the picture.
const WINDOWS: [u32; 2] = [10, 6];

/// What drivers lose besides: they may round a value to either of the 8-bit codes beside it, and approximate sRGB. These are
/// the errors of the layout `exact` on lavapipe, the middle of those of the shipped scenes.
const ROUNDING: Predicted = Predicted { flip: 0.0065, psnr_db: Some(60.0), ciede2000_p95: 0.55 };

/// Windows of a scene's picture as they are, to be compared with what a G-buffer makes of them.
pub struct Probe<'a> {
    camera: &'a Camera,
    /// Without shadows: their edges are the same for all.
    scene: Scene,
    options: Options,
    exposure_ev: f32,
    windows: Vec<(Window, Frame)>,
}

/// How far the picture will be from the true one; in 8 bits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Predicted {
    /// Mean FLIP.
    pub flip: f64,
    /// Peak signal-to-noise ratio; `None` if no pixel differs.
    pub psnr_db: Option<f64>,
    /// CIEDE2000 that 95 % of the pixels do not exceed.
    pub ciede2000_p95: f64,
}

/// What is in the picture, as shares of the pixels that surfaces cover.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Content {
    /// Metallic by more than half.
    pub metal: f64,
    /// Lit, and of a perceptual roughness below 0.3: highlights are narrower than what 8 bits turn a normal by.
    pub smooth: f64,
    /// Brighter than what the display shows as white without a curve.
    pub bright: f64,
    /// Sending light of its own: emission, ambient light, environment, lightmap.
    pub prelit: f64,
    /// Darker than a hundredth of white.
    pub dark: f64,
    /// The nearest and the farthest surface along the view's axis, metres.
    pub distance_m: [f64; 2],
}

impl<'a> Probe<'a> {
    /// Looks at the scene; takes seconds for large ones.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the windows show no lit surface.
    pub fn new(scene: &Scene, camera: &'a Camera, options: &Options, exposure_ev: f32) -> Result<Self> {
        let scene = scene.clone().without_shadows();
        let settings = settings(options, exposure_ev);
        let tracer = Tracer::new(&scene, &settings);
        let windows: Vec<_> = windows(options.size)
            .into_iter()
            .map(|window| (window, tracer.render(camera, &within(&settings, window))))
            .collect();
        drop(tracer);
        let probe = Self { camera, scene, options: options.clone(), exposure_ev, windows };
        if probe.pixels().any(|p| p.attributes.lit) {
            return Ok(probe);
        }
        Err(Error::unsupported(
            format!("{}: no lit surface is in sight to choose a G-buffer by", probe.scene.name),
            "name a layout instead of 'auto', or choose another --camera",
        ))
    }

    /// The pixels that are compared.
    fn pixels(&self) -> impl Iterator<Item = &Pixel> {
        self.windows.iter().flat_map(|(_, frame)| &frame.pixels).filter(|p| counts(p))
    }

    /// What is in the picture.
    pub fn content(&self) -> Content {
        let view = View::new(self.camera, self.options.size);
        let mut content = Content { distance_m: [f64::INFINITY, 0.0], ..Content::default() };
        let mut count = 0.0;
        for pixel in self.pixels() {
            let a = &pixel.attributes;
            let light = pixel.linear.max_element();
            count += 1.0;
            let shares = [
                (&mut content.metal, a.lit && a.metallic > 0.5),
                (&mut content.smooth, a.lit && a.roughness < 0.3),
                (&mut content.bright, light > 1.0),
                (&mut content.prelit, a.prelit != DVec3::ZERO),
                (&mut content.dark, light < 0.01),
            ];
            shares.into_iter().for_each(|(share, has)| *share += f64::from(u8::from(has)));
            let distance = view.distance_from_depth(a.depth);
            let [near, far] = content.distance_m;
            content.distance_m = [near.min(distance), far.max(distance)];
        }
        for share in [
            &mut content.metal,
            &mut content.smooth,
            &mut content.bright,
            &mut content.prelit,
            &mut content.dark,
        ] {
            *share /= f64::max(count, 1.0);
        }
        content
    }

    /// The error of the picture that a plan of the same scene and options gives.
    pub fn error(&self, plan: &Plan) -> Predicted {
        let settings = Settings {
            gbuffer: Some(stored_gbuffer(plan)),
            light_target: plan.has_light_target(),
            light_scale: f64::from(plan.light_scale()),
            ..settings(&self.options, self.exposure_ev)
        };
        let gbuffer = settings.gbuffer.as_ref().expect("it was just set");
        let factor = settings.exposure() * settings.light_scale;
        let (mut flips, mut codes, mut ciede) = (ErrorStats::default(), ErrorStats::default(), Vec::new());
        for (window, exact) in &self.windows {
            let settings = within(&settings, *window);
            let view = settings.view(self.camera);
            let stored: Vec<_> =
                exact.pixels.iter().map(|p| encode(gbuffer, &p.attributes, &view, factor)).collect();
            let found = shade_gbuffer(&self.scene, self.camera, &settings, &stored);
            let shown = [exact, &found].map(|frame| {
                let pixels = exact.pixels.iter().zip(&frame.pixels);
                // What does not count is the same in both, so that FLIP sees no difference in its neighbourhood.
                pixels.map(|(e, p)| code(if counts(e) { p.display } else { e.display })).collect::<Vec<_>>()
            });
            let linear = shown.each_ref().map(|codes| {
                codes
                    .iter()
                    .map(|c| DVec3::from_array(c.to_array().map(|c| linear_from_srgb(c / 255.0))))
                    .collect::<Vec<_>>()
            });
            let errors = flip(&linear[0], &linear[1], exact.size, PIXELS_PER_DEGREE);
            for i in (0..errors.len()).filter(|&i| counts(&exact.pixels[i])) {
                flips.add(errors[i], 0.0);
                (0..3).for_each(|c| codes.add(shown[0][i][c], shown[1][i][c]));
                ciede.push(ciede2000(lab_from_linear(linear[0][i]), lab_from_linear(linear[1][i])));
            }
        }
        Predicted {
            flip: flips.mean().hypot(ROUNDING.flip),
            psnr_db: ROUNDING
                .psnr_db
                .map(|db| psnr_db(codes.mse() + 255.0_f64.powi(2) * 10.0_f64.powf(-0.1 * db), 255.0)),
            ciede2000_p95: percentile(&mut ciede, 0.95).unwrap_or(0.0).hypot(ROUNDING.ciede2000_p95),
        }
    }
}

/// The plan's G-buffer with the light target that its way of lights has.
fn stored_gbuffer(plan: &Plan) -> GBuffer {
    let mut gbuffer = plan.gbuffer.clone();
    if let (LightPlace::Added { sum, .. }, Some(target)) = (&mut gbuffer.light, plan.light_target()) {
        *sum = target;
    }
    gbuffer
}

/// Whether a surface is there, and is the GPU's too.
fn counts(pixel: &Pixel) -> bool {
    pixel.covered && !pixel.edge
}

/// The 8-bit codes of display light.
fn code(display: DVec3) -> DVec3 {
    DVec3::from_array(display.to_array().map(|x| (srgb_from_linear(x.clamp(0.0, 1.0)) * 255.0).round()))
}

fn settings(options: &Options, exposure_ev: f32) -> Settings {
    Settings {
        size: options.size,
        exposure_ev: f64::from(exposure_ev),
        tonemap: options.tonemap,
        shadows: false,
        around: Method::Prefiltered(options.environment_format),
        lightmap: Some(options.lightmap_format),
        ..Settings::default()
    }
}

fn within(settings: &Settings, window: Window) -> Settings {
    Settings { size: window.size, window: Some(window), ..settings.clone() }
}

/// Spread evenly over the picture; those of a small picture touch, and cover it.
fn windows(picture: [u32; 2]) -> Vec<Window> {
    let along = |side: u32, count: u32| -> (u32, Vec<u32>) {
        let length = WINDOW_PX.min(side);
        let count = count.min(side.div_ceil(length));
        let place = |i: u32| match count {
            1 => (side - length) / 2,
            _ => (side - length) * i / (count - 1),
        };
        (length, (0..count).map(place).collect())
    };
    let ((width, columns), (height, rows)) = (along(picture[0], WINDOWS[0]), along(picture[1], WINDOWS[1]));
    let window = |x: u32, y: u32| Window { image: picture, origin: [x, y], size: [width, height] };
    rows.iter().flat_map(|&y| columns.iter().map(move |&x| window(x, y))).collect()
}
