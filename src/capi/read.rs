//! From C's descriptions to the elements of a world.

use glam::{Mat4, Vec2, Vec3, Vec4};

use super::call::{Failure, Outcome, list, optional, text};
use super::elements::*;
use crate::scene::{
    AlphaMode, Camera, Checked, Decal, DecalChannels, Id, Image, Instance, Light, LightKind, Material, Mesh,
    Particle, Particles, Projection, Sampler, Shadow, Texture, TextureRef, Transmission, World, Wrap,
};

fn unknown(what: &str, value: u32) -> Failure {
    Failure::Argument(format!("{what} is {value}, which its type does not name"))
}

/// The index of what is named, for elements that refer to it.
fn index<T: crate::scene::Element>(world: &World, id: OntileId, what: &str) -> Outcome<usize> {
    let id = Id::<T>::from_bits(id);
    match world.get(id) {
        Some(_) => Ok(id.index()),
        None => Err(Failure::Argument(format!("{what} names no element of the world"))),
    }
}

/// A list of vectors as a list of numbers.
fn vectors<const N: usize, T>(numbers: &[f32], make: fn([f32; N]) -> T) -> Vec<T> {
    numbers.as_chunks::<N>().0.iter().copied().map(make).collect()
}

impl OntileMesh {
    /// # Safety
    /// Its lists have as many elements as it says.
    pub(super) unsafe fn read(&self, world: &World) -> Outcome<Mesh> {
        let count = |n: usize| {
            let numbers = self.vertex_count.checked_mul(n);
            numbers.ok_or_else(|| Failure::Argument("mesh.vertex_count is too large".into()))
        };
        // SAFETY: the caller's promise.
        unsafe {
            Ok(Mesh {
                name: text(self.name, "mesh.name")?.to_owned(),
                positions: vectors(list(self.positions, count(3)?, "mesh.positions")?, Vec3::from_array),
                normals: vectors(optional(self.normals, count(3)?), Vec3::from_array),
                tangents: vectors(optional(self.tangents, count(4)?), Vec4::from_array),
                texcoords: [
                    vectors(optional(self.texcoords_0, count(2)?), Vec2::from_array),
                    vectors(optional(self.texcoords_1, count(2)?), Vec2::from_array),
                ],
                colors: vectors(optional(self.colors, count(4)?), Vec4::from_array),
                indices: list(self.indices, self.index_count, "mesh.indices")?.to_vec(),
                material: index::<Material>(world, self.material, "mesh.material")?,
                deformation: None,
            })
        }
    }
}

impl OntileTextureRef {
    const NONE: Self = Self { texture: 0, texcoord: 0, uv_from_texcoord: [[0.0; 3]; 2] };

    fn read(&self, world: &World, what: &str) -> Outcome<Option<TextureRef>> {
        if self.texture == 0 {
            return Ok(None);
        }
        if self.texcoord > 1 {
            return Err(unknown(&format!("{what}.texcoord"), self.texcoord));
        }
        let uv_from_texcoord = match self.uv_from_texcoord {
            [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]] => TextureRef::IDENTITY,
            rows => rows.map(Vec3::from_array),
        };
        let texture = index::<Texture>(world, self.texture, what)?;
        Ok(Some(TextureRef { texture, texcoord: self.texcoord as usize, uv_from_texcoord }))
    }
}

impl OntileMaterial {
    pub(super) const DEFAULT: Self = Self {
        name: std::ptr::null(),
        base_color_factor: [1.0; 4],
        base_color_texture: OntileTextureRef::NONE,
        metallic_factor: 0.0,
        roughness_factor: 1.0,
        metallic_roughness_texture: OntileTextureRef::NONE,
        normal_texture: OntileTextureRef::NONE,
        normal_scale: 1.0,
        occlusion_texture: OntileTextureRef::NONE,
        occlusion_strength: 1.0,
        emissive_factor: [0.0; 3],
        emissive_texture: OntileTextureRef::NONE,
        alpha_mode: OntileAlphaMode::Opaque as u32,
        alpha_cutoff: 0.5,
        double_sided: false,
        unlit: false,
        transmission_factor: 0.0,
        ior: 1.5,
        thickness: 0.0,
        attenuation_color: [1.0; 3],
        attenuation_distance: 0.0,
    };

