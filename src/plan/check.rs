//! What no plan can be made of.

use super::layout::{GBuffer, LightPlace};
use super::shadow::{LEAST_TEXELS, MOST_TEXELS};
use super::{Attachment, Limits, Needs, Options, Pass, Strategy, Translucency};

/// # Errors
/// [`crate::Error::Unsupported`] if no image can have this size in pixels.
pub(crate) fn check_size([width, height]: [u32; 2], limits: &Limits) -> crate::Result<()> {
    let most = limits.max_image_size;
    if width == 0 || height == 0 || width > most || height > most {
        return Err(crate::Error::unsupported(
            format!("an image of {width}x{height} pixels cannot be rendered"),
            format!("choose a size from 1x1 to {most}x{most}"),
        ));
    }
    Ok(())
}

pub(super) fn check_dither(options: &Options) -> crate::Result<()> {
    if options.dither && options.output.is_float() {
        return Err(crate::Error::unsupported(
            format!(
                "dither spreads the rounding to 8 bits, and the output {} is not rounded",
                options.output
            ),
            "render to a PNG (an 8-bit output), or leave dither out",
        ));
    }
    Ok(())
}

/// A range that sides of shadow maps and their tiles have to be in, whether or not the scene has shadows.
pub(super) fn check_shadows(options: &Options) -> crate::Result<()> {
    let shadows = &options.shadows;
    let check = |what: &str, texels: u32, most: u32| {
        if (LEAST_TEXELS..=most).contains(&texels) {
            return Ok(());
        }
        Err(crate::Error::unsupported(
            format!("{what} cannot have a side of {texels} texels"),
            format!("choose from {LEAST_TEXELS} to {most}; powers of two are used whole"),
        ))
    };
    check("a shadow map (--shadow-map)", shadows.most_texels, MOST_TEXELS)?;
    let tile = |texels| check("a tile of this shadow map (--shadow-tile)", texels, shadows.most_texels);
    shadows.tile_texels.map_or(Ok(()), tile)
}

pub(super) fn check_counts(
    passes: &[Pass],
    attachments: &[Attachment],
    strategy: Strategy,
    options: &Options,
    limits: &Limits,
) -> crate::Result<()> {
    // A rendering has all colour attachments of its stages at once, whichever of them a stage writes.
    for pass in passes.iter().filter(|_| strategy == Strategy::LocalRead) {
        let format = |i: usize| attachments[pass.attachments[i].attachment].format;
        let is_color = |&i: &usize| pass.is_on_tile(i) && !format(i).is_depth();
        let wanted = (0..pass.attachments.len()).filter(is_color).count();
        let most = limits.max_color_attachments;
        if wanted > most as usize {
            return Err(crate::Error::unsupported(
                format!(
                    "strategy local-read binds all {wanted} colour attachments of {} at once, the device allows {most}",
                    pass.name
                ),
                format!(
                    "use --strategy subpasses, which binds those of one stage, or another layout than {}",
                    options.layout
                ),
            ));
        }
    }
    for subpass in passes.iter().flat_map(|p| &p.subpasses) {
        let checks = [
            ("colour attachments", subpass.colors.len(), limits.max_color_attachments),
            ("input attachments", subpass.inputs.len(), limits.max_input_attachments),
        ];
        for (what, wanted, most) in checks {
            if wanted > most as usize {
                return Err(crate::Error::unsupported(
                    format!("subpass {} needs {wanted} {what}, the device allows {most}", subpass.name),
                    format!("choose another layout than {}", options.layout),
                ));
            }
        }
    }
    Ok(())
}

