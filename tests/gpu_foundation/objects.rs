//! Objects are what was asked for, and answer.

use super::*;

#[test]
fn samplers_are_shared() {
    let Some(gpu) = Gpu::new() else { return };
    let mut cache = SamplerCache::new(gpu.device());
    assert!(cache.is_empty());
    let trilinear = scene::Sampler::default();
    let nearest =
        scene::Sampler { mag_linear: false, min_linear: false, mip_linear: Some(false), ..trilinear };
    let first = cache.get(trilinear).unwrap();
    assert_eq!(cache.get(trilinear).unwrap(), first);
    assert_ne!(cache.get(nearest).unwrap(), first);
    // Without mips only the view differs.
    let base_only = scene::Sampler { mip_linear: None, ..nearest };
    assert_eq!(cache.get(base_only).unwrap(), cache.get(nearest).unwrap());
    assert_eq!(cache.len(), 2);
    assert_eq!(gpu.device().live().objects["sampler"], 2);
    drop(cache);
    gpu.finish();
}

#[test]
fn transient_images_take_lazy_memory_where_there_is_some() {
    let Some(gpu) = Gpu::new() else { return };
    let device = gpu.device();
    let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::INPUT_ATTACHMENT;
    // One below and one above the size from which images get memory of their own.
    for size in [[64, 64], [1280, 720]] {
        let desc = ImageDesc::new("normal", vk::Format::R8G8B8A8_UNORM, size, usage);
        let image = Image::transient(device, &desc, false).unwrap();
        assert!(image.usage().contains(vk::ImageUsageFlags::TRANSIENT_ATTACHMENT));
        assert_eq!(image.committed_bytes().is_some(), device.caps().lazily_allocated_memory);
        assert!(image.allocated_bytes() >= u64::from(size[0]) * u64::from(size[1]) * 4);
        assert_eq!(device.live().bytes, image.allocated_bytes());
        assert_ne!(image.view(), vk::ImageView::null());
        let captured = Image::transient(device, &desc, true).unwrap();
        assert_eq!(captured.committed_bytes(), None, "a capture needs ordinary memory");
        assert!(!captured.usage().contains(vk::ImageUsageFlags::TRANSIENT_ATTACHMENT));
    }
    let depth = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::INPUT_ATTACHMENT;
    let depth = ImageDesc::new("depth", vk::Format::D32_SFLOAT, [64, 64], depth);
    drop(Image::transient(device, &depth, false).unwrap());
    gpu.finish();
}

#[test]
fn queries_answer_or_say_nothing() {
    let Some(gpu) = Gpu::new() else { return };
    let device = gpu.device();
    let queries = Queries::new(device, 2, 2).unwrap();
    let mut commands = Commands::new(device, "queries").unwrap();
    commands
        .record(|r| {
            let _label = r.label("queries");
            queries.reset(r, 1);
            queries.timestamp(r, 1, 0, vk::PipelineStageFlags::TOP_OF_PIPE);
            queries.begin_statistics(r, 1);
            queries.end_statistics(r, 1);
            queries.timestamp(r, 1, 1, vk::PipelineStageFlags::BOTTOM_OF_PIPE);
            Ok(())
        })
        .unwrap();
    commands.submit().unwrap();
    assert!(commands.submit().is_err(), "commands run once");
    commands.wait().unwrap();
    let results = queries.results(1).unwrap();
    assert_eq!(results.timestamps_ns.is_some(), device.caps().timestamp_valid_bits > 0);
    if let Some(times) = results.timestamps_ns {
        assert_eq!((times.len(), times[0]), (2, 0.0));
        assert!((0.0..1e10).contains(&times[1]), "{times:?} ns");
    }
    // Nothing was drawn.
    let nothing = device.features().pipeline_statistics.then(PipelineStatistics::default);
    assert_eq!(results.statistics, nothing);
    drop((queries, commands));
    gpu.finish();
}

#[test]
fn a_damaged_pipeline_cache_starts_empty() {
    let Some(gpu) = Gpu::new() else { return };
    let device = gpu.device();
    let blob = PipelineCache::new(device, &[]).unwrap().blob().unwrap();
    let again = PipelineCache::new(device, &blob).unwrap();
    assert_eq!(again.blob().unwrap().len(), blob.len());
    let mut damaged = blob.clone();
    *damaged.last_mut().unwrap() ^= 1;
    for bad in [&damaged[..], &blob[..blob.len() / 2], &[0; 7], &[0xff; 4096]] {
        // The driver never sees it: a cache is made, and is as one from nothing.
        assert_eq!(PipelineCache::new(device, bad).unwrap().blob().unwrap().len(), blob.len());
    }
    drop(again);
    gpu.finish();
}
