//! A walled courtyard at dusk: wet paving, arcades, a fountain with an armillary sphere, lanterns and banners.

mod architecture;
mod fountain;
mod furnishing;
mod lighting;
mod palette;
mod skyline;
mod surface;

use super::glb::{Glb, Pose};
use architecture::{ARCADE_X_M, BAYS_Z_M, TERRACE_M};
use glam::{Quat, Vec3};
use palette::Palette;

/// Where the fountain stands.
const FOUNTAIN: Pose =
    Pose { position_m: Vec3::new(-0.4, 0.0, -1.2), rotation: Quat::IDENTITY, scale: Vec3::ONE };
/// The bay of the west arcade that has the shop.
const SHOP_Z_M: f32 = BAYS_Z_M[2];
/// Lanterns that stand on posts: x and z.
const POSTS_M: [[f32; 2]; 4] = [[-3.0, 3.4], [2.9, -5.2], [-3.3, -5.6], [3.4, 1.8]];
/// The hanging lanterns' flames, one in each arch.
const LANTERNS_M: [Vec3; 10] = {
    let mut all = [Vec3::ZERO; 10];
    let mut i = 0;
    while i < 10 {
        let x_m = if i < 5 { -ARCADE_X_M } else { ARCADE_X_M };
        all[i] = Vec3::new(x_m, 3.42, BAYS_Z_M[i % 5]);
        i += 1;
    }
    all
};

/// A cable with bulbs from one terrace to the other.
struct Festoon {
    from_m: Vec3,
    to_m: Vec3,
    sag_m: f32,
    first_color: usize,
}

const FESTOONS: [Festoon; 3] =
    [Festoon::new(-6.4, -4.0, 0), Festoon::new(-1.0, 0.8, 2), Festoon::new(5.4, 2.2, 1)];

impl Festoon {
    const BULBS: usize = 13;

    const fn new(west_z_m: f32, east_z_m: f32, first_color: usize) -> Self {
        let height_m = TERRACE_M + 0.7;
        Self {
            from_m: Vec3::new(-ARCADE_X_M + 0.45, height_m, west_z_m),
            to_m: Vec3::new(ARCADE_X_M - 0.45, height_m, east_z_m),
            sag_m: 1.25,
            first_color,
        }
    }

    /// A parabola: what a shallow hanging cable is, nearly.
    fn point_m(&self, t: f32) -> Vec3 {
        self.from_m.lerp(self.to_m, t) - Vec3::Y * (4.0 * t * (1.0 - t) * self.sag_m)
    }

    fn bulb_m(&self, bulb: usize) -> Vec3 {
        self.point_m((bulb as f32 + 0.5) / Self::BULBS as f32)
    }

    /// Index into the bulbs' colours.
    fn color(&self, bulb: usize) -> usize {
        (bulb + self.first_color) % palette::BULB_COLORS.len()
    }
}

/// The file's bytes.
pub fn glb() -> Vec<u8> {
    let mut glb = Glb::default();
    let palette = Palette::new(&mut glb);
    architecture::build(&mut glb, &palette);
    skyline::build(&mut glb, &palette);
    fountain::build(&mut glb, &palette);
    furnishing::build(&mut glb, &palette);
    lighting::build(&mut glb);
    let view = |from: [f32; 3], target: [f32; 3]| Pose::looking(Vec3::from(from), Vec3::from(target));
    glb.perspective("main", 48.0, view([2.5, 1.75, 8.6], [-0.5, 2.55, -2.0]));
    glb.perspective("arcade", 55.0, view([-6.3, 1.7, 7.0], [-4.2, 2.0, -4.0]));
    glb.perspective("terrace", 50.0, view([4.4, 6.6, 7.6], [-1.6, 1.4, -3.0]));
    glb.perspective("armillary", 34.0, view([1.9, 2.3, 2.9], [-0.4, 2.6, -1.2]));
    glb.finish("courtyard")
}
