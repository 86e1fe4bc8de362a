//! The scene's particles as they stand, and what of them a view sees.

use std::ops::Range;

use glam::{Mat2, Vec2};

use super::shared::ParticleData;
use crate::plan::{ParticleKind, Pipeline, Plan};
use crate::scene::{Particle, Particles, PreRotation, Scene};
use crate::visible::{Frustum, Reach};
use crate::{Error, Result};

/// What one draw adds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ParticleRun {
    /// Index into `Plan::pipelines`.
    pub(super) pipeline: usize,
    /// Index for `SceneData::material_set`.
    pub(super) material_set: usize,
    /// Their part of the buffer.
    pub(super) instances: Range<u32>,
}

/// An element of `Scene::particles`.
struct Group {
    /// `None` if there is nothing to see of it.
    pipeline: Option<usize>,
    /// Index into `Scene::materials`.
    material: usize,
    material_set: usize,
    inverse_soft: f32,
    most: usize,
    list: Vec<Particle>,
}

/// All particles.
#[derive(Default)]
pub(super) struct SceneParticles {
    groups: Vec<Group>,
    runs: Vec<ParticleRun>,
}

impl SceneParticles {
    pub(super) fn new(scene: &Scene, plan: &Plan) -> Self {
        let group = |particles: &Particles| {
            let kind = ParticleKind::new(scene, particles).map(Pipeline::Particles);
            let mut list = Vec::with_capacity(particles.most);
            list.extend_from_slice(&particles.list);
            Group {
                pipeline: kind.and_then(|kind| plan.pipelines.iter().position(|(_, p)| *p == kind)),
                material: particles.material,
                material_set: 0,
                inverse_soft: particles.inverse_soft() as f32,
                most: particles.most,
                list,
            }
        };
        let groups: Vec<_> = scene.particles.iter().map(group).collect();
        Self { runs: Vec::with_capacity(groups.len()), groups }
    }

    /// How many there may be.
    pub(super) fn most(&self) -> usize {
        self.groups.iter().filter(|g| g.pipeline.is_some()).map(|g| g.most).sum()
    }

    /// Pipeline and material of each group that is drawn.
    pub(super) fn materials(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.groups.iter().filter_map(|g| Some((g.pipeline?, g.material)))
    }

    /// Says where each finds its material, by pipeline and material.
    pub(super) fn set_material_sets(&mut self, set: impl Fn((usize, usize)) -> usize) {
        for group in &mut self.groups {
            if let Some(pipeline) = group.pipeline {
                group.material_set = set((pipeline, group.material));
            }
        }
    }

    /// Puts others in the place of an element of `Scene::particles`.
    pub(super) fn set(&mut self, index: usize, list: &[Particle]) -> Result<()> {
        let count = self.groups.len();
        let Some(group) = self.groups.get_mut(index) else {
            let remedy = format!("use an index below {count}, the number of the scene's lists of particles");
            return Err(Error::unsupported(format!("there are no particles {index} to replace"), remedy));
        };
        if list.len() > group.most {
            return Err(Error::unsupported(
                format!(
                    "{} particles {index} are more than the {} that there may be",
                    list.len(),
                    group.most
                ),
                "say how many there may be in `Particles::most` before the plan is made",
            ));
        }
        if let Some(problem) = list.iter().find_map(Particle::problem) {
            let remedy = "give finite numbers of at least 0";
            return Err(Error::unsupported(format!("particles {index}: {problem}"), remedy));
        }
        group.list.clear();
        group.list.extend_from_slice(list);
        Ok(())
    }

    /// Writes those that the view sees, all without a view.
    pub(super) fn write_visible(
        &mut self,
        view: Option<&Frustum>,
        pre_rotation: PreRotation,
        out: &mut [ParticleData],
    ) {
        self.runs.clear();
        // Axes go up and images down, so that clockwise there is counter-clockwise here.
        let turn = pre_rotation.image_from_picture().transpose();
        let mut end = 0;
        for group in &self.groups {
            let Some(pipeline) = group.pipeline else { continue };
            let first = end;
            for particle in &group.list {
                if view.is_some_and(|view| view.misses(&reach(particle))) {
                    continue;
                }
                out[end as usize] = data(particle, group.inverse_soft, turn);
                end += 1;
            }
            if end > first {
                let material_set = group.material_set;
                self.runs.push(ParticleRun { pipeline, material_set, instances: first..end });
            }
        }
    }

    /// What the last frame sees.
    pub(super) fn runs(&self) -> &[ParticleRun] {
        &self.runs
    }
}

fn reach(particle: &Particle) -> Reach {
    let radius_m = particle.size_m * std::f32::consts::FRAC_1_SQRT_2;
    Reach::Sphere { center_world: particle.position_world, radius_m }
}

fn data(particle: &Particle, inverse_soft: f32, turn: Mat2) -> ParticleData {
    let axis = turn * Vec2::from_angle(particle.rotation_rad);
    ParticleData {
        center_world: particle.position_world.to_array(),
        inverse_soft,
        color: particle.color.to_array(),
        half_axis: (axis * 0.5 * particle.size_m).to_array(),
        ..ParticleData::default()
    }
}
