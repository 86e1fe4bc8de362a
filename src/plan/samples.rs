//! Several samples a pixel: which plans can have them.

use super::{Format, Limits, Options, Pass, Path, Plan, ResolveWay, Subpass};
use crate::Error;

/// # Errors
/// [`Error::Unsupported`] for a number of samples that no device has, or that goes with none of the other options.
pub(super) fn check(options: &Options, path: Path, folded: bool) -> crate::Result<()> {
    let samples = options.samples;
    if ![1, 2, 4, 8].contains(&samples) {
        return Err(Error::unsupported(
            format!("a pixel cannot have {samples} samples"),
            "choose 1, 2, 4 or 8 (--samples)",
        ));
    }
    if samples == 1 {
        return Ok(());
    }
    if options.keep_gbuffer {
        return Err(Error::unsupported(
            format!(
                "a G-buffer of {samples} samples a pixel cannot be kept: images of several samples cannot be copied out"
            ),
            "leave `keep_gbuffer` out, or use 1 sample",
        ));
    }
    if options.resolve == ResolveWay::Plain && folded {
        let problem = match path {
            Path::Deferred => format!("layout {} has no light target", options.layout),
            _ => format!("the path {path} applies the tone curve to each sample as it is drawn"),
        };
        return Err(Error::unsupported(
            format!("{problem}, so that light cannot be resolved before the tone curve (--resolve plain)"),
            "use --resolve tonemapped, or the path deferred with --layout ontile128",
        ));
    }
    Ok(())
}

impl Plan {
    /// Whether light is added by blending to several samples of floats, which Mali does at less than its full rate (best practices
    /// of the validation layer, `multisampled-blending`).
    pub fn blends_samples_of_floats(&self) -> bool {
        let is_wide =
            |format| matches!(format, Format::Rgba16Float | Format::Rgba32Float | Format::B10g11r11Float);
        self.attachments.iter().any(|a| a.samples > 1 && a.usage.blend && is_wide(a.format))
    }
}

/// What a plan with several samples a pixel tells.
pub(super) fn notes(options: &Options, attachments: &[super::Attachment]) -> Vec<String> {
    let samples = options.samples;
    if samples == 1 {
        return Vec::new();
    }
    let place = attachments.iter().find(|a| a.name.contains("output_samples")).map(|a| a.name.as_str());
    let place = place
        .filter(|name| name.contains('/'))
        .map_or(String::new(), |name| format!(", in one place ({name})"));
    let has_layers = attachments.iter().any(|a| a.samples > 1 && a.name.contains("layer_"));
    let layers = "layers are of samples, so that what is blended is shaded for each sample, not once a pixel"
        .to_owned();
    let all = format!(
        "{samples} samples a pixel of all that is drawn; the output has 1, resolved on the tile{place}: {}",
        match options.resolve {
            ResolveWay::Tonemapped => "the tone curve of each sample, then the mean",
            ResolveWay::Plain => "the mean of light, then the tone curve",
        }
    );
    std::iter::once(all).chain(has_layers.then_some(layers)).collect()
}

/// # Errors
/// [`Error::Unsupported`] if the device's attachments cannot have so many samples, or its fragments not be of samples.
pub(super) fn check_limits(
    attachments: &[super::Attachment],
    passes: &[Pass],
    options: &Options,
    limits: &Limits,
) -> crate::Result<()> {
    let samples = options.samples;
    if samples == 1 {
        return Ok(());
    }
    for attachment in attachments.iter().filter(|a| a.samples > 1) {
        let counts =
            if attachment.format.is_uint() { limits.word_sample_counts } else { limits.sample_counts };
        if counts & samples == 0 {
            let known: Vec<_> =
                [1, 2, 4, 8].iter().filter(|n| counts & **n != 0).map(u32::to_string).collect();
            let words = match attachment.format.is_uint() {
                true if attachment.name.contains("layer_") => {
                    ", or --translucency weighted, which keeps no words"
                }
                true => ", or a layout without words (--layout ontile128)",
                false => "",
            };
            return Err(Error::unsupported(
                format!(
                    "attachment {} ({}) cannot have {samples} samples a pixel on this device",
                    attachment.name, attachment.format
                ),
                format!("use --samples {}{words}", known.join(" or ")),
            ));
        }
    }
    // The tone curve, and what is shown in its place, goes through the samples of a pixel.
    let looks = |s: &Subpass| !s.inputs.is_empty() || !s.samples.is_empty();
    let reads = |s: &&Subpass| looks(s) && !matches!(s.name, "tonemap" | "show" | "difference");
    let mut subpasses = passes.iter().flat_map(|pass| &pass.subpasses);
    if let Some(subpass) = subpasses.find(reads).filter(|_| !limits.sample_shading) {
        return Err(Error::unsupported(
            format!(
                "the stage {} looks at each sample by itself, which takes sampleRateShading, and this device has it not",
                subpass.name
            ),
            "use --samples 1, or --path forward with --translucency sorted",
        ));
    }
    Ok(())
}
