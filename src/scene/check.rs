//! Numbers that mean nothing are refused before anything is made of a scene.

use glam::Vec4;

use super::world::{Kind, Listed, lengths};
use super::{
    AlphaMode, Background, Camera, Decal, Fog, Image, Instance, Light, Material, Mesh, Particles, Projection,
    Scene, Texture,
};
use crate::{Error, Result};

/// What an element has wrong.
type Problem = Option<String>;

/// What has numbers that may mean nothing.
pub trait Checked {
    /// What is wrong with it, whatever it refers to.
    fn problem(&self) -> Problem;
}

impl Scene {
    /// Checks that all numbers are finite and within what their descriptions say, and that elements refer to what is there, as in a
    /// scene that was loaded. One NaN in a picture spreads with every filter that touches it.
    ///
    /// A scene that was built by hand wants it before [`Needs::of`](crate::plan::Needs::of), which follows references.
    ///
    /// Lights' numbers are not looked at: those that mean nothing [are dark](super::Light::is_dark).
    ///
    /// # Errors
    /// [`Error::Unsupported`] that names the element.
    pub fn check(&self) -> Result<()> {
        let has = lengths(self);
        let problem = first(has, &self.meshes, Checked::problem)
            .or_else(|| first(has, &self.instances, Checked::problem))
            .or_else(|| first(has, &self.materials, Checked::problem))
            .or_else(|| first(has, &self.textures, Checked::problem))
            .or_else(|| first(has, &self.lights, |_| None))
            .or_else(|| first(has, &self.decals, Checked::problem))
            .or_else(|| first(has, &self.particles, Checked::problem))
            .or_else(|| first(has, &self.cameras, Checked::problem))
            .or_else(|| {
                let problem = self.motion.as_ref()?.problem(self)?;
                Some(("motion".to_owned(), problem))
            });
        match problem {
            Some((element, problem)) => Err(self.refused(&element, &problem)),
            None => self.check_surroundings(),
        }
    }

    /// The part of [`Self::check`] that is about no list but the probes.
    pub(super) fn check_surroundings(&self) -> Result<()> {
        match surroundings(self) {
            Some(problem) => Err(self.refused("scene", problem)),
            None => self.probes.iter().try_for_each(|probe| probe.check()),
        }
    }

    fn refused(&self, element: &str, problem: &str) -> Error {
        Error::unsupported(
            format!("scene '{}': {element}: {problem}", self.name),
            "give finite numbers within the range that the element's description names, and indices below the lengths of lists",
        )
    }
}

/// The first of a list that has a problem, by its name in messages. `has` is how long the lists are, by kind.
fn first<T: Listed>(
    has: [usize; Kind::COUNT],
    elements: &[T],
    problem: impl Fn(&T) -> Problem,
) -> Option<(String, String)> {
    let missing = |element: &T| {
        let mut missing = element.uses().filter(|&(kind, index)| index >= has[kind as usize]);
        let name = |(kind, index): (Kind, usize)| {
            format!("it uses {}[{index}], and there are {}", kind.list(), has[kind as usize])
        };
        missing.next().map(name)
    };
    let problems = elements
        .iter()
        .enumerate()
        .filter_map(|(i, element)| Some((i, problem(element).or_else(|| missing(element))?)));
    problems.map(|(i, problem)| (format!("{}[{i}]", T::KIND.list()), problem)).next()
}

fn told(problem: Option<&'static str>) -> Problem {
    problem.map(str::to_owned)
}

impl Checked for Mesh {
    fn problem(&self) -> Problem {
        self.lists_problem().or_else(|| told(mesh(self)))
    }
}

impl Checked for Instance {
    fn problem(&self) -> Problem {
        told(affine(&self.world_from_object))
    }
}

impl Checked for Material {
    fn problem(&self) -> Problem {
        told(material(self))
    }
}

impl Checked for Texture {
    fn problem(&self) -> Problem {
        None
    }
}

impl Checked for Image {
    fn problem(&self) -> Problem {
        let bytes = u64::from(self.width) * u64::from(self.height) * 4;
        (bytes == 0 || self.rgba8.len() as u64 != bytes).then(|| {
            format!(
                "{} bytes are not four for each of {}x{} texels",
                self.rgba8.len(),
                self.width,
                self.height
            )
        })
    }
}

impl Checked for Light {
    fn problem(&self) -> Problem {
        told(
            (!self.is_sound()).then_some(
                "a number is not finite, or a colour, an intensity, a range or a size is negative",
            ),
        )
    }
}

impl Checked for Decal {
    fn problem(&self) -> Problem {
        told(self.numbers_problem())
    }
}

impl Checked for Particles {
    fn problem(&self) -> Problem {
        told(self.numbers_problem())
    }
}

impl Checked for Camera {
    fn problem(&self) -> Problem {
        told(camera(self))
    }
}

