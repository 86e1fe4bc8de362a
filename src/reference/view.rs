//! A camera and an image size as rays, and depth as the rasteriser stores it.

use glam::{DMat3, DMat4, DVec2, DVec3};

use crate::scene::{Camera, Projection};

/// A camera's image plane in world space.
///
/// Rays are scaled so that the ray parameter is the distance along the view axis, for either projection.
#[derive(Clone, Debug)]
pub struct View {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The camera's position, world space, metres.
    pub position_world: DVec3,
    /// World space: from the image's middle to its right edge, at distance 1 (perspective) or in metres
    /// (orthographic).
    pub right_world: DVec3,
    /// World space: from the image's middle to its lower edge, in the unit of `right_world`.
    pub down_world: DVec3,
    /// World space, unit length: the way the camera looks.
    pub forward_world: DVec3,
    projection: Projection,
    /// What places are counted from, pixels from the image's upper left corner.
    origin_px: DVec2,
}

/// A part of an image, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Width and height of the whole image.
    pub image: [u32; 2],
    /// The column and the row at which the part begins.
    pub origin: [u32; 2],
    /// Width and height of the part.
    pub size: [u32; 2],
}

/// A half-line in world space. Its parameter is the distance along the view axis, metres.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where the parameter is 0.
    pub origin: DVec3,
    /// How far the ray goes while the view distance grows by 1.
    pub direction: DVec3,
    /// View distances of the near and the far plane: what lies outside is clipped.
    pub range: [f64; 2],
}

impl Ray {
    /// The point at this view distance.
    pub fn at(&self, distance: f64) -> DVec3 {
        self.origin + self.direction * distance
    }
}

impl View {
    /// The view of `camera` in an image of `size` pixels; the image's aspect ratio decides the width, as in
    /// [`Projection::clip_from_view`].
    pub fn new(camera: &Camera, size: [u32; 2]) -> Self {
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        let half_height = match camera.projection {
            Projection::Perspective { yfov_rad, .. } => (f64::from(yfov_rad) * 0.5).tan(),
            Projection::Orthographic { ymag_m, .. } => f64::from(ymag_m),
        };
        let world_from_view: DMat4 = camera.world_from_view.as_dmat4();
        Self {
            size,
            position_world: world_from_view.w_axis.truncate(),
            right_world: world_from_view.x_axis.truncate() * (half_height * aspect),
            down_world: -world_from_view.y_axis.truncate() * half_height,
            forward_world: -world_from_view.z_axis.truncate(),
            projection: camera.projection,
            origin_px: DVec2::ZERO,
        }
    }

    /// The same view; places are counted from the window's corner.
    pub fn within(camera: &Camera, window: &Window) -> Self {
        let [x, y] = window.origin.map(f64::from);
        Self { origin_px: DVec2::new(x, y), ..Self::new(camera, window.image) }
    }

    /// The same view; places are counted from so far to the right and down, pixels.
    pub fn shifted(self, shift_px: DVec2) -> Self {
        Self { origin_px: self.origin_px + shift_px, ..self }
    }

    /// The ray through a place in the image, in pixels: (0, 0) is the upper left corner, (0.5, 0.5) the first
    /// pixel's centre.
    pub fn ray(&self, place_px: DVec2) -> Ray {
        let ndc = 2.0 * (place_px + self.origin_px)
            / DVec2::new(f64::from(self.size[0]), f64::from(self.size[1]))
            - 1.0;
        let offset = self.right_world * ndc.x + self.down_world * ndc.y;
        match self.projection {
            Projection::Perspective { znear_m, zfar_m, .. } => Ray {
                origin: self.position_world,
                direction: self.forward_world + offset,
                range: [f64::from(znear_m), zfar_m.map_or(f64::INFINITY, f64::from)],
            },
            Projection::Orthographic { znear_m, zfar_m, .. } => Ray {
                origin: self.position_world + offset,
                direction: self.forward_world,
                range: [f64::from(znear_m), f64::from(zfar_m)],
            },
        }
    }

    /// The ray through the centre of a pixel.
    pub fn ray_through_pixel(&self, pixel: [u32; 2]) -> Ray {
        self.ray(DVec2::new(f64::from(pixel[0]) + 0.5, f64::from(pixel[1]) + 0.5))
    }

    /// Where in the image a point in world space is, in pixels as of [`Self::ray`]; `None` where it is not before the camera.
    pub fn place(&self, position_world: DVec3) -> Option<DVec2> {
        // Axes of single precision are not quite at right angles.
        let axes = DMat3::from_cols(self.right_world, self.down_world, self.forward_world);
        let along = axes.inverse() * (position_world - self.position_world);
        let ndc = match self.projection {
            Projection::Perspective { .. } if along.z <= 0.0 => return None,
            Projection::Perspective { .. } => along.truncate() / along.z,
            Projection::Orthographic { .. } => along.truncate(),
        };
        let size = DVec2::new(f64::from(self.size[0]), f64::from(self.size[1]));
        Some((ndc + 1.0) * 0.5 * size - self.origin_px)
    }

