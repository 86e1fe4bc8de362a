//! Light in few bits: steps in the dark, what is too bright, and what becomes of greys.

use super::{Answer, Bound, Case, Figure, Findings, Lab, Sweep, Worst, display_steps};
use crate::Result;
use crate::measure::canvas::short;
use crate::measure::plot::{Axis, Plot};
use crate::plan::Tonemap;
use crate::reference::quantise::formats::unorm;
use crate::reference::tonemap::tonemap;
use glam::DVec3;

pub const BANDING: Sweep = Sweep {
    name: "banding",
    title: "Steps of the light target",
    varies: "exposed light of one channel, 1e-4 to 1 (display white is near 1)",
    about: "A light target of few bits shows bands where its steps are wider than the display's: fixed point in the dark, \
            small floats everywhere alike. Alone, a channel passes the toe of the tone curve unchanged, which is where steps \
            are widest on the display.",
    needs_device: false,
    find: banding,
};

pub const OVERFLOW: Sweep = Sweep {
    name: "overflow",
    title: "Light above the target's range",
    varies: "exposed light of the brightest channel, 0.5 to 1e6; the others 1/10 and 1/100 of it",
    about: "Fixed point clips each channel by itself, so that bright colours change hue before the tone curve sees them.",
    needs_device: false,
    find: overflow,
};

pub const TINT: Sweep = Sweep {
    name: "tint",
    title: "Grey that becomes coloured",
    varies: "exposed light of a grey, 1e-4 to 16",
    about: "B10G11R11 has a bit less of mantissa in blue than in red and green. Rounded to the nearest, greys are tinted at \
            random; truncated, as formats with fewer bits may be converted, blue is too dark on average, which is yellow.",
    needs_device: false,
    find: tint,
};

/// How a target rounds.
#[derive(Clone, Copy)]
pub(super) enum Rounding {
    Nearest,
    /// Towards zero.
    Down,
}

/// What holds light.
#[derive(Clone, Copy)]
pub(super) enum Store {
    /// Bits, and the exposed light that is stored as 1.
    Fixed(u32, f64),
    /// Bits of mantissa, five of exponent.
    Float(u32, Rounding),
}

/// Name and what a channel is stored in: red's and blue's.
pub(super) type Target = (&'static str, [Store; 2]);

pub(super) const TEN_SCALED: Target = ("rgb10a2, range 2", [Store::Fixed(10, 2.0); 2]);
const TEN: Target = ("rgb10a2, range 1 (no scale)", [Store::Fixed(10, 1.0); 2]);
pub(super) const HALF: Target = ("rgba16f", [Store::Float(10, Rounding::Nearest); 2]);
pub(super) const SMALL: Target =
    ("b10g11r11, nearest", [Store::Float(6, Rounding::Nearest), Store::Float(5, Rounding::Nearest)]);
const SMALL_DOWN: Target =
    ("b10g11r11, truncated", [Store::Float(6, Rounding::Down), Store::Float(5, Rounding::Down)]);
const TARGETS: [Target; 5] = [TEN_SCALED, TEN, HALF, SMALL, SMALL_DOWN];

impl Store {
    /// What is read back of exposed light.
    pub fn keep(self, light: f64) -> f64 {
        match self {
            Self::Fixed(bits, range) => unorm(light / range, bits) * range,
            Self::Float(mantissa, rounding) => small_float(light, mantissa, rounding),
        }
    }

    /// Half a step, of the range or of the value: the largest relative rounding error.
    pub fn unit(self) -> f64 {
        match self {
            Self::Fixed(bits, range) => 0.5 * range / ((1_u64 << bits) - 1) as f64,
            Self::Float(mantissa, Rounding::Nearest) => (-f64::from(mantissa) - 1.0).exp2(),
            Self::Float(mantissa, Rounding::Down) => (-f64::from(mantissa)).exp2(),
        }
    }
}

/// A float without sign with five bits of exponent (bias 15), subnormals included; what is above its largest becomes that.
fn small_float(x: f64, mantissa: u32, rounding: Rounding) -> f64 {
    let exponent = x.max(f64::MIN_POSITIVE).log2().floor().max(-14.0);
    let step = (exponent - f64::from(mantissa)).exp2();
    let steps = match rounding {
        Rounding::Nearest => (x / step).round_ties_even(),
        Rounding::Down => (x / step).floor(),
    };
    let largest = (2.0 - (-f64::from(mantissa)).exp2()) * 15_f64.exp2();
    (steps * step).min(largest)
}

/// `count` values from `low` to `high` in equal factors.
fn spread(low: f64, high: f64, count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| low * (high / low).powf(i as f64 / (count - 1) as f64))
}

