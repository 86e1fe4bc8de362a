//! Specialisation constants of what shows the G-buffer.

use super::{Specialization, shared};
use crate::plan::Show;

impl Specialization {
    /// The constants of [`super::Module::Show`]: what is shown, in which strips, and whether of edges those that are marked.
    pub fn show(show: Show, strips: &[Show], is_edge: bool) -> Self {
        Self::from_pairs(&[
            (const { shared("ID_SHOW") }, number(show)),
            (
                const { shared("ID_SHOW_STRIPS") },
                strips.iter().fold(0, |bits, show| bits | 1 << number(*show)),
            ),
            (const { shared("ID_SHOW_STRIP_COUNT") }, (strips.len() as f32).to_bits()),
            (const { shared("ID_SHOW_EDGE") }, is_edge.into()),
        ])
    }
}

fn number(show: Show) -> u32 {
    match show {
        // Nothing of this is compiled then.
        Show::Picture | Show::Normal => const { shared("SHOW_NORMAL") },
        Show::BaseColor => const { shared("SHOW_BASE_COLOR") },
        Show::Metallic => const { shared("SHOW_METALLIC") },
        Show::Diffuse => const { shared("SHOW_DIFFUSE") },
        Show::Reflectance => const { shared("SHOW_REFLECTANCE") },
        Show::Roughness => const { shared("SHOW_ROUGHNESS") },
        Show::Depth => const { shared("SHOW_DEPTH") },
        Show::Occlusion => const { shared("SHOW_OCCLUSION") },
        Show::Light => const { shared("SHOW_LIGHT") },
        Show::Channels => const { shared("SHOW_CHANNELS") },
        Show::Lights => const { shared("SHOW_LIGHTS") },
        Show::Edges => const { shared("SHOW_EDGES") },
    }
}
