//! The stages of a frame and the resources that they exchange, before anything is placed in memory.

use super::layout::{GBuffer, LightPlace, LightTarget, Target, Tells};
use super::{DepthStore, Format, LightWay, Needs, Options, Path};

/// Something that stages write and read, one value a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Resource {
    /// Name in plans and reports.
    pub name: &'static str,
    /// How it is stored.
    pub format: Format,
    /// What each channel holds.
    pub holds: &'static str,
    /// What pixels that nothing covers must hold; `None` where nothing reads them.
    pub clear: Option<[f32; 4]>,
    /// Outlives the frame: the final image, or a G-buffer that is kept to be read back.
    pub kept: bool,
    /// The scene element or the stage that needs it.
    pub why: String,
}

/// How a stage uses a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// Colour output that replaces what was there.
    Write,
    /// Colour output that is added to what was there.
    Blend,
    /// Depth test and write.
    Depth,
    /// Depth test against what earlier stages wrote.
    DepthTest,
    /// The same, and the stencil is written and tested.
    Stencil,
    /// Input attachment: this pixel of an earlier stage's output.
    Read,
}

impl Use {
    /// Whether earlier content matters.
    pub const fn reads(self) -> bool {
        matches!(self, Self::Blend | Self::Read | Self::DepthTest | Self::Stencil)
    }

    /// Whether content changes.
    pub const fn writes(self) -> bool {
        !matches!(self, Self::DepthTest | Self::Read)
    }
}

/// One step of the frame; becomes a subpass.
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    /// Name in plans, labels and reports.
    pub name: &'static str,
    /// Resources by index, in order of colour output location and of input attachment index.
    pub uses: Vec<(usize, Use)>,
    /// Why the stage exists.
    pub why: String,
}

/// The stages of a frame with their resources. The last stage writes [`Frame::OUTPUT`].
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Indexed by `Stage::uses`.
    pub resources: Vec<Resource>,
    /// In order of execution.
    pub stages: Vec<Stage>,
    /// Whether the stage that lights applies the tone curve itself.
    pub folded: bool,
}

impl Frame {
    /// The final image's index in `resources`.
    pub const OUTPUT: usize = 0;

    /// What a light target holds where background and surfaces are told apart.
    const LIGHT_AND_BACKGROUND: &str = "rgb: exposed light / range, a: 0 background, 1 surface";

