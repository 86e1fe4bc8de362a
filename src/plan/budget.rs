//! Whether the plan fits the tile memory of each family of GPUs, and why.

use serde::Serialize;

use super::{Adreno, Bins, Plan};

/// What one family of tilers is expected to do with a plan. All figures are `modelled`: they come from the
/// vendors' publications, not from a device.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Verdict {
    /// GPU family.
    pub family: &'static str,
    /// Whether every pass is expected to stay on the tile at full speed.
    pub fits: bool,
    /// The figures behind it.
    pub reason: String,
}

/// Colour bits a pixel at full tile size (Arm: Mali Bifrost and earlier; PowerVR: Rogue series 6).
const STRICT_COLOR_BITS: u32 = 128;
/// The same on later cores (Valhall and after; Rogue series 7 and after).
const LATER_COLOR_BITS: u32 = 256;
/// Attachments a Mali render pass may have to be merged.
const MALI_ATTACHMENTS: usize = 8;

/// Pixels of a tile that is not shrunk: 16x16.
const MALI_TILE_PX: u32 = 256;

/// The sides of a tile of this many pixels, a power of two, wider than high.
fn sides(pixels: u32) -> [u32; 2] {
    let bits = pixels.ilog2();
    [1 << bits.div_ceil(2), 1 << (bits / 2)]
}

/// Mali tiles of so many samples and colour bits each: memory for 16x16 pixels is shared out, to powers of two.
fn mali_tiles(samples: u32, color_bits: u32) -> String {
    let tile = |room: u32| {
        let pixels = MALI_TILE_PX * room / (samples * color_bits.next_power_of_two().max(1));
        let [width, height] = sides(pixels.clamp(1, MALI_TILE_PX));
        format!("{width}x{height}")
    };
    format!(
        "; {samples} samples: tiles of {} pixels, {} on later cores",
        tile(STRICT_COLOR_BITS),
        tile(LATER_COLOR_BITS)
    )
}

/// The bins of each Adreno GPU that is known, for the pass that has most.
fn adreno_bins(plan: &Plan) -> String {
    let of = |adreno: Adreno| {
        let bins = (0..plan.passes.len()).map(|p| adreno.bins(&plan.occupancy(p), plan.options.size));
        let bins: Option<Vec<_>> = bins.collect();
        match bins.and_then(|bins| bins.into_iter().max_by_key(|b| b.count)) {
            Some(Bins { count, size_px: [w, h] }) => format!("{count} of {w}x{h} on {}", adreno.id),
            None => format!("does not fit {}", adreno.id),
        }
    };
    format!(": {}", Adreno::ALL.map(of).join(", "))
}

/// One verdict per GPU family.
pub fn verdicts(plan: &Plan) -> Vec<Verdict> {
    let split = plan.passes.len() > 1;
    let declared = |pass: &super::Pass| -> u32 {
        let held = pass.attachments.iter().enumerate().filter(|(index, _)| pass.is_on_tile(*index));
        let formats = held.map(|(_, a)| plan.attachments[a.attachment].format);
        formats.filter(|f| !f.is_depth()).map(|f| f.bits()).sum()
    };
    let color_bits = plan.passes.iter().map(declared).max().unwrap_or(0);
    let depth_bits =
        plan.passes.iter().flat_map(|p| &p.subpasses).map(|s| s.live_depth_bits).max().unwrap_or(0);
    let attachments = plan.passes.iter().map(|p| p.attachments.len()).max().unwrap_or(0);
    let split_reason = |reason: String| match split {
        true => format!(
            "split into {} passes on request: every pass stores and loads; {reason}",
            plan.passes.len()
        ),
        false => reason,
    };
    let room = |cores: [&str; 2], over: &str| match color_bits {
        0..=STRICT_COLOR_BITS => {
            format!("{color_bits} of {STRICT_COLOR_BITS} colour bits: fits {}", cores[0])
        }
        129..=LATER_COLOR_BITS => {
            format!("{color_bits} colour bits: fits only {} ({LATER_COLOR_BITS}); {over}", cores[1])
        }
        _ => format!("{color_bits} colour bits: more than any core holds ({LATER_COLOR_BITS}); {over}"),
    };
    let samples = plan.options.samples;
    let several = |what: String| if samples > 1 { what } else { String::new() };
    let fits = !split && color_bits <= STRICT_COLOR_BITS;
    vec![
        Verdict {
            family: "Mali",
            fits: fits && attachments <= MALI_ATTACHMENTS,
            reason: split_reason(format!(
                "{}; {attachments} of {MALI_ATTACHMENTS} attachments{}",
                room(["all cores", "later cores"], "smaller tiles or no merging elsewhere"),
                several(mali_tiles(samples, color_bits))
            )),
        },
        Verdict {
            family: "PowerVR",
            fits,
            reason: split_reason(
                room(["Rogue series 6 and later", "Rogue series 7 and later"], "the rest spills to memory")
                    + &several(format!("; {samples} samples: tiles of a {samples}th of the pixels")),
            ),
        },
        Verdict {
            family: "Adreno",
            fits: !split,
            reason: split_reason(format!(
                "{} bytes a pixel in tile memory: any amount merges, bins shrink as it grows{}",
                (color_bits * samples + depth_bits) / 8,
                several(adreno_bins(plan))
            )),
        },
    ]
}