    /// # Safety
    /// Its name is null or ends with a zero.
    pub(super) unsafe fn read(&self, world: &World) -> Outcome<Material> {
        Ok(Material {
            // SAFETY: the caller's promise.
            name: unsafe { text(self.name, "material.name") }?.to_owned(),
            base_color_factor: Vec4::from_array(self.base_color_factor),
            base_color_texture: self.base_color_texture.read(world, "material.base_color_texture")?,
            metallic_factor: self.metallic_factor,
            roughness_factor: self.roughness_factor,
            metallic_roughness_texture: self
                .metallic_roughness_texture
                .read(world, "material.metallic_roughness_texture")?,
            normal_texture: self.normal_texture.read(world, "material.normal_texture")?,
            normal_scale: self.normal_scale,
            occlusion_texture: self.occlusion_texture.read(world, "material.occlusion_texture")?,
            occlusion_strength: self.occlusion_strength,
            emissive_factor: Vec3::from_array(self.emissive_factor),
            emissive_texture: self.emissive_texture.read(world, "material.emissive_texture")?,
            alpha_mode: match self.alpha_mode {
                0 => AlphaMode::Opaque,
                1 => AlphaMode::Mask { cutoff: self.alpha_cutoff },
                2 => AlphaMode::Blend,
                other => return Err(unknown("material.alpha_mode", other)),
            },
            double_sided: self.double_sided,
            unlit: self.unlit,
            transmission: (self.transmission_factor != 0.0).then(|| Transmission {
                factor: self.transmission_factor,
                ior: self.ior,
                thickness_m: self.thickness,
                attenuation_color: Vec3::from_array(self.attenuation_color),
                attenuation_distance_m: match self.attenuation_distance {
                    0.0 => f32::INFINITY,
                    distance => distance,
                },
            }),
        })
    }
}

impl OntileImage {
    /// # Safety
    /// It has as many bytes as it says.
    pub(super) unsafe fn read(&self) -> Outcome<Image> {
        let bytes = (self.width as usize).checked_mul(self.height as usize).and_then(|n| n.checked_mul(4));
        let bytes = bytes.ok_or_else(|| Failure::Argument("the image is too large".into()))?;
        Ok(Image {
            // SAFETY: the caller's promise.
            name: unsafe { text(self.name, "image.name") }?.to_owned(),
            width: self.width,
            height: self.height,
            // SAFETY: the caller's promise.
            rgba8: unsafe { list(self.rgba8, bytes, "image.rgba8") }?.to_vec(),
        })
    }
}

impl OntileTexture {
    pub(super) fn read(&self, world: &World) -> Outcome<Texture> {
        let wrap = |what: &str, value| match value {
            0 => Ok(Wrap::Repeat),
            1 => Ok(Wrap::MirroredRepeat),
            2 => Ok(Wrap::ClampToEdge),
            other => Err(unknown(what, other)),
        };
        let sampler = Sampler {
            mag_linear: self.mag_linear,
            min_linear: self.min_linear,
            mip_linear: match self.mips {
                0 => None,
                1 => Some(false),
                2 => Some(true),
                other => return Err(unknown("texture.mips", other)),
            },
            wrap_u: wrap("texture.wrap_u", self.wrap_u)?,
            wrap_v: wrap("texture.wrap_v", self.wrap_v)?,
        };
        Ok(Texture { image: index::<Image>(world, self.image, "texture.image")?, sampler })
    }
}

impl OntileInstance {
    pub(super) fn read(&self, world: &World) -> Outcome<Instance> {
        let mesh = index::<Mesh>(world, self.mesh, "instance.mesh")?;
        let world_from_object = Mat4::from_cols_array(&self.world_from_object);
        let Self { dynamic, hidden, .. } = *self;
        Ok(Instance { dynamic, hidden, ..Instance::new(mesh, world_from_object) })
    }
}

impl OntileLight {
    pub(super) const DEFAULT: Self = Self {
        name: std::ptr::null(),
        kind: OntileLightKind::Directional as u32,
        color: [1.0; 3],
        back_color: [0.0; 3],
        intensity: 0.0,
        position: [0.0; 3],
        direction: [0.0, 0.0, -1.0],
        range: 0.0,
        inner_cone: 0.0,
        outer_cone: std::f32::consts::FRAC_PI_4,
        box_size: [1.0; 3],
        box_falloff: 0.0,
        shadow: OntileShadow::None as u32,
        dynamic: false,
        priority: 0.0,
    };

