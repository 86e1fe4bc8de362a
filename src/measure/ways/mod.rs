//! What a frame's ways cost and what they are worth: samples a pixel, decals, shadows, translucency, refraction. Beside [`super::chart`], whose points are
//! G-buffers.
//!
//! A [`Series`] has several ways to one picture, drawn in turns, and one truth in f64: 64 samples a pixel for samples, rays for
//! shadows, the same paint for decals, bent rays for refraction; for translucency it is the device's own picture of many layers that were
//! peeled off. Where surfaces have textures, whose filters are the driver's own, shadows and decals shade what the
//! layout `exact` stored of them. Errors are roots of mean squares, of display light before it is cut into 8 bits.

mod page;

use std::path::Path;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::chart::{self, is_textured};
use super::{Clock, Effort, Racer, Summary, lit_by_sample, race};
use crate::gpu::{Device, Offscreen, PipelineCache, RendererConfig, View};
use crate::picture::Pixels;
use crate::plan::{
    DecalWay, Edges, Layout, Needs, Options, OutputFormat, Plan, Refraction, ShadowFilter, Translucency,
};
use crate::reference::around::Method;
use crate::reference::samples::{grid, supersampled};
use crate::reference::{self, Behind, Pixel, Settings};
use crate::scene::{Camera, Scene};
use crate::{Error, Result};

pub use page::write;

/// As many layers as may be peeled off.
const MOST_LAYERS: u32 = 16;

/// What varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Series {
    /// One sample a pixel, or four, of which edges are lit by sample or all are.
    Samples,
    /// How decals that overlap are painted.
    Decals,
    /// Shadow maps by their filters and texels, and volumes.
    Shadows,
    /// How what is blended is brought into order.
    Translucency,
    /// Whether media bend light.
    Refraction,
}

/// One way in one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// The scene's name.
    pub scene: String,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// What varies.
    pub series: Series,
    /// The way.
    pub way: String,
    /// What came of it, or why it cannot be.
    pub outcome: std::result::Result<Figures, String>,
}

/// What a way costs, and its error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Milliseconds a frame.
    pub frame_ms: Summary,
    /// Bytes a pixel of all attachments on the tile, planned.
    pub on_tile: u32,
    /// Bytes a pixel that the frame's own passes load and store, planned.
    pub moved: u32,
    /// Bytes of the shadow map that a frame stores which draws all of it, planned.
    pub shadow_bytes: u64,
    /// Root of the mean squared error of a channel's display light, of which 1 is white.
    pub error: f64,
    /// The share of pixels that are lit sample by sample, counted, where some are and others not.
    pub lit_by_sample: Option<f64>,
}

/// What was measured, and where.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The device's name.
    pub device: String,
    /// Its driver.
    pub driver: String,
    /// Where times come from.
    pub clock: Clock,
    /// In order of measurement.
    pub points: Vec<Point>,
}

impl Report {
    const FILE: &str = "ways.json";

    /// What [`write()`] has left in a folder.
    ///
    /// # Errors
    /// [`Error::Io`] if there is none; [`Error::Input`] if it cannot be understood.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(Self::FILE);
        let json = std::fs::read(&path).map_err(|e| Error::io(&path, "read", e))?;
        serde_json::from_slice(&json).map_err(|e| {
            let problem = format!("it is no chart of ways of this version ({e})");
            Error::input(&path, "the file", problem, "chart the scenes again")
        })
    }

    /// Takes in what was measured elsewhere on a device of the same name; of what both have, the newcomer's.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the devices, drivers or clocks differ.
    pub fn merge(&mut self, other: Self) -> Result<()> {
        let by = |report: &Self| (report.device.clone(), report.driver.clone(), report.clock);
        if by(self) != by(&other) {
            return Err(Error::unsupported(
                format!(
                    "one chart is of {} ({}), another of {} ({}): times of two devices do not go into one",
                    self.device, self.driver, other.device, other.driver
                ),
                "merge the charts of each device by themselves",
            ));
        }
        let what = |p: &Point| (p.scene.clone(), p.size, p.series, p.way.clone());
        self.points.retain(|old| !other.points.iter().any(|new| what(new) == what(old)));
        self.points.extend(other.points);
        Ok(())
    }
}

