//! What a host asks before there is a renderer: the plan, its pipelines, what it will take.

use std::ffi::c_char;

use super::call::{OntileResult, Outcome, call, copy_out, get, put};
use super::host::{OntileDevice, OntilePipelineCache};
use super::options::OntileOptions;
use super::world::OntileWorld;
use crate::gpu::{Device, MemoryBudget, RendererConfig};
use crate::plan::{Needs, Plan};
use crate::scene::Scene;

/// Bytes of device memory, as sums of contents: a device adds what it aligns and rounds to.
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct OntileBudget {
    /// Of a renderer, whatever it draws to.
    pub renderer_bytes: u64,
    /// Of a target of the size asked for, without the host's images.
    pub target_bytes: u64,
    /// The same on a device with lazily allocated memory that stays on the tile.
    pub lazy_target_bytes: u64,
}

/// The plan of a world on a device. Without options they are the usual ones.
pub(super) fn plan_of(
    device: &Device,
    scene: &Scene,
    options: Option<&OntileOptions>,
) -> crate::Result<Plan> {
    let options = options.map(|o| o.options.clone()).unwrap_or_default();
    Plan::new(Needs::of(scene), options, &device.limits())
}

pub(super) fn config_of(frames_in_flight: u32) -> RendererConfig {
    RendererConfig { frames_in_flight: frames_in_flight.max(1) as usize, ..RendererConfig::default() }
}

/// Plans, and does something with it.
///
/// # Safety
/// The pointers are valid; `options` may be null.
unsafe fn with_plan(
    (device, world, options): (*const OntileDevice, *const OntileWorld, *const OntileOptions),
    then: impl FnOnce(&Device, &Scene, Plan) -> Outcome,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        let (device, world, options) =
            unsafe { (&get(device, "device")?.device, &get(world, "world")?.world, options.as_ref()) };
        then(device, world.scene(), plan_of(device, world.scene(), options)?)
    })
}

/// The plan that a renderer of this world would have, as ontile_renderer_plan tells it. `options` may be null.
///
/// # Safety
/// All pointers are valid or null as said, and `text` has room for `size` bytes or is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_plan_text(
    device: *const OntileDevice,
    world: *const OntileWorld,
    options: *const OntileOptions,
    size: *mut usize,
    text: *mut c_char,
) -> OntileResult {
    // SAFETY: the caller's promise.
    unsafe {
        with_plan((device, world, options), |_, _, plan| {
            copy_out(plan.to_string().as_bytes(), size, text.cast())
        })
    }
}

/// The pipelines of that plan, a line each: the subpass, a space, what is drawn. Sizes and `text` as for ontile_plan_text.
///
/// # Safety
/// As for ontile_plan_text.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_plan_pipelines(
    device: *const OntileDevice,
    world: *const OntileWorld,
    options: *const OntileOptions,
    size: *mut usize,
    text: *mut c_char,
) -> OntileResult {
    // SAFETY: the caller's promise.
    unsafe {
        with_plan((device, world, options), |_, _, plan| {
            let line = |(stage, pipeline): &(usize, crate::plan::Pipeline)| {
                format!("{} {}", plan.subpass(*stage).2.name, plan.pipeline_text(pipeline))
            };
            let lines: Vec<_> = plan.pipelines.iter().map(line).collect();
            copy_out(lines.join("\n").as_bytes(), size, text.cast())
        })
    }
}

/// Compiles all pipelines of that plan into a cache, those of shadow maps included, so that making the renderer with it does not. It may take
/// long, and run on any thread, as long as nobody changes the world.
///
/// # Safety
/// All pointers are valid or null as said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_pipeline_cache_prepare(
    cache: *const OntilePipelineCache,
    device: *const OntileDevice,
    world: *const OntileWorld,
    options: *const OntileOptions,
) -> OntileResult {
    // SAFETY: the caller's promise.
    unsafe {
        with_plan((device, world, options), |_, _, plan| Ok(get(cache, "cache")?.cache.prepare(&plan)?))
    }
}

/// What device memory a renderer of this world, for so many frames in flight, and a target of this size will take. `options` may be null.
///
/// # Safety
/// All pointers are valid or null as said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_plan_budget(
    device: *const OntileDevice,
    world: *const OntileWorld,
    options: *const OntileOptions,
    frames_in_flight: u32,
    width: u32,
    height: u32,
    budget: *mut OntileBudget,
) -> OntileResult {
    // SAFETY: the caller's promise.
    unsafe {
        with_plan((device, world, options), |device, scene, plan| {
            let (config, size) = (config_of(frames_in_flight), [width, height]);
            let found = MemoryBudget::new(scene, &plan, &config, device.features(), size)?;
            let told = OntileBudget {
                renderer_bytes: found.renderer_bytes(),
                target_bytes: found.target_bytes(false),
                lazy_target_bytes: found.target_bytes(true),
            };
            put(budget, "budget", told)
        })
    }
}
