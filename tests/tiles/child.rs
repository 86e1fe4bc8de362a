//! What the judged process does: render a scene by a plan, perhaps a spoilt one, and write down what happened.

use crate::common::scenes;
use ontile::glam::{Mat4, Vec3};
use ontile::gpu::{
    Headless, HeadlessOptions, Offscreen, OverlayFrame, OverlayPart, OverlayVertex, PipelineCache,
    RendererConfig, View, expected_advice,
};
use ontile::plan::{
    Access, Adreno, Bins, BloomWay, DecalWay, DepthStore, Edges, Layout, LightWay, Limits, Merging, Needs,
    Options, Path as LightPath, Plan, Refraction, Show, Store, Strategy, Translucency,
};
use ontile::scene::{Scene, Shadow};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What to render.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Case {
    /// One of `scenes::built` or `scenes::shipped`, by name.
    pub scene: String,
    pub layout: Layout,
    pub depth: Option<DepthStore>,
    pub path: LightPath,
    pub lights: LightWay,
    pub depth_prepass: bool,
    pub strategy: Strategy,
    pub recycle: bool,
    pub samples: u32,
    pub edges: Edges,
    pub bloom: BloomWay,
    pub translucency: Translucency,
    pub shadow_volumes: bool,
    /// A triangle is drawn over the picture.
    pub overlay: bool,
    pub fault: Option<Fault>,
    /// `RendererConfig::capture`.
    pub capture: bool,
    /// `RendererConfig::stage_timestamps`.
    pub stage_timestamps: bool,
    /// The last instance is dynamic, and moves before a second frame.
    pub moves: bool,
    pub decals: DecalWay,
    pub refraction: Refraction,
    pub show: Show,
    /// Another frame beside it, or that it is compared with.
    pub beside: Option<Beside>,
}

/// What a second renderer draws to the same image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Beside {
    /// The right part of it, from this column on.
    Split(u32),
    /// All of it: how far the pictures are apart.
    Difference,
}

/// What is wrong with the plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fault {
    /// Dependencies between subpasses let a pixel depend on any other one.
    NotByRegion,
    /// Lighting does not wait for geometry.
    DependencyDropped,
    /// What waits for a dependency is only what reads, not the discarding store that writes at the end of the pass.
    StoreNotCovered,
    /// An attachment that only lighting reads is stored.
    Stored,
    /// The same, and the image is no longer made for lazily allocated memory.
    StoredInMemory,
    /// Of the dependency of a subpass on itself alone: it lets a pixel depend on any other one.
    ItselfNotByRegion,
    /// There is none.
    ItselfDropped,
}

/// What the child tells.
#[derive(Debug, Serialize, Deserialize)]
pub struct Told {
    /// `ontile::plan::Report`.
    pub report: serde_json::Value,
    /// The bins of the last pass as the plan predicts them, by the number in the GPU's name.
    pub bins: Vec<(u32, Option<Bins>)>,
    /// Whether timestamps and pipeline statistics were recorded. (No GPU, no results.)
    pub queries: bool,
    /// What the validation layer said.
    pub messages: Vec<String>,
}

/// Large enough for several bins on every GPU that is asked, however few bytes a pixel has.
pub const SIZE: [u32; 2] = [1920, 1080];

impl Case {
    pub fn new(scene: &str, layout: Layout) -> Self {
        Self {
            scene: scene.into(),
            layout,
            depth: None,
            path: LightPath::Deferred,
            lights: LightWay::Fullscreen,
            depth_prepass: false,
            strategy: Strategy::Subpasses,
            recycle: true,
            samples: 1,
            edges: Edges::Auto,
            bloom: BloomWay::Off,
            translucency: Translucency::Sorted,
            shadow_volumes: false,
            overlay: false,
            fault: None,
            capture: false,
            stage_timestamps: false,
            moves: false,
            decals: DecalWay::Auto,
            refraction: Refraction::None,
            show: Show::Picture,
            beside: None,
        }
    }

    fn scene(&self) -> Scene {
        let named = |scene: &Scene| scene.name == self.scene;
        let built = scenes::built().into_iter().find(named);
        let shipped = || scenes::shipped().into_iter().find(named);
        let mut scene = built.or_else(shipped).expect("a scene of this name");
        if self.shadow_volumes {
            scene.lights.iter_mut().for_each(|light| light.shadow = Some(Shadow::default()));
        }
        scene.instances.iter_mut().rev().take(usize::from(self.moves)).for_each(|i| i.dynamic = true);
        scene
    }

