//! Where pipelines get their modules from.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{AttachmentPlaces, Module, Shaders, Specialization, prune};
use crate::Result;

/// SPIR-V of every [`Module`]: what this build embeds, but for modules that were replaced. Clones share what they hold.
#[derive(Clone, Debug, Default)]
pub struct Modules {
    /// By name.
    replaced: Arc<BTreeMap<&'static str, Vec<u32>>>,
}

impl Modules {
    /// With other SPIR-V for some of the modules. It has the module's interface: the same bindings, targets and constants.
    pub fn with(&self, others: impl IntoIterator<Item = (Module, Vec<u32>)>) -> Self {
        let mut replaced = (*self.replaced).clone();
        replaced.extend(others.into_iter().map(|(module, spirv)| (module.name(), spirv)));
        Self { replaced: Arc::new(replaced) }
    }

    /// A module.
    ///
    /// # Errors
    /// As of [`Module::spirv`].
    pub fn spirv(&self, module: Module) -> Result<&[u32]> {
        self.replaced.get(module.name()).map_or_else(|| module.spirv(), |spirv| Ok(spirv))
    }

    /// The shaders of a pipeline that consists of these modules.
    ///
    /// # Errors
    /// As of [`Shaders::new`].
    pub(in crate::gpu) fn shaders(
        &self,
        vertex: Module,
        fragment: Option<Module>,
        constants: &Specialization,
        attachments: &AttachmentPlaces,
    ) -> Result<Shaders> {
        let left = |module: Module, read| prune(module.name(), self.spirv(module)?, constants, read);
        let fragment = fragment.map(|module| {
            let left = left(module, None)?;
            Ok((attachments.apply(module.name(), left.spirv)?, left.inputs))
        });
        let (fragment, read) = fragment.transpose()?.unzip();
        let vertex = left(vertex, Some(&read.unwrap_or_default()))?;
        Ok(Shaders { vertex: vertex.spirv, fragment, attributes: vertex.inputs })
    }
}
