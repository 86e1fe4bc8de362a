//! Two pictures side by side, pixel by pixel.

use crate::picture::{Picture, Pixels};
use crate::{Error, Result};

/// Two pictures of one size and kind, and which of their pixels count.
pub(super) struct Pairs<'a> {
    a: &'a Picture,
    b: &'a Picture,
    mask: Option<&'a Picture>,
}

/// How a pixel differs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Difference {
    /// The largest absolute difference of the four channels.
    Finite(f64),
    /// A channel is a NaN or an infinity in one picture and not the same in the other.
    NonFinite,
}

impl Difference {
    pub(super) fn finite(self) -> Option<f64> {
        match self {
            Self::Finite(difference) => Some(difference),
            Self::NonFinite => None,
        }
    }
}

impl<'a> Pairs<'a> {
    pub(super) fn new(a: &'a Picture, b: &'a Picture, mask: Option<&'a Picture>) -> Result<Self> {
        a.validate()?;
        b.validate()?;
        let size = |p: &Picture| format!("{}x{}", p.width, p.height);
        if size(a) != size(b) {
            return Err(Error::unsupported(
                format!("the pictures differ in size: {} and {}", size(a), size(b)),
                "compare pictures of one size",
            ));
        }
        if std::mem::discriminant(&a.pixels) != std::mem::discriminant(&b.pixels) {
            return Err(Error::unsupported(
                "one picture has 8 bits a channel and the other has linear floats",
                "compare two of a kind",
            ));
        }
        if let Some(mask) = mask {
            mask.validate()?;
            if size(mask) != size(a) {
                return Err(Error::unsupported(
                    format!("the mask is {} pixels and the pictures are {}", size(mask), size(a)),
                    "give a mask of the pictures' size",
                ));
            }
        }
        let pairs = Self { a, b, mask };
        if pairs.counted().next().is_none() {
            return Err(Error::unsupported(
                "no pixel is left to compare",
                "give pictures that are not empty and a mask that is not all black",
            ));
        }
        Ok(pairs)
    }

    /// Pixels of each picture, counted or not.
    pub(super) fn len(&self) -> usize {
        self.a.width as usize * self.a.height as usize
    }

    /// Whether the mask lets this pixel count: any colour but black does.
    pub(super) fn counts(&self, index: usize) -> bool {
        self.mask.is_none_or(|mask| pixel(mask, index)[..3].iter().any(|&c| c != 0.0))
    }

    /// The pixels that count, in order.
    pub(super) fn counted(&self) -> impl Iterator<Item = usize> {
        (0..self.len()).filter(|&i| self.counts(i))
    }

    /// The four channels of a pixel in both pictures: 0 to 255 for 8 bits, else as they are.
    pub(super) fn get(&self, index: usize) -> ([f64; 4], [f64; 4]) {
        (pixel(self.a, index), pixel(self.b, index))
    }

    /// Channels that hold the same NaN or infinity do not differ.
    pub(super) fn difference(&self, index: usize) -> Difference {
        let (a, b) = self.get(index);
        let mut max: f64 = 0.0;
        for (a, b) in a.into_iter().zip(b) {
            let same = a == b || a.is_nan() && b.is_nan();
            match (a - b).abs() {
                _ if same => {}
                difference if difference.is_finite() => max = max.max(difference),
                _ => return Difference::NonFinite,
            }
        }
        Difference::Finite(max)
    }
}

fn pixel(picture: &Picture, index: usize) -> [f64; 4] {
    let first = 4 * index;
    match &picture.pixels {
        Pixels::Rgba8(p) => std::array::from_fn(|c| p[first + c].into()),
        Pixels::Rgba32F(p) => std::array::from_fn(|c| p[first + c].into()),
    }
}
