//! Pictures of scenes on a device of the test's own.

use super::ignored_unless_required;
use ontile::gpu::{
    Device, Headless, HeadlessOptions, Offscreen, PipelineCache, RendererConfig, View, expected_advice,
};
use ontile::picture::{Picture, Pixels};
use ontile::plan::{Needs, Options, Plan};
use ontile::scene::Scene;
use std::cell::RefCell;
use std::collections::BTreeSet;

/// The name of Mesa's software rasteriser, which every machine can have.
pub const LAVAPIPE: &str = "llvmpipe";

/// A device to render on.
pub struct Gpu<'a> {
    device: &'a Device,
    cache: PipelineCache,
    /// What the layer may say of the plans so far.
    excused: RefCell<BTreeSet<&'static str>>,
}

/// Runs a test on a device under the validation layer and fails if that says anything. Says "ignored" and does not run
/// it without a device of that name (`None`: any).
///
/// A closure, so that no test can forget to ask for the messages, which may come as late as the device's destruction.
pub fn on_device(name_part: Option<&str>, test: impl FnOnce(&Gpu<'_>)) {
    let messages = run(name_part, true, test);
    assert!(messages.is_empty(), "the validation layer says:\n{}", messages.join("\n"));
}

/// As [`on_device`], without validation: for plans that a test has broken.
pub fn on_device_with_faults(test: impl FnOnce(&Gpu<'_>)) {
    run(None, false, test);
}

fn run(name_part: Option<&str>, validate: bool, test: impl FnOnce(&Gpu<'_>)) -> Vec<String> {
    let options = HeadlessOptions {
        device_name_part: name_part.map(str::to_owned),
        validate,
        application_name: "ontile tests".into(),
        ..HeadlessOptions::default()
    };
    let host = match Headless::new(&options) {
        Ok(host) => host,
        Err(error) => {
            ignored_unless_required(&error.to_string());
            return Vec::new();
        }
    };
    let cache = PipelineCache::new(host.device(), &[]).expect("an empty pipeline cache");
    let gpu = Gpu { device: host.device(), cache, excused: RefCell::default() };
    test(&gpu);
    let excused = gpu.excused.take();
    drop(gpu);
    let mut messages = host.finish();
    messages.retain(|message| !excused.iter().any(|excuse| message.contains(excuse)));
    messages
}

impl Gpu<'_> {
    /// The device.
    pub fn device(&self) -> &Device {
        self.device
    }

    /// A pipeline cache of this run.
    pub fn cache(&self) -> &PipelineCache {
        &self.cache
    }

    /// Lets the layer say what contains this part.
    pub fn excuse(&self, part: &'static str) {
        self.excused.borrow_mut().insert(part);
    }

    /// The plan of a scene on this device.
    pub fn plan(&self, scene: &Scene, options: Options) -> Plan {
        let plan = Plan::new(Needs::of(scene), options, &self.device.limits());
        let plan = plan.unwrap_or_else(|error| panic!("{}: {error}", scene.name));
        self.excused.borrow_mut().extend(expected_advice(&plan));
        plan
    }

    /// A renderer with an image of its own.
    pub fn offscreen(&self, scene: &Scene, plan: Plan, config: RendererConfig) -> Offscreen {
        let offscreen = Offscreen::new(self.device, scene, plan, config, &self.cache);
        offscreen.unwrap_or_else(|error| panic!("{}: {error}", scene.name))
    }

    /// One frame of the scene's first camera.
    pub fn picture(&self, scene: &Scene, plan: Plan, exposure_ev: f32) -> Picture {
        self.picture_with(scene, plan, exposure_ev, RendererConfig::default())
    }

    /// As [`Self::picture`], with a renderer set up differently.
    pub fn picture_with(
        &self,
        scene: &Scene,
        plan: Plan,
        exposure_ev: f32,
        config: RendererConfig,
    ) -> Picture {
        let mut offscreen = self.offscreen(scene, plan, config);
        let view = View { camera: &scene.cameras[0], exposure_ev };
        offscreen.render(&view).unwrap_or_else(|error| panic!("{}: {error}", scene.name));
        offscreen.picture()
    }
}

/// What differs between two pictures of one size and format, bit by bit.
pub fn difference(a: &Picture, b: &Picture) -> Option<String> {
    assert_eq!([a.width, a.height], [b.width, b.height], "pictures of two sizes");
    let bits = |p: &Picture| -> Vec<u32> {
        match &p.pixels {
            Pixels::Rgba8(channels) => channels.iter().map(|&c| c.into()).collect(),
            Pixels::Rgba32F(channels) => channels.iter().map(|c| c.to_bits()).collect(),
        }
    };
    let (a_bits, b_bits) = (bits(a), bits(b));
    assert_eq!(a_bits.len(), b_bits.len(), "pictures of two formats");
    let differing: Vec<_> = a_bits
        .chunks(4)
        .zip(b_bits.chunks(4))
        .enumerate()
        .filter(|(_, (a, b))| a != b)
        .map(|(i, _)| i)
        .collect();
    let first = *differing.first()? as u32;
    let [x, y] = [first % a.width, first / a.width];
    Some(format!("{} pixels differ, the first at {x}, {y}", differing.len()))
}