    fn plan(&self, scene: &Scene, others: Options) -> Plan {
        let options = Options {
            size: SIZE,
            strategy: self.strategy,
            layout: self.layout,
            depth: self.depth,
            path: self.path,
            lights: self.lights,
            depth_prepass: self.depth_prepass,
            recycle: self.recycle,
            decals: self.decals,
            samples: self.samples,
            edges: self.edges,
            bloom: self.bloom,
            translucency: self.translucency,
            shadow_volumes: self.shadow_volumes,
            refraction: self.refraction,
            overlay: self.overlay,
            show: self.show,
            ..others
        };
        // What every Adreno of these generations allows.
        let limits = Limits {
            max_color_attachments: 8,
            max_input_attachments: 8,
            ordered_attachment_access: true,
            depth_clamp: true,
            sample_counts: 7,
            word_sample_counts: 7,
            merging: Merging { local_read: Ok(()), ..Merging::default() },
            ..Limits::default()
        };
        let mut plan = Plan::new(Needs::of(scene), options, &limits).unwrap();
        if let Some(fault) = self.fault {
            spoil(&mut plan, fault);
        }
        plan
    }

    /// Renders a frame and writes a [`Told`] to the file.
    pub fn run(&self, told: &Path) {
        let options =
            HeadlessOptions { validate: true, application_name: "tiles".into(), ..Default::default() };
        let host = Headless::new(&options).unwrap();
        let config = RendererConfig {
            capture: self.capture,
            stage_timestamps: self.stage_timestamps,
            ..RendererConfig::default()
        };
        let scene = self.scene();
        if let Some(beside) = self.beside {
            // Shadow maps are passes too, and others' matter.
            let scene = scene.without_shadows();
            return super::beside::run(host, &scene, |options| self.plan(&scene, options), beside, told);
        }
        let cache = PipelineCache::new(host.device(), &[]).unwrap();
        let plan = self.plan(&scene, Options::default());
        // A plan means what it does; of separate passes all advice is wanted.
        let separate = plan.strategy == Strategy::Separate;
        let expected = if separate { Vec::new() } else { expected_advice(&plan) };
        let occupancy = plan.occupancy(plan.passes.len() - 1);
        let bins = Adreno::ALL.map(|adreno| (adreno.id, adreno.bins(&occupancy, SIZE))).into();
        let mut offscreen = Offscreen::new(host.device(), &scene, plan, config, &cache).unwrap();
        if self.overlay {
            let corner = |x, y| OverlayVertex { position: [x, y], texcoord: [0.5; 2], color: [128; 4] };
            let frame = OverlayFrame {
                vertices: &[corner(0.0, 0.0), corner(1800.0, 0.0), corner(0.0, 1000.0)],
                indices: &[0, 1, 2],
                parts: &[OverlayPart { clip_px: [0, 0, SIZE[0], SIZE[1]], indices: 0..3 }],
                pixels_per_point: 1.0,
            };
            offscreen.renderer_mut().set_overlay(0, &frame).unwrap();
        }
        let view = View { camera: &scene.cameras[0], exposure_ev: 0.0 };
        offscreen.render(&view).unwrap();
        if self.moves {
            let (index, instance) = scene.instances.iter().enumerate().next_back().unwrap();
            let place = Mat4::from_translation(Vec3::Y * 0.1) * instance.world_from_object;
            offscreen.renderer_mut().set_instance(index, &place).unwrap();
            offscreen.render(&view).unwrap();
        }
        let report = serde_json::to_value(offscreen.report(&scene)).unwrap();
        let queries =
            host.device().features().pipeline_statistics && host.device().caps().timestamp_valid_bits > 0;
        drop((offscreen, cache));
        let mut messages = host.finish();
        messages.retain(|message| !expected.iter().any(|part| message.contains(part)));
        let told_now = Told { report, bins, queries, messages };
        std::fs::write(told, serde_json::to_vec(&told_now).unwrap()).unwrap();
    }
}

fn spoil(plan: &mut Plan, fault: Fault) {
    let Plan { attachments, passes, .. } = plan;
    let pass = &mut passes[0];
    let mut between: Vec<_> =
        pass.dependencies.iter_mut().filter(|d| d.from.is_some() && d.to.is_some()).collect();
    assert!(!between.is_empty(), "the plan has nothing to spoil");
    match fault {
        Fault::NotByRegion => between.iter_mut().for_each(|d| d.by_region = false),
        Fault::DependencyDropped => pass.dependencies.retain(|d| (d.from, d.to) != (Some(0), Some(1))),
        Fault::StoreNotCovered => {
            // What geometry wrote and lighting reads for the last time.
            let d = between.iter_mut().find(|d| (d.from, d.to) == (Some(0), Some(1))).unwrap();
            assert!(d.after.remove(&Access::ColorWrite) && d.after.contains(&Access::InputRead));
        }
        Fault::ItselfNotByRegion => {
            between.iter_mut().filter(|d| d.from == d.to).for_each(|d| d.by_region = false);
        }
        Fault::ItselfDropped => pass.dependencies.retain(|d| d.from != d.to),
        Fault::Stored | Fault::StoredInMemory => {
            let index = attachments.iter().position(|a| a.name == "normal_roughness").unwrap();
            let used = pass.attachments.iter_mut().find(|a| a.attachment == index).unwrap();
            used.store = Store::Store;
            attachments[index].transient = fault == Fault::Stored;
        }
    }
}
