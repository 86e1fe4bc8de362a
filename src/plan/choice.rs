//! A G-buffer as it is chosen: a layout, and what is chosen besides.

use serde::{Deserialize, Serialize};

use super::{Brdf, DepthStore, GBuffer, Gamma, Layout, LightFormat, Normals, Options};

/// The part of [`Options`] that says how surfaces and light are stored, and how accurately they are shaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Choice {
    /// The layout.
    pub layout: Layout,
    /// How normals are encoded, if not the layout's way.
    pub normals: Option<Normals>,
    /// How colours are encoded, likewise.
    pub gamma: Option<Gamma>,
    /// What light is summed in, likewise.
    pub light_target: Option<LightFormat>,
    /// Where depth is read, likewise.
    pub depth: Option<DepthStore>,
    /// How reflection is evaluated.
    #[serde(default)]
    pub brdf: Brdf,
}

impl Choice {
    /// A layout as it is.
    pub const fn of(layout: Layout) -> Self {
        Self { layout, normals: None, gamma: None, light_target: None, depth: None, brdf: Brdf::Exact }
    }

    /// What these options choose.
    pub fn in_options(options: &Options) -> Self {
        let Options { layout, normals, gamma, light_target, depth, brdf, .. } = *options;
        Self { layout, normals, gamma, light_target, depth, brdf }
    }

    /// The options with this choice in place of their own.
    pub fn apply(self, options: &Options) -> Options {
        let Self { layout, normals, gamma, light_target, depth, brdf } = self;
        Options { layout, normals, gamma, light_target, depth, brdf, ..options.clone() }
    }

    /// Every layout as it is, then each single other choice over `base`.
    pub fn one_by_one(base: Self) -> Vec<Self> {
        let plain = Layout::ALL.iter().map(|&layout| Self::of(layout));
        let normals = Normals::ALL.iter().map(|&n| Self { normals: Some(n), ..base });
        let gamma = Gamma::ALL.iter().map(|&g| Self { gamma: Some(g), ..base });
        let light = LightFormat::ALL.iter().map(|&l| Self { light_target: Some(l), ..base });
        let depth = DepthStore::ALL.iter().map(|&d| Self { depth: Some(d), ..base });
        let brdf = Brdf::ALL.iter().map(|&b| Self { brdf: b, ..base });
        let others = normals.chain(gamma).chain(light).chain(depth).chain(brdf);
        let own = base.gbuffer().ok();
        // What the base does by itself is no other choice.
        let others = others.filter(|c| c.brdf != base.brdf || c.gbuffer().ok() != own);
        plain.chain(others).collect()
    }

    /// What [`crate::measure::choose`] chooses from: the layouts, each single other choice over `ontile128` that changes
    /// bytes or normals, and 16 bits of depth over its smaller kin. Colours are left as they are, since no other way has fewer
    /// bytes.
    pub fn candidates() -> Vec<Self> {
        let layouts = Layout::ALL.iter().filter(|&&layout| layout != Layout::Exact).map(|&l| Self::of(l));
        let base = Self::of(Layout::Ontile128);
        let others = Self::one_by_one(base).into_iter().filter(|c| {
            let floats = c.normals == Some(Normals::Float) || c.light_target == Some(LightFormat::Rgba32f);
            !c.is_plain() && c.gamma.is_none() && !floats && c.light_target != Some(LightFormat::B10g11r11)
        });
        let small = [Layout::Ontile96, Layout::Ontile64, Layout::Packed128];
        let small = small.map(|layout| Self { depth: Some(DepthStore::D16), ..Self::of(layout) });
        layouts.chain(others).chain(small).collect()
    }

    /// Every combination that makes sense; of those that come to the same G-buffer, the one with the fewest words.
    pub fn every() -> Vec<Self> {
        let mut seen: Vec<GBuffer> = Vec::new();
        let mut all = Vec::new();
        let mut combined: Vec<Self> = Layout::ALL.iter().map(|&layout| Self::of(layout)).collect();
        for &layout in Layout::ALL {
            for normals in some_of(Normals::ALL) {
                for gamma in some_of(Gamma::ALL) {
                    for light_target in some_of(LightFormat::ALL) {
                        let brdf = Brdf::Exact;
                        let of = |depth| Self { layout, normals, gamma, light_target, depth, brdf };
                        combined.extend(some_of(DepthStore::ALL).map(of));
                    }
                }
            }
        }
        for choice in combined {
            if let Ok(gbuffer) = choice.gbuffer()
                && !seen.contains(&gbuffer)
            {
                seen.push(gbuffer);
                all.push(choice);
            }
        }
        let shaded = |&choice: &Self| Brdf::ALL.iter().map(move |&brdf| Self { brdf, ..choice });
        all.iter().flat_map(shaded).collect()
    }

    /// What the choice comes to.
    ///
    /// # Errors
    /// As [`GBuffer::new`].
    pub fn gbuffer(&self) -> crate::Result<GBuffer> {
        GBuffer::new(&self.apply(&Options::default()))
    }

    /// Whether the layout is taken as it is.
    pub fn is_plain(&self) -> bool {
        *self == Self::of(self.layout)
    }

    /// Flags and values of what is chosen besides the layout.
    fn besides(&self) -> impl Iterator<Item = (&'static str, &'static str)> {
        let choices = [
            ("--normals", self.normals.map(Normals::name)),
            ("--gamma", self.gamma.map(Gamma::name)),
            ("--light-target", self.light_target.map(LightFormat::name)),
            ("--depth", self.depth.map(DepthStore::name)),
            ("--brdf", (self.brdf != Brdf::Exact).then(|| self.brdf.name())),
        ];
        choices.into_iter().filter_map(|(flag, name)| Some((flag, name?)))
    }

    /// The flags of the command line that make this choice.
    pub fn flags(&self) -> Vec<String> {
        let layout = std::iter::once(("--layout", self.layout.name()));
        layout.chain(self.besides()).flat_map(|(flag, name)| [flag.into(), name.into()]).collect()
    }
}

/// None of them, then each.
fn some_of<T: Copy>(all: &'static [T]) -> impl Iterator<Item = Option<T>> {
    std::iter::once(None).chain(all.iter().copied().map(Some))
}

impl std::fmt::Display for Choice {
    /// The layout, and what is chosen besides after plus signs.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let gamma = |flag| if flag == "--gamma" { "gamma " } else { "" };
        let besides = self.besides().map(|(flag, name)| format!(" + {}{name}", gamma(flag)));
        f.pad(&std::iter::once(self.layout.name().to_owned()).chain(besides).collect::<String>())
    }
}