/// Steps of an 8-bit sRGB display that one channel's rounding is wrong by, at most: half a step of the target where the
/// display's curve is steepest.
pub(super) fn steps_at_most(store: Store) -> f64 {
    match store {
        // sRGB's linear part.
        Store::Fixed(..) => 12.92 * 255.0 * store.unit() * 1.001,
        // x d(sRGB)/dx is largest at 1: 1.055 / 2.4.
        Store::Float(..) => 1.055 / 2.4 * 255.0 * store.unit() * 1.01,
    }
}

fn banding(lab: &Lab<'_>) -> Result<Findings> {
    let mut findings = Findings::default();
    let mut curves = Vec::new();
    for (name, stores) in TARGETS {
        let mut worst = Worst::new();
        let mut bands = Vec::new();
        let count = lab.pick(4_000, 40_000);
        for (i, light) in spread(1e-4, 1.0, count).enumerate() {
            // Blue has the fewest bits.
            let shown = |light: f64| tonemap(Tonemap::Neutral, DVec3::new(0.0, 0.0, light)).z;
            let error = display_steps(shown(stores[1].keep(light)), shown(light));
            worst.add(error, || light);
            // The largest of a stretch, or the curve would be a band of noise.
            if i % (count / 100) == 0 {
                bands.push([light, 0.0]);
            }
            let last = bands.last_mut().expect("the first is added at once");
            last[1] = error.max(last[1]);
        }
        let at = worst.at.unwrap_or_default();
        let fixed = matches!(stores[1], Store::Fixed(..));
        findings.cases.push(Case {
            method: name.into(),
            worst: worst.error,
            at: format!("exposed light {}", short(at)),
            bound: Bound {
                name: "HALF_A_STEP",
                unit: "8-bit steps",
                good: steps_at_most(stores[1]).min(0.5),
                most: steps_at_most(stores[1]),
                reason: "half a step of the target through sRGB's steepest part; below half a step of the display nobody sees it",
            },
            answer: None,
            remedy: if fixed {
                "--dither hides the display's bands, not these; where they show, take --light-target rgba16f, or fold the target \
                 away (no emission, no ambient light)"
                    .into()
            } else {
                String::new()
            },
        });
        curves.push((name.to_owned(), bands));
    }
    findings.figures.push(Figure::plot(
        "steps",
        "The largest error within each hundredth of the range, of blue alone.",
        Plot {
            title: "Error of blue light after the target, through the neutral curve".into(),
            x_label: "exposed light".into(),
            y_label: "steps of an 8-bit sRGB display".into(),
            axes: [Axis::Logarithmic; 2],
            curves,
            levels: vec![("half a step".into(), 0.5)],
        },
    ));
    Ok(findings)
}

