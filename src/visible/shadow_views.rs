//! The views from lights that shadow maps are drawn through. Computed in f64: what they show has to stay in place.

use glam::{DMat3, DMat4, DVec3, DVec4, Mat4, Vec2, Vec3, Vec4Swizzles};
use serde::Serialize;

use super::{Frustum, Sphere, TexelArea};
use crate::scene::{Aabb, Light, LightKind};

/// Nearer than this to a point or spot light, distances to casters are not told apart, metres. With reversed depth in
/// floats the precision farther away does not depend on it.
const NEAR_M: f64 = 0.01;

/// A cone whose edge is farther from its axis than this (radians) has six maps around the light, as a point light has:
/// a single plane's texels at 60 degrees are already 4 times as far apart, seen from the light, as in the middle.
const MOST_CONE_RAD: f32 = std::f32::consts::FRAC_PI_3;

/// A cascade's map moves in steps of this share of its side (as whole texels): rarely, so that maps are kept.
const STEP_SHARE: u32 = 16;

/// Depth ranges are longer than the scene by this share at both ends, against rounding.
const DEPTH_MARGIN: f64 = 1e-3;

/// How many views a light's shadow takes, and of what kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ShadowShape {
    /// Directional lights: one parallel view a cascade.
    Cascades,
    /// Box lights: one parallel view.
    Slab,
    /// Spot lights: one perspective view.
    Cone,
    /// Point lights, and cones too wide for one view: six, towards +X, -X, +Y, -Y, +Z and -Z.
    Cube,
}

impl ShadowShape {
    /// The faces of [`Self::Cube`].
    pub const FACES: usize = 6;

    /// Whether its views are parallel, so that depths are even steps of distance.
    pub fn is_parallel(self) -> bool {
        matches!(self, Self::Cascades | Self::Slab)
    }

    /// Of a light; `None` for those that cast no shadow.
    pub fn of(light: &Light) -> Option<Self> {
        light.shadow?;
        match light.kind {
            LightKind::Directional { .. } => Some(Self::Cascades),
            LightKind::Box { .. } => Some(Self::Slab),
            LightKind::Spot { outer_cone_rad, .. } if outer_cone_rad <= MOST_CONE_RAD => Some(Self::Cone),
            LightKind::Spot { .. } | LightKind::Point { .. } => Some(Self::Cube),
            LightKind::Hemisphere { .. } => None,
        }
    }
}

/// A square part of a shadow map: how many texels it has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct TileSize {
    /// Along a side.
    pub texels: u32,
    /// Texels at each edge that are drawn only so that filters find something there; less than a quarter of the side.
    pub guard: u32,
}

impl TileSize {
    fn side(self) -> f64 {
        f64::from(self.texels)
    }

    /// How much larger the tile is than what is inside its guard.
    fn widened(self) -> f64 {
        self.side() / (self.side() - 2.0 * f64::from(self.guard))
    }
}

/// What a tile of a shadow map shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowView {
    /// Vulkan clip space, y down, reversed depth, over the whole tile.
    pub clip_from_world: Mat4,
    /// How wide a texel is in metres, at w = 1 of clip space: parallel views have it everywhere, perspective ones at a
    /// metre from the light.
    pub texel_m: f32,
    /// How far casters are pushed away from the light, in texels: by as much as their depth changes over so many along x
    /// or y, whichever changes it more.
    ///
    /// A filter compares a receiver with texels around it. Where another surface rises towards the light from an edge beside
    /// the receiver, they are nearer by that surface's slope times their distance: pushed by as much, it darkens nothing
    /// that rays from the light reach. What is thinner lets light past where it meets other surfaces.
    pub slope_texels: f32,
    /// Whether what is in front of the near plane is drawn upon it, because it casts shadows too. Parallel views only.
    pub pancaked: bool,
    /// The light's place and how far it reaches, metres: what is farther away casts no shadow. `None`: no end.
    pub reach: Option<(Vec3, f32)>,
}

