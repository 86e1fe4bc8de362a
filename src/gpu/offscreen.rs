//! A host without a window: renders to an image of its own and reads it back. For the program and for tests.

use std::time::Instant;

use ash::vk;

use super::{
    Commands, CounterQuery, Counters, Device, Image, ImageDesc, OutputImage, PipelineCache, QueryResults,
    Readback, Renderer, RendererConfig, Target, View, conv,
};
use crate::picture::{Picture, Pixels};
use crate::plan::{CounterFigures, DeviceFigures, Figure, Format, Plan, Report};
use crate::scene::{PreRotation, Scene};
use crate::{Error, Result};

/// A renderer with its output image, command buffer and readback.
pub struct Offscreen {
    // In order of destruction; `commands` waits for the GPU first.
    commands: Commands,
    target: Target,
    readback: Readback,
    output: Image,
    renderer: Renderer,
    measured: Vec<Measured>,
}

/// What one frame took.
struct Measured {
    record_ms: f64,
    /// `None` where the plan has no light lists.
    light_lists_ms: Option<f64>,
    queries: QueryResults,
}

impl Offscreen {
    /// Makes the renderer and its image, and uploads the scene.
    ///
    /// # Errors
    /// As [`Renderer::new`].
    pub fn new(
        device: &Device,
        scene: &Scene,
        plan: Plan,
        config: RendererConfig,
        cache: &PipelineCache,
    ) -> Result<Self> {
        let mut renderer = Renderer::new(device, scene, plan, config, cache)?;
        Commands::run(device, "upload", |recorder| {
            renderer.record_upload(recorder);
            Ok(())
        })?;
        renderer.finish_upload();
        let format = renderer.output_format();
        let usage = renderer.output_usage() | vk::ImageUsageFlags::TRANSFER_SRC;
        let size = renderer.plan().options.size;
        let output = Image::new(device, &ImageDesc::new("output", format, size, usage))?;
        let target =
            renderer.create_target(size, &[OutputImage { image: output.raw(), view: output.view() }])?;
        let readback = Readback::new(device, format, size)?;
        let commands = Commands::new(device, "frame")?;
        Ok(Self { commands, target, readback, output, renderer, measured: Vec::new() })
    }

    /// Has pictures drawn turned from now on, as [`Target::pre_rotate`] says; so is [`Self::picture`].
    pub fn pre_rotate(&mut self, pre_rotation: PreRotation) {
        self.target.pre_rotate(pre_rotation);
    }

    /// Renders one frame, waits for it and measures it.
    ///
    /// # Errors
    /// [`Error::Vulkan`], e.g. when the device is lost.
    pub fn render(&mut self, view: &View<'_>) -> Result<()> {
        let Self { commands, target, readback, output, renderer, measured } = self;
        let layout = renderer.output_layout();
        let record_ms = commands.record(|recorder| {
            let start = Instant::now();
            renderer.record(recorder, 0, target, 0, view);
            let record_ms = start.elapsed().as_secs_f64() * 1e3;
            readback.record(recorder, output, 0, layout, layout)?;
            Ok(record_ms)
        })?;
        commands.submit()?;
        commands.wait()?;
        let light_lists = renderer.recorded().light_lists.as_secs_f64() * 1e3;
        measured.push(Measured {
            record_ms,
            light_lists_ms: renderer.plan().clusters.map(|_| light_lists),
            queries: renderer.query_results(0)?,
        });
        Ok(())
    }

