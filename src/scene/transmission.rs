//! Surfaces that light goes through: water, coloured glass.

use glam::{DVec3, Vec3};

/// What is behind a smooth surface of a material that fills the space behind it, and absorbs light on its way through it
/// (KHR_materials_transmission, KHR_materials_volume, KHR_materials_ior).
///
/// The way is that of the view ray, from the surface to what is opaque behind it in the same pixel, and at most as long as
/// [`Self::thickness_m`]. Of what is behind arrives, in each channel, the factor times the base colour, times what the way leaves
/// (Beer and Lambert), times what the surface does not reflect (Schlick 1994). Cameras are outside of what fills the space; where
/// several such surfaces lie over each other, each takes its whole way. Where a frame refracts (the
/// option `refraction`) it is the way of the ray that the surface bends, as far as the picture shows what that meets, and the nearest surface shows nothing of the others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transmission {
    /// The share of light that enters and is not scattered back as diffuse light: 0 to 1.
    pub factor: f32,
    /// Index of refraction, at least 1; that of the other side is 1. It decides how much is reflected head-on: ((n - 1) / (n + 1))^2.
    pub ior: f32,
    /// The longest way through, metres of the world, at least 0; 0 is a thin pane that absorbs nothing.
    pub thickness_m: f32,
    /// What is left of white light after [`Self::attenuation_distance_m`]: linear Rec.709, 0 to 1.
    pub attenuation_color: Vec3,
    /// Metres, above 0; infinity absorbs nothing.
    pub attenuation_distance_m: f32,
}

impl Default for Transmission {
    /// As of the extensions: a thin pane of glass that transmits nothing.
    fn default() -> Self {
        Self {
            factor: 0.0,
            ior: 1.5,
            thickness_m: 0.0,
            attenuation_color: Vec3::ONE,
            attenuation_distance_m: f32::INFINITY,
        }
    }
}

impl Transmission {
    /// What is absorbed of each channel on the first of many metres, per metre: -ln(colour) / distance (KHR_materials_volume). Colours
    /// of 0 count as a millionth.
    pub fn absorption_per_m(&self) -> DVec3 {
        const LEAST: f64 = 1e-6;
        let color = self.attenuation_color.as_dvec3().max(DVec3::splat(LEAST));
        -color.map(f64::ln) / f64::from(self.attenuation_distance_m)
    }

    /// The share of light that a way of so many metres leaves.
    pub fn left_after(&self, way_m: f64) -> DVec3 {
        (-self.absorption_per_m() * way_m.min(f64::from(self.thickness_m))).exp()
    }

    /// Whether light goes on in another direction behind the surface: a thin pane has another surface that bends it back
    /// (KHR_materials_volume).
    pub fn bends(&self) -> bool {
        self.thickness_m > 0.0 && self.ior > 1.0
    }

    /// Reflectance at normal incidence.
    pub fn f0(&self) -> f64 {
        let n = f64::from(self.ior);
        ((n - 1.0) / (n + 1.0)).powi(2)
    }

    /// What is wrong with its numbers.
    pub(crate) fn problem(&self) -> Option<&'static str> {
        let is_share = |v: f32| (0.0..=1.0).contains(&v);
        if !is_share(self.factor) || !self.attenuation_color.to_array().into_iter().all(is_share) {
            Some("the transmission or a channel of the attenuation colour is not from 0 to 1")
        } else if !(self.ior >= 1.0 && self.ior.is_finite()) {
            Some("the index of refraction is not finite or below 1")
        } else if !(self.thickness_m >= 0.0 && self.thickness_m.is_finite()) {
            Some("the thickness is not finite or negative")
        } else if self.attenuation_distance_m.is_nan() || self.attenuation_distance_m <= 0.0 {
            Some("the attenuation distance is not above 0")
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_colour_is_left_after_the_distance() {
        let color = Vec3::new(0.5, 0.25, 1.0);
        let water = Transmission {
            attenuation_color: color,
            attenuation_distance_m: 2.0,
            thickness_m: 10.0,
            ..Transmission::default()
        };
        assert!(water.left_after(2.0).abs_diff_eq(color.as_dvec3(), 1e-12));
        assert!(water.left_after(4.0).abs_diff_eq((color * color).as_dvec3(), 1e-12));
        assert_eq!(water.left_after(1e9), water.left_after(10.0), "no longer than it is thick");
        assert_eq!(Transmission::default().left_after(f64::INFINITY), DVec3::ONE);
        assert!((Transmission { ior: 1.5, ..water }.f0() - 0.04).abs() < 1e-12);
        assert!(Transmission { attenuation_color: Vec3::ZERO, ..water }.left_after(3.0).is_finite());
    }

    #[test]
    fn numbers_that_mean_nothing_are_told() {
        let good = Transmission::default();
        assert_eq!(good.problem(), None);
        for bad in [
            Transmission { factor: 1.5, ..good },
            Transmission { ior: 0.5, ..good },
            Transmission { ior: f32::NAN, ..good },
            Transmission { thickness_m: f32::INFINITY, ..good },
            Transmission { attenuation_color: Vec3::splat(-0.1), ..good },
            Transmission { attenuation_distance_m: 0.0, ..good },
        ] {
            assert!(bad.problem().is_some(), "{bad:?}");
        }
    }
}
