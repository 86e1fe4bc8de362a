//! Shadows of what stands still stand still, too.

use crate::common::render::on_device;
use crate::common::scenes::shadow_scenes::one_light_each;
use crate::{options, render, taken};
use ontile::glam::{Mat4, Vec3};
use ontile::gpu::{Offscreen, RendererConfig};
use ontile::plan::{Options, ShadowFilter, ShadowFormat, ShadowOptions, Tile};

/// A tile's texels.
struct Texels {
    side: usize,
    depths: Vec<f32>,
}

impl Texels {
    fn of(offscreen: &Offscreen, tile: &Tile) -> Self {
        let width = offscreen.renderer().plan().shadow_map.as_ref().unwrap().size[0] as usize;
        let map = offscreen.shadow_map().unwrap();
        let [x, y, side] = [tile.x, tile.y, tile.texels].map(|n| n as usize);
        let depths = (y..y + side).flat_map(|y| map[y * width + x..][..side].to_vec()).collect();
        Self { side, depths }
    }

    /// How many texels differ by more than this from those of `before`, which are this many texels further right and down.
    fn changed(&self, before: &Self, shift: [isize; 2], tolerance: f32) -> usize {
        let side = self.side as isize;
        let range = |shift: isize| 0.max(-shift)..side.min(side - shift);
        let at = |texels: &Self, x: isize, y: isize| texels.depths[(y * side + x) as usize];
        let differ = |a: f32, b: f32| a.to_bits() != b.to_bits() && (a - b).abs() > tolerance;
        let rows = range(shift[1]).map(|y| {
            let row = range(shift[0]);
            row.filter(|x| differ(at(self, *x, y), at(before, x + shift[0], y + shift[1]))).count()
        });
        rows.sum()
    }
}

/// While a camera moves by less than a texel a frame, cascades stay where they are or move by whole texels, and all of them
/// have the depths that they had, though everything is drawn anew: bit for bit while they stay.
#[test]
fn a_moving_camera_leaves_the_texels_of_shadows_as_they_are() {
    /// Of the tiles' side, in cascades.rs.
    const LATTICE: isize = 256 / 16;
    /// Planes through triangles begin elsewhere in the tile after a jump: the last bit of depths near 1, or one step.
    const FORMATS: [(ShadowFormat, f32); 2] =
        [(ShadowFormat::D32, f32::EPSILON), (ShadowFormat::D16, 1.0 / 65535.0 + f32::EPSILON)];
    const FRAMES: usize = 80;
    on_device(None, |gpu| {
        let scene = &one_light_each()[0];
        let walk = |stable, (format, rounding): (ShadowFormat, f32)| {
            let shadows =
                ShadowOptions { tile_texels: Some(256), stable, format, ..ShadowOptions::default() };
            let plan = gpu.plan(scene, Options { shadows, ..options(ShadowFilter::Grid3) });
            let config = RendererConfig { capture: true, ..RendererConfig::default() };
            let mut offscreen = gpu.offscreen(scene, plan, config);
            let mut camera = scene.cameras[0].clone();
            let tile = offscreen.renderer().plan().shadow_map.as_ref().unwrap().tiles[0];
            let mut before: Option<Texels> = None;
            let (mut jumps, mut unsteady) = (0, 0);
            for _ in 0..FRAMES {
                render(&mut offscreen, &camera);
                assert!(taken(&offscreen).tiles > 1);
                let texels = Texels::of(&offscreen, &tile);
                let drawn = texels.depths.iter().filter(|d| **d != 0.0).count();
                assert!(drawn > texels.depths.len() / 4, "the tile shows little: {drawn}");
                if let Some(before) = before.filter(|before| texels.changed(before, [0, 0], 0.0) > 0) {
                    let steps = [0, LATTICE, -LATTICE];
                    let mut shifts = steps.into_iter().flat_map(|x| steps.map(|y| [x, y])).skip(1);
                    let jumped = shifts.any(|shift| texels.changed(&before, shift, rounding) == 0);
                    *if jumped { &mut jumps } else { &mut unsteady } += 1;
                }
                before = Some(texels);
                // A texel is some 2 cm wide.
                let turn = Mat4::from_rotation_y(1e-3);
                camera.world_from_view *= Mat4::from_translation(Vec3::new(0.004, 0.002, -0.003)) * turn;
                offscreen.renderer_mut().redraw_shadows();
            }
            (jumps, unsteady)
        };
        for format in FORMATS {
            let (jumps, unsteady) = walk(true, format);
            assert!(jumps > 0 && unsteady == 0, "{jumps} jumps, {unsteady} of {FRAMES} frames are unsteady");
            // And without steps?
            let (_, unsteady) = walk(false, format);
            assert!(unsteady > FRAMES / 2, "{unsteady}: this test sees nothing");
        }
    });
}
