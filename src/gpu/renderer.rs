//! The renderer: a plan made of Vulkan objects, and frames recorded with them.

mod decals;
mod frame;
mod overlay;
mod particles;
mod post;
mod record;
mod retired;
#[cfg(feature = "view")]
mod seen;
mod shadow_volumes;
mod told;
mod update;

use std::sync::Arc;

use ash::vk;
use glam::Mat4;

use super::fragments::FragmentQueries;
use super::overlay::Overlay;
use super::pass::VulkanPass;
use super::pipeline::Pipelines;
use super::poses::Poses;
use super::post::PostPasses;
use super::scene_data::SceneData;
use super::shadow::{RecordedShadows, ShadowResources, Shadows};
use super::target::check_formats;
use super::{Device, Image, OutputImage, PipelineCache, Queries, Recorder, Target, Upload, conv};
use crate::plan::{FrameCounts, MergeReport, Needs, OutputUse, Pipeline, Plan, State, Usage};
use crate::scene::{Changes, Decal, Light, Particle, Pose, Scene};
use crate::{Error, Result};
use retired::Retired;
#[cfg(feature = "view")]
pub(crate) use seen::{SeenLight, SeenLights};
pub use update::Updated;

/// How a [`Renderer`] is set up.
#[derive(Clone, Copy, Debug)]
pub struct RendererConfig {
    /// Frames that the host may have on the GPU at the same time, at least 1.
    pub frames_in_flight: usize,
    /// Give transient attachments ordinary memory, so that frame debuggers can read them, and allow copies of the shadow
    /// map. Same pixels.
    pub capture: bool,
    /// Take a timestamp after every subpass, not only around the frame. On tilers only the ones around the
    /// frame mean anything, since subpasses of different tiles interleave.
    pub stage_timestamps: bool,
    /// Leave out objects and lights that the view cannot see. Same pixels.
    pub cull: bool,
    /// Tiles of the shadow map that one frame draws again at most, so that frames take alike. While a tile waits, its shadows
    /// are those of when it was drawn last. Tiles that were never drawn do not wait.
    pub shadow_tiles_per_frame: usize,
    /// Count the fragments of every draw, for [`Renderer::draw_counts`]. Tilers may lose time by it. Same pixels.
    pub count_fragments: bool,
}

impl Default for RendererConfig {
    fn default() -> Self {
        Self {
            frames_in_flight: 2,
            capture: false,
            stage_timestamps: false,
            cull: true,
            shadow_tiles_per_frame: usize::MAX,
            count_fragments: false,
        }
    }
}

/// Draws one scene by one plan.
///
/// The host owns command buffers, queue submissions and output images; the renderer records and never waits.
///
/// 1. [`Renderer::new`] makes all objects and stages the scene's data.
/// 2. [`Renderer::record_upload`] goes into a command buffer that the host submits before the first frame; once that
///    has finished, [`Renderer::finish_upload`] frees the staging memory.
/// 3. [`Renderer::create_target`] wraps the host's images, again after each resize.
/// 4. [`Renderer::record`] records a frame. Frame slot `n` may be recorded again once the host knows that the GPU has
///    finished the frame recorded with it before (a fence or timeline semaphore).
///
/// Renderer and targets must be dropped only when no frame that uses them is on the GPU. Several renderers on one
/// device are independent of each other.
pub struct Renderer {
    // In order of destruction.
    upload: Option<Upload>,
    /// What frames on the GPU still use of earlier states of the scene.
    retired: Retired,
    queries: Arc<Queries>,
    /// Whether these and `fragments` are recorded.
    has_queries: bool,
    fragments: Option<FragmentQueries>,
    shadows: Option<Shadows>,
    /// `None` if the plan has none.
    overlay: Option<Overlay>,
    scene: SceneData,
    /// `None` if the plan has no passes after the frame's own.
    post: Option<Arc<PostPasses>>,
    pipelines: Arc<Pipelines>,
    /// Shared with the targets, which are of these passes.
    passes: Arc<[VulkanPass]>,
    cache: PipelineCache,
    plan: Plan,
    config: RendererConfig,
    device: Device,
    recorded: Recorded,
}

