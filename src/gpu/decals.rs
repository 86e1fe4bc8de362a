//! The scene's decals as they stand, and what of them a view sees, in the order in which it is painted.

use std::ops::Range;

use glam::Mat4;

use super::shared::DecalData;
use crate::plan::{DecalKind, Pipeline, Plan};
use crate::scene::{Camera, Decal, Projection, Scene};
use crate::visible::{DecalLevels, Frustum, Reach};
use crate::{Error, Result};

/// Decals that one draw paints, none of which covers another of the same level.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct DecalRun {
    /// Those of a higher level are painted over those of lower ones.
    pub(super) level: u32,
    /// Index into `Plan::pipelines`.
    pub(super) pipeline: usize,
    /// Index for `SceneData::material_set`.
    pub(super) material_set: usize,
    /// Their part of the buffer.
    pub(super) instances: Range<u32>,
}

/// What of a decal does not change.
struct Placed {
    /// Index into `Scene::materials`.
    material: usize,
    pipeline: usize,
    material_set: usize,
    kind: DecalKind,
    decal: Decal,
    data: DecalData,
    reach: Reach,
}

/// All decals that paint something, in the order of painting.
#[derive(Default)]
pub(super) struct Decals {
    placed: Vec<Placed>,
    /// By element of `Scene::decals`: its place in `placed`.
    elements: Vec<Option<usize>>,
    levels: DecalLevels,
    /// Level, pipeline, material set and place of what the last frame saw.
    seen: Vec<(u32, usize, usize, usize)>,
    runs: Vec<DecalRun>,
}

impl Decals {
    pub(super) fn new(scene: &Scene, plan: &Plan) -> Self {
        let mut elements = vec![None; scene.decals.len()];
        if plan.decal_way.is_none() {
            return Self { elements, ..Self::default() };
        }
        let mut order: Vec<usize> = (0..scene.decals.len()).collect();
        order.sort_by(|&a, &b| scene.decals[a].priority.total_cmp(&scene.decals[b].priority));
        let mut placed = Vec::new();
        for element in order {
            let decal = &scene.decals[element];
            let Some(kind) = DecalKind::new(scene, decal) else { continue };
            let drawn = plan.pipelines.iter().position(|(_, p)| *p == Pipeline::Decal(kind));
            let Some(pipeline) = drawn else { continue };
            elements[element] = Some(placed.len());
            placed.push(Placed {
                material: decal.material,
                pipeline,
                material_set: 0,
                kind,
                decal: decal.clone(),
                data: data(decal),
                reach: reach(decal),
            });
        }
        let count = placed.len();
        Self {
            placed,
            elements,
            levels: DecalLevels::default(),
            seen: Vec::with_capacity(count),
            runs: Vec::with_capacity(count),
        }
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.placed.len()
    }

    /// Pipeline and material of each.
    pub(super) fn materials(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.placed.iter().map(|p| (p.pipeline, p.material))
    }

    /// Says where each finds its material, by pipeline and material.
    pub(super) fn set_material_sets(&mut self, set: impl Fn((usize, usize)) -> usize) {
        self.placed.iter_mut().for_each(|p| p.material_set = set((p.pipeline, p.material)));
    }

