//! How an Adreno GPU's memory for tiles cuts a picture into bins, by the rule of Mesa's Turnip driver.
//!
//! Turnip lays the attachments of a render pass side by side in the on-chip memory (GMEM) and draws the picture bin by bin.
//! The rule is that of Mesa 26.1, `tu_render_pass_gmem_config` (tu_pass.cc) and `tu_tiling_config_update_tile_layout`
//! (tu_util.cc); a test compares it with what the driver says it chose. Qualcomm's own driver may choose otherwise, but has
//! the same memory.

use serde::{Deserialize, Serialize};

use super::{Format, Plan, Store, Strategy};

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

/// An attachment as it occupies tile memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct Occupancy {
    /// How a sample is stored.
    pub format: Format,
    /// Samples a pixel.
    pub samples: u32,
    /// The first and the last subpass that need it.
    pub subpasses: [usize; 2],
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
    pub fn bins(&self, attachments: &[Occupancy], size_px: [u32; 2]) -> Option<Bins> {
        let planes = planes(attachments);
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

/// Bytes a pixel of what lies side by side: attachments whose subpasses do not overlap share a place, if the first has
/// room for the other.
fn planes(attachments: &[Occupancy]) -> Vec<u32> {
    struct Place {
        bytes: u32,
        subpasses: [usize; 2],
    }
    let mut places: Vec<Place> = Vec::new();
    for Occupancy { format, samples, subpasses: [first, last] } in attachments {
        // Stencil beside 32-bit depth has a place of its own, after it.
        let parts: &[u32] = if *format == Format::D32FloatS8 { &[4, 1] } else { &[format.bytes()] };
        for bytes in parts.iter().map(|bytes| bytes * samples) {
            let mut free = (places.iter_mut())
                .filter(|p| p.bytes >= bytes && (p.subpasses[0] > *last || p.subpasses[1] < *first))
                .collect::<Vec<_>>();
            // One of the same size, else the first.
            let same = free.iter().position(|p| p.bytes == bytes).unwrap_or(0);
            match free.get_mut(same) {
                Some(place) => {
                    let [begin, end] = place.subpasses;
                    place.subpasses = [begin.min(*first), end.max(*last)];
                }
                None => places.push(Place { bytes, subpasses: [*first, *last] }),
            }
        }
    }
    places.into_iter().map(|place| place.bytes).collect()
}

impl Plan {
    /// How the attachments of a pass, in the driver's order, occupy tile memory: those of a render pass in its order, those of a
    /// rendering from begin to end, depth last.
    pub fn occupancy(&self, pass: usize) -> Vec<Occupancy> {
        let pass = &self.passes[pass];
        if self.strategy == Strategy::LocalRead {
            let held = (0..pass.attachments.len()).filter(|&i| pass.is_on_tile(i));
            let held = held.map(|i| {
                let super::Attachment { format, samples, .. } =
                    self.attachments[pass.attachments[i].attachment];
                Occupancy { format, samples, subpasses: [0, pass.subpasses.len() - 1] }
            });
            let (depth, colors): (Vec<_>, Vec<_>) = held.partition(|held| held.format.is_depth());
            return colors.into_iter().chain(depth).collect();
        }
        let attachments = pass.attachments.iter().enumerate();
        let held = attachments.filter(|(index, _)| pass.is_on_tile(*index));
        held.map(|(index, used)| {
            let uses = |s: &super::Subpass| {
                s.colors.contains(&index) || s.inputs.contains(&index) || s.depth == Some(index)
            };
            let mut subpasses = (0..pass.subpasses.len()).filter(|&s| uses(&pass.subpasses[s]));
            let first = subpasses.next().unwrap_or(0);
            let last = subpasses.next_back().unwrap_or(first);
            let stored = used.store == Store::Store || used.stencil.1 == Store::Store;
            // What is stored stays until the pass ends.
            let last = if stored { pass.subpasses.len() - 1 } else { last };
            let super::Attachment { format, samples, .. } = self.attachments[used.attachment];
            Occupancy { format, samples, subpasses: [first, last] }
        })
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [1920, 1080];

    /// What Turnip of Mesa 26.1.6 printed for the courtyard at 1920x1080: five attachments of four bytes.
    #[test]
    fn twenty_bytes_are_cut_as_the_driver_cuts_them() {
        let all = vec![Occupancy { format: Format::Rgba8Srgb, samples: 1, subpasses: [0, 0] }; 5];
        let expected = [(40, [192, 272]), (28, [480, 160]), (14, [960, 160])];
        for (adreno, (count, size_px)) in Adreno::ALL.into_iter().zip(expected) {
            assert_eq!(adreno.bins(&all, SIZE), Some(Bins { count, size_px }), "{}", adreno.id);
        }
    }

    #[test]
    fn fewer_bytes_never_need_more_bins_and_too_many_do_not_fit() {
        let many = |format, n| vec![Occupancy { format, samples: 1, subpasses: [0, 0] }; n];
        for adreno in Adreno::ALL {
            let counts: Vec<_> =
                (1..20).map(|n| adreno.bins(&many(Format::Rgba16Float, n), SIZE).unwrap().count).collect();
            assert!(counts.is_sorted(), "{}: {counts:?}", adreno.id);
            assert_eq!(adreno.bins(&many(Format::Rgba32Float, 9999), SIZE), None);
            let small = adreno.bins(&many(Format::Rgba8Srgb, 1), [64, 32]).unwrap();
            assert_eq!(small.count, 1);
        }
    }

    #[test]
    fn what_is_not_needed_at_the_same_time_shares_a_place() {
        let of = |list: &[(Format, [usize; 2])]| {
            planes(
                &list
                    .iter()
                    .map(|&(format, subpasses)| Occupancy { format, samples: 1, subpasses })
                    .collect::<Vec<_>>(),
            )
        };
        use Format::{D32Float, D32FloatS8, Rgba8Srgb, Rgba16Float};
        assert_eq!(of(&[(Rgba8Srgb, [2, 2]), (D32Float, [0, 0]), (Rgba16Float, [0, 2])]), [4, 8]);
        // The place that was shared is taken for all that lies between.
        assert_eq!(of(&[(Rgba8Srgb, [2, 2]), (D32Float, [0, 0]), (D32Float, [1, 1])]), [4, 4]);
        // The same size is preferred to the first; what is larger finds no room.
        assert_eq!(of(&[(Rgba16Float, [1, 1]), (D32Float, [1, 1]), (Rgba8Srgb, [0, 0])]), [8, 4]);
        assert_eq!(of(&[(D32Float, [1, 1]), (Rgba16Float, [0, 0])]), [4, 8]);
        assert_eq!(of(&[(D32FloatS8, [0, 0])]), [4, 1]);
    }
}
