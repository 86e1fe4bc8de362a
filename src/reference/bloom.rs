//! Light that lens and eye scatter around bright places.
//!
//! Glare falls with the square of the angle from its source (Stiles and Holladay; CIE 146:2002), so that each doubling of the angle
//! brings as much light as the one before: sizes that halve from one to the next, all with the same weight. Each size is made of
//! the one before it by a filter whose weights add up to 1, and brought back by another (Jimenez, "Next Generation Post Processing
//! in Call of Duty: Advanced Warfare", SIGGRAPH 2014), so that light is moved and none added, but for what lies beyond the edge of
//! the picture, which counts as what is on it. There is no threshold: lenses have none.

use glam::DVec3;

/// Linear light, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// `size[0] * size[1]` of them.
    pub pixels: Vec<DVec3>,
}

impl Light {
    fn from_fn(size: [usize; 2], pixel: impl Fn(usize, usize) -> DVec3) -> Self {
        let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
        Self { size, pixels: pixels.map(|(x, y)| pixel(x, y)).collect() }
    }

    /// The pixel there, or the nearest on the edge.
    fn at(&self, x: i64, y: i64) -> DVec3 {
        let [x, y] = [(x, self.size[0]), (y, self.size[1])].map(|(v, n)| v.clamp(0, n as i64 - 1) as usize);
        self.pixels[y * self.size[0] + x]
    }

    /// Interpolated between pixel centres, which are at halves.
    pub fn sample(&self, x: f64, y: f64) -> DVec3 {
        let ([x, y], half) = ([x - 0.5, y - 0.5], |v: f64| (v.floor() as i64, v - v.floor()));
        let ((x, fx), (y, fy)) = (half(x), half(y));
        let row = |y: i64| self.at(x, y).lerp(self.at(x + 1, y), fx);
        row(y).lerp(row(y + 1), fy)
    }

    fn half_size(&self) -> [usize; 2] {
        self.size.map(|side| side.div_ceil(2))
    }
}

/// The mean of the four pixels that each pixel of half the size takes the place of.
pub fn first(light: &Light) -> Light {
    Light::from_fn(light.half_size(), |x, y| {
        let [x, y] = [2 * x as i64, 2 * y as i64];
        (light.at(x, y) + light.at(x + 1, y) + light.at(x, y + 1) + light.at(x + 1, y + 1)) / 4.0
    })
}

/// Five overlapping squares of 4 x 4 pixels of which the one in the middle has half the weight (Jimenez 2014).
pub fn down(light: &Light) -> Light {
    Light::from_fn(light.half_size(), |x, y| {
        let square = |dx: f64, dy: f64| {
            let tap = |sx: f64, sy: f64| {
                light.sample(2.0 * x as f64 + 1.0 + dx + sx, 2.0 * y as f64 + 1.0 + dy + sy)
            };
            (tap(-1.0, -1.0) + tap(1.0, -1.0) + tap(-1.0, 1.0) + tap(1.0, 1.0)) / 4.0
        };
        let corners = square(-1.0, -1.0) + square(1.0, -1.0) + square(-1.0, 1.0) + square(1.0, 1.0);
        square(0.0, 0.0) * 0.5 + corners * 0.125
    })
}

/// A tent over 3 x 3 pixels of the smaller image, for each pixel of one of `size`.
pub fn up(smaller: &Light, size: [usize; 2]) -> Light {
    Light::from_fn(size, |x, y| {
        let [cx, cy] = [x, y].map(|v| (v as f64 + 0.5) / 2.0);
        let weights = [(-1.0, 0.25), (0.0, 0.5), (1.0, 0.25)];
        let terms = weights.into_iter().flat_map(|a| weights.map(|b| (a, b)));
        terms.map(|((dx, wx), (dy, wy))| smaller.sample(cx + dx, cy + dy) * (wx * wy)).sum()
    })
}

/// All light of `light` scattered over this many sizes, at half the size.
pub fn scattered(light: &Light, levels: usize) -> Light {
    let mut sizes = vec![first(light)];
    for _ in 1..levels {
        let next = down(&sizes[sizes.len() - 1]);
        sizes.push(next);
    }
    let mut sum = sizes.pop().expect("there is a first");
    let mut summed = 1.0;
    while let Some(size) = sizes.pop() {
        let spread = up(&sum, size.size);
        let share = summed / (summed + 1.0);
        let mixed = size.pixels.iter().zip(&spread.pixels).map(|(own, wider)| own.lerp(*wider, share));
        sum = Light { size: size.size, pixels: mixed.collect() };
        summed += 1.0;
    }
    sum
}

/// `light` with this share of it replaced by light that was scattered, interpolated from half the size.
pub fn mixed(light: &Light, scattered: &Light, share: f64) -> Light {
    Light::from_fn(light.size, |x, y| {
        let [sx, sy] = [x, y].map(|v| (v as f64 + 0.5) / 2.0);
        light.pixels[y * light.size[0] + x].lerp(scattered.sample(sx, sy), share)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spot(size: [usize; 2], at: [usize; 2]) -> Light {
        Light::from_fn(size, |x, y| if [x, y] == at { DVec3::ONE } else { DVec3::ZERO })
    }

    fn sum(light: &Light) -> f64 {
        light.pixels.iter().map(|p| p.x).sum()
    }

    /// Far from the edges nothing is lost or gained, in any size: half the size has a quarter of the pixels.
    #[test]
    fn light_is_moved_and_none_added() {
        let light = spot([256, 192], [121, 93]);
        let scattered = scattered(&light, 4);
        assert!((sum(&scattered) * 4.0 - 1.0).abs() < 1e-12, "{}", sum(&scattered));
        let mixed = mixed(&light, &scattered, 0.3);
        assert!((sum(&mixed) - 1.0).abs() < 1e-12, "{}", sum(&mixed));
        assert!(mixed.pixels.iter().all(|p| p.x >= 0.0));
        // What is even stays even, up to the edges and for odd sizes.
        let even = Light::from_fn([37, 23], |_, _| DVec3::splat(2.5));
        assert!(super::scattered(&even, 3).pixels.iter().all(|p| (p.x - 2.5).abs() < 1e-12));
    }

    /// Rings of twice the radius bring about the same light: glare by the square of the angle.
    #[test]
    fn each_doubling_of_the_angle_brings_as_much_light() {
        let (size, center) = ([1024, 1024], [512, 512]);
        let scattered = scattered(&spot(size, center), 7);
        let ring = |from: f64, to: f64| -> f64 {
            let radius = |i: usize| {
                let [x, y] =
                    [i % scattered.size[0], i / scattered.size[0]].map(|v| 2.0 * v as f64 + 1.0 - 512.5);
                x.hypot(y)
            };
            let pixels = scattered.pixels.iter().enumerate();
            pixels.filter(|(i, _)| (from..to).contains(&radius(*i))).map(|(_, p)| p.x).sum()
        };
        let rings: Vec<_> = [4.0, 8.0, 16.0, 32.0].map(|r| ring(r, 2.0 * r)).into();
        for pair in rings.windows(2) {
            assert!((0.7..1.4).contains(&(pair[1] / pair[0])), "{rings:?}");
        }
    }
}
