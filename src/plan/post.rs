//! Passes after the frame's own: what needs a pixel's neighbours, which are not on the tile yet while its own pass runs. The
//! frame's pass stays one; these have a price, and it is known before anything runs.

use serde::Serialize;

use super::{Attachment, BloomWay, Format, Needs, Options, Path, Plan};
use crate::{Error, Result};

/// An image that only these passes, and the next frame's tone curve, use.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PostImage {
    /// Name.
    pub name: String,
    /// How a pixel is stored.
    pub format: Format,
    /// Its sides are the picture's, halved so often and rounded up each time.
    pub halvings: u32,
    /// What needs it.
    pub why: &'static str,
}

impl PostImage {
    /// Width and height for a picture of this size, pixels.
    pub fn size(&self, picture: [u32; 2]) -> [u32; 2] {
        picture.map(|side| side.div_ceil(1 << self.halvings))
    }
}

/// What a pass samples or draws to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PostPlace {
    /// An attachment of the frame's own passes: index into [`Plan::attachments`].
    Attachment(usize),
    /// Index into [`Post::images`].
    Image(usize),
    /// The host's image, where the frame's own passes do not draw to it.
    Output,
}

/// What a pass does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PostKind {
    /// Averages pixels on edges with their neighbours (Koonce 2007, listing 19-3).
    EdgeFilter,
    /// Takes the light of the frame to half its size; `displayed`: from behind the tone curve, which is undone.
    BloomFirst {
        /// Whether the tone curve is undone.
        displayed: bool,
    },
    /// Takes spread light to half its size.
    BloomDown,
    /// Spreads what the next smaller size adds up to, and adds light of its own size.
    BloomUp,
}

/// One render pass with one draw that covers the image.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PostPass {
    /// Name.
    pub name: String,
    /// What it does.
    pub kind: PostKind,
    /// Sampled, neighbours too, in order of bindings.
    pub samples: Vec<PostPlace>,
    /// Drawn to and stored.
    pub target: PostPlace,
    /// Why it exists.
    pub why: &'static str,
}

/// All passes after the frame's own.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Post {
    /// Images.
    pub images: Vec<PostImage>,
    /// In order of execution.
    pub passes: Vec<PostPass>,
}

impl Post {
    /// The image that the tone curve of the next frame samples, index into [`Self::images`].
    pub fn scattered(&self) -> Option<usize> {
        let first = self.images.iter().position(|image| image.name == "bloom_sum_1");
        first.or((!self.images.is_empty()).then_some(0))
    }

    /// The first pass of each kind: those of one kind have a pipeline in common.
    pub fn kinds(&self) -> impl Iterator<Item = &PostPass> {
        let is_first = |(n, pass): &(usize, &PostPass)| self.passes[..*n].iter().all(|p| p.kind != pass.kind);
        self.passes.iter().enumerate().filter(is_first).map(|(_, pass)| pass)
    }

    /// Whether one of them draws to the host's image, in place of the frame's own.
    pub fn draws_output(&self) -> bool {
        self.passes.iter().any(|pass| pass.target == PostPlace::Output)
    }

