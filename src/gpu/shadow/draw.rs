//! Recording a frame's shadows.

use ash::vk;

use super::super::scene_data::SceneData;
use super::super::shared::{InstanceData, ShadowPush, ShadowViewData};
use super::super::{IndexWidth, Recorder, View};
use super::casters::Batch;
use super::{RecordedShadows, Shadows};
use crate::visible::{Frustum, ShadowView};

/// A depth beyond all that is drawn: nothing is moved to it.
const NO_NEAREST_DEPTH: f32 = f32::MAX;

impl Shadows {
    /// Draws the tiles that this view needs and that are not there yet, outside of any render pass, and fills the slot's
    /// list of views. The GPU has finished with the slot; it need not have with the map: the commands wait for earlier
    /// frames that sample it.
    pub(in crate::gpu) fn record(
        &mut self,
        recorder: &Recorder<'_>,
        slot: usize,
        view: &View<'_>,
        aspect: f64,
        data: &SceneData,
    ) -> RecordedShadows {
        let Self { lights, tiles, bounds_world, casters, .. } = self;
        let moves = casters.moves();
        let signature = |view: &ShadowView| casters.signature(&Frustum::new(&view.casters_clip_from_world()));
        for light in lights.iter() {
            light.views(view.camera, aspect, bounds_world, |tile, view| {
                tiles.want(tile, view, moves, signature)
            });
        }
        let waiting = self.tiles.choose(self.most_tiles);
        let mut recorded = RecordedShadows { waiting, ..RecordedShadows::default() };
        if !self.tiles.chosen().is_empty() {
            let _label = recorder.label("shadows");
            self.write_instances(slot);
            self.begin(recorder, slot);
            let mut bound = Bound::default();
            for &tile in self.tiles.chosen() {
                self.draw_tile(recorder, data, tile, &mut bound, &mut recorded);
            }
            self.end(recorder);
            self.in_use = true;
        }
        self.write_views(slot);
        recorded
    }

    /// Brings the slot's casters up to date.
    fn write_instances(&mut self, slot: usize) {
        let (buffer, moves) = &mut self.instances[slot];
        if *moves != self.casters.moves() {
            let content: &mut [InstanceData] = bytemuck::cast_slice_mut(buffer.mapped_mut());
            content.iter_mut().zip(self.casters.data()).for_each(|(to, from)| *to = from);
            *moves = self.casters.moves();
        }
    }

    fn write_views(&mut self, slot: usize) {
        let Self { lights, tiles, map, resources, .. } = self;
        let content: &mut [ShadowViewData] = bytemuck::cast_slice_mut(resources.views[slot].mapped_mut());
        for light in lights.iter() {
            for tile in light.tiles() {
                // All zero, nothing is inside of it.
                let data = tiles.shown(tile).map(|view| light.data(view, &map.tiles[tile], map));
                content[tile] = data.unwrap_or_default();
            }
        }
    }

    /// From being sampled to being drawn.
    fn begin(&self, recorder: &Recorder<'_>, slot: usize) {
        let old = match self.in_use {
            true => vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
            false => vk::ImageLayout::UNDEFINED,
        };
        let depth = vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
        let access =
            vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_READ | vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_WRITE;
        // Earlier reads need the order of execution only; what earlier frames drew, they made visible themselves.
        self.barrier(
            recorder,
            (vk::PipelineStageFlags::FRAGMENT_SHADER, vk::AccessFlags::empty(), old),
            (DEPTH_STAGES, access, depth),
        );
        let (device, raw) = (recorder.device().raw(), recorder.raw());
        let (point, layout) = (vk::PipelineBindPoint::GRAPHICS, self.pipelines.layouts[0].layout.raw());
        // SAFETY: recording; the set was allocated with the layout's first set layout, which all caster layouts share.
        unsafe {
            device.cmd_bind_descriptor_sets(raw, point, layout, 0, &[self.instance_sets.raw(slot)], &[])
        };
    }

    /// From being drawn to being sampled.
    fn end(&self, recorder: &Recorder<'_>) {
        self.barrier(
            recorder,
            (
                DEPTH_STAGES,
                vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_WRITE,
                vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
            ),
            (
                vk::PipelineStageFlags::FRAGMENT_SHADER,
                vk::AccessFlags::SHADER_READ,
                vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
            ),
        );
    }

    fn barrier(
        &self,
        recorder: &Recorder<'_>,
        (src_stages, src_access, old): (vk::PipelineStageFlags, vk::AccessFlags, vk::ImageLayout),
        (dst_stages, dst_access, new): (vk::PipelineStageFlags, vk::AccessFlags, vk::ImageLayout),
    ) {
        let barrier = vk::ImageMemoryBarrier::default()
            .src_access_mask(src_access)
            .dst_access_mask(dst_access)
            .old_layout(old)
            .new_layout(new)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(self.resources.image.raw())
            .subresource_range(self.resources.image.range());
        let none = vk::DependencyFlags::empty();
        // SAFETY: recording, outside of a render pass; the image is alive.
        unsafe {
            recorder.device().raw().cmd_pipeline_barrier(
                recorder.raw(),
                src_stages,
                dst_stages,
                none,
                &[],
                &[],
                &[barrier],
            );
        }
    }

