//! Pixels that two surfaces share: what may be averaged over samples, and what not.

use glam::DVec3;

use super::parts::sun;
use super::{Answer, Bound, Case, Figure, Findings, Lab, Sweep, Worst, display_steps};
use crate::Result;
use crate::measure::plot::{Axis, Plot};
use crate::plan::Tonemap;
use crate::reference::tonemap::tonemap;
use crate::reference::{Attributes, shade};
use crate::scene::Scene;

pub const EDGES: Sweep = Sweep {
    name: "edges",
    title: "Two surfaces in a pixel",
    varies: "angle between their normals, 0 to 170 degrees; a light to the side of both, which is above white",
    about: "Of several samples a pixel, light can be averaged and surfaces cannot: the mean of two normals is one that neither \
            surface has (Thibieroz 2009, figure 2.8.3). Light that is averaged as each volume is drawn, and written to the samples \
            that pass its depth test only, is averaged twice (figure 2.8.5).",
    needs_device: false,
    find: edges,
};

pub const RESOLVE: Sweep = Sweep {
    name: "resolve",
    title: "The tone curve and the mean of samples",
    varies: "light of one side of an edge, from a quarter of white to 1024 times white; the other side is a sixteenth of white",
    about: "A curve takes light above white to white. Before it, a sample of bright light outweighs all others of its pixel, so that \
            the edge has as many steps as one sample gives: the mean is made after the curve.",
    needs_device: false,
    find: resolve,
};

/// Samples of which a surface covers so many, the other one the rest.
const SAMPLES: u32 = 4;

const STEP: &str = "half a step of an 8-bit display is not seen";

fn bound() -> Bound {
    Bound { name: "SEEN", unit: "steps of 8-bit sRGB", good: 0.5, most: 1.0, reason: STEP }
}

/// A white, rough surface at the origin.
fn surface(normal_world: DVec3) -> Attributes {
    Attributes {
        lit: true,
        depth: 0.5,
        position_world: DVec3::ZERO,
        normal_world,
        roughness: 1.0,
        base_color: DVec3::ONE,
        metallic: 0.0,
        reflectance: None,
        prelit: DVec3::ZERO,
    }
}

fn edges(_: &Lab<'_>) -> Result<Findings> {
    let side = DVec3::new(1.0, 0.0, 0.3).normalize();
    let scene = Scene { lights: vec![sun(6.0, side.as_vec3())], ..Scene::default() };
    let light = |normal: DVec3| shade(&surface(normal), DVec3::Z, &scene, 1.0);
    let display = |light: DVec3| tonemap(Tonemap::Neutral, light);
    let mut worst = [Worst::new(), Worst::new()];
    let mut curves = [Vec::new(), Vec::new()];
    for degrees in 0..=170 {
        for covered in 1..SAMPLES {
            let half = f64::from(degrees).to_radians() * 0.5;
            let normals = [half.sin(), -half.sin()].map(|x| DVec3::new(x, 0.0, half.cos()));
            let share = f64::from(covered) / f64::from(SAMPLES);
            let mean = |of: &dyn Fn(DVec3) -> DVec3| of(normals[0]) * share + of(normals[1]) * (1.0 - share);
            let truth = mean(&|normal| display(light(normal))).x;
            let surfaces = display(light(mean(&|normal| normal).normalize())).x;
            // The light's volume holds the first surface only, and so do the samples that the mean is written to.
            let alone = light(normals[0]);
            let lit_once = display(alone).x * share;
            let on_the_fly = display(alone * share).x * share;
            let errors = [display_steps(surfaces, truth), display_steps(on_the_fly, lit_once)];
            for (worst, error) in worst.iter_mut().zip(errors) {
                worst.add(error, || format!("{degrees} degrees, {covered} of {SAMPLES} samples"));
            }
            if covered == SAMPLES / 2 {
                curves.iter_mut().zip(errors).for_each(|(c, error)| c.push([f64::from(degrees), error]));
            }
        }
    }
    let names =
        ["surfaces averaged, then lit", "light averaged over the pixel, added to the samples in its volume"];
    let cases = names.iter().zip(worst).map(|(name, worst)| Case {
        method: (*name).into(),
        worst: worst.error,
        at: worst.at.unwrap_or_default(),
        bound: bound(),
        answer: Some(Answer::Mended),
        remedy: "every sample of an edge is lit by itself, and light is summed by sample (--edges)".into(),
    });
    let plot = Plot {
        title: "Averages that are none of light".into(),
        x_label: "degrees between two normals".into(),
        y_label: "steps of 8-bit sRGB".into(),
        axes: [Axis::Linear; 2],
        curves: names.iter().map(|name| (*name).to_owned()).zip(curves).collect(),
        levels: vec![("seen".into(), 1.0)],
    };
    let caption = "How far a pixel is off that two surfaces share, two samples each.";
    Ok(Findings { cases: cases.collect(), figures: vec![Figure::plot("shared", caption, plot)] })
}

fn resolve(_: &Lab<'_>) -> Result<Findings> {
    const DIM: f64 = 1.0 / 16.0;
    let display = |light: f64| tonemap(Tonemap::Neutral, DVec3::splat(light)).x;
    let mut worst = Worst::new();
    let mut curve = Vec::new();
    for step in 0..=48 {
        let bright = 0.25 * (f64::from(step) / 4.0).exp2();
        for covered in 1..SAMPLES {
            let share = f64::from(covered) / f64::from(SAMPLES);
            let mean = |a: f64, b: f64| a * share + b * (1.0 - share);
            let error = display_steps(display(mean(bright, DIM)), mean(display(bright), display(DIM)));
            worst.add(error, || format!("{bright:.0} times white, {covered} of {SAMPLES} samples"));
            if covered == 1 {
                curve.push([bright, error]);
            }
        }
    }
    let case = Case {
        method: "light averaged, then the curve".into(),
        worst: worst.error,
        at: worst.at.unwrap_or_default(),
        bound: bound(),
        answer: Some(Answer::Mended),
        remedy:
            "--resolve tonemapped, the default, applies the curve to each sample; --resolve plain is this"
                .into(),
    };
    let plot = Plot {
        title: "An edge of bright light".into(),
        x_label: "light of the bright side, of which 1 is white".into(),
        y_label: "steps of 8-bit sRGB".into(),
        axes: [Axis::Logarithmic, Axis::Linear],
        curves: vec![("light averaged, then the curve".into(), curve)],
        levels: vec![("seen".into(), 1.0)],
    };
    let caption = "How far a pixel is off of which the bright side covers one sample of four.";
    Ok(Findings { cases: vec![case], figures: vec![Figure::plot("curve", caption, plot)] })
}