impl ShadowView {
    /// A cascade of a light that travels along `direction` (unit length), with room in depth for all of `bounds`.
    ///
    /// If it shall be `stable`, its centre is moved to a multiple of some texels, so that all centres' texels lie on one
    /// lattice.
    pub fn cascade(direction: DVec3, sphere: &Sphere, bounds: &Aabb, tile: TileSize, stable: bool) -> Self {
        let step_texels = (tile.texels / STEP_SHARE).max(1);
        let usable = tile.side() - 2.0 * f64::from(tile.guard) - f64::from(step_texels);
        let texel_m = 2.0 * sphere.radius_m / usable;
        let step_m = texel_m * f64::from(step_texels);
        let light_from_world = light_frame(direction).transpose();
        let center = light_from_world * sphere.center;
        let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        let axis = light_from_world.row(2);
        let (middle, half) = (((min + max) * 0.5).dot(axis), ((max - min) * 0.5).dot(axis.abs()));
        let margin = (half * DEPTH_MARGIN).max(f64::from(f32::MIN_POSITIVE));
        let follow = |n: f64| if stable { (n / step_m).round() * step_m } else { n };
        let place = DVec3::new(follow(center.x), follow(center.y), middle);
        let half_m = DVec3::new(1.0, 1.0, 0.0) * (texel_m * tile.side() * 0.5) + DVec3::Z * (half + margin);
        Self::parallel(light_from_world, place, half_m, texel_m, true)
    }

    /// A box light's. Nothing outside of the box casts shadows.
    pub fn slab(light: &Light, tile: TileSize) -> Self {
        let LightKind::Box { size_m, .. } = light.kind else { unreachable!("only boxes have this shape") };
        let (direction, up) = (light.direction_world.as_dvec3(), light.up_world.as_dvec3());
        let light_from_world = DMat3::from_cols(direction.cross(up), up, -direction).transpose();
        let half = size_m.as_dvec3() * 0.5;
        let wide = half.x.max(half.y) * tile.widened();
        let place = light_from_world * light.position_world.as_dvec3();
        Self::parallel(
            light_from_world,
            place,
            DVec3::new(wide, wide, half.z),
            2.0 * wide / tile.side(),
            false,
        )
    }

    /// `place` is the view's middle in the light's frame, `half_m` its half extent.
    fn parallel(light_from_world: DMat3, place: DVec3, half_m: DVec3, texel_m: f64, pancaked: bool) -> Self {
        let row = |i: usize, scale: f64, offset: f64| (light_from_world.row(i) * scale).extend(offset);
        let (x, y, z) = (half_m.x.recip(), -half_m.y.recip(), 0.5 * half_m.z.recip());
        let rows = [
            row(0, x, -place.x * x),
            row(1, y, -place.y * y),
            // 1 at the end nearer to the light, which is towards +z.
            row(2, z, 0.5 - place.z * z),
            DVec4::W,
        ];
        Self {
            clip_from_world: from_rows(rows),
            texel_m: texel_m as f32,
            slope_texels: 0.0,
            pancaked,
            reach: None,
        }
    }

    /// A spot light's.
    pub fn cone(light: &Light, tile: TileSize) -> Self {
        let LightKind::Spot { outer_cone_rad, .. } = light.kind else {
            unreachable!("only spots have this shape")
        };
        let frame = light_frame(light.direction_world.as_dvec3());
        Self::perspective(light, frame, f64::from(outer_cone_rad).tan() * tile.widened(), tile)
    }

    /// One face of the cube around a light.
    ///
    /// Its guard is beyond the 90 degrees that are the face's own, so that filters near an edge need no other face.
    pub fn face(light: &Light, face: usize, tile: TileSize) -> Self {
        let axis = DVec3::AXES[face / 2] * if face.is_multiple_of(2) { 1.0 } else { -1.0 };
        Self::perspective(light, light_frame(axis), tile.widened(), tile)
    }

    /// `frame` has the columns right, up and back; `half` is half the width at a metre's distance.
    fn perspective(light: &Light, frame: DMat3, half: f64, tile: TileSize) -> Self {
        let place = light.position_world.as_dvec3();
        let row = |axis: DVec3| axis.extend(-axis.dot(place));
        let rows =
            [row(frame.x_axis / half), row(-frame.y_axis / half), DVec4::W * NEAR_M, row(-frame.z_axis)];
        let texel_m = (2.0 * half / tile.side()) as f32;
        let reach = light.range_m.map(|range| (light.position_world, range));
        Self { clip_from_world: from_rows(rows), texel_m, slope_texels: 0.0, pancaked: false, reach }
    }

    /// What can cast a shadow in this view.
    pub fn volume(&self) -> ShadowVolume {
        ShadowVolume { frustum: Frustum::new(&self.casters_clip_from_world()), reach: self.reach }
    }

