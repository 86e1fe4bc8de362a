//! The courtyard's 47 lights. Candela are such that surfaces a metre or two away come out near 1 nit.

use super::super::glb::{Glb, Light, LightKind, Pose};
use super::super::shape::circle;
use super::palette::BULB_COLORS;
use super::{FESTOONS, FOUNTAIN, Festoon, LANTERNS_M, POSTS_M, SHOP_Z_M};
use glam::Vec3;

use super::architecture::{ARCADE_X_M, PORTAL_Z_M};

/// Linear Rec.709 of a lantern's light: paler than its glass looks.
const AMBER: Vec3 = Vec3::new(1.0, 0.64, 0.33);

/// Places all lights.
pub fn build(glb: &mut Glb) {
    sky(glb);
    let point = |name, color, intensity_cd, range_m| Light {
        name,
        color,
        kind: LightKind::Point { intensity_cd, range_m },
    };
    let lantern = point("lantern light", AMBER, 9.0, 6.5);
    for p in LANTERNS_M {
        glb.light(lantern, Pose::at(p.x, p.y, p.z));
    }
    let post = point("post light", AMBER, 11.0, 7.0);
    for [x_m, z_m] in POSTS_M {
        glb.light(post, Pose::at(x_m, 2.42, z_m));
    }
    for festoon in &FESTOONS {
        for k in (1..Festoon::BULBS).step_by(3) {
            let p = festoon.bulb_m(k);
            let name = ["gold bulb light", "coral bulb light", "turquoise bulb light", "violet bulb light"];
            let color = festoon.color(k);
            glb.light(point(name[color], BULB_COLORS[color], 7.0, 6.0), Pose::at(p.x, p.y - 0.15, p.z));
        }
    }
    let pool = point("fountain light", Vec3::new(0.12, 0.8, 0.9), 1.6, 3.5);
    for i in 0..4 {
        let around = circle(i as f32 / 4.0 + 0.125) * 1.15;
        let center = FOUNTAIN.position_m;
        glb.light(pool, Pose::at(center.x + around.x, center.y + 1.15, center.z + around.y));
    }
    let warm_passage = point("passage light", Vec3::new(1.0, 0.5, 0.16), 14.0, 7.0);
    glb.light(warm_passage, Pose::at(0.0, 3.0, PORTAL_Z_M - 2.4));
    let shop = point("shop light", Vec3::new(1.0, 0.7, 0.38), 4.0, 4.0);
    glb.light(shop, Pose::at(-ARCADE_X_M + 1.1, 2.3, SHOP_Z_M));
    spots(glb);
}

/// Moon, the dusk sky as two broad directions, and what the paving throws back.
fn sky(glb: &mut Glb) {
    let sources = [
        ("moon", Vec3::new(0.5, 0.66, 1.0), 0.8, Vec3::new(0.55, 1.0, 0.5)),
        ("zenith", Vec3::new(0.35, 0.45, 1.0), 0.36, Vec3::new(-0.2, 1.0, 0.3)),
        ("sunset", Vec3::new(1.0, 0.5, 0.42), 0.25, Vec3::new(-0.3, 0.35, -1.0)),
        ("ground", Vec3::new(0.9, 0.6, 0.5), 0.12, Vec3::new(0.0, -1.0, 0.4)),
    ];
    for (name, color, illuminance_lx, towards) in sources {
        let kind = LightKind::Directional { illuminance_lx };
        glb.light(Light { name, color, kind }, Pose::looking(towards, Vec3::ZERO));
    }
}

fn spots(glb: &mut Glb) {
    let spot = |name, color, intensity_cd, range_m, outer_deg: f32| Light {
        name,
        color,
        kind: LightKind::Spot {
            intensity_cd,
            range_m,
            inner_rad: (outer_deg * 0.55).to_radians(),
            outer_rad: outer_deg.to_radians(),
        },
    };
    let center = FOUNTAIN.position_m;
    let globe_m = center + Vec3::Y * 3.1;
    for (color, from) in [
        (Vec3::new(1.0, 0.82, 0.55), Vec3::new(1.6, 0.9, 2.2)),
        (Vec3::new(0.3, 0.85, 1.0), Vec3::new(-1.9, 1.1, 0.9)),
        (Vec3::new(1.0, 0.35, 0.5), Vec3::new(1.3, 1.0, -1.8)),
    ] {
        glb.light(spot("armillary spot", color, 26.0, 7.0, 24.0), Pose::looking(center + from, globe_m));
    }
    // Grazing the portal wall from the ground, and banners from below.
    for side in [-1.0_f32, 1.0] {
        let wash = spot("banner wash", Vec3::new(1.0, 0.42, 0.5), 30.0, 9.0, 32.0);
        let foot = Vec3::new(side * 3.6, 0.3, PORTAL_Z_M + 1.5);
        glb.light(wash, Pose::looking(foot, Vec3::new(side * 3.6, 4.6, PORTAL_Z_M)));
        let crown = spot("portal spot", Vec3::new(0.45, 0.5, 1.0), 40.0, 9.0, 40.0);
        let foot = Vec3::new(side * 2.0, 0.3, PORTAL_Z_M + 2.0);
        glb.light(crown, Pose::looking(foot, Vec3::new(side * 0.7, 6.0, PORTAL_Z_M)));
        for z_m in [-4.8, 1.6] {
            let (name, color) = if side * (z_m + 1.6) > 0.0 {
                ("violet pier wash", Vec3::new(0.6, 0.25, 1.0))
            } else {
                ("teal pier wash", Vec3::new(0.1, 0.85, 0.75))
            };
            let foot = Vec3::new(side * (ARCADE_X_M - 1.0), 0.2, z_m);
            let target = Vec3::new(side * (ARCADE_X_M - 0.2), 4.4, z_m);
            glb.light(spot(name, color, 24.0, 7.5, 26.0), Pose::looking(foot, target));
        }
    }
}
