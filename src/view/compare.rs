//! Two ways to draw one scene: side by side, or how far they are apart.

use std::path::Path;

use winit::event::{ElementState, MouseButton, WindowEvent};

use super::app::{App, Open};
use crate::picture::{Picture, Pixels};
use crate::plan::Options;
use crate::{Error, Result};

/// What is compared with what, and how.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Compare {
    pub(super) how: How,
    /// What B's options have other than A's: names and values.
    pub(super) beside: Vec<(String, String)>,
}

/// How A, the viewer's own options, and B are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum How {
    /// A alone.
    #[default]
    Alone,
    /// A left of this share of the width, B right of it. Each is one pass over its part of the window's image.
    Split(f32),
    /// The absolute difference, amplified by this: A is stored, and sampled in B's pass.
    Difference(f32),
}

/// What the pointer does to the line between A and B.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Divider {
    is_held: bool,
    pointer_x: f64,
}

/// How far pictures of bytes are apart.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub(super) struct Apart {
    /// The largest difference of a channel, of 255.
    pub(super) most: u8,
    /// Of all channels of colour; nothing for equal pictures.
    pub(super) psnr_db: Option<f64>,
}

impl Apart {
    pub(super) fn new(a: &Picture, b: &Picture) -> Self {
        let (Pixels::Rgba8(a), Pixels::Rgba8(b)) = (&a.pixels, &b.pixels) else {
            unreachable!("a window has bytes")
        };
        let pixels = a.chunks_exact(4).zip(b.chunks_exact(4));
        let apart = || pixels.clone().flat_map(|(a, b)| (0..3).map(|c| a[c].abs_diff(b[c])));
        let squares: f64 = apart().map(|d| f64::from(d).powi(2)).sum();
        let count = apart().count().max(1) as f64;
        let psnr_db = (squares > 0.0).then(|| 10.0 * (255.0_f64.powi(2) * count / squares).log10());
        Self { most: apart().max().unwrap_or(0), psnr_db }
    }
}

impl std::fmt::Display for Apart {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.psnr_db {
            None => f.write_str("A and B are equal"),
            Some(db) => write!(f, "A and B differ by {} of 255 at most, PSNR {db:.1} dB", self.most),
        }
    }
}

impl Compare {
    /// B's options beside these of A.
    pub(super) fn beside(&self, a: &Options) -> Result<Options> {
        let mut options = a.clone();
        self.beside.iter().try_for_each(|(name, value)| options.set(name, value))?;
        Ok(options)
    }

    /// All that is drawn for a frame, in order.
    pub(super) fn drawn(&self, a: &Options) -> Result<Vec<Options>> {
        let b = self.beside(a)?;
        Ok(match self.how {
            How::Alone => vec![a.clone()],
            How::Split(_) => {
                if a.edge_filter || a.bloom != crate::plan::BloomWay::Off {
                    let problem =
                        "passes after the frame's own draw the whole picture, and a part of it is B's";
                    return Err(Error::unsupported(problem, "leave --bloom and --edge-filter out"));
                }
                vec![a.clone(), Options { output_is_kept: true, ..b }]
            }
            How::Difference(gain) => {
                let a = Options { overlay: false, output_use: crate::plan::OutputUse::Sample, ..a.clone() };
                vec![a, Options { difference: Some(gain), ..b }]
            }
        })
    }

    /// What each of them draws of a picture of this size: left, top, right and bottom, pixels.
    pub(super) fn parts(&self, [width, height]: [u32; 2]) -> [[u32; 4]; 2] {
        match self.how {
            How::Split(share) if width > 1 => {
                let at = ((share * width as f32).round() as u32).clamp(1, width - 1);
                [[0, 0, at, height], [at, 0, width, height]]
            }
            _ => [[0, 0, width, height]; 2],
        }
    }
}

/// Where keys and switches begin.
pub(super) const MIDDLE: f32 = 0.5;
/// The amplification that keys and switches begin with.
pub(super) const GAIN: f32 = 8.0;

impl App {
    /// Compares in this way, or goes on as before.
    pub(super) fn set_compare(&mut self, compare: Compare) {
        let moves = |how: &How| matches!(how, How::Split(_));
        let is_moved =
            moves(&self.compare.how) && moves(&compare.how) && self.compare.beside == compare.beside;
        let before = std::mem::replace(&mut self.compare, compare);
        if !is_moved && !self.set_options(self.viewer.options.clone()) {
            self.compare = before;
        }
    }

    pub(super) fn set_how(&mut self, how: How) {
        self.set_compare(Compare { how, ..self.compare.clone() });
    }

