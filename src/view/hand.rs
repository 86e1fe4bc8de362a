//! Pointer and fingers: what they do to the camera.

use std::collections::BTreeMap;

use glam::{DVec2, Vec2, dvec2};
use winit::event::{ElementState, MouseButton, MouseScrollDelta, Touch, TouchPhase, WindowEvent};

use super::rig::Rig;

/// What is held, and where.
#[derive(Debug, Default)]
pub(super) struct Hand {
    pointer: DVec2,
    turns: bool,
    pans: bool,
    /// The fingers on the screen, by the system's number.
    fingers: BTreeMap<u64, DVec2>,
}

/// A drag over the picture's height turns by this much, radians.
const TURN_RAD: f32 = std::f32::consts::PI;
/// A step of the wheel brings the camera this much nearer.
const WHEEL_FACTOR: f64 = 0.9;
/// As far as a step of the wheel, pixels.
const WHEEL_PX: f64 = 40.0;

/// Turns the camera as if something was dragged so many pixels.
pub(super) fn turn(rig: &mut Rig, by: DVec2, height_px: f64) {
    let Vec2 { x, y } = (by / height_px.max(1.0)).as_vec2() * TURN_RAD;
    rig.turn(x, y);
}

impl Hand {
    /// Takes a window's event; `shift` is held. Whether it moved the camera.
    pub(super) fn event(&mut self, event: &WindowEvent, shift: bool, height_px: f64, rig: &mut Rig) -> bool {
        let height_px = height_px.max(1.0);
        match event {
            WindowEvent::MouseInput { state, button, .. } => {
                let down = *state == ElementState::Pressed;
                match button {
                    MouseButton::Left if down && shift => self.pans = true,
                    MouseButton::Left => (self.turns, self.pans) = (down, false),
                    MouseButton::Right | MouseButton::Middle => self.pans = down,
                    _ => {}
                }
                false
            }
            WindowEvent::CursorMoved { position, .. } => {
                let to = dvec2(position.x, position.y);
                let by = to - std::mem::replace(&mut self.pointer, to);
                if self.pans {
                    let by = (by / height_px).as_vec2();
                    rig.pan(by.x, by.y);
                } else if self.turns {
                    turn(rig, by, height_px);
                }
                self.pans || self.turns
            }
            WindowEvent::MouseWheel { delta, .. } => {
                let steps = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => f64::from(*lines),
                    MouseScrollDelta::PixelDelta(px) => px.y / WHEEL_PX,
                };
                rig.zoom(WHEEL_FACTOR.powf(steps.clamp(-20.0, 20.0)) as f32);
                true
            }
            WindowEvent::PinchGesture { delta, .. } => {
                rig.zoom((1.0 - delta.clamp(-0.5, 0.5)) as f32);
                true
            }
            WindowEvent::Touch(touch) => self.touch(touch, height_px, rig),
            WindowEvent::CursorLeft { .. } | WindowEvent::Focused(false) => {
                self.release();
                false
            }
            _ => false,
        }
    }

    /// Lets go of everything.
    pub(super) fn release(&mut self) {
        (self.turns, self.pans) = (false, false);
        self.fingers.clear();
    }

    /// One finger turns; two pan by their middle and zoom by their distance.
    fn touch(&mut self, touch: &Touch, height_px: f64, rig: &mut Rig) -> bool {
        let to = dvec2(touch.location.x, touch.location.y);
        match touch.phase {
            TouchPhase::Started => {
                self.fingers.insert(touch.id, to);
                false
            }
            TouchPhase::Ended | TouchPhase::Cancelled => {
                self.fingers.remove(&touch.id);
                false
            }
            TouchPhase::Moved => {
                let Some(from) = self.fingers.insert(touch.id, to) else { return false };
                let others = self.fingers.iter().filter(|(id, _)| **id != touch.id);
                let others: Vec<_> = others.map(|(_, place)| *place).collect();
                match others[..] {
                    [] => turn(rig, to - from, height_px),
                    [other] => {
                        let by = ((to - from) * 0.5 / height_px).as_vec2();
                        rig.pan(by.x, by.y);
                        let (before, after) = (from.distance(other).max(1.0), to.distance(other).max(1.0));
                        rig.zoom((before / after).clamp(0.5, 2.0) as f32);
                    }
                    _ => return false,
                }
                true
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Projection, Scene};
    use crate::view::rig::Motion;
    use glam::{Mat4, Vec3, vec3};
    use winit::dpi::PhysicalPosition;
    use winit::event::DeviceId;

    fn rig() -> Rig {
        let projection = Projection::Perspective { yfov_rad: 1.0, znear_m: 0.1, zfar_m: None };
        let world_from_view = Mat4::from_translation(vec3(0.0, 0.0, 5.0));
        let camera = Camera { name: String::new(), world_from_view, projection };
        Rig::new(&Scene { cameras: vec![camera], ..Scene::default() }, 0, Motion::Orbit)
    }

    fn eye(rig: &Rig) -> Vec3 {
        rig.camera.world_from_view.w_axis.truncate()
    }

    fn touch(id: u64, phase: TouchPhase, x: f64, y: f64) -> WindowEvent {
        let location = PhysicalPosition::new(x, y);
        WindowEvent::Touch(Touch { device_id: DeviceId::dummy(), phase, location, force: None, id })
    }

    #[test]
    fn fingers_turn_pan_and_zoom() {
        let (mut hand, mut rig) = (Hand::default(), rig());
        let give = |hand: &mut Hand, rig: &mut Rig, event| hand.event(&event, false, 100.0, rig);
        assert!(!give(&mut hand, &mut rig, touch(7, TouchPhase::Started, 50.0, 50.0)));
        assert!(give(&mut hand, &mut rig, touch(7, TouchPhase::Moved, 60.0, 50.0)));
        assert!(eye(&rig).x < 0.0, "one finger turns");
        let before = eye(&rig);
        give(&mut hand, &mut rig, touch(8, TouchPhase::Started, 80.0, 50.0));
        give(&mut hand, &mut rig, touch(8, TouchPhase::Moved, 100.0, 50.0));
        give(&mut hand, &mut rig, touch(7, TouchPhase::Moved, 40.0, 50.0));
        assert!(eye(&rig).distance(before) > 0.0 && eye(&rig).z < before.z, "fingers apart bring it nearer");
        give(&mut hand, &mut rig, touch(8, TouchPhase::Ended, 100.0, 50.0));
        give(&mut hand, &mut rig, touch(7, TouchPhase::Ended, 40.0, 50.0));
        assert!(!give(&mut hand, &mut rig, touch(7, TouchPhase::Moved, 0.0, 0.0)), "no finger is down");
    }
}