    /// Changes an element of `Scene::decals`.
    pub(super) fn set(&mut self, scene_index: usize, decal: &Decal) -> Result<()> {
        let count = self.elements.len();
        let refused = |problem: String, remedy: String| Err(Error::unsupported(problem, remedy));
        let Some(&place) = self.elements.get(scene_index) else {
            let remedy = format!("use an index below {count}, the number of the scene's decals");
            return refused(format!("there is no decal {scene_index} to change"), remedy);
        };
        let name = &decal.name;
        if let Some(problem) = decal.numbers_problem() {
            let remedy = "give finite numbers within the range that the decal's description names";
            return refused(format!("decal {scene_index} ('{name}'): {problem}"), remedy.into());
        }
        let [color, normal, roughness, metallic] = decal.channels.to_array().map(|opacity| opacity > 0.0);
        let placed = place.map(|place| &mut self.placed[place]);
        let known = placed.filter(|placed| {
            let has = placed.kind.channels;
            let new = (color && !has.base_color)
                || (normal && !has.normal && placed.decal.channels.normal == 0.0)
                || (roughness && !has.roughness)
                || (metallic && !has.metallic);
            !new && decal.material == placed.material && decal.priority == placed.decal.priority
        });
        let Some(placed) = known else {
            return refused(
                format!("decal {scene_index} ('{name}') changes into one that the plan does not know"),
                "make a plan and a renderer of the scene with the new decal".into(),
            );
        };
        placed.data = data(decal);
        placed.reach = reach(decal);
        placed.decal = decal.clone();
        Ok(())
    }

    /// Writes those that the view sees (all without a view), those that one draw paints beside each other.
    pub(super) fn write_visible(
        &mut self,
        clip_from_world: &Mat4,
        view: Option<&Frustum>,
        camera: &Camera,
        out: &mut [DecalData],
    ) {
        self.levels.clear();
        self.seen.clear();
        self.runs.clear();
        for (place, placed) in self.placed.iter().enumerate() {
            if view.is_some_and(|view| view.misses(&placed.reach)) {
                continue;
            }
            let level = self.levels.place(clip_from_world, &placed.decal.world_from_decal);
            self.seen.push((level, placed.pipeline, placed.material_set, place));
        }
        self.seen.sort_unstable();
        for (instance, &(level, pipeline, material_set, place)) in (0..).zip(&self.seen) {
            let placed = &self.placed[place];
            let whole_image = u32::from(is_cut_by_far_plane(camera, &placed.reach));
            out[instance as usize] = DecalData { whole_image, ..placed.data };
            match self.runs.last_mut() {
                Some(run)
                    if (run.level, run.pipeline, run.material_set) == (level, pipeline, material_set) =>
                {
                    run.instances.end = instance + 1;
                }
                _ => self.runs.push(DecalRun {
                    level,
                    pipeline,
                    material_set,
                    instances: instance..instance + 1,
                }),
            }
        }
    }

    /// What the last frame saw, in the order of painting.
    pub(super) fn runs(&self) -> &[DecalRun] {
        &self.runs
    }
}

fn data(decal: &Decal) -> DecalData {
    let rows = |m: &Mat4| [m.row(0), m.row(1), m.row(2)].map(|row| row.to_array());
    DecalData {
        world_from_decal_rows: rows(&decal.world_from_decal),
        decal_from_world_rows: rows(&decal.decal_from_world().as_mat4()),
        opacity: decal.channels.to_array(),
        inverse_falloff: decal.falloff_share().recip().as_vec3().to_array(),
        handedness: decal.handedness() as f32,
        facing: decal.angle_line().map(|x| x as f32),
        ..DecalData::default()
    }
}

fn reach(decal: &Decal) -> Reach {
    let m = &decal.world_from_decal;
    Reach::Box {
        center_world: m.w_axis.truncate(),
        half_axes_world: [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.truncate() * 0.5),
    }
}

/// Whether the far side of the box, or a part of it, is beyond the far plane: its mesh would have a hole there.
fn is_cut_by_far_plane(camera: &Camera, reach: &Reach) -> bool {
    /// Meshes are somewhat larger than what they hold.
    const ROOM: f32 = 1.01;
    let far = match camera.projection {
        Projection::Perspective { zfar_m, .. } => zfar_m.unwrap_or(f32::INFINITY),
        Projection::Orthographic { zfar_m, .. } => zfar_m,
    };
    let Reach::Box { center_world, half_axes_world } = *reach else { return false };
    let forward = -camera.world_from_view.z_axis.truncate();
    let distance = (center_world - camera.world_from_view.w_axis.truncate()).dot(forward);
    let extent: f32 = half_axes_world.iter().map(|axis| axis.length()).sum();
    distance + ROOM * extent >= far
}
