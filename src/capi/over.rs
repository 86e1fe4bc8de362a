//! What a host draws over the picture, in the same pass.

use bytemuck::{Pod, Zeroable};

use super::call::{OntileResult, call, get_mut, list};
use super::frame::{OntileRenderer, check_slot};
use crate::gpu::{OverlayFrame, OverlayPart, OverlayVertex};

/// A corner of a triangle that is drawn over the picture.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct OntileOverlayVertex {
    /// From the left upper corner of the picture, points.
    pub position: [f32; 2],
    /// Where in the overlay's image: 0 to 1.
    pub texcoord: [f32; 2],
    /// RGBA that the image's is multiplied by: encoded as sRGB and multiplied by alpha after that.
    pub color: [u8; 4],
}

/// Triangles that one draw draws.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct OntileOverlayPart {
    /// What of the picture they may cover: left, top, right and bottom, pixels.
    pub clip_px: [u32; 4],
    /// Their first index.
    pub first_index: u32,
    /// Three a triangle.
    pub index_count: u32,
}

/// Sets the image that an overlay's triangles take their colours from: RGBA, encoded as sRGB and multiplied by alpha after that, 4 bytes a
/// texel, row by row from the top. At first it is one white texel. It waits until that is copied, and no frame of the renderer is on the GPU.
///
/// # Safety
/// `renderer` is valid, and there are `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_renderer_set_overlay_image(
    renderer: *mut OntileRenderer,
    width: u32,
    height: u32,
    texels: *const u8,
    size: usize,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        let (renderer, texels) = unsafe { (get_mut(renderer, "renderer")?, list(texels, size, "texels")?) };
        Ok(renderer.renderer.set_overlay_image([width, height], texels)?)
    })
}

/// Sets what is drawn over the frames that are recorded with this slot, in order, in the frame's own pass; the option "overlay" is "true".
/// The GPU has finished the frame that was recorded with the slot before. Vertices are in points, of `pixels_per_point` pixels.
///
/// # Safety
/// `renderer` is valid, and the lists are as long as said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_renderer_set_overlay(
    renderer: *mut OntileRenderer,
    slot: u32,
    vertices: *const OntileOverlayVertex,
    vertex_count: usize,
    indices: *const u32,
    index_count: usize,
    parts: *const OntileOverlayPart,
    part_count: usize,
    pixels_per_point: f32,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        let (OntileRenderer { renderer, overlay_parts }, vertices, indices, parts) = unsafe {
            (
                get_mut(renderer, "renderer")?,
                list(vertices, vertex_count, "vertices")?,
                list(indices, index_count, "indices")?,
                list(parts, part_count, "parts")?,
            )
        };
        check_slot(renderer, slot)?;
        overlay_parts.clear();
        overlay_parts.extend(parts.iter().map(|part| OverlayPart {
            clip_px: part.clip_px,
            indices: part.first_index..part.first_index.saturating_add(part.index_count),
        }));
        let vertices: &[OverlayVertex] = bytemuck::cast_slice(vertices);
        let frame = OverlayFrame { vertices, indices, parts: overlay_parts, pixels_per_point };
        Ok(renderer.set_overlay(slot as usize, &frame)?)
    })
}