/// What recording a frame did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Recorded {
    /// What it put into the command buffer.
    pub counts: FrameCounts,
    /// CPU time of listing the lights of each part of the view; 0 where the plan has no light lists.
    pub light_lists: std::time::Duration,
    /// The shadow map's part; its draws and state changes are not among the above.
    pub shadows: RecordedShadows,
}

impl Renderer {
    /// Makes everything that the plan lists.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the device lacks a format, the plan was made for another scene, or a number of the scene means
    /// nothing ([`Scene::check`]);
    /// [`Error::Vulkan`].
    pub fn new(
        device: &Device,
        scene: &Scene,
        plan: Plan,
        config: RendererConfig,
        cache: &PipelineCache,
    ) -> Result<Self> {
        if plan.needs != Needs::of(scene).shown(plan.options.show) {
            return Err(Error::unsupported(
                format!("the plan does not match what scene '{}' needs", scene.name),
                "make the plan from this scene's `Needs`, after the last change to the scene",
            ));
        }
        scene.check()?;
        check_formats(device, &plan)?;
        Self::with(device, scene, plan, config, cache, None)
    }

    /// Makes a renderer that shares with another one what has not changed.
    fn with(
        device: &Device,
        scene: &Scene,
        plan: Plan,
        config: RendererConfig,
        cache: &PipelineCache,
        kept: Option<(&Self, &Changes)>,
    ) -> Result<Self> {
        let old = kept.map(|(old, _)| old);
        let same_passes = old.filter(|old| old.plan.shares_passes(&plan));
        let same_pipelines = same_passes.filter(|old| old.plan.shares_pipelines(&plan));
        let passes = match same_passes {
            Some(old) => Arc::clone(&old.passes),
            None => plan
                .passes
                .iter()
                .map(|pass| VulkanPass::new(device, &plan, pass))
                .collect::<Result<Arc<[_]>>>()?,
        };
        let pipelines = match same_pipelines {
            Some(old) => Arc::clone(&old.pipelines),
            None => Arc::new(Pipelines::new(device, &plan, &passes, cache)?),
        };
        let post = match same_pipelines {
            Some(old) => old.post.clone(),
            None => PostPasses::new(device, &plan, &pipelines, cache)?.map(Arc::new),
        };
        let mut upload = Upload::new(device);
        let slot_count = config.frames_in_flight.max(1);
        let map = plan.shadow_map.as_ref();
        let resources = map.map(|map| ShadowResources::new(device, map, slot_count, config.capture));
        let resources = resources.transpose()?;
        let kept_data = kept.map(|(old, changes)| (&old.scene, changes));
        let data = SceneData::new(
            device,
            scene,
            &plan,
            &pipelines,
            resources.as_ref(),
            slot_count,
            (&mut upload, cache, kept_data),
        )?;
        let shadows = map.zip(resources).map(|(map, resources)| {
            let most = config.shadow_tiles_per_frame;
            let old = old.and_then(|old| old.shadows.as_ref());
            Shadows::new(device, scene, (&plan, map), (resources, &data), most, (cache, old))
        });
        let shadows = shadows.transpose()?;
        let drawn_over = plan.pipelines.iter().position(|(_, p)| *p == Pipeline::Overlay);
        let overlay = drawn_over
            .map(|index| Overlay::new(device, index, pipelines.layout_of(index), slot_count, &mut upload));
        let overlay = overlay.transpose()?;
        let timestamps = if config.stage_timestamps { plan.stage_count() + 1 } else { 2 };
        let queries = match old.filter(|old| old.queries.per_frame() == timestamps as u32) {
            Some(old) => Arc::clone(&old.queries),
            None => Arc::new(Queries::new(device, timestamps as u32, slot_count as u32)?),
        };
        let fragments = config
            .count_fragments
            .then(|| FragmentQueries::new(device, &plan, data.objects().most_runs(), slot_count));
        Ok(Self {
            upload: Some(upload),
            queries,
            has_queries: old.is_none_or(|old| old.has_queries),
            fragments: fragments.transpose()?,
            shadows,
            overlay,
            scene: data,
            post,
            pipelines,
            passes,
            cache: cache.clone(),
            plan,
            config,
            device: device.clone(),
            recorded: old.map_or_else(Recorded::default, |old| old.recorded),
            retired: Retired::new(slot_count),
        })
    }

