//! Light from far away: from all around alike, and an environment's.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec3};

use super::Random;
use crate::environment::{Lookup, Panorama, direction_from_uv, uv_from_direction};
use crate::scene::{Environment, Scene};

/// Directions are drawn from this many columns at most, and half as many rows: a sun fills about one of the cells.
const MOST_COLUMNS: usize = 512;

/// What arrives where nothing is in the way.
pub struct FarLight {
    ambient_nt: DVec3,
    environment: Option<Sky>,
}

/// An environment, and how often directions are drawn: each cell of a grid over its picture in proportion to the light
/// in it, and within alike everywhere.
struct Sky {
    environment: Environment,
    /// Where only the prefiltered environment is at hand: its sharpest level.
    lookup: Option<Lookup>,
    columns: usize,
    /// Sums of weights up to and with each cell, row by row.
    sums: Vec<f64>,
}

impl FarLight {
    pub fn new(scene: &Scene) -> Self {
        let lit = scene.environment.as_ref().filter(|environment| !environment.is_dark());
        Self { ambient_nt: scene.ambient_nt.as_dvec3(), environment: lit.map(Sky::new) }
    }

    /// Whether nothing arrives.
    pub fn is_dark(&self) -> bool {
        self.ambient_nt == DVec3::ZERO && self.environment.is_none()
    }

    /// Radiance from all directions alike, in cd/m²; no directions are drawn for it.
    pub fn ambient_nt(&self) -> DVec3 {
        self.ambient_nt
    }

    /// Radiance from this direction besides, in cd/m².
    pub fn radiance(&self, direction: DVec3) -> DVec3 {
        self.environment.as_ref().map_or(DVec3::ZERO, |sky| sky.radiance(direction))
    }

    /// A direction from which much light may come, world space; `None` if there is no environment.
    pub fn draw(&self, random: &mut Random) -> Option<DVec3> {
        self.environment.as_ref().map(|sky| sky.draw(random))
    }

    /// How densely [`Self::draw`] fills the sphere around this direction, per steradian.
    pub fn density(&self, direction: DVec3) -> f64 {
        self.environment.as_ref().map_or(0.0, |sky| sky.density(direction))
    }
}

impl Sky {
    fn new(environment: &Environment) -> Self {
        let lookup = match &environment.panorama {
            Some(_) => None,
            None => environment.prefiltered.as_deref().map(Lookup::new),
        };
        let columns = environment.panorama.as_ref().map_or(128, |p| p.width() as usize).min(MOST_COLUMNS);
        let mut sky = Self { environment: environment.clone(), lookup, columns, sums: Vec::new() };
        let mut sum = 0.0;
        for cell in 0..columns * (columns / 2) {
            sum += sky.brightness(cell) * sky.solid_angle(cell / columns);
            sky.sums.push(sum);
        }
        sky
    }

