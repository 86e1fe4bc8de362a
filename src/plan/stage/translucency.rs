//! Surfaces that are blended over what is behind them, once that is lit and before the tone curve.

use super::depth::Depth;
use super::{Asked, Frame, Use};
use super::{media, particles};
use crate::plan::layout::{Target, Tells};
use crate::plan::{Format, Translucency};

/// The name of stages that blend over the light.
pub const NAME: &str = "translucency";

/// Of the one that fogs what is behind, where that is not the same.
pub const FOG: &str = "fog";

/// Of the one that collects layers.
pub const LAYERS: &str = "layers";

/// Of those that look for the next layer.
pub const PEEL: &str = "peel";

/// Adds what it takes where a surface is blended, light goes through one, or particles add light. `lights` are the targets that hold
/// light so far, and `positions` what tells fog where the G-buffer's surfaces are. Returns the targets that hold light then.
pub(super) fn add(
    frame: &mut Frame,
    asked: &Asked,
    lights: &[usize],
    depth: &Depth,
    positions: &[usize],
) -> Vec<usize> {
    let Some(first) = asked.needs.over_light() else { return lights.to_vec() };
    let needs = asked.needs;
    let alone = needs.blended.is_some() && needs.transmits.is_none();
    let sorted = alone && asked.options.translucency == Translucency::Sorted;
    if !(sorted || positions.is_empty()) {
        let over = lights.iter().map(|&light| (light, Use::Blend));
        let read = positions.iter().map(|&position| (position, Use::Read));
        let test = depth.resource.map(|depth| (depth, Use::DepthTest));
        let why = format!("what is behind {first} is fogged before it is covered");
        frame.add_stage(FOG, over.chain(read).chain(test), why);
    }
    let media::Behind { lights, depth } = media::add(frame, asked, lights, depth);
    if let Some(blended) = &asked.needs.blended {
        let positions = if sorted { positions } else { &[] };
        add_blended(frame, asked, blended, &lights, (depth, positions));
    }
    particles::add(frame, asked, &lights, depth);
    lights
}

fn add_blended(
    frame: &mut Frame,
    asked: &Asked,
    blended: &str,
    lights: &[usize],
    (depth, positions): (Option<usize>, &[usize]),
) {
    let lights: Vec<_> = lights.iter().map(|&light| (light, Use::Blend)).collect();
    let read = positions.iter().map(|&position| (position, Use::Read));
    let test = depth.map(|depth| (depth, Use::DepthTest));
    match asked.options.translucency {
        Translucency::Sorted => {
            let fog = if positions.is_empty() { "" } else { "; what is behind is fogged before" };
            let why = format!("{blended} is blended over what is lit behind it, from far to near{fog}");
            frame.add_stage(NAME, lights.into_iter().chain(read).chain(test), why);
        }
        Translucency::Oit => {
            let layers = add_layers(frame, asked, blended);
            let modified = layers.iter().map(|&layer| (layer, Use::Modify)).chain(test);
            let why = format!("layers of {blended} are sorted in each pixel, whatever the order of drawing");
            collect(frame, LAYERS, modified, why, &layers.iter().map(|&l| (l, [0.0; 4])).collect::<Vec<_>>());
            let read = layers.iter().map(|&layer| (layer, Use::Read));
            let why = "the layers of each pixel are blended over its light".into();
            frame.add_stage(NAME, lights.into_iter().chain(read), why);
        }
        Translucency::Weighted => {
            let mut add = |name, format, holds, used_bits| {
                let target = Target { name, format, holds, used_bits, clear: None, tells: Tells::Surface };
                frame.add_target(&target, false, format!("{blended} is summed by weight"))
            };
            let holds = "rgb: sum of light * alpha * weight, a: what is left of what is behind";
            let sum = add("weighted_light", Format::Rgba16Float, holds, 64);
            let weights = add("weights", Format::R16Float, "r: sum of alpha * weight", 16);
            let why = format!("layers of {blended} are summed by weight, whatever the order of drawing");
            let added = [(sum, Use::Blend), (weights, Use::Blend)].into_iter().chain(test);
            collect(frame, LAYERS, added, why, &[(sum, [0.0, 0.0, 0.0, 1.0]), (weights, [0.0; 4])]);
            let read = [(sum, Use::Read), (weights, Use::Read)];
            let why = "the mean of the layers is blended over the light".into();
            frame.add_stage(NAME, lights.into_iter().chain(read), why);
        }
        Translucency::Peeled => {
            let found = ["peel_a", "peel_b"].map(|name| {
                let target = Target {
                    name,
                    format: Format::D32Float,
                    holds: "reversed device depth of every other layer, the farthest first",
                    used_bits: 32,
                    clear: None,
                    tells: Tells::Position,
                };
                frame.add_target(&target, false, format!("{blended} is peeled layer by layer"))
            });
            let layers = asked.options.layers();
            for layer in 0..layers as usize {
                let [this, last] = [found[layer % 2], found[(layer + 1) % 2]];
                let behind = if layer == 0 { depth } else { Some(last) };
                let behind = behind.map(|behind| (behind, Use::Read));
                let why = format!("the farthest of {blended} that is before layer {layer} of {layers}");
                let uses = [(this, Use::Depth)].into_iter().chain(behind);
                collect(frame, PEEL, uses, why, &[(this, [1.0; 4])]);
                let why = format!("layer {} is blended over what is behind it", layer + 1);
                frame.add_stage(NAME, lights.iter().copied().chain([(this, Use::DepthTest)]), why);
            }
        }
    }
}

/// Words for the layers: four in an attachment, which are two layers, where the G-buffer has such words, so that these can be
/// used again; else two.
fn add_layers(frame: &mut Frame, asked: &Asked, blended: &str) -> Vec<usize> {
    let layers = asked.options.layers();
    let pairs = asked.gbuffer.has_four_words();
    let names = ["layer_0", "layer_1", "layer_2", "layer_3"];
    let (format, holds, each) = match pairs {
        true => (Format::Rgba32Uint, "two layers: light (e5b9g9r9), depth 24, alpha 8", 2),
        false => (Format::Rg32Uint, "a layer: light (e5b9g9r9), depth 24, alpha 8", 1),
    };
    let names = names.iter().take(layers.div_ceil(each) as usize);
    let add = |name| {
        let target =
            Target { name, format, holds, used_bits: format.bits(), clear: None, tells: Tells::Surface };
        frame.add_target(&target, false, format!("{layers} layers of {blended} are kept apart"))
    };
    names.copied().map(add).collect()
}

/// A stage that begins by clearing.
fn collect(
    frame: &mut Frame,
    name: &'static str,
    uses: impl IntoIterator<Item = (usize, Use)>,
    why: String,
    clears: &[(usize, [f32; 4])],
) {
    let stage = frame.stages.len();
    frame.clears.extend(clears.iter().map(|&(resource, value)| (stage, resource, value)));
    frame.add_stage(name, uses, why);
}