    /// The least number of stages and resources that give the picture on this path and in this way, none of which is
    /// `Auto`. The format is for depth where the way needs a stencil.
    pub fn new(
        needs: &Needs,
        options: &Options,
        gbuffer: &GBuffer,
        path: Path,
        way: LightWay,
        depth_stencil: Format,
    ) -> Self {
        let mut resources = vec![Resource {
            name: "output",
            format: options.output.into(),
            holds: "the final image",
            clear: None,
            kept: true,
            why: "the picture".into(),
        }];
        let mut add = |target: &Target, kept, why: String| {
            resources.push(Resource {
                name: target.name,
                format: target.format,
                holds: target.holds,
                clear: target.clear,
                kept,
                why,
            });
            resources.len() - 1
        };
        let mut stages = Vec::new();
        let mut depth_uses = Vec::new();
        let one_by_one = way.is_one_by_one();
        let before_sky = needs.sky && needs.triangles > 0;
        let is_read = path == Path::Deferred && needs.lit.is_some() && gbuffer.reads_depth_attachment();
        let depth = (needs.triangles > 1 || one_by_one || before_sky || is_read).then(|| {
            let stencil = way == LightWay::Stencil;
            let target = Target {
                name: match (is_read, stencil) {
                    (true, _) => "depth",
                    (false, true) => "depth_stencil_test",
                    (false, false) => "depth_test",
                },
                format: match gbuffer.depth {
                    _ if stencil => depth_stencil,
                    DepthStore::D24 if is_read => Format::D24Unorm,
                    DepthStore::D16 if is_read => Format::D16Unorm,
                    _ => Format::D32Float,
                },
                holds: match stencil {
                    true => "reversed device depth, 0 is far; stencil: surfaces in a light's volume",
                    false => "reversed device depth, 0 is far",
                },
                used_bits: if stencil { depth_stencil.bits() } else { 32 },
                clear: Some([0.0; 4]),
                tells: Tells::Position,
            };
            let mut why = Vec::new();
            why.extend(
                (needs.triangles > 1).then(|| format!("{} triangles hide each other", needs.triangles)),
            );
            why.extend(is_read.then(|| "lighting reads it".into()));
            why.extend(one_by_one.then(|| "a light's volume is tested against it".into()));
            why.extend(before_sky.then(|| "the sky is behind them".into()));
            add(&target, options.keep_gbuffer && is_read, why.join("; "))
        });
        if let Some(depth) = depth {
            if options.depth_prepass {
                let why = "what is nearest is found first, so that no pixel is shaded twice".into();
                stages.push(Stage { name: "depth", uses: vec![(depth, Use::Depth)], why });
                depth_uses.push((depth, Use::DepthTest));
            } else {
                depth_uses.push((depth, Use::Depth));
            }
        }

        let lights = || {
            let Needs { directional_lights, point_lights, spot_lights, box_lights, .. } = needs;
            let more = [
                (*box_lights, "box"),
                (needs.hemisphere_lights, "hemisphere (all at the cost of one)"),
                (needs.back_colors, "with a back colour"),
                (needs.globe_maps, "with a globe map"),
            ];
            let more = more.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!(", {n} {what}"));
            format!(
                "{directional_lights} directional, {point_lights} point and {spot_lights} spot lights{}",
                more.collect::<String>()
            )
        };
        let lit = match (&needs.lit, path) {
            (Some(lit), Path::Deferred) => lit,
            (Some(_), Path::ForwardMultipass) => {
                let light = added_light(gbuffer, true).0;
                let light = add(&light.target, false, "lights are summed one by one".into());
                if needs.background.is_some() {
                    resources[light].holds = Self::LIGHT_AND_BACKGROUND;
                }
                let drawn = |how| (light, how);
                let depth_test =
                    depth_uses.iter().map(|&(depth, _)| (depth, Use::DepthTest)).collect::<Vec<_>>();
                let base = if needs.prelit.is_empty() {
                    "surfaces without their lights, and their depth".into()
                } else {
                    needs.prelit.join(", ")
                };
                let mut stage = |name, uses: Vec<_>, why| stages.push(Stage { name, uses, why });
                stage("geometry", std::iter::once(drawn(Use::Write)).chain(depth_uses).collect(), base);
                let each = format!("{}; each adds to the surfaces that it reaches", lights());
                stage("lights", std::iter::once(drawn(Use::Blend)).chain(depth_test).collect(), each);
                let sum = "light from several draws was summed".into();
                stage("tonemap", vec![(Self::OUTPUT, Use::Write), drawn(Use::Read)], sum);
                return Self { resources, stages, folded: false };
            }
            (lit, _) => {
                // Nothing covers the whole image, so the output itself must be cleared.
                let [red, green, blue] = needs.background.unwrap_or_default();
                resources[Self::OUTPUT].clear = Some([red, green, blue, 1.0]);
                let fogged = if needs.fog.is_some() { ", fogged" } else { "" };
                let uses = std::iter::once((Self::OUTPUT, Use::Write)).chain(depth_uses).collect();
                let (name, why) = match lit {
                    None => (
                        "geometry",
                        format!(
                            "nothing in the scene is lit: surfaces are drawn{fogged} and tone-mapped at once"
                        ),
                    ),
                    Some(_) => (
                        "forward",
                        format!("{}; surfaces are lit{fogged} and tone-mapped as drawn", lights()),
                    ),
                };
                stages.push(Stage { name, uses, why });
                return Self { resources, stages, folded: true };
            }
        };

