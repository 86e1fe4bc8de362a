//! What a frame left in its G-buffer, as the reference reads it.

use glam::DVec4;

use crate::Result;
use crate::gpu::Offscreen;
use crate::plan::LightPlace;
use crate::reference::Stored;

/// The G-buffer of the last frame, which was kept ([`Options::keep_gbuffer`](crate::plan::Options::keep_gbuffer)); one element a
/// pixel, rows from the top. `dark` is a frame of the same scene without its lights: there the light target still holds what
/// geometry wrote. It is needed where the plan has a light target.
///
/// # Errors
/// As [`Offscreen::attachment`].
pub fn stored(offscreen: &Offscreen, dark: Option<&Offscreen>) -> Result<Vec<Stored>> {
    let plan = offscreen.renderer().plan();
    let gbuffer = &plan.gbuffer;
    let depth = gbuffer.form.has_depth().then(|| offscreen.attachment("depth")).transpose()?;
    let word = match &gbuffer.light {
        LightPlace::Read(word) if plan.light_is_read() => word.as_ref(),
        _ => None,
    };
    let surface = gbuffer.surface.iter().chain(word).map(|t| t.name).filter(|name| *name != "depth");
    let targets = surface.map(|name| offscreen.attachment(name)).collect::<Result<Vec<_>>>()?;
    let is_split = matches!(gbuffer.light, LightPlace::Added { split: true, .. });
    let light = if is_split { "specular_light" } else { "light" };
    let light = dark.map(|dark| dark.attachment(light)).transpose()?;
    let texel = |values: Option<&Vec<f64>>, i: usize| {
        values.map_or(DVec4::ZERO, |values| DVec4::from_slice(&values[4 * i..]))
    };
    let pixels = targets.first().map_or(0, |values| values.len() / 4);
    let pixel = |i| Stored {
        depth: texel(depth.as_ref(), i).x,
        targets: std::array::from_fn(|t| texel(targets.get(t), i)),
        light: texel(light.as_ref(), i).truncate(),
    };
    Ok((0..pixels).map(pixel).collect())
}