fn overflow(lab: &Lab<'_>) -> Result<Findings> {
    let mut findings = Findings::default();
    let mut curves = Vec::new();
    for (name, [red, blue]) in [TEN_SCALED, TEN, HALF, SMALL] {
        let mut worst = Worst::new();
        let mut curve = Vec::new();
        for light in spread(0.5, 1e6, lab.pick(200, 2_000)) {
            let color = DVec3::new(1.0, 0.1, 0.01) * light;
            let kept = DVec3::new(red.keep(color.x), red.keep(color.y), blue.keep(color.z));
            let (shown, meant) = (tonemap(Tonemap::Neutral, kept), tonemap(Tonemap::Neutral, color));
            let error = (0..3).map(|k| display_steps(shown[k], meant[k])).fold(0.0, f64::max);
            worst.add(error, || light);
            curve.push([light, error]);
        }
        let fixed = matches!(red, Store::Fixed(..));
        findings.cases.push(Case {
            method: name.into(),
            worst: worst.error,
            at: format!("exposed light {}", short(worst.at.unwrap_or_default())),
            bound: Bound {
                name: "NO_OTHER_HUE",
                unit: "8-bit steps",
                good: 1.0,
                // Two channels' rounding, and the curve's knee between them.
                most: 3.0,
                reason: "what rounding alone does to a colour of three channels in B10G11R11; more is another hue",
            },
            answer: fixed.then_some(Answer::Mended),
            remedy: if fixed {
                "clips: exposed light above the range needs --light-target rgba16f or b10g11r11; what is lit in one stage \
                 (no emission, no ambient light) needs no light target"
                    .into()
            } else {
                String::new()
            },
        });
        curves.push((name.to_owned(), curve));
    }
    findings.figures.push(Figure::plot(
        "steps",
        "An orange light of 100 : 10 : 1 that gets brighter.",
        Plot {
            title: "Error of a bright colour after the target, through the neutral curve".into(),
            x_label: "exposed light of red".into(),
            y_label: "steps of an 8-bit sRGB display".into(),
            axes: [Axis::Logarithmic; 2],
            curves,
            levels: vec![("other hue".into(), 3.0)],
        },
    ));
    Ok(findings)
}

fn tint(lab: &Lab<'_>) -> Result<Findings> {
    let mut findings = Findings::default();
    let mut curves = Vec::new();
    for (name, [red, blue]) in [HALF, SMALL, SMALL_DOWN] {
        let (mut sum, mut count) = (0.0, 0);
        let mut curve = Vec::new();
        for light in spread(1e-4, 16.0, lab.pick(20_000, 200_000)) {
            let bias = blue.keep(light) / red.keep(light) - 1.0;
            sum += bias;
            count += 1;
            if (0.25..1.0).contains(&light) && count % lab.pick(10, 100) == 0 {
                curve.push([light, 100.0 * bias]);
            }
        }
        findings.cases.push(Case {
            method: name.into(),
            worst: 100.0 * (sum / f64::from(count)).abs(),
            at: "the mean over all greys".into(),
            bound: Bound {
                name: "BLUE_BIAS",
                unit: "% of blue",
                // Rounded to the nearest, errors cancel but for a share of the relative step that falls as its square.
                good: 0.05,
                most: 100.0 * (0.5 * (2_f64.powi(-5) - 2_f64.powi(-6))),
                reason: "truncation loses half a step on average: a 64th of blue at most and a 128th of red, of the octave's lower end",
            },
            answer: None,
            remedy: if matches!(blue, Store::Float(5, Rounding::Down)) {
                "a device that truncates tints all greys yellow: take --light-target rgba16f there".into()
            } else {
                String::new()
            },
        });
        curves.push((name.to_owned(), curve));
    }
    findings.figures.push(Figure::plot(
        "bias",
        "Blue relative to red in greys of two octaves.",
        Plot {
            title: "Tint of greys".into(),
            x_label: "exposed light".into(),
            y_label: "% that blue is brighter than red".into(),
            axes: [Axis::Linear; 2],
            curves,
            levels: Vec::new(),
        },
    ));
    Ok(findings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_floats_round_as_the_standard_says() {
        let half = |x| small_float(x, 10, Rounding::Nearest);
        assert_eq!(half(1.0 + 2_f64.powi(-11)), 1.0);
        assert_eq!(half(1.0 + 3.0 * 2_f64.powi(-11)), 1.0 + 2_f64.powi(-9));
        assert_eq!(half(2_f64.powi(-24)), 2_f64.powi(-24));
        assert_eq!(half(1e9), 65504.0);
        assert_eq!(small_float(1.999, 5, Rounding::Down), 1.0 + 31.0 / 32.0);
        assert_eq!(small_float(0.0, 5, Rounding::Nearest), 0.0);
    }
}
