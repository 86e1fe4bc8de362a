//! Bringing a renderer to a later state of its scene.

use super::{Recorder, Renderer, Retired, check_formats};
use crate::Result;
use crate::plan::{Needs, Plan};
use crate::scene::{Changes, Scene, World};

/// What an update did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Updated {
    /// The frame has other attachments now: targets that were created before must be created anew, and those of frames on the GPU
    /// be kept until these have finished.
    pub new_targets: bool,
    /// Pipelines were made.
    pub new_pipelines: bool,
    /// Buffers and descriptors were made, and copies recorded.
    pub new_objects: bool,
}

impl Renderer {
    /// Brings the renderer to the state that its world is in now, for the frames recorded from now on. Those on the GPU go on as they are, and
    /// what only they use is freed once a frame is recorded with the slot of the last of them.
    ///
    /// The renderer was made of [`World::scene`] when [`World::changes`] were cleared last, or updated then. If since then
    /// things have only moved or were posed, and lights, decals and particles got other numbers, this is [`Self::set_instance`],
    /// [`Self::set_pose`], [`Self::set_light`], [`Self::set_decal`] and [`Self::set_particles`]. Otherwise it makes a plan with the same options, and what of the objects is not there: meshes and textures
    /// that have not changed, the pipelines where the plan has the same, the environment where it is the same, are shared with the
    /// frames before. Shadow maps are drawn anew.
    ///
    /// Copies are recorded, outside of a render pass, into a command buffer that the host submits to the device's queue before the next
    /// frame or with it. Nothing waits; what takes time is making objects.
    ///
    /// # Errors
    /// Those of [`Plan::new`] and [`Renderer::new`], if what the scene has become does not go with the options or the device. The
    /// renderer is unchanged then, but for things that have moved.
    pub fn update(&mut self, world: &World, recorder: &Recorder<'_>) -> Result<Updated> {
        let (scene, changes) = (world.scene(), world.changes());
        if !changes.is_structural() && self.set_values(scene, changes).is_ok() {
            return Ok(Updated::default());
        }
        let needs = Needs::of(scene).shown(self.plan.options.show);
        let limits = self.device.limits();
        let plan = match needs == self.plan.needs {
            true => self.plan.clone(),
            false => Plan::new(needs, self.plan.options.clone(), &limits)?,
        };
        check_formats(&self.device, &plan)?;
        let next = Self::with(&self.device, scene, plan, self.config, &self.cache, Some((&*self, changes)))?;
        let same_casters = match (&next.shadows, &self.shadows) {
            (Some(next), Some(old)) => next.shares_pipelines(old),
            (next, _) => next.is_none(),
        };
        let updated = Updated {
            new_targets: !std::sync::Arc::ptr_eq(&next.passes, &self.passes),
            new_pipelines: !std::sync::Arc::ptr_eq(&next.pipelines, &self.pipelines) || !same_casters,
            new_objects: true,
        };
        let mut old = std::mem::replace(self, next);
        // What is drawn over frames has nothing to do with the scene.
        if let (Some(new), Some(drawn)) = (&mut self.overlay, &mut old.overlay) {
            new.take(drawn);
        }
        self.retired = std::mem::replace(&mut old.retired, Retired::new(0));
        // What is shared may not have been copied yet.
        let mut uploads: Vec<_> = old.upload.take().into_iter().chain(self.upload.take()).collect();
        uploads.iter_mut().for_each(|upload| upload.record(recorder));
        self.retired.leave(old, uploads);
        Ok(updated)
    }

    fn set_values(&mut self, scene: &Scene, changes: &Changes) -> Result<()> {
        for &index in &changes.instances {
            self.set_instance(index, &scene.instances[index].world_from_object)?;
        }
        changes.lights.iter().try_for_each(|&index| self.set_light(index, &scene.lights[index]))?;
        changes.decals.iter().try_for_each(|&index| self.set_decal(index, &scene.decals[index]))?;
        for &index in &changes.poses {
            if let Some(deformation) = &scene.meshes[index].deformation {
                self.set_pose(index, &deformation.pose)?;
            }
        }
        let mut particles = changes.particles.iter();
        particles.try_for_each(|&index| self.set_particles(index, &scene.particles[index].list))
    }
}
