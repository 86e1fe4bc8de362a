//! What is painted over the G-buffer before it is lit.

use super::depth::Depth;
use super::{Asked, Frame, Stage, Use};
use crate::plan::DecalWay;
use crate::plan::decals::{Channels, channels, held};

/// The stage, where the scene has decals. Targets that some decal changes are read and written, and what tells places and normals
/// is read; other targets stay out of it. `surface` are the G-buffer's resources.
pub(super) fn stage(frame: &Frame, asked: &Asked, depth: &Depth, surface: &[usize]) -> Option<Stage> {
    let changes = match asked.decals? {
        DecalWay::RasterOrder | DecalWay::Auto => Use::Modify,
        DecalWay::Barrier => Use::Rewrite,
        DecalWay::Fixed => Use::Blend,
    };
    let painted = channels(asked.needs);
    // Products of the two: either changes both.
    let of_color = Channels { base_color: true, metallic: true, ..Channels::default() };
    let has_products = asked.gbuffer.has_products();
    let painted = if has_products && painted.meets(of_color) { painted.or(of_color) } else { painted };
    let how = |&r: &usize| {
        let (is_position, holds) = held(asked.gbuffer.form, frame.resources[r].name);
        let is_read = is_position || holds.normal;
        let is_changed = holds.meets(painted);
        (is_changed || is_read).then_some((r, if is_changed { changes } else { Use::Read }))
    };
    let read = depth.resource.filter(|_| depth.is_read).map(|depth| (depth, Use::Read));
    let test = depth.resource.map(|depth| (depth, Use::DepthTest));
    let count = asked.needs.decals.iter().map(|need| need.decals).sum::<usize>();
    let order = match changes {
        Use::Modify => "each reads what those before have left, in the order of rasterisation",
        Use::Rewrite => "each reads what those before have left, after a barrier where they overlap",
        _ => "mixed by fixed-function blending",
    };
    Some(Stage {
        name: "decals",
        uses: read.into_iter().chain(surface.iter().filter_map(how)).chain(test).collect(),
        why: format!(
            "{}: {painted}, before surfaces are lit; {order}",
            match count {
                1 => format!("{} paints", asked.needs.decals[0].why),
                _ => format!("{count} decals paint"),
            },
        ),
    })
}
