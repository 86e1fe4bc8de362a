//! Where a rasteriser may rightly see something else than the ray through a pixel's centre.

use super::gbuffer::interpolate;
use super::view::Ray;
use super::visibility::{Hit, Visibility};

/// How far from a centre a rasteriser's edge may be: half a step of Vulkan's least `subPixelPrecisionBits`, 4,
/// along each axis, for both ends of an edge.
pub(super) const SNAP_PX: f64 = 1.0 / 16.0;

/// Whether two hits about a pixel apart belong to different instances, or to parts of one surface that are not
/// side by side: one lies more than 30 degrees off the other's plane.
pub(super) fn is_torn(visibility: &Visibility, (ray_a, a): (&Ray, &Hit), (ray_b, b): (&Ray, &Hit)) -> bool {
    const MAX_SINE: f64 = 0.5;
    if a.triangle == b.triangle {
        return false;
    }
    if visibility.instance(a) != visibility.instance(b) || a.front_facing != b.front_facing {
        return true;
    }
    let apart = ray_b.at(b.distance) - ray_a.at(a.distance);
    let off_plane = |hit: &Hit| visibility.plane_normal(hit).dot(apart).abs();
    off_plane(a).max(off_plane(b)) > MAX_SINE * apart.length()
}

/// Whether the surface at `b` differs from what `a`'s triangle, extrapolated to the same ray, would show there.
pub(super) fn is_creased(visibility: &Visibility, a: &Hit, ray_b: &Ray, b: &Hit) -> bool {
    /// Differences that change the shading by less than about one part in a thousand, next to the shading's own
    /// slope over `SNAP_PX`.
    const MAX_STEP: f64 = 2e-3;
    if a.triangle == b.triangle {
        return false;
    }
    if visibility.instance(a) != visibility.instance(b) || a.front_facing != b.front_facing {
        return true;
    }
    let Some(continued) = visibility.extrapolate(ray_b, a.triangle, a.front_facing) else { return true };
    if (continued.distance - b.distance).abs() > MAX_STEP * b.distance.abs() {
        return true;
    }
    let (here, there) = (interpolate(visibility, &continued), interpolate(visibility, b));
    let turned = here.normal_world.normalize_or_zero() - there.normal_world.normalize_or_zero();
    turned.length() > MAX_STEP || (here.color - there.color).abs().max_element() > MAX_STEP
}