    /// Counts a frame: renders it as often as it takes until all of these counters (indices into
    /// [`Counters::all`]) have counted. Neither [`Self::picture`] nor what [`Self::render`] measures are touched; a
    /// [`Self::report`] made afterwards is of the counted frame as far as it is of the last one's commands.
    ///
    /// # Errors
    /// As [`CounterQuery::new`].
    pub fn count(
        &mut self,
        view: &View<'_>,
        counters: &Counters,
        chosen: &[usize],
    ) -> Result<CounterFigures> {
        let Self { target, renderer, .. } = self;
        let query = CounterQuery::new(counters, chosen)?;
        // A query must not be reset in the command buffer that has it.
        Commands::run(renderer.device(), "reset counters", |recorder| {
            query.reset(recorder);
            Ok(())
        })?;
        // The layer (1.4.309) takes the lock for lost in buffers that are older than it.
        let mut commands = Commands::new(renderer.device(), "counted frame")?;
        renderer.set_queries(false);
        let counted = (0..query.passes()).try_for_each(|pass| {
            commands.record(|recorder| {
                query.begin(recorder);
                renderer.record(recorder, 0, target, 0, view);
                query.end(recorder);
                Ok(())
            })?;
            let mut info = query.submit_info(pass);
            commands.submit_as(vk::SubmitInfo::default().push_next(&mut info))?;
            commands.wait()
        });
        renderer.set_queries(true);
        counted.and_then(|()| query.results())
    }

    /// The last frame: 8 bits sRGB or linear floats, as the plan's output format is.
    pub fn picture(&self) -> Picture {
        picture(&self.readback, self.renderer.plan().attachments[0].format)
    }

    /// What an attachment held when the last frame ended, four numbers a pixel (absent channels 0): colours linear, words as they
    /// are.
    /// Only attachments that the plan stores can be read: `Options::keep_gbuffer`.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if there is no such attachment or it is not stored.
    pub fn attachment(&self, name: &str) -> Result<Vec<f64>> {
        let plan = self.renderer.plan();
        let index =
            plan.attachments.iter().position(|a| a.name == name && a.usage.copy_source && !a.is_output);
        let image = index.and_then(|i| self.target.attachment(i));
        let (Some(index), Some(image)) = (index, image) else {
            return Err(Error::unsupported(
                format!("no attachment '{name}' can be read back"),
                "make a plan with `keep_gbuffer` that has it",
            ));
        };
        let mut uses = plan.passes.iter().flat_map(|p| &p.attachments).filter(|a| a.attachment == index);
        let layout = uses.next_back().map_or(vk::ImageLayout::UNDEFINED, |a| conv::layout(a.last));
        let readback = Readback::new(self.renderer.device(), image.format(), image.size())?;
        Commands::run(self.renderer.device(), "read attachment", |recorder| {
            readback.record(recorder, image, 0, layout, layout)
        })?;
        let (format, texels) = (plan.attachments[index].format, readback.texels());
        if format.is_uint() {
            let channels = format.bytes() as usize / 4;
            let word = |t: &[u8]| f64::from(u32::from_le_bytes([t[0], t[1], t[2], t[3]]));
            let texel = |t: &[u8]| {
                let words = t.chunks_exact(4).map(word).chain(std::iter::repeat(0.0));
                words.take(4).collect::<Vec<_>>()
            };
            return Ok(texels.chunks_exact(4 * channels).flat_map(texel).collect());
        }
        Ok(decode(format, texels).into_iter().map(f64::from).collect())
    }

    /// The depths of the shadow map, row by row from the top: reversed, 0 where nothing is.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if nothing was drawn into one, or not for [`RendererConfig::capture`].
    pub fn shadow_map(&self) -> Result<Vec<f32>> {
        let map = self.renderer.plan().shadow_map.as_ref().zip(self.renderer.shadow_image());
        let Some((map, image)) = map else {
            return Err(Error::unsupported("there is no shadow map to read", "render a frame with shadows"));
        };
        let layout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
        let readback = Readback::new(self.renderer.device(), image.format(), image.size())?;
        Commands::run(self.renderer.device(), "read shadow map", |recorder| {
            readback.record(recorder, image, 0, layout, layout)
        })?;
        Ok(decode(map.format, readback.texels()).into_iter().step_by(4).collect())
    }

