//! What a G-buffer's formats leave of a surface.
//!
//! [`encode`] gives the values that a stage reads back from the attachments, [`decode`] turns them into a surface
//! again: the counterparts of `gbuffer_write` and `gbuffer_read`.

pub mod formats;
pub mod normals;

#[cfg(test)]
mod tests;

use glam::{DVec2, DVec3, DVec4};

use self::formats::{b10g11r11, e5b9g9r9, float32, half, srgb8, unorm};
use self::normals::{direction_from_octahedral_codes, octahedral_codes, world_from_view};
use super::brdf::DIELECTRIC_F0;
use super::gbuffer::Attributes;
use super::view::View;
use crate::plan::{DepthStore, Form, Format, GBuffer, Gamma, LightPlace};

/// The G-buffer's channels as an input attachment returns them: UNORM in \[0, 1\], sRGB decoded, words as they are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stored {
    /// Reversed depth, where the form has it.
    pub depth: f64,
    /// The other surface targets in order, then the target of light that lighting reads, if it has one of its own.
    pub targets: [DVec4; 4],
    /// What geometry wrote to the light target: light before exposure times `exposure * light_scale`.
    pub light: DVec3,
}

/// The highlight of Thibieroz' shading pass: the Blinn-Phong exponent 8 as roughness, alpha² = 2 / (8 + 2) (Walter et al.
/// 2007, section 5.2).
const THIBIEROZ_ROUGHNESS: f64 = 0.668_740;

fn each(v: DVec3, f: impl Fn(f64) -> f64) -> DVec3 {
    DVec3::new(f(v.x), f(v.y), f(v.z))
}

fn each4(v: DVec4, f: impl Fn(f64) -> f64) -> DVec4 {
    v.to_array().map(f).into()
}

/// What a light target of this format holds of a value.
pub fn store_light(format: Format, scaled: DVec3) -> DVec3 {
    match format {
        Format::Rgb10a2Unorm => each(scaled, |x| unorm(x, 10)),
        Format::B10g11r11Float => b10g11r11(scaled),
        Format::Rgba16Float => each(scaled, half),
        _ => each(scaled, float32),
    }
}

/// What the light target holds after fixed-function addition of `added`. As Vulkan defines blending for UNORM,
/// the source is clamped, the sum formed, and the result rounded once.
pub fn blend_light(format: Format, stored: DVec3, added: DVec3) -> DVec3 {
    let source = match format {
        Format::Rgb10a2Unorm => added.clamp(DVec3::ZERO, DVec3::ONE),
        _ => each(added, float32),
    };
    store_light(format, stored + source)
}

/// Depth as it is stored.
pub fn store_depth(depth: DepthStore, value: f64) -> f64 {
    match depth {
        DepthStore::R32f | DepthStore::D32 => float32(value),
        DepthStore::D24 => unorm(value, 24),
        DepthStore::D16 => unorm(value, 16),
    }
}

/// A colour after its target.
pub fn store_color(gamma: Gamma, linear: DVec3) -> DVec3 {
    let power = |g: f64| each(linear, |x| unorm(x.max(0.0).powf(1.0 / g), 8));
    match gamma {
        Gamma::Srgb => each(linear, srgb8),
        Gamma::Power22 => power(2.2),
        Gamma::Power20 => power(2.0),
        Gamma::Linear => each(linear, |x| unorm(x, 8)),
        Gamma::Float => each(linear, float32),
    }
}

/// A stored colour as light.
pub fn load_color(gamma: Gamma, stored: DVec3) -> DVec3 {
    match gamma {
        Gamma::Srgb | Gamma::Linear | Gamma::Float => stored,
        Gamma::Power22 => each(stored, |x| x.powf(2.2)),
        Gamma::Power20 => stored * stored,
    }
}

/// What stands for a gamma in `packed128`: x 1.7 / (x + 0.7).
fn hyperbola(linear: DVec3) -> DVec3 {
    linear * 1.7 / (linear + 0.7)
}

