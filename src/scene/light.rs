//! Lights: those of KHR_lights_punctual, and the box, hemisphere and back-lit ones of Koonce 2007 ("Deferred Shading
//! in Tabula Rasa", GPU Gems 3, section 19.4).

use glam::{DVec3, Vec3};

/// A light at a point, from a direction, or within a box.
///
/// A light has a frame of its own: it shines along -Z, +Y is up, and +X is right as [`Light::right_world`] gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// A name for messages.
    pub name: String,
    /// Linear Rec.709; multiplies the intensity.
    pub color: Vec3,
    /// What surfaces that face away get in place of `color`, as diffuse light; linear Rec.709. Directional and box
    /// lights: a second light from behind, zero without one. Hemispheres: the ground's colour. Unused by others.
    pub back_color: Vec3,
    /// Type and photometric quantity.
    pub kind: LightKind,
    /// World space, metres; of a box its centre. Unused by directional lights and hemispheres.
    pub position_world: Vec3,
    /// World space, unit length: the way the light travels (the node's -Z). Unused by point lights without a globe map.
    pub direction_world: Vec3,
    /// World space, unit length, perpendicular to `direction_world`: the light's +Y. Used by boxes and globe maps.
    pub up_world: Vec3,
    /// Distance at which the light ends, smoothly; `None` reaches everywhere. Used by point and spot lights.
    pub range_m: Option<f32>,
    /// What the light shines through; `None` is nothing. Used by point, spot and box lights.
    pub globe_map: Option<GlobeMap>,
    /// How it casts shadows; `None` shines through everything. Unused by hemispheres, which have none.
    pub shadow: Option<Shadow>,
    /// Whether it may move or change from frame to frame: nothing of it is made ahead (lightmaps) or kept (shadow maps).
    pub dynamic: bool,
    /// Its light is in the scene's [lightmap](super::Scene::lightmap): it shines no more on anything, lightmap or not.
    pub baked: bool,
    /// Lights of higher priority are kept where there are too many ([`Scene::keep_lights`](super::Scene::keep_lights)).
    pub priority: f32,
}

/// Type of a [`Light`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Infinitely far.
    Directional {
        /// On a surface that faces the light, in lux.
        illuminance_lx: f32,
    },
    /// Alike in all directions.
    Point {
        /// Candela.
        intensity_cd: f32,
    },
    /// Within a cone.
    Spot {
        /// Candela along the axis.
        intensity_cd: f32,
        /// From the axis, radians: full intensity within. 0 <= inner < outer.
        inner_cone_rad: f32,
        /// From the axis, radians: dark outside. At most pi / 2.
        outer_cone_rad: f32,
    },
    /// A directional light that ends at the faces of a box (Koonce 2007, 19.4.3).
    Box {
        /// On a surface that faces the light, in lux.
        illuminance_lx: f32,
        /// Whole extent along the light's X, Y and Z, metres.
        size_m: Vec3,
        /// The light fades over this distance inside each face, metres: along each axis by smoothstep, the three
        /// multiplied. More than half the extent counts as half; 0 is an edge.
        falloff_m: f32,
    },
    /// Diffuse light from all around: `color` from where the light comes from, `back_color` from the other half (Koonce
    /// 2007, 19.4.1). A surface whose normal is at a cosine c from the way to the light gets
    /// `mix(back_color, color, 0.5 + 0.5 c) * illuminance_lx`, which is what two half spheres of uniform radiance give.
    /// It has no highlights and casts no shadows, and occlusion textures do not dim it: as direct light it is added where
    /// occlusion is no longer known. Ambient light and environments are dimmed.
    Hemisphere {
        /// On a surface that faces the light, in lux.
        illuminance_lx: f32,
    },
}

