//! Recording a frame's shadows.

use ash::vk;

use super::super::scene_data::SceneData;
use super::super::shared::{InstanceData, ShadowPush, ShadowViewData};
use super::super::{Image, IndexWidth, Owned, Recorder, View};
use super::casters::{Batch, Which};
use super::pipelines::CONSTANT_BIAS;
use super::static_map::StaticMap;
use super::tiles::{Chosen, How};
use super::{RecordedShadows, Shadows};
use crate::plan::Tile;
use crate::visible::{ShadowView, TexelArea};

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
        let Self { lights, tiles, bounds_world, casters, map, .. } = self;
        let moves = casters.moves();
        let signature = |view: &ShadowView| casters.signature(&view.volume());
        for light in lights.iter() {
            light.views(view.camera, aspect, bounds_world, |tile, view| {
                tiles.want(tile, view, moves, signature);
            });
        }
        let keeps_static = |tile| map.lights.iter().any(|l| l.keeps_static && l.tiles.contains(&tile));
        let waiting = tiles.choose(self.most_tiles, keeps_static);
        let mut recorded = RecordedShadows { waiting, ..RecordedShadows::default() };
        if !self.tiles.chosen().is_empty() {
            let _label = recorder.label("shadows");
            self.write_instances(slot);
            self.draw_static(recorder, slot, data, &mut recorded);
            self.draw_tiles(recorder, slot, data, &mut recorded);
        }
        self.write_views(slot);
        recorded
    }

    /// Draws what is missing of the static map.
    fn draw_static(
        &mut self,
        recorder: &Recorder<'_>,
        slot: usize,
        data: &SceneData,
        recorded: &mut RecordedShadows,
    ) {
        let missing = |chosen: &&Chosen| matches!(chosen.how, How::Composed { fixed: true, .. });
        let chosen = self.tiles.chosen();
        let Some(map) = self.static_map.as_ref().filter(|_| chosen.iter().any(|c| missing(&c))) else {
            return;
        };
        begin(recorder, &map.image, map.in_use);
        self.bind_instances(recorder, slot);
        let mut bound = Bound::default();
        for &Chosen { tile, .. } in chosen.iter().filter(missing) {
            let (framebuffer, area) = (&map.framebuffer, self.whole(tile));
            let target = Target { tile, framebuffer, area, copied: None, which: Which::Fixed };
            self.draw_tile(recorder, slot, data, &target, &mut bound, recorded);
            recorded.static_tiles += 1;
        }
        end(recorder, &map.image);
        self.static_map.iter_mut().for_each(|map| map.in_use = true);
    }

    fn draw_tiles(
        &mut self,
        recorder: &Recorder<'_>,
        slot: usize,
        data: &SceneData,
        recorded: &mut RecordedShadows,
    ) {
        begin(recorder, &self.resources.image, self.in_use);
        self.bind_instances(recorder, slot);
        let mut bound = Bound::default();
        for index in 0..self.tiles.chosen().len() {
            let Chosen { tile, how } = self.tiles.chosen()[index];
            let texels = self.map.tiles[tile].texels;
            let dynamic = self
                .tiles
                .shown(tile)
                .map(|view| self.casters.dynamic_area(view, texels))
                .unwrap_or_default();
            let changed = self.tiles.set_dynamic(tile, dynamic);
            let (which, copied, area) = match how {
                How::Whole => (Which::All, None, self.whole(tile)),
                How::Composed { rest_stays: false, .. } => {
                    (Which::Dynamic, self.static_map.as_ref(), self.whole(tile))
                }
                How::Composed { rest_stays: true, .. } => {
                    (Which::Dynamic, self.static_map.as_ref(), self.part(tile, changed))
                }
            };
            let target = Target { tile, framebuffer: &self.framebuffer, area, copied, which };
            self.draw_tile(recorder, slot, data, &target, &mut bound, recorded);
            if copied.is_some() {
                recorded.composed += 1;
                recorded.copied_bytes += self.bytes(area);
            }
            recorded.tiles += 1;
        }
        end(recorder, &self.resources.image);
        self.in_use = true;
    }

    /// A tile's place in the map.
    fn whole(&self, tile: usize) -> vk::Rect2D {
        let Tile { x, y, texels } = self.map.tiles[tile];
        vk::Rect2D {
            offset: vk::Offset2D { x: x as i32, y: y as i32 },
            extent: vk::Extent2D { width: texels, height: texels },
        }
    }

    /// The place of a part of a tile, no smaller than what the device draws at a time.
    fn part(&self, tile: usize, part: TexelArea) -> vk::Rect2D {
        let Tile { x, y, texels } = self.map.tiles[tile];
        let origin = [x, y];
        let begin = |axis: usize| {
            let step = self.granularity[axis].max(1);
            ((origin[axis] + part.min[axis]) / step * step).max(origin[axis])
        };
        let end = |axis: usize| {
            let end = origin[axis] + part.max[axis].max(part.min[axis] + 1);
            end.next_multiple_of(self.granularity[axis].max(1)).min(origin[axis] + texels)
        };
        let ([x, y], [right, bottom]) = ([begin(0), begin(1)], [end(0), end(1)]);
        vk::Rect2D {
            offset: vk::Offset2D { x: x as i32, y: y as i32 },
            extent: vk::Extent2D { width: right - x, height: bottom - y },
        }
    }

    fn bytes(&self, area: vk::Rect2D) -> u64 {
        let texels = u64::from(area.extent.width) * u64::from(area.extent.height);
        texels * u64::from(self.map.format.bytes())
    }

    /// Brings the slot's casters up to date.
    fn write_instances(&mut self, slot: usize) {
        let (buffer, moves) = &mut self.instances[slot];
        if *moves != Some(self.casters.moves()) {
            let content: &mut [InstanceData] = bytemuck::cast_slice_mut(buffer.mapped_mut());
            content.iter_mut().zip(self.casters.data()).for_each(|(to, from)| *to = from);
            *moves = Some(self.casters.moves());
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

    fn bind_instances(&self, recorder: &Recorder<'_>, slot: usize) {
        let (device, raw) = (recorder.device().raw(), recorder.raw());
        let (point, layout) =
            (vk::PipelineBindPoint::GRAPHICS, self.pipelines.casters.layouts[0].layout.raw());
        // SAFETY: recording; the set was allocated with the layout's first set layout, which all caster layouts share.
        unsafe {
            device.cmd_bind_descriptor_sets(raw, point, layout, 0, &[self.instance_sets.raw(slot)], &[])
        };
    }

    fn draw_tile(
        &self,
        recorder: &Recorder<'_>,
        slot: usize,
        data: &SceneData,
        target: &Target<'_>,
        bound: &mut Bound,
        recorded: &mut RecordedShadows,
    ) {
        let Some(view) = self.tiles.shown(target.tile) else { return };
        let (device, raw) = (recorder.device().raw(), recorder.raw());
        let place = &self.map.tiles[target.tile];
        let side = place.texels as f32;
        let viewport = vk::Viewport {
            x: place.x as f32,
            y: place.y as f32,
            width: side,
            height: side,
            min_depth: 0.0,
            max_depth: 1.0,
        };
        let info = vk::RenderPassBeginInfo::default()
            .render_pass(self.pipelines.pass.raw())
            .framebuffer(target.framebuffer.raw())
            .render_area(target.area);
        let push = ShadowPush {
            clip_from_world: view.clip_from_world.to_cols_array_2d(),
            nearest_depth: if view.pancaked { 1.0 } else { NO_NEAREST_DEPTH },
        };
        // SAFETY: recording, outside of a render pass; the area is inside the framebuffer, which was made for the pass.
        unsafe {
            device.cmd_begin_render_pass(raw, &info, vk::SubpassContents::INLINE);
            device.cmd_set_viewport(raw, 0, &[viewport]);
            device.cmd_set_scissor(raw, 0, &[target.area]);
            // Depth is reversed, so away from the light is down.
            device.cmd_set_depth_bias(raw, -CONSTANT_BIAS, 0.0, -view.slope_texels);
        }
        let point = vk::PipelineBindPoint::GRAPHICS;
        match target.copied {
            Some(map) => {
                map.draw_copy(recorder);
                // The copy has descriptors of its own.
                self.bind_instances(recorder, slot);
                bound.material = None;
            }
            // SAFETY: the pipeline was made for this pass; the triangle reads no vertices and no descriptors.
            None => unsafe {
                device.cmd_bind_pipeline(raw, point, self.pipelines.casters.clear.raw());
                device.cmd_draw(raw, 3, 1, 0, 0);
            },
        }
        let (layout, stages) = (self.pipelines.casters.layouts[0].layout.raw(), vk::ShaderStageFlags::VERTEX);
        // SAFETY: recording; all casters' layouts have the same push constants.
        unsafe { device.cmd_push_constants(raw, layout, stages, 0, bytemuck::bytes_of(&push)) };
        bound.pipeline = None;
        recorded.draws += 1;
        let mut drawn = 0;
        self.casters.in_view(&view.volume(), target.which, |index, batch, run| {
            self.bind(recorder, data, index, batch, bound);
            let (.., range) = data.meshes().drawn(batch.mesh);
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
            recorded.triangles += u64::from(range.index_count / 3) * u64::from(count);
            recorded.vertices += u64::from(range.vertex_count);
            drawn += run.len();
        });
        // SAFETY: the pass is being recorded.
        unsafe { device.cmd_end_render_pass(raw) };
        recorded.casters += drawn;
        recorded.culled += self.casters.count_of(target.which) - drawn;
        recorded.stored_bytes += self.bytes(target.area);
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
            unsafe {
                device.cmd_bind_pipeline(raw, point, self.pipelines.casters.pipelines[batch.pipeline].raw())
            };
            bound.pipeline = Some(batch.pipeline);
        }
        if let (Some(set), Some(sets)) = (self.material_set_of[index], &self.material_sets)
            && bound.material != Some(set)
        {
            let layout = self.pipelines.casters.layouts[batch.pipeline].layout.raw();
            // SAFETY: the set was allocated with this layout's second set layout.
            unsafe { device.cmd_bind_descriptor_sets(raw, point, layout, 1, &[sets.raw(set)], &[]) };
            bound.material = Some(set);
        }
        let (piece, geometry, range) = data.meshes().drawn(batch.mesh);
        let (Some(vertices), Some(indices)) = (geometry.vertices(), geometry.indices()) else { return };
        let streams @ (offsets, count) = &self.stream_offsets[index];
        if bound.streams != Some((piece, *streams)) {
            let buffers = [vertices.raw(); super::MOST_STREAMS];
            // SAFETY: both lists are of one length, and offsets lie inside the buffer.
            unsafe { device.cmd_bind_vertex_buffers(raw, 0, &buffers[..*count], &offsets[..*count]) };
            bound.streams = Some((piece, *streams));
        }
        let width = range.index_width;
        if bound.indices != Some((piece, width)) {
            let offset = geometry.index_offset_bytes(width);
            // SAFETY: the offset lies inside the buffer and is a multiple of the index size.
            unsafe { device.cmd_bind_index_buffer(raw, indices.raw(), offset, width.index_type()) };
            bound.indices = Some((piece, width));
        }
    }
}

