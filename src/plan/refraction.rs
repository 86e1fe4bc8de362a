//! Media that bend what is behind them: what that takes and costs, and which plans can have it.

use super::layout::GBuffer;
use super::{Needs, Options, Path, Plan, Refraction};
use crate::{Error, Result};

/// # Errors
/// [`Error::Unsupported`] where what media sample is not one light.
pub(super) fn check(needs: &Needs, options: &Options, gbuffer: &GBuffer, path: Path) -> Result<()> {
    let Some(first) = needs.refracts.as_ref().filter(|_| options.refraction == Refraction::Pass) else {
        return Ok(());
    };
    let split = gbuffer.added_light(false).is_some_and(|(_, split)| split);
    if split && path == Path::Deferred && needs.lit_opaque.is_some() {
        return Err(Error::unsupported(
            format!(
                "{first} samples what is behind it, and layout {} keeps diffuse light apart from the colour that it is multiplied by",
                options.layout
            ),
            "use another --layout, or --refraction none",
        ));
    }
    Ok(())
}

/// What it makes of the frame. `bends`: it has a pass for it.
pub(super) fn note(needs: &Needs, options: &Options, bends: bool) -> Option<String> {
    let first = needs.transmits.as_ref()?;
    if bends {
        let each = match options.samples {
            1 => String::new(),
            samples => {
                format!(", each of {samples} samples a pixel by itself, all of which are stored for that")
            }
        };
        return Some(format!(
            "{first} lets light through, bent at its surface (--refraction pass){each}: what is behind is found where a ray that is bent there \
             ends, as deep as what is opaque straight ahead or the medium is thick; beyond the picture's edge it is \
             that of the edge, behind what is nearer than the medium that of the same pixel; media are smooth, are not seen through each \
             other, and are below all that is blended"
        ));
    }
    let asked = match (options.refraction, &needs.refracts) {
        (Refraction::None, _) => "",
        (Refraction::Pass, None) => " (nothing has both a thickness and an index of refraction above 1)",
        (Refraction::Pass, Some(_)) => " (nothing is behind)",
    };
    Some(format!(
        "{first} lets light through, in the pass and not refracted{asked}: of what is behind it in the same pixel; it absorbs on the whole way to \
         what is opaque, whatever lies between, and is below all that is blended"
    ))
}

impl Plan {
    /// Whether media sample what is behind them.
    pub fn refracts(&self) -> bool {
        self.passes.iter().flat_map(|pass| &pass.subpasses).any(|subpass| !subpass.samples.is_empty())
    }

    /// Bytes a pixel that passes sample of an attachment that earlier ones have stored: each pass once, since caches hold neighbours.
    pub(super) fn sampled_bytes(&self, attachment: usize) -> u32 {
        let samples = |pass: &&super::Pass| {
            pass.subpasses.iter().flat_map(|subpass| &subpass.samples).any(|s| s.attachment == attachment)
        };
        let super::Attachment { format, samples: count, .. } = self.attachments[attachment];
        self.passes.iter().filter(samples).count() as u32 * format.bytes() * count
    }

    /// What the ledger prints of it; nothing where there is none.
    pub(super) fn print_refraction(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if !self.refracts() {
            return Ok(());
        }
        let sampled: u32 = (0..self.attachments.len()).map(|a| self.sampled_bytes(a)).sum();
        writeln!(
            f,
            "  refraction: {sampled} of the bytes loaded are sampled, and as many more stored for that"
        )
    }
}