/// How a light casts shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shadow {
    /// Radius over which a shadow's edge is smoothed, in texels of the shadow map; 0 is hard.
    pub spread_texels: f32,
    /// Receivers are moved this far along their normal before they are compared, in texels of the shadow map at their
    /// place: less shows stripes on surfaces that the light grazes, more detaches shadows from what casts them.
    pub bias_texels: f32,
    /// Whether it is counted as a volume on the tile or looked up in the map; `None` leaves that to the frame's options. A light whose
    /// shadow cannot be a volume, or a frame without a G-buffer, has the map all the same, and the plan says why.
    pub volume: Option<bool>,
}

impl Shadow {
    /// Wider filters are narrowed to this radius, texels; files may not ask for them.
    pub const MOST_SPREAD_TEXELS: f32 = 12.0;
    /// Receivers are moved by no more, texels; files may not ask for it.
    pub const MOST_BIAS_TEXELS: f32 = 64.0;
}

impl Default for Shadow {
    /// Smoothed over a texel and a half either way, and moved as far.
    fn default() -> Self {
        Self { spread_texels: 1.5, bias_texels: 1.5, volume: None }
    }
}

/// A picture that colours a light like a slide or a glass globe around it (Koonce 2007, 19.4.2): the light's colour is
/// multiplied by it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlobeMap {
    /// What is shone through.
    pub picture: GlobePicture,
    /// Turns the picture within the light's frame, right-handed: about +Z for spot and box lights (counter-clockwise as the
    /// light sees it), about +Y for point lights. Radians.
    pub rotation_rad: f32,
}

/// The picture of a [`GlobeMap`]: sRGB colours, alpha ignored, sampled linearly. Lights of other kinds than named here
/// shine as without.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum GlobePicture {
    /// For spot and box lights, upright as the light sees it: it spans the square around a spot's outer cone (up to
    /// [`GlobeMap::MOST_CONE_RAD`]; beyond, its edge goes on), or a box's face.
    Flat {
        /// Index into `Scene::images`.
        image: usize,
    },
    /// For point lights: what a camera at the light sees towards +X, -X, +Y, -Y, +Z and -Z of the light's frame, 90
    /// degrees each way. Its up is +Y, but +Z towards +Y and -Z towards -Y: -Z is the front of an unfolded cube.
    Cube {
        /// Indices into `Scene::images`.
        images: [usize; 6],
    },
}

impl GlobeMap {
    /// A flat picture spans this half angle at most: no plane has room for the 90 degrees that a spot may have.
    pub const MOST_CONE_RAD: f32 = 1.4;
}

impl Light {
    /// The same light under another name, which takes no memory.
    pub(crate) fn renamed(&self, name: String) -> Self {
        let Self { name: _, color, back_color, kind, position_world, direction_world, up_world, .. } = *self;
        let Self { range_m, globe_map, shadow, dynamic, baked, priority, .. } = *self;
        Self {
            name,
            color,
            back_color,
            kind,
            position_world,
            direction_world,
            up_world,
            range_m,
            globe_map,
            shadow,
            dynamic,
            baked,
            priority,
        }
    }

    /// A white light at the origin that shines along -Z, without range, back colour, globe map and shadow.
    pub fn new(kind: LightKind) -> Self {
        Self {
            name: String::new(),
            color: Vec3::ONE,
            back_color: Vec3::ZERO,
            kind,
            position_world: Vec3::ZERO,
            direction_world: Vec3::NEG_Z,
            up_world: Vec3::Y,
            range_m: None,
            globe_map: None,
            shadow: None,
            dynamic: false,
            baked: false,
            priority: 0.0,
        }
    }

    /// Turned so that it shines along `direction_world` (any length but 0), its up as near to world +Y as can be.
    pub fn towards(self, direction_world: Vec3) -> Self {
        let direction = direction_world.as_dvec3().normalize();
        let up = up_of(direction, DVec3::Y);
        Self { direction_world: direction.as_vec3(), up_world: up.as_vec3(), ..self }
    }

    /// World space: the light's +X.
    pub fn right_world(&self) -> Vec3 {
        self.direction_world.cross(self.up_world)
    }

