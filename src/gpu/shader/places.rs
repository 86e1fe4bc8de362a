//! Where the attachments of a subpass are.
//!
//! Modules number targets and input attachments by what they hold, since they do not know which of them a plan has. Vulkan numbers
//! them by their place in the subpass.

use std::collections::HashSet;

use super::numbers;
use crate::plan::Subpass;
use crate::{Error, Result};

/// The attachments of a subpass in the order of their places, by the numbers that modules know them by: `TARGET_*` and `INPUT_*`
/// of `glsl/shared.h`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct AttachmentPlaces {
    /// By colour output location.
    pub targets: Vec<u32>,
    /// By input attachment index, which is also the binding.
    pub inputs: Vec<u32>,
}

const HEADER_WORDS: usize = 5;
const DECORATE: u32 = 71;
const VARIABLE: u32 = 59;
const STORAGE_OUTPUT: u32 = 3;
const LOCATION: u32 = 30;
const BINDING: u32 = 33;
const INPUT_ATTACHMENT_INDEX: u32 = 43;

impl AttachmentPlaces {
    /// Of a subpass.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if no module knows one of them.
    pub fn of(subpass: &Subpass) -> Result<Self> {
        let number = |kind: &str, name: &&str| {
            // Several samples a pixel are drawn as one is.
            let name = name.trim_end_matches("_samples");
            let wanted = format!("{kind}_{}", name.to_uppercase());
            numbers::find(&wanted).ok_or_else(|| {
                Error::unsupported(format!("no shader has {wanted}"), "name the attachment in glsl/shared.h")
            })
        };
        let numbers = |kind, names: &[&str]| -> Result<Vec<u32>> {
            names.iter().map(|name| number(kind, name)).collect()
        };
        Ok(Self {
            targets: numbers("TARGET", &subpass.color_names)?,
            inputs: numbers("INPUT", &subpass.input_names)?,
        })
    }

    /// The fragment shader with places for numbers; `name` is for errors.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if it has a target or an input that the subpass has not.
    pub fn apply(&self, name: &str, mut spirv: Vec<u32>) -> Result<Vec<u32>> {
        let mut outputs = HashSet::new();
        let mut inputs = HashSet::new();
        let begins: Vec<_> = instructions(&spirv).collect();
        for &at in &begins {
            match spirv[at..] {
                [word, _, id, STORAGE_OUTPUT, ..] if word & 0xffff == VARIABLE => {
                    outputs.insert(id);
                }
                [word, id, INPUT_ATTACHMENT_INDEX, ..] if word & 0xffff == DECORATE => {
                    inputs.insert(id);
                }
                _ => {}
            }
        }
        for at in begins {
            let [word, id, decoration, number, ..] = spirv[at..] else { continue };
            if word & 0xffff != DECORATE {
                continue;
            }
            let (places, what) = match decoration {
                LOCATION if outputs.contains(&id) => (&self.targets, "target"),
                BINDING | INPUT_ATTACHMENT_INDEX if inputs.contains(&id) => (&self.inputs, "input"),
                _ => continue,
            };
            let place = places.iter().position(|own| *own == number).ok_or_else(|| {
                Error::unsupported(
                    format!("shader module '{name}' has {what} {number}, which its subpass has not"),
                    "report this with the scene and the command",
                )
            })?;
            spirv[at + 3] = place as u32;
        }
        Ok(spirv)
    }
}

/// Where instructions begin.
fn instructions(spirv: &[u32]) -> impl Iterator<Item = usize> {
    let mut at = HEADER_WORDS;
    std::iter::from_fn(move || {
        let begin = at;
        // A length of 0 would be no SPIR-V.
        at += (spirv.get(begin)? >> 16).max(1) as usize;
        Some(begin)
    })
}
