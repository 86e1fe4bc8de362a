//! Colour and material in 8 bits: gamma in the dark, metals beside stone, light in RGBM.

use glam::{DVec3, Vec3, Vec4};

use super::{Answer, Bound, Case, Figure, Findings, Lab, Sweep, Worst, display_steps};
use crate::Result;
use crate::environment::TexelFormat;
use crate::measure::canvas::short;
use crate::measure::plot::{Axis, Plot};
use crate::picture::{Picture, Pixels};
use crate::plan::Gamma;
use crate::reference::Attributes;
use crate::reference::brdf::brdf;
use crate::reference::quantise::formats::unorm;
use crate::reference::quantise::{load_color, store_color};
use crate::reference::texture::srgb_from_linear;

pub const GAMMA: Sweep = Sweep {
    name: "gamma",
    title: "Gamma of stored colour",
    varies: "linear colour, 1e-5 to 1, in 8 bits",
    about: "Powers of 2.2 and 2 stand for sRGB where its two pieces cost too much (Smith and Einig 2015, listings 2.3 and 2.4). \
            Written and read by one power they only round elsewhere; where one side is sRGB (textures, displays) dark colours are \
            off by a factor.",
    needs_device: false,
    find: gamma,
};

pub const HALOS: Sweep = Sweep {
    name: "halos",
    title: "Halos where metal meets stone",
    varies: "place across a border of gold and stone whose textures are filtered, and how far the metallicness mask is moved",
    about: "Halfway between the two, the filtered base colour is read as albedo and as reflectance at once (Smith and Einig 2015, \
            figure 2.4): brighter or darker than both.",
    needs_device: false,
    find: halos,
};

pub const RGBM: Sweep = Sweep {
    name: "rgbm",
    title: "Light as colour and factor",
    varies: "light of two neighbouring texels, up to 1 : 1000, filtered halfway; and a ramp in blocks of 4 x 4 texels, compressed",
    about: "RGBM is right at texel centres. Filters mix its factor apart from its colours, and block compression gives each its \
            own line of few steps.",
    needs_device: false,
    find: rgbm,
};

pub const RANGE: Sweep = Sweep {
    name: "texel-range",
    title: "Light that is too bright for a texel",
    varies: "light of one texel, 1e-3 to 1e6",
    about: "A texel format has a largest value; what is brighter is held to it. RGBM's is the least.",
    needs_device: false,
    find: range,
};

/// What is left of a linear colour.
type Curve = Box<dyn Fn(f64) -> f64>;

fn gamma(lab: &Lab<'_>) -> Result<Findings> {
    let stored = |gamma: Gamma| {
        let keep = move |linear: f64| load_color(gamma, store_color(gamma, DVec3::splat(linear))).x;
        (
            format!("{gamma} both ways"),
            Box::new(keep) as Curve,
            (gamma == Gamma::Linear).then_some(Answer::Mended),
        )
    };
    let texture = |power: f64| {
        let keep = move |linear: f64| unorm(srgb_from_linear(linear), 8).powf(power);
        (format!("sRGB texture read by power {power}"), Box::new(keep) as Curve, Some(Answer::Guarded))
    };
    let methods = Gamma::ALL.iter().map(|&gamma| stored(gamma)).chain([texture(2.2), texture(2.0)]);
    let mut findings = Findings::default();
    let mut curves = Vec::new();
    let count = lab.pick(20_000, 200_000);
    for (name, keep, answer) in methods {
        let mut worst = Worst::new();
        let mut curve: Vec<[f64; 2]> = Vec::new();
        for i in 0..count {
            let linear = 1e-5_f64.powf(1.0 - f64::from(i) / f64::from(count - 1));
            let error = display_steps(keep(linear), linear);
            worst.add(error, || linear);
            if i % (count / 80) == 0 {
                curve.push([linear, 0.0]);
            }
            let last = curve.last_mut().expect("the first is added at once");
            last[1] = f64::max(last[1], error);
        }
        findings.cases.push(Case {
            method: name.clone(),
            worst: worst.error,
            at: format!("linear colour {}", short(worst.at.unwrap_or_default())),
            bound: Bound {
                name: "HALF_A_CODE",
                unit: "8-bit steps",
                good: 0.5 + 1e-9,
                // Half a code of power 2.0, 2 sqrt(x) / 510, through sRGB's slope 12.92 at its linear part's end, x = 0.0031308.
                most: 12.92 * 255.0 * (2.0 * 0.003_130_8_f64.sqrt() / 510.0 + 1.0 / 260_100.0),
                reason: "half a code of the power 2.0 where sRGB is steepest against it, at the end of its linear part; sRGB itself is \
                         off by half a step",
            },
            answer,
            remedy: match answer {
                None => String::new(),
                Some(Answer::Mended) => "codes that are even in light are too wide in the dark: every other choice is better".into(),
                Some(_) => {
                    "textures and the final image are converted by exact sRGB, in hardware; the powers are for what one frame writes \
                     and reads itself"
                        .into()
                }
            },
        });
        curves.push((name, curve));
    }
    findings.figures.push(Figure::plot(
        "steps",
        "The largest error within each eightieth of the range.",
        Plot {
            title: "Error of a colour after 8 bits".into(),
            x_label: "linear colour".into(),
            y_label: "steps of an 8-bit sRGB display".into(),
            axes: [Axis::Logarithmic; 2],
            curves,
            levels: vec![("half a step".into(), 0.5)],
        },
    ));
    Ok(findings)
}

