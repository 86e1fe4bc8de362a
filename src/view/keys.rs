//! The keyboard.

use std::collections::BTreeSet;

use glam::Vec3;
use winit::event::{ElementState, KeyEvent};
use winit::keyboard::{KeyCode, PhysicalKey};

use super::course::CourseWish;

/// What keys ask for, once each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wish {
    Quit,
    Help,
    /// Between orbiting and flying.
    Motion,
    /// The n-th camera of the scene.
    Camera(usize),
    NextCamera,
    /// Half stops.
    Expose(i32),
    Screenshot,
    Fullscreen,
    Overlay,
    /// Animations go on, or stop.
    Play,
    NextAnimation,
    /// Stops them, so many steps further.
    Step(i32),
    /// So many times twice as fast.
    Hasten(i32),
    /// Records or flies a camera path, or stops that.
    Course(CourseWish),
    /// What else there is to show; whether backwards.
    Show(bool),
    /// Outlines of the light volumes, or none.
    Volumes,
    /// The cells that lights are listed in, or none.
    Clusters,
    /// A beside B, or A alone.
    Split,
    /// How far they are apart, likewise.
    Difference,
}

/// The keys, for people.
pub const HELP: &str = "\
drag, one finger      turn (orbit, or look around while flying)
right drag, shift-drag, two fingers   pan
wheel, pinch          nearer and further
F                     orbit / fly
F2                    the overlay: times, plan, bytes, options
G, Shift-G            what is shown: the picture, the G-buffer's channels, lights, edges
L, Shift-L            outlines of the light volumes and shadow cascades; the cells that lights are listed in
B, V                  two ways to draw it: side by side (drag the divider), or their difference
W A S D, Q E          fly; with Shift ten times as fast
1 to 9, C             the scene's cameras, the next camera
- =                   exposure by half a stop
space, N              animation: play or stop, the next one
, .   [ ]             a step back and on; half and twice the speed
R, T                  record the camera's path, or stop and write it; fly it
P                     screenshot
F11                   full screen
H, F1                 this help
Esc                   quit
A scene file that is dropped on the window is opened, a .flight is flown.";

/// Keys that are held.
#[derive(Debug, Default)]
pub(super) struct Keys {
    held: BTreeSet<KeyCode>,
}

impl Keys {
    pub(super) fn event(&mut self, event: &KeyEvent) -> Option<Wish> {
        let PhysicalKey::Code(code) = event.physical_key else { return None };
        if event.state == ElementState::Released {
            self.held.remove(&code);
            return None;
        }
        self.held.insert(code);
        let camera = |n| Some(Wish::Camera(n));
        match code {
            KeyCode::Minus | KeyCode::NumpadSubtract => Some(Wish::Expose(-1)),
            KeyCode::Equal | KeyCode::NumpadAdd => Some(Wish::Expose(1)),
            KeyCode::Comma => Some(Wish::Step(-1)),
            KeyCode::Period => Some(Wish::Step(1)),
            _ if event.repeat => None,
            KeyCode::Space => Some(Wish::Play),
            KeyCode::KeyN => Some(Wish::NextAnimation),
            KeyCode::KeyR => Some(Wish::Course(CourseWish::Record)),
            KeyCode::KeyT => Some(Wish::Course(CourseWish::Fly)),
            KeyCode::BracketLeft => Some(Wish::Hasten(-1)),
            KeyCode::BracketRight => Some(Wish::Hasten(1)),
            KeyCode::Escape => Some(Wish::Quit),
            KeyCode::KeyH | KeyCode::F1 => Some(Wish::Help),
            KeyCode::KeyF => Some(Wish::Motion),
            KeyCode::F2 => Some(Wish::Overlay),
            KeyCode::KeyG => Some(Wish::Show(self.shift())),
            KeyCode::KeyL => Some(if self.shift() { Wish::Clusters } else { Wish::Volumes }),
            KeyCode::KeyB => Some(Wish::Split),
            KeyCode::KeyV => Some(Wish::Difference),
            KeyCode::Digit1 => camera(0),
            KeyCode::Digit2 => camera(1),
            KeyCode::Digit3 => camera(2),
            KeyCode::Digit4 => camera(3),
            KeyCode::Digit5 => camera(4),
            KeyCode::Digit6 => camera(5),
            KeyCode::Digit7 => camera(6),
            KeyCode::Digit8 => camera(7),
            KeyCode::Digit9 => camera(8),
            KeyCode::KeyC => Some(Wish::NextCamera),
            KeyCode::KeyP => Some(Wish::Screenshot),
            KeyCode::F11 => Some(Wish::Fullscreen),
            _ => None,
        }
    }

    pub(super) fn release(&mut self) {
        self.held.clear();
    }

    pub(super) fn shift(&self) -> bool {
        self.held.contains(&KeyCode::ShiftLeft) || self.held.contains(&KeyCode::ShiftRight)
    }

    /// Where the held keys fly to, in view space.
    pub(super) fn flight(&self) -> Vec3 {
        let way = |positive, negative| {
            f32::from(u8::from(self.held.contains(&positive)))
                - f32::from(u8::from(self.held.contains(&negative)))
        };
        let direction = Vec3::new(
            way(KeyCode::KeyD, KeyCode::KeyA),
            way(KeyCode::KeyE, KeyCode::KeyQ),
            way(KeyCode::KeyS, KeyCode::KeyW),
        );
        direction * if self.shift() { 10.0 } else { 1.0 }
    }
}
