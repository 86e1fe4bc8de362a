//! Frames: renderers, what they draw to, and recording.

use std::ffi::c_char;

use ash::vk;

use super::ahead::{config_of, plan_of};
use super::call::{Failure, OntileResult, Outcome, call, copy_out, destroy, get, get_mut, give, list, put};
use super::elements::OntileCamera;
use super::host::{OntileDevice, OntilePipelineCache};
use super::options::OntileOptions;
use super::world::OntileWorld;
use crate::gpu::{OutputImage, OverlayPart, PipelineCache, Recorder, Renderer, Target, View};
use crate::scene::PreRotation;

type VkCommandBuffer = vk::CommandBuffer;
type VkImage = vk::Image;
type VkImageView = vk::ImageView;
type VkFormat = vk::Format;
type VkImageUsageFlags = vk::ImageUsageFlags;
type VkImageLayout = vk::ImageLayout;

/// Draws one world by one plan.
pub struct OntileRenderer {
    pub(super) renderer: Renderer,
    /// Kept, so that no frame allocates.
    pub(super) overlay_parts: Vec<OverlayPart>,
}

/// What a renderer draws to: the host's images of one size, and the attachments that exist only while a frame is drawn.
pub struct OntileTarget {
    target: Target,
}

/// What a host's image must be like, and what it is after a frame.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct OntileOutput {
    /// Its format.
    pub format: VkFormat,
    /// Its usage, at least.
    pub usage: VkImageUsageFlags,
    /// Its layout after a frame; before it, layout and content do not matter.
    pub layout: VkImageLayout,
}

/// A host's image.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct OntileOutputImage {
    /// Of the target's size, one sample, one level.
    pub image: VkImage,
    /// 2D, identity swizzle.
    pub view: VkImageView,
}

/// What ontile_renderer_update did.
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct OntileUpdated {
    /// Targets must be created anew; those of frames on the GPU are kept until these have finished.
    pub new_targets: bool,
    /// Pipelines were made.
    pub new_pipelines: bool,
    /// Buffers were made, and copies recorded.
    pub new_objects: bool,
}

/// Makes a renderer of a world as it is now, with all pipelines, and gathers what is to be copied to the device. `options` and `cache`
/// may be null. Afterwards the host calls ontile_world_clear_changes: all that the world is is in the renderer. `frames_in_flight` is how many frames the host may have on the GPU at a time, views counted.
///
/// # Safety
/// All pointers are valid or null as said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_renderer_create(
    device: *const OntileDevice,
    world: *const OntileWorld,
    options: *const OntileOptions,
    frames_in_flight: u32,
    cache: *const OntilePipelineCache,
    renderer: *mut *mut OntileRenderer,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        let (device, world, options, cache) = unsafe {
            (&get(device, "device")?.device, &get(world, "world")?.world, options.as_ref(), cache.as_ref())
        };
        let make = || {
            let plan = plan_of(device, world.scene(), options)?;
            let cache = cache.map_or_else(|| PipelineCache::new(device, &[]), |c| Ok(c.cache.clone()))?;
            let renderer = Renderer::new(device, world.scene(), plan, config_of(frames_in_flight), &cache)?;
            Ok(OntileRenderer { renderer, overlay_parts: Vec::new() })
        };
        // SAFETY: the caller's promise.
        unsafe { give(renderer, "renderer", make) }
    })
}

/// Destroys a renderer; null is none.
///
/// # Safety
/// `renderer` was made by this interface and not destroyed, and the GPU has finished with its frames.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_renderer_destroy(renderer: *mut OntileRenderer) {
    // SAFETY: the caller's promise.
    unsafe { destroy(renderer) }
}

/// The plan as a text: passes, subpasses, attachments, what is loaded and stored, and why. With `text` null it writes its size in bytes;
/// else as much as `size` has room for, and how much that was. There is no zero at its end.
///
/// # Safety
/// All pointers are valid, and `text` has room for `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_renderer_plan(
    renderer: *const OntileRenderer,
    size: *mut usize,
    text: *mut c_char,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        unsafe {
            let plan = get(renderer, "renderer")?.renderer.plan().to_string();
            copy_out(plan.as_bytes(), size, text.cast())
        }
    })
}

/// What the host's images must be like.
///
/// # Safety
/// All pointers are valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_renderer_output(
    renderer: *const OntileRenderer,
    output: *mut OntileOutput,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        unsafe {
            let renderer = &get(renderer, "renderer")?.renderer;
            let told = OntileOutput {
                format: renderer.output_format(),
                usage: renderer.output_usage(),
                layout: renderer.output_layout(),
            };
            put(output, "output", told)
        }
    })
}

