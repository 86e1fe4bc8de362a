//! What is done to a window in the place of a user, one command a line.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use super::outline::Cells;
use crate::scene::PreRotation;
use crate::{Error, Result};

/// Commands that a window carries out, one after the other, and closes itself after the last one.
///
/// One command a line; what follows `#` is a comment.
///
/// | command | |
/// |---|---|
/// | `frames N` | shows N frames |
/// | `size WxH` | makes the window so many pixels large; `0x0` is as if it were minimised |
/// | `open FILE` | opens a scene, and goes on when that is done or has failed |
/// | `scenes FILE` | looks at what there is to open, and writes it: a file a line |
/// | `pick N` | opens the n-th of those, from 0, as the panel does, and goes on when that is done or has failed |
/// | `set OPTION VALUE` | sets one of the [`Options`](crate::plan::Options) by its name, as [`Options::set`](crate::plan::Options::set) |
/// | `set b.OPTION VALUE` | likewise of B, which has A's options but for those that are set so |
/// | `split SHARE\|off` | shows A left of this share of the width and B right of it; off: A alone |
/// | `difference GAIN\|off` | shows how far A and B are apart, amplified |
/// | `measure FILE` | writes how far they are apart as JSON: the most of 255, and the PSNR |
/// | `camera N\|NAME` | looks from one of the scene's cameras |
/// | `time SECONDS` | shows the scene's animation at this time; it stands until `play` |
/// | `animation N\|NAME\|all` | takes this one of the scene's animations, or all at once |
/// | `play`, `pause` | lets it go on, from its begin after its end, or stops it |
/// | `speed FACTOR` | plays so many seconds of it a second |
/// | `record FILE`, `stop` | records the camera's path as a [`Flight`](crate::scene::Flight), a key a frame, and writes it |
/// | `fly FILE` | flies such a path, and goes on at its end |
/// | `reload` | compiles what has changed of the folder of GLSL, and goes on when that is done or has failed |
/// | `exposure EV` | sets the exposure, stops |
/// | `drag X Y` | turns the camera as if a pointer went so many pixels to the right and down |
/// | `screenshot FILE` | shows a frame and writes it |
/// | `live FILE` | writes what exists on the device as JSON: the number of objects by kind, and their memory |
/// | `overlay on\|off` | shows times, plan and options over the picture, or not |
/// | `volumes on\|off` | outlines the light volumes and the shadow cascades, in the overlay |
/// | `clusters most\|N\|off` | shows how many lights the cells of slice N list, or each tile's cell with the most, in the overlay |
/// | `turn DEGREES` | draws as if the screen was turned, by 0, 90, 180 or 270 degrees; screenshots are upright |
/// | `low-memory` | as if the system was short of memory: while the surface is taken, what draws goes |
/// | `suspend`, `resume` | as if the system took the window's surface, and gave it back |
/// | `stay` | leaves the window to the user |
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Script {
    pub(super) steps: Vec<Step>,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Step {
    Frames(u32),
    Size([u32; 2]),
    Open(PathBuf),
    Scenes(PathBuf),
    Pick(usize),
    Set(String, String),
    Camera(String),
    Time(f64),
    Animation(String),
    Play(bool),
    Speed(f64),
    Record(PathBuf),
    Stop,
    Fly(PathBuf),
    Reload,
    Exposure(f32),
    Drag([f32; 2]),
    Screenshot(PathBuf),
    Live(PathBuf),
    Overlay(bool),
    Volumes(bool),
    Clusters(Option<Cells>),
    Split(Option<f32>),
    Difference(Option<f32>),
    Measure(PathBuf),
    Turn(PreRotation),
    LowMemory,
    Suspend,
    Resume,
    Stay,
}

impl Script {
    /// Reads a script's file.
    ///
    /// # Errors
    /// [`Error::Io`] if it cannot be read, [`Error::Input`] that names the line that is no command.
    pub fn load(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, "read", e))?;
        Self::parse(&text).map_err(|(line, problem)| {
            Error::input(
                path,
                format!("line {line}"),
                problem,
                "write one of the commands of 'ontile view --help'",
            )
        })
    }

    /// The line, from 1, and what is wrong with it.
    fn parse(text: &str) -> Result<Self, (usize, String)> {
        let mut steps = Vec::new();
        for (number, line) in (1..).zip(text.lines()) {
            let line = line.split('#').next().unwrap_or_default().trim();
            if !line.is_empty() {
                steps.push(step(line).map_err(|problem| (number, problem))?);
            }
        }
        Ok(Self { steps })
    }
}