    /// # Safety
    /// Its name is null or ends with a zero.
    pub(super) unsafe fn read(&self) -> Outcome<Light> {
        let Self { intensity, inner_cone, outer_cone, .. } = *self;
        let kind = match self.kind {
            0 => LightKind::Directional { illuminance_lx: intensity },
            1 => LightKind::Point { intensity_cd: intensity },
            2 => LightKind::Spot {
                intensity_cd: intensity,
                inner_cone_rad: inner_cone,
                outer_cone_rad: outer_cone,
            },
            3 => LightKind::Box {
                illuminance_lx: intensity,
                size_m: Vec3::from_array(self.box_size),
                falloff_m: self.box_falloff,
            },
            4 => LightKind::Hemisphere { illuminance_lx: intensity },
            other => return Err(unknown("light.kind", other)),
        };
        let direction = Vec3::from_array(self.direction);
        if !(direction.is_finite() && direction != Vec3::ZERO) {
            return Err(Failure::Argument("light.direction has no direction".into()));
        }
        Ok(Light {
            // SAFETY: the caller's promise.
            name: unsafe { text(self.name, "light.name") }?.to_owned(),
            color: Vec3::from_array(self.color),
            back_color: Vec3::from_array(self.back_color),
            position_world: Vec3::from_array(self.position),
            range_m: (self.range != 0.0).then_some(self.range),
            shadow: match self.shadow {
                0 => None,
                1 => Some(Shadow::default()),
                2 => Some(Shadow { volume: Some(false), ..Shadow::default() }),
                3 => Some(Shadow { volume: Some(true), ..Shadow::default() }),
                other => return Err(unknown("light.shadow", other)),
            },
            dynamic: self.dynamic,
            priority: self.priority,
            ..Light::new(kind).towards(direction)
        })
    }
}

impl OntileDecal {
    pub(super) fn read(&self, world: &World) -> Outcome<Decal> {
        let [base_color, normal, roughness, metallic] = self.channels;
        let material = index::<Material>(world, self.material, "decal.material")?;
        Ok(Decal {
            channels: DecalChannels { base_color, normal, roughness, metallic },
            falloff_m: Vec3::from_array(self.falloff),
            priority: self.priority,
            ..Decal::new(material, Mat4::from_cols_array(&self.world_from_decal))
        })
    }
}

impl OntileParticles {
    /// # Safety
    /// It has as many particles as it says.
    pub(super) unsafe fn read(&self, world: &World) -> Outcome<Particles> {
        let of = |p: &OntileParticle| Particle {
            position_world: Vec3::from_array(p.position),
            size_m: p.size,
            rotation_rad: p.rotation,
            color: Vec3::from_array(p.color),
        };
        Ok(Particles {
            // SAFETY: the caller's promise.
            name: unsafe { text(self.name, "particles.name") }?.to_owned(),
            material: index::<Material>(world, self.material, "particles.material")?,
            soft_m: self.soft,
            // SAFETY: the caller's promise.
            list: unsafe { list(self.particles, self.count, "particles.particles") }?
                .iter()
                .map(of)
                .collect(),
            most: self.most.max(self.count),
        })
    }
}

impl OntileCamera {
    pub(super) fn of(camera: &Camera) -> Self {
        let world_from_view = camera.world_from_view.to_cols_array();
        match camera.projection {
            Projection::Perspective { yfov_rad, znear_m, zfar_m } => Self {
                world_from_view,
                projection: OntileProjection::Perspective as u32,
                vertical: yfov_rad,
                z_near: znear_m,
                z_far: zfar_m.unwrap_or(0.0),
            },
            Projection::Orthographic { ymag_m, znear_m, zfar_m, .. } => Self {
                world_from_view,
                projection: OntileProjection::Orthographic as u32,
                vertical: ymag_m,
                z_near: znear_m,
                z_far: zfar_m,
            },
        }
    }

    pub(super) fn read(&self) -> Outcome<Camera> {
        let Self { vertical, z_near, z_far, .. } = *self;
        let projection = match self.projection {
            0 => Projection::Perspective {
                yfov_rad: vertical,
                znear_m: z_near,
                zfar_m: (z_far != 0.0).then_some(z_far),
            },
            1 => Projection::Orthographic {
                xmag_m: vertical,
                ymag_m: vertical,
                znear_m: z_near,
                zfar_m: z_far,
            },
            other => return Err(unknown("camera.projection", other)),
        };
        let world_from_view = Mat4::from_cols_array(&self.world_from_view);
        let camera = Camera { name: String::new(), world_from_view, projection };
        match camera.problem() {
            Some(problem) => Err(Failure::Argument(format!("camera: {problem}"))),
            None => Ok(camera),
        }
    }
}
