//! What the courtyard's materials look like close up: functions from texture coordinate to texel.

use super::super::noise::{cellular, fractal, gradient_noise, pick, smoothstep, unit};
use super::super::texture::{Surface, Texel, srgb};
use glam::{FloatExt, IVec2, Vec2, Vec3};

/// Where a point lies in a bond of stones.
struct Masonry {
    /// From the nearest joint's middle, metres.
    edge_m: f32,
    /// Identifies the stone.
    stone: IVec2,
}

/// `courses` rows of about `stones` stones, over a sample of `extent_m`; joints waver by a few millimetres.
fn masonry(uv: Vec2, courses: i32, stones: i32, extent_m: f32, seed: u32) -> Masonry {
    let cells = IVec2::splat(courses * 2);
    let waver = Vec2::new(fractal(uv, cells, 2, seed), fractal(uv, cells, 2, seed + 1)) * 0.012 / extent_m;
    let uv = uv + waver;
    let y = uv.y * courses as f32;
    let course = y.floor() as i32;
    let row = course.rem_euclid(courses);
    let shift = 0.5 * (row % 2) as f32;
    // Joint k of this row, in stones from the left.
    let joint =
        |k: i32| k as f32 + shift + 0.36 * (unit(IVec2::new(k.rem_euclid(stones), row), seed + 2) - 0.5);
    let x = uv.x * stones as f32;
    let left = (-2..=stones + 1).rev().find(|&k| joint(k) <= x).unwrap_or(-2);
    let across = (x - joint(left)).min(joint(left + 1) - x) * extent_m / stones as f32;
    let along = (y - y.floor()).min(1.0 - (y - y.floor())) * extent_m / courses as f32;
    Masonry { edge_m: across.min(along), stone: IVec2::new(left.rem_euclid(stones), row) }
}

/// Worn flagstones, 3 m of them, wet in places.
pub fn paving() -> Surface {
    const EXTENT_M: f32 = 3.0;
    Surface::sample(512, EXTENT_M, |uv| {
        let m = masonry(uv, 6, 4, EXTENT_M, 11);
        let tone = unit(m.stone, 12);
        let grain = fractal(uv, IVec2::splat(24), 4, 13);
        let face = smoothstep(0.004, 0.035, m.edge_m);
        let tilt = (unit(m.stone, 14) - 0.5) * 0.006;
        let wet =
            smoothstep(-0.1, 0.35, fractal(uv, IVec2::splat(3), 3, 15) + 0.3 * (unit(m.stone, 16) - 0.5));
        let dry = srgb(0x858a94).lerp(srgb(0x9c958d), tone) * (0.95 + 0.22 * grain);
        let stone = dry * 0.92_f32.lerp(0.62, wet);
        Texel {
            albedo: (srgb(0x3a3630) * 0.8).lerp(stone, face),
            height_m: face * 0.012 + tilt * face + 0.0022 * grain * (1.0 - 0.7 * wet),
            roughness: 0.85_f32.lerp(0.58.lerp(0.16, wet) + 0.08 * grain, face),
            metallic: 0.0,
        }
    })
}

/// Coursed sandstone blocks, 2.4 m of them.
pub fn wall() -> Surface {
    const EXTENT_M: f32 = 2.4;
    Surface::sample(512, EXTENT_M, |uv| {
        let m = masonry(uv, 6, 4, EXTENT_M, 21);
        let tone = unit(m.stone, 22);
        let hue = unit(m.stone, 23);
        let grain = fractal(uv, IVec2::splat(20), 4, 24);
        let chisel = gradient_noise(uv * Vec2::new(96.0, 24.0), IVec2::new(96, 24), 25);
        let face = smoothstep(0.003, 0.026, m.edge_m + 0.004 * grain);
        let color = srgb(0xb8a68c).lerp(srgb(0xa99484), hue) * (0.82 + 0.3 * tone) * (1.0 + 0.16 * grain);
        Texel {
            albedo: srgb(0x6f6353).lerp(color, face),
            height_m: face * (0.014 + 0.006 * tone) + 0.0022 * grain + 0.0009 * chisel * face,
            roughness: 0.92 - 0.1 * face * (1.0 - tone),
            metallic: 0.0,
        }
    })
}

/// Pale limestone with fine pits and veins, 1 m of it.
pub fn limestone() -> Surface {
    Surface::sample(256, 1.0, |uv| {
        let cloud = fractal(uv, IVec2::splat(3), 4, 31);
        let vein = 1.0 - smoothstep(0.0, 0.05, fractal(uv, IVec2::new(2, 4), 4, 32).abs());
        let pit = 1.0 - smoothstep(0.12, 0.34, cellular(uv, IVec2::splat(26), 33).nearest);
        let pit = pit * smoothstep(0.2, 0.6, fractal(uv, IVec2::splat(4), 2, 34));
        let color = srgb(0xcdc3b0).lerp(srgb(0xb9ab97), 0.5 + cloud) * (1.0 - 0.1 * vein - 0.2 * pit);
        Texel {
            albedo: color,
            height_m: 0.0014 * cloud - 0.0022 * pit - 0.0005 * vein,
            roughness: 0.62 + 0.18 * cloud + 0.2 * pit,
            metallic: 0.0,
        }
    })
}

