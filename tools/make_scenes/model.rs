//! What a glTF file describes besides triangles: materials, lights and where things stand.

use glam::{Quat, Vec2, Vec3};

/// How one material slot samples a texture; made by [`Glb::texture`](super::glb::Glb::texture).
#[derive(Clone, Copy)]
pub struct Slot {
    /// Index into the file's textures.
    pub texture: usize,
    /// KHR_texture_transform's scale.
    pub scale: Vec2,
}

impl Slot {
    /// Repeats the picture `per_unit` times over one unit of texture coordinate.
    pub fn scaled(self, per_unit: f32) -> Self {
        Self { scale: Vec2::splat(per_unit), ..self }
    }
}

/// A glTF material. Colours are linear Rec.709.
#[derive(Clone)]
pub struct Material {
    pub name: &'static str,
    pub base_color: Vec3,
    pub base_color_texture: Option<Slot>,
    pub metallic: f32,
    pub roughness: f32,
    pub metallic_roughness_texture: Option<Slot>,
    pub normal_texture: Option<Slot>,
    pub normal_scale: f32,
    pub occlusion_texture: Option<Slot>,
    pub emissive: Vec3,
    pub emissive_texture: Option<Slot>,
    /// KHR_materials_emissive_strength; 1 leaves the extension out.
    pub emissive_strength: f32,
    /// Discards what has less alpha.
    pub alpha_cutoff: Option<f32>,
    /// Blended over what is behind, as much of it as this says.
    pub blend_alpha: Option<f32>,
    pub double_sided: bool,
    /// KHR_materials_transmission, with KHR_materials_volume and KHR_materials_ior.
    pub medium: Option<Medium>,
    /// KHR_materials_unlit.
    pub unlit: bool,
}

/// What light goes through.
#[derive(Clone, Copy)]
pub struct Medium {
    pub transmission: f32,
    pub ior: f32,
    pub thickness_m: f32,
    /// What is left of white light after `distance_m`.
    pub color: Vec3,
    pub distance_m: f32,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: "",
            base_color: Vec3::ONE,
            base_color_texture: None,
            metallic: 0.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            occlusion_texture: None,
            emissive: Vec3::ZERO,
            emissive_texture: None,
            emissive_strength: 1.0,
            alpha_cutoff: None,
            blend_alpha: None,
            double_sided: false,
            medium: None,
            unlit: false,
        }
    }
}

/// A punctual light; it shines along its node's -Z.
#[derive(Clone, Copy)]
pub struct Light {
    pub name: &'static str,
    /// Linear Rec.709.
    pub color: Vec3,
    pub kind: LightKind,
}

/// Type of a [`Light`] and its photometric quantity.
#[derive(Clone, Copy)]
pub enum LightKind {
    Directional { illuminance_lx: f32 },
    Point { intensity_cd: f32, range_m: f32 },
    Spot { intensity_cd: f32, range_m: f32, inner_rad: f32, outer_rad: f32 },
}

/// Where something stands. Rotation and scale come before the translation, as in glTF.
#[derive(Clone, Copy)]
pub struct Pose {
    pub position_m: Vec3,
    pub rotation: Quat,
    pub scale: Vec3,
}

impl Pose {
    /// Unrotated.
    pub fn at(x_m: f32, y_m: f32, z_m: f32) -> Self {
        Self { position_m: Vec3::new(x_m, y_m, z_m), rotation: Quat::IDENTITY, scale: Vec3::ONE }
    }

    /// At the origin.
    pub fn origin() -> Self {
        Self::at(0.0, 0.0, 0.0)
    }

    /// Turned about +Y, counter-clockwise seen from above.
    pub fn turned(self, turns: f32) -> Self {
        self.rotated(Vec3::Y, turns)
    }

    /// Turned about an axis, before the rotations given so far.
    pub fn rotated(self, axis: Vec3, turns: f32) -> Self {
        let half = super::shape::circle(turns * 0.5);
        let rotation =
            self.rotation * Quat::from_xyzw(axis.x * half.y, axis.y * half.y, axis.z * half.y, half.x);
        Self { rotation, ..self }
    }

    /// Scaled along the object's own axes.
    pub fn scaled(self, x: f32, y: f32, z: f32) -> Self {
        Self { scale: Vec3::new(x, y, z), ..self }
    }

    /// At a place, with -Z towards `target` and +Y as far up as possible: for cameras and lights.
    pub fn looking(from_m: Vec3, target_m: Vec3) -> Self {
        let back = (from_m - target_m).normalize();
        let up = if back.y.abs() > 0.999 { Vec3::Z } else { Vec3::Y };
        let right = up.cross(back).normalize();
        let rotation = Quat::from_mat3(&glam::Mat3::from_cols(right, back.cross(right), back)).normalize();
        Self { position_m: from_m, rotation, scale: Vec3::ONE }
    }
}
