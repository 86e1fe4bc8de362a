//! What all charts are drawn on: the same marks as an SVG document and as a PNG picture. The font is embedded, so that
//! they look the same on every machine.

use std::path::Path;

use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};

use crate::{Error, Result, file};

/// Pixels of the PNG for one of the SVG, so that its letters are crisp.
const PNG_SCALE: u32 = 2;
const FONT: &str = "sans-serif";

/// Okabe and Ito's colours, which people with any colour vision can tell apart, the yellow left out.
pub const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];

/// The area to draw on, and how many of its pixels make one of the drawing's own.
pub struct Canvas<B: DrawingBackend> {
    /// All of it.
    pub area: DrawingArea<B, plotters::coord::Shift>,
    /// Lengths are multiplied by this.
    pub scale: u32,
}

/// How drawing ends.
pub type Drawn = std::result::Result<(), Box<dyn std::error::Error + Send + Sync>>;

impl<B: DrawingBackend> Canvas<B> {
    /// Letters of this height, in the drawing's pixels.
    pub fn font(&self, size: u32) -> (&'static str, u32) {
        (FONT, size * self.scale)
    }

    /// The width and height that a text takes, in the canvas's pixels.
    pub fn text_size(&self, text: &str, size: u32) -> (u32, u32) {
        let style = self.font(size).into_font();
        // Fails only without the font, which is compiled in; then half as wide as high is a fair guess.
        style.box_size(text).unwrap_or((text.len() as u32 * size * self.scale / 2, size * self.scale))
    }
}

/// Something that can be drawn.
pub trait Drawing {
    /// What it shows, for messages.
    fn title(&self) -> &str;

    /// Width and height in pixels.
    fn size(&self) -> (u32, u32);

    /// Draws it; the canvas is white.
    ///
    /// # Errors
    /// What prevents it, e.g. that there is no point to show.
    fn draw<B: DrawingBackend<ErrorType: 'static>>(&self, canvas: &Canvas<B>) -> Drawn;

    /// As an SVG document.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if it cannot be drawn.
    fn svg(&self) -> Result<String> {
        let mut svg = String::new();
        self.draw_on(SVGBackend::with_string(&mut svg, self.size()), 1)?;
        Ok(svg)
    }

    /// As a PNG file's bytes.
    ///
    /// # Errors
    /// As [`Self::svg`].
    fn png(&self) -> Result<Vec<u8>> {
        let (width, height) = self.size();
        let (width, height) = (width * PNG_SCALE, height * PNG_SCALE);
        let mut texels = vec![0; (width * height * 3) as usize];
        self.draw_on(BitMapBackend::with_buffer(&mut texels, (width, height)), PNG_SCALE)?;
        let mut png = Vec::new();
        let written = PngEncoder::new(&mut png).write_image(&texels, width, height, ExtendedColorType::Rgb8);
        written.map_err(|e| undrawable(self.title(), &e.to_string()))?;
        Ok(png)
    }

    /// Writes `path` with the extensions svg and png.
    ///
    /// # Errors
    /// As [`Self::svg`], and [`Error::Io`].
    fn write(&self, path: &Path) -> Result<()> {
        file::write_whole(&path.with_extension("svg"), self.svg()?.as_bytes())?;
        file::write_whole(&path.with_extension("png"), &self.png()?)
    }

    /// Draws it with a backend of its size times `scale`.
    ///
    /// # Errors
    /// As [`Self::svg`].
    fn draw_on<B: DrawingBackend<ErrorType: 'static>>(&self, backend: B, scale: u32) -> Result<()> {
        // Fails only for bytes that are no font, and these are compiled in.
        let _ = register_font(FONT, FontStyle::Normal, dejavu::sans::regular());
        let canvas = Canvas { area: backend.into_drawing_area(), scale };
        let draw = || -> Drawn {
            canvas.area.fill(&WHITE)?;
            self.draw(&canvas)?;
            Ok(canvas.area.present()?)
        };
        draw().map_err(|e| undrawable(self.title(), &e.to_string()))
    }
}

fn undrawable(title: &str, why: &str) -> Error {
    Error::unsupported(format!("the chart '{title}' cannot be drawn: {why}"), "measure more places")
}

/// A legend's field of a colour.
pub fn key(x: i32, y: i32, scale: u32, color: RGBColor) -> Rectangle<(i32, i32)> {
    let scale = scale as i32;
    Rectangle::new([(x, y - 5 * scale), (x + 16 * scale, y + 5 * scale)], color.filled())
}

/// Three significant digits, without trailing zeros.
pub fn short(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    let magnitude = x.abs().log10().floor() as i32;
    if !(-4..6).contains(&magnitude) {
        let mantissa = x / 10_f64.powi(magnitude);
        let text = format!("{mantissa:.2}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        return format!("{text}e{magnitude}");
    }
    let digits = (2 - magnitude).max(0) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// [`short`], with more digits where an axis of this length has marks that would read alike.
pub fn mark(x: f64, length: f64) -> String {
    // About ten marks.
    let step = length / 10.0;
    let is_told_apart = |text: &str| text.parse().is_ok_and(|told: f64| (told - x).abs() < 0.25 * step);
    let text = short(x);
    if step <= 0.0 || is_told_apart(&text) {
        return text;
    }
    let digits = (-step.log10().floor()).max(0.0) as usize + 1;
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_that_are_next_to_each_other_read_differently() {
        for (start, length) in [(3.12, 0.03), (382.0, 1.5), (0.0072, 2e-5), (1.0, 9.0)] {
            let marks: Vec<_> = (0..10).map(|i| mark(start + length * f64::from(i) / 10.0, length)).collect();
            assert!(marks.windows(2).all(|pair| pair[0] != pair[1]), "{marks:?}");
        }
        assert_eq!((mark(0.5, 1.0), mark(3.125, 0.01)), ("0.5".into(), "3.125".into()));
    }

    #[test]
    fn numbers_are_short() {
        let cases = [
            (0.0, "0"),
            (0.5, "0.5"),
            (1234.5, "1234"),
            (1e-7, "1e-7"),
            (2.5e9, "2.5e9"),
            (0.012_34, "0.0123"),
        ];
        for (x, text) in cases {
            assert_eq!(short(x), text);
        }
    }
}
