//! What is painted over surfaces: boxes that project a material onto what lies in them.

use glam::{DMat4, DVec3, Mat4, Vec3};

use super::{Material, TextureRef};

/// A box that paints a material over the lit surfaces in it, before they are lit.
///
/// The box's +Z is towards who looks at the decal, which projects along its -Z: the picture's right is +X, and up is +Y. Of each
/// channel (base colour, normal, roughness, metallicness) what the material says is mixed with what is there, and what
/// [`Self::channels`] leaves out stays as it is. How much arrives is a product: of the channel's opacity, the alpha of the base
/// colour (factor and texture, whatever the material's [`AlphaMode`](super::AlphaMode)), the falloff within the box's faces, and
/// the angle between surface and projection. A surface that faces away gets nothing, so that decals do not reach around corners,
/// and neither do unlit surfaces and the background, which are not in the G-buffer.
///
/// Normals are added to those that are there: the normal map's directions are turned into the frame of the surface's own normal
/// (Barré-Brisebois and Hill, "Blending in Detail", 2012: reoriented normal mapping), mixed with that normal by opacity, and made
/// unit length. Occlusion and emission of the material are not used, nor its alpha mode and its sides.
///
/// Light that a surface has before lights are added (emission, ambient light, environments, lightmaps) is made with the surface below
/// and stays that.
///
/// Where decals overlap, each is painted over what those before have left: in order of priority, then of the scene's list.
#[derive(Clone, Debug, PartialEq)]
pub struct Decal {
    /// A name for messages.
    pub name: String,
    /// Turns the cube from -0.5 to 0.5 along each axis into the box: affine, of a volume that is not 0.
    pub world_from_decal: Mat4,
    /// Index into [`super::Scene::materials`].
    pub material: usize,
    /// What is painted, and how much of it.
    pub channels: DecalChannels,
    /// Between the surface's normal and the box's +Z, radians: at the first angle and below all is painted, at the second and
    /// above nothing. From 0 to pi / 2; the second is not less than the first.
    pub angle_rad: [f32; 2],
    /// How far inside the faces across X, Y and Z the whole is painted, metres, at least 0; at the faces nothing is.
    pub falloff_m: Vec3,
    /// Those of lower priority are painted first.
    pub priority: f32,
}

/// How much of each channel is painted: from 0, nothing, to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecalChannels {
    /// Base colour.
    pub base_color: f32,
    /// Normal; without a normal texture there is none to paint.
    pub normal: f32,
    /// Perceptual roughness.
    pub roughness: f32,
    /// Metallicness.
    pub metallic: f32,
}

impl DecalChannels {
    /// Nothing.
    pub const NONE: Self = Self { base_color: 0.0, normal: 0.0, roughness: 0.0, metallic: 0.0 };
    /// The whole material.
    pub const ALL: Self = Self { base_color: 1.0, normal: 1.0, roughness: 1.0, metallic: 1.0 };
    /// Colour alone.
    pub const COLOR: Self = Self { base_color: 1.0, ..Self::NONE };

    /// In the order of the fields.
    pub fn to_array(self) -> [f32; 4] {
        [self.base_color, self.normal, self.roughness, self.metallic]
    }
}

/// A falloff is at least this share of the box's size: an edge, but no division by 0.
const LEAST_FALLOFF: f64 = 1e-5;

impl Decal {
    /// The angles of a decal that does not say: steep enough to be seen whole, and none on what stands across.
    pub const ANGLE_RAD: [f32; 2] = [std::f32::consts::FRAC_PI_3, 4.0 * std::f32::consts::FRAC_PI_3 / 3.0];

    /// The whole material, in a box.
    pub fn new(material: usize, world_from_decal: Mat4) -> Self {
        Self {
            name: String::new(),
            world_from_decal,
            material,
            channels: DecalChannels::ALL,
            angle_rad: Self::ANGLE_RAD,
            falloff_m: Vec3::ZERO,
            priority: 0.0,
        }
    }

    /// Whether something is painted with this material, which is the decal's.
    pub fn paints(&self, material: &Material) -> bool {
        let has_normal = material.normal_texture.is_some();
        let DecalChannels { base_color, normal, roughness, metallic } = self.channels;
        let most = base_color.max(roughness).max(metallic).max(if has_normal { normal } else { 0.0 });
        most > 0.0 && (material.base_color_factor.w > 0.0)
    }

    /// The textures that are looked at, by the slots of materials: base colour, metallic-roughness, normal.
    pub fn textures(&self, material: &Material) -> [Option<TextureRef>; 3] {
        let DecalChannels { normal, roughness, metallic, .. } = self.channels;
        [
            // Its alpha says where.
            material.base_color_texture,
            material.metallic_roughness_texture.filter(|_| roughness > 0.0 || metallic > 0.0),
            material.normal_texture.filter(|_| normal > 0.0),
        ]
    }

    /// The inverse of [`Self::world_from_decal`].
    pub fn decal_from_world(&self) -> DMat4 {
        self.world_from_decal.as_dmat4().inverse()
    }

    /// Unit vectors along the box's axes; across each other where the box is not sheared.
    pub fn axes_world(&self) -> [DVec3; 3] {
        let m = self.world_from_decal.as_dmat4();
        [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.truncate().normalize_or_zero())
    }

    /// 1, or -1 where the box is mirrored.
    pub fn handedness(&self) -> f64 {
        self.world_from_decal.as_dmat4().determinant().signum()
    }

    /// The falloff along each axis as a share of the box's size, at most a half.
    pub fn falloff_share(&self) -> DVec3 {
        let m = self.world_from_decal.as_dmat4();
        let size = [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.truncate().length());
        (self.falloff_m.as_dvec3() / DVec3::from_array(size))
            .clamp(DVec3::splat(LEAST_FALLOFF), DVec3::splat(0.5))
    }