    /// What follows from the options and the attachments that are stored for it.
    /// `sampled` tells which.
    pub(super) fn new(
        options: &Options,
        attachments: &[Attachment],
        sampled: &dyn Fn(usize) -> bool,
    ) -> Self {
        let mut post = Self::default();
        let light = attachments.iter().position(|a| a.name == "bloom_light");
        if options.edge_filter {
            let sampled = (0..attachments.len()).filter(|&a| sampled(a) && light != Some(a));
            let samples = sampled.map(PostPlace::Attachment);
            post.passes.push(PostPass {
                name: "edge_filter".into(),
                kind: PostKind::EdgeFilter,
                samples: samples.collect(),
                target: PostPlace::Output,
                why: "edges are found by depth and normals of neighbours, and smoothed",
            });
        }
        if options.bloom == BloomWay::Off {
            return post;
        }
        let levels = bloom_levels(options);
        for level in 1..=levels {
            post.images.push(PostImage {
                name: format!("bloom_{level}"),
                format: Format::B10g11r11Float,
                halvings: level,
                why: "light that is spread",
            });
        }
        for level in 1..levels {
            post.images.push(PostImage {
                name: format!("bloom_sum_{level}"),
                format: Format::B10g11r11Float,
                halvings: level,
                why: "spread light of this size and all smaller ones",
            });
        }
        let sum = |level: u32| match level {
            _ if level == levels => PostPlace::Image(level as usize - 1),
            _ => PostPlace::Image((levels + level) as usize - 1),
        };
        let image = |level: u32| PostPlace::Image(level as usize - 1);
        let down = |level: u32, kind, from, why| PostPass {
            name: format!("bloom_down_{level}"),
            kind,
            samples: vec![from],
            target: image(level),
            why,
        };
        let displayed = options.bloom == BloomWay::Previous;
        let why = match displayed {
            true => "the tone curve of the stored picture is undone, and light taken to half its size",
            false => "stored light is taken to half its size",
        };
        let first = PostKind::BloomFirst { displayed };
        post.passes.push(down(1, first, PostPlace::Attachment(light.unwrap_or(0)), why));
        for level in 2..=levels {
            let why = "wider scattering needs fewer pixels";
            post.passes.push(down(level, PostKind::BloomDown, image(level - 1), why));
        }
        for level in (1..levels).rev() {
            post.passes.push(PostPass {
                name: format!("bloom_up_{level}"),
                kind: PostKind::BloomUp,
                samples: vec![sum(level + 1), image(level)],
                target: sum(level),
                why: "light of all sizes is added up",
            });
        }
        post
    }
}

/// Sizes of scattered light: the pixels of the smallest are as wide as the radius says, and it has two of them at least.
pub fn bloom_levels(options: &Options) -> u32 {
    let side = options.size[0].min(options.size[1]) as f32;
    let most = side.log2().floor() as u32;
    let wanted = (options.bloom_radius * side).log2().round().max(1.0) as u32;
    wanted.clamp(1, most.saturating_sub(1).max(1))
}

/// # Errors
/// [`Error::Unsupported`] for numbers out of range, and for frames of which no stage sees all pixels.
pub(super) fn check(options: &Options, needs: &Needs, path: Path) -> Result<()> {
    let share = |what: &str, value: f32, least: bool| {
        if value <= 1.0 && if least { value >= 0.0 } else { value > 0.0 } {
            return Ok(());
        }
        let from = if least { "0" } else { "above 0" };
        Err(Error::unsupported(format!("{what} cannot be {value}"), format!("choose from {from} to 1")))
    };
    share("the share of light that bloom scatters (--bloom-strength)", options.bloom_strength, true)?;
    share("the reach of bloom (--bloom-radius)", options.bloom_radius, false)?;
    if options.output_is_kept && (options.bloom != BloomWay::Off || options.edge_filter) {
        return Err(Error::unsupported(
            "passes after the frame's own draw the whole picture, and a part of it is another frame's",
            "leave --bloom and --edge-filter out",
        ));
    }
    let none_sees_all = needs.lit.is_none() || path == Path::Forward;
    if options.bloom != BloomWay::Off && none_sees_all {
        return Err(Error::unsupported(
            format!(
                "bloom mixes scattered light into every pixel before the tone curve, and {} no stage covers all pixels",
                if needs.lit.is_none() {
                    "where nothing is lit".into()
                } else {
                    format!("on the path {path}")
                }
            ),
            if needs.lit.is_none() {
                "leave --bloom out"
            } else {
                "use --path deferred, or leave --bloom out"
            },
        ));
    }
    if options.bloom == BloomWay::Store && options.samples > 1 {
        return Err(Error::unsupported(
            "bloom from stored light stores one sample a pixel, and the frame has more",
            "use --bloom previous, or --samples 1",
        ));
    }
    if options.edge_filter && options.samples > 1 {
        return Err(Error::unsupported(
            "the edge filter compares one depth and normal a pixel, and the frame has more samples, which smooth edges already",
            "leave --edge-filter out, or use --samples 1",
        ));
    }
    if options.edge_filter && (needs.lit.is_none() || path != Path::Deferred) {
        return Err(Error::unsupported(
            "the edge filter reads normals from the G-buffer, and this frame has none",
            "use --path deferred with lit surfaces, or leave --edge-filter out",
        ));
    }
    Ok(())
}