/// Records the copies that bring a new renderer's world to the device. The host submits them before the first frame or with it.
///
/// # Safety
/// `commands` is a primary command buffer of the device's queue family, recording, outside of a render pass.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_renderer_record_upload(
    renderer: *mut OntileRenderer,
    commands: VkCommandBuffer,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        let renderer = &mut unsafe { get_mut(renderer, "renderer") }?.renderer;
        let device = renderer.device().clone();
        // SAFETY: the caller's promise.
        renderer.record_upload(&unsafe { Recorder::from_host(&device, commands) });
        Ok(())
    })
}

/// Frees staging memory once the commands of ontile_renderer_record_upload have finished on the GPU.
///
/// # Safety
/// `renderer` is valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_renderer_finish_upload(renderer: *mut OntileRenderer) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        unsafe { get_mut(renderer, "renderer") }?.renderer.finish_upload();
        Ok(())
    })
}

/// Whether frames recorded from now on have queries of their own (timestamps, statistics); at first they have. Those that a host counts by
/// VK_KHR_performance_query want none.
///
/// # Safety
/// `renderer` is valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_renderer_set_queries(
    renderer: *mut OntileRenderer,
    are_recorded: bool,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        unsafe { get_mut(renderer, "renderer") }?.renderer.set_queries(are_recorded);
        Ok(())
    })
}

/// Brings a renderer to the state that its world is in now, for the frames recorded from now on; frames on the GPU go on as they are.
/// Copies are recorded into `commands`, which the host submits before the next frame or with it. Nothing waits. Afterwards, and once
/// the world's other renderers are updated too, the host calls ontile_world_clear_changes. `updated` may be null.
///
/// # Safety
/// All pointers are valid or null as said; `commands` as for ontile_renderer_record_upload.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_renderer_update(
    renderer: *mut OntileRenderer,
    world: *const OntileWorld,
    commands: VkCommandBuffer,
    updated: *mut OntileUpdated,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        let (renderer, world) =
            unsafe { (&mut get_mut(renderer, "renderer")?.renderer, &get(world, "world")?.world) };
        let device = renderer.device().clone();
        // SAFETY: the caller's promise.
        let done = renderer.update(world, &unsafe { Recorder::from_host(&device, commands) })?;
        // SAFETY: the caller's promise.
        if let Some(updated) = unsafe { updated.as_mut() } {
            let crate::gpu::Updated { new_targets, new_pipelines, new_objects } = done;
            *updated = OntileUpdated { new_targets, new_pipelines, new_objects };
        }
        Ok(())
    })
}

/// Makes the attachments that go with the host's images of a size, e.g. those of a swapchain; again after each resize. The old
/// target may still be in use by the GPU: the host destroys it when it no longer is.
///
/// # Safety
/// All pointers are valid; there are `count` images, which live as long as the target.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_target_create(
    renderer: *const OntileRenderer,
    width: u32,
    height: u32,
    images: *const OntileOutputImage,
    count: usize,
    target: *mut *mut OntileTarget,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        unsafe {
            let renderer = &get(renderer, "renderer")?.renderer;
            let outputs = outputs(images, count)?;
            give(target, "target", || {
                Ok(OntileTarget { target: renderer.create_target([width, height], &outputs)? })
            })
        }
    })
}

/// The same for a renderer with the option "difference" (a number that multiplies it), with a view of the other picture: of this size, one
/// sample, any format of colours. When a frame is recorded that picture was drawn by commands before on the same queue, and its image is
/// in VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, as the option "output-use" with "sample" leaves it.
///
/// # Safety
/// As for ontile_target_create; `other` lives as long as the target.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_target_create_beside(
    renderer: *const OntileRenderer,
    width: u32,
    height: u32,
    images: *const OntileOutputImage,
    count: usize,
    other: VkImageView,
    target: *mut *mut OntileTarget,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        unsafe {
            let renderer = &get(renderer, "renderer")?.renderer;
            let outputs = outputs(images, count)?;
            give(target, "target", || {
                let target = renderer.create_target_beside([width, height], &outputs, other)?;
                Ok(OntileTarget { target })
            })
        }
    })
}

/// # Safety
/// There are `count` images.
unsafe fn outputs(images: *const OntileOutputImage, count: usize) -> Outcome<Vec<OutputImage>> {
    // SAFETY: the caller's promise.
    let images = unsafe { list(images, count, "images") }?;
    Ok(images.iter().map(|i| OutputImage { image: i.image, view: i.view }).collect())
}

