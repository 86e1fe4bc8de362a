//! What a renderer takes is known before there is one.

use super::*;
use crate::common::scenes::shipped;
use ontile::gpu::MemoryBudget;
use ontile::plan::BloomWay;

/// What devices add to each allocation: alignment, and pages of large images.
const ROUNDING_BYTES: u64 = 4096;

#[test]
fn memory_is_what_the_budget_said() {
    let device_name_part = Some("llvmpipe".into());
    let options = HeadlessOptions { device_name_part, ..HeadlessOptions::default() };
    let host = match Headless::new(&options) {
        Ok(host) => host,
        Err(reason) => return common::ignored_unless_required(&reason.to_string()),
    };
    let device = host.device();
    let cache = PipelineCache::new(device, &[]).unwrap();
    let size = [96, 64];
    let of = |samples, bloom, shadow_volumes| Options {
        size,
        samples,
        bloom,
        shadow_volumes,
        ..Options::default()
    };
    for scene in shipped() {
        for options in [of(1, BloomWay::Off, false), of(4, BloomWay::Store, true)] {
            let Ok(plan) = Plan::new(Needs::of(&scene), options, &device.limits()) else { continue };
            let config = RendererConfig { frames_in_flight: 3, ..RendererConfig::default() };
            let budget = MemoryBudget::new(&scene, &plan, &config, device.features(), size).unwrap();
            cache.prepare(&plan).unwrap();
            assert_eq!(device.live().bytes, 0, "{}: preparing keeps no memory", scene.name);

            let mut renderer = Renderer::new(device, &scene, plan, config, &cache).unwrap();
            renderer.finish_upload();
            let renderer_live = device.live();
            let close = |what: &str, bytes: u64, budget: u64, allocations: usize| {
                let most = budget + allocations as u64 * ROUNDING_BYTES;
                let name = &scene.name;
                assert!((budget..=most).contains(&bytes), "{name}: {what}: {bytes} bytes, {budget} budgeted");
            };
            close("renderer", renderer_live.bytes, budget.renderer_bytes(), renderer_live.allocations);

            let output = renderer.output_format();
            let usage = renderer.output_usage();
            let image =
                ontile::gpu::Image::new(device, &ontile::gpu::ImageDesc::new("output", output, size, usage))
                    .unwrap();
            let before = device.live();
            let outputs = [OutputImage { image: image.raw(), view: image.view() }];
            let target = renderer.create_target(size, &outputs).unwrap();
            let after = device.live();
            let lazily = device.caps().lazily_allocated_memory;
            let allocations = after.allocations - before.allocations;
            close("target", after.bytes - before.bytes, budget.target_bytes(lazily), allocations);
            drop((target, image, renderer));
        }
    }
}