    /// The part of a tile of this side that a box may cover.
    pub fn area(&self, bounds: &Aabb, texels: u32) -> TexelArea {
        // Vertices are rounded otherwise than corners are.
        const ROUNDING_TEXELS: f32 = 1.0;
        let side = texels as f32;
        let (mut min, mut max) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for corner in 0..8 {
            let pick = |axis: usize| [bounds.min, bounds.max][corner >> axis & 1][axis];
            let corner = Vec3::new(pick(0), pick(1), pick(2));
            let clip = self.clip_from_world * corner.extend(1.0);
            let place = (clip.xy() / clip.w * 0.5 + 0.5) * side;
            // What reaches behind the light covers everything, as does what is too far away for numbers.
            if clip.w <= 0.0 || !place.is_finite() {
                return TexelArea { min: [0; 2], max: [texels; 2] };
            }
            (min, max) = (min.min(place), max.max(place));
        }
        // Casting to integers saturates.
        let min = (min - ROUNDING_TEXELS).floor().to_array().map(|n| (n as u32).min(texels));
        let max = (max + ROUNDING_TEXELS).ceil().to_array().map(|n| (n as u32).min(texels));
        TexelArea { min, max }
    }

    fn casters_clip_from_world(&self) -> Mat4 {
        if !self.pancaked {
            return self.clip_from_world;
        }
        // Depth 0 of every point is between the near plane and the far one. What lies beyond all receivers is culled by
        // none, and there is seldom anything.
        let depth = Mat4::from_cols_array(&[
            1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0,
        ]);
        depth * self.clip_from_world
    }
}

/// The part of the world that can cast a shadow in a view.
#[derive(Clone, Copy, Debug)]
pub struct ShadowVolume {
    frustum: Frustum,
    reach: Option<(Vec3, f32)>,
}

impl ShadowVolume {
    /// Whether a box is outside.
    pub fn misses(&self, bounds: &Aabb) -> bool {
        let too_far = self.reach.is_some_and(|(center, range)| {
            center.clamp(bounds.min, bounds.max).distance_squared(center) > range * range
        });
        too_far || self.frustum.misses_aabb(bounds)
    }
}

/// Right, up and back of a light that travels along `direction`; the same for the same direction, whatever moves.
fn light_frame(direction: DVec3) -> DMat3 {
    // As long as rounding to f32 left it, it would tilt the frame.
    let direction = direction.normalize();
    let (a, b) = direction.any_orthonormal_pair();
    // (a, b, direction) is right-handed, so (a, -b, -direction) is, too.
    DMat3::from_cols(a, -b, -direction)
}