/// Has pictures drawn turned from now on, clockwise by 0, 90, 180 or 270 degrees, as a screen that is turned shows the images: the
/// preTransform of their swapchain. Cameras stay those of the upright picture. It costs nothing, where a system that turns images reads
/// and writes each again.
///
/// # Safety
/// `target` is valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_target_pre_rotate(target: *mut OntileTarget, degrees: u32) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        let target = &mut unsafe { get_mut(target, "target") }?.target;
        let turned = PreRotation::ALL.get(degrees as usize / 90).filter(|_| degrees.is_multiple_of(90));
        target.pre_rotate(
            *turned.ok_or_else(|| {
                Failure::Argument(format!("{degrees} degrees are none of 0, 90, 180 and 270"))
            })?,
        );
        Ok(())
    })
}

/// Destroys a target; null is none.
///
/// # Safety
/// `target` was made by this interface and not destroyed, and the GPU has finished with its frames.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_target_destroy(target: *mut OntileTarget) {
    // SAFETY: the caller's promise.
    unsafe { destroy(target) }
}

/// Records a frame: it submits nothing, waits for nothing and allocates nothing. `slot` is below frames_in_flight, and the GPU has
/// finished the frame that was recorded with it before. `image` is an index into the target's images. Light is multiplied by 2 to the
/// power of `exposure_ev`. A swapchain's semaphore is waited for at VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT.
///
/// # Safety
/// All pointers are valid; `commands` as for ontile_renderer_record_upload; renderer and target are kept until the GPU has finished.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_renderer_record(
    renderer: *mut OntileRenderer,
    commands: VkCommandBuffer,
    slot: u32,
    target: *const OntileTarget,
    image: u32,
    camera: *const OntileCamera,
    exposure_ev: f32,
) -> OntileResult {
    // SAFETY: the caller's promise.
    unsafe { record((renderer, commands), slot, (target, image), (camera, exposure_ev), None) }
}

/// As ontile_renderer_record, of a part of the picture, upright: left, top, right and bottom, pixels, four numbers. Tiles beyond it are
/// neither drawn nor stored. What is elsewhere in the image is lost, unless the renderer has the option "output-is-kept"; then the image
/// is in the layout that ontile_renderer_output says before too. So two renderers share an image.
///
/// # Safety
/// As for ontile_renderer_record; `part_px` has four numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_renderer_record_part(
    renderer: *mut OntileRenderer,
    commands: VkCommandBuffer,
    slot: u32,
    target: *const OntileTarget,
    image: u32,
    camera: *const OntileCamera,
    exposure_ev: f32,
    part_px: *const u32,
) -> OntileResult {
    // SAFETY: the caller's promise.
    unsafe { record((renderer, commands), slot, (target, image), (camera, exposure_ev), Some(part_px)) }
}

/// # Safety
/// As for ontile_renderer_record_part.
unsafe fn record(
    (renderer, commands): (*mut OntileRenderer, VkCommandBuffer),
    slot: u32,
    (target, image): (*const OntileTarget, u32),
    (camera, exposure_ev): (*const OntileCamera, f32),
    part_px: Option<*const u32>,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        let (renderer, target, camera) = unsafe {
            (
                &mut get_mut(renderer, "renderer")?.renderer,
                &get(target, "target")?.target,
                get(camera, "camera")?.read()?,
            )
        };
        check_slot(renderer, slot)?;
        let images = target.output_count();
        if image as usize >= images {
            return Err(Failure::Argument(format!(
                "image {image} is not below {images}, how many there are"
            )));
        }
        if !renderer.created(target) {
            return Err(Failure::Argument(
                "the target is another renderer's, or older than an update that asked for new ones".into(),
            ));
        }
        let vk::Extent2D { width, height } = target.extent();
        let size = target.pre_rotation().size([width, height]);
        let part_px = match part_px {
            // SAFETY: the caller's promise.
            Some(part) => *unsafe { get(part.cast::<[u32; 4]>(), "part_px") }?,
            None => [0, 0, size[0], size[1]],
        };
        let [left, top, right, bottom] = part_px;
        if left >= right.min(size[0]) || top >= bottom.min(size[1]) {
            return Err(Failure::Argument(format!(
                "nothing of the part {part_px:?} lies in the picture of {} x {} pixels",
                size[0], size[1]
            )));
        }
        let device = renderer.device().clone();
        // SAFETY: the caller's promise.
        let recorder = unsafe { Recorder::from_host(&device, commands) };
        let view = View { camera: &camera, exposure_ev };
        renderer.record_part(&recorder, slot as usize, target, image as usize, &view, part_px);
        Ok(())
    })
}

pub(super) fn check_slot(renderer: &Renderer, slot: u32) -> Outcome {
    let slots = renderer.frames_in_flight();
    match (slot as usize) < slots {
        true => Ok(()),
        false => Err(Failure::Argument(format!("slot {slot} is not below {slots}, how many there are"))),
    }
}
