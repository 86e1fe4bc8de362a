//! Fog between a surface and the viewer.

use glam::DVec3;

use crate::scene::Fog;

/// The share of light that gets from `from` to `to` (world space, metres): exp of minus the density's integral
/// over the way.
///
/// Density falls exponentially with height, so its mean over a way between the heights a and b (in scale heights over
/// the base) is (exp(-a) - exp(-b)) / (b - a): Wenzel, "Real-time Atmospheric Effects in Games", SIGGRAPH 2006 course
/// notes; Quilez, "Better fog", 2010.
pub fn transmittance(fog: &Fog, from: DVec3, to: DVec3) -> f64 {
    let optical_depth = f64::from(fog.density_per_m) * from.distance(to);
    let Some(height) = fog.height else { return (-optical_depth).exp() };
    let scaled = |y: f64| (y - f64::from(height.base_m)) / f64::from(height.scale_m);
    let (a, b) = (scaled(from.y), scaled(to.y));
    // The denser end times the mean of exp(-x) from 0 to the difference, which is 1 - x / 2 where that is small.
    let x = (b - a).abs();
    let mean = if x < 1e-5 { 1.0 - x * 0.5 } else { -(-x).exp_m1() / x };
    (-optical_depth * (-a.min(b)).exp() * mean).exp()
}

/// Exposed light of a surface at `to` as it arrives at `from`.
pub fn fogged(fog: &Fog, exposed_light: DVec3, exposure: f64, from: DVec3, to: DVec3) -> DVec3 {
    (fog.color_nt.as_dvec3() * exposure).lerp(exposed_light, transmittance(fog, from, to))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::FogHeight;
    use glam::Vec3;

    fn fog(height: Option<FogHeight>) -> Fog {
        Fog { color_nt: Vec3::new(0.5, 0.6, 0.7), density_per_m: 0.1, height }
    }

    #[test]
    fn it_is_the_integral_of_the_density() {
        let layer = fog(Some(FogHeight { base_m: 2.0, scale_m: 5.0 }));
        let eye = DVec3::new(1.0, 3.0, -2.0);
        for to in
            [[30.0, 3.0, 4.0], [30.0, 3.001, 4.0], [1.0, 90.0, -2.0], [4.0, -20.0, 9.0], [4.0, 2.9999, 9.0]]
        {
            let to = DVec3::from(to);
            let steps = 100_000;
            let density = |i: i32| {
                let y = eye.lerp(to, (f64::from(i) + 0.5) / f64::from(steps)).y;
                f64::from(layer.density_per_m) * (-(y - 2.0) / 5.0).exp()
            };
            let sum: f64 = (0..steps).map(density).sum();
            let expected = (-sum * eye.distance(to) / f64::from(steps)).exp();
            let found = transmittance(&layer, eye, to);
            assert!((found - expected).abs() < 1e-8 * expected.max(1e-8), "{to}: {found} {expected}");
            assert!((transmittance(&layer, to, eye) - found).abs() < 1e-12, "both ways alike");
        }
    }

    #[test]
    fn fog_without_height_is_the_limit_of_endless_scale() {
        let (even, tall) = (fog(None), fog(Some(FogHeight { base_m: 0.0, scale_m: 1e9 })));
        let (from, to) = (DVec3::ZERO, DVec3::new(3.0, 4.0, 12.0));
        let light = fogged(&even, DVec3::ONE, 2.0, from, to);
        let share = (-13.0 * f64::from(0.1_f32)).exp();
        let expected = DVec3::ONE * share + even.color_nt.as_dvec3() * 2.0 * (1.0 - share);
        assert!((light - expected).length() < 1e-12);
        assert!((fogged(&tall, DVec3::ONE, 2.0, from, to) - light).length() < 1e-8);
    }

    #[test]
    fn extremes_stay_finite() {
        let layer = fog(Some(FogHeight { base_m: 0.0, scale_m: 1e-3 }));
        for (from, to) in [(1e6, -1e6), (-1e6, -1e6), (1e6, 1e6), (-1e6, 1e6)] {
            let share = transmittance(&layer, DVec3::Y * from, DVec3::new(1.0, to, 0.0));
            assert!((0.0..=1.0).contains(&share), "{from} {to}: {share}");
        }
    }
}
