//! The lights that a frame is drawn with, for whoever shows where they are.

use ash::vk;
use glam::{Mat2, Mat4, Vec3};

use super::Renderer;
use crate::gpu::{Target, View};
use crate::visible::{Clusters, Reach};

/// What a view sees of the lights. Matrices and clusters are those of the images, which may be turned against the picture.
pub(crate) struct SeenLights<'a> {
    pub(crate) clip_from_world: Mat4,
    /// Of directions: right and down.
    pub(crate) picture_from_image: Mat2,
    /// Of the images, pixels.
    pub(crate) size: [u32; 2],
    /// Those that the frame lists, in the order in which shaders go through them.
    pub(crate) lights: Vec<SeenLight>,
    /// Where the plan's way of lights has them; they hold numbers of `lights`.
    pub(crate) clusters: Option<&'a Clusters>,
    /// The views of directional lights' cascades.
    pub(crate) clips_of_cascades: Vec<Mat4>,
}

/// A light that a frame lists.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SeenLight {
    pub(crate) reach: Reach,
    /// World space, metres; `None` of directional lights.
    pub(crate) place_world: Option<Vec3>,
    /// Colour times candela or lux.
    pub(crate) intensity: Vec3,
    pub(crate) has_shadow: bool,
}

impl Renderer {
    /// The lights of the frame that [`Renderer::record`] records of this view next. No frame is being recorded.
    pub(crate) fn see_lights(&mut self, target: &Target, view: &View<'_>) -> SeenLights<'_> {
        let vk::Extent2D { width, height } = target.extent();
        let turned = target.pre_rotated_camera(view.camera);
        let view = View { camera: turned.as_ref().unwrap_or(view.camera), ..*view };
        let size = [width, height];
        let mut clips_of_cascades = Vec::new();
        if let Some(shadows) = &self.shadows {
            let aspect = f64::from(width) / f64::from(height);
            shadows.cascades(view.camera, aspect, |view| clips_of_cascades.push(view.clip_from_world));
        }
        let uniforms = view.uniforms(&self.plan, size, Vec3::ZERO);
        let clip_from_world = Mat4::from_cols_array_2d(&uniforms.clip_from_world);
        let (lights, clusters) = self.scene.see_lights(&view, size, &clip_from_world, self.config.cull);
        let picture_from_image = target.pre_rotation().image_from_picture().transpose();
        SeenLights { clip_from_world, picture_from_image, size, lights, clusters, clips_of_cascades }
    }
}