/// Hammered bronze with verdigris in its hollows, half a metre of it.
pub fn bronze() -> Surface {
    Surface::sample(256, 0.5, |uv| {
        let dent = cellular(uv, IVec2::splat(14), 41);
        let cloud = fractal(uv, IVec2::splat(4), 4, 42);
        let green = smoothstep(0.18, 0.42, cloud + 0.12 * (dent.nearest - 0.5));
        let metal = srgb(0xd9a566).lerp(srgb(0xb87a48), 0.5 + cloud);
        Texel {
            albedo: metal.lerp(srgb(0x4d8a76), green),
            height_m: 0.0016 * dent.nearest * dent.nearest + 0.0006 * green,
            roughness: (0.34 + 0.1 * cloud).lerp(0.82, green),
            metallic: 1.0 - green,
        }
    })
}

/// Forged iron: dark, dented, a little rusty; a quarter of a metre.
pub fn iron() -> Surface {
    Surface::sample(128, 0.25, |uv| {
        let dent = cellular(uv, IVec2::splat(7), 51).nearest;
        let rust = smoothstep(0.2, 0.45, fractal(uv, IVec2::splat(4), 4, 52));
        Texel {
            albedo: srgb(0x84868c).lerp(srgb(0x6b4430), rust),
            height_m: 0.0011 * dent * dent + 0.0003 * rust,
            roughness: 0.42.lerp(0.85, rust),
            metallic: 1.0 - 0.9 * rust,
        }
    })
}

/// A plain weave, 32 threads over 0.16 m.
pub fn cloth() -> Surface {
    const THREADS: f32 = 32.0;
    Surface::sample(256, 0.16, |uv| {
        let thread = (uv * THREADS).floor().as_ivec2();
        let across = uv * THREADS - thread.as_vec2() - 0.5;
        let warp_on_top = (thread.x + thread.y) % 2 == 0;
        let (round, along) = if warp_on_top { (across.x, across.y) } else { (across.y, across.x) };
        let height = (1.0 - 4.0 * round * round).max(0.0).sqrt() * (1.0 - 1.6 * along * along);
        let slub = unit(if warp_on_top { IVec2::new(thread.x, -1) } else { IVec2::new(-1, thread.y) }, 61);
        Texel {
            albedo: Vec3::splat(0.75 + 0.2 * height - 0.1 * slub),
            height_m: 0.0012 * height,
            roughness: 0.9,
            metallic: 0.0,
        }
    })
}

/// Weathered oak planks, 1.2 m of them, grain along v.
pub fn wood() -> Surface {
    Surface::sample(256, 1.2, |uv| {
        const PLANKS: f32 = 6.0;
        let plank = (uv.x * PLANKS).floor();
        let across = uv.x * PLANKS - plank;
        let edge_m = across.min(1.0 - across) * 1.2 / PLANKS;
        let face = smoothstep(0.002, 0.012, edge_m);
        let shifted = Vec2::new(uv.x, (uv.y + pick(plank as usize, 71)).fract());
        let fibre = fractal(shifted, IVec2::new(40, 3), 3, 72);
        let tone = pick(plank as usize, 73);
        let color = srgb(0x7a5636).lerp(srgb(0x5c4029), tone) * (1.0 + 0.4 * fibre);
        Texel {
            albedo: srgb(0x20150e).lerp(color, face),
            height_m: 0.006 * face + 0.0016 * fibre,
            roughness: 0.7 - 0.15 * fibre,
            metallic: 0.0,
        }
    })
}

/// Ripples on water, 1.5 m of them.
pub fn water() -> Surface {
    Surface::sample(256, 1.5, |uv| Texel {
        albedo: Vec3::ONE,
        height_m: 0.012 * fractal(uv, IVec2::splat(5), 3, 81),
        roughness: 0.05,
        metallic: 0.0,
    })
}

