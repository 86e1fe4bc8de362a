//! Globe maps as one stack of pictures of one size.

use std::collections::HashMap;

use rayon::prelude::*;

use super::mipmaps::{linear_from_srgb, srgb_from_linear};
use super::{GlobePicture, Image, Scene, mipmaps};
use crate::{Error, Result};

/// The longer side of globe maps, texels: larger pictures are shrunk.
const MOST_SIDE: u32 = 1024;

/// All globe maps that a scene's lights shine through.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GlobeLayers {
    /// Width and height of every layer, texels.
    pub side: u32,
    /// `side * side * 4` bytes a layer, sRGB, one after another: of flat pictures one, of cubes six.
    pub texels: Vec<u8>,
    /// By light: the index of its first layer, if it shines through any.
    pub first_of_light: Vec<Option<u32>>,
}

impl GlobeLayers {
    /// How many layers there are.
    pub fn count(&self) -> u32 {
        (self.texels.len() / (self.side as usize * self.side as usize * 4)) as u32
    }
}

impl Scene {
    /// The globe maps of all lights that are not dark, each picture once, brought to the size of the largest (at most
    /// 1024 x 1024): linearly, in linear light.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for an index or a picture that is none.
    pub fn globe_layers(&self) -> Result<GlobeLayers> {
        let mut pictures: Vec<&Image> = Vec::new();
        let mut known: HashMap<GlobePicture, u32> = HashMap::new();
        let mut first_of_light = Vec::with_capacity(self.lights.len());
        for light in &self.lights {
            let Some(map) = light.shown_globe_map().filter(|_| !light.is_dark()) else {
                first_of_light.push(None);
                continue;
            };
            let first = match known.get(&map.picture) {
                Some(&first) => first,
                None => {
                    let first = pictures.len() as u32;
                    let images: &[usize] = match &map.picture {
                        GlobePicture::Flat { image } => std::slice::from_ref(image),
                        GlobePicture::Cube { images } => images,
                    };
                    for &image in images {
                        pictures.push(self.globe_picture(image, &light.name)?);
                    }
                    known.insert(map.picture, first);
                    first
                }
            };
            first_of_light.push(Some(first));
        }
        let longest = pictures.iter().map(|i| i.width.max(i.height)).max().unwrap_or(1);
        let side = longest.min(MOST_SIDE);
        let layers: Vec<_> = pictures.par_iter().map(|image| resized(image, side)).collect();
        Ok(GlobeLayers { side, texels: layers.concat(), first_of_light })
    }

    fn globe_picture(&self, index: usize, light: &str) -> Result<&Image> {
        let image = self.images.get(index).ok_or_else(|| {
            Error::unsupported(
                format!(
                    "light '{light}' shines through image {index}, but the scene has {}",
                    self.images.len()
                ),
                "make the scene's indices refer to what it has",
            )
        })?;
        image.check()?;
        Ok(image)
    }
}

/// The picture as `side` times `side` texels: the smallest of its mip levels that is no smaller, interpolated linearly.
fn resized(image: &Image, side: u32) -> Vec<u8> {
    if [image.width, image.height] == [side, side] {
        return image.rgba8().to_vec();
    }
    let too_large = image.width.max(image.height) > side;
    let levels = if too_large { mipmaps(image, true) } else { Vec::new() };
    let level = levels.iter().rev().find(|level| level.width.min(level.height) >= side);
    let (width, height, texels) =
        level.map_or((image.width, image.height, image.rgba8()), |l| (l.width, l.height, &l.rgba8[..]));
    let decode: [f32; 256] = std::array::from_fn(|i| linear_from_srgb(i as f64 / 255.0) as f32);
    let mut out = Vec::with_capacity(side as usize * side as usize * 4);
    for y in 0..side {
        let (above, below, down) = neighbours(y, side, height);
        for x in 0..side {
            let (left, right, across) = neighbours(x, side, width);
            for channel in 0..3 {
                let at =
                    |x: usize, y: usize| decode[usize::from(texels[(y * width as usize + x) * 4 + channel])];
                let upper = at(left, above) + (at(right, above) - at(left, above)) * across;
                let lower = at(left, below) + (at(right, below) - at(left, below)) * across;
                out.push((srgb_from_linear(upper + (lower - upper) * down) * 255.0).round() as u8);
            }
            out.push(255);
        }
    }
    out
}

