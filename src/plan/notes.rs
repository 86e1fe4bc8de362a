//! Decisions that a reader may wonder about.

use super::layout::{GBuffer, LightPlace, LightTarget, Tells};
use super::{
    Attachment, Brdf, Format, LightFormat, LightWay, Needs, Options, Path, Translucency, path, refraction,
};

/// What a plan tells besides what it consists of.
pub(super) fn of(
    needs: &Needs,
    options: &Options,
    gbuffer: &GBuffer,
    path: Path,
    attachments: &[Attachment],
    folded: bool,
) -> Vec<String> {
    let mut notes = Vec::new();
    notes.extend(translucency(needs, options, gbuffer));
    let bends = attachments.iter().any(|a| a.name.contains("refracted_light"));
    notes.extend(refraction::note(needs, options, bends));
    if needs.anisotropy > 1 {
        notes.push(format!(
            "textures ask for anisotropy: a look-up of theirs may take up to {} samples, and Mali's samplers are larger",
            needs.anisotropy
        ));
    }
    if options.depth_prepass && needs.triangles <= 1 {
        notes.push("no triangle hides another: no depth test, so no depth pre-pass".into());
    }
    if options.show.is_debug() {
        return notes;
    }
    match options.brdf {
        _ if needs.lit.is_none() => {}
        Brdf::Exact => {}
        Brdf::Fitted => notes.push(
            "brdf fitted: a visibility term without square roots, and light from all around without a table".into(),
        ),
        Brdf::Mediump => notes.push(
            "brdf mediump: half floats by rounding, which shows their error and not their speed; roughness is at least 0.089".into(),
        ),
    }
    if needs.lit.is_none() {
        notes.push("nothing is lit: no G-buffer, no lighting, no light target".into());
    } else if path == Path::Forward {
        notes.extend(path::notes(options, path, folded));
    } else if folded && !needs.prelit.is_empty() {
        notes.push("one stage adds all light and applies the tone curve: nothing is blended".into());
    } else if folded {
        notes.push(
            "no light exists before lighting: lighting and tonemap are one subpass, no light target".into(),
        );
    } else {
        let clips = |light: &LightTarget| {
            let is_there =
                attachments.iter().any(|a| a.name == light.target.name && a.format == light.target.format);
            is_there && light.target.format == Format::Rgb10a2Unorm
        };
        let light = gbuffer.added_light(false).map(|(light, _)| light).filter(clips);
        if path == Path::Deferred && matches!(gbuffer.light, LightPlace::Read(_)) {
            notes.push(
                "light is added in the shader: each fragment reads and writes the words that hold it after the one before \
                 (VK_EXT_rasterization_order_attachment_access)"
                    .into(),
            );
        }
        notes.extend(light.map(|l| format!("the light target holds exposed light up to {}", l.range)));
        notes.extend(path::notes(options, path, folded));
        if !options.recycle {
            notes.push("recycling is off: every resource has an attachment of its own".into());
        } else if path == Path::Deferred && options.samples == 1 && !attachments[0].name.contains('/') {
            let base = gbuffer.surface.iter().find(|t| t.tells == Tells::Albedo).map(|t| t.format);
            let Some(base) = base else { return notes };
            notes.push(if !options.output_is_input_attachment {
                "the output cannot be read as an input attachment, so base_metallic has its own".into()
            } else if base != options.output.into() {
                let output = Format::from(options.output);
                format!("base_metallic is {base} and the output {output}, so they cannot share an attachment")
            } else {
                "the G-buffer is kept, so the output cannot stand in for base_metallic".into()
            });
        }
    }
    notes
}

/// What blended surfaces make of the frame.
fn translucency(needs: &Needs, options: &Options, gbuffer: &GBuffer) -> Option<String> {
    let (blended, (light, _)) = (needs.blended.as_ref()?, gbuffer.added_light(true)?);
    let layers = options.layers();
    let way = match options.translucency {
        Translucency::Sorted => {
            "objects from far to near by their centres, the triangles of one in the order of its mesh".into()
        }
        Translucency::Oit => format!(
            "the {layers} nearest layers of each pixel are kept apart, in the G-buffer's place where it has words of that size; of \
             more the farthest are merged"
        ),
        Translucency::Weighted => {
            "a mean of its layers by weight, none of which is in front of another".into()
        }
        Translucency::Peeled => {
            format!(
                "the {layers} farthest layers of each pixel one after the other, all drawn twice for each"
            )
        }
    };
    Some(format!(
        "{blended} is blended: {way}; the light target is {}, since every layer over it is rounded; what is blended casts no \
         shadow",
        light.target.format
    ))
}

/// What a chosen light target costs where lights are added to it one by one: each sum is rounded, so that what a dim light adds may
/// be lost (half floats keep 93 % of 1024 such lights, these formats nearly nothing: `ontile stability`).
pub(super) fn warning(needs: &Needs, options: &Options, path: Path, way: LightWay) -> Option<String> {
    let one_by_one = path == Path::ForwardMultipass || (path == Path::Deferred && way.is_one_by_one());
    let coarse = matches!(options.light_target, Some(LightFormat::Rgb10a2 | LightFormat::B10g11r11));
    if coarse && needs.blended.is_some() {
        return Some(
            "the chosen light target is rounded after each layer of what is blended: leave --light-target out for half floats"
                .into(),
        );
    }
    (one_by_one && coarse && needs.local_lights() > 1).then(|| {
        "the chosen light target is rounded after each light, and dim ones among many are lost: leave --light-target out for half \
         floats, or use --lights clusters"
            .into()
    })
}
