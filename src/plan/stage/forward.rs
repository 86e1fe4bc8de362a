//! Surfaces that are lit as they are drawn, or not at all.

use super::depth::Depth;
use super::{Asked, Frame, Use, added_light, translucency};

/// All at once, the tone curve too, unless something is blended over it.
pub(super) fn add(frame: &mut Frame, asked: &Asked, depth: &Depth, name: &'static str, why: String) {
    if let Some(why_light) = asked.over_light() {
        let light = added_light(asked.gbuffer, false).0;
        let light = frame.add_target(&light.target, false, why_light);
        if asked.needs.background.is_some() {
            frame.resources[light].holds = Asked::LIGHT_AND_BACKGROUND;
        }
        if asked.needs.opaque_triangles() > 0 || asked.needs.sky {
            frame.add_stage(name, [(light, Use::Write)].into_iter().chain(depth.drawn), why);
        }
        let lights = translucency::add(frame, asked, &[light], depth, &[]);
        let read = lights.into_iter().map(|light| (light, Use::Read));
        let sum = "the tone curve is of what is blended".into();
        frame.add_stage("tonemap", [(Frame::OUTPUT, Use::Write)].into_iter().chain(read), sum);
        return;
    }
    // Nothing covers the whole image, so the output itself must be cleared.
    let [red, green, blue] = asked.needs.background.unwrap_or_default();
    frame.resources[Frame::OUTPUT].clear = Some([red, green, blue, 1.0]);
    frame.add_stage(name, [(Frame::OUTPUT, Use::Write)].into_iter().chain(depth.drawn), why);
    frame.folded = true;
}

/// A pass of its own for each light.
pub(super) fn add_multipass(frame: &mut Frame, asked: &Asked, depth: &Depth) {
    let needs = asked.needs;
    let light = added_light(asked.gbuffer, true).0;
    let light = frame.add_target(&light.target, false, "lights are summed one by one".into());
    if needs.background.is_some() {
        frame.resources[light].holds = Asked::LIGHT_AND_BACKGROUND;
    }
    let base = if needs.prelit.is_empty() {
        "surfaces without their lights, and their depth".into()
    } else {
        needs.prelit.join(", ")
    };
    frame.add_stage("geometry", [(light, Use::Write)].into_iter().chain(depth.drawn), base);
    let each = format!("{}; each adds to the surfaces that it reaches", asked.lights());
    let test = depth.resource.map(|depth| (depth, Use::DepthTest));
    frame.add_stage("lights", [(light, Use::Blend)].into_iter().chain(test), each);
    let lights = translucency::add(frame, asked, &[light], depth, &[]);
    let read = lights.into_iter().map(|light| (light, Use::Read));
    let sum = "light from several draws was summed".into();
    frame.add_stage("tonemap", [(Frame::OUTPUT, Use::Write)].into_iter().chain(read), sum);
}