    /// Unit vector from a point in world space towards the viewer: the `v` of the shading formulas.
    pub fn to_viewer(&self, position_world: DVec3) -> DVec3 {
        match self.projection {
            Projection::Perspective { .. } => (self.position_world - position_world).normalize(),
            Projection::Orthographic { .. } => -self.forward_world,
        }
    }

    /// Where the ray to a point in world space is at distance 0 along the view axis.
    pub fn ray_start(&self, position_world: DVec3) -> DVec3 {
        match self.projection {
            Projection::Perspective { .. } => self.position_world,
            Projection::Orthographic { .. } => {
                let way = position_world - self.position_world;
                position_world - self.forward_world * way.dot(self.forward_world)
            }
        }
    }

    /// Reversed depth (1 near, 0 far) of a view distance in metres.
    pub fn depth_from_distance(&self, distance: f64) -> f64 {
        match self.projection {
            Projection::Perspective { znear_m, zfar_m: None, .. } => f64::from(znear_m) / distance,
            Projection::Perspective { znear_m, zfar_m: Some(far), .. } => {
                let (near, far) = (f64::from(znear_m), f64::from(far));
                near * (far - distance) / (distance * (far - near))
            }
            Projection::Orthographic { znear_m, zfar_m, .. } => {
                let (near, far) = (f64::from(znear_m), f64::from(zfar_m));
                (far - distance) / (far - near)
            }
        }
    }

    /// View distance in metres of a reversed depth.
    pub fn distance_from_depth(&self, depth: f64) -> f64 {
        match self.projection {
            Projection::Perspective { znear_m, zfar_m: None, .. } => f64::from(znear_m) / depth,
            Projection::Perspective { znear_m, zfar_m: Some(far), .. } => {
                let (near, far) = (f64::from(znear_m), f64::from(far));
                near * far / (near + depth * (far - near))
            }
            Projection::Orthographic { znear_m, zfar_m, .. } => {
                let (near, far) = (f64::from(znear_m), f64::from(zfar_m));
                far + depth * (near - far)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::testing::{camera_at, orthographic, perspective};
    use glam::{Mat4, Vec3};

    /// f32 matrices carry about 7 digits through one product and one division.
    const F32_TOLERANCE: f64 = 2e-5;

    #[test]
    fn rays_and_depth_agree_with_the_projection_matrix() {
        let size = [320, 180];
        let aspect = 320.0 / 180.0;
        let placement = Mat4::from_rotation_translation(
            glam::Quat::from_euler(glam::EulerRot::YXZ, 0.7, -0.3, 0.2),
            Vec3::new(1.0, -2.0, 3.0),
        );
        for projection in [perspective(0.9, 0.25, Some(40.0)), perspective(0.9, 0.25, None), orthographic()] {
            let camera = Camera { name: String::new(), world_from_view: placement, projection };
            let view = View::new(&camera, size);
            let clip_from_world = projection.clip_from_view(aspect) * placement.inverse();
            for (place, distance) in [([0.5, 0.5], 1.0), ([160.0, 90.0], 3.0), ([317.5, 12.5], 11.0)] {
                let point = view.ray(DVec2::from(place)).at(distance);
                let ndc = clip_from_world.project_point3(point.as_vec3()).as_dvec3();
                let back = (DVec2::new(ndc.x, ndc.y) + 1.0) * 0.5 * DVec2::new(320.0, 180.0);
                assert!(
                    (back - DVec2::from(place)).length() < 320.0 * F32_TOLERANCE,
                    "{projection:?} {back}"
                );
                let again = view.place(view.ray(DVec2::from(place)).at(distance)).unwrap();
                assert!(again.abs_diff_eq(DVec2::from(place), 1e-9), "{projection:?}: {again}");
                let depth = view.depth_from_distance(distance);
                assert!((ndc.z - depth).abs() < F32_TOLERANCE, "{projection:?}: {} {depth}", ndc.z);
                let [p, q, r, s] = projection.distance_from_depth().map(f64::from);
                let by_contract = (p + q * depth) / (r + s * depth);
                assert!((by_contract / distance - 1.0).abs() < F32_TOLERANCE);
                assert!((view.distance_from_depth(depth) / distance - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn the_first_row_is_the_upper_one() {
        let view = View::new(&camera_at(Vec3::ZERO, Vec3::NEG_Z, perspective(1.0, 0.1, None)), [4, 4]);
        let upper_left = view.ray_through_pixel([0, 0]).direction;
        assert!(upper_left.y > 0.0 && upper_left.x < 0.0 && upper_left.z < 0.0);
    }
}