fn from_rows(rows: [DVec4; 4]) -> Mat4 {
    DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose().as_mat4()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Shadow;

    const TILE: TileSize = TileSize { texels: 512, guard: 5 };
    const BOUNDS: Aabb = Aabb { min: Vec3::new(-20.0, 0.0, -20.0), max: Vec3::new(20.0, 6.0, 20.0) };

    /// Where a point is in the tile, texels, and its depth.
    fn texel(view: &ShadowView, tile: TileSize, point: DVec3) -> DVec3 {
        let clip = view.clip_from_world.as_dmat4() * point.extend(1.0);
        let ndc = clip.truncate() / clip.w;
        DVec3::new((ndc.x * 0.5 + 0.5) * tile.side(), (ndc.y * 0.5 + 0.5) * tile.side(), ndc.z)
    }

    /// Whether it is inside the tile's guard.
    fn inside(at: DVec3, tile: TileSize) -> bool {
        let guard = f64::from(tile.guard);
        [at.x, at.y].iter().all(|&n| n > guard && n < tile.side() - guard) && (0.0..=1.0).contains(&at.z)
    }

    /// Directions in all quarters, one along an axis.
    fn directions() -> [DVec3; 4] {
        [
            DVec3::NEG_Y,
            DVec3::new(0.3, -1.0, 0.2).normalize(),
            DVec3::new(-0.9, -0.2, 0.5).normalize(),
            DVec3::new(0.1, 0.7, -0.4).normalize(),
        ]
    }

    fn light(kind: LightKind) -> Light {
        let light = Light::new(kind).towards(Vec3::new(0.4, -1.0, 0.3));
        Light { position_world: Vec3::new(1.0, 4.0, -2.0), shadow: Some(Shadow::default()), ..light }
    }

    #[test]
    fn texels_keep_their_places_while_the_camera_moves() {
        // In texels: f32 rounds places of some metres in a map of some metres to this.
        const ROUNDING: f64 = 1e-3;
        for direction in directions() {
            let point = DVec3::new(1.7, 0.3, -2.2);
            let at = |x: f64| {
                let sphere = Sphere { center: DVec3::new(x, 0.5 * x, -0.3 * x), radius_m: 7.0 };
                ShadowView::cascade(direction, &sphere, &BOUNDS, TILE, true)
            };
            let first = at(0.0);
            let mut views = 1;
            let mut last = first;
            for step in 1..400 {
                // A tenth of a texel along the longest axis.
                let view = at(f64::from(step) * 0.1 * f64::from(first.texel_m));
                views += usize::from(view != last);
                last = view;
                let moved = texel(&view, TILE, point) - texel(&first, TILE, point);
                assert!((moved.x - moved.x.round()).abs() < ROUNDING, "{direction}, {step}: {moved}");
                assert!((moved.y - moved.y.round()).abs() < ROUNDING, "{direction}, {step}: {moved}");
                assert_eq!(moved.z, 0.0, "{direction}, {step}");
            }
            // 40 texels at most, in steps of 32.
            assert!((1..=5).contains(&views), "{direction}: {views}");
        }
    }

    #[test]
    fn a_cascade_holds_its_sphere_and_all_depths() {
        for (direction, x) in directions().into_iter().zip([0.0, 0.77, -3.1, 12.3]) {
            let sphere = Sphere { center: DVec3::new(x, 1.0, -x), radius_m: 3.0 };
            let view = ShadowView::cascade(direction, &sphere, &BOUNDS, TILE, true);
            let (a, b) = direction.any_orthonormal_pair();
            for edge in [a, -a, b, -b] {
                let at = texel(&view, TILE, sphere.center + edge * sphere.radius_m);
                assert!(inside(at.with_z(0.5), TILE), "{direction}: {at}");
            }
            for corner in 0..8 {
                let pick = |axis: usize| [BOUNDS.min, BOUNDS.max][corner >> axis & 1][axis];
                let depth = texel(&view, TILE, Vec3::new(pick(0), pick(1), pick(2)).as_dvec3()).z;
                assert!((0.0..=1.0).contains(&depth), "{direction}: {depth}");
            }
            let [near, far] = [-1.0, 1.0].map(|d| texel(&view, TILE, sphere.center + direction * d).z);
            assert!(near > far, "nearer to the light is more");
            let wide = texel(&view, TILE, sphere.center + a * f64::from(view.texel_m))
                - texel(&view, TILE, sphere.center);
            assert!((wide.truncate().length() - 1.0).abs() < 1e-3, "{wide}");
        }
    }

    #[test]
    fn a_cone_holds_its_light() {
        for outer_cone_rad in [0.05, 0.4, 0.9, MOST_CONE_RAD] {
            let lamp = light(LightKind::Spot { intensity_cd: 1.0, inner_cone_rad: 0.0, outer_cone_rad });
            assert_eq!(ShadowShape::of(&lamp), Some(ShadowShape::Cone));
            let view = ShadowView::cone(&lamp, TILE);
            let axis = lamp.direction_world.as_dvec3();
            let (a, b) = axis.any_orthonormal_pair();
            for edge in [a, -a, b, -b] {
                let ray = axis + edge * f64::from(outer_cone_rad).tan() * 0.999;
                for distance in [0.1, 3.0, 500.0] {
                    let at = texel(&view, TILE, lamp.position_world.as_dvec3() + ray * distance);
                    assert!(inside(at, TILE), "{outer_cone_rad}: {at}");
                    assert!((at.z - NEAR_M / distance).abs() < 1e-6);
                }
            }
        }
        let wide = LightKind::Spot { intensity_cd: 1.0, inner_cone_rad: 0.0, outer_cone_rad: 1.2 };
        assert_eq!(ShadowShape::of(&light(wide)), Some(ShadowShape::Cube));
    }

    #[test]
    fn faces_share_their_edges_and_overlap_by_the_guard() {
        let lamp = light(LightKind::Point { intensity_cd: 1.0 });
        let center = lamp.position_world.as_dvec3();
        for face in 0..ShadowShape::FACES {
            let view = ShadowView::face(&lamp, face, TILE);
            let axis = DVec3::AXES[face / 2] * if face.is_multiple_of(2) { 1.0 } else { -1.0 };
            let (a, b) = (DVec3::new(axis.y, axis.z, axis.x), DVec3::new(axis.z, axis.x, axis.y));
            for (s, t) in [(1.0, 1.0), (-1.0, 0.3), (0.2, -1.0), (0.0, 0.0)] {
                let at = texel(&view, TILE, center + (axis + (a * s + b * t) * (1.0 - 1e-9)) * 2.5);
                assert!(inside(at, TileSize { guard: TILE.guard - 1, ..TILE }), "{face}: {at}");
                let edge = at.x.min(at.y).min(TILE.side() - at.x).min(TILE.side() - at.y);
                assert_eq!((edge - f64::from(TILE.guard)).abs() < 1e-3, s.abs().max(t.abs()) == 1.0);
            }
        }
    }

    #[test]
    fn what_is_beyond_a_range_casts_no_shadow() {
        let lamp = Light { range_m: Some(5.0), ..light(LightKind::Point { intensity_cd: 1.0 }) };
        let volume = ShadowView::face(&lamp, 0, TILE).volume();
        let block = |x: f32| {
            let center = lamp.position_world + Vec3::X * x;
            Aabb { min: center - 0.5, max: center + 0.5 }
        };
        // Behind, around, before, reaching in, and beyond.
        let missed = [-2.0, 0.0, 3.0, 5.4, 5.6].map(|x| volume.misses(&block(x)));
        assert_eq!(missed, [true, false, false, false, true]);
        let endless = ShadowView::face(&Light { range_m: None, ..lamp.clone() }, 0, TILE).volume();
        assert!(!endless.misses(&block(5.6)));
    }

    #[test]
    fn an_area_holds_what_its_box_covers() {
        let lamp = light(LightKind::Point { intensity_cd: 1.0 });
        let sphere = Sphere { center: DVec3::ZERO, radius_m: 3.0 };
        let sun = ShadowView::cascade(directions()[1], &sphere, &BOUNDS, TILE, true);
        for view in [ShadowView::face(&lamp, 3, TILE), sun] {
            for (x, size) in [(-1.0, 0.1), (0.3, 0.7), (1.9, 0.4), (0.0, 9.0)] {
                let center = Vec3::new(1.0 + x, 0.0, x - 2.0);
                let bounds = Aabb { min: center - size, max: center + size };
                let area = view.area(&bounds, TILE.texels);
                for i in 0..125 {
                    let share = Vec3::new((i % 5) as f32, (i / 5 % 5) as f32, (i / 25) as f32) * 0.25;
                    let point = bounds.min + (bounds.max - bounds.min) * share;
                    if (view.clip_from_world * point.extend(1.0)).w <= 0.0 {
                        continue;
                    }
                    let at = texel(&view, TILE, point.as_dvec3());
                    for axis in (0..2).filter(|&axis| at[axis] >= 0.0 && at[axis] < TILE.side()) {
                        let range = f64::from(area.min[axis])..f64::from(area.max[axis]);
                        assert!(range.contains(&at[axis]), "{bounds:?}: {at} in {area:?}");
                    }
                }
                let whole = TexelArea { min: [0; 2], max: [TILE.texels; 2] };
                assert_eq!(area == whole, size == 9.0, "{bounds:?}: {area:?}");
                assert_eq!(area.union(TexelArea::default()), area);
            }
        }
    }

    #[test]
    fn a_slab_is_the_box() {
        let size_m = Vec3::new(4.0, 2.0, 6.0);
        let lamp = light(LightKind::Box { illuminance_lx: 1.0, size_m, falloff_m: 0.1 });
        let view = ShadowView::slab(&lamp, TILE);
        let (x, y, z) = (lamp.right_world(), lamp.up_world, lamp.direction_world);
        for (s, t, u) in [(-1.0, 1.0, 1.0), (1.0, -1.0, -1.0), (0.5, 1.0, 0.0)] {
            let half = size_m * 0.5 * 0.999;
            let place = lamp.position_world + x * half.x * s + y * half.y * t + z * half.z * u;
            let at = texel(&view, TILE, place.as_dvec3());
            assert!(inside(at, TILE), "{at}");
            assert!((at.z - f64::from(0.5 - 0.5 * u)).abs() < 1e-3, "{at}");
        }
        assert!(!view.pancaked, "what is outside of the box casts no shadow");
    }
}