impl Plan {
    /// Bytes of an image of these passes, a pixel of the picture.
    fn post_bytes(&self, place: PostPlace) -> f64 {
        match place {
            PostPlace::Attachment(a) => f64::from(self.attachments[a].format.bytes()),
            PostPlace::Output => f64::from(Format::from(self.options.output).bytes()),
            PostPlace::Image(i) => {
                let image = &self.post.images[i];
                f64::from(image.format.bytes()) / f64::from(1_u32 << (2 * image.halvings))
            }
        }
    }

    /// Bytes that a pass after the frame's own loads (first; what it samples counts once, since caches hold the neighbours)
    /// and stores (second), a pixel of the picture.
    pub fn post_traffic(&self, pass: &PostPass) -> [f64; 2] {
        let sampled: f64 = pass.samples.iter().map(|&place| self.post_bytes(place)).sum();
        [sampled, self.post_bytes(pass.target)]
    }

    /// Bytes that the frame's own tone curve samples of scattered light, a pixel.
    pub fn scattered_bytes(&self) -> f64 {
        self.post.scattered().map_or(0.0, |image| self.post_bytes(PostPlace::Image(image)))
    }

    /// Bytes a pixel that all of it loads (first) and stores (second).
    pub fn post_totals(&self) -> [f64; 2] {
        let all = self.post.passes.iter().map(|pass| self.post_traffic(pass));
        all.fold([self.scattered_bytes() + self.compared_bytes(), 0.0], |[l, s], [loaded, stored]| {
            [l + loaded, s + stored]
        })
    }

    /// What the ledger prints of it; nothing where there is none.
    pub(super) fn print_post(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.post.passes.is_empty() {
            return Ok(());
        }
        writeln!(f, "\nafter it (planned), bytes a pixel of the picture:   loaded   stored")?;
        let mut line = |name: &str, [loaded, stored]: [f64; 2], why: &str| {
            writeln!(f, "  {name:<48} {loaded:>7.3} {stored:>8.3}  {why}")
        };
        for pass in &self.post.passes {
            let place = |place: PostPlace| match place {
                PostPlace::Attachment(a) => self.attachments[a].name.clone(),
                PostPlace::Image(i) => self.post.images[i].name.clone(),
                PostPlace::Output => "the host's image".into(),
            };
            let from = pass.samples.iter().map(|&p| place(p)).collect::<Vec<_>>().join(", ");
            let name = format!("{}: {from} -> {}", pass.name, place(pass.target));
            line(&name, self.post_traffic(pass), pass.why)?;
        }
        if let Some(image) = self.post.scattered() {
            let name = format!("next frame's tone curve: {}", self.post.images[image].name);
            line(&name, [self.scattered_bytes(), 0.0], "scattered light is mixed in")?;
        }
        line("total", self.post_totals(), "")?;
        let passes = self.post.passes.len();
        writeln!(f, "  {passes} render pass{}, each with one draw", if passes == 1 { "" } else { "es" })
    }

    /// Frames of a view that stands still until the picture does: a picture that is stored with scattered light in it scatters that
    /// again, until what is left of it is below half of an 8-bit step.
    pub fn frames_to_settle(&self) -> u32 {
        const LEAST: f32 = 0.5 / 255.0;
        match self.options.bloom {
            BloomWay::Off => 1,
            BloomWay::Store => 2,
            BloomWay::Previous => {
                let strength = self.options.bloom_strength.clamp(LEAST, 0.99);
                2 + (LEAST.ln() / strength.ln()).ceil() as u32
            }
        }
    }
}
