//! How far two pictures of light are apart.

use std::fmt;

use ontile::glam::DVec3;
use ontile::reference::Frame;

/// The promise: relative error at most this ...
pub const MAX_RELATIVE_ERROR: f64 = 1e-3;
/// ... for this part of the pixels.
pub const PROMISED_PART: f64 = 0.999;
/// Errors are relative to the channel's true value or to this, whichever is greater: the first step of an 8-bit sRGB
/// image above black, 1 / (255 * 12.92). A thousandth of it is seen by nothing.
pub const FLOOR: f64 = 3.0e-4;

/// Relative errors of the pixels that were compared, largest first.
pub struct Errors {
    sorted: Vec<f64>,
    /// Where the largest is, what was expected and what was found.
    worst: Option<(usize, DVec3, DVec3)>,
    covered: usize,
}

impl Errors {
    /// The display light of the reference's covered pixels, but for those at edges, against `found`.
    pub fn of_display(reference: &Frame, found: &[DVec3]) -> Self {
        Self::of(reference, found, |index| !reference.pixels[index].edge)
    }

    /// As [`Self::of_display`], for the pixels that `chosen` picks among the covered ones.
    pub fn of(reference: &Frame, found: &[DVec3], chosen: impl Fn(usize) -> bool) -> Self {
        assert_eq!(reference.pixels.len(), found.len());
        let covered = reference.pixels.iter().filter(|p| p.covered).count();
        let mut errors: Vec<(f64, usize)> = (reference.pixels.iter().enumerate())
            .filter(|&(index, pixel)| pixel.covered && chosen(index))
            .map(|(index, pixel)| (relative_error(pixel.display, found[index]), index))
            .collect();
        errors.sort_by(|a, b| b.0.total_cmp(&a.0));
        let worst = errors.first().map(|&(_, i)| (i, reference.pixels[i].display, found[i]));
        Self { sorted: errors.into_iter().map(|(error, _)| error).collect(), worst, covered }
    }

    /// The error that `part` of the pixels do not exceed.
    pub fn quantile(&self, part: f64) -> f64 {
        let beyond = ((1.0 - part) * self.sorted.len() as f64).floor() as usize;
        self.sorted.get(beyond).copied().unwrap_or(f64::NAN)
    }

    /// Whether the promise is kept, on enough pixels to mean something.
    pub fn check(&self) -> Result<(), String> {
        self.check_within(MAX_RELATIVE_ERROR)
    }

    /// [`Self::check`] with another bound than [`MAX_RELATIVE_ERROR`].
    pub fn check_within(&self, bound: f64) -> Result<(), String> {
        /// Edges are lines: most of what is covered must be compared.
        const LEAST_PART: f64 = 0.6;
        let compared = self.sorted.len() as f64;
        if self.covered == 0 || compared < LEAST_PART * self.covered as f64 {
            return Err(format!("only {compared} of {} covered pixels can be compared", self.covered));
        }
        let error = self.quantile(PROMISED_PART);
        // Not `error > bound`: NaN fails.
        if error <= bound { Ok(()) } else { Err(self.to_string()) }
    }
}

impl fmt::Display for Errors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} of {} covered pixels: 50 % within {:.1e}, 99 % {:.1e}, 99.9 % {:.1e}, all {:.1e}",
            self.sorted.len(),
            self.covered,
            self.quantile(0.5),
            self.quantile(0.99),
            self.quantile(PROMISED_PART),
            self.quantile(1.0),
        )?;
        let Some((index, expected, found)) = self.worst else { return Ok(()) };
        let [width, _] = crate::SIZE.map(|n| n as usize);
        write!(f, " at ({}, {}): {expected:.5}, found {found:.5}", index % width, index / width)
    }
}

/// The greatest of the three channels'.
fn relative_error(expected: DVec3, found: DVec3) -> f64 {
    let error = (found - expected).abs() / expected.max(DVec3::splat(FLOOR));
    // `max_element` may drop NaN.
    if found.is_finite() { error.max_element() } else { f64::NAN }
}

#[test]
fn a_nan_is_never_within_bounds() {
    use ontile::reference::Pixel;
    let pixel = Pixel { covered: true, display: DVec3::ONE, ..Pixel::default() };
    let frame = Frame { size: [10, 1], pixels: vec![pixel; 10] };
    let mut found = vec![DVec3::ONE; 10];
    assert_eq!(Errors::of_display(&frame, &found).check(), Ok(()));
    found[3].y = f64::NAN;
    assert!(Errors::of_display(&frame, &found).check().is_err());
    found[3].y = 1.0011;
    assert!(Errors::of_display(&frame, &found).check().is_err());
}