/// The two texels of `from` between which texel `index` of `to` lies, and how far from the first.
fn neighbours(index: u32, to: u32, from: u32) -> (usize, usize, f32) {
    let place = (f64::from(index) + 0.5) * f64::from(from) / f64::from(to) - 0.5;
    let last = f64::from(from - 1);
    let (first, second) = (place.floor().clamp(0.0, last), (place.floor() + 1.0).clamp(0.0, last));
    (first as usize, second as usize, (place - place.floor()) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{GlobeMap, Light, LightKind};

    fn image(width: u32, height: u32, gray: impl Fn(u32, u32) -> u8) -> Image {
        let texel = |i: u32| {
            let g = gray(i % width, i / width);
            [g, g, g, 255]
        };
        Image { name: "map".into(), width, height, texels: (0..width * height).flat_map(texel).collect() }
    }

    fn spot(image: usize) -> Light {
        let globe_map = Some(GlobeMap { picture: GlobePicture::Flat { image }, rotation_rad: 0.0 });
        let kind = LightKind::Spot { intensity_cd: 1.0, inner_cone_rad: 0.0, outer_cone_rad: 0.5 };
        Light { globe_map, ..Light::new(kind) }
    }

    #[test]
    fn each_picture_is_there_once() {
        let cube = GlobePicture::Cube { images: [0, 0, 1, 1, 0, 1] };
        let globe_map = Some(GlobeMap { picture: cube, rotation_rad: 1.0 });
        let bulb = Light { globe_map, ..Light::new(LightKind::Point { intensity_cd: 1.0 }) };
        let sun = Light { globe_map, ..Light::new(LightKind::Directional { illuminance_lx: 1.0 }) };
        let dark = Light { color: glam::Vec3::ZERO, ..spot(9) };
        let images = vec![image(4, 4, |_, _| 10), image(8, 2, |_, _| 200)];
        let lights = vec![spot(1), sun, bulb.clone(), spot(0), dark, spot(1), bulb];
        let scene = Scene { images, lights, ..Scene::default() };
        let layers = scene.globe_layers().unwrap();
        assert_eq!(layers.first_of_light, [Some(0), None, Some(1), Some(7), None, Some(0), Some(1)]);
        assert_eq!((layers.side, layers.count()), (8, 8));
        let grays: Vec<_> = layers.texels.chunks(256).map(|l| l[0]).collect();
        assert_eq!(grays, [200, 10, 10, 200, 200, 10, 200, 10]);
        assert!(layers.texels.chunks(256).all(|l| l.chunks(4).all(|t| t[0] == l[0])));
        let none = Scene { lights: vec![spot(2)], ..scene }.globe_layers().unwrap_err();
        assert!(none.to_string().contains("image 2, but the scene has 2"), "{none}");
    }

    #[test]
    fn resizing_keeps_light() {
        // Half of it white, half black: the mean of the light is a half, however large.
        let mean = |width, height, side| {
            let half = image(width, height, |x, _| if x < width / 2 { 255 } else { 0 });
            let texels = resized(&half, side);
            let light = |t: &[u8]| linear_from_srgb(f64::from(t[0]) / 255.0);
            texels.chunks(4).map(light).sum::<f64>() / f64::from(side * side)
        };
        for (width, height, side) in [(2, 2, 16), (16, 4, 16), (64, 16, 16), (2048, 2, 1024), (30, 30, 20)] {
            assert!((mean(width, height, side) - 0.5).abs() < 2e-3, "{width}x{height} as {side}");
        }
        // Texel centres stay where they are.
        let ramp = resized(&image(2, 1, |x, _| 255 * x as u8), 4);
        assert_eq!([ramp[0], ramp[12]], [0, 255]);
        assert!(ramp[4] > 0 && ramp[4] < ramp[8] && ramp[8] < 255);
    }
}
