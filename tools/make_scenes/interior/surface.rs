//! What the hall's materials look like close up: functions from texture coordinate to texel.

use super::super::noise::{cellular, fractal, smoothstep};
use super::super::texture::{Surface, Texel, srgb};
use glam::{FloatExt, IVec2, Vec2, Vec3};

/// Distance of a coordinate in cells from the nearest border between cells, in cells.
fn to_border(x: f32) -> f32 {
    let f = x - x.floor();
    f.min(1.0 - f)
}

/// Bare metal where paint is scratched off: 0 paint, 1 metal.
fn scratches(uv: Vec2, seed: u32) -> f32 {
    let wear = fractal(uv, IVec2::splat(5), 4, seed);
    smoothstep(0.4, 0.48, wear)
}

/// Tread plate: raised lozenges, alternately leaning left and right; a metre of it.
pub fn tread() -> Surface {
    Surface::sample(256, 1.0, |uv| {
        const CELLS: f32 = 8.0;
        let cell = (uv * CELLS).floor();
        let p = uv * CELLS - cell - 0.5;
        let lean = if (cell.x + cell.y) % 2.0 == 0.0 { 1.0 } else { -1.0 };
        let (along, across) = (p.x * lean + p.y, p.x * lean - p.y);
        let bump = 1.0 - smoothstep(0.6, 1.0, (along * along * 2.6 + across * across * 30.0).sqrt());
        let grime = fractal(uv, IVec2::splat(4), 3, 101);
        let worn = bump * smoothstep(-0.3, 0.3, grime);
        Texel {
            albedo: srgb(0x6d7175).lerp(srgb(0x9ca1a5), worn) * (1.0 + 0.14 * grime),
            height_m: 0.006 * bump,
            roughness: 0.6 - 0.22 * worn + 0.1 * grime,
            metallic: 0.35 + 0.3 * worn,
        }
    })
}

/// Painted wall panels with grooves and rivets, two metres of them.
pub fn panels() -> Surface {
    Surface::sample(256, 2.0, |uv| {
        let grid = uv * Vec2::new(2.0, 2.0);
        let edge_m = to_border(grid.x).min(to_border(grid.y));
        let face = smoothstep(0.008, 0.024, edge_m);
        // Rivets every quarter metre along the grooves.
        let q = Vec2::new(to_border(uv.x * 8.0), to_border(uv.y * 8.0)) * 0.25;
        let on_edge = smoothstep(0.10, 0.09, edge_m) * smoothstep(0.05, 0.06, edge_m);
        let rivet = (1.0 - smoothstep(0.012, 0.022, (q - Vec2::splat(0.077)).length().min(0.1))) * on_edge;
        let dirt = fractal(uv, IVec2::splat(4), 4, 111);
        let bare = scratches(uv, 112) * face;
        let paint = srgb(0x6f7c7a).lerp(srgb(0x59655f), 0.5 + dirt) * 0.55_f32.lerp(1.0, face);
        Texel {
            albedo: paint.lerp(srgb(0x9a938a), bare),
            height_m: 0.012 * face + 0.006 * rivet - 0.0015 * bare,
            roughness: (0.58 + 0.12 * dirt).lerp(0.4, bare),
            metallic: bare,
        }
    })
}

/// Yellow and black stripes on steel, a metre of them.
pub fn hazard() -> Surface {
    Surface::sample(256, 1.0, |uv| {
        let stripe = uv.x * 4.0 + uv.y * 4.0;
        let inside = stripe - stripe.floor();
        let yellow = smoothstep(0.48, 0.5, inside) * smoothstep(1.0, 0.98, inside);
        let bare = scratches(uv, 121);
        let dirt = fractal(uv, IVec2::splat(6), 3, 122);
        let paint = srgb(0x26241f).lerp(srgb(0xe0a52a), yellow) * (1.0 + 0.12 * dirt);
        Texel {
            albedo: paint.lerp(srgb(0x8c8880), bare),
            height_m: -0.0012 * bare + 0.0006 * dirt,
            roughness: 0.5.lerp(0.36, bare),
            metallic: bare,
        }
    })
}

/// Dark steel with dents and rust, half a metre of it.
pub fn steel() -> Surface {
    Surface::sample(256, 0.5, |uv| {
        let dent = cellular(uv, IVec2::splat(9), 131).nearest;
        let rust = smoothstep(0.12, 0.4, fractal(uv, IVec2::splat(5), 4, 132));
        Texel {
            albedo: srgb(0x85888c).lerp(srgb(0x6b4430), rust),
            height_m: 0.0012 * dent * dent + 0.0004 * rust,
            roughness: 0.4.lerp(0.86, rust),
            metallic: 1.0 - 0.9 * rust,
        }
    })
}

