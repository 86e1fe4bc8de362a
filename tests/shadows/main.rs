//! Shadows: where they fall and what they cost. That they stay there is a sweep of `ontile stability`.

#[path = "../common/mod.rs"]
mod common;

mod corners;
mod kept;
mod pool;
mod rays;
mod volumes;

use common::render::Gpu;
use common::scenes::shadow_scenes::{one_light_each, room};
use ontile::gpu::{Offscreen, RecordedShadows, RendererConfig, View};
use ontile::picture::Picture;
use ontile::plan::{Layout, Options, OutputFormat, ShadowFilter, ShadowOptions, Tonemap};
use ontile::scene::{Camera, Scene};

const SIZE: [u32; 2] = [320, 180];

fn options(filter: ShadowFilter) -> Options {
    Options {
        size: SIZE,
        layout: Layout::Exact,
        tonemap: Tonemap::Linear,
        output: OutputFormat::Rgba32Float,
        // Texels that are smaller than pixels, so that filters reach over few pixels.
        shadows: ShadowOptions { filter, tile_texels: Some(1024), ..ShadowOptions::default() },
        ..Options::default()
    }
}

/// What recording the last frame took for shadows.
fn taken(offscreen: &Offscreen) -> RecordedShadows {
    offscreen.renderer().recorded().shadows
}

fn render(offscreen: &mut Offscreen, camera: &Camera) -> Picture {
    offscreen.render(&View { camera, exposure_ev: 0.0 }).unwrap();
    offscreen.picture()
}

fn offscreen(gpu: &Gpu<'_>, scene: &Scene, config: RendererConfig) -> Offscreen {
    gpu.offscreen(scene, gpu.plan(scene, options(ShadowFilter::Grid3)), config)
}

/// The room with a sun, a spot and a bulb.
fn three_lights() -> Scene {
    let mut scene = room();
    let lights = one_light_each().into_iter().filter(|s| ["sun", "spot", "bulb"].contains(&&*s.name));
    scene.lights = lights.flat_map(|s| s.lights).collect();
    scene
}

/// Of the room's instances: floor, wall, ball, post, post.
const BALL: usize = 2;
