//! The traffic of a counted frame: what the formula says of it, what this renderer asks for, and all of it together for merged
//! and for separate passes.

use serde::Serialize;

use super::count::{Counts, SHADOW_MAP};
use super::{Thibieroz, Traffic};
use crate::Result;
use crate::plan::{LightWay, Limits, Needs, Options, Origin, Path, Plan, Strategy};
use crate::scene::Scene;

/// What the merged renderer of Smith and Einig 2015 saved (figure 2.8, on a PowerVR series 6): shares of the bytes that were
/// read and written by separate passes.
pub const PUBLISHED: Traffic = Traffic { read: 0.53, written: 0.54 };

/// The formula for a frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModelledFrame {
    /// How its lights are shaded.
    pub what: String,
    /// The formula's variables.
    pub model: Thibieroz,
    /// Bytes a frame.
    pub frame: Traffic,
}

/// A part of a frame's traffic, bytes a frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Part {
    /// What moves.
    pub what: &'static str,
    /// Where the figures come from.
    pub origin: Origin,
    /// In passes of their own, if each byte is fetched from memory once.
    pub separate: Traffic,
    /// In subpasses of one pass, likewise.
    pub subpasses: Traffic,
    /// How much more is read of it without caches, in both.
    pub uncached_read: f64,
    /// Only in frames that draw the shadow map, as the first one does.
    pub of_shadow_tiles: bool,
}

/// What subpasses save of the bytes that separate passes move.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Saved {
    /// Under which assumptions.
    pub assuming: &'static str,
    /// Bytes of separate passes.
    pub separate: Traffic,
    /// Bytes of subpasses.
    pub subpasses: Traffic,
    /// Shares of the former.
    pub share: Traffic,
}

/// All of it.
#[derive(Clone, Debug, Serialize)]
pub struct FrameTraffic {
    /// The formula, with the same G-buffer in memory.
    pub modelled: Vec<ModelledFrame>,
    /// The whole frame.
    pub parts: Vec<Part>,
    /// What merging saves of it.
    pub saved: Vec<Saved>,
    /// The same of [`PUBLISHED`].
    pub published: Traffic,
}

impl FrameTraffic {
    /// Of a scene's frame, counted with these options on a device with these limits.
    ///
    /// # Errors
    /// Those of [`Plan::new`].
    pub fn new(scene: &Scene, options: &Options, limits: &Limits, counts: &Counts) -> Result<Self> {
        let plan = |options: Options| Plan::new(Needs::of(scene), options, limits);
        // What is compared takes one path.
        let Plan { path, light_way, .. } = plan(options.clone())?;
        let by = |strategy| {
            let options = Options { strategy, path, lights: light_way, ..options.clone() };
            plan(options).map(|plan| (attachments(&plan, counts), plan))
        };
        let (separate, _) = by(Strategy::Separate)?;
        let (subpasses, merged) = by(Strategy::Subpasses)?;
        // The formula's frame: each attribute has a target, and lights are no volumes.
        let stored = plan(Options {
            strategy: Strategy::Separate,
            path: Path::Deferred,
            lights: LightWay::Fullscreen,
            recycle: false,
            ..options.clone()
        })?;
        let parts = parts(counts, &merged, separate, subpasses);
        let saved = saved(&parts);
        Ok(Self { modelled: modelled(counts, &stored), parts, saved, published: PUBLISHED })
    }
}

/// Bytes of attachments a frame.
fn attachments(plan: &Plan, counts: &Counts) -> Traffic {
    let pixels = counts.pixels();
    let of = |attachment| {
        let [read, written] = plan.traffic(attachment).map(f64::from);
        Traffic { read, written } * pixels
    };
    (0..plan.attachments.len()).map(of).sum()
}

fn modelled(counts: &Counts, stored: &Plan) -> Vec<ModelledFrame> {
    let passes = match counts.lights {
        0 => vec![("no light is added", 0)],
        1 => vec![("one shading pass for its light", 1)],
        n => vec![("a full-screen shading pass a light", n), ("one shading pass for all lights", 1)],
    };
    let frame = |(what, n): (&str, usize)| {
        let model = inputs(counts, stored, n as f64);
        ModelledFrame { what: what.into(), model, frame: model.frame() }
    };
    passes.into_iter().map(frame).collect()
}

