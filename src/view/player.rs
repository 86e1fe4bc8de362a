//! Animations as they play.

use egui::{ComboBox, Slider, SliderClamping, Ui};

use super::app::App;
use crate::scene::{Play, Scene, World};
use crate::{Error, Result};

/// What of a scene's animations is seen, and how it goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Controls {
    /// The animation's number; `None`: all at once.
    pub(super) animation: Option<usize>,
    /// Seconds from its begin.
    pub(super) time_s: f64,
    /// Seconds of it a second.
    pub(super) speed: f64,
    pub(super) is_playing: bool,
}

/// The animations of a scene that has some.
#[derive(Debug)]
pub(super) struct Player {
    pub(super) controls: Controls,
    names: Vec<String>,
    durations_s: Vec<f64>,
    /// As the scene was posed last.
    posed: Option<Controls>,
    playing: Vec<Play>,
}

/// A key goes this far, seconds.
const STEP_S: f64 = 1.0 / 30.0;
/// Speeds that keys and the panel give.
const SPEEDS: std::ops::RangeInclusive<f64> = 1.0 / 16.0..=16.0;

impl Player {
    /// What plays from its begin, or stands; `None` for a scene that stands still.
    pub(super) fn new(scene: &Scene, is_playing: bool) -> Option<Self> {
        let motion = scene.motion.as_ref().filter(|motion| !motion.animations.is_empty())?;
        let animations = || motion.animations.iter();
        Some(Self {
            controls: Controls { animation: Some(0), time_s: 0.0, speed: 1.0, is_playing },
            names: animations().map(|animation| animation.name.clone()).collect(),
            durations_s: animations().map(|animation| animation.duration_s().into()).collect(),
            posed: None,
            playing: Vec::new(),
        })
    }

    /// The same, begun with what a viewer names.
    pub(super) fn first(
        scene: &Scene,
        animation: Option<&str>,
        time_s: Option<f64>,
        is_playing: bool,
    ) -> Result<Option<Self>> {
        let mut player = Self::new(scene, is_playing && time_s.is_none());
        if animation.is_none() && time_s.is_none() {
            return Ok(player);
        }
        let begun = player.as_mut().ok_or_else(|| still(scene))?;
        begun.choose(scene, animation.unwrap_or("0"))?;
        begun.controls.time_s = time_s.unwrap_or(0.0);
        Ok(player)
    }

    /// Takes an animation by its number or name, or `all`.
    fn choose(&mut self, scene: &Scene, wanted: &str) -> Result<()> {
        let motion = scene.motion.as_ref().ok_or_else(|| still(scene))?;
        self.controls.animation = match wanted {
            "all" => None,
            one => Some(motion.animation(one)?),
        };
        Ok(())
    }

    /// Its part of the interface: what was made of the controls, if something was.
    pub(super) fn panel(&self, ui: &mut Ui) -> Option<Controls> {
        let mut now = self.controls;
        let name = |index: Option<usize>| match index {
            Some(one) => format!("{one} {}", self.names[one]),
            None => "all".into(),
        };
        ui.horizontal(|ui| {
            let sign = if now.is_playing { "stop" } else { "play" };
            now.is_playing ^= ui.button(sign).clicked();
            ComboBox::from_id_salt("animation").selected_text(name(now.animation)).show_ui(ui, |ui| {
                let several = Some(None).filter(|_| self.names.len() > 1);
                for index in (0..self.names.len()).map(Some).chain(several) {
                    ui.selectable_value(&mut now.animation, index, name(index));
                }
            });
            ui.add(Slider::new(&mut now.speed, SPEEDS).logarithmic(true).suffix(" x"));
        });
        let end = self.duration_s().max(1e-3);
        ui.spacing_mut().slider_width = 260.0;
        ui.add(Slider::new(&mut now.time_s, 0.0..=end).suffix(" s").clamping(SliderClamping::Never));
        (now != self.controls).then_some(now)
    }

    /// Of what was chosen; of all that of the longest.
    pub(super) fn duration_s(&self) -> f64 {
        match self.controls.animation {
            Some(one) => self.durations_s.get(one).copied().unwrap_or(0.0),
            None => self.durations_s.iter().copied().fold(0.0, f64::max),
        }
    }

    /// Goes on by some seconds of the user's, and begins again after the end.
    fn go_on(&mut self, seconds: f64) {
        // What was not seen yet begins where it was told to.
        if self.controls.is_playing && self.posed.is_some() {
            self.step(seconds * self.controls.speed);
        }
    }

    /// Goes so many of its own seconds.
    fn step(&mut self, seconds: f64) {
        let duration_s = self.duration_s();
        let time_s = self.controls.time_s + seconds;
        self.controls.time_s = if duration_s > 0.0 { time_s.rem_euclid(duration_s) } else { 0.0 };
    }