/// The series that a scene has, each with its ways over the options.
pub fn series(needs: &Needs, options: &Options) -> Vec<(Series, Vec<(String, Options)>)> {
    let mut all = Vec::new();
    if needs.lit_opaque.is_some() {
        let four = [Edges::All, Edges::Compare, Edges::Coverage]
            .map(|edges| (format!("4 samples, {edges}"), Options { samples: 4, edges, ..options.clone() }));
        let one = ("1 sample".to_owned(), Options { samples: 1, ..options.clone() });
        all.push((Series::Samples, [vec![one], four.to_vec()].concat()));
    }
    if !needs.decals.is_empty() {
        let ways = [DecalWay::Barrier, DecalWay::RasterOrder, DecalWay::Fixed];
        let on = |layout: Layout| {
            ways.map(|decals| (format!("{decals}, {layout}"), Options { decals, layout, ..options.clone() }))
        };
        all.push((
            Series::Decals,
            [Layout::Metallic128, Layout::Packed128, Layout::Thibieroz128].map(on).concat(),
        ));
    }
    // What is blended is lit as it is drawn, by maps alone.
    let blends = needs.blended.is_some() || needs.transmits.is_some();
    if !blends && needs.shadows.lights.iter().any(|light| light.no_volume.is_none()) {
        let mut ways = Vec::new();
        for (filter, texels) in [ShadowFilter::Hardware, ShadowFilter::Grid3]
            .into_iter()
            .flat_map(|f| [256, 1024].map(|t| (f, t)))
        {
            let mut map = options.clone();
            (map.shadows.filter, map.shadows.tile_texels) = (filter, Some(texels));
            ways.push((format!("{filter}, {texels} texels"), map));
        }
        ways.push(("volumes".into(), Options { shadow_volumes: true, ..options.clone() }));
        all.push((Series::Shadows, ways));
    }
    if needs.blended.is_some() {
        let way = |&translucency| (format!("{translucency}"), Options { translucency, ..options.clone() });
        all.push((Series::Translucency, Translucency::ALL.iter().map(way).collect()));
    }
    if needs.refracts.is_some() {
        let way = |&refraction| (format!("{refraction}"), Options { refraction, ..options.clone() });
        all.push((Series::Refraction, Refraction::ALL.iter().map(way).collect()));
    }
    all
}

/// What is drawn, and how long.
#[derive(Clone, Copy, Debug)]
pub struct Stage<'a> {
    /// By whom.
    pub device: &'a Device,
    /// What.
    pub scene: &'a Scene,
    /// From where.
    pub camera: &'a Camera,
    /// Stops.
    pub exposure_ev: f32,
    /// Of the race of a series.
    pub effort: Effort,
}

