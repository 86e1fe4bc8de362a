//! What a G-buffer layout's formats leave of a surface.
//!
//! [`encode`] gives the values that a stage reads back from the attachments, [`decode`] turns them into a surface
//! again: the counterparts of `gbuffer_write` and `gbuffer_read`. Conversions are those of Vulkan 1.3 chapter 3,
//! "Fixed-Point Data Conversion", rounding to the nearest code.

use glam::{DVec3, DVec4};

use super::gbuffer::Attributes;
use super::texture::{linear_from_srgb, srgb_from_linear};
use super::view::View;
use crate::plan::Layout;

/// The G-buffer's channels as an input attachment returns them: UNORM in \[0, 1\], sRGB decoded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stored {
    /// Reversed depth.
    pub depth: f64,
    /// Normal as the layout biases it, roughness. All zero where not lit.
    pub normal_roughness: DVec4,
    /// Base colour, metallicness.
    pub base_color_metallic: DVec4,
    /// What geometry wrote to the light target: light before exposure times `exposure * light_scale`.
    pub light: DVec3,
}

/// The nearest value that `bits` bits of UNORM can hold.
pub fn unorm(value: f64, bits: u32) -> f64 {
    let steps = f64::from((1_u32 << bits) - 1);
    (value.clamp(0.0, 1.0) * steps).round() / steps
}

/// The linear value of the nearest 8-bit sRGB code.
pub fn srgb8(value: f64) -> f64 {
    linear_from_srgb(unorm(srgb_from_linear(value.clamp(0.0, 1.0)), 8))
}

/// The nearest f32.
fn float32(value: f64) -> f64 {
    f64::from(value as f32)
}

fn each(v: DVec3, f: impl Fn(f64) -> f64) -> DVec3 {
    DVec3::new(f(v.x), f(v.y), f(v.z))
}

/// What a layout's light target holds of a value: 10 bits of \[0, 1\], or f32.
pub fn store_light(layout: Layout, scaled: DVec3) -> DVec3 {
    match layout {
        Layout::Metallic128 => each(scaled, |x| unorm(x, 10)),
        Layout::Exact => each(scaled, float32),
    }
}

/// What the light target holds after fixed-function addition of `added`. As Vulkan defines blending for UNORM,
/// the source is clamped, the sum formed, and the result rounded once.
pub fn blend_light(layout: Layout, stored: DVec3, added: DVec3) -> DVec3 {
    let source = match layout {
        Layout::Metallic128 => added.clamp(DVec3::ZERO, DVec3::ONE),
        Layout::Exact => each(added, float32),
    };
    store_light(layout, stored + source)
}

/// Writes a surface into a layout's formats. `light_factor` is `exposure * light_scale`.
pub fn encode(layout: Layout, attributes: &Attributes, light_factor: f64) -> Stored {
    let (base, metallic) = (attributes.base_color, attributes.metallic);
    let (normal, roughness) = (attributes.normal_world, attributes.roughness);
    let (normal_roughness, base_color_metallic) = match layout {
        Layout::Metallic128 => (
            each(normal * 0.5 + 0.5, |x| unorm(x, 8)).extend(unorm(roughness, 8)),
            each(base, srgb8).extend(unorm(metallic, 8)),
        ),
        Layout::Exact => {
            (each(normal, float32).extend(float32(roughness)), each(base, float32).extend(float32(metallic)))
        }
    };
    Stored {
        depth: float32(attributes.depth),
        normal_roughness: if attributes.lit { normal_roughness } else { DVec4::ZERO },
        base_color_metallic,
        light: store_light(layout, attributes.prelit * light_factor),
    }
}

/// Reads a surface back at a pixel of `view`; its position follows from depth. `light_factor` as in [`encode`].
pub fn decode(
    layout: Layout,
    stored: &Stored,
    view: &View,
    pixel: [u32; 2],
    light_factor: f64,
) -> Attributes {
    let covered = stored.depth > 0.0;
    let distance = if covered { view.distance_from_depth(stored.depth) } else { 0.0 };
    let prelit = stored.light / light_factor;
    let base_color = stored.base_color_metallic.truncate();
    let position_world = view.ray_through_pixel(pixel).at(distance);
    let unlit =
        Attributes { depth: stored.depth, position_world, base_color, prelit, ..Attributes::default() };
    let channels = stored.normal_roughness.truncate();
    if channels == DVec3::ZERO {
        return unlit;
    }
    let normal_world = match layout {
        // 8 bits do not keep the length.
        Layout::Metallic128 => (channels * 2.0 - 1.0).normalize_or_zero(),
        Layout::Exact => channels,
    };
    Attributes {
        lit: true,
        normal_world,
        roughness: stored.normal_roughness.w,
        metallic: stored.base_color_metallic.w,
        ..unlit
    }
}