/// What a texel says.
#[derive(Clone, Copy)]
struct Texel {
    base_color: DVec3,
    metallic: f64,
    roughness: f64,
}

const GOLD: Texel = Texel { base_color: DVec3::new(1.0, 0.78, 0.34), metallic: 1.0, roughness: 0.35 };
const STONE: Texel = Texel { base_color: DVec3::new(0.32, 0.29, 0.26), metallic: 0.0, roughness: 0.7 };

/// Light towards the viewer of a surface that is lit from the side: the highlight's foot, where metal is dark. cd/m² for 1 lx.
fn shown(texel: Texel) -> DVec3 {
    let surface = Attributes {
        lit: true,
        base_color: texel.base_color,
        metallic: texel.metallic,
        roughness: texel.roughness,
        ..Attributes::default()
    };
    let way = |degrees: f64| DVec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos());
    let l = way(25.0);
    brdf(&surface, DVec3::Z, way(0.0), l) * l.z
}

/// From 0 on the left of a border to 1 on its right, over one texel.
fn ramp(place: f64) -> f64 {
    (place + 0.5).clamp(0.0, 1.0)
}

/// The filtered texel at a place, in texels from the border; the metallicness mask is moved by so many into the stone.
fn filtered(place: f64, moved: f64) -> Texel {
    let (color, metal) = (ramp(place), ramp(place - moved));
    Texel {
        base_color: GOLD.base_color.lerp(STONE.base_color, color),
        metallic: 1.0 - metal,
        roughness: GOLD.roughness + (STONE.roughness - GOLD.roughness) * color,
    }
}

/// What should be seen: each material shaded by itself, then mixed.
fn mixed(place: f64) -> DVec3 {
    shown(GOLD).lerp(shown(STONE), ramp(place))
}

fn halos(lab: &Lab<'_>) -> Result<Findings> {
    let mut findings = Findings::default();
    let mut curves = Vec::new();
    let methods = [("as painted", 0.0), ("mask eroded by a texel", -1.0), ("mask dilated by a texel", 1.0)];
    let span = (shown(GOLD) - shown(STONE)).abs().max_element();
    for (name, moved) in methods {
        let mut worst = Worst::new();
        let mut curve = Vec::new();
        let count = lab.pick(200, 2_000);
        for i in 0..=count {
            let place = f64::from(i) / f64::from(count) * 4.0 - 2.0;
            let light = shown(filtered(place, moved));
            let (low, high) = (shown(GOLD).min(shown(STONE)), shown(GOLD).max(shown(STONE)));
            // A halo is what is brighter than both, or darker.
            let beyond = (light - high).max(low - light).max(DVec3::ZERO).max_element() / span;
            worst.add(100.0 * beyond, || place);
            curve.push([place, light.y]);
        }
        findings.cases.push(Case {
            method: name.into(),
            worst: worst.error,
            at: format!("{:.2} texels into the stone", worst.at.unwrap_or_default()),
            bound: Bound {
                name: "BEYOND_BOTH",
                unit: "% of the contrast",
                good: 2.0,
                most: most_beyond(),
                reason: "the brightest or darkest surface that any base colour, roughness and metallicness between the two gives, beyond \
                         both; 2 % of the contrast between gold and stone is one step where the border itself is 50 wide",
            },
            answer: None,
            remedy: match moved {
                0.0 => "an artist moves the mask: eroding it leaves a rim of stone with gold's bright albedo, dilating it one of metal \
                        with stone's dark reflectance; which is less depends on the two"
                    .into(),
                _ => String::new(),
            },
        });
        curves.push((name.to_owned(), curve));
    }
    let truth = (0..=100).map(|i| f64::from(i) / 25.0 - 2.0).map(|place| [place, mixed(place).y]);
    curves.push(("shaded apart, then mixed".into(), truth.collect()));
    findings.figures.push(Figure::plot(
        "profile",
        "Green light across the border.",
        Plot {
            title: "Gold (left) beside stone".into(),
            x_label: "texels from the border".into(),
            y_label: "cd/m² under 1 lx".into(),
            axes: [Axis::Linear; 2],
            curves,
            levels: Vec::new(),
        },
    ));
    findings.figures.push(Figure::picture(
        "border",
        "The border enlarged, from above: shaded apart and mixed; as painted; mask eroded; mask dilated.",
        strips(&[None, Some(0.0), Some(-1.0), Some(1.0)]),
    ));
    Ok(findings)
}