/// The banner's picture: a gold star in a ring, and a gold border, on a field of this sRGB colour.
pub fn banner_color(uv: Vec2, field: Vec3) -> Vec3 {
    // The picture is stretched over a strip 2.25 times as high as wide.
    const ASPECT: f32 = 2.25;
    let p = (uv - Vec2::new(0.5, 0.4)) * Vec2::new(1.0, ASPECT);
    let (radius, angle) = (p.length(), p.y.atan2(p.x));
    let star = 0.15 + 0.11 * (angle * 8.0).cos().abs().powf(1.5) * ((angle * 4.0).cos() * 0.35 + 0.65);
    let margin = (uv.x.min(1.0 - uv.x)).min((uv.y.min(1.0 - uv.y)) * ASPECT);
    let gold = radius < star * 0.95 && radius > 0.055
        || (0.315..0.35).contains(&radius)
        || (0.05..0.085).contains(&margin)
        || ((uv.y * ASPECT - 1.72).abs() < 0.03 && margin > 0.085)
        || ((uv.y * ASPECT - 1.82).abs() < 0.015 && margin > 0.085);
    if gold { srgb(0xe8b850) } else { field * (1.0 + 0.1 * fractal(uv, IVec2::splat(6), 3, 91)) }
}

/// Wrought iron: an ogee lattice with rosettes; colour and coverage.
pub fn lattice(uv: Vec2) -> (Vec3, f32) {
    let wave = |x: f32| (x * std::f32::consts::TAU).cos();
    // Two families of mirrored waves meet in ogees.
    let bend = 0.25 * wave(uv.y);
    let distance = |x: f32| (x - x.round()).abs();
    let bars = distance(uv.x - 0.25 - bend).min(distance(uv.x + 0.25 + bend));
    let p = Vec2::new(distance(uv.x), distance(uv.y - 0.5)).min(Vec2::splat(0.5));
    let q = Vec2::new(distance(uv.x - 0.5), distance(uv.y));
    let rosette = |p: Vec2| p.length() - 0.1 - 0.035 * (p.y.atan2(p.x) * 8.0).cos();
    let ring = |p: Vec2| (p.length() - 0.21).abs() - 0.022;
    let inside = bars < 0.05 || rosette(p).min(rosette(q)) < 0.0 || ring(p).min(ring(q)) < 0.0;
    let tone = 0.75 + 0.25 * fractal(uv, IVec2::splat(8), 3, 95);
    (srgb(0x5a5550) * tone, if inside { 1.0 } else { 0.0 })
}

/// A spray of pointed leaves: colour and coverage. It does not tile; its stem is at the bottom.
pub fn leaves(uv: Vec2) -> (Vec3, f32) {
    let mut result = (srgb(0x3c5a2a), 0.0);
    let stem = Vec2::new(0.5 + 0.03 * (uv.y * 9.0).sin(), uv.y);
    if (uv.x - stem.x).abs() < 0.012 && uv.y > 0.12 {
        result = (srgb(0x4a3a22), 1.0);
    }
    for i in 0..11 {
        let side = if i % 2 == 0 { 1.0 } else { -1.0 };
        let base = Vec2::new(0.5, 0.93 - 0.078 * i as f32);
        let lean = if i == 10 { 0.0 } else { side * (0.9 + 0.35 * (pick(i, 96) - 0.5)) };
        let axis = Vec2::new(lean.sin(), -lean.cos());
        let p = uv - base;
        let (along, across) = (p.dot(axis) / 0.36, p.perp_dot(axis).abs() / 0.36);
        if !(0.0..1.0).contains(&along) {
            continue;
        }
        let width = 0.62 * along.sqrt() * (1.0 - along) * (1.0 + 0.1 * (along * 40.0).sin());
        if across < width {
            let rib = smoothstep(0.0, 0.03, across);
            let tone = srgb(0x55803a).lerp(srgb(0x8a9a48), pick(i, 97)) * (0.75 + 0.35 * along);
            result = (srgb(0xa8b070).lerp(tone, rib), 1.0);
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean step of height between the line `at` and the one before it; `along` runs along the line.
    fn mean_step_m(surface: &Surface, at: i32, across: IVec2, along: IVec2) -> f32 {
        let size = surface.size_px();
        let step = |i: i32| {
            let here = across * at + along * i;
            (surface.height_m(here) - surface.height_m(here - across)).abs()
        };
        (0..size).map(step).sum::<f32>() / size as f32
    }

    #[test]
    fn surfaces_tile_without_a_seam() {
        let surfaces = [
            ("paving", paving()),
            ("wall", wall()),
            ("limestone", limestone()),
            ("bronze", bronze()),
            ("iron", iron()),
            ("cloth", cloth()),
            ("wood", wood()),
            ("water", water()),
        ];
        for (name, surface) in &surfaces {
            for (across, along) in [(IVec2::X, IVec2::Y), (IVec2::Y, IVec2::X)] {
                let step = |at| mean_step_m(surface, at, across, along);
                // The first line follows the last: its step may be as large as any inside, but no larger.
                let inside = (1..surface.size_px()).map(step).fold(0.0, f32::max);
                // Joints and threads may fall on the edge itself, where the largest of all steps are.
                const SLACK: f32 = 1.05;
                assert!(step(0) <= inside * SLACK, "{name}: {} m, inside at most {inside} m", step(0));
            }
        }
    }
}
