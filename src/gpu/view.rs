//! What changes from frame to frame: the camera and the exposure, as shaders want them.

use glam::{DMat4, DVec3};

use super::shared::FrameUniforms;
use crate::plan::Plan;
use crate::scene::{Camera, Projection};

/// How a frame looks at the scene.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Where from, and through which projection.
    pub camera: &'a Camera,
    /// Light is multiplied by 2 to this power, which is held between -126 and 126; NaN counts as 0.
    pub exposure_ev: f32,
}

impl View<'_> {
    /// What light is multiplied by: not a number counts as 0 EV, and light that is multiplied stays a number.
    pub(super) fn exposure(&self) -> f32 {
        if self.exposure_ev.is_nan() { 1.0 } else { self.exposure_ev.clamp(-126.0, 126.0).exp2() }
    }

    /// The uniform block of a frame of this size in pixels, without lights. Computed in f64: the f32 result is the
    /// nearest to the exact one.
    pub(super) fn uniforms(&self, plan: &Plan, size: [u32; 2], ambient_nt: glam::Vec3) -> FrameUniforms {
        let [width, height] = size.map(f64::from);
        let aspect = width / height;
        let world_from_view: DMat4 = self.camera.world_from_view.as_dmat4();
        let clip_from_view = self.camera.projection.clip_from_view(aspect as f32).as_dmat4();
        let (half_width, half_height, perspective) = match self.camera.projection {
            Projection::Perspective { yfov_rad, .. } => {
                let half = (f64::from(yfov_rad) * 0.5).tan();
                (half * aspect, half, 1.0)
            }
            Projection::Orthographic { ymag_m, .. } => (f64::from(ymag_m) * aspect, f64::from(ymag_m), 0.0),
        };
        let axis = |v: DVec3, w: f32| v.as_vec3().extend(w).to_array();
        let [right, up, back, position] =
            world_from_view.to_cols_array_2d().map(|c| DVec3::new(c[0], c[1], c[2]));
        FrameUniforms {
            clip_from_world: (clip_from_view * world_from_view.inverse()).as_mat4().to_cols_array_2d(),
            camera_position_world: axis(position, perspective),
            right_world: axis(right * half_width, 0.0),
            down_world: axis(-up * half_height, 0.0),
            forward_world: axis(-back, 0.0),
            distance_from_depth: self.camera.projection.distance_from_depth(),
            inverse_size: [(1.0 / width) as f32, (1.0 / height) as f32],
            exposure: self.exposure(),
            light_scale: plan.light_scale(),
            ambient_nt: ambient_nt.extend(0.0).to_array(),
            light_counts: [0; 4],
            hemispheres: [[0.0; 4]; 3],
            bloom: [0.0; 4],
        }
    }
}
