//! Where the bits of `packed128` are, how they were found, and that no other layout of as many does better.

mod common;

use common::scenes;
use ontile::glam::DVec3;
use ontile::plan::{GBuffer, Layout, Limits, Needs, Options, Plan, Tonemap};
use ontile::reference::quantise::formats::unorm;
use ontile::reference::quantise::normals::{direction_from_octahedral_codes, octahedral_codes};
use ontile::reference::texture::{linear_from_srgb, srgb_from_linear};
use ontile::reference::tonemap::tonemap;
use ontile::reference::{Attributes, Settings, View, quantise, render, shade};
use ontile::scene::Scene;

/// A pixel that is lit, and what it is seen as.
struct Seen {
    pixel: [u32; 2],
    attributes: Attributes,
    to_viewer: DVec3,
    display: DVec3,
}

/// What a camera sees of a scene.
struct Study {
    scene: Scene,
    view: View,
    seen: Vec<Seen>,
}

const SIZE: [u32; 2] = [96, 54];

/// sRGB-encoded display light, in steps of 8 bits, not rounded.
fn display(linear: DVec3) -> DVec3 {
    let shown = tonemap(Tonemap::Neutral, linear).clamp(DVec3::ZERO, DVec3::ONE);
    DVec3::from_array(shown.to_array().map(|x| 255.0 * srgb_from_linear(x)))
}

impl Study {
    fn new(scene: Scene) -> Option<Self> {
        let camera = scene.cameras.first()?.clone();
        let settings = Settings { size: SIZE, shadows: false, ..Settings::default() };
        let (frame, view) = (render(&scene, &camera, &settings), View::new(&camera, SIZE));
        let seen = frame.pixels.iter().enumerate().filter(|(_, p)| p.attributes.lit).map(|(index, p)| {
            let pixel = [index as u32 % SIZE[0], index as u32 / SIZE[0]];
            let to_viewer = -view.ray_through_pixel(pixel).direction.normalize();
            let display = display(shade::shade(&p.attributes, to_viewer, &scene, 1.0));
            Seen { pixel, attributes: p.attributes, to_viewer, display }
        });
        let seen: Vec<_> = seen.collect();
        (!seen.is_empty()).then_some(Self { scene, view, seen })
    }

    /// The mean squared error of what `store` keeps of surfaces.
    fn error(&self, store: impl Fn(&Seen) -> Attributes) -> f64 {
        let error = |seen: &Seen| {
            let kept = shade::shade(&store(seen), seen.to_viewer, &self.scene, 1.0);
            (display(kept) - seen.display).length_squared() / 3.0
        };
        self.seen.iter().map(error).sum::<f64>() / self.seen.len() as f64
    }
}

fn studies() -> Vec<Study> {
    // What decals paint is stored as all else.
    let shipped = scenes::shipped().into_iter().filter(|scene| scene.decals.is_empty());
    let without_shadows = shipped.map(|scene| scene.without_shadows());
    without_shadows.chain([scenes::every_feature(), scenes::lights_only()]).filter_map(Study::new).collect()
}

/// Decibels below white of the mean over scenes of decibels: each scene counts alike.
fn psnr_db(studies: &[Study], store: impl Fn(&Study, &Seen) -> Attributes) -> f64 {
    let each =
        studies.iter().map(|study| 10.0 * (255.0 * 255.0 / study.error(|seen| store(study, seen))).log10());
    each.sum::<f64>() / studies.len() as f64
}

fn stored(gbuffer: &GBuffer, study: &Study, seen: &Seen) -> Attributes {
    let kept = quantise(gbuffer, &seen.attributes, &study.view, seen.pixel, 1.0);
    // Light that a target of its own holds is another matter; here it is about surfaces.
    Attributes { prelit: seen.attributes.prelit, ..kept }
}

/// Bits of colour attachments that the one pass has, output included, with every kind of light before lighting that the layout has
/// a place for.
fn bits(layout: Layout) -> u32 {
    let limits = Limits { max_color_attachments: 8, max_input_attachments: 8, ..Limits::default() };
    let plan = |scene| Plan::new(Needs::of(&scene), Options { layout, ..Options::default() }, &limits);
    let plan = plan(scenes::every_feature()).or_else(|_| plan(scenes::lights_only())).unwrap();
    plan.attachments.iter().map(|a| a.format).filter(|f| !f.is_depth()).map(|f| f.bits()).sum()
}

