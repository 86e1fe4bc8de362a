//! What a reference picture is of.

use glam::DVec2;

use super::around::Method;
use super::view::{View, Window};
use crate::environment::TexelFormat;
use crate::plan::{Brdf, Format, GBuffer, LightPlace, Tonemap};
use crate::scene::Camera;

/// What is computed.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The part of a larger picture that is computed; it has that size. `None`: the whole.
    pub window: Option<Window>,
    /// How far from its centre each pixel is looked at, pixels to the right and down.
    pub shift_px: DVec2,
    /// Light is multiplied by 2 to this power.
    pub exposure_ev: f64,
    /// From exposed light to the display.
    pub tonemap: Tonemap,
    /// What the surface passes through; `None` keeps f64.
    pub gbuffer: Option<GBuffer>,
    /// Whether light passes through the layout's light target too. Without one, lighting and tonemap are folded.
    pub light_target: bool,
    /// What exposed light is multiplied by in the light target.
    pub light_scale: f64,
    /// Whether lights cast the shadows that they are to cast.
    pub shadows: bool,
    /// How light from all around is evaluated.
    pub around: Method,
    /// How reflection is evaluated; half floats are not modelled.
    pub brdf: Brdf,
    /// What stores the lightmap; `None` keeps f64.
    pub lightmap: Option<TexelFormat>,
    /// Where media find what is behind them.
    pub behind: Behind,
}

/// Where media find what is behind them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Behind {
    /// Straight behind them, not bent.
    #[default]
    Straight,
    /// Bent, in the picture of what is opaque, where a plan that refracts looks for it
    /// ([`Plan::refracts`](crate::plan::Plan::refracts)).
    Picture,
    /// Bent, by rays: where it is.
    Rays,
}

impl Behind {
    /// Of a plan's pictures.
    pub fn of(plan: &crate::plan::Plan) -> Self {
        if plan.refracts() { Self::Picture } else { Self::Straight }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            size: [320, 180],
            window: None,
            shift_px: DVec2::ZERO,
            exposure_ev: 0.0,
            tonemap: Tonemap::Neutral,
            gbuffer: None,
            light_target: false,
            light_scale: 1.0,
            shadows: true,
            around: Method::default(),
            brdf: Brdf::Exact,
            lightmap: None,
            behind: Behind::Straight,
        }
    }
}

impl Settings {
    /// What the camera sees.
    pub fn view(&self, camera: &Camera) -> View {
        let view = match &self.window {
            Some(window) => View::within(camera, window),
            None => View::new(camera, self.size),
        };
        view.shifted(self.shift_px)
    }

    /// The multiplier 2^EV.
    pub fn exposure(&self) -> f64 {
        self.exposure_ev.exp2()
    }

    /// The light target, if one is used: its format, and whether diffuse light has one of its own.
    pub(super) fn added_light(&self) -> Option<(Format, bool)> {
        match self.gbuffer.as_ref()?.light {
            LightPlace::Added { sum, split, .. } if self.light_target => Some((sum.target.format, split)),
            _ => None,
        }
    }

    /// Whether light that is not reflected passes through a format.
    pub(super) fn stores_prelit(&self) -> bool {
        let read = |gbuffer: &GBuffer| matches!(gbuffer.light, LightPlace::Read(_));
        self.added_light().is_some() || self.gbuffer.as_ref().is_some_and(read)
    }
}
