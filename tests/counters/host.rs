//! A host that lends its device and counts frames of its own.

use ontile::gpu::ash;
use ontile::gpu::{
    CounterQuery, Counters, Device, Features, Headless, HeadlessOptions, HostDevice, Offscreen,
    PipelineCache, RendererConfig, View,
};
use ontile::plan::{CounterFigures, Needs, Options, Plan};
use ontile::scene::Scene;

/// What the validation layer says of it.
pub fn counts() -> Vec<String> {
    let options = HeadlessOptions {
        device_name_part: Some(super::LAVAPIPE.into()),
        validate: true,
        performance_counters: true,
        ..HeadlessOptions::default()
    };
    let theirs = Headless::new(&options).unwrap();
    let lend = |features: Features| {
        let device = theirs.device();
        let lent = HostDevice {
            instance: device.instance().clone(),
            physical_device: device.physical_device(),
            device: device.raw().clone(),
            queue_family: device.queue_family(),
            queue: *device.queue(),
            callbacks: None,
            allocator: None,
            features,
        };
        // SAFETY: the handles are of one device, which outlives what is made from it.
        unsafe { Device::from_host(lent) }.unwrap()
    };
    // SAFETY: the system's Vulkan library is loaded.
    let entry = unsafe { ash::Entry::load() }.unwrap();
    let without = lend(Features::default());
    // SAFETY: the instance was made with the functions of the same library, here and below.
    let refused = unsafe { Counters::from_host(&entry, &without) }.err().unwrap().to_string();
    assert!(refused.contains("was made without performance counters; enable"), "{refused}");

    let device = lend(Features { performance_counters: true, ..Features::default() });
    // SAFETY: as above.
    let counters = unsafe { Counters::from_host(&entry, &device) }.unwrap();
    for chosen in [&[][..], &[8], &[0, usize::MAX]] {
        let refused = CounterQuery::new(&counters, chosen).err().unwrap().to_string();
        assert!(refused.contains("are not indices of the 8 performance counters"), "{refused}");
    }
    let held = CounterQuery::new(&counters, &[0, 1]).unwrap();
    assert_eq!((held.passes(), device.live().objects["query_pool"]), (2, 1));
    let refused = CounterQuery::new(&counters, &[0]).err().unwrap().to_string();
    assert!(refused.contains("one query at a time; drop the other"), "{refused}");
    drop(held);
    assert_eq!(device.live().objects.get("query_pool"), None);

    let scene = Scene::load(super::scene("lamps.glb").as_ref()).unwrap();
    let options = Options { size: [64, 36], ..Options::default() };
    let plan = Plan::new(Needs::of(&scene), options, &device.limits()).unwrap();
    let cache = PipelineCache::new(&device, &[]).unwrap();
    let config = RendererConfig { stage_timestamps: true, ..RendererConfig::default() };
    let mut frame = Offscreen::new(&device, &scene, plan, config, &cache).unwrap();
    let view = View { camera: &scene.cameras[0], exposure_ev: 0.0 };
    frame.render(&view).unwrap();
    let values = |figures: CounterFigures| -> Vec<_> {
        figures.counters.iter().map(|counter| counter.value.unwrap().value).collect()
    };
    let all = counters.choose(&["draws", "render passes", "busy"]).unwrap();
    let first = frame.count(&view, &counters, &all).unwrap();
    assert_eq!(values(first), [frame.renderer().recorded().counts.draws as f64, 1.0, 62.5]);
    // Frames between have their own queries again, and a query of less passes is another one.
    frame.render(&view).unwrap();
    let times = frame.renderer().query_results(0).unwrap().timestamps_ns.unwrap();
    assert!(times.len() > 2 && times.windows(2).all(|pair| pair[0] <= pair[1]), "{times:?}");
    let second = frame.count(&view, &counters, &all[..1]).unwrap();
    assert_eq!(second.passes, 1);
    drop((frame, cache, counters, device, without));
    theirs.finish()
}
