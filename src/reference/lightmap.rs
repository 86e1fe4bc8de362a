//! Light that was computed ahead, as a surface finds it.

use glam::{DVec2, DVec3};

use crate::scene::Lightmap;

/// Irradiance in lux at a place of the map: colour and scale are filtered bilinearly, each by itself, and then decoded
/// (Smith and Einig 2015, listing 2.5). Beyond the border its texels go on.
pub fn irradiance(map: &Lightmap, uv: DVec2) -> DVec3 {
    let place = uv * DVec2::new(f64::from(map.width), f64::from(map.height)) - 0.5;
    let (base, weight) = (place.floor(), place - place.floor());
    let inside = |i: f64, n: u32| i.clamp(0.0, f64::from(n - 1)) as usize;
    let texel = |i: f64, j: f64| {
        let at = inside(j, map.height) * map.width as usize + inside(i, map.width);
        let [r, g, b] = [0, 1, 2].map(|k| f64::from(map.color_rgba8[at * 4 + k]) / 255.0);
        DVec3::new(r, g, b).extend(f64::from(map.scale8[at]) / 255.0)
    };
    let upper = texel(base.x, base.y).lerp(texel(base.x + 1.0, base.y), weight.x);
    let lower = texel(base.x, base.y + 1.0).lerp(texel(base.x + 1.0, base.y + 1.0), weight.x);
    let filtered = upper.lerp(lower, weight.y);
    map.decode(filtered.truncate(), filtered.w)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colour_and_scale_are_filtered_apart() {
        let map = Lightmap {
            width: 2,
            height: 1,
            color_rgba8: vec![255, 0, 0, 255, 0, 255, 0, 255],
            scale8: vec![51, 153],
            unit_lx: 2.0,
        };
        let at = |u: f64| irradiance(&map, DVec2::new(u, 0.7));
        assert!((at(0.25) - DVec3::new(2.0 * 1.2 * 1.2, 0.0, 0.0)).length() < 1e-12);
        // Halfway: colours of a half, a scale of 0.4.
        assert!((at(0.5) - DVec3::new(2.0 * 1.2 * 1.2, 2.0 * 1.2 * 1.2, 0.0)).length() < 1e-12);
        assert_eq!(at(-3.0), at(0.0));
    }
}