/// The inverse of [`hyperbola`].
fn from_hyperbola(t: DVec3) -> DVec3 {
    t * 0.7 / (1.7 - t)
}

/// A number beside a colour.
fn store_beside(gamma: Gamma, value: f64) -> f64 {
    if gamma == Gamma::Float { float32(value) } else { unorm(value, 8) }
}

/// Writes a surface into a G-buffer's formats. `light_factor` is `exposure * light_scale`.
pub fn encode(gbuffer: &GBuffer, attributes: &Attributes, view: &View, light_factor: f64) -> Stored {
    let (base, metallic) = (attributes.base_color, attributes.metallic);
    let (normal, roughness, lit) = (attributes.normal_world, attributes.roughness, attributes.lit);
    let (gamma, position) = (gbuffer.gamma, attributes.position_world);
    let covered = attributes.depth > 0.0;
    let scaled = attributes.prelit * light_factor;
    let (diffuse, f0) = (attributes.diffuse(), attributes.f0());
    let colored = |color, beside| store_color(gamma, color).extend(store_beside(gamma, beside));
    let if_lit = |target: DVec4| if lit { target } else { DVec4::ZERO };
    let normal_roughness = || if_lit(normals::encode(gbuffer.normals, normal, roughness, view));
    let view_from_world = world_from_view(view).transpose();
    let place = |p: DVec3, beside: f64| if covered { each4(p.extend(beside), half) } else { DVec4::ZERO };
    let [a, b, c, d] = match gbuffer.form {
        Form::Metallic => [normal_roughness(), colored(base, metallic), DVec4::ZERO, DVec4::ZERO],
        Form::Specular => [normal_roughness(), colored(diffuse, 0.0), colored(f0, 0.0), DVec4::ZERO],
        Form::Thibieroz128 => {
            let normal = each(normal * 0.5 + 0.5, |x| unorm(x, 10)).extend(1.0);
            [place(position, roughness), if_lit(normal), colored(base, metallic), DVec4::ZERO]
        }
        Form::Thibieroz96 => {
            let n = if lit { each(normal * 0.5 + 0.5, |x| unorm(x, 8)) } else { DVec3::ZERO };
            let [x, y, z, _] = place(position, 0.0).to_array();
            let xy = DVec4::new(x, y, 0.0, 0.0);
            [xy, DVec4::X * z, colored(base, n.z), DVec4::new(n.x, n.y, 0.0, 0.0)]
        }
        Form::Rasa128 => {
            let n = view_from_world * normal * 0.5 + 0.5;
            let normal = DVec4::new(unorm(n.x, 8), unorm(n.y, 8), unorm(roughness, 8), 1.0);
            [if_lit(normal), colored(diffuse, 0.0), colored(f0, 0.0), DVec4::ZERO]
        }
        Form::Dissertation192 => {
            let position = view_from_world * (position - view.position_world);
            let normal = each4((view_from_world * normal).extend(1.0), half);
            [place(position, roughness), if_lit(normal), each4(base.extend(metallic), half), DVec4::ZERO]
        }
        Form::Metallic256 | Form::Specular256 => {
            let words = if covered { words256(gbuffer.form, attributes, scaled) } else { [0; 8] };
            let four = |at: usize| DVec4::from_array(std::array::from_fn(|k| f64::from(words[at + k])));
            [four(0), four(4), DVec4::ZERO, DVec4::ZERO]
        }
        Form::Packed128 => {
            let n = if lit { octahedral_codes(normal, 11) } else { DVec2::ZERO };
            let code = |value: f64, bits: u32| (unorm(value, bits) * f64::from((1_u32 << bits) - 1)) as u32;
            let color = hyperbola(base.clamp(DVec3::ZERO, DVec3::ONE));
            let metallic = code(metallic, 6);
            let first = n.x as u32 | (n.y as u32) << 11 | code(roughness, 9) << 22 | metallic >> 5 << 31;
            let second = code(color.x, 9) | code(color.y, 9) << 9 | code(color.z, 9) << 18 | metallic << 27;
            let surface = DVec4::new(f64::from(first), f64::from(second), 0.0, 0.0);
            [surface, DVec4::X * f64::from(word_of(e5b9g9r9(scaled))), DVec4::ZERO, DVec4::ZERO]
        }
    };
    Stored {
        depth: if gbuffer.form.has_depth() { store_depth(gbuffer.depth, attributes.depth) } else { 0.0 },
        targets: [a, b, c, d],
        light: match gbuffer.light {
            LightPlace::Added { sum, .. } => store_light(sum.target.format, scaled),
            LightPlace::Read(_) | LightPlace::Nowhere => DVec3::ZERO,
        },
    }
}