/// Where depth attachments are accessed.
const DEPTH_STAGES: vk::PipelineStageFlags = vk::PipelineStageFlags::from_raw(
    vk::PipelineStageFlags::EARLY_FRAGMENT_TESTS.as_raw()
        | vk::PipelineStageFlags::LATE_FRAGMENT_TESTS.as_raw(),
);

/// A tile, or a part of it, to be drawn.
struct Target<'a> {
    tile: usize,
    /// Of the shadow map or of the static map.
    framebuffer: &'a Owned<vk::Framebuffer>,
    /// What of the map is drawn.
    area: vk::Rect2D,
    /// What it begins as a copy of; `None`: as far away as can be.
    copied: Option<&'a StaticMap>,
    /// What is drawn into it.
    which: Which,
}

/// From being sampled to being drawn.
fn begin(recorder: &Recorder<'_>, image: &Image, in_use: bool) {
    let old = match in_use {
        true => vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
        false => vk::ImageLayout::UNDEFINED,
    };
    let depth = vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
    let access =
        vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_READ | vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_WRITE;
    // Earlier reads need the order of execution only; what earlier frames drew, they made visible themselves.
    let earlier = (vk::PipelineStageFlags::FRAGMENT_SHADER, vk::AccessFlags::empty(), old);
    barrier(recorder, image, earlier, (DEPTH_STAGES, access, depth));
}