/// How far any mixture is beyond both materials, in percent of their contrast.
fn most_beyond() -> f64 {
    const STEPS: u32 = 20;
    let (low, high) = (shown(GOLD).min(shown(STONE)), shown(GOLD).max(shown(STONE)));
    let span = (shown(GOLD) - shown(STONE)).abs().max_element();
    let mut most = 0.0;
    for i in 0..=STEPS {
        for j in 0..=STEPS {
            let (color, metal) = (f64::from(i) / f64::from(STEPS), f64::from(j) / f64::from(STEPS));
            let light = shown(Texel {
                base_color: GOLD.base_color.lerp(STONE.base_color, color),
                metallic: metal,
                roughness: GOLD.roughness + (STONE.roughness - GOLD.roughness) * color,
            });
            most = f64::max(most, (light - high).max(low - light).max_element() / span);
        }
    }
    100.0 * most * 1.01
}

/// Strips of a border, exposed so that gold is bright.
fn strips(moved: &[Option<f64>]) -> Picture {
    const WIDTH: usize = 480;
    const HEIGHT: usize = 48;
    let exposure = 0.8 / shown(GOLD).max(shown(STONE)).max_element();
    let mut pixels = Vec::new();
    for y in 0..HEIGHT * moved.len() {
        for x in 0..WIDTH {
            let place = x as f64 / WIDTH as f64 * 4.0 - 2.0;
            let light = match moved[y / HEIGHT] {
                Some(moved) => shown(filtered(place, moved)),
                None => mixed(place),
            };
            let light = if y % HEIGHT < 2 { Vec3::ZERO } else { (light * exposure).as_vec3() };
            pixels.extend(light.extend(1.0).to_array());
        }
    }
    Picture { width: WIDTH as u32, height: (HEIGHT * moved.len()) as u32, pixels: Pixels::Rgba32F(pixels) }
}

/// Four channels in bytes, and back: as stored, before and after filters.
fn stored(format: TexelFormat, light: f32) -> Vec4 {
    let mut bytes = Vec::new();
    format.encode(Vec3::splat(light.min(format.max())), &mut bytes);
    format.load(&bytes)
}

fn rgbm(lab: &Lab<'_>) -> Result<Findings> {
    let mut findings = Findings::default();
    let mut curves = Vec::new();
    for &format in TexelFormat::ALL {
        let mut worst = Worst::new();
        let mut curve = Vec::new();
        let count = lab.pick(60, 600);
        for i in 0..=count {
            let contrast = 1000_f32.powf(i as f32 / count as f32);
            let bright = format.max().min(36.0);
            let [a, b] = [bright, bright / contrast].map(|light| stored(format, light));
            let [truth, found] = [(format.decode(a) + format.decode(b)) * 0.5, format.decode((a + b) * 0.5)]
                .map(|light| f64::from(light.x));
            let error = 100.0 * (found / truth - 1.0).abs();
            worst.add(error, || contrast);
            curve.push([f64::from(contrast), error]);
        }
        let is_rgbm = format == TexelFormat::Rgbm;
        findings.cases.push(Case {
            method: format!("{format}, filtered"),
            worst: worst.error,
            at: format!("1 : {}", short(worst.at.unwrap_or_default().into())),
            bound: Bound {
                name: "HALFWAY",
                unit: "% of the light",
                good: 0.01,
                // A factor of half, squared, is a quarter where half is true; roots are up to 1 in 255 / 2 off besides.
                most: 55.0,
                reason: "halfway between light and near darkness, whose roots are near 1 too, RGBM's factor is halved and then squared: a \
                         quarter for a half",
            },
            answer: None,
            remedy: if is_rgbm {
                "the default is e5b9g9r9, which is filtered as light, in the same four bytes".into()
            } else {
                String::new()
            },
        });
        curves.push((format.to_string(), curve));
    }
    findings.cases.push(blocks());
    findings.figures.push(Figure::plot(
        "filtered",
        "Halfway between two texels.",
        Plot {
            title: "Error of light that is filtered as it is stored".into(),
            x_label: "contrast of the two texels, 1 : x".into(),
            y_label: "% of the light".into(),
            axes: [Axis::Logarithmic, Axis::Linear],
            curves,
            levels: Vec::new(),
        },
    ));
    Ok(findings)
}