    /// Compares in this way, or in no way if it is the one already.
    pub(super) fn toggle(&mut self, how: How) {
        let is_now = std::mem::discriminant(&self.compare.how) == std::mem::discriminant(&how);
        self.set_how(if is_now { How::Alone } else { how });
    }

    /// Sets an option of B by its name.
    pub(super) fn set_beside(&mut self, name: &str, value: &str) {
        let mut compare = self.compare.clone();
        compare.beside.retain(|(known, _)| known != name);
        compare.beside.push((name.into(), value.into()));
        match compare.beside(&self.viewer.options) {
            Ok(_) => self.set_compare(compare),
            Err(error) => self.tell(&error),
        }
    }

    /// Moves the divider with the pointer while it is held; whether the event was for it.
    pub(super) fn drag_divider(&mut self, event: &WindowEvent) -> bool {
        /// How near the pointer has to be, pixels.
        const NEAR_PX: f64 = 8.0;
        let (How::Split(at), Some(width)) = (self.compare.how, self.open.as_ref().and_then(Open::width))
        else {
            self.divider.is_held = false;
            return false;
        };
        let width = f64::from(width.max(1));
        match event {
            WindowEvent::CursorMoved { position, .. } => {
                self.divider.pointer_x = position.x;
                if self.divider.is_held {
                    self.compare.how = How::Split((position.x / width).clamp(0.0, 1.0) as f32);
                }
            }
            WindowEvent::MouseInput { state, button: MouseButton::Left, .. } => {
                let is_near = (self.divider.pointer_x - f64::from(at) * width).abs() <= NEAR_PX;
                self.divider.is_held = *state == ElementState::Pressed && is_near;
            }
            _ => return false,
        }
        self.divider.is_held
    }

    /// Says how far A and B are apart, of whole pictures; writes it as JSON if there is a file for it.
    pub(super) fn measure(&mut self, path: Option<&Path>) -> Result<()> {
        let how = self.compare.how;
        if !matches!(how, How::Split(_)) {
            self.set_how(How::Split(MIDDLE));
        }
        let view = crate::gpu::View { camera: &self.rig.camera, exposure_ev: self.viewer.exposure_ev };
        let apart = match &mut self.open {
            Some(open) if matches!(self.compare.how, How::Split(_)) => open.frames.apart(&view)?,
            _ => None,
        };
        self.set_how(how);
        let Some(apart) = apart else {
            self.tell_text("A and B could not be drawn beside each other");
            return Ok(());
        };
        self.message.replace(apart.to_string());
        let Some(path) = path else { return Ok(()) };
        let json = serde_json::to_string(&apart).map_err(|e| Error::io(path, "write", e.into()))?;
        crate::file::write_whole(path, json.as_bytes())
    }
}

impl Open {
    fn width(&self) -> Option<u32> {
        self.frames.size().map(|[width, _]| width)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Layout;

    #[test]
    fn parts_meet_and_options_follow() {
        let mut compare = Compare { how: How::Split(0.25), ..Compare::default() };
        assert_eq!(compare.parts([100, 50]), [[0, 0, 25, 50], [25, 0, 100, 50]]);
        for share in [-1.0, 0.0, 1.0, 2.0] {
            compare.how = How::Split(share);
            let [a, b] = compare.parts([100, 50]);
            assert!(a[2] == b[0] && (1..100).contains(&a[2]), "{share}: {a:?} {b:?}");
        }
        compare.beside.push(("layout".into(), "packed128".into()));
        let a = Options { samples: 4, ..Options::default() };
        let drawn = compare.drawn(&a).unwrap();
        assert_eq!((drawn[0].layout, drawn[1].layout), (Layout::Metallic128, Layout::Packed128));
        assert!(drawn[1].samples == 4 && drawn[1].output_is_kept && !drawn[0].output_is_kept);
        let whole = Options { edge_filter: true, ..Options::default() };
        assert!(compare.drawn(&whole).is_err());
        compare.how = How::Alone;
        assert_eq!(compare.drawn(&whole).unwrap(), [whole]);
    }

    #[test]
    fn pictures_are_apart() {
        let of = |pixels: &[u8]| Picture { width: 2, height: 1, pixels: Pixels::Rgba8(pixels.into()) };
        let a = of(&[1, 2, 3, 255, 4, 5, 6, 255]);
        assert_eq!(Apart::new(&a, &a), Apart { most: 0, psnr_db: None });
        let apart = Apart::new(&a, &of(&[1, 2, 3, 0, 4, 5, 0, 255]));
        // 6 in one of six channels.
        assert_eq!((apart.most, apart.psnr_db.unwrap()), (6, 10.0 * (255.0_f64.powi(2) / 6.0).log10()));
    }
}