/// From being drawn to being sampled.
fn end(recorder: &Recorder<'_>, image: &Image) {
    let (write, layout) =
        (vk::AccessFlags::DEPTH_STENCIL_ATTACHMENT_WRITE, vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL);
    let (stage, layout_read) =
        (vk::PipelineStageFlags::FRAGMENT_SHADER, vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
    let later = (stage, vk::AccessFlags::SHADER_READ, layout_read);
    barrier(recorder, image, (DEPTH_STAGES, write, layout), later);
}

type Use = (vk::PipelineStageFlags, vk::AccessFlags, vk::ImageLayout);

fn barrier(
    recorder: &Recorder<'_>,
    image: &Image,
    (src_stages, src_access, old): Use,
    (dst_stages, dst_access, new): Use,
) {
    let barrier = vk::ImageMemoryBarrier::default()
        .src_access_mask(src_access)
        .dst_access_mask(dst_access)
        .old_layout(old)
        .new_layout(new)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .image(image.raw())
        .subresource_range(image.range());
    let (device, raw, none) = (recorder.device().raw(), recorder.raw(), vk::DependencyFlags::empty());
    // SAFETY: recording, outside of a render pass; the image is alive.
    unsafe { device.cmd_pipeline_barrier(raw, src_stages, dst_stages, none, &[], &[], &[barrier]) };
}

/// What is bound while casters are drawn, in all tiles of a frame.
#[derive(Default)]
struct Bound {
    pipeline: Option<usize>,
    material: Option<usize>,
    /// With the piece of the meshes.
    streams: Option<(usize, ([u64; super::MOST_STREAMS], usize))>,
    /// Likewise.
    indices: Option<(usize, IndexWidth)>,
}
