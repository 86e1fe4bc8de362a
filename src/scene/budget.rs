//! How many lights and shadows a scene may have.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use super::{Aabb, Light, LightKind, Scene};

impl Scene {
    /// As many lights cast shadows where nobody says otherwise.
    pub const DEFAULT_SHADOWS: usize = 8;

    /// The scene with no light casting a shadow.
    pub fn without_shadows(mut self) -> Self {
        self.lights.iter_mut().for_each(|light| light.shadow = None);
        self
    }

    /// Keeps the most important lights: removes lights beyond `max_lights` and shadows beyond `max_shadows` (a point
    /// light's counts as one). `None` is no limit. Adds a warning for either.
    ///
    /// Lights of higher [`priority`](Light::priority) come first, then those that bring the scene more light as
    /// [`contribution_lm`](Light::contribution_lm) estimates it, then those that come first in `lights`. Their order in
    /// `lights` stays. Dark lights are not counted, and go where any must.
    pub fn keep_lights(&mut self, max_lights: Option<usize>, max_shadows: Option<usize>) {
        let bounds = self.bounds_world();
        let shining = self.lights.iter().filter(|light| !light.is_dark()).count();
        if let Some(most) = max_lights.filter(|&most| most < shining) {
            let keep = most_important(&self.lights, bounds, most, |light| !light.is_dark());
            let mut index = 0..;
            self.lights.retain(|_| index.next().is_some_and(|i| keep[i]));
            self.motion.iter_mut().for_each(|motion| motion.keep_lights(&keep));
            let n = shining - most;
            self.warnings.push(format!(
                "scene: {n} of {shining} lights {} left out, the least important: at most {most} are allowed",
                if n == 1 { "was" } else { "were" }
            ));
        }
        let casts = |light: &Light| light.shadow.is_some() && !light.is_dark();
        let casting = self.lights.iter().filter(|light| casts(light)).count();
        if let Some(most) = max_shadows.filter(|&most| most < casting) {
            let keep = most_important(&self.lights, bounds, most, casts);
            for (light, _) in self.lights.iter_mut().zip(keep).filter(|(_, keep)| !keep) {
                light.shadow = None;
            }
            let n = casting - most;
            self.warnings.push(format!(
                "scene: {n} of {casting} lights with shadows cast{} none, the least important: at most {most} may",
                if n == 1 { "s" } else { "" }
            ));
        }
    }
}

/// For each light whether it is among the `most` most important of those wanted.
fn most_important(
    lights: &[Light],
    bounds: Option<Aabb>,
    most: usize,
    wanted: impl Fn(&Light) -> bool,
) -> Vec<bool> {
    let mut order: Vec<_> = (0..lights.len()).filter(|&i| wanted(&lights[i])).collect();
    let key = |i: usize| (lights[i].priority, lights[i].contribution_lm(bounds));
    // Stable: of equals, the first stays first.
    order.sort_by(|&a, &b| {
        let ((priority_a, light_a), (priority_b, light_b)) = (key(a), key(b));
        priority_b.total_cmp(&priority_a).then(light_b.total_cmp(&light_a))
    });
    let mut keep = vec![false; lights.len()];
    order.iter().take(most).for_each(|&i| keep[i] = true);
    keep
}

impl Light {
    /// An estimate of the light that it brings to a scene with these bounds, in lumens: its luminous flux, of endless
    /// lights the part through the bounds' sphere; times the share of that sphere's cross-section that its range
    /// covers, and 0 if it does not reach the sphere. Occlusion, globe maps and the camera are not considered.
    pub fn contribution_lm(&self, bounds: Option<Aabb>) -> f64 {
        let bounds = bounds.unwrap_or(Aabb { min: Vec3::splat(-1.0), max: Vec3::ONE });
        let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        let (center, radius) = ((min + max) * 0.5, (max - min).length() * 0.5);
        let amount = f64::from(self.intensity()) * luminance(self.color);
        let both = match self.has_back() {
            true => amount + f64::from(self.intensity()) * luminance(self.back_color),
            false => amount,
        };
        let cross_section = PI * radius * radius;
        let distance = self.position_world.as_dvec3().distance(center);
        let covered = |reach: f64| match reach {
            _ if distance > reach + radius => 0.0,
            _ if reach >= radius => 1.0,
            _ => (reach / radius).powi(2),
        };
        let in_range = || self.range_m.map_or(1.0, |range| covered(f64::from(range)));
        match self.kind {
            LightKind::Directional { .. } | LightKind::Hemisphere { .. } => both * cross_section,
            LightKind::Point { .. } => amount * 2.0 * TAU * in_range(),
            LightKind::Spot { outer_cone_rad, .. } => {
                amount * TAU * (1.0 - f64::from(outer_cone_rad).cos()) * in_range()
            }
            LightKind::Box { size_m, .. } => {
                let size = size_m.as_dvec3();
                let reaches = distance <= radius + size.length() * 0.5;
                if reaches { both * (size.x * size.y).min(cross_section) } else { 0.0 }
            }
        }
    }
}