    fn draw_tile(
        &self,
        recorder: &Recorder<'_>,
        data: &SceneData,
        tile: usize,
        bound: &mut Bound,
        recorded: &mut RecordedShadows,
    ) {
        let Some(view) = self.tiles.shown(tile) else { return };
        let (device, raw) = (recorder.device().raw(), recorder.raw());
        let place = &self.map.tiles[tile];
        let side = place.texels as f32;
        let area = vk::Rect2D {
            offset: vk::Offset2D { x: place.x as i32, y: place.y as i32 },
            extent: vk::Extent2D { width: place.texels, height: place.texels },
        };
        let viewport = vk::Viewport {
            x: place.x as f32,
            y: place.y as f32,
            width: side,
            height: side,
            min_depth: 0.0,
            max_depth: 1.0,
        };
        let info = vk::RenderPassBeginInfo::default()
            .render_pass(self.pass.raw())
            .framebuffer(self.framebuffer.raw())
            .render_area(area);
        let push = ShadowPush {
            clip_from_world: view.clip_from_world.to_cols_array_2d(),
            nearest_depth: if view.pancaked { 1.0 } else { NO_NEAREST_DEPTH },
        };
        // SAFETY: recording, outside of a render pass; the area is inside the framebuffer, which was made for the pass; all
        // layouts have the same push constants.
        unsafe {
            device.cmd_begin_render_pass(raw, &info, vk::SubpassContents::INLINE);
            device.cmd_set_viewport(raw, 0, &[viewport]);
            device.cmd_set_scissor(raw, 0, &[area]);
            let layout = self.pipelines.layouts[0].layout.raw();
            device.cmd_push_constants(
                raw,
                layout,
                vk::ShaderStageFlags::VERTEX,
                0,
                bytemuck::bytes_of(&push),
            );
            device.cmd_bind_pipeline(raw, vk::PipelineBindPoint::GRAPHICS, self.pipelines.clear.raw());
            device.cmd_draw(raw, 3, 1, 0, 0);
        }
        bound.pipeline = None;
        recorded.draws += 1;
        let frustum = Frustum::new(&view.casters_clip_from_world());
        self.casters.in_view(&frustum, |index, batch, run| {
            self.bind(recorder, data, index, batch, bound);
            let range = &data.geometry().meshes()[batch.mesh];
            let (count, first) = (run.len() as u32, run.start as u32);
            // SAFETY: `bind` bound everything that the pipeline reads, and the ranges lie inside the buffers.
            unsafe {
                device.cmd_draw_indexed(
                    raw,
                    range.index_count,
                    count,
                    range.first_index,
                    range.vertex_offset,
                    first,
                );
            }
            recorded.draws += 1;
            recorded.casters += run.len();
        });
        // SAFETY: the pass is being recorded.
        unsafe { device.cmd_end_render_pass(raw) };
        recorded.tiles += 1;
        recorded.stored_bytes += self.map.tile_bytes(tile);
    }

    /// Binds what a batch's draws read, unless it is bound already.
    fn bind(
        &self,
        recorder: &Recorder<'_>,
        data: &SceneData,
        index: usize,
        batch: &Batch,
        bound: &mut Bound,
    ) {
        let (device, raw) = (recorder.device().raw(), recorder.raw());
        let point = vk::PipelineBindPoint::GRAPHICS;
        if bound.pipeline != Some(batch.pipeline) {
            // SAFETY: the pipeline was made for this pass.
            unsafe { device.cmd_bind_pipeline(raw, point, self.pipelines.pipelines[batch.pipeline].raw()) };
            bound.pipeline = Some(batch.pipeline);
        }
        if let (Some(set), Some(sets)) = (self.material_set_of[index], &self.material_sets)
            && bound.material != Some(set)
        {
            let layout = self.pipelines.layouts[batch.pipeline].layout.raw();
            // SAFETY: the set was allocated with this layout's second set layout.
            unsafe { device.cmd_bind_descriptor_sets(raw, point, layout, 1, &[sets.raw(set)], &[]) };
            bound.material = Some(set);
        }
        let geometry = data.geometry();
        let (Some(vertices), Some(indices)) = (geometry.vertices(), geometry.indices()) else { return };
        let streams @ (offsets, count) = &self.stream_offsets[index];
        if bound.streams != Some(*streams) {
            let buffers = [vertices.raw(); super::MOST_STREAMS];
            // SAFETY: both lists are of one length, and offsets lie inside the buffer.
            unsafe { device.cmd_bind_vertex_buffers(raw, 0, &buffers[..*count], &offsets[..*count]) };
            bound.streams = Some(*streams);
        }
        let width = geometry.meshes()[batch.mesh].index_width;
        if bound.index_width != Some(width) {
            let offset = geometry.index_offset_bytes(width);
            // SAFETY: the offset lies inside the buffer and is a multiple of the index size.
            unsafe { device.cmd_bind_index_buffer(raw, indices.raw(), offset, width.index_type()) };
            bound.index_width = Some(width);
        }
    }
}

/// Where depth attachments are accessed.
const DEPTH_STAGES: vk::PipelineStageFlags = vk::PipelineStageFlags::from_raw(
    vk::PipelineStageFlags::EARLY_FRAGMENT_TESTS.as_raw()
        | vk::PipelineStageFlags::LATE_FRAGMENT_TESTS.as_raw(),
);

/// What is bound while casters are drawn, in all tiles of a frame.
#[derive(Default)]
struct Bound {
    pipeline: Option<usize>,
    material: Option<usize>,
    streams: Option<([u64; super::MOST_STREAMS], usize)>,
    index_width: Option<IndexWidth>,
}