/// A surface after a layout's formats: [`decode`] of [`encode`].
pub fn quantise(
    layout: Layout,
    attributes: &Attributes,
    view: &View,
    pixel: [u32; 2],
    light_factor: f64,
) -> Attributes {
    decode(layout, &encode(layout, attributes, light_factor), view, pixel, light_factor)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::testing::{camera_at, direction, perspective};
    use glam::Vec3;

    fn view() -> View {
        View::new(
            &camera_at(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, perspective(0.8, 0.1, Some(100.0))),
            [64, 64],
        )
    }

    fn surface(view: &View, pixel: [u32; 2]) -> Attributes {
        Attributes {
            lit: true,
            depth: view.depth_from_distance(4.2),
            position_world: view.ray_through_pixel(pixel).at(4.2),
            normal_world: direction(0.7, 1.1),
            roughness: 0.333,
            base_color: DVec3::new(0.01, 0.25, 0.9),
            metallic: 0.6,
            prelit: DVec3::new(0.1, 0.2, 0.05),
        }
    }

    #[test]
    fn codes_are_vulkans() {
        assert_eq!(unorm(0.5, 8), 128.0 / 255.0);
        assert_eq!(unorm(1.7, 10), 1.0);
        assert_eq!(unorm(-1.0, 10), 0.0);
        assert_eq!(unorm(0.499 / 1023.0, 10), 0.0);
        assert_eq!(unorm(0.501 / 1023.0, 10), 1.0 / 1023.0);
        // Mid grey of 18 % light is sRGB code 118 (117.7 by IEC 61966-2-1).
        assert!((srgb_from_linear(srgb8(0.18)) * 255.0 - 118.0).abs() < 1e-6);
    }

    #[test]
    fn metallic128_errs_by_half_a_step_at_most() {
        let (view, pixel) = (view(), [10, 50]);
        let exact = surface(&view, pixel);
        let stored = quantise(Layout::Metallic128, &exact, &view, pixel, 1.0);
        assert!((stored.roughness - exact.roughness).abs() <= 0.5 / 255.0);
        assert!((stored.metallic - exact.metallic).abs() <= 0.5 / 255.0);
        assert!((stored.prelit - exact.prelit).abs().max_element() <= 0.5 / 1023.0);
        for k in 0..3 {
            let encoded = |c: DVec3| srgb_from_linear(c[k]);
            assert!((encoded(stored.base_color) - encoded(exact.base_color)).abs() <= 0.5 / 255.0 + 1e-12);
        }
        // Each axis is off by at most a step of 2/255, halved; the angle by at most 0.39 degrees.
        let degrees = stored.normal_world.angle_between(exact.normal_world).to_degrees();
        assert!(degrees > 1e-3 && degrees < 0.39, "{degrees}");
        // Reversed f32 depth: a relative step of 2^-24 in depth is one in distance where the far plane is far.
        let off = (stored.position_world - exact.position_world).length();
        assert!(off > 0.0 && off < 4.2 * 2.0_f64.powi(-23), "{off}");
    }

    #[test]
    fn exact_errs_by_a_float_step() {
        let (view, pixel) = (view(), [33, 3]);
        let exact = surface(&view, pixel);
        let stored = quantise(Layout::Exact, &exact, &view, pixel, 4.0);
        let step = 2.0_f64.powi(-23);
        assert!((stored.normal_world - exact.normal_world).length() < step);
        assert!((stored.base_color - exact.base_color).length() < step);
        assert!((stored.prelit - exact.prelit).length() < step);
        assert_ne!(stored.roughness, exact.roughness);
        assert!((stored.roughness - exact.roughness).abs() < step);
    }

    #[test]
    fn what_is_not_lit_reads_back_so() {
        let view = view();
        let unlit = Attributes { lit: false, ..surface(&view, [1, 1]) };
        for &layout in Layout::ALL {
            let stored = encode(layout, &unlit, 1.0);
            assert_eq!(stored.normal_roughness, DVec4::ZERO);
            assert!(stored.depth > 0.0);
            assert!(!decode(layout, &stored, &view, [1, 1], 1.0).lit);
            let background = encode(layout, &Attributes::default(), 1.0);
            assert_eq!(background, Stored::default());
        }
    }

    #[test]
    fn the_light_target_saturates_and_rounds_once() {
        let step = 1.0 / 1023.0;
        let stored = store_light(Layout::Metallic128, DVec3::splat(10.0 * step));
        // Two additions of 0.4 steps by one blend each are lost; one of 0.8 is not.
        let blend = |s, x: f64| blend_light(Layout::Metallic128, s, DVec3::splat(x * step));
        assert_eq!(blend(blend(stored, 0.4), 0.4), stored);
        assert_eq!(blend(stored, 0.8), DVec3::splat(unorm(11.0 * step, 10)));
        assert_eq!(blend(stored, 5000.0), DVec3::ONE);
        assert_eq!(blend_light(Layout::Exact, DVec3::splat(0.5), DVec3::splat(5000.0)), DVec3::splat(5000.5));
    }
}