/// Relative luminance of linear Rec.709 (ITU-R BT.709-6, item 3.2).
fn luminance(color: Vec3) -> f64 {
    color.as_dvec3().dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Shadow;

    fn lamp(name: &str, intensity_cd: f32, priority: f32) -> Light {
        let shadow = Some(Shadow::default());
        Light { name: name.into(), priority, shadow, ..Light::new(LightKind::Point { intensity_cd }) }
    }

    fn names(scene: &Scene) -> Vec<&str> {
        scene.lights.iter().map(|l| l.name.as_str()).collect()
    }

    #[test]
    fn priority_counts_before_light_and_place_last() {
        let dark = lamp("dark", 0.0, 9.0);
        let lights =
            vec![dark, lamp("a", 1.0, 0.0), lamp("b", 2.0, 0.0), lamp("c", 2.0, 0.0), lamp("d", 0.5, 1.0)];
        let scene = Scene { lights, ..Scene::default() };
        let kept = |most| {
            let mut scene = scene.clone();
            scene.keep_lights(Some(most), None);
            (names(&scene).concat(), scene.warnings)
        };
        assert_eq!(kept(4), ("darkabcd".into(), vec![]));
        assert_eq!(kept(2).0, "bd");
        assert_eq!(kept(1).0, "d");
        assert_eq!(kept(0).0, "");
        let left_out = "scene: 1 of 4 lights was left out, the least important: at most 3 are allowed";
        assert_eq!(kept(3), ("bcd".into(), vec![left_out.into()]));
    }

    #[test]
    fn shadows_go_where_lights_stay() {
        let mut scene = Scene { lights: vec![lamp("a", 1.0, 0.0), lamp("b", 2.0, 0.0)], ..Scene::default() };
        scene.lights.push(Light { shadow: None, ..lamp("c", 9.0, 9.0) });
        scene.keep_lights(None, Some(1));
        let shadows: Vec<_> = scene.lights.iter().map(|l| l.shadow.is_some()).collect();
        assert_eq!(shadows, [false, true, false]);
        let text = "scene: 1 of 2 lights with shadows casts none, the least important: at most 1 may";
        assert_eq!(scene.warnings, [text]);
        assert!(scene.without_shadows().lights.iter().all(|l| l.shadow.is_none()));
    }

    #[test]
    fn contributions_are_lumens_within_reach() {
        // A sphere of radius 5 around the origin.
        let bounds = Some(Aabb { min: Vec3::new(-3.0, 0.0, -4.0), max: Vec3::new(3.0, 0.0, 4.0) });
        let lumens = |light: &Light| light.contribution_lm(bounds);
        let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-6;
        assert!(close(lumens(&lamp("", 1.0, 0.0)), 4.0 * PI));
        let sun = Light::new(LightKind::Directional { illuminance_lx: 2.0 });
        assert!(close(lumens(&sun), 50.0 * PI));
        let spot = |cone| LightKind::Spot { intensity_cd: 1.0, inner_cone_rad: 0.0, outer_cone_rad: cone };
        assert!(close(lumens(&Light::new(spot(std::f32::consts::FRAC_PI_2))), 2.0 * PI));
        let near = Light { range_m: Some(1.0), ..lamp("", 1.0, 0.0) };
        assert!(close(lumens(&near), 4.0 * PI / 25.0));
        assert_eq!(lumens(&Light { position_world: Vec3::X * 6.1, ..near }), 0.0);
        let kind = LightKind::Box { illuminance_lx: 3.0, size_m: Vec3::new(2.0, 4.0, 9.0), falloff_m: 0.0 };
        let window = Light { back_color: Vec3::ONE, ..Light::new(kind) };
        assert!(close(lumens(&window), 48.0));
        assert_eq!(lumens(&Light { position_world: Vec3::X * 11.0, ..window }), 0.0);
    }

    #[test]
    fn senseless_lights_are_dark() {
        let kinds = [
            LightKind::Directional { illuminance_lx: 1.0 },
            LightKind::Point { intensity_cd: 1.0 },
            LightKind::Spot { intensity_cd: 1.0, inner_cone_rad: 0.1, outer_cone_rad: 0.2 },
            LightKind::Box { illuminance_lx: 1.0, size_m: Vec3::ONE, falloff_m: 0.1 },
            LightKind::Hemisphere { illuminance_lx: 1.0 },
        ];
        for light in kinds.map(Light::new) {
            assert!(!light.is_dark(), "{light:?}");
            for color in [Vec3::ZERO, -Vec3::ONE, Vec3::new(1.0, -0.1, 1.0), Vec3::NAN, Vec3::INFINITY] {
                assert!(Light { color, ..light.clone() }.is_dark(), "{color} {light:?}");
            }
            assert!(Light { position_world: Vec3::NAN, ..light.clone() }.is_dark());
            let behind = Light { color: Vec3::ZERO, back_color: Vec3::X, ..light };
            assert_eq!(behind.is_dark(), !behind.has_back(), "{behind:?}");
        }
        for range in [0.0, -1.0, f32::NAN] {
            assert!(Light { range_m: Some(range), ..lamp("", 1.0, 0.0) }.is_dark());
        }
        for (size_m, falloff_m) in [(Vec3::new(1.0, 0.0, 1.0), 0.0), (Vec3::ONE, -0.1), (Vec3::ONE, f32::NAN)]
        {
            assert!(Light::new(LightKind::Box { illuminance_lx: 1.0, size_m, falloff_m }).is_dark());
        }
    }
}
