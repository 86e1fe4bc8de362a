//! View points and projections.

use glam::{DMat3, DMat4, Mat4, Vec3};

/// A view point.
#[derive(Clone, Debug)]
pub struct Camera {
    /// A name for messages and `--camera`.
    pub name: String,
    /// Rigid (scale removed): the camera looks along its -Z, +Y is up.
    pub world_from_view: Mat4,
    /// How view space becomes clip space.
    pub projection: Projection,
}

/// glTF's two projections.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Pinhole.
    Perspective {
        /// Full vertical field of view, radians.
        yfov_rad: f32,
        /// Distance of the near plane, metres, above 0.
        znear_m: f32,
        /// Distance of the far plane, metres; `None` is infinite.
        zfar_m: Option<f32>,
    },
    /// Parallel.
    Orthographic {
        /// Half the width, metres. The rendered width follows the image's aspect ratio.
        xmag_m: f32,
        /// Half the height, metres.
        ymag_m: f32,
        /// Distance of the near plane, metres.
        znear_m: f32,
        /// Distance of the far plane, metres, above `znear_m`.
        zfar_m: f32,
    },
}

impl Camera {
    /// One at `eye` that looks at `target`, both in world space, with world +Y up; straight up or down, world -Z is up.
    ///
    /// ```
    /// use ontile::glam::Vec3;
    /// use ontile::scene::{Camera, Projection};
    ///
    /// let projection = Projection::Perspective { yfov_rad: 0.9, znear_m: 0.1, zfar_m: None };
    /// let camera = Camera::new(Vec3::new(0.0, 2.0, 5.0), Vec3::ZERO, projection);
    /// assert_eq!(camera.world_from_view.w_axis.truncate(), Vec3::new(0.0, 2.0, 5.0));
    /// ```
    pub fn new(eye: Vec3, target: Vec3, projection: Projection) -> Self {
        let backward = (eye - target).normalize_or(Vec3::Z);
        let up = if backward.y.abs() > 0.999_999 { Vec3::NEG_Z } else { Vec3::Y };
        let right = up.cross(backward).normalize();
        let axes = [right, backward.cross(right), backward].map(|axis| axis.extend(0.0));
        let world_from_view = Mat4::from_cols(axes[0], axes[1], axes[2], eye.extend(1.0));
        Self { name: "camera".into(), world_from_view, projection }
    }
}

impl Projection {
    /// Clip space from view space for Vulkan: y down, reversed depth (1 at the near plane, 0 at the far one).
    ///
    /// `aspect` is the image's width over height; as in glTF 2.0 section 3.10, the vertical extent is the
    /// camera's and the horizontal one follows the image.
    pub fn clip_from_view(&self, aspect: f32) -> Mat4 {
        match *self {
            Self::Perspective { yfov_rad, znear_m: n, zfar_m } => {
                let f = 1.0 / (yfov_rad * 0.5).tan();
                // Depth is (c2 * z + c3) / -z: 1 at z = -n; at z = -far it is 0.
                let (c2, c3) = match zfar_m {
                    Some(far) => (n / (far - n), n * far / (far - n)),
                    None => (0.0, n),
                };
                Mat4::from_cols_array(&[
                    f / aspect,
                    0.0,
                    0.0,
                    0.0, //
                    0.0,
                    -f,
                    0.0,
                    0.0, //
                    0.0,
                    0.0,
                    c2,
                    -1.0, //
                    0.0,
                    0.0,
                    c3,
                    0.0,
                ])
            }
            Self::Orthographic { ymag_m, znear_m: n, zfar_m: far, .. } => Mat4::from_cols_array(&[
                1.0 / (ymag_m * aspect),
                0.0,
                0.0,
                0.0, //
                0.0,
                -1.0 / ymag_m,
                0.0,
                0.0, //
                0.0,
                0.0,
                1.0 / (far - n),
                0.0, //
                0.0,
                0.0,
                far / (far - n),
                1.0,
            ]),
        }
    }

    /// `[p, q, r, s]` such that the distance along the view axis is `(p + q * depth) / (r + s * depth)`.
    ///
    /// The inverse of [`Self::clip_from_view`]'s third row, for positions from depth.
    pub fn distance_from_depth(&self) -> [f32; 4] {
        match *self {
            Self::Perspective { znear_m: n, zfar_m: Some(far), .. } => {
                [n * far / (far - n), 0.0, n / (far - n), 1.0]
            }
            Self::Perspective { znear_m: n, zfar_m: None, .. } => [n, 0.0, 0.0, 1.0],
            Self::Orthographic { znear_m: n, zfar_m: far, .. } => [far, n - far, 1.0, 0.0],
        }
    }
}

/// The transform without scale, shear and mirroring; -Z and the plane of Y stay.
pub(super) fn rigid(world_from_node: &DMat4) -> Option<Mat4> {
    let axes = DMat3::from_mat4(*world_from_node);
    let back = axes.z_axis.try_normalize()?;
    let right = axes.y_axis.try_normalize()?.cross(back).try_normalize()?;
    let rotation = DMat3::from_cols(right, back.cross(right), back);
    Some((DMat4::from_translation(world_from_node.w_axis.truncate()) * DMat4::from_mat3(rotation)).as_mat4())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_look_at_their_targets() {
        let projection = Projection::Perspective { yfov_rad: 1.0, znear_m: 0.1, zfar_m: None };
        let eye = Vec3::new(1.0, 2.0, 3.0);
        for to in [Vec3::ZERO, eye + Vec3::Y, eye - Vec3::Y * 9.0, Vec3::new(-4.0, 2.0, 3.0)] {
            let world = Camera::new(eye, to, projection).world_from_view;
            let seen = world.inverse().transform_point3(to);
            assert!(
                seen.truncate().length() < 1e-5 && (seen.z + to.distance(eye)).abs() < 1e-5,
                "{to}: {seen}"
            );
            assert!((world.determinant() - 1.0).abs() < 1e-5 && world.y_axis.y >= -1e-6, "{to}: {world}");
        }
        assert!(Camera::new(eye, eye, projection).world_from_view.is_finite());
    }

    #[test]
    fn depth_and_distance_invert_each_other() {
        let projections = [
            Projection::Perspective { yfov_rad: 1.0, znear_m: 0.1, zfar_m: Some(100.0) },
            Projection::Perspective { yfov_rad: 1.0, znear_m: 0.1, zfar_m: None },
            Projection::Orthographic { xmag_m: 2.0, ymag_m: 1.0, znear_m: 0.5, zfar_m: 20.0 },
        ];
        for p in projections {
            let [a, b, c, d] = p.distance_from_depth();
            for distance in [0.5_f32, 1.0, 7.0, 19.0] {
                let depth = p.clip_from_view(1.5).project_point3(Vec3::new(0.3, 0.2, -distance)).z;
                let back = (a + b * depth) / (c + d * depth);
                assert!((back - distance).abs() < 1e-4 * distance, "{p:?}: {distance} -> {depth} -> {back}");
            }
        }
    }

    #[test]
    fn near_is_one_and_far_is_zero() {
        let p = Projection::Perspective { yfov_rad: 1.0, znear_m: 0.1, zfar_m: Some(100.0) };
        let depth = |z: f32| p.clip_from_view(1.0).project_point3(Vec3::new(0.0, 0.0, z)).z;
        assert!((depth(-0.1) - 1.0).abs() < 1e-6);
        assert!(depth(-100.0).abs() < 1e-6);
    }
}
