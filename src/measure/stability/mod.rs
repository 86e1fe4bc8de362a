//! Where methods fail: sweeps that take a method from where it is right to where it is not.
//!
//! A [`Sweep`] varies one quantity and measures each method (a layout, an encoding, a way of lights) against the f64
//! [`reference`](mod@crate::reference) or a closed form, never the GPU against itself unless that is the point (does a
//! picture stand still? does order matter?). Of each method it tells the worst case, where that happens, and how this
//! compares with a [`Bound`] that has a name and a reason. What is worse than its bound is a failure, unless the renderer
//! [answers](Answer) it: the case then is of what would happen without, and another of what happens.
//!
//! [`Sweep::ALL`] lists them, [`Sweep::run`] runs one, [`Study`] gathers what was found and writes it.

mod bench;
mod colour;
mod decals;
mod depth;
mod geometry;
mod inputs;
mod lattice;
mod light_target;
mod lights;
mod masks;
mod normals;
mod particles;
mod parts;
mod posing;
mod refraction;
mod report;
mod samples;
mod shading;
mod shadow_volumes;
mod shadows;
mod sums;
mod translucency;

use serde::Serialize;

use super::plot::Plot;
use crate::Result;
use crate::picture::Picture;
use crate::reference::texture::srgb_from_linear;

use bench::exact;
pub use bench::{Bench, Difference, Truth, difference};
pub use report::Study;

/// One quantity that is varied until methods fail.
#[derive(Clone, Copy, Debug)]
pub struct Sweep {
    /// As it is asked for, and the beginning of its files' names.
    pub name: &'static str,
    /// A heading.
    pub title: &'static str,
    /// What is varied, from where to where, with units.
    pub varies: &'static str,
    /// What the methods are for and why they might fail, in a sentence or two.
    pub about: &'static str,
    /// Whether it draws with the GPU.
    pub needs_device: bool,
    find: fn(&Lab<'_>) -> Result<Findings>,
}

impl Sweep {
    /// All there are.
    pub const ALL: &'static [Self] = &[
        shading::ROUGHNESS,
        shading::GRAZING,
        shading::DISTANCE,
        normals::ANGLES,
        normals::RENORMALISED,
        normals::HIGHLIGHTS,
        light_target::BANDING,
        light_target::OVERFLOW,
        light_target::TINT,
        sums::SUM,
        sums::ORDER,
        depth::DEPTH,
        colour::GAMMA,
        colour::HALOS,
        colour::RGBM,
        colour::RANGE,
        inputs::INPUTS,
        geometry::GEOMETRY,
        geometry::TARGETS,
        lattice::LATTICE,
        lights::VOLUMES,
        lights::STEADY,
        shadows::ACNE,
        shadows::PANNING,
        shadows::SHIMMER,
        shadow_volumes::SHADOW_VOLUMES,
        decals::DECALS,
        samples::EDGES,
        samples::RESOLVE,
        masks::MASKS,
        translucency::TRANSLUCENCY,
        posing::POSING,
        particles::PARTICLES,
        refraction::REFRACTION,
    ];

    /// The sweep of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        Self::ALL.iter().find(|sweep| sweep.name == name)
    }

    /// Measures.
    ///
    /// # Errors
    /// [`Error::Unsupported`](crate::Error::Unsupported) if it needs a device and the lab has none; what drawing may fail
    /// with. That a method fails is no error.
    pub fn run(&self, lab: &Lab<'_>) -> Result<Findings> {
        if self.needs_device {
            lab.bench()?;
        }
        (self.find)(lab)
    }
}

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Scale {
    /// Enough to see a method fail: seconds.
    Quick,
    /// Minutes.
    Full,
}

/// What a sweep measures with.
#[derive(Clone, Copy, Debug)]
pub struct Lab<'a> {
    /// How much is measured.
    pub scale: Scale,
    /// A device to draw with.
    pub bench: Option<&'a Bench>,
}

impl<'a> Lab<'a> {
    /// One of two, by scale.
    fn pick<T>(&self, quick: T, full: T) -> T {
        match self.scale {
            Scale::Quick => quick,
            Scale::Full => full,
        }
    }

    fn bench(&self) -> Result<&'a Bench> {
        self.bench.ok_or_else(|| {
            crate::Error::unsupported(
                "this sweep draws and there is no device",
                "install a Vulkan driver (on Debian: apt-get install mesa-vulkan-drivers)",
            )
        })
    }
}

/// What a sweep found.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    /// One a method.
    pub cases: Vec<Case>,
    /// What it looks like.
    pub figures: Vec<Figure>,
}

/// A method's worst case within a sweep.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Case {
    /// What was measured.
    pub method: String,
    /// The largest error, in the bound's unit. Not a number where the result is none.
    pub worst: f64,
    /// Where that is.
    pub at: String,
    /// What it is held to.
    pub bound: Bound,
    /// What the renderer does about a failure; `None` where nothing is needed or nothing is done.
    pub answer: Option<Answer>,
    /// What a user can do, or what the renderer does.
    pub remedy: String,
}