    /// The renderer.
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// The renderer, to move what it draws.
    pub fn renderer_mut(&mut self) -> &mut Renderer {
        &mut self.renderer
    }

    /// The ledger with what the device said about the frames so far.
    pub fn report(&self, scene: &Scene) -> Report {
        let plan = self.renderer.plan();
        let device = self.renderer.device();
        let mut report = plan.report(scene);
        for (index, attachment) in report.attachments.iter_mut().enumerate() {
            let Some(image) = self.target.attachment(index) else { continue };
            let lazily = image.committed_bytes();
            attachment.lazily_allocated = Some(lazily.is_some());
            let bytes = lazily.unwrap_or(image.allocated_bytes());
            attachment.committed_bytes = Some(Figure::driver(bytes as f64));
        }
        let median_of = |value: &dyn Fn(&Measured) -> Option<f64>| {
            median(self.measured.iter().filter_map(value).collect())
        };
        let until = |m: &Measured, index: usize| Some(m.queries.timestamps_ns.as_ref()?.get(index)? * 1e-6);
        let last = self.measured.last();
        let stamps = last.and_then(|m| m.queries.timestamps_ns.as_ref()).map_or(0, Vec::len);
        let stages = if stamps > 2 { plan.stage_count() } else { 0 };
        let stage_ms = (0..stages).filter_map(|stage| {
            let ms = median_of(&|m| Some(until(m, stage + 1)? - until(m, stage)?))?;
            Some((plan.subpass(stage).2.name.to_owned(), Figure::driver(ms)))
        });
        let statistics = last.and_then(|m| m.queries.statistics).map(|s| {
            [
                ("vertex shader invocations", s.vertex_invocations),
                ("primitives after clipping", s.clipping_primitives),
                ("fragment shader invocations", s.fragment_invocations),
            ]
        });
        let statistics = statistics.into_iter().flatten();
        report.device = Some(DeviceFigures {
            device: device.caps().name.clone(),
            driver: device.caps().driver.clone(),
            has_lazy_memory: device.caps().lazily_allocated_memory,
            merging: self.renderer.merge_reports(),
            gpu_frame_ms: median_of(&|m| until(m, stamps.checked_sub(1)?)).map(Figure::driver),
            gpu_stage_ms: stage_ms.collect(),
            cpu_record_ms: median_of(&|m| Some(m.record_ms)),
            cpu_light_lists_ms: median_of(&|m| m.light_lists_ms),
            statistics: statistics.map(|(name, n)| (name.to_owned(), Figure::driver(n as f64))).collect(),
            frame: self.renderer.recorded().counts,
            shadows: plan.shadow_map.is_some().then(|| self.renderer.recorded().shadows.figures()),
            lit_by_sample: None,
            counters: None,
            frames: self.measured.len(),
            allocated_bytes: self.renderer.scene_bytes(),
            validation_messages: None,
        });
        report
    }
}

/// What was read back of a final image.
pub(super) fn picture(readback: &Readback, format: Format) -> Picture {
    let [width, height] = readback.size();
    let texels = readback.texels();
    let pixels = match format {
        Format::Rgba8Srgb => Pixels::Rgba8(texels.to_vec()),
        Format::Bgra8Srgb => {
            Pixels::Rgba8(texels.chunks_exact(4).flat_map(|t| [t[2], t[1], t[0], t[3]]).collect())
        }
        _ => Pixels::Rgba32F(decode(format, texels)),
    };
    Picture { width, height, pixels }
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    (n > 0).then(|| (values[(n - 1) / 2] + values[n / 2]) * 0.5)
}

