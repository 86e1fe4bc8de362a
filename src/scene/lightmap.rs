//! Light that was computed ahead for surfaces that do not move.

use glam::{DVec3, Vec2};

use crate::environment::TexelFormat;

/// Diffuse light on the scene's surfaces, by TEXCOORD_1: irradiance, encoded as Smith and Einig 2015 ("Physically Based Deferred
/// Shading on Mobile", listing 2.5) do it, in a colour texture and one with a scale (RGBM: Karis 2009).
///
/// The two are apart so that the colours may be compressed in blocks, where errors of the scale would show. Square
/// roots are stored, so that steps are finer in the dark.
#[derive(Clone, Debug, PartialEq)]
pub struct Lightmap {
    /// Texels, at least 1.
    pub width: u32,
    /// Texels, at least 1.
    pub height: u32,
    /// `width * height * 4` bytes, rows from the top: the light's colour; the fourth byte means nothing.
    pub color_rgba8: Vec<u8>,
    /// `width * height` bytes: the scale M.
    pub scale8: Vec<u8>,
    /// Irradiance in lux of the decoded value 1. The largest that can be held is [`Self::RGBM_SCALE`]² times this.
    pub unit_lx: f32,
}

/// An instance's part of the lightmap, in texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightmapRect {
    /// Where TEXCOORD_1 = (0, 0) lies.
    pub origin: Vec2,
    /// From there to where TEXCOORD_1 = (1, 1) lies.
    pub size: Vec2,
}

impl LightmapRect {
    /// Where this TEXCOORD_1 lies in the lightmap.
    pub fn uv(&self, texcoord: Vec2) -> Vec2 {
        self.origin + texcoord * self.size
    }
}

impl Lightmap {
    /// `RGBM_SCALE` of the listing: the largest decoded value is its square.
    pub const RGBM_SCALE: f32 = 6.0;

    /// Encodes irradiances in lux, rows from the top. The brightest channel is the largest value that is held; M is the least
    /// that leaves no channel above 1.
    ///
    /// # Panics
    /// If there is not one irradiance a texel, or one is negative or not finite.
    pub fn encode(width: u32, height: u32, irradiances_lx: &[DVec3]) -> Self {
        assert_eq!(irradiances_lx.len(), width as usize * height as usize, "one irradiance a texel");
        let valid = |e: &DVec3| e.is_finite() && e.min_element() >= 0.0;
        assert!(irradiances_lx.iter().all(valid), "irradiances are finite and not negative");
        let brightest = irradiances_lx.iter().map(|e| e.max_element()).fold(0.0, f64::max);
        let most = f64::from(Self::RGBM_SCALE * Self::RGBM_SCALE);
        // Any unit will do for a black map.
        let unit = if brightest > 0.0 { brightest / most } else { 1.0 };
        let byte = |x: f64| (x * 255.0).round().min(255.0) as u8;
        let mut map =
            Self { width, height, color_rgba8: Vec::new(), scale8: Vec::new(), unit_lx: unit as f32 };
        for irradiance in irradiances_lx {
            let root = (irradiance / unit).map(f64::sqrt) / f64::from(Self::RGBM_SCALE);
            let scale = (root.max_element() * 255.0).ceil().clamp(1.0, 255.0);
            let color = root * (255.0 / scale);
            map.scale8.push(scale as u8);
            map.color_rgba8.extend([byte(color.x), byte(color.y), byte(color.z), u8::MAX]);
        }
        map
    }

    /// Irradiance in lux of a colour and a scale in \[0, 1\], as a filter gives them: the listing's `RGBMSqrtDecode` times the
    /// unit.
    pub fn decode(&self, color: DVec3, scale: f64) -> DVec3 {
        let root = color * (scale * f64::from(Self::RGBM_SCALE));
        root * root * f64::from(self.unit_lx)
    }

    /// The texels as a texture of this format holds them, rows from the top, in [`Self::unit_lx`]: RGBM as it is, with the
    /// scale in the fourth channel; decoded in the others.
    pub fn texels(&self, format: TexelFormat) -> Vec<u8> {
        let mut texels = Vec::with_capacity(self.scale8.len() * format.bytes());
        for (color, &scale) in self.color_rgba8.chunks_exact(4).zip(&self.scale8) {
            let rgbm = [color[0], color[1], color[2], scale];
            match format {
                TexelFormat::Rgbm => texels.extend(rgbm),
                _ => format.encode(TexelFormat::Rgbm.decode(TexelFormat::Rgbm.load(&rgbm)), &mut texels),
            }
        }
        texels
    }

    /// Irradiance in lux of one texel.
    pub fn texel(&self, x: u32, y: u32) -> DVec3 {
        let at = y as usize * self.width as usize + x as usize;
        let [r, g, b] = [0, 1, 2].map(|k| f64::from(self.color_rgba8[at * 4 + k]) / 255.0);
        self.decode(DVec3::new(r, g, b), f64::from(self.scale8[at]) / 255.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_of_four_decades_survives_encoding() {
        /// Two roundings to 8 bits, of which the colour's may be of a value as low as a half (squared: twice the error).
        const RELATIVE: f64 = 2.0 * (0.5 / 127.0);
        let brightest = DVec3::new(90_000.0, 60_000.0, 1000.0);
        for decade in 0..=4 {
            let light = brightest * 10_f64.powi(-decade);
            let map = Lightmap::encode(3, 1, &[light, brightest, DVec3::ZERO]);
            let back = map.texel(0, 0);
            for channel in 0..3 {
                let error = (back[channel] - light[channel]).abs() / light.max_element();
                assert!(error <= RELATIVE, "{decade}: {light} {back}");
            }
            assert_eq!(map.texel(2, 0), DVec3::ZERO);
        }
        assert_eq!(Lightmap::encode(1, 1, &[DVec3::ZERO]).texel(0, 0), DVec3::ZERO);
    }

    #[test]
    fn it_is_the_listings_code() {
        let map = Lightmap { unit_lx: 1.0, ..Lightmap::encode(1, 1, &[DVec3::ONE]) };
        // (0.5 * 6 * rgb)²
        assert_eq!(map.decode(DVec3::new(1.0, 0.5, 0.0), 0.5), DVec3::new(9.0, 2.25, 0.0));
        let rect = LightmapRect { origin: Vec2::new(0.5, 0.25), size: Vec2::new(0.5, 0.25) };
        assert_eq!(rect.uv(Vec2::new(0.5, 1.0)), Vec2::new(0.75, 0.5));
    }
}