#[test]
fn no_layout_of_as_many_bits_is_closer() {
    let studies = studies();
    let of = |layout| {
        let gbuffer = GBuffer::new(&Options { layout, ..Options::default() }).unwrap();
        (psnr_db(&studies, |study, seen| stored(&gbuffer, study, seen)), bits(layout))
    };
    let (packed, most_bits) = of(Layout::Packed128);
    assert!(most_bits <= 128);
    for &layout in Layout::ALL.iter().filter(|l| **l != Layout::Packed128) {
        let (psnr, bits) = of(layout);
        println!("{layout}: {psnr:.2} dB, {bits} bits; packed128 {packed:.2} dB");
        assert!(
            bits > 128 || psnr < packed,
            "{layout}: {psnr:.2} dB in {bits} bits, packed128 {packed:.2} dB"
        );
    }
}

/// A number in [0, 1] as its code is spread.
type Curve = (&'static str, fn(f64) -> f64, fn(f64) -> f64);

const LINEAR: Curve = ("linear", |x| x, |x| x);
const LOGARITHM: Curve =
    ("logarithm", |x| 1.0 - (x.max(0.045)).ln() / 0.045_f64.ln(), |t| 0.045_f64.powf(1.0 - t));
/// Of colours: powers, sRGB, and hyperbolas, which take a division instead of a power either way.
const OF_COLOR: [Curve; 7] = [
    ("sRGB", srgb_from_linear, linear_from_srgb),
    ("power 2.2", |x| x.powf(1.0 / 2.2), |t| t.powf(2.2)),
    ("power 2", f64::sqrt, |t| t * t),
    ("hyperbola 0.2", |x| x * 1.2 / (x + 0.2), |t| 0.2 * t / (1.2 - t)),
    ("hyperbola 0.35", |x| x * 1.35 / (x + 0.35), |t| 0.35 * t / (1.35 - t)),
    ("hyperbola 0.5", |x| x * 1.5 / (x + 0.5), |t| 0.5 * t / (1.5 - t)),
    ("hyperbola 0.7", |x| x * 1.7 / (x + 0.7), |t| 0.7 * t / (1.7 - t)),
];

fn kept(value: f64, bits: u32, curve: &Curve) -> f64 {
    (curve.2)(unorm((curve.1)(value.clamp(0.0, 1.0)), bits))
}

/// `cargo test --test packing where_bits_count -- --ignored --nocapture` prints the table that `packed128` is from: every way to
/// give 64 bits to a normal, a roughness, a colour and a metallicness.
#[test]
#[ignore = "a search, which checks nothing"]
fn where_bits_count_most() {
    const BITS: u32 = 64;
    let studies = studies();
    let mut found = Vec::new();
    for (normal, roughness, metallic) in every([9, 10, 11, 12], [6, 7, 8, 9, 10], [4, 5, 6, 7, 8]) {
        let color = BITS - 2 * normal - roughness - metallic;
        // Green is seen most, blue least.
        let color = [(color + 1) / 3, color - (color + 1) / 3 - color / 3, color / 3];
        let color = [color[1], color[0], color[2]];
        for (roughness_curve, color_curve) in
            [LINEAR, LOGARITHM].into_iter().flat_map(|r| OF_COLOR.map(|c| (r, c)))
        {
            let psnr = psnr_db(&studies, |_, seen| {
                let a = &seen.attributes;
                let base = a.base_color.to_array();
                Attributes {
                    normal_world: direction_from_octahedral_codes(
                        octahedral_codes(a.normal_world, normal),
                        normal,
                    ),
                    roughness: kept(a.roughness, roughness, &roughness_curve),
                    base_color: DVec3::from_array(std::array::from_fn(|c| {
                        kept(base[c], color[c], &color_curve)
                    })),
                    metallic: kept(a.metallic, metallic, &LINEAR),
                    ..*a
                }
            });
            let (r, c) = (roughness_curve.0, color_curve.0);
            let name = format!(
                "normal 2 x {normal}, roughness {roughness} {r}, metallic {metallic}, colour {color:?} {c}"
            );
            found.push((psnr, name));
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.iter().for_each(|(psnr, name)| println!("{psnr:.2} dB: {name}"));
}

fn every(a: [u32; 4], b: [u32; 5], c: [u32; 5]) -> Vec<(u32, u32, u32)> {
    a.into_iter()
        .flat_map(|a| b.into_iter().flat_map(move |b| c.into_iter().map(move |c| (a, b, c))))
        .collect()
}
