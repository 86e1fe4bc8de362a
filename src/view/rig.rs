//! A camera in a hand: it orbits what it looks at, or flies.

use std::f32::consts::FRAC_PI_2;

use glam::{Mat3, Mat4, Quat, Vec3};

use crate::scene::{Camera, Flight, Projection, Scene};

/// How a drag turns the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Motion {
    /// About what it looks at.
    Orbit,
    /// About itself.
    Fly,
}

/// A camera that is moved by hand. Until it is, it is the scene's own to the bit.
#[derive(Clone, Debug)]
pub(super) struct Rig {
    pub(super) camera: Camera,
    pub(super) motion: Motion,
    /// The scene's camera that it is, until a hand moves it.
    index: Option<usize>,
    /// From the camera to what it orbits, metres.
    distance_m: f32,
    /// The scene's extent: how fast it flies, and how near it comes.
    extent_m: f32,
}

/// The view stays this far from straight up and down, radians.
const LEAST_TO_POLE_RAD: f32 = 0.02;
/// What is orbited is at least this share of the scene's extent away.
const LEAST_DISTANCE: f32 = 1e-3;

impl Rig {
    /// The camera of a scene with this number.
    pub(super) fn new(scene: &Scene, index: usize, motion: Motion) -> Self {
        let camera = &scene.cameras[index];
        let bounds = scene.bounds_world();
        let extent_m = bounds.map_or(1.0, |b| (b.max - b.min).length()).max(1e-6);
        let center = bounds.map_or(Vec3::ZERO, |b| (b.min + b.max) * 0.5);
        let eye = camera.world_from_view.w_axis.truncate();
        // What is looked at is about as far away as the scene's middle; of what surrounds the camera, a share.
        let to_center = (center - eye).dot(-camera.world_from_view.z_axis.truncate());
        let distance_m = to_center.max(0.1 * extent_m);
        Self { camera: camera.clone(), motion, index: Some(index), distance_m, extent_m }
    }

    /// Goes along with the scene's camera, unless a hand has moved it.
    pub(super) fn follow(&mut self, scene: &Scene) {
        if let Some(camera) = self.index.and_then(|index| scene.cameras.get(index)) {
            self.camera.world_from_view = camera.world_from_view;
        }
    }

    /// Goes to where a flight is after so many seconds.
    pub(super) fn fly_along(&mut self, flight: &Flight, seconds: f64) {
        self.index = None;
        flight.place(&mut self.camera, seconds);
    }

    fn eye(&self) -> Vec3 {
        self.camera.world_from_view.w_axis.truncate()
    }

    fn axes(&self) -> Mat3 {
        Mat3::from_mat4(self.camera.world_from_view)
    }

    /// A drag by so many radians to the right and down: a world that is orbited follows the hand, and so does the gaze of who flies.
    pub(super) fn turn(&mut self, right_rad: f32, down_rad: f32) {
        let axes = self.axes();
        let elevation = (-axes.z_axis.y).clamp(-1.0, 1.0).asin();
        let most = FRAC_PI_2 - LEAST_TO_POLE_RAD;
        // A camera of the scene's may begin beyond.
        let (lowest, highest) = (elevation.min(-most), elevation.max(most));
        let pitch = (elevation - down_rad).clamp(lowest, highest) - elevation;
        let turn = Quat::from_rotation_y(-right_rad) * Quat::from_axis_angle(axes.x_axis.normalize(), pitch);
        let pivot = match self.motion {
            Motion::Orbit => self.eye() - axes.z_axis * self.distance_m,
            Motion::Fly => self.eye(),
        };
        let eye = pivot + turn * (self.eye() - pivot);
        self.place(Mat3::from_quat(turn) * axes, eye);
    }

    /// Moves the camera so that what is at the pivot's distance follows a hand that goes so far to the right and down, as shares
    /// of the picture's height.
    pub(super) fn pan(&mut self, right: f32, down: f32) {
        let height_m = match self.camera.projection {
            Projection::Perspective { yfov_rad, .. } => 2.0 * (yfov_rad * 0.5).tan() * self.distance_m,
            Projection::Orthographic { ymag_m, .. } => 2.0 * ymag_m,
        };
        let axes = self.axes();
        let eye = self.eye() + (axes.y_axis * down - axes.x_axis * right) * height_m;
        self.place(axes, eye);
    }

