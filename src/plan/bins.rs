//! How an Adreno GPU's memory for tiles cuts a picture into bins, by the rule of Mesa's Turnip driver.
//!
//! Turnip lays the attachments of a render pass side by side in the on-chip memory (GMEM) and draws the picture bin by bin.
//! The rule is that of Mesa 26.1, `tu_render_pass_gmem_config` (tu_pass.cc) and `tu_tiling_config_update_tile_layout`
//! (tu_util.cc); a test compares it with what the driver says it chose. Qualcomm's own driver may choose otherwise, but has
//! the same memory.

use serde::{Deserialize, Serialize};

use super::{Format, Plan};

/// An Adreno GPU, as far as bins depend on it (freedreno_devices.py; memory: the driver's kernel interface).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Adreno {
    /// The number in its name.
    pub id: u32,
    /// On-chip memory for tiles, bytes.
    pub gmem_bytes: u32,
    /// Bins' sides are multiples of this, pixels.
    pub align_px: [u32; 2],
    /// Bins' longest sides, pixels.
    pub most_px: [u32; 2],
}

/// How a picture is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bins {
    /// Number of bins.
    pub count: u32,
    /// Width and height of one, pixels; those at the right and the lower border may be cut.
    pub size_px: [u32; 2],
}

impl Adreno {
    /// GPUs of three generations (Snapdragon 845, 888 and 8 Gen 2).
    pub const ALL: [Self; 3] = [
        Self { id: 630, gmem_bytes: 1 << 20, align_px: [32, 16], most_px: [1024, 1024] },
        Self { id: 660, gmem_bytes: 3 << 19, align_px: [96, 16], most_px: [1024, 1024] },
        Self { id: 740, gmem_bytes: 3 << 20, align_px: [96, 32], most_px: [2016, 2032] },
    ];

    /// The bins of a render pass with these attachments; `None` if they do not fit, so that the pass is not tiled.
    pub fn bins(&self, attachments: &[Format], size_px: [u32; 2]) -> Option<Bins> {
        // Stencil beside 32-bit depth has a place of its own, after it.
        let planes: Vec<u32> = (attachments.iter())
            .flat_map(|format| match format {
                Format::D32FloatS8 => vec![4, 1],
                other => vec![other.bytes()],
            })
            .collect();
        let pixels = self.pixels(&planes)?;
        let [align_w, align_h] = self.bin_align(&planes);
        let [width, height] = size_px;
        let most_w = self.most_px[0].min(width.next_multiple_of(align_w));
        let most_h = self.most_px[1].min(height.next_multiple_of(align_h));
        let mut best: Option<Bins> = None;
        for bin_w in (align_w..=most_w).step_by(align_w as usize) {
            let bin_h = (pixels / bin_w).min(most_h) / align_h * align_h;
            if bin_h == 0 {
                continue;
            }
            let [columns, rows] = [width.div_ceil(bin_w), height.div_ceil(bin_h)];
            let count = columns * rows;
            // As many rows, but of equal height.
            let bin_h = height.div_ceil(rows).next_multiple_of(align_h);
            let apart = |[w, h]: [u32; 2]| w.abs_diff(h);
            let is_better = best.is_none_or(|known| {
                let squarer = apart([bin_w, bin_h]) < apart(known.size_px);
                count < known.count || count == known.count && squarer
            });
            if is_better {
                best = Some(Bins { count, size_px: [bin_w, bin_h] });
            }
        }
        best
    }

    /// Where a plane has one byte a pixel, its rows must be whole blocks of 64.
    fn bin_align(&self, planes: &[u32]) -> [u32; 2] {
        let [mut width, height] = self.align_px;
        for _ in planes.iter().filter(|&&bytes| bytes == 1) {
            if width % 64 != 0 {
                width *= 2;
            }
        }
        [width, height]
    }

    /// How many pixels of these planes the memory holds. It is shared out in blocks of eight smallest bins of a byte a
    /// pixel, to each plane by its share of what is left.
    fn pixels(&self, planes: &[u32]) -> Option<u32> {
        /// Planes of more bytes than this begin at multiples of several blocks.
        const BLOCK_BINS: u32 = 8;
        let block_bytes = BLOCK_BINS * self.align_px[0] * self.align_px[1];
        let narrowed = self.bin_align(planes)[0] / self.align_px[0];
        let mut blocks = self.gmem_bytes / block_bytes;
        let mut bytes_left: u32 = planes.iter().sum();
        let mut pixels = u32::MAX;
        for &bytes in planes {
            let step = (bytes * narrowed / BLOCK_BINS).max(1);
            let share = (blocks * bytes / bytes_left / step * step).max(step);
            if share > blocks {
                return None;
            }
            blocks -= share;
            bytes_left -= bytes;
            pixels = pixels.min(share * block_bytes / bytes);
        }
        Some(pixels)
    }
}

impl Plan {
    /// The formats of a pass's attachments, in its order.
    pub fn formats(&self, pass: usize) -> Vec<Format> {
        self.passes[pass].attachments.iter().map(|a| self.attachments[a.attachment].format).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [1920, 1080];

    /// What Turnip of Mesa 26.1.6 printed for the courtyard at 1920x1080: five attachments of four bytes.
    #[test]
    fn twenty_bytes_are_cut_as_the_driver_cuts_them() {
        let formats = [Format::Rgba8Srgb; 5];
        let expected = [(40, [192, 272]), (28, [480, 160]), (14, [960, 160])];
        for (adreno, (count, size_px)) in Adreno::ALL.into_iter().zip(expected) {
            assert_eq!(adreno.bins(&formats, SIZE), Some(Bins { count, size_px }), "{}", adreno.id);
        }
    }

    #[test]
    fn fewer_bytes_never_need_more_bins_and_too_many_do_not_fit() {
        for adreno in Adreno::ALL {
            let counts: Vec<_> =
                (1..20).map(|n| adreno.bins(&vec![Format::Rgba16Float; n], SIZE).unwrap().count).collect();
            assert!(counts.is_sorted(), "{}: {counts:?}", adreno.id);
            assert_eq!(adreno.bins(&vec![Format::Rgba32Float; 9999], SIZE), None);
            let small = adreno.bins(&[Format::Rgba8Srgb], [64, 32]).unwrap();
            assert_eq!(small.count, 1);
        }
    }
}