    /// Brings the scene to what is to be seen, if it is not there.
    fn pose(&mut self, world: &mut World) -> Result<()> {
        let Controls { animation, time_s, .. } = self.controls;
        if self.posed.replace(self.controls).is_some_and(|p| (p.animation, p.time_s) == (animation, time_s)) {
            return Ok(());
        }
        self.playing.clear();
        let chosen = animation.map_or(0..self.names.len(), |one| one..one + 1);
        self.playing.extend(chosen.map(|animation| Play { animation, time_s }));
        world.animate(&self.playing)
    }
}

fn still(scene: &Scene) -> Error {
    Error::unsupported(
        format!("nothing of scene '{}' is animated", scene.name),
        "ask for no time and no animation, or show a file whose animations move what is drawn",
    )
}

impl App {
    /// Moves the scene to where its animations have it after so many seconds, and the camera with it unless it is in a hand.
    pub(super) fn play(&mut self, seconds: f64) {
        let Some(player) = &mut self.player else { return };
        player.go_on(seconds);
        if let Err(error) = player.pose(&mut self.world) {
            player.controls.is_playing = false;
            self.tell(&error);
        }
        self.rig.follow(self.world.scene());
    }

    /// What a script asks of the scene's animations.
    pub(super) fn control(&mut self, change: impl FnOnce(&mut Controls)) -> Result<()> {
        let player = self.player.as_mut().ok_or_else(|| still(self.world.scene()))?;
        change(&mut player.controls);
        Ok(())
    }

    /// Takes one of the scene's animations, or all.
    pub(super) fn set_animation(&mut self, wanted: &str) -> Result<()> {
        let scene = self.world.scene();
        self.player.as_mut().ok_or_else(|| still(scene))?.choose(scene, wanted)
    }

    /// The animation after this one; after the last all of them, if they are several.
    pub(super) fn next_animation(&mut self) {
        let Some(player) = &mut self.player else { return };
        let count = player.names.len();
        player.controls.animation = match player.controls.animation {
            Some(last) if last + 1 == count => (count == 1).then_some(0),
            Some(one) => Some(one + 1),
            None => Some(0),
        };
    }

    /// Stops, so many steps further.
    pub(super) fn step_animation(&mut self, steps: i32) {
        let Some(player) = &mut self.player else { return };
        player.controls.is_playing = false;
        player.step(f64::from(steps) * STEP_S);
    }

    /// Plays so many times twice as fast.
    pub(super) fn hasten(&mut self, doublings: i32) {
        let Some(player) = &mut self.player else { return };
        let speed = player.controls.speed * f64::from(doublings).exp2();
        player.controls.speed = speed.clamp(*SPEEDS.start(), *SPEEDS.end());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Animation, Channel, Interpolation, Motion, Node, NodeTransform, Property};

    fn scene() -> Scene {
        let node =
            Node { name: String::new(), parent: None, transform: NodeTransform::IDENTITY, weights: vec![] };
        let animation = |name: &str, end_s: f32| Animation {
            name: name.into(),
            channels: vec![Channel {
                node: 0,
                property: Property::Translation,
                interpolation: Interpolation::Linear,
                times_s: vec![0.0, end_s],
                values: vec![0.0; 6],
            }],
        };
        let animations = vec![animation("walk", 2.0), animation("run", 0.5)];
        let motion = Motion { nodes: vec![node], animations, ..Motion::default() };
        Scene { motion: Some(motion), ..Scene::default() }
    }

    #[test]
    fn time_goes_round_once_something_was_seen() {
        let scene = scene();
        let mut world = World::from(scene.clone());
        let mut player = Player::new(&scene, true).unwrap();
        player.go_on(0.75);
        assert_eq!(player.controls.time_s, 0.0, "nothing was seen yet");
        player.pose(&mut world).unwrap();
        player.controls.speed = 2.0;
        player.go_on(0.75);
        assert_eq!(player.controls.time_s, 1.5);
        player.go_on(0.5);
        assert_eq!(player.controls.time_s, 0.5);
        player.step(-0.75);
        assert_eq!(player.controls.time_s, 1.75);
        player.controls.is_playing = false;
        player.go_on(1.0);
        assert_eq!(player.controls.time_s, 1.75);
        player.choose(&scene, "all").unwrap();
        assert_eq!(player.duration_s(), 2.0);
        player.choose(&scene, "run").unwrap();
        assert_eq!((player.controls.animation, player.duration_s()), (Some(1), 0.5));
    }

    #[test]
    fn what_is_named_is_begun_with() {
        let scene = scene();
        let player = Player::first(&scene, Some("1"), Some(7.0), true).unwrap().unwrap();
        let Controls { animation, time_s, is_playing, .. } = player.controls;
        assert_eq!((animation, time_s, is_playing), (Some(1), 7.0, false));
        assert!(Player::first(&scene, Some("all"), None, true).unwrap().unwrap().controls.is_playing);
        let error = Player::first(&scene, Some("jump"), None, true).unwrap_err().to_string();
        assert!(error.contains("0 (walk), 1 (run)"), "{error}");
        let still = Scene::default();
        assert!(Player::first(&still, None, None, true).unwrap().is_none());
        let error = Player::first(&still, None, Some(0.0), true).unwrap_err().to_string();
        assert!(error.contains("nothing of scene"), "{error}");
    }
}