impl Stage<'_> {
    /// Measures all ways of all series that the scene has. `step` is told of each series.
    ///
    /// # Errors
    /// [`Error::Vulkan`], and what else drawing may fail with; what single ways are refused for is told in their points.
    pub fn run(&self, options: &Options, step: &dyn Fn()) -> Result<Vec<Point>> {
        let mut points = Vec::new();
        for (series, ways) in series(&Needs::of(self.scene), options) {
            points.extend(self.measure(series, &ways, options)?);
            step();
        }
        Ok(points)
    }

    fn measure(&self, series: Series, ways: &[(String, Options)], options: &Options) -> Result<Vec<Point>> {
        let racer = |way: &(String, Options)| {
            Racer::new(self.device, self.scene, self.camera, self.exposure_ev, &way.1)
        };
        let mut racers: Vec<_> = ways.iter().map(racer).collect();
        race(&mut racers, Clock::of(self.device), self.effort)?;
        let cache = PipelineCache::new(self.device, &[])?;
        let truth = self.truth(series, options, &cache)?;
        let mut points = Vec::new();
        for ((way, options), racer) in ways.iter().zip(racers) {
            let outcome = match racer {
                Ok(racer) => Ok(self.figures(options, racer.frame_ms, &truth, &cache)?),
                Err(refused @ Error::Unsupported { .. }) => Err(refused.to_string()),
                Err(error) => return Err(error),
            };
            let scene = self.scene.name.clone();
            points.push(Point { scene, size: options.size, series, way: way.clone(), outcome });
        }
        Ok(points)
    }

    /// Display light of each pixel that counts.
    fn truth(&self, series: Series, options: &Options, cache: &PipelineCache) -> Result<Vec<Option<DVec3>>> {
        let settings = Settings {
            size: options.size,
            exposure_ev: self.exposure_ev.into(),
            tonemap: options.tonemap,
            around: Method::Prefiltered(options.environment_format),
            lightmap: Some(options.lightmap_format),
            ..Settings::default()
        };
        let shown = |pixel: &Pixel| pixel.display;
        if series == Series::Translucency {
            let (layout, translucency) = (Layout::Exact, Translucency::Peeled);
            let layers = Some(MOST_LAYERS);
            let ruler = Options { layout, translucency, translucency_layers: layers, ..options.clone() };
            return Ok(self.light(ruler, cache)?.into_iter().map(Some).collect());
        }
        if series == Series::Refraction {
            let settings = Settings { behind: Behind::Rays, ..settings };
            let light = supersampled(self.scene, self.camera, &settings, &grid(4), shown);
            let frame = reference::render(self.scene, self.camera, &settings);
            return Ok(light.into_iter().zip(&frame.pixels).map(|(l, p)| (!p.edge).then_some(l)).collect());
        }
        if series == Series::Samples {
            let light = supersampled(self.scene, self.camera, &settings, &grid(8), shown);
            return Ok(light.into_iter().map(Some).collect());
        }
        let frame = if is_textured(self.scene) {
            let Self { device, scene, camera, exposure_ev, .. } = *self;
            let stage = chart::Stage { device, cache, scene, camera, options: options.clone(), exposure_ev };
            let (surfaces, stored) = stage.surfaces()?;
            let settings = Settings { tonemap: options.tonemap, shadows: true, ..stored };
            reference::shade_gbuffer(self.scene, self.camera, &settings, &surfaces)
        } else {
            reference::render(self.scene, self.camera, &settings)
        };
        Ok(frame.pixels.iter().map(|pixel| (!pixel.edge).then_some(pixel.display)).collect())
    }

    fn plan(&self, options: Options) -> Result<Plan> {
        Plan::new(Needs::of(self.scene), options, &self.device.limits())
    }

    /// Display light of each pixel, drawn in floats.
    fn light(&self, options: Options, cache: &PipelineCache) -> Result<Vec<DVec3>> {
        let plan = self.plan(Options { output: OutputFormat::Rgba32Float, ..options })?;
        let mut offscreen = Offscreen::new(self.device, self.scene, plan, RendererConfig::default(), cache)?;
        offscreen.render(&View { camera: self.camera, exposure_ev: self.exposure_ev })?;
        let Pixels::Rgba32F(light) = offscreen.picture().pixels else {
            unreachable!("the output is of floats")
        };
        Ok(light.chunks_exact(4).map(|p| DVec3::new(p[0].into(), p[1].into(), p[2].into())).collect())
    }

    fn figures(
        &self,
        options: &Options,
        frame_ms: Vec<f64>,
        truth: &[Option<DVec3>],
        cache: &PipelineCache,
    ) -> Result<Figures> {
        let light = self.light(options.clone(), cache)?.into_iter();
        let squares =
            light.zip(truth).filter_map(|(light, truth)| Some((light - (*truth)?).length_squared()));
        let (sum, count) = squares.fold((0.0, 0_usize), |(sum, count), square| (sum + square, count + 1));
        let plan = self.plan(options.clone())?;
        let view = View { camera: self.camera, exposure_ev: self.exposure_ev };
        let map = plan.shadow_map.as_ref();
        Ok(Figures {
            frame_ms: Summary::of(frame_ms)
                .ok_or_else(|| Error::unsupported("no round was measured", "allow one with --frames"))?,
            on_tile: plan.bytes_on_tile(),
            moved: plan.bytes_moved(),
            shadow_bytes: map.map_or(0, |map| (0..map.tiles.len()).map(|tile| map.tile_bytes(tile)).sum()),
            error: (sum / (3 * count.max(1)) as f64).sqrt(),
            lit_by_sample: lit_by_sample(self.device, self.scene, &plan, &view, cache)?,
        })
    }
}