        let light_read = matches!(gbuffer.light, LightPlace::Read(_)) && !needs.prelit.is_empty();
        let folded = match gbuffer.light {
            LightPlace::Added { .. } => needs.prelit.is_empty() && options.fold && !one_by_one,
            LightPlace::Read(_) | LightPlace::Nowhere => true,
        };
        let mut surface: Vec<_> = gbuffer
            .surface
            .iter()
            .map(|t| add(t, options.keep_gbuffer, format!("lighting reads it for lit surfaces ({lit})")))
            .collect();
        let mut light_why = needs.prelit.clone();
        light_why.extend(one_by_one.then(|| "lights are added one by one, each rounded".into()));
        if light_why.is_empty() {
            light_why.push("lighting and tonemap are kept apart on request".into());
        }
        let light_why = light_why.join(", ");
        if let LightPlace::Read(Some(word)) = &gbuffer.light
            && light_read
        {
            surface.push(add(word, options.keep_gbuffer, light_why.clone()));
        }
        let (light, split) = added_light(gbuffer, one_by_one);
        let other = Target {
            name: "specular_light",
            holds: "rgb: exposed light but for diffuse light",
            ..light.target
        };
        let targets = [Some(light.target), split.then_some(other)];
        let lights_added: Vec<_> = if folded {
            Vec::new()
        } else {
            targets.iter().flatten().map(|t| add(t, options.keep_gbuffer, light_why.clone())).collect()
        };
        // What tells the light of surfaces from the background, and where fog begins.
        let has_fog = needs.fog.is_some();
        let by_depth = !light.has_alpha() && (has_fog || needs.background.is_some());
        let positions: Vec<_> = {
            let told = |tells| {
                let targets = gbuffer.surface.iter().zip(&surface);
                targets.filter(move |(t, _)| t.tells == tells).map(|(_, &r)| r)
            };
            let albedo = told(Tells::Albedo).filter(|_| split);
            let read = depth.filter(|_| is_read).into_iter();
            read.chain(told(Tells::Position)).filter(|_| has_fog || by_depth).chain(albedo).collect()
        };
        if folded && light_read && (has_fog || needs.background.is_some()) {
            // The layouts that do not say it otherwise read it from depth.
            for &r in &surface {
                if resources[r].name == "depth" {
                    resources[r].clear = Some([0.0; 4]);
                }
            }
        }
        if !folded {
            for &r in &positions {
                let why = if has_fog { ", and tonemap for fog" } else { ", and tonemap" };
                resources[r].why += why;
                if by_depth {
                    resources[r].clear = Some([0.0; 4]);
                }
            }
            if let Some(&last) = lights_added.last()
                && light.has_alpha()
                && (has_fog || needs.background.is_some())
            {
                resources[last].holds = Self::LIGHT_AND_BACKGROUND;
            }
        }

        let written = surface.iter().chain(&lights_added).map(|&r| (r, Use::Write));
        let geometry = Stage {
            name: "geometry",
            uses: written.chain(depth_uses).collect(),
            why: format!(
                "{} of surface in the G-buffer",
                if needs.kinds.len() == 1 { "1 kind".into() } else { format!("{} kinds", needs.kinds.len()) }
            ),
        };
        let test = if way == LightWay::Stencil { Use::Stencil } else { Use::DepthTest };
        let test = depth.filter(|_| one_by_one).map(|depth| (depth, test));
        let depth_read = depth.filter(|_| is_read);
        let read = depth_read.iter().chain(&surface).map(|&r| (r, Use::Read)).chain(test);
        let adds = |r: &usize| (*r, Use::Blend);
        let lighting = Stage {
            name: "lighting",
            uses: match folded {
                false => lights_added.iter().map(adds).chain(read).collect(),
                true => std::iter::once((Self::OUTPUT, Use::Write)).chain(read).collect(),
            },
            why: format!(
                "{}{}{}",
                lights(),
                if one_by_one { ", each where its volume is" } else { "" },
                match (folded, light_read) {
                    (true, true) => "; applies the tone curve too, since it is the only one to add light",
                    (true, false) => {
                        "; applies the tone curve too, since no light is summed before it"
                    }
                    (false, _) => "",
                }
            ),
        };
        let tonemap = (!folded).then(|| Stage {
            name: "tonemap",
            uses: std::iter::once((Self::OUTPUT, Use::Write))
                .chain(lights_added.iter().chain(&positions).map(|&r| (r, Use::Read)))
                .collect(),
            why: if has_fog {
                "light from several stages was summed; fog goes by the depth of what sent it".into()
            } else {
                "light from several stages was summed".into()
            },
        });
        stages.extend([geometry, lighting].into_iter().chain(tonemap));
        Self { resources, stages, folded }
    }

    /// First and last stage that uses the resource; a kept resource lives to the last stage.
    pub fn lifetime(&self, resource: usize) -> (usize, usize) {
        let uses = |s: &Stage| s.uses.iter().any(|(r, _)| *r == resource);
        let first = self.stages.iter().position(uses).unwrap_or(0);
        let last = self.stages.iter().rposition(uses).unwrap_or(0);
        (first, if self.resources[resource].kept { self.stages.len() - 1 } else { last })
    }
}

/// Where light is added, and whether diffuse light apart. A layout that has no such place gets half floats where a way needs one
/// all the same.
pub fn added_light(gbuffer: &GBuffer, one_by_one: bool) -> (LightTarget, bool) {
    gbuffer.added_light(one_by_one).unwrap_or((LightTarget::new(super::LightFormat::Rgba16f), false))
}