/// Reads a surface back at a pixel of `view`; without a stored position it follows from depth. `light_factor` as in
/// [`encode`].
pub fn decode(
    gbuffer: &GBuffer,
    stored: &Stored,
    view: &View,
    pixel: [u32; 2],
    light_factor: f64,
) -> Attributes {
    let gamma = gbuffer.gamma;
    let [a, b, c, d] = stored.targets;
    let world_from_view = world_from_view(view);
    let read = match gbuffer.form {
        Form::Metallic | Form::Specular => Read::at_depth(normals::decode(gbuffer.normals, a, view))
            .colored(load_color(gamma, b.truncate()), b.w)
            .specular((gbuffer.form == Form::Specular).then(|| load_color(gamma, c.truncate()))),
        Form::Rasa128 => {
            let xy = a.truncate().truncate() * 2.0 - 1.0;
            let normal = (a.w > 0.0).then(|| (normals::in_view(xy, view), a.z));
            Read::at_depth(normal)
                .colored(load_color(gamma, b.truncate()), 0.0)
                .specular(Some(load_color(gamma, c.truncate())))
        }
        Form::Packed128 => {
            let [first, second] = [a.x as u32, a.y as u32];
            let codes = DVec2::new(f64::from(first & 0x7ff), f64::from(first >> 11 & 0x7ff));
            let channel = |at: u32| f64::from(second >> at & 511) / 511.0;
            let roughness = f64::from(first >> 22 & 511) / 511.0;
            let normal =
                (codes != DVec2::ZERO).then(|| (direction_from_octahedral_codes(codes, 11), roughness));
            let color = from_hyperbola(DVec3::new(channel(0), channel(9), channel(18)));
            let metallic = f64::from(first >> 31 << 5 | second >> 27) / 63.0;
            Read { light: Some(from_word(b.x as u32)), ..Read::at_depth(normal) }.colored(color, metallic)
        }
        Form::Thibieroz128 => {
            let normal = (b.w > 0.0).then(|| ((b.truncate() * 2.0 - 1.0).normalize_or_zero(), a.w));
            Read::at(a.truncate(), normal).colored(load_color(gamma, c.truncate()), c.w)
        }
        Form::Thibieroz96 => {
            let normal = DVec3::new(d.x, d.y, c.w);
            let normal = (normal != DVec3::ZERO)
                .then(|| ((normal * 2.0 - 1.0).normalize_or_zero(), THIBIEROZ_ROUGHNESS));
            Read::at(DVec3::new(a.x, a.y, b.x), normal).colored(load_color(gamma, c.truncate()), 0.0)
        }
        Form::Dissertation192 => {
            let normal = (b.w > 0.0).then(|| (world_from_view * b.truncate().normalize_or_zero(), a.w));
            let position = view.position_world + world_from_view * a.truncate();
            Read::at(position, normal).colored(c.truncate(), c.w)
        }
        Form::Metallic256 | Form::Specular256 => {
            let words = std::array::from_fn(|k| if k < 4 { a[k] as u32 } else { b[k - 4] as u32 });
            read256(gbuffer.form, words)
        }
    };
    let covered = match read.position {
        Some(_) => stored.targets != [DVec4::ZERO; 4],
        None => stored.depth > 0.0,
    };
    let position_world = match read.position {
        Some(position) => position,
        None => {
            let distance = if covered { view.distance_from_depth(stored.depth) } else { 0.0 };
            view.ray_through_pixel(pixel).at(distance)
        }
    };
    let distance = (position_world - view.position_world).dot(view.forward_world);
    let depth = match read.position {
        Some(_) if covered => view.depth_from_distance(distance),
        Some(_) => 0.0,
        None => stored.depth,
    };
    let prelit = read.light.unwrap_or(stored.light) / light_factor;
    let surface =
        Attributes { depth, position_world, base_color: read.color, prelit, ..Attributes::default() };
    match read.normal {
        None => surface,
        Some((normal_world, roughness)) => Attributes {
            lit: true,
            normal_world,
            roughness,
            metallic: read.metallic,
            reflectance: read.reflectance,
            ..surface
        },
    }
}