fn mesh(mesh: &Mesh) -> Option<&'static str> {
    let bad = |holds: bool, problem| (!holds).then_some(problem);
    bad(mesh.positions.iter().all(|p| p.is_finite()), "a position is not finite")
        .or(bad(mesh.normals.iter().all(|n| n.is_finite()), "a normal is not finite"))
        .or(bad(mesh.tangents.iter().all(|t| t.is_finite()), "a tangent is not finite"))
        .or(bad(mesh.texcoords.iter().flatten().all(|t| t.is_finite()), "a texture coordinate is not finite"))
        .or(bad(mesh.colors.iter().all(is_color), "a vertex colour is not finite or negative"))
}

fn is_color(color: &Vec4) -> bool {
    color.is_finite() && color.min_element() >= 0.0
}

fn affine(matrix: &glam::Mat4) -> Option<&'static str> {
    let holds = matrix.is_finite() && matrix.row(3) == Vec4::W;
    (!holds).then_some("the transform is not affine and finite")
}

fn material(m: &Material) -> Option<&'static str> {
    let parts = [m.metallic_factor, m.roughness_factor, m.occlusion_strength];
    let slots = [
        &m.base_color_texture,
        &m.metallic_roughness_texture,
        &m.normal_texture,
        &m.occlusion_texture,
        &m.emissive_texture,
    ];
    let rows = slots.into_iter().flatten().flat_map(|slot| slot.uv_from_texcoord);
    if !is_color(&m.base_color_factor) || !is_color(&m.emissive_factor.extend(0.0)) {
        Some("a colour is not finite or negative")
    } else if !parts.iter().all(|part| (0.0..=1.0).contains(part)) {
        Some("metallicness, roughness or occlusion strength is not from 0 to 1")
    } else if !m.normal_scale.is_finite()
        || matches!(m.alpha_mode, AlphaMode::Mask { cutoff } if !cutoff.is_finite())
    {
        Some("the normal's scale or the alpha cutoff is not finite")
    } else if let Some(problem) = m.transmission.as_ref().and_then(super::Transmission::problem) {
        Some(problem)
    } else if !rows.into_iter().all(|row| row.is_finite()) {
        Some("a texture transform is not finite")
    } else {
        None
    }
}

fn camera(camera: &Camera) -> Option<&'static str> {
    let projects = match camera.projection {
        Projection::Perspective { yfov_rad, znear_m, zfar_m } => {
            yfov_rad > 0.0
                && yfov_rad < std::f32::consts::PI
                && znear_m > 0.0
                && znear_m.is_finite()
                && zfar_m.is_none_or(|far| far > znear_m && far.is_finite())
        }
        Projection::Orthographic { xmag_m, ymag_m, znear_m, zfar_m } => {
            [xmag_m, ymag_m].iter().all(|mag| mag.is_finite() && *mag != 0.0)
                && znear_m.is_finite()
                && zfar_m.is_finite()
                && zfar_m > znear_m
        }
    };
    affine(&camera.world_from_view).or((!projects).then_some("the projection has no volume"))
}

fn surroundings(scene: &Scene) -> Option<&'static str> {
    let fog = |fog: &Fog| {
        is_color(&fog.color_nt.extend(fog.density_per_m))
            && fog.height.is_none_or(|h| h.base_m.is_finite() && h.scale_m.is_finite() && h.scale_m > 0.0)
    };
    let background = match scene.background {
        Background::Color(color) => is_color(&color.extend(0.0)),
        Background::Black | Background::Environment => true,
    };
    let mut environments = scene.environment.iter();
    if !is_color(&scene.ambient_nt.extend(0.0)) {
        Some("the ambient light is not finite or negative")
    } else if !scene.fog.as_ref().is_none_or(fog) {
        Some("the fog's numbers are not finite, or negative, or its height has no scale")
    } else if !background {
        Some("the background's colour is not finite or negative")
    } else if !environments
        .all(|e| e.rotation_deg.is_finite() && e.intensity.is_finite() && e.intensity >= 0.0)
    {
        Some("the environment's rotation or intensity is not finite, or it is negative")
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn the_element_is_named() {
        let mut scene =
            Scene { name: "s".into(), materials: vec![Material::default(); 3], ..Scene::default() };
        scene.check().unwrap();
        scene.materials[2].roughness_factor = f32::NAN;
        let message = scene.check().unwrap_err().to_string();
        assert!(message.starts_with("scene 's': materials[2]: metallicness, roughness"), "{message}");
        scene.materials[2].roughness_factor = 0.0;
        scene.meshes = vec![Mesh { positions: vec![Vec3::ZERO, Vec3::INFINITY], ..Mesh::default() }];
        assert!(scene.check().unwrap_err().to_string().contains("meshes[0]: a position"));
        scene.meshes.clear();
        scene.background = Background::Color(Vec3::NEG_X);
        assert!(scene.check().unwrap_err().to_string().contains("background"));
    }
}
