//! The fountain and the armillary sphere that crowns it.

use super::super::glb::{Glb, Pose};
use super::super::mesh::{Mesh, planar_texcoord};
use super::super::noise::smoothstep;
use super::super::shape::{cuboid, lathe, ring_profile, sphere, tube};
use super::FOUNTAIN;
use super::furnishing::points;
use super::palette::Palette;
use glam::{Affine3A, Quat, Vec2, Vec3};

/// Builds both.
pub fn build(glb: &mut Glb, palette: &Palette) {
    fountain(glb, palette);
    armillary(glb, palette);
}

/// The basin, its pedestal and the water.
fn fountain(glb: &mut Glb, palette: &Palette) {
    let basin = points(&[
        (1.62, 0.28),
        (1.66, 0.3),
        (1.7, 0.36),
        (1.66, 0.42),
        (1.58, 0.46),
        (1.55, 0.56),
        (1.58, 0.72),
        (1.68, 0.86),
        (1.8, 0.93),
        (1.84, 0.98),
        (1.84, 1.03),
        (1.8, 1.07),
        (1.62, 1.07),
        (1.58, 1.04),
        (1.55, 0.98),
        (1.5, 0.7),
    ]);
    let pedestal = points(&[
        (0.5, 0.7),
        (0.5, 1.0),
        (0.46, 1.05),
        (0.34, 1.1),
        (0.26, 1.2),
        (0.22, 1.35),
        (0.24, 1.46),
        (0.3, 1.52),
        (0.5, 1.6),
        (0.72, 1.72),
        (0.78, 1.8),
        (0.77, 1.84),
        (0.7, 1.84),
        (0.5, 1.76),
        (0.24, 1.74),
        (0.2, 1.8),
        (0.16, 1.95),
        (0.2, 2.02),
        (0.24, 2.06),
        (0.22, 2.1),
        (0.0, 2.12),
    ]);
    // The basin's rim bulges in sixteen lobes.
    let mut basin = lathe(&basin, 80, 10.0);
    for p in &mut basin.positions {
        let lobe = 0.5 + 0.5 * (p.z.atan2(p.x) * 16.0).cos();
        let bulge = 1.0 + 0.018 * lobe * smoothstep(0.5, 0.8, p.y);
        *p *= Vec3::new(bulge, 1.0, bulge);
    }
    let stone = Mesh::merged([basin, lathe(&pedestal, 48, 3.0)])
        .colored(|p, _| Vec3::splat(0.62 + 0.38 * smoothstep(0.2, 0.9, p.y)));
    let disc = |radius_m: f32, height_m: f32| {
        let mut disc = lathe(&[Vec2::new(radius_m, height_m), Vec2::new(0.02, height_m)], 48, 1.0);
        disc.texcoords = disc.positions.iter().map(|p| planar_texcoord(*p, Vec3::Y)).collect();
        disc
    };
    let water = Mesh::merged([disc(1.56, 0.95), disc(0.71, 1.82)]);
    let (stone, water) = (glb.geometry(&stone), glb.geometry(&water.with_tangents()));
    let mesh = glb.mesh("fountain", &[(&stone, palette.limestone), (&water, palette.water)]);
    glb.place("fountain", mesh, FOUNTAIN);
}

/// Nested bronze rings about a copper sun, pierced by an iron axis with an arrow's head.
fn armillary(glb: &mut Glb, palette: &Palette) {
    let ring = |radius_m: f32, width_m: f32, thick_m: f32, tilt: Quat| {
        let profile = ring_profile(radius_m - thick_m..radius_m, -width_m / 2.0..width_m / 2.0);
        lathe(&profile, 72, (radius_m * 12.0).round() / 2.0).transformed(Affine3A::from_quat(tilt))
    };
    let upright = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let axis_tilt = Quat::from_rotation_z(-0.42);
    let turned = |angle_rad: f32| axis_tilt * Quat::from_rotation_y(angle_rad) * upright;
    let mut rings = vec![
        ring(0.88, 0.07, 0.04, upright),
        ring(0.83, 0.06, 0.035, turned(0.75)),
        ring(0.79, 0.05, 0.03, turned(2.1)),
        ring(0.82, 0.09, 0.03, axis_tilt),
        ring(0.74, 0.14, 0.02, axis_tilt * Quat::from_rotation_x(0.41)),
        ring(0.56, 0.04, 0.03, axis_tilt * Quat::from_rotation_x(-0.9)),
    ];
    for side in [-1.0, 1.0] {
        let tropic = ring(0.72, 0.035, 0.025, Quat::IDENTITY).at(0.0, 0.36 * side, 0.0);
        rings.push(tropic.transformed(Affine3A::from_quat(axis_tilt)));
    }
    // Hour marks on the equator.
    for i in 0..24 {
        let angle_rad = i as f32 / 24.0 * std::f32::consts::TAU;
        let mark = cuboid(Vec3::new(0.03, 0.12, 0.02), 0.004).at(0.83, 0.0, 0.0);
        rings.push(mark.transformed(Affine3A::from_quat(axis_tilt * Quat::from_rotation_y(angle_rad))));
    }
    let stand =
        points(&[(0.2, -1.06), (0.14, -1.02), (0.07, -0.98), (0.06, -0.93), (0.1, -0.9), (0.0, -0.86)]);
    rings.push(lathe(&stand, 24, 0.5));
    let axis = Mesh::merged([
        tube(&[Vec3::NEG_Y * 1.12, Vec3::Y * 1.05], 0.018, 10),
        lathe(&points(&[(0.0, 1.02), (0.07, 1.03), (0.0, 1.3)]), 12, 0.5),
        lathe(&points(&[(0.0, -1.2), (0.045, -1.15), (0.045, -1.1), (0.0, -1.05)]), 12, 0.5),
    ])
    .transformed(Affine3A::from_quat(axis_tilt));
    let planets = [(0.74, 0.1, 0.05), (0.56, 2.2, 0.06), (0.74, 3.9, 0.045)].map(
        |(orbit_m, angle_rad, radius_m): (f32, f32, f32)| {
            let place = Affine3A::from_quat(axis_tilt * Quat::from_rotation_y(angle_rad))
                * Affine3A::from_translation(Vec3::X * orbit_m);
            sphere(radius_m, 16, 10).transformed(place)
        },
    );
    let sun = Mesh::merged([sphere(0.21, 40, 24)].into_iter().chain(planets));
    let parts = [(Mesh::merged(rings), palette.bronze), (axis, palette.iron), (sun, palette.copper)];
    let parts = parts.map(|(mesh, material)| (glb.geometry(&mesh), material));
    let mesh = glb.mesh("armillary", &parts.each_ref().map(|(geometry, material)| (geometry, *material)));
    let pose = Pose { position_m: FOUNTAIN.position_m + Vec3::Y * 3.12, ..Pose::origin().turned(0.06) };
    glb.place("armillary", mesh, pose);
}