    /// Goes nearer to what is orbited: distances, or the picture's extent, shrink by this factor.
    pub(super) fn zoom(&mut self, factor: f32) {
        if let Projection::Orthographic { xmag_m, ymag_m, .. } = &mut self.camera.projection {
            let least = LEAST_DISTANCE * self.extent_m;
            let factor = if *ymag_m * factor < least { 1.0 } else { factor };
            self.index = None;
            (*xmag_m, *ymag_m) = (*xmag_m * factor, *ymag_m * factor);
            return;
        }
        let nearer = (self.distance_m * factor).clamp(LEAST_DISTANCE * self.extent_m, 1e3 * self.extent_m);
        let axes = self.axes();
        let eye = self.eye() - axes.z_axis * (self.distance_m - nearer);
        // Who flies takes along what would be orbited.
        if self.motion == Motion::Orbit {
            self.distance_m = nearer;
        }
        self.place(axes, eye);
    }

    /// Flies: seconds times a direction in view space, in each direction -1 to 1.
    pub(super) fn fly(&mut self, seconds_view: Vec3) {
        const EXTENTS_PER_SECOND: f32 = 0.1;
        let axes = self.axes();
        let eye = self.eye() + axes * seconds_view * (EXTENTS_PER_SECOND * self.extent_m);
        self.place(axes, eye);
    }

    /// Rigid, whatever rounding has done.
    fn place(&mut self, axes: Mat3, eye: Vec3) {
        let back = axes.z_axis.normalize();
        let right = axes.y_axis.cross(back).normalize();
        let up = back.cross(right);
        let placed = Mat4::from_cols(right.extend(0.0), up.extend(0.0), back.extend(0.0), eye.extend(1.0));
        if placed.is_finite() {
            self.index = None;
            self.camera.world_from_view = placed;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3;

    fn rig(motion: Motion) -> Rig {
        let camera = Camera {
            name: String::new(),
            world_from_view: Mat4::from_translation(vec3(0.0, 0.0, 5.0)),
            projection: Projection::Perspective { yfov_rad: 1.0, znear_m: 0.1, zfar_m: None },
        };
        Rig { camera, motion, index: None, distance_m: 5.0, extent_m: 10.0 }
    }

    #[track_caller]
    fn close(a: Vec3, b: Vec3) {
        assert!((a - b).length() < 1e-4, "{a} is not {b}");
    }

    #[test]
    fn what_is_orbited_stays_in_the_middle_and_follows_the_hand() {
        let mut rig = rig(Motion::Orbit);
        rig.turn(FRAC_PI_2, 0.0);
        // Dragged to the right, the world turns to the right: the camera goes to the left.
        close(rig.eye(), vec3(-5.0, 0.0, 0.0));
        close(rig.axes().z_axis, vec3(-1.0, 0.0, 0.0));
        rig.turn(0.0, 0.5);
        // Dragged down, what is above comes into view.
        assert!(rig.eye().y > 0.0);
        close(rig.eye() - rig.axes().z_axis * 5.0, Vec3::ZERO);
        for _ in 0..1000 {
            rig.turn(0.1, 3.0);
        }
        assert!((rig.axes().z_axis.y.asin() - (FRAC_PI_2 - LEAST_TO_POLE_RAD)).abs() < 1e-2);
        assert!((rig.axes().determinant() - 1.0).abs() < 1e-5);
        close(rig.eye() - rig.axes().z_axis * 5.0, Vec3::ZERO);
    }

    #[test]
    fn who_flies_looks_where_the_hand_goes() {
        let mut rig = rig(Motion::Fly);
        rig.turn(FRAC_PI_2, 0.0);
        close(rig.eye(), vec3(0.0, 0.0, 5.0));
        close(-rig.axes().z_axis, Vec3::X);
        rig.fly(vec3(0.0, 0.0, -2.0));
        close(rig.eye(), vec3(2.0, 0.0, 5.0));
        rig.turn(0.0, 0.5);
        assert!(-rig.axes().z_axis.y < 0.0, "dragged down, it looks down");
    }

    #[test]
    fn zooming_and_panning_follow_the_hand() {
        let mut rig = rig(Motion::Orbit);
        rig.zoom(0.5);
        close(rig.eye(), vec3(0.0, 0.0, 2.5));
        let height_m = 2.0 * 0.5_f32.tan() * 2.5;
        rig.pan(1.0, 1.0);
        // The hand takes the world to the right and down, so the camera goes to the left and up.
        close(rig.eye(), vec3(-height_m, height_m, 2.5));
        for _ in 0..100 {
            rig.zoom(0.5);
        }
        assert!(rig.distance_m >= LEAST_DISTANCE * 10.0 && rig.camera.world_from_view.is_finite());
    }

    #[test]
    fn a_roll_stays() {
        let mut rig = rig(Motion::Fly);
        rig.camera.world_from_view *= Mat4::from_rotation_z(0.3);
        let up = rig.axes().y_axis.y;
        rig.turn(1.0, 0.0);
        assert!((rig.axes().y_axis.y - up).abs() < 1e-5);
    }
}