/// Ribbed casing of a machine, painted; half a metre of it.
pub fn casing() -> Surface {
    Surface::sample(256, 0.5, |uv| {
        let rib = smoothstep(0.06, 0.14, to_border(uv.y * 8.0));
        let bare = 0.6 * scratches(uv, 141) * rib;
        let grain = fractal(uv, IVec2::splat(16), 3, 142);
        let paint = srgb(0xa8582a).lerp(srgb(0xc07436), 0.5 + grain) * 0.5_f32.lerp(1.0, rib);
        Texel {
            albedo: paint.lerp(srgb(0xa8a29a), bare),
            height_m: 0.009 * rib + 0.0006 * grain,
            roughness: 0.42.lerp(0.32, bare),
            metallic: bare,
        }
    })
}

/// Slatted, framed sides of crates, a metre of them.
pub fn crate_side() -> Surface {
    Surface::sample(256, 1.0, |uv| {
        let frame = to_border(uv.x).min(to_border(uv.y));
        let is_frame = smoothstep(0.12, 0.11, frame);
        let slat = smoothstep(0.02, 0.06, to_border(uv.y * 6.0)) * (1.0 - is_frame) + is_frame;
        let fibre = fractal(Vec2::new(uv.x, uv.y), IVec2::new(4, 48), 3, 151);
        let wood = srgb(0x7c603c).lerp(srgb(0x5d4529), 0.5 + fibre) * 0.45_f32.lerp(1.0, slat);
        Texel {
            albedo: wood,
            height_m: 0.012 * is_frame + 0.008 * slat + 0.001 * fibre,
            roughness: 0.8,
            metallic: 0.0,
        }
    })
}

/// What a console shows, sRGB-encoded: traces over a grid. It does not tile.
pub fn screen(uv: Vec2) -> Vec3 {
    let line = |y: f32, width: f32| 1.0 - smoothstep(0.0, width, (uv.y - y).abs());
    let grid = (1.0 - smoothstep(0.0, 0.05, to_border(uv.x * 10.0).min(to_border(uv.y * 7.0)))) * 0.22;
    let wave = 0.34 + 0.5 * fractal(Vec2::new(uv.x, 0.3), IVec2::new(9, 1), 4, 161);
    let bars = if uv.y > 0.62 && uv.y < 0.92 {
        let height =
            0.5 + 0.8 * fractal(Vec2::new((uv.x * 14.0).floor() / 14.0, 0.7), IVec2::new(14, 2), 2, 162);
        f32::from(uv.y > 0.92 - 0.3 * height.clamp(0.1, 1.0) && to_border(uv.x * 14.0) > 0.12)
    } else {
        0.0
    };
    let inside = smoothstep(0.0, 0.02, uv.x.min(1.0 - uv.x).min(uv.y.min(1.0 - uv.y)) - 0.03);
    (Vec3::new(0.05, 0.3, 0.28) * (0.3 + grid)
        + Vec3::new(0.35, 1.0, 0.8) * line(wave, 0.02)
        + Vec3::new(1.0, 0.62, 0.2) * bars)
        * inside
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surfaces_tile_without_a_seam() {
        // Mean step of height between the line `at` and the one before it; `along` runs along the line.
        let mean_step_m = |surface: &Surface, at: i32, across: IVec2, along: IVec2| {
            let size = surface.size_px();
            let step = |i: i32| {
                let here = across * at + along * i;
                (surface.height_m(here) - surface.height_m(here - across)).abs()
            };
            (0..size).map(step).sum::<f32>() / size as f32
        };
        let surfaces = [
            ("tread", tread()),
            ("panels", panels()),
            ("hazard", hazard()),
            ("steel", steel()),
            ("casing", casing()),
            ("crate", crate_side()),
        ];
        for (name, surface) in &surfaces {
            for (across, along) in [(IVec2::X, IVec2::Y), (IVec2::Y, IVec2::X)] {
                let step = |at| mean_step_m(surface, at, across, along);
                // The first line follows the last: its step may be as large as any inside, but no larger.
                let inside = (1..surface.size_px()).map(step).fold(0.0, f32::max);
                // Grooves may fall on the edge itself, where the largest of all steps are.
                const SLACK: f32 = 1.05;
                assert!(step(0) <= inside * SLACK, "{name}: {} m, inside at most {inside} m", step(0));
            }
        }
    }
}
