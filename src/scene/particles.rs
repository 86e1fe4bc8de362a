//! Light without surfaces: sparks, steam, glow.

use glam::Vec3;

use super::Material;

/// Squares that face the camera and add light to what is behind them.
///
/// The light is the material's emission (factor times texture, on the square's own texture coordinates: (0, 0) is at its upper left
/// corner) times each particle's colour, in cd/m². It is added, so no order is needed, and what is behind is not dimmed: black is
/// nothing. Nothing else of the material is used. Fog dims it on its way. Particles light no surface, and lie over blended surfaces,
/// also where one is in front of them.
///
/// Where a square meets something opaque it fades by how far that is behind it, so that no line is seen where it is cut ([`Self::fade`]).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Particles {
    /// A name for messages.
    pub name: String,
    /// Index into [`super::Scene::materials`].
    pub material: usize,
    /// How far behind a particle something opaque is, and how far in front of it the near plane, at least where it is seen whole:
    /// metres along the view axis, at least 0.
    pub soft_m: f32,
    /// Those there are at first.
    pub list: Vec<Particle>,
    /// How many there may be later; no less than there are at first.
    pub most: usize,
}

/// One of [`Particles`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particle {
    /// The middle of the square.
    pub position_world: Vec3,
    /// The square's side, metres, at least 0.
    pub size_m: f32,
    /// By how much the square is turned on the image, counter-clockwise.
    pub rotation_rad: f32,
    /// Multiplies the material's emission; linear Rec.709, at least 0.
    pub color: Vec3,
}

impl Particles {
    /// Those of this list, of which there will be no more.
    pub fn new(material: usize, soft_m: f32, list: Vec<Particle>) -> Self {
        Self { name: String::new(), material, soft_m, most: list.len(), list }
    }

    /// Whether something can be seen of them with this material, which is theirs.
    pub fn shine(&self, material: &Material) -> bool {
        self.most > 0 && !material.unlit && material.emissive_factor != Vec3::ZERO
    }

    /// How much is seen of what is `before_m` in front of something else, metres: 0 to 1, without a kink at either end.
    ///
    /// Lorach 2007, "Soft Particles" (NVIDIA), the function `Contrast` with power 2, of the distance as a share of
    /// [`Self::soft_m`].
    pub fn fade(&self, before_m: f64) -> f64 {
        let share = (before_m * self.inverse_soft()).clamp(0.0, 1.0);
        let to_end = share.min(1.0 - share);
        let raised = 2.0 * to_end * to_end;
        if share > 0.5 { 1.0 - raised } else { raised }
    }

    /// 1 / [`Self::soft_m`], which is at least a tenth of a millimetre.
    pub(crate) fn inverse_soft(&self) -> f64 {
        const LEAST_M: f32 = 1e-4;
        1.0 / f64::from(self.soft_m.max(LEAST_M))
    }

    /// What is wrong with their numbers.
    pub(crate) fn numbers_problem(&self) -> Option<&'static str> {
        if !(self.soft_m >= 0.0 && self.soft_m.is_finite()) {
            Some("the soft distance is not finite or negative")
        } else if self.list.len() > self.most {
            Some("there are more than there may be")
        } else {
            self.list.iter().find_map(Particle::problem)
        }
    }
}

impl Particle {
    /// What is wrong with its numbers.
    pub(crate) fn problem(&self) -> Option<&'static str> {
        if !(self.position_world.is_finite() && self.rotation_rad.is_finite()) {
            Some("a particle's place or rotation is not finite")
        } else if !(self.size_m >= 0.0 && self.size_m.is_finite()) {
            Some("a particle's size is not finite or negative")
        } else if !(self.color.is_finite() && self.color.min_element() >= 0.0) {
            Some("a particle's colour is not finite or negative")
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fade_has_no_kink() {
        let soft = Particles::new(0, 0.5, Vec::new());
        assert_eq!(
            [-1.0, 0.0, 0.25, 0.5, 9.0, f64::INFINITY].map(|m| soft.fade(m)),
            [0.0, 0.0, 0.5, 1.0, 1.0, 1.0]
        );
        let slope = |m: f64| (soft.fade(m + 1e-6) - soft.fade(m - 1e-6)) / 2e-6;
        assert!(slope(0.0) < 1e-4 && slope(0.5) < 1e-4 && (slope(0.25) - 4.0).abs() < 1e-4);
        assert_eq!(Particles::new(0, 0.0, Vec::new()).fade(1e-4), 1.0, "hard, but no division by 0");
    }

    #[test]
    fn numbers_that_mean_nothing_are_told() {
        let good = Particle { position_world: Vec3::ZERO, size_m: 1.0, rotation_rad: 0.0, color: Vec3::ONE };
        assert_eq!(Particles::new(0, 0.1, vec![good]).numbers_problem(), None);
        assert!(Particles::new(0, f32::NAN, vec![good]).numbers_problem().is_some());
        assert!(Particles { most: 0, ..Particles::new(0, 0.1, vec![good]) }.numbers_problem().is_some());
        for bad in [
            Particle { size_m: -1.0, ..good },
            Particle { rotation_rad: f32::INFINITY, ..good },
            Particle { color: Vec3::NEG_X, ..good },
            Particle { position_world: Vec3::NAN, ..good },
        ] {
            assert!(Particles::new(0, 0.1, vec![bad]).numbers_problem().is_some(), "{bad:?}");
        }
    }
}
