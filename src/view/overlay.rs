//! The interface over the picture: what the user does with it, and the triangles that it is.
//!
//! The library that makes them mixes its colours as displays encode them, the pass as light: half-transparent panels and the edges of
//! letters come out lighter than elsewhere, and nothing needs a copy of the picture.

use egui::epaint::ClippedShape;
use egui::{ClippedPrimitive, Rect, TextureId, ViewportId, epaint};
use egui_winit::EventResponse;
use winit::event::WindowEvent;
use winit::window::Window;

use super::outline::Outlines;
use super::panels::{Asked, Panels, Shows};
use crate::Result;
use crate::gpu::{OverlayFrame, OverlayPart, OverlayVertex, Renderer, Target, View};

/// Interface, input and the triangles of the last frame.
pub(super) struct Overlay {
    context: egui::Context,
    input: egui_winit::State,
    panels: Panels,
    outlines: Outlines,
    /// Of the last [`Self::lay_out`].
    panel_shapes: Vec<ClippedPrimitive>,
    atlas: Atlas,
    vertices: Vec<OverlayVertex>,
    indices: Vec<u32>,
    parts: Vec<OverlayPart>,
    pixels_per_point: f32,
}

/// Letters, as white and alpha.
#[derive(Default)]
struct Atlas {
    size: [usize; 2],
    texels: Vec<u8>,
    /// The renderer has another one.
    has_changed: bool,
}

impl Overlay {
    pub(super) fn new(window: &Window, most_texels: u32) -> Self {
        let context = egui::Context::default();
        let scale = window.scale_factor() as f32;
        let most = Some(most_texels as usize);
        let input =
            egui_winit::State::new(context.clone(), ViewportId::ROOT, window, Some(scale), None, most);
        Self {
            context,
            input,
            panels: Panels::default(),
            outlines: Outlines::default(),
            panel_shapes: Vec::new(),
            atlas: Atlas::default(),
            vertices: Vec::new(),
            indices: Vec::new(),
            parts: Vec::new(),
            pixels_per_point: scale,
        }
    }

    /// Whether an event is for the interface, and not for the camera.
    pub(super) fn event(&mut self, window: &Window, event: &WindowEvent) -> bool {
        let EventResponse { consumed, .. } = self.input.on_window_event(window, event);
        match event {
            // It knows of a finger's place only with the next frame.
            WindowEvent::Touch(touch) => {
                let place = touch.location.to_logical::<f32>(f64::from(self.pixels_per_point));
                let layer = self.context.layer_id_at(egui::pos2(place.x, place.y));
                consumed || layer.is_some_and(|layer| layer.order != egui::Order::Background)
            }
            _ => consumed,
        }
    }

    /// Has its image set again: there is a new renderer.
    pub(super) fn renew(&mut self) {
        self.atlas.has_changed = true;
    }

    /// Whether [`Self::set_image`] has something to do, for which no frame may be on the GPU.
    pub(super) fn has_new_image(&self) -> bool {
        self.atlas.has_changed && !self.atlas.texels.is_empty()
    }

    pub(super) fn set_image(&self, renderer: &mut Renderer) -> Result<()> {
        renderer.set_overlay_image(self.atlas.size.map(|n| n as u32), &self.atlas.texels)
    }

    /// All that draw it have its image.
    pub(super) fn image_is_set(&mut self) {
        self.atlas.has_changed = false;
    }

    /// The triangles of the last [`Self::lay_out`] and [`Self::outline`].
    pub(super) fn frame(&self) -> OverlayFrame<'_> {
        OverlayFrame {
            vertices: &self.vertices,
            indices: &self.indices,
            parts: &self.parts,
            pixels_per_point: self.pixels_per_point,
        }
    }

    /// Makes the next frame's interface, and says what the user asked for.
    pub(super) fn lay_out(&mut self, window: &Window, shows: &Shows<'_>) -> Asked {
        let input = self.input.take_egui_input(window);
        let mut asked = Asked::default();
        let panels = &mut self.panels;
        let output = self.context.run(input, |context| asked = panels.show(context, shows));
        self.input.handle_platform_output(window, output.platform_output);
        for (texture, delta) in output.textures_delta.set {
            if texture == TextureId::default() {
                self.atlas.change(&delta);
            }
        }
        self.pixels_per_point = output.pixels_per_point;
        self.panel_shapes = self.context.tessellate(output.shapes, output.pixels_per_point);
        self.outlines = shows.outlines;
        self.clear();
        self.gather_panels();
        asked
    }

    /// Outlines what the renderer's next frame of this view is lit by, below the panels.
    pub(super) fn outline(&mut self, renderer: &mut Renderer, target: &Target, view: &View<'_>) {
        if self.outlines == Outlines::default() {
            return;
        }
        let (context, ppp) = (&self.context, self.pixels_per_point);
        let seen = renderer.see_lights(target, view);
        let mut shapes = Vec::new();
        self.panels.outlined = self.outlines.draw(&seen, view.camera, ppp, context, &mut shapes);
        let clip_rect = Rect::EVERYTHING;
        let clipped = shapes.into_iter().map(|shape| ClippedShape { clip_rect, shape }).collect();
        let outlines = context.tessellate(clipped, ppp);
        self.clear();
        self.gather(&outlines);
        self.gather_panels();
    }

    fn clear(&mut self) {
        self.vertices.clear();
        self.indices.clear();
        self.parts.clear();
    }

    fn gather_panels(&mut self) {
        let shapes = std::mem::take(&mut self.panel_shapes);
        self.gather(&shapes);
        self.panel_shapes = shapes;
    }

    fn gather(&mut self, shapes: &[ClippedPrimitive]) {
        let pixel = |points: f32| (points * self.pixels_per_point).round().max(0.0) as u32;
        for ClippedPrimitive { clip_rect, primitive } in shapes {
            let epaint::Primitive::Mesh(mesh) = primitive else { continue };
            let first = self.indices.len() as u32;
            let before = self.vertices.len() as u32;
            self.vertices.extend_from_slice(bytemuck::cast_slice(&mesh.vertices));
            self.indices.extend(mesh.indices.iter().map(|index| before + index));
            let clip_px = [clip_rect.min.x, clip_rect.min.y, clip_rect.max.x, clip_rect.max.y].map(pixel);
            self.parts.push(OverlayPart { clip_px, indices: first..self.indices.len() as u32 });
        }
    }
}

impl Atlas {
    fn change(&mut self, delta: &epaint::ImageDelta) {
        let epaint::ImageData::Color(image) = &delta.image;
        let texels: &[u8] = bytemuck::cast_slice(&image.pixels);
        let row = 4 * image.size[0];
        match delta.pos {
            None => (self.size, self.texels) = (image.size, texels.to_vec()),
            Some([x, y]) => {
                for (i, content) in texels.chunks_exact(row.max(1)).enumerate() {
                    let at = 4 * ((y + i) * self.size[0] + x);
                    self.texels[at..at + row].copy_from_slice(content);
                }
            }
        }
        self.has_changed = true;
    }
}