/// How large an error may be.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bound {
    /// Its name in the source.
    pub name: &'static str,
    /// Of errors and bounds.
    pub unit: &'static str,
    /// Up to this the method holds: nobody sees it, or it is rounding.
    pub good: f64,
    /// Up to this it degrades as its formula says; beyond it fails.
    pub most: f64,
    /// Where both come from.
    pub reason: &'static str,
}

/// What the renderer does where a method fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Answer {
    /// It uses another formula, which another case measures.
    Mended,
    /// It keeps inputs away from where the method fails.
    Guarded,
    /// It refuses with a message.
    Refused,
}

/// How a [`Case`] ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The error is at most [`Bound::good`].
    Holds,
    /// At most [`Bound::most`].
    Degrades,
    /// More, and the renderer uses another formula.
    Mended,
    /// More, and the renderer does not let it come to that.
    Guarded,
    /// More, and the renderer refuses it.
    Refused,
    /// More, and nothing is done about it.
    Fails,
}

impl Verdict {
    /// As tables have it.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Degrades => "degrades within bound",
            Self::Mended => "fails: mended",
            Self::Guarded => "fails: guarded",
            Self::Refused => "fails: refused",
            Self::Fails => "FAILS",
        }
    }
}

impl Case {
    /// What the error comes to.
    pub fn verdict(&self) -> Verdict {
        match self.answer {
            // Not a number is within no bound.
            _ if self.worst <= self.bound.good => Verdict::Holds,
            _ if self.worst <= self.bound.most => Verdict::Degrades,
            Some(Answer::Mended) => Verdict::Mended,
            Some(Answer::Guarded) => Verdict::Guarded,
            Some(Answer::Refused) => Verdict::Refused,
            None => Verdict::Fails,
        }
    }
}

/// A picture that belongs to a sweep.
#[derive(Clone, Debug)]
pub struct Figure {
    /// The second part of its file's name.
    pub name: String,
    /// What is seen.
    pub caption: String,
    /// The picture.
    pub drawing: Drawing,
}

/// What a [`Figure`] shows.
#[derive(Clone, Debug)]
pub enum Drawing {
    /// Curves: SVG and PNG.
    Plot(Box<Plot>),
    /// A rendered picture: PNG.
    Picture(Picture),
}

impl Figure {
    fn plot(name: impl Into<String>, caption: impl Into<String>, plot: Plot) -> Self {
        Self { name: name.into(), caption: caption.into(), drawing: Drawing::Plot(Box::new(plot)) }
    }

    fn picture(name: impl Into<String>, caption: impl Into<String>, picture: Picture) -> Self {
        Self { name: name.into(), caption: caption.into(), drawing: Drawing::Picture(picture) }
    }
}

/// The largest of some errors and where it is. Not a number is larger than all.
#[derive(Clone, Debug)]
struct Worst<T> {
    error: f64,
    at: Option<T>,
}

impl<T> Worst<T> {
    fn new() -> Self {
        Self { error: 0.0, at: None }
    }

    fn add(&mut self, error: f64, at: impl FnOnce() -> T) -> bool {
        let worse = !self.error.is_nan() && (error.is_nan() || error > self.error || self.at.is_none());
        if worse {
            (self.error, self.at) = (error, Some(at()));
        }
        worse
    }
}

/// How far two amounts of linear display light are apart in steps of 8-bit sRGB, unrounded.
fn display_steps(a: f64, b: f64) -> f64 {
    let code = |light: f64| srgb_from_linear(light.clamp(0.0, 1.0)) * 255.0;
    (code(a) - code(b)).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdicts_follow_bounds() {
        let bound = Bound { name: "B", unit: "m", good: 1.0, most: 2.0, reason: "r" };
        let case = |worst, answer| Case {
            method: "m".into(),
            worst,
            at: "here".into(),
            bound: bound.clone(),
            answer,
            remedy: "none".into(),
        };
        assert_eq!(case(1.0, None).verdict(), Verdict::Holds);
        assert_eq!(case(2.0, None).verdict(), Verdict::Degrades);
        assert_eq!(case(2.1, None).verdict(), Verdict::Fails);
        assert_eq!(case(f64::NAN, None).verdict(), Verdict::Fails);
        assert_eq!(case(f64::INFINITY, Some(Answer::Guarded)).verdict(), Verdict::Guarded);
        assert_eq!(case(1.5, Some(Answer::Mended)).verdict(), Verdict::Degrades);
    }

    #[test]
    fn the_worst_is_kept_and_nan_is_worst() {
        let mut worst = Worst::new();
        for (error, place) in [(0.0, 'a'), (2.0, 'b'), (1.0, 'c')] {
            worst.add(error, || place);
        }
        assert_eq!((worst.error, worst.at), (2.0, Some('b')));
        worst.add(f64::NAN, || 'd');
        worst.add(9.0, || 'e');
        assert_eq!((worst.error.is_nan(), worst.at), (true, Some('d')));
    }

    #[test]
    fn names_are_unique_and_make_file_names() {
        let fits = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        for (i, sweep) in Sweep::ALL.iter().enumerate() {
            assert!(sweep.name.chars().all(fits), "{}", sweep.name);
            assert!(Sweep::ALL[..i].iter().all(|other| other.name != sweep.name), "{} twice", sweep.name);
        }
    }
}
