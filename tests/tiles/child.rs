//! What the judged process does: render a small scene by a plan, perhaps a spoilt one, and write down what happened.

use ontile::glam::{Mat4, Vec3, Vec4};
use ontile::gpu::{Headless, HeadlessOptions, Offscreen, PipelineCache, RendererConfig, View};
use ontile::plan::{Access, Layout, Needs, Options, Plan, Store, Strategy};
use ontile::scene::{Camera, Instance, Light, LightKind, Material, Mesh, Projection, Scene};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What to render.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Case {
    pub content: Content,
    pub layout: Layout,
    pub strategy: Strategy,
    pub recycle: bool,
    pub fault: Option<Fault>,
    /// `RendererConfig::capture`.
    pub capture: bool,
    /// `RendererConfig::stage_timestamps`.
    pub stage_timestamps: bool,
}

/// What the scene has, and so which plan it gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Content {
    /// Lit and emissive: a light target, three stages.
    Emissive,
    /// Lit only: lighting and tonemap are one stage.
    Lit,
    /// Unlit only: one stage.
    Unlit,
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
}

/// What the child tells.
#[derive(Debug, Serialize, Deserialize)]
pub struct Told {
    /// `ontile::plan::Report`.
    pub report: serde_json::Value,
    /// Whether timestamps and pipeline statistics were recorded. (No GPU, no results.)
    pub queries: bool,
    /// What the validation layer said.
    pub messages: Vec<String>,
}

/// Large enough for several bins on every GPU that is asked, however few bytes a pixel has.
pub const SIZE: [u32; 2] = [1920, 1080];

impl Case {
    pub fn new(content: Content, layout: Layout) -> Self {
        Self {
            content,
            layout,
            strategy: Strategy::Subpasses,
            recycle: true,
            fault: None,
            capture: false,
            stage_timestamps: false,
        }
    }

    pub fn plan(&self) -> Plan {
        let options = Options {
            size: SIZE,
            strategy: self.strategy,
            layout: self.layout,
            recycle: self.recycle,
            ..Options::default()
        };
        let mut plan = Plan::new(Needs::of(&scene(self.content)), options, &Default::default()).unwrap();
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
        let cache = PipelineCache::new(host.device(), &[]).unwrap();
        let config = RendererConfig {
            capture: self.capture,
            stage_timestamps: self.stage_timestamps,
            ..RendererConfig::default()
        };
        let scene = scene(self.content);
        let mut offscreen = Offscreen::new(host.device(), &scene, self.plan(), config, &cache).unwrap();
        offscreen.render(&View { camera: &scene.cameras[0], exposure_ev: 0.0 }).unwrap();
        let report = serde_json::to_value(offscreen.report(&scene)).unwrap();
        let queries =
            host.device().features().pipeline_statistics && host.device().caps().timestamp_valid_bits > 0;
        drop((offscreen, cache));
        let told_now = Told { report, queries, messages: host.finish() };
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
        Fault::Stored | Fault::StoredInMemory => {
            let index = attachments.iter().position(|a| a.name == "normal_roughness").unwrap();
            let used = pass.attachments.iter_mut().find(|a| a.attachment == index).unwrap();
            used.store = Store::Store;
            attachments[index].transient = fault == Fault::Stored;
        }
    }
}

/// Squares of several materials around a lamp. Colours, metallicness and roughness differ; kinds of surfaces do not.
pub fn scene(content: Content) -> Scene {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let square = |material| Mesh {
        name: "square".into(),
        positions: corners.iter().map(|&(x, y)| Vec3::new(x, y, 0.0)).collect(),
        normals: vec![Vec3::Z; 4],
        indices: vec![0, 1, 2, 0, 2, 3],
        material,
        ..Mesh::default()
    };
    const SQUARES: usize = 8;
    let material = |i: usize| Material {
        name: format!("material {i}"),
        base_color_factor: Vec4::new(0.2 + 0.1 * i as f32, 0.5, 0.9 - 0.1 * i as f32, 1.0),
        metallic_factor: (i % 2) as f32,
        roughness_factor: 0.1 * (i + 1) as f32,
        emissive_factor: if content == Content::Emissive && i == 0 { Vec3::ONE } else { Vec3::ZERO },
        unlit: content == Content::Unlit,
        ..Material::default()
    };
    let place = |mesh: usize| Instance {
        mesh,
        world_from_object: Mat4::from_translation(Vec3::new(
            0.7 * mesh as f32 - 2.5,
            0.0,
            -0.3 * mesh as f32,
        )),
    };
    Scene {
        name: "squares".into(),
        meshes: (0..SQUARES).map(square).collect(),
        instances: (0..SQUARES).map(place).collect(),
        materials: (0..SQUARES).map(material).collect(),
        lights: vec![Light {
            name: "lamp".into(),
            color: Vec3::ONE,
            kind: LightKind::Point { intensity_cd: 20.0 },
            position_world: Vec3::new(0.0, 1.0, 2.0),
            direction_world: Vec3::NEG_Z,
            range_m: None,
        }],
        cameras: vec![Camera {
            name: "front".into(),
            world_from_view: Mat4::from_translation(Vec3::new(0.0, 0.0, 5.0)),
            projection: Projection::Perspective { yfov_rad: 1.0, znear_m: 0.1, zfar_m: None },
        }],
        ..Scene::default()
    }
}