    /// What is left of the decal at a place of the box (-0.5 to 0.5): 0 outside, smoothstep over the falloff inside each face, the
    /// three multiplied.
    pub fn weight_at(&self, place: DVec3) -> f64 {
        let t = ((0.5 - place.abs()) / self.falloff_share()).clamp(DVec3::ZERO, DVec3::ONE);
        (t * t * (3.0 - 2.0 * t)).element_product()
    }

    /// Slope and offset of the share by the cosine between normal and projection, before it is held to 0 to 1 and smoothed.
    pub fn angle_line(&self) -> [f64; 2] {
        let [begin, end] = self.angle_rad.map(|angle| f64::from(angle).cos());
        let slope = 1.0 / (begin - end).max(1e-4);
        [slope, -end * slope]
    }

    /// What is left of the decal where the surface's normal has this cosine to the box's +Z: smoothstep between the angles.
    pub fn weight_facing(&self, cosine: f64) -> f64 {
        let [slope, offset] = self.angle_line();
        let t = (cosine * slope + offset).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    }

    /// What is wrong with its numbers.
    pub(crate) fn numbers_problem(&self) -> Option<&'static str> {
        let m = &self.world_from_decal;
        let is_share = |v: f32| (0.0..=1.0).contains(&v);
        let [begin, end] = self.angle_rad;
        if !(m.is_finite() && m.row(3) == glam::Vec4::W) {
            Some("the transform is not affine and finite")
        } else if !has_volume(&m.as_dmat4()) {
            Some("the box has no volume")
        } else if !self.channels.to_array().into_iter().all(is_share) {
            Some("an opacity is not from 0 to 1")
        } else if !(0.0 <= begin && begin <= end && end <= std::f32::consts::FRAC_PI_2) {
            Some("0 <= first angle <= second angle <= pi / 2 does not hold")
        } else if !(self.falloff_m.is_finite() && self.falloff_m.min_element() >= 0.0) {
            Some("the falloff is not finite or negative")
        } else if !self.priority.is_finite() {
            Some("the priority is not finite")
        } else {
            None
        }
    }
}

/// Whether the cube's image has a volume that survives rounding to `f32`, there and back.
pub(super) fn has_volume(world_from_decal: &DMat4) -> bool {
    /// Of the product of the axes' lengths: what a shear leaves of a box.
    const LEAST_SHARE: f64 = 1e-4;
    let m = world_from_decal;
    let lengths = [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.truncate().length());
    let share = m.determinant().abs() / lengths.iter().product::<f64>();
    share > LEAST_SHARE && m.as_mat4().is_finite() && m.inverse().as_mat4().is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decal() -> Decal {
        let place =
            Mat4::from_translation(Vec3::new(1.0, 2.0, 3.0)) * Mat4::from_scale(Vec3::new(2.0, 4.0, 0.5));
        Decal { falloff_m: Vec3::new(0.5, 0.0, 0.25), ..Decal::new(0, place) }
    }

    #[test]
    fn the_weight_is_1_inside_the_falloff_and_0_at_the_faces() {
        let decal = decal();
        assert_eq!(decal.weight_at(DVec3::ZERO), 1.0);
        assert_eq!(decal.weight_at(DVec3::new(0.25, 0.4, 0.0)), 1.0);
        assert_eq!(decal.weight_at(DVec3::new(0.5, 0.0, 0.0)), 0.0);
        assert_eq!(decal.weight_at(DVec3::new(0.375, 0.0, 0.0)), 0.5, "smoothstep's middle");
        assert_eq!(decal.weight_at(DVec3::new(0.0, 0.6, 0.0)), 0.0);
        // A falloff of half the box and more is half.
        assert_eq!(decal.weight_at(DVec3::new(0.0, 0.0, 0.25)), 0.5);
        let at = decal.decal_from_world().transform_point3(DVec3::new(2.0, 4.0, 3.25));
        assert!(at.abs_diff_eq(DVec3::splat(0.5), 1e-12), "{at}");
    }

    #[test]
    fn the_angle_fades() {
        let decal = Decal { angle_rad: [0.5, 1.0], ..decal() };
        for (angle, weight) in [(0.0, 1.0), (0.49, 1.0), (1.01, 0.0), (2.0, 0.0)] {
            assert_eq!(decal.weight_facing(f64::cos(angle)), weight, "{angle}");
        }
        let middle = (f64::cos(0.5) + f64::cos(1.0)) * 0.5;
        assert!((decal.weight_facing(middle) - 0.5).abs() < 1e-6);
        // Two equal angles are an edge.
        let edge = Decal { angle_rad: [0.5, 0.5], ..decal };
        assert_eq!((edge.weight_facing(f64::cos(0.48)), edge.weight_facing(f64::cos(0.51))), (1.0, 0.0));
    }

    #[test]
    fn numbers_that_make_no_decal_are_told() {
        let spoil: [fn(&mut Decal); 8] = [
            |d| d.world_from_decal.w_axis.x = f32::NAN,
            |d| d.world_from_decal.x_axis.w = 1.0,
            |d| d.world_from_decal.z_axis = glam::Vec4::ZERO,
            |d| d.world_from_decal.z_axis = d.world_from_decal.x_axis,
            |d| d.channels.normal = 1.5,
            |d| d.angle_rad = [1.0, 0.5],
            |d| d.falloff_m.y = -0.1,
            |d| d.priority = f32::INFINITY,
        ];
        assert_eq!(decal().numbers_problem(), None);
        for (i, spoil) in spoil.iter().enumerate() {
            let mut bad = decal();
            spoil(&mut bad);
            assert!(bad.numbers_problem().is_some(), "{i}");
        }
    }
}