    /// Lux on a surface that faces the light, or candela along its axis, before colour.
    pub fn intensity(&self) -> f32 {
        match self.kind {
            LightKind::Directional { illuminance_lx }
            | LightKind::Box { illuminance_lx, .. }
            | LightKind::Hemisphere { illuminance_lx } => illuminance_lx,
            LightKind::Point { intensity_cd } | LightKind::Spot { intensity_cd, .. } => intensity_cd,
        }
    }

    /// Its globe map, if it is of a kind that shines through one.
    pub fn shown_globe_map(&self) -> Option<GlobeMap> {
        self.globe_map.filter(|map| match self.kind {
            LightKind::Point { .. } => matches!(map.picture, GlobePicture::Cube { .. }),
            LightKind::Spot { .. } | LightKind::Box { .. } => {
                matches!(map.picture, GlobePicture::Flat { .. })
            }
            LightKind::Directional { .. } | LightKind::Hemisphere { .. } => false,
        })
    }

    /// Whether surfaces that face away from it get light too.
    pub fn has_back(&self) -> bool {
        match self.kind {
            LightKind::Directional { .. } | LightKind::Box { .. } => self.back_color != Vec3::ZERO,
            LightKind::Hemisphere { .. } => true,
            LightKind::Point { .. } | LightKind::Spot { .. } => false,
        }
    }

    /// Whether it adds nothing anywhere: its light is baked, or it has no colour, no intensity, no range, an extent of less
    /// than a micrometre, or numbers that mean nothing (see [`Self::is_sound`]). Such lights are left out of everything.
    pub fn is_dark(&self) -> bool {
        self.baked || !self.shines()
    }

    /// Whether it sends light, baked or not.
    pub(crate) fn shines(&self) -> bool {
        const LEAST_SIZE_M: f32 = 1e-6;
        let colors = if self.has_back() { self.color.max(self.back_color) } else { self.color };
        let reaches = match self.kind {
            LightKind::Directional { .. } | LightKind::Hemisphere { .. } => true,
            LightKind::Point { .. } | LightKind::Spot { .. } => self.range_m.is_none_or(|range| range > 0.0),
            LightKind::Box { size_m, .. } => size_m.min_element() >= LEAST_SIZE_M,
        };
        let shines = (colors * self.intensity()).max_element() > 0.0;
        shines && reaches && self.is_sound()
    }

    /// Whether all numbers are finite, and colours, intensity, range, extent and falloff not negative.
    pub fn is_sound(&self) -> bool {
        let extent = match self.kind {
            LightKind::Box { size_m, falloff_m, .. } => size_m.min_element().min(falloff_m),
            _ => 0.0,
        };
        let colors = self.color.min(self.back_color).min_element();
        let least = colors.min(self.intensity()).min(extent).min(self.range_m.unwrap_or(0.0));
        least >= 0.0 && self.is_finite()
    }

    fn is_finite(&self) -> bool {
        let numbers = match self.kind {
            LightKind::Spot { inner_cone_rad, outer_cone_rad, .. } => {
                [inner_cone_rad, outer_cone_rad, 0.0, 0.0]
            }
            LightKind::Box { size_m, falloff_m, .. } => size_m.extend(falloff_m).to_array(),
            _ => [0.0; 4],
        };
        let vectors =
            [self.color * self.intensity(), self.back_color * self.intensity(), self.position_world];
        vectors.iter().chain([&self.direction_world, &self.up_world]).all(|v| v.is_finite())
            && numbers.iter().all(|n| n.is_finite())
            && self.range_m.is_none_or(f32::is_finite)
            && self.globe_map.is_none_or(|map| map.rotation_rad.is_finite())
    }
}

/// A unit vector perpendicular to `direction` (unit length), as near to `wanted` as can be.
pub(super) fn up_of(direction: DVec3, wanted: DVec3) -> DVec3 {
    let across = wanted - direction * wanted.dot(direction);
    // What is left of a parallel vector is rounding.
    let clear = across.length_squared() > 1e-12 * wanted.length_squared();
    if clear { across.normalize() } else { direction.any_orthonormal_vector() }
}
