//! Light that was computed ahead, as a surface finds it.
//!
//! What textures of each format cost, against the same texels filtered as f64, at places all over a wall with a shadow's edge and
//! over a map of noise (errors relative to the brightest channel, mean and what 99 % are within):
//!
//! | format | bits a texel | wall | noise over three decades |
//! |---|---|---|---|
//! | RGBM | 32 | 0.8 %, 34 % | 37 %, 84 % |
//! | B10G11R11 | 32 | 0.3 %, 0.7 % | 0.4 %, 1.2 % |
//! | E5B9G9R9 | 32 | 0.08 %, 0.15 % | 0.1 %, 0.23 % |
//! | RGBA16F | 64 | 0.016 %, 0.04 % | 0.016 %, 0.04 % |
//!
//! RGBM (Smith and Einig 2015, listing 2.5) is exact at texel centres; between them colour and scale are filtered apart and
//! then multiplied and squared. A driver that filters 8-bit textures in 8 bits, as lavapipe does, adds up to 2 % to that.
//! So lightmaps are RGBM in files and E5B9G9R9 in memory.

use glam::{DVec2, DVec3, DVec4};

use crate::environment::TexelFormat;
use crate::scene::Lightmap;

/// Look-ups in a scene's lightmap.
#[derive(Clone, Debug)]
pub struct Lookup {
    size: [u32; 2],
    unit_lx: f64,
    /// Of `texels`; `None`: light as it is.
    format: Option<TexelFormat>,
    texels: Vec<DVec4>,
}

impl Lookup {
    /// As a texture of this format gives it; `None`: each texel's light is decoded and filtered as f64.
    pub fn new(map: &Lightmap, format: Option<TexelFormat>) -> Self {
        let unit_lx = f64::from(map.unit_lx);
        let texels = match format {
            Some(format) => {
                let stored = map.texels(format);
                stored.chunks_exact(format.bytes()).map(|texel| format.load(texel).as_dvec4()).collect()
            }
            None => (0..map.width * map.height)
                .map(|i| (map.texel(i % map.width, i / map.width) / unit_lx).extend(1.0))
                .collect(),
        };
        Self { size: [map.width, map.height], unit_lx, format, texels }
    }

    /// Irradiance in lux at a place of the map: texels are blended bilinearly as they are stored, then decoded. Beyond the border
    /// its texels go on.
    pub fn irradiance(&self, uv: DVec2) -> DVec3 {
        let [width, height] = self.size;
        let place = uv * DVec2::new(f64::from(width), f64::from(height)) - 0.5;
        let (base, weight) = (place.floor(), place - place.floor());
        let inside = |i: f64, n: u32| i.clamp(0.0, f64::from(n - 1)) as usize;
        let texel = |i: f64, j: f64| self.texels[inside(j, height) * width as usize + inside(i, width)];
        let upper = texel(base.x, base.y).lerp(texel(base.x + 1.0, base.y), weight.x);
        let lower = texel(base.x, base.y + 1.0).lerp(texel(base.x + 1.0, base.y + 1.0), weight.x);
        let filtered = upper.lerp(lower, weight.y);
        let light = match self.format {
            Some(TexelFormat::Rgbm) => {
                let root = filtered.truncate() * (filtered.w * f64::from(Lightmap::RGBM_SCALE));
                root * root
            }
            _ => filtered.truncate(),
        };
        light * self.unit_lx
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rgbm_is_filtered_as_it_is_stored_and_light_as_it_is() {
        let map = Lightmap {
            width: 2,
            height: 1,
            color_rgba8: vec![255, 0, 0, 255, 0, 255, 0, 255],
            scale8: vec![51, 153],
            unit_lx: 2.0,
        };
        let rgbm = Lookup::new(&map, Some(TexelFormat::Rgbm));
        let at = |u: f64| rgbm.irradiance(DVec2::new(u, 0.7));
        let (red, green) = (2.0 * 1.2 * 1.2, 2.0 * 3.6 * 3.6);
        assert!((at(0.25) - DVec3::new(red, 0.0, 0.0)).length() < 1e-6);
        // Halfway: colours of a half, a scale of 0.4.
        assert!((at(0.5) - DVec3::new(red, red, 0.0)).length() < 1e-6);
        assert_eq!(at(-3.0), at(0.0));
        let halfway = Lookup::new(&map, None).irradiance(DVec2::new(0.5, 0.7));
        assert!((halfway - DVec3::new(red, green, 0.0) * 0.5).length() < 1e-12);
    }

    /// A wall whose light falls off, under a shadow's edge and a coloured stripe; and noise over three decades.
    fn maps() -> [(&'static str, Lightmap); 2] {
        const SIDE: u32 = 64;
        let wall = |x: f64, y: f64| {
            let falloff = DVec3::new(1.0, 0.9, 0.7) * (900.0 / (1.0 + 8.0 * (x * x + y * y)));
            let stripe = if (0.6..0.7).contains(&y) { DVec3::new(1.0, 0.2, 0.1) } else { DVec3::ONE };
            falloff * stripe * if x + 0.3 * y > 0.7 { 0.05 } else { 1.0 }
        };
        let noise = |x: f64, y: f64| {
            let of = |k: f64| ((x * 127.1 + y * 311.7 + k).sin() * 43758.5453).fract().abs();
            DVec3::new(of(0.0), of(1.0), of(2.0)).map(|v| 10_f64.powf(3.0 * v))
        };
        let map = |light: &dyn Fn(f64, f64) -> DVec3| {
            let texel = |i: u32| light(f64::from(i % SIDE) / 64.0, f64::from(i / SIDE) / 64.0);
            Lightmap::encode(SIDE, SIDE, &(0..SIDE * SIDE).map(texel).collect::<Vec<_>>())
        };
        [("wall", map(&wall)), ("noise", map(&noise))]
    }

    #[test]
    fn formats_cost_what_they_are_said_to() {
        // Mean and 99 % of the wall, and of noise.
        let bounds = [
            (TexelFormat::Rgbm, [[0.01, 0.4], [0.4, 0.9]]),
            (TexelFormat::B10G11R11, [[0.004, 0.01], [0.005, 0.015]]),
            (TexelFormat::E5B9G9R9, [[1e-3, 2e-3], [1.2e-3, 2.5e-3]]),
            (TexelFormat::Rgba16F, [[2e-4, 5e-4], [2e-4, 5e-4]]),
        ];
        for (which, (name, map)) in maps().into_iter().enumerate() {
            let truth = Lookup::new(&map, None);
            for (format, bounds) in bounds {
                let lookup = Lookup::new(&map, Some(format));
                let error = |i: u32| {
                    let uv = DVec2::new(f64::from(i) * 0.618, f64::from(i) * 0.754).fract();
                    let (light, truth) = (lookup.irradiance(uv), truth.irradiance(uv));
                    (light - truth).abs().max_element() / truth.max_element()
                };
                let mut errors: Vec<_> = (0..20_000).map(error).collect();
                errors.sort_by(f64::total_cmp);
                let mean = errors.iter().sum::<f64>() / errors.len() as f64;
                let most = errors[errors.len() * 99 / 100];
                println!("| {name} | {format} | {:.3} % | {:.2} % |", mean * 100.0, most * 100.0);
                let [most_mean, most_of_99] = bounds[which];
                assert!(mean <= most_mean && most <= most_of_99, "{name}, {format}");
            }
        }
    }
}