/// RGBM under block compression as BC3 and ETC2 have it: in each block of 4 x 4, one line through the colours with four places
/// on it and one through the factor with eight.
fn blocks() -> Case {
    let mut worst = Worst::new();
    for octaves in 1..=40 {
        let octaves = f64::from(octaves) * 0.2;
        let light = |i: usize| (36.0 * (-octaves * i as f64 / 15.0).exp2()) as f32;
        let texels: Vec<_> = (0..16).map(|i| stored(TexelFormat::Rgbm, light(i))).collect();
        let ends = |k: usize| {
            let values = || texels.iter().map(|texel| texel[k]);
            (values().fold(f32::MAX, f32::min), values().fold(f32::MIN, f32::max))
        };
        let snap = |value: f32, (low, high): (f32, f32), places: f32| {
            if high == low {
                low
            } else {
                low + ((value - low) / (high - low) * places).round() / places * (high - low)
            }
        };
        for (i, texel) in texels.iter().enumerate() {
            let color = snap(texel.x, ends(0), 3.0);
            let compressed = Vec4::new(color, color, color, snap(texel.w, ends(3), 7.0));
            let found = f64::from(TexelFormat::Rgbm.decode(compressed).x);
            worst.add(100.0 * (found / f64::from(light(i)) - 1.0).abs(), || octaves);
        }
    }
    Case {
        method: "rgbm, in compressed blocks".into(),
        worst: worst.error,
        at: format!("a ramp of {:.1} octaves within a block", worst.at.unwrap_or_default()),
        bound: Bound {
            name: "STEPS_OF_A_BLOCK",
            unit: "% of the light",
            good: 2.0,
            most: 20.0,
            reason: "half of a seventh of an octave's root as factor is 4 %, twice that squared, and steps of colour beside it; a fifth is \
                     where a ramp shows its blocks",
        },
        answer: Some(Answer::Refused),
        remedy: "lightmaps and environments are never compressed in blocks: files that are so are not read, and ours hold whole texels"
            .into(),
    }
}

fn range(lab: &Lab<'_>) -> Result<Findings> {
    let mut findings = Findings::default();
    let mut curves = Vec::new();
    for &format in TexelFormat::ALL {
        let mut worst = Worst::new();
        let mut curve = Vec::new();
        let count = lab.pick(400, 4_000);
        for i in 0..=count {
            let light = 1e-3 * 1e9_f64.powf(i as f64 / count as f64);
            let found = f64::from(format.decode(stored(format, light as f32)).x);
            let error = 100.0 * (found / light - 1.0).abs();
            // Light that the format is for.
            if light <= f64::from(format.max()) {
                worst.add(error, || light);
            }
            curve.push([light, error.max(1e-4)]);
        }
        // Half a step of root and factor each, squared, at the darkest; half steps of 5 and 9 and 10 bits.
        let most = match format {
            TexelFormat::Rgbm => 100.0,
            TexelFormat::B10G11R11 => 100.0 / 64.0,
            TexelFormat::E5B9G9R9 => 100.0 / 512.0,
            TexelFormat::Rgba16F => 100.0 / 2048.0,
        };
        findings.cases.push(Case {
            method: format!("{format}, up to {}", short(format.max().into())),
            worst: worst.error,
            at: format!("light of {}", short(worst.at.unwrap_or_default())),
            bound: Bound {
                name: "TEXEL_STEP",
                unit: "% of the light",
                good: f64::min(most, 1.0),
                most: most * 1.001,
                reason: "half a step of the format, relative: RGBM's steps are even, so that its darkest light is off by all of itself",
            },
            answer: None,
            remedy: match format {
                TexelFormat::Rgbm => "brighter light is scaled into its range for lightmaps, and clipped for environments; take e5b9g9r9".into(),
                _ => String::new(),
            },
        });
        curves.push((format.to_string(), curve));
    }
    findings.figures.push(Figure::plot(
        "error",
        "Relative error by light; what is above a format's range is lost.",
        Plot {
            title: "Error of light in one texel".into(),
            x_label: "light".into(),
            y_label: "% of the light".into(),
            axes: [Axis::Logarithmic; 2],
            curves,
            levels: Vec::new(),
        },
    ));
    Ok(findings)
}