/// The formula's variables for `n` shading passes.
fn inputs(counts: &Counts, stored: &Plan, n: f64) -> Thibieroz {
    let pass = |name| stored.passes.iter().find(|p| p.subpasses.iter().any(|s| s.name == name));
    let bits = |pass: &crate::plan::Pass, list: &[usize]| -> Vec<f64> {
        list.iter()
            .map(|&i| f64::from(stored.attachments[pass.attachments[i].attachment].format.bits()))
            .collect()
    };
    let building = &stored.passes[0];
    let z_bpp = bits(building, building.subpasses[0].depth.as_slice()).iter().sum();
    let (targets, bb_bpp) = match pass("lighting") {
        Some(lighting) => {
            let subpass = &lighting.subpasses[0];
            (bits(lighting, &subpass.inputs), bits(lighting, &subpass.colors).iter().sum())
        }
        None => (bits(building, &building.subpasses[0].colors), 0.0),
    };
    let pixels = counts.pixels();
    let shading = counts.draws.iter().filter(|d| d.of_surfaces && d.stage != "depth" && d.stage != "lights");
    // Of a fragment on average: lookups, and bytes of them.
    let [mut t_b, mut t_b_bytes, mut c_geometry] = [0.0; 3];
    for draw in shading {
        let own = draw.lookups.iter().filter(|l| !counts.light_lookups.iter().any(|of| of.image == l.image));
        for lookup in own {
            t_b += draw.fragments * lookup.times;
            t_b_bytes += draw.fragments * lookup.times * lookup.texel_bytes;
        }
        c_geometry += draw.geometry_each;
    }
    let passed = counts.passed.max(1.0);
    let all_lights = total(counts.light_lookups.iter().map(|l| l.times));
    let all_lights_bytes = total(counts.light_lookups.iter().map(|l| l.times * l.texel_bytes));
    let lookups = t_b + pixels * all_lights;
    Thibieroz {
        size: counts.size,
        z_bpp,
        bb_bpp,
        overdraw: counts.rasterized / pixels,
        sorting: counts.passed / pixels,
        t_bpp: if lookups > 0.0 { 8.0 * (t_b_bytes + pixels * all_lights_bytes) / lookups } else { 0.0 },
        t_b: t_b / passed,
        t_s: if n > 0.0 { all_lights / n } else { 0.0 },
        n,
        n_mrt: targets.len() as f64,
        mrt_bpp: targets.iter().sum::<f64>() / (targets.len() as f64).max(1.0),
        c_geometry,
        fps: Thibieroz::default().fps,
    }
}

fn parts(counts: &Counts, plan: &Plan, separate: Traffic, subpasses: Traffic) -> Vec<Part> {
    let both = |what, origin, once: Traffic, each: f64, of_shadow_tiles| Part {
        what,
        origin,
        separate: once,
        subpasses: once,
        uncached_read: each - once.read,
        of_shadow_tiles,
    };
    let read = |once| Traffic { read: once, written: 0.0 };
    let [textures, shadows] =
        [false, true].map(|shadows| counts.lookups(|image| (image == SHADOW_MAP) == shadows));
    let sum = |of: fn(&super::Draw) -> f64| total(counts.draws.iter().map(of));
    let geometry = [sum(|d| d.geometry_once), sum(|d| d.geometry_each)];
    let attachments = Part {
        what: "attachments",
        origin: Origin::Planned,
        separate,
        subpasses,
        uncached_read: 0.0,
        of_shadow_tiles: false,
    };
    let mut all = vec![
        attachments,
        both("textures", Origin::Modelled, read(textures[0]), textures[1], false),
        both("geometry", Origin::Modelled, read(geometry[0]), geometry[1], false),
    ];
    if let Some(map) = &plan.shadow_map {
        let stored = (0..map.tiles.len()).map(|tile| map.tile_bytes(tile)).sum::<u64>() as f64;
        let tiles = Traffic { read: 0.0, written: stored };
        all.extend([
            both("shadow map, sampled", Origin::Modelled, read(shadows[0]), shadows[1], false),
            both("shadow tiles, stored", Origin::Planned, tiles, 0.0, true),
            both(
                "shadow tiles, geometry",
                Origin::Modelled,
                read(counts.casters[0]),
                counts.casters[1],
                true,
            ),
        ]);
    }
    all
}

fn saved(parts: &[Part]) -> Vec<Saved> {
    let sum = |assuming, cached: bool, tiles: bool| {
        let counted = || parts.iter().filter(move |part| tiles || !part.of_shadow_tiles);
        let more =
            |part: &Part| Traffic { read: if cached { 0.0 } else { part.uncached_read }, written: 0.0 };
        let separate: Traffic = counted().map(|part| part.separate + more(part)).sum();
        let subpasses: Traffic = counted().map(|part| part.subpasses + more(part)).sum();
        let share = |of: f64, kept: f64| if of > 0.0 { 1.0 - kept / of } else { 0.0 };
        let share = Traffic {
            read: share(separate.read, subpasses.read),
            written: share(separate.written, subpasses.written),
        };
        Saved { assuming, separate, subpasses, share }
    };
    let mut all = vec![sum("each byte read once", true, false), sum("no caches", false, false)];
    if parts.iter().any(|part| part.of_shadow_tiles) {
        all.push(sum("each byte read once, all shadow tiles drawn", true, true));
        all.push(sum("no caches, all shadow tiles drawn", false, true));
    }
    all
}

/// The sum, 0 of nothing (where that of the standard library is -0).
fn total(all: impl Iterator<Item = f64>) -> f64 {
    all.fold(0.0, |sum, one| sum + one)
}

impl Counts {
    /// Pixels of the picture.
    pub fn pixels(&self) -> f64 {
        f64::from(self.size[0]) * f64::from(self.size[1])
    }

    /// Bytes looked up in images of these names: where a texel that was fetched stays near (no more than the image has, and no
    /// more than one a new lookup), and where each lookup fetches one.
    fn lookups(&self, wanted: impl Fn(&str) -> bool) -> [f64; 2] {
        let mut all = std::collections::BTreeMap::new();
        for draw in &self.draws {
            for lookup in draw.lookups.iter().filter(|l| wanted(&l.image)) {
                let [new, each] = all.entry(lookup.image.as_str()).or_insert([0.0; 2]);
                *new += draw.fragments * lookup.new_times * lookup.texel_bytes;
                *each += draw.fragments * lookup.times * lookup.texel_bytes;
            }
        }
        let once = |(image, &[new, _]): (&&str, &[f64; 2])| {
            self.images.get(*image).map_or(new, |bytes| bytes.min(new))
        };
        [total(all.iter().map(once)), total(all.values().map(|[_, each]| *each))]
    }
}