/// Whether what is blended can be drawn in the way asked for, and the light target holds what that takes.
pub(super) fn check_blended(
    gbuffer: &GBuffer,
    needs: &Needs,
    options: &Options,
    strategy: Strategy,
    limits: &Limits,
) -> crate::Result<()> {
    let most = match options.translucency {
        Translucency::Oit => 4,
        Translucency::Peeled => 16,
        Translucency::Sorted | Translucency::Weighted if options.translucency_layers.is_some() => 0,
        Translucency::Sorted | Translucency::Weighted => u32::MAX,
    };
    if !(1..=most).contains(&options.layers()) {
        return Err(crate::Error::unsupported(
            format!("translucency {} does not keep {} layers", options.translucency, options.layers()),
            "choose 1 to 4 with --translucency oit, 1 to 16 with peeled, and leave --translucency-layers out else",
        ));
    }
    let peels = needs.blended.is_some() && options.translucency == Translucency::Peeled;
    if peels && strategy == Strategy::LocalRead {
        return Err(crate::Error::unsupported(
            "translucency peeled finds layers in two depth attachments beside that of what is opaque, and a rendering has one \
             (VkRenderingInfo::pDepthAttachment)",
            "use --strategy subpasses, or another --translucency",
        ));
    }
    if needs.blended.is_some()
        && options.translucency == Translucency::Oit
        && !limits.ordered_attachment_access
    {
        return Err(crate::Error::unsupported(
            "translucency oit sorts layers in words that each fragment reads and writes; the device has no \
             rasterization-order attachment access (VK_EXT_rasterization_order_attachment_access) for that",
            "use --translucency weighted, which blends in any order, or sorted",
        ));
    }
    let has_alpha = gbuffer.added_light(true).is_none_or(|(light, _)| light.has_alpha());
    match (needs.over_light(), needs.background) {
        (Some(blended), Some(_)) if !has_alpha => Err(crate::Error::unsupported(
            format!(
                "light in b10g11r11 has no room for how much {blended} covers of the background's colour"
            ),
            "use --light-target rgba16f",
        )),
        _ => Ok(()),
    }
}

/// Whether the layout has a place for the light of this frame.
pub(super) fn check_light(
    gbuffer: &GBuffer,
    needs: &Needs,
    options: &Options,
    one_by_one: bool,
    limits: &Limits,
) -> crate::Result<()> {
    let layout = gbuffer.layout;
    let refused = |problem: String, remedy: &str| Err(crate::Error::unsupported(problem, remedy.to_owned()));
    let LightPlace::Added { .. } = gbuffer.light else {
        match gbuffer.light {
            LightPlace::Read(_) if one_by_one && !limits.ordered_attachment_access => {
                let problem = format!(
                    "layout {layout} holds light in words, to which lights that come one by one are added in the shader; the device has no \
                     rasterization-order attachment access (VK_EXT_rasterization_order_attachment_access) for that"
                );
                return refused(
                    problem,
                    "use --lights clusters or fullscreen and shadow maps, or --layout ontile128",
                );
            }
            LightPlace::Read(_) if one_by_one => return Ok(()),
            _ if one_by_one => {
                let problem =
                    format!("layout {layout} has no light target to which lights could be added one by one");
                return refused(
                    problem,
                    "use --lights clusters or fullscreen and shadow maps, or --layout ontile128",
                );
            }
            _ => {}
        }
        if !options.fold {
            let problem = format!("layout {layout} has no light target between lighting and tonemap");
            return refused(problem, "leave --no-fold out, or use --layout ontile128");
        }
        return match (gbuffer.light, needs.prelit.first()) {
            (LightPlace::Nowhere, Some(why)) => {
                let problem =
                    format!("layout {layout} has no place for light that exists before lighting: {why}");
                refused(problem, "use --layout ontile96 or packed128")
            }
            _ => Ok(()),
        };
    };
    let has_alpha = gbuffer.added_light(one_by_one).is_none_or(|(light, _)| light.has_alpha());
    if !has_alpha && !gbuffer.form.has_depth() && (needs.fog.is_some() || needs.background.is_some()) {
        let problem = format!(
            "layout {layout} with light in b10g11r11 cannot tell surfaces from the background, which fog and background colour need"
        );
        return refused(problem, "use --light-target rgba16f");
    }
    Ok(())
}