    /// The light in a cell as the bilinear filter spreads it.
    fn brightness(&self, cell: usize) -> f64 {
        let (x, y) = (cell % self.columns, cell / self.columns);
        let Some(picture) = &self.environment.panorama else {
            let rows = self.columns as f64 / 2.0;
            let at = |i: f64, j: f64| [(x as f64 + i) / self.columns as f64, (y as f64 + j) / rows];
            let places = [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0), at(1.0, 1.0), at(0.5, 0.5)];
            return places.map(|uv| self.of_picture(direction_from_uv(uv)).element_sum()).iter().sum();
        };
        let (width, height) = (picture.width() as i64, picture.height() as i64);
        let texels = width / self.columns as i64;
        // An eighth of a texel's tent lies beyond either side.
        let share = |i: i64| match i {
            _ if i == -1 || i == texels => 0.125,
            _ => 1.0 - 0.125 * f64::from(u8::from(i == 0) + u8::from(i == texels - 1)),
        };
        let mut sum = 0.0;
        for (i, j) in (-1..=texels).flat_map(|j| (-1..=texels).map(move |i| (i, j))) {
            let column = (x as i64 * texels + i).rem_euclid(width);
            let row = (y as i64 * texels + j).clamp(0, height - 1);
            let texel = picture.texels()[(row * width + column) as usize];
            sum += f64::from(texel.element_sum()) * share(i) * share(j);
        }
        sum
    }

    /// Of one cell in this row, steradians.
    fn solid_angle(&self, row: usize) -> f64 {
        let step = TAU / self.columns as f64;
        let edge = |row: usize| (step * row as f64).cos();
        step * (edge(row) - edge(row + 1))
    }

    fn of_picture(&self, direction: DVec3) -> DVec3 {
        match (&self.environment.panorama, &self.lookup) {
            (Some(panorama), _) => Panorama::radiance(panorama, direction),
            (None, Some(lookup)) => lookup.radiance(direction, 0.0),
            (None, None) => DVec3::ZERO,
        }
    }

    fn radiance(&self, direction: DVec3) -> DVec3 {
        let local = self.environment.environment_from_world(direction);
        self.of_picture(local) * f64::from(self.environment.intensity)
    }

    fn draw(&self, random: &mut Random) -> DVec3 {
        let wanted = random.next() * self.sums.last().copied().unwrap_or(0.0);
        let cell = self.sums.partition_point(|sum| *sum <= wanted).min(self.sums.len() - 1);
        let (x, y) = (cell % self.columns, cell / self.columns);
        let step = TAU / self.columns as f64;
        let (top, bottom) = ((step * y as f64).cos(), (step * (y + 1) as f64).cos());
        let theta = (top + (bottom - top) * random.next()).clamp(-1.0, 1.0).acos();
        let local = direction_from_uv([(x as f64 + random.next()) / self.columns as f64, theta / PI]);
        let turn = f64::from(self.environment.rotation_deg).to_radians();
        DQuat::from_rotation_y(turn) * local
    }

    fn density(&self, direction: DVec3) -> f64 {
        let total = self.sums.last().copied().unwrap_or(0.0);
        if total == 0.0 {
            return 0.0;
        }
        let [u, v] = uv_from_direction(self.environment.environment_from_world(direction));
        let rows = self.columns / 2;
        let (x, y) = ((u * self.columns as f64) as usize, (v * rows as f64) as usize);
        let cell = y.min(rows - 1) * self.columns + x.min(self.columns - 1);
        let before = if cell == 0 { 0.0 } else { self.sums[cell - 1] };
        (self.sums[cell] - before) / total / self.solid_angle(cell / self.columns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// Dark but for a sun of one texel and a dim floor, turned.
    fn sky() -> Sky {
        let (width, height) = (64, 32);
        let texel = |i: u32| match (i % width, i / width) {
            (40, 9) => Vec3::new(4000.0, 3000.0, 1000.0),
            (_, row) if row >= height / 2 => Vec3::splat(0.2),
            _ => Vec3::ZERO,
        };
        let panorama = Panorama::new(width, height, (0..width * height).map(texel).collect()).unwrap();
        Sky::new(&Environment { rotation_deg: 70.0, intensity: 0.5, ..Environment::new("test", panorama) })
    }

    #[test]
    fn drawn_directions_have_the_stated_density() {
        let sky = sky();
        let mut random = Random::new(1);
        // The mean of 1 / density is the solid angle of all that can be drawn, and of radiance / density the sphere's integral.
        let count = 40_000;
        let mut integral = DVec3::ZERO;
        for _ in 0..count {
            let direction = sky.draw(&mut random);
            assert!((direction.length() - 1.0).abs() < 1e-12);
            integral += sky.radiance(direction) / sky.density(direction) / f64::from(count);
        }
        let steps = 1000;
        let mut expected = DVec3::ZERO;
        for i in 0..steps * steps / 2 {
            let (u, v) = (
                (f64::from(i % steps) + 0.5) / f64::from(steps),
                (f64::from(i / steps) + 0.5) * 2.0 / f64::from(steps),
            );
            let texel = TAU / f64::from(steps) * 2.0 * PI / f64::from(steps) * (PI * v).sin();
            expected += sky.radiance(direction_from_uv([u, v])) * texel;
        }
        assert!(((integral - expected) / expected).abs().max_element() < 0.01, "{integral} {expected}");
        // Nearly all light is the sun's, and so are the directions.
        let sun = DQuat::from_rotation_y(70_f64.to_radians()) * direction_from_uv([40.5 / 64.0, 9.5 / 32.0]);
        let near = (0..1000).filter(|_| sky.draw(&mut random).dot(sun) > 0.97).count();
        assert!(near > 800, "{near}");
    }
}