/// What is read of a surface.
#[derive(Clone, Copy, Default)]
struct Read {
    /// World space, if it is stored.
    position: Option<DVec3>,
    /// Direction and roughness; `None`: not lit.
    normal: Option<(DVec3, f64)>,
    color: DVec3,
    metallic: f64,
    reflectance: Option<DVec3>,
    /// Scaled light, if it is among the targets.
    light: Option<DVec3>,
}

impl Read {
    fn at_depth(normal: Option<(DVec3, f64)>) -> Self {
        Self { normal, ..Self::default() }
    }

    fn at(position: DVec3, normal: Option<(DVec3, f64)>) -> Self {
        Self { position: Some(position), normal, ..Self::default() }
    }

    fn colored(self, color: DVec3, metallic: f64) -> Self {
        Self { color, metallic, ..self }
    }

    fn specular(self, reflectance: Option<DVec3>) -> Self {
        match reflectance {
            Some(_) => Self { reflectance, metallic: 0.0, ..self },
            None => self,
        }
    }
}

/// A pair of half floats in a word, the first in the low bits.
fn halves(low: f64, high: f64) -> u32 {
    half_bits(low) | half_bits(high) << 16
}

fn half_bits(value: f64) -> u32 {
    let value = half(value);
    let sign = if value.is_sign_negative() { 0x8000 } else { 0 };
    sign | float_bits(value.abs(), 10)
}

/// The bits of a value that a float of five bits of exponent holds.
fn float_bits(value: f64, mantissa_bits: i32) -> u32 {
    let exponent = (value.max(f64::MIN_POSITIVE).log2().floor() as i32).max(-14);
    let steps = value * f64::from(mantissa_bits - exponent).exp2();
    // Carries into the exponent by itself; subnormals have none.
    (((exponent + 14) as u32) << mantissa_bits) + steps as u32
}

fn float_from_bits(bits: u32, mantissa_bits: u32) -> f64 {
    let mantissa = f64::from(bits & ((1 << mantissa_bits) - 1));
    let exponent = (bits >> mantissa_bits & 0x1f) as i32;
    let one = if exponent == 0 { 0.0 } else { f64::from(1_u32 << mantissa_bits) };
    (mantissa + one) * f64::from(exponent.max(1) - 15 - mantissa_bits as i32).exp2()
}

fn halves_in(word: u32) -> DVec2 {
    let half = |bits: u32| if bits & 0x8000 != 0 { -1.0 } else { 1.0 } * float_from_bits(bits, 10);
    DVec2::new(half(word & 0xffff), half(word >> 16))
}

fn b10g11r11_word(v: DVec3) -> u32 {
    let v = b10g11r11(v);
    float_bits(v.x, 6) | float_bits(v.y, 6) << 11 | float_bits(v.z, 5) << 22
}

fn from_b10g11r11_word(word: u32) -> DVec3 {
    DVec3::new(
        float_from_bits(word & 0x7ff, 6),
        float_from_bits(word >> 11 & 0x7ff, 6),
        float_from_bits(word >> 22, 5),
    )
}

