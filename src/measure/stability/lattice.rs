//! Between which vertices a device interpolates.

use glam::{DVec2, DVec3, Mat4, Vec3};

use super::bench::light_of;
use super::parts::add;
use super::{Bound, Case, Findings, Lab, Sweep, exact};
use crate::Result;
use crate::scene::{Camera, Material, Mesh, Projection, Scene};

pub const LATTICE: Sweep = Sweep {
    name: "lattice",
    title: "Vertices on the rasteriser's lattice",
    varies: "places of corners of triangles a few pixels wide, which are white in one channel each",
    about: "A rasteriser tests coverage with vertices rounded to a lattice (`subPixelPrecisionBits`; Vulkan 1.3, 28.9). Some interpolate \
            between the rounded ones too, others between vertices as they are: small triangles then differ by some thousandths, which \
            the other sweeps allow for. This one says which the device does.",
    needs_device: true,
    find: lattice,
};

/// Side of a triangle's part of the picture, pixels.
const CELL: u32 = 6;

/// Corners in pixels from the upper left: odd multiples of 1/8192, so that floats hold them, and none is halfway between two places of a
/// lattice of up to 11 bits, where devices round either way.
fn corners(cell: u32, columns: u32) -> [DVec2; 3] {
    let origin = DVec2::new(f64::from(cell % columns), f64::from(cell / columns)) * f64::from(CELL);
    let mut state = cell.wrapping_mul(0x9e37_79b9) ^ 0x85eb_ca6b;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        f64::from(state % 4096) / 4096.0
    };
    [DVec2::new(0.2, 0.2), DVec2::new(0.4, 4.4), DVec2::new(4.6, 2.0)]
        .map(|corner| origin + ((corner * 4096.0).round() + 0.5) / 4096.0 + DVec2::new(random(), random()))
}

fn scene(size: [u32; 2]) -> Scene {
    let half = DVec2::new(f64::from(size[0]), f64::from(size[1])) * 0.5;
    let columns = size[0] / CELL;
    let mut mesh = Mesh::default();
    for corner in (0..columns * (size[1] / CELL)).flat_map(|cell| corners(cell, columns)) {
        let first = mesh.positions.len() as u32;
        // A pixel is a metre.
        mesh.positions.push(DVec3::new(corner.x - half.x, half.y - corner.y, 0.0).as_vec3());
        mesh.normals.push(Vec3::Z);
        mesh.colors.push(Vec3::AXES[first as usize % 3].extend(1.0));
        mesh.indices.push(first);
    }
    let (xmag_m, ymag_m) = (half.x as f32, half.y as f32);
    let projection = Projection::Orthographic { xmag_m, ymag_m, znear_m: 1.0, zfar_m: 9.0 };
    let world_from_view = Mat4::from_translation(Vec3::Z * 5.0);
    let mut scene = Scene {
        cameras: vec![Camera { name: "camera".into(), world_from_view, projection }],
        ..Scene::default()
    };
    add(&mut scene, mesh, Material { unlit: true, ..Material::default() }, Mat4::IDENTITY);
    scene
}

/// Weights of the corners at a place.
fn weights([a, b, c]: [DVec2; 3], at: DVec2) -> DVec3 {
    let across = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a);
    DVec3::new(across(b, c, at), across(c, a, at), across(a, b, at)) / across(a, b, c)
}

fn lattice(lab: &Lab<'_>) -> Result<Findings> {
    /// From edges, so that coverage is no question.
    const INSIDE: f64 = 0.05;
    let bench = lab.bench()?;
    let size = lab.pick([96, 60], [480, 300]);
    let found = light_of(&bench.picture(&scene(size), exact(size), 0.0)?)?;
    let bits = bench.device().caps().sub_pixel_precision_bits;
    let steps = f64::from(bits).exp2();
    let columns = size[0] / CELL;
    let mut worst = [0.0_f64; 2];
    for cell in 0..columns * (size[1] / CELL) {
        let own = corners(cell, columns);
        let rounded = own.map(|corner| (corner * steps).round() / steps);
        for pixel in 0..CELL * CELL {
            let [x, y] = [cell % columns * CELL + pixel % CELL, cell / columns * CELL + pixel / CELL];
            let at = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
            if weights(own, at).min_element() < INSIDE {
                continue;
            }
            let light = found[(y * size[0] + x) as usize];
            for (worst, corners) in worst.iter_mut().zip([own, rounded]) {
                let error = (light - weights(corners, at)).abs().max_element();
                *worst = if error.is_finite() { worst.max(error) } else { f64::NAN };
            }
        }
    }
    let [as_they_are, on_lattice] = worst;
    let is_rounded = on_lattice < as_they_are;
    Ok(Findings {
        cases: vec![Case {
            method: match is_rounded {
                true => format!("interpolates between vertices rounded to 1/{steps} of a pixel"),
                false => "interpolates between vertices as they are".into(),
            },
            worst: as_they_are.min(on_lattice),
            at: format!("as they are: off by {as_they_are:.1e}; rounded: off by {on_lattice:.1e}"),
            bound: Bound {
                name: "ONE_OR_THE_OTHER",
                unit: "of a channel",
                good: 5e-5,
                most: 2e-4,
                reason: "what a device does explains what it draws to a few units of f32; the other way is off by half a step times the \
                         slope, ten times more",
            },
            answer: None,
            remedy: "nothing: other sweeps allow each pixel half a step of the lattice".into(),
        }],
        figures: Vec::new(),
    })
}
