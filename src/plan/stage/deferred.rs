//! Surfaces that are lit once all are known, from a G-buffer.

use super::decals;
use super::depth::Depth;
use super::{Asked, Frame, Stage, Use, added_light, show, translucency};
use crate::plan::layout::{LightPlace, Target, Tells};
use crate::plan::{Edges, Format, Layout};

/// Where triangles cover a part of a pixel.
const EDGE: Target = Target {
    name: "edge",
    format: Format::R8Unorm,
    holds: "r: 1 where a triangle covers some samples only, 1/2 where an alpha mask may",
    used_bits: 2,
    clear: Some([0.0; 4]),
    tells: Tells::Surface,
};

/// How much of the light from all around arrives, where that is added in lighting.
const OCCLUSION: Target = Target {
    name: "occlusion",
    format: Format::R8Unorm,
    holds: "r: the share of light from all around that arrives",
    used_bits: 8,
    clear: None,
    tells: Tells::Surface,
};

/// Geometry, lighting and, where light is summed before it, the tone curve. `lit` is the first lit material.
pub(super) fn add(frame: &mut Frame, asked: &Asked, depth: &Depth, lit: &str) {
    let Asked { needs, options, gbuffer, way, edges, .. } = *asked;
    let one_by_one = asked.one_by_one();
    let in_gbuffer = matches!(gbuffer.light, LightPlace::Read(_));
    let light_read = in_gbuffer && (one_by_one || !needs.prelit.is_empty());
    let folded = match gbuffer.light {
        LightPlace::Added { .. } => {
            needs.prelit.is_empty() && needs.over_light().is_none() && asked.may_fold() && !one_by_one
        }
        LightPlace::Read(_) => !one_by_one,
        LightPlace::Nowhere => true,
    };
    let mut surface: Vec<_> = gbuffer
        .surface
        .iter()
        .map(|t| {
            frame.add_target(t, options.keep_gbuffer, format!("lighting reads it for lit surfaces ({lit})"))
        })
        .collect();
    let mut light_why = needs.prelit.clone();
    light_why.extend(one_by_one.then(|| "lights are added one by one, each rounded".into()));
    light_why.extend(asked.over_light());
    if light_why.is_empty() {
        light_why.push("lighting and tonemap are kept apart on request".into());
    }
    let light_why = light_why.join(", ");
    if let LightPlace::Read(Some(word)) = &gbuffer.light
        && light_read
    {
        let word = if one_by_one { &word.one_by_one } else { &word.once };
        surface.push(frame.add_target(word, options.keep_gbuffer, light_why.clone()));
    }
    let (light, split) = added_light(gbuffer, one_by_one);
    let other =
        Target { name: "specular_light", holds: "rgb: exposed light but for diffuse light", ..light.target };
    let targets = [Some(light.target), split.then_some(other)];
    // What light is added to in the shader.
    let modified: Vec<_> = match gbuffer.light {
        _ if folded => Vec::new(),
        LightPlace::Read(Some(_)) => surface.last().copied().into_iter().collect(),
        LightPlace::Read(None) => surface.clone(),
        _ => Vec::new(),
    };
    let lights_added: Vec<_> = if folded || in_gbuffer {
        Vec::new()
    } else {
        targets
            .iter()
            .flatten()
            .map(|t| frame.add_target(t, options.keep_gbuffer, light_why.clone()))
            .collect()
    };
    // What tells the light of surfaces from the background, and where fog begins.
    let has_fog = needs.fog.is_some();
    let tells_background = has_fog || needs.background.is_some();
    let by_depth = !light.has_alpha() && tells_background;
    let positions: Vec<_> = {
        let told = |tells| {
            let targets = gbuffer.surface.iter().zip(&surface);
            targets.filter(move |(t, _)| t.tells == tells).map(|(_, &r)| r)
        };
        let albedo = told(Tells::Albedo).filter(|_| split);
        let read = depth.resource.filter(|_| depth.is_read).into_iter();
        let of_position = read.chain(told(Tells::Position)).filter(|r| !modified.contains(r));
        let is_wanted = has_fog || by_depth || (in_gbuffer && tells_background);
        of_position.filter(|_| is_wanted).chain(albedo).collect()
    };
    if light_read && tells_background {
        // The layouts that do not say it otherwise read it from depth.
        for &r in &surface {
            if frame.resources[r].name == "depth" {
                frame.resources[r].clear = Some([0.0; 4]);
            }
        }
    }
    if !folded {
        for &r in &positions {
            let why = match (has_fog, asked.fogs_last()) {
                (true, true) => ", and tonemap for fog",
                (true, false) => ", and translucency for fog",
                _ => ", and tonemap",
            };
            frame.resources[r].why += why;
            if by_depth {
                frame.resources[r].clear = Some([0.0; 4]);
            }
        }
        if let Some(&last) = lights_added.last()
            && light.has_alpha()
            && tells_background
        {
            frame.resources[last].holds = Asked::LIGHT_AND_BACKGROUND;
        }
    }

    let edge = (edges == Edges::Coverage).then(|| {
        let why = "triangles that cover a part of a pixel's samples say so".to_owned();
        frame.add_target(&EDGE, false, why)
    });
    let occlusion = needs.occlusion.as_ref().map(|occluded| {
        let why =
            format!("{occluded} is occluded, and decals are painted before light from all around is added");
        let format = if gbuffer.layout == Layout::Exact { Format::R32Float } else { OCCLUSION.format };
        frame.add_target(&Target { format, used_bits: format.bits(), ..OCCLUSION }, false, why)
    });
    let masks = needs.kinds.iter().any(|need| need.kind.alpha_mask);
    if edges == Edges::Compare || (edges == Edges::Coverage && masks) {
        // Samples are compared, and those of no surface are to agree: what they hold would mark them at random.
        for &r in surface.iter().chain(&occlusion) {
            frame.resources[r].clear.get_or_insert([0.0; 4]);
        }
    }
    let written =
        surface.iter().chain(&lights_added).chain(&edge).chain(&occlusion).map(|&r| (r, Use::Write));
    let geometry = Stage {
        name: "geometry",
        uses: written.chain(depth.drawn).collect(),
        why: format!(
            "{} of surface in the G-buffer",
            if needs.kinds.len() == 1 { "1 kind".into() } else { format!("{} kinds", needs.kinds.len()) }
        ),
    };
    let depth_read = depth.resource.filter(|_| depth.is_read);
    if options.show.is_debug() {
        let targets = depth_read.iter().chain(&surface).chain(&edge).chain(&occlusion).chain(&lights_added);
        let targets: Vec<_> = targets.copied().collect();
        let decals = decals::stage(frame, asked, depth, &surface);
        frame.stages.extend(std::iter::once(geometry).chain(decals));
        show::add(frame, asked, depth, &targets, folded);
        frame.folded = folded;
        return;
    }
    let marks_edges = edges != Edges::All;
    let test = if asked.has_stencil() || marks_edges { Use::Stencil } else { Use::DepthTest };
    let test = depth.resource.filter(|_| one_by_one || marks_edges).map(|depth| (depth, test));
    let how = |r: &usize| (*r, if modified.contains(r) { Use::Modify } else { Use::Read });
    let read = depth_read.iter().chain(&surface).chain(&edge).chain(&occlusion).map(how).chain(test);
    let adds = |r: &usize| (*r, Use::Blend);
    let lighting = Stage {
        name: "lighting",
        uses: match folded {
            false => lights_added.iter().map(adds).chain(read).collect(),
            true => std::iter::once((Frame::OUTPUT, Use::Write)).chain(read).collect(),
        },
        why: format!(
            "{}{}{}{}",
            asked.lights(),
            if needs.painted_around.any() {
                ", and light from all around on what decals have painted"
            } else {
                ""
            },
            match (way.is_one_by_one(), in_gbuffer) {
                (true, true) => ", each where its volume is, added in the shader in the order of drawing",
                (true, false) => ", each where its volume is",
                (false, _) => "",
            },
            match (folded, light_read) {
                (true, true) => "; applies the tone curve too, since it is the only one to add light",
                (true, false) => {
                    "; applies the tone curve too, since no light is summed before it"
                }
                (false, _) => "",
            }
        ),
    };
    // Albedo is for the last stage.
    let albedo = |r: &usize| {
        gbuffer.surface.iter().any(|t| t.tells == Tells::Albedo && t.name == frame.resources[*r].name)
    };
    let (of_tonemap, of_fog): (Vec<usize>, Vec<usize>) =
        positions.iter().copied().partition(|r| asked.fogs_last() || !has_fog || albedo(r));
    let decals = decals::stage(frame, asked, depth, &surface);
    frame.stages.extend([Some(geometry), decals, Some(lighting)].into_iter().flatten());
    // Of eight words the first four hold the position.
    let of_fog: Vec<_> = of_fog.into_iter().filter(|&r| frame.resources[r].name != "more_words").collect();
    let lights = translucency::add(frame, asked, &lights_added, depth, &of_fog);
    let tonemap = (!folded).then(|| Stage {
        name: "tonemap",
        uses: std::iter::once((Frame::OUTPUT, Use::Write))
            .chain(modified.iter().chain(&lights).chain(&of_tonemap).map(|&r| (r, Use::Read)))
            .collect(),
        why: if asked.fogs_last() {
            "light from several stages was summed; fog goes by the depth of what sent it".into()
        } else {
            "light from several stages was summed".into()
        },
    });
    frame.stages.extend(tonemap);
    frame.folded = folded;
}