    /// Records the copies that bring the scene to the device; does nothing after [`Self::finish_upload`].
    pub fn record_upload(&mut self, recorder: &Recorder<'_>) {
        if let Some(upload) = &mut self.upload {
            upload.record(recorder);
        }
    }

    /// Frees the staging memory. The commands of [`Self::record_upload`] must have finished on the GPU.
    pub fn finish_upload(&mut self) {
        self.upload = None;
    }

    /// Makes the attachments that go with the host's images, which are of this size in pixels. A renderer can have
    /// targets of several sizes; the plan's own size is only the one that reports speak of.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the device has no images of that size; [`Error::Vulkan`].
    pub fn create_target(&self, size: [u32; 2], outputs: &[OutputImage]) -> Result<Target> {
        self.target(size, (outputs, None))
    }

    /// The same for a plan with [`Options::difference`](crate::plan::Options::difference), with a view of the other picture: of this
    /// size, one sample, any format of colours. When a frame is recorded that picture was drawn by commands before on the same queue, and
    /// its image is in SHADER_READ_ONLY_OPTIMAL ([`OutputUse::Sample`] leaves it so). The host keeps image and view alive as long as the
    /// target.
    ///
    /// # Errors
    /// As [`Self::create_target`].
    pub fn create_target_beside(
        &self,
        size: [u32; 2],
        outputs: &[OutputImage],
        other: vk::ImageView,
    ) -> Result<Target> {
        self.target(size, (outputs, Some(other)))
    }

    fn target(&self, size: [u32; 2], images: (&[OutputImage], Option<vk::ImageView>)) -> Result<Target> {
        let Self { device, plan, passes, pipelines, post, config, .. } = self;
        let post = post.as_deref();
        Target::new(device, plan, passes, pipelines, post, size, images, config.capture)
    }

    /// The format that output images must have.
    pub fn output_format(&self) -> vk::Format {
        conv::format(self.plan.attachments[0].format)
    }

    /// The usage that output images must have at least.
    pub fn output_usage(&self) -> vk::ImageUsageFlags {
        match self.plan.post.draws_output() {
            true => conv::usage(Usage {
                color: true,
                copy_source: self.plan.options.output_use == OutputUse::Copy,
                ..Usage::default()
            }),
            false => conv::usage(self.plan.attachments[0].usage),
        }
    }

    /// The layout that a frame leaves its output image in; what it is in before does not matter.
    pub fn output_layout(&self) -> vk::ImageLayout {
        conv::layout(State::after_frame(self.plan.options.output_use))
    }

    /// The plan.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The device.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// What the driver says it makes of the subpasses of each render pass; empty where it does not
    /// ([`Features::subpass_merge_feedback`](super::Features::subpass_merge_feedback)).
    pub fn merge_reports(&self) -> Vec<MergeReport> {
        self.passes.iter().filter_map(VulkanPass::merge_report).cloned().collect()
    }

    /// How many frames the host may have on the GPU at a time: slots are below.
    pub fn frames_in_flight(&self) -> usize {
        self.config.frames_in_flight.max(1)
    }

    /// Whether frames can be recorded to a target: it is of [`Self::create_target`], after the last update that asked for new ones.
    pub fn created(&self, target: &Target) -> bool {
        target.is_of(&self.passes)
    }

    /// What the last [`Self::record`] recorded.
    pub fn recorded(&self) -> Recorded {
        self.recorded
    }