/// Texels as four floats each; sRGB-encoded colours become linear.
fn decode(format: Format, texels: &[u8]) -> Vec<f32> {
    let unorm8 = |v: u8| f32::from(v) / 255.0;
    let srgb8 = |v: u8| crate::picture::linear_from_srgb(unorm8(v));
    let bytes4 = texels.chunks_exact(4);
    let word = |t: &[u8]| u32::from_le_bytes([t[0], t[1], t[2], t[3]]);
    match format {
        Format::R32Float | Format::D32Float => {
            bytes4.flat_map(|t| [f32::from_bits(word(t)), 0.0, 0.0, 0.0]).collect()
        }
        Format::Rgba32Float => bytes4.map(|t| f32::from_bits(word(t))).collect(),
        Format::Rgba8Unorm => texels.iter().copied().map(unorm8).collect(),
        Format::Rgba8Srgb => {
            bytes4.flat_map(|t| [srgb8(t[0]), srgb8(t[1]), srgb8(t[2]), unorm8(t[3])]).collect()
        }
        Format::Bgra8Srgb => {
            bytes4.flat_map(|t| [srgb8(t[2]), srgb8(t[1]), srgb8(t[0]), unorm8(t[3])]).collect()
        }
        Format::Rgb10a2Unorm => bytes4
            .map(word)
            .flat_map(|w| {
                [0, 10, 20]
                    .map(|s| (w >> s & 1023) as f32 / 1023.0)
                    .into_iter()
                    .chain([(w >> 30) as f32 / 3.0])
            })
            .collect(),
        Format::D16Unorm => texels
            .chunks_exact(2)
            .flat_map(|t| [f32::from(u16::from_le_bytes([t[0], t[1]])) / 65535.0, 0.0, 0.0, 0.0])
            .collect(),
        Format::D24Unorm => {
            bytes4.flat_map(|t| [(word(t) & 0xff_ffff) as f32 / 16_777_215.0, 0.0, 0.0, 0.0]).collect()
        }
        Format::B10g11r11Float => bytes4
            .map(word)
            .flat_map(|w| {
                let half = |bits: u32| half_to_f32(bits as u16);
                [half((w & 0x7ff) << 4), half((w >> 11 & 0x7ff) << 4), half((w >> 22) << 5), 1.0]
            })
            .collect(),
        Format::R16Float | Format::Rg16Float => {
            let channels = format.bytes() as usize / 2;
            let half = |t: &[u8]| half_to_f32(u16::from_le_bytes([t[0], t[1]]));
            let texel = |t: &[u8]| {
                let halves = t.chunks_exact(2).map(half).chain(std::iter::repeat(0.0));
                halves.take(4).collect::<Vec<_>>()
            };
            texels.chunks_exact(2 * channels).flat_map(texel).collect()
        }
        Format::R8Unorm => texels.iter().flat_map(|&c| [unorm8(c), 0.0, 0.0, 0.0]).collect(),
        Format::Rg8Unorm => {
            texels.chunks_exact(2).flat_map(|t| [unorm8(t[0]), unorm8(t[1]), 0.0, 0.0]).collect()
        }
        Format::Rgba16Unorm => {
            texels.chunks_exact(2).map(|t| f32::from(u16::from_le_bytes([t[0], t[1]])) / 65535.0).collect()
        }
        // Words are not numbers, and nothing keeps a combined format.
        Format::R32Uint | Format::Rg32Uint | Format::Rgba32Uint | Format::D32FloatS8 | Format::D24UnormS8 => {
            Vec::new()
        }
        Format::Rgba16Float => {
            texels.chunks_exact(2).map(|t| half_to_f32(u16::from_le_bytes([t[0], t[1]]))).collect()
        }
    }
}

/// IEEE 754 binary16 to binary32.
fn half_to_f32(h: u16) -> f32 {
    let sign = if h & 0x8000 != 0 { -1.0 } else { 1.0 };
    let fraction = f32::from(h & 0x3ff) / 1024.0;
    match (h >> 10) & 0x1f {
        0 => sign * fraction * 2.0_f32.powi(-14),
        31 if fraction == 0.0 => sign * f32::INFINITY,
        31 => f32::NAN,
        exponent => sign * (1.0 + fraction) * 2.0_f32.powi(i32::from(exponent) - 15),
    }
}