/// The E5B9G9R9 word of a value that such a word can hold.
fn word_of(v: DVec3) -> u32 {
    let largest = v.max_element();
    let exponent = (largest.max(f64::MIN_POSITIVE).log2().floor() as i32).max(-16) + 16;
    let [r, g, b] = v.to_array().map(|x| (x * f64::from(24 - exponent).exp2()) as u32);
    r | g << 9 | b << 18 | (exponent as u32) << 27
}

fn from_word(word: u32) -> DVec3 {
    let step = (f64::from(word >> 27) - 24.0).exp2();
    DVec3::from_array([0, 9, 18].map(|at| f64::from(word >> at & 511) * step))
}

/// The words of Smith and Einig 2015, listings 2.7 and 2.8.
fn words256(form: Form, surface: &Attributes, light: DVec3) -> [u32; 8] {
    let position = surface.position_world.to_array().map(|x| (x as f32).to_bits());
    let light_rg = halves(light.x, light.y);
    let [x, y, z] = position;
    if form == Form::Metallic256 {
        let n = if surface.lit { surface.normal_world } else { DVec3::ZERO };
        let covered = 0x8000;
        let roughness_metallic = halves(surface.roughness, surface.metallic) | covered;
        let (first, second) = (halves(light.z, n.x), halves(n.y, n.z));
        return [x, y, z, light_rg, first, second, roughness_metallic, b10g11r11_word(surface.base_color)];
    }
    let normal = if surface.lit { b10g11r11_word(surface.normal_world * 0.5 + 0.5) } else { 0 };
    let covered = 0x8000_0000;
    let light_b = halves(light.z, surface.roughness) | covered;
    let [diffuse, f0] = [surface.diffuse(), surface.f0()].map(b10g11r11_word);
    [x, y, z, light_rg, light_b, normal, diffuse, f0]
}

fn read256(form: Form, words: [u32; 8]) -> Read {
    let position = DVec3::from_array([0, 1, 2].map(|k| f64::from(f32::from_bits(words[k]))));
    let light = halves_in(words[3]).extend(halves_in(words[4]).x);
    if form == Form::Metallic256 {
        let yz = halves_in(words[5]);
        let normal = DVec3::new(halves_in(words[4]).y, yz.x, yz.y);
        let roughness_metallic = halves_in(words[6]).abs();
        let normal = (normal != DVec3::ZERO).then(|| (normal.normalize_or_zero(), roughness_metallic.x));
        return Read { light: Some(light), ..Read::at(position, normal) }
            .colored(from_b10g11r11_word(words[7]), roughness_metallic.y);
    }
    let normal = (words[5] != 0).then(|| {
        let normal = from_b10g11r11_word(words[5]) * 2.0 - 1.0;
        (normal.normalize_or_zero(), halves_in(words[4]).y.abs())
    });
    Read { light: Some(light), ..Read::at(position, normal) }
        .colored(from_b10g11r11_word(words[6]), 0.0)
        .specular(Some(from_b10g11r11_word(words[7])))
}

/// A surface after a G-buffer's formats: [`decode`] of [`encode`].
pub fn quantise(
    gbuffer: &GBuffer,
    attributes: &Attributes,
    view: &View,
    pixel: [u32; 2],
    light_factor: f64,
) -> Attributes {
    decode(gbuffer, &encode(gbuffer, attributes, view, light_factor), view, pixel, light_factor)
}

impl Attributes {
    /// Diffuse albedo under a dielectric's coat: 0 of a metal.
    pub fn diffuse(&self) -> DVec3 {
        self.base_color * (1.0 - self.metallic)
    }

    /// Reflectance at normal incidence.
    pub fn f0(&self) -> DVec3 {
        self.reflectance.unwrap_or(DVec3::splat(DIELECTRIC_F0).lerp(self.base_color, self.metallic))
    }
}