    /// Device memory of the scene's buffers and textures.
    pub fn scene_bytes(&self) -> u64 {
        self.scene.allocated_bytes() + self.shadows.as_ref().map_or(0, Shadows::allocated_bytes)
    }

    /// Moves the scene's instance `index` for the frames recorded from now on. Those on the GPU go on as they are.
    ///
    /// Moving what is not [dynamic](crate::scene::Instance::dynamic) costs more: what was kept of static objects is
    /// made anew.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the scene has no such instance, the matrix is not affine and finite, or the instance would
    /// become mirrored or cease to be (its determinant's sign): that takes another pipeline. Nothing is changed then.
    pub fn set_instance(&mut self, index: usize, world_from_object: &Mat4) -> Result<()> {
        self.scene.set_instance(index, world_from_object)?;
        if let Some(shadows) = &mut self.shadows {
            shadows.set_instance(index, world_from_object);
        }
        Ok(())
    }

    /// Poses the scene's mesh `index`, which [bends](crate::scene::Mesh::deformation), for the frames recorded from now on: the next one
    /// poses it before all else.
    ///
    /// Instances of it that are not [dynamic](crate::scene::Instance::dynamic) count as moved.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the pose is of other joints or morph targets than the mesh's, or a number is not finite. Nothing is
    /// changed then.
    pub fn set_pose(&mut self, index: usize, pose: &Pose) -> Result<()> {
        if let Some(bounds) = self.scene.set_pose(index, pose)?
            && let Some(shadows) = &mut self.shadows
        {
            shadows.set_bounds(index, &bounds);
        }
        Ok(())
    }

    /// How often an instance that is not dynamic was moved so far.
    pub fn static_moves(&self) -> u64 {
        self.scene.objects().static_moves()
    }

    /// Changes the scene's light `index` for the frames recorded from now on: place, direction, colour, intensity, range
    /// and cone. It may become dark and light up again, and cease to cast a shadow; only a light that did when the plan was
    /// made can begin to.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the scene has no such light, a number is not finite, or it takes what the plan does not
    /// have: another kind, or light of a kind of which the scene had none that was not dark. Nothing is changed then.
    pub fn set_light(&mut self, index: usize, light: &Light) -> Result<()> {
        if let Some(shadows) = &self.shadows {
            shadows.check_light(index, light)?;
        }
        self.scene.lights_mut().set(index, light)?;
        if let Some(shadows) = &mut self.shadows {
            shadows.set_light(index, light);
        }
        Ok(())
    }

    /// Changes the scene's decal `index` for the frames recorded from now on: its box, opacities, angles and falloff.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the scene has no such decal, a number means nothing, or it takes what the plan does not have:
    /// another material or priority, or a channel that it did not paint. Nothing is changed then.
    pub fn set_decal(&mut self, index: usize, decal: &Decal) -> Result<()> {
        self.scene.decals_mut().set(index, decal)
    }

    /// Puts other particles in the place of the scene's element `index`, for the frames recorded from now on.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the scene has no such element, a number means nothing, or there are more than
    /// [`Particles::most`](crate::scene::Particles::most). Nothing is changed then.
    pub fn set_particles(&mut self, index: usize, list: &[Particle]) -> Result<()> {
        self.scene.particles_mut().set(index, list)
    }

    /// The shadow map, if something was drawn into it; between frames in SHADER_READ_ONLY_OPTIMAL.
    pub(super) fn shadow_image(&self) -> Option<&Image> {
        self.shadows.as_ref().and_then(Shadows::image)
    }

    /// Draws the shadow map anew with the next frame, and poses meshes anew. Both are kept on the assumption that the GPU executes every frame that
    /// was recorded, in the order of recording; a host that drops one says so here.
    pub fn redraw_shadows(&mut self) {
        self.scene.poses_mut().into_iter().for_each(Poses::redo);
        if let Some(shadows) = &mut self.shadows {
            shadows.redraw();
        }
    }
}
