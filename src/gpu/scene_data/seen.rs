//! What a frame would see of the lights.

use bytemuck::Zeroable;
use glam::{Mat4, Vec3};

use super::SceneData;
use crate::gpu::View;
use crate::gpu::renderer::SeenLight;
use crate::gpu::shared::LightData;
use crate::visible::{Clusters, Sight};

impl SceneData {
    /// The lights that [`Self::write_frame`] would write for a view, and the cells that it would list them in.
    pub(in crate::gpu) fn see_lights(
        &mut self,
        view: &View<'_>,
        size: [u32; 2],
        clip_from_world: &Mat4,
        cull: bool,
    ) -> (Vec<SeenLight>, Option<&Clusters>) {
        let Self { lights, light_lists, .. } = self;
        let sight = Sight::new(clip_from_world, &view.camera.world_from_view);
        let mut data = vec![LightData::zeroed(); lights.count()];
        let reaches = light_lists.reaches_mut();
        let counts = lights.write_visible(cull.then_some(&sight.frustum), &mut data, reaches);
        let seen = |(n, (&reach, data)): (usize, (_, &LightData))| SeenLight {
            reach,
            place_world: (n >= counts[0] as usize).then(|| Vec3::from_slice(&data.place[..3])),
            intensity: data.intensity.into(),
            has_shadow: data.shadow != 0,
        };
        let seen = reaches.iter().zip(&data).enumerate().map(seen).collect();
        let all = counts.iter().sum::<u32>();
        (seen, light_lists.clusters(view.camera, size, counts[0]..all))
    }
}