fn step(line: &str) -> Result<Step, String> {
    let (command, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let rest = rest.trim();
    let needs = |what: &str| format!("'{command}' needs {what}");
    let file = || if rest.is_empty() { Err(needs("a file")) } else { Ok(PathBuf::from(rest)) };
    let alone = |step| if rest.is_empty() { Ok(step) } else { Err(format!("'{command}' stands alone")) };
    match command {
        "frames" => rest.parse().map(Step::Frames).map_err(|_| needs("a number of frames")),
        "size" => {
            let sides = rest.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
            sides
                .filter(|s| s.iter().all(|n| *n <= 32768))
                .map(Step::Size)
                .ok_or_else(|| needs("a size like 640x360"))
        }
        "open" => file().map(Step::Open),
        "scenes" => file().map(Step::Scenes),
        "pick" => rest.parse().map(Step::Pick).map_err(|_| needs("a scene's number")),
        "set" => {
            let pair = rest.split_once(char::is_whitespace);
            let (name, value) = pair.ok_or_else(|| needs("an option and its value"))?;
            Ok(Step::Set(name.into(), value.trim().into()))
        }
        "camera" if rest.is_empty() => Err(needs("a camera's number or name")),
        "camera" => Ok(Step::Camera(rest.into())),
        "animation" if rest.is_empty() => Err(needs("an animation's number or name, or all")),
        "animation" => Ok(Step::Animation(rest.into())),
        "time" => finite(rest).map(Step::Time).ok_or_else(|| needs("a number of seconds")),
        "speed" => finite(rest).map(Step::Speed).ok_or_else(|| needs("a factor")),
        "play" => alone(Step::Play(true)),
        "pause" => alone(Step::Play(false)),
        "record" => file().map(Step::Record),
        "stop" => alone(Step::Stop),
        "reload" => alone(Step::Reload),
        "fly" => file().map(Step::Fly),
        "exposure" => number(rest).map(Step::Exposure).ok_or_else(|| needs("a number of stops")),
        "drag" => {
            let pair = rest.split_once(char::is_whitespace);
            let pair = pair.and_then(|(x, y)| Some([number(x)?, number(y.trim())?]));
            pair.map(Step::Drag).ok_or_else(|| needs("two numbers of pixels"))
        }
        "screenshot" => file().map(Step::Screenshot),
        "live" => file().map(Step::Live),
        "split" | "difference" => {
            let (is_split, off) = (command == "split", rest == "off");
            let value = number(rest).filter(|n| if is_split { (0.0..=1.0).contains(n) } else { *n > 0.0 });
            let what = if is_split { "a share of the width, 0 to 1, or off" } else { "a factor, or off" };
            let value = if off { None } else { Some(value.ok_or_else(|| needs(what))?) };
            Ok(if is_split { Step::Split(value) } else { Step::Difference(value) })
        }
        "measure" => file().map(Step::Measure),
        "overlay" if rest == "on" => Ok(Step::Overlay(true)),
        "overlay" if rest == "off" => Ok(Step::Overlay(false)),
        "volumes" if rest == "on" => Ok(Step::Volumes(true)),
        "volumes" if rest == "off" => Ok(Step::Volumes(false)),
        "overlay" | "volumes" => Err(needs("on or off")),
        "clusters" if rest == "most" => Ok(Step::Clusters(Some(Cells::Most))),
        "clusters" if rest == "off" => Ok(Step::Clusters(None)),
        "clusters" => {
            let slice = rest.parse().map(|slice| Step::Clusters(Some(Cells::Slice(slice))));
            slice.map_err(|_| needs("most, the number of a slice, or off"))
        }
        "turn" => {
            let names = ["0", "90", "180", "270"];
            let index = names.iter().position(|name| *name == rest);
            index
                .map(|index| Step::Turn(PreRotation::ALL[index]))
                .ok_or_else(|| needs("0, 90, 180 or 270 degrees"))
        }
        "low-memory" => alone(Step::LowMemory),
        "suspend" => alone(Step::Suspend),
        "resume" => alone(Step::Resume),
        "stay" => alone(Step::Stay),
        _ => Err(format!("there is no command '{command}'")),
    }
}

fn number(text: &str) -> Option<f32> {
    f32::from_str(text).ok().filter(|number| number.is_finite())
}

fn finite(text: &str) -> Option<f64> {
    f64::from_str(text).ok().filter(|number| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_commands() {
        let text = "size 640x360 # at first\n\n  frames 3\nset layout packed128\nopen a b.glb\nscenes s.txt\npick 2\ncamera 1\ntime 0.5\nanimation all\nplay\nspeed -2\npause\nrecord a.flight\nstop\nfly a.flight\nreload\nexposure -1.5\n\
                    drag 10 -4\nscreenshot o.png\nlive l.json\noverlay on\nvolumes on\nclusters 3\nclusters most\nclusters off\nvolumes off\nsplit 0.25\ndifference 8\nsplit off\nmeasure m.json\nturn 90\nlow-memory\nsuspend\nresume\nstay\n";
        let expected = [
            Step::Size([640, 360]),
            Step::Frames(3),
            Step::Set("layout".into(), "packed128".into()),
            Step::Open("a b.glb".into()),
            Step::Scenes("s.txt".into()),
            Step::Pick(2),
            Step::Camera("1".into()),
            Step::Time(0.5),
            Step::Animation("all".into()),
            Step::Play(true),
            Step::Speed(-2.0),
            Step::Play(false),
            Step::Record("a.flight".into()),
            Step::Stop,
            Step::Fly("a.flight".into()),
            Step::Reload,
            Step::Exposure(-1.5),
            Step::Drag([10.0, -4.0]),
            Step::Screenshot("o.png".into()),
            Step::Live("l.json".into()),
            Step::Overlay(true),
            Step::Volumes(true),
            Step::Clusters(Some(Cells::Slice(3))),
            Step::Clusters(Some(Cells::Most)),
            Step::Clusters(None),
            Step::Volumes(false),
            Step::Split(Some(0.25)),
            Step::Difference(Some(8.0)),
            Step::Split(None),
            Step::Measure("m.json".into()),
            Step::Turn(PreRotation::Rotate90),
            Step::LowMemory,
            Step::Suspend,
            Step::Resume,
            Step::Stay,
        ];
        assert_eq!(Script::parse(text).unwrap().steps, expected);
        for (text, problem) in [
            ("frames", "needs a number"),
            ("frames -1", "needs a number"),
            ("size 3", "a size like"),
            ("size 3x99999", "a size like"),
            ("open", "needs a file"),
            ("pick lamps", "scene's number"),
            ("set layout", "an option and its value"),
            ("camera", "number or name"),
            ("time inf", "number of seconds"),
            ("animation", "number or name"),
            ("play now", "stands alone"),
            ("speed", "a factor"),
            ("exposure nan", "number of stops"),
            ("drag 1", "two numbers"),
            ("overlay", "on or off"),
            ("volumes", "on or off"),
            ("clusters all", "number of a slice"),
            ("split 2", "share of the width"),
            ("difference 0", "a factor"),
            ("turn 45", "90, 180"),
            ("stay here", "stands alone"),
            ("jump", "no command 'jump'"),
        ] {
            let (line, told) = Script::parse(&format!("# one\n{text}")).unwrap_err();
            assert!(line == 2 && told.contains(problem), "{text}: {told}");
        }
    }
}
