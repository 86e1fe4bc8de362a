//! Screens that are turned against their images.

use glam::{Mat2, Vec2};

use super::{Camera, Projection};

/// How a picture has to be turned when it is drawn, clockwise, so that it is upright on a screen that shows images as they lie in
/// memory: `VkSurfaceTransformFlagBitsKHR` without mirrors.
///
/// A phone that is held sideways would turn each image by a pass of its own, which reads and writes every pixel again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PreRotation {
    /// Upright in memory.
    #[default]
    Identity,
    /// By 90 degrees: what is above in the picture is at the image's right.
    Rotate90,
    /// Upside down.
    Rotate180,
    /// By 270 degrees: what is above in the picture is at the image's left.
    Rotate270,
}

impl PreRotation {
    /// All, in order.
    pub const ALL: [Self; 4] = [Self::Identity, Self::Rotate90, Self::Rotate180, Self::Rotate270];

    /// Width and height of the picture that images of this size show, and the other way around.
    pub fn size(self, [width, height]: [u32; 2]) -> [u32; 2] {
        match self {
            Self::Identity | Self::Rotate180 => [width, height],
            Self::Rotate90 | Self::Rotate270 => [height, width],
        }
    }

    /// Where a direction of the picture (right, down) goes in the image (right, down), exactly.
    pub fn image_from_picture(self) -> Mat2 {
        let (right, down) = match self {
            Self::Identity => (Vec2::X, Vec2::Y),
            Self::Rotate90 => (Vec2::Y, Vec2::NEG_X),
            Self::Rotate180 => (Vec2::NEG_X, Vec2::NEG_Y),
            Self::Rotate270 => (Vec2::NEG_Y, Vec2::X),
        };
        Mat2::from_cols(right, down)
    }

    /// The camera that draws to the images what this one draws to the picture, whose width is `aspect` times its height.
    ///
    /// A turn of the image is one of the camera about its axis the other way around, so all that follows from a camera follows
    /// here too. Its name is empty.
    pub fn camera(self, camera: &Camera, aspect: f32) -> Camera {
        let Camera { mut world_from_view, mut projection, .. } = *camera;
        // Of an image's right and down, what they are in the picture; up is negative.
        let picture_from_image = self.image_from_picture().transpose();
        let [right, up] = [world_from_view.x_axis, world_from_view.y_axis];
        let axis = |v: Vec2| right * v.x - up * v.y;
        world_from_view.x_axis = axis(picture_from_image.x_axis);
        world_from_view.y_axis = -axis(picture_from_image.y_axis);
        if self.size([0, 1]) == [1, 0] {
            match &mut projection {
                Projection::Perspective { yfov_rad, .. } => {
                    *yfov_rad = 2.0 * ((*yfov_rad * 0.5).tan() * aspect).atan();
                }
                Projection::Orthographic { xmag_m, ymag_m, .. } => {
                    (*xmag_m, *ymag_m) = (*ymag_m, *ymag_m * aspect);
                }
            }
        }
        Camera { name: String::new(), world_from_view, projection }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Mat4, Vec3, vec2};

    #[test]
    fn a_point_of_the_picture_lands_where_its_image_is_turned() {
        let perspective = Projection::Perspective { yfov_rad: 0.9, znear_m: 0.1, zfar_m: None };
        let parallel = Projection::Orthographic { xmag_m: 2.0, ymag_m: 1.5, znear_m: 0.1, zfar_m: 9.0 };
        let world_from_view = Mat4::from_rotation_y(0.7) * Mat4::from_translation(Vec3::new(1.0, 2.0, 3.0));
        let (size, point) = ([300, 200], Vec3::new(0.4, 0.3, -2.0));
        for projection in [perspective, parallel] {
            let camera = Camera { name: "a".into(), world_from_view, projection };
            let ndc = |camera: &Camera, [width, height]: [u32; 2]| {
                let clip = camera.projection.clip_from_view(width as f32 / height as f32);
                let world = world_from_view.transform_point3(point);
                clip.project_point3(camera.world_from_view.inverse().transform_point3(world))
            };
            let upright = ndc(&camera, size);
            assert!(upright.x > 0.0 && upright.y < 0.0, "right of the middle and above it");
            for rotation in PreRotation::ALL {
                let turned = ndc(&rotation.camera(&camera, 1.5), rotation.size(size));
                let wanted = rotation.image_from_picture() * upright.truncate();
                assert!((turned - wanted.extend(upright.z)).length() < 1e-5, "{rotation:?}: {turned}");
            }
        }
    }

    #[test]
    fn turns_are_clockwise() {
        let above = vec2(0.0, -1.0);
        let goes = PreRotation::ALL.map(|rotation| rotation.image_from_picture() * above);
        assert_eq!(goes, [above, vec2(1.0, 0.0), vec2(0.0, 1.0), vec2(-1.0, 0.0)]);
    }
}
