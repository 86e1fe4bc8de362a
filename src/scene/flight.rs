//! The path of a camera over time: recorded, kept as text, flown again.

use std::fmt::Write;
use std::path::Path;

use glam::{DMat4, DQuat, DVec3, Mat3, Quat, Vec3};

use super::{Camera, Projection};
use crate::{Error, Result, file};

/// Where a camera was at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlightKey {
    /// Seconds.
    pub time_s: f64,
    /// World space, metres.
    pub eye_m: Vec3,
    /// What turns view space (looking along -Z, +Y up) into world space; unit length.
    pub rotation: Quat,
    /// Full vertical field of view, radians; `None` for a parallel projection, which stays as it is.
    pub yfov_rad: Option<f32>,
}

/// A camera's path: at each key it is where the key says, and between them it moves smoothly.
///
/// Positions are cubic Hermite splines whose velocity at a key is none where a neighbour is at the same place, else that of the parabola
/// through it and its neighbours (the Catmull-Rom
/// spline for keys at any times: Barry and Goldman, "A recursive evaluation algorithm for a class of Catmull-Rom splines", SIGGRAPH
/// 1988). Rotations are the same on unit quaternions: cumulative Bezier curves of the angular velocities (Kim, Kim and Shin, "A general
/// construction scheme for unit quaternion curves", SIGGRAPH 1995, section 4.1), the shorter way from key to key. The field of view changes
/// linearly.
///
/// A file of one is text:
///
/// ```text
/// ontile flight 1
/// # seconds, eye x y z (m), rotation x y z w, vertical field of view (rad) or -
/// 0     0 1.6 4   0 0 0 1             0.8
/// 1.5   2 1.6 3   0 0.2588 0 0.9659   0.8
/// ```
///
/// What follows `#` is a comment. Times rise; rotations are made unit length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Flight {
    keys: Vec<FlightKey>,
}

/// The first line of a file.
const FIRST: &str = "ontile flight 1";
/// The second one, for people.
const COLUMNS: &str = "# seconds, eye x y z (m), rotation x y z w, vertical field of view (rad) or -";
const REMEDY: &str = "give each line a time after the one before, three metres, a rotation of four numbers, and an angle in radians or -";

impl FlightKey {
    /// Where a camera is now.
    pub fn of(camera: &Camera, time_s: f64) -> Self {
        let yfov_rad = match camera.projection {
            Projection::Perspective { yfov_rad, .. } => Some(yfov_rad),
            Projection::Orthographic { .. } => None,
        };
        let rotation = Quat::from_mat3(&Mat3::from_mat4(camera.world_from_view)).normalize();
        Self { time_s, eye_m: camera.world_from_view.w_axis.truncate(), rotation, yfov_rad }
    }

    /// Whether the camera is the same, whatever the time.
    fn is_at(&self, other: &Self) -> bool {
        Self { time_s: 0.0, ..*self } == Self { time_s: 0.0, ..*other }
    }

    /// What is wrong with it after an earlier one.
    fn problem(&self, before: Option<&Self>) -> Option<String> {
        let is_angle = |angle: f32| angle > 0.0 && angle < std::f32::consts::PI;
        if !self.time_s.is_finite() || !self.eye_m.is_finite() {
            Some("has a number that is not finite".into())
        } else if let Some(before) = before.filter(|before| before.time_s >= self.time_s) {
            Some(format!(
                "is at {} s, which is not after the one before, at {} s",
                self.time_s, before.time_s
            ))
        } else if !(self.rotation.is_finite() && self.rotation.length_squared() > f32::MIN_POSITIVE) {
            Some("has a rotation without length".into())
        } else {
            let bad = self.yfov_rad.filter(|angle| !is_angle(*angle))?;
            Some(format!("has a field of view of {bad} rad, which is not between 0 and pi"))
        }
    }
}

impl Flight {
    /// A flight by these keys.
    ///
    /// # Errors
    /// [`Error::Unsupported`] that names the key, from 0, that is not after the one before or holds a number that means nothing; or if
    /// there is none.
    pub fn new(keys: Vec<FlightKey>) -> Result<Self> {
        let mut flight = Self::default();
        for (index, key) in keys.into_iter().enumerate() {
            let pushed = flight.push(key);
            pushed.map_err(|problem| {
                Error::unsupported(format!("key {index} of a flight {problem}"), REMEDY)
            })?;
        }
        match flight.keys.is_empty() {
            true => Err(Error::unsupported("a flight has no keys", "give it one at least")),
            false => Ok(flight),
        }
    }

    /// Adds a key at the end, unless it is not after the last or means nothing; of three at the same place the middle one is not kept.
    pub fn record(&mut self, key: FlightKey) {
        if let [.., a, b] = self.keys[..]
            && a.is_at(&b)
            && b.is_at(&key)
            && key.time_s > b.time_s
        {
            self.keys.pop();
        }
        // What it refuses is no part of the way.
        let _ = self.push(key);
    }

    fn push(&mut self, key: FlightKey) -> std::result::Result<(), String> {
        match key.problem(self.keys.last()) {
            Some(problem) => Err(problem),
            None => {
                // What is of unit length stays to the bit.
                let rotation = key.rotation;
                let rotation = if rotation.is_normalized() { rotation } else { rotation.normalize() };
                self.keys.push(FlightKey { rotation, ..key });
                Ok(())
            }
        }
    }

    /// The keys, in the order of time: one at least, unless it is [`Self::default`].
    pub fn keys(&self) -> &[FlightKey] {
        &self.keys
    }

    /// The time of the last key, seconds after that of the first.
    pub fn duration_s(&self) -> f64 {
        match &self.keys[..] {
            [first, .., last] => last.time_s - first.time_s,
            _ => 0.0,
        }
    }

    /// Brings a camera to where the path is so many seconds after its first key; before and after it, to its ends.
    pub fn place(&self, camera: &mut Camera, seconds: f64) {
        let Some(key) = self.at(seconds) else { return };
        camera.world_from_view = DMat4::from_rotation_translation(unit(&key), key.eye_m.as_dvec3()).as_mat4();
        if let (Projection::Perspective { yfov_rad, .. }, Some(angle)) =
            (&mut camera.projection, key.yfov_rad)
        {
            *yfov_rad = angle;
        }
    }

    /// As [`Self::place`]; `None` without keys.
    pub fn at(&self, seconds: f64) -> Option<FlightKey> {
        let begin_s = self.keys.first()?.time_s;
        let after = self.keys.partition_point(|key| key.time_s - begin_s <= seconds);
        if after == 0 || after == self.keys.len() || self.keys[after - 1].time_s - begin_s == seconds {
            return Some(self.keys[after.saturating_sub(1)]);
        }
        let (a, b) = (after - 1, after);
        let (first, last) = (&self.keys[a], &self.keys[b]);
        let step_s = last.time_s - first.time_s;
        let time_s = begin_s + seconds;
        let t = (time_s - first.time_s) / step_s;
        let [from, to] = [a, b].map(|key| self.velocity(key));
        let (p, q) = (first.eye_m.as_dvec3(), last.eye_m.as_dvec3());
        let bezier = [p, p + from.eye * (step_s / 3.0), q - to.eye * (step_s / 3.0), q];
        let s = 1.0 - t;
        let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
        let eye: DVec3 = bezier.iter().zip(weights).map(|(point, weight)| *point * weight).sum();
        // Of the same curve, in the frame of the key before: what is left of each step, summed up.
        let begin = unit(first);
        let (out, home) = (from.turn * (step_s / 3.0), to.turn * (step_s / 3.0));
        let exp = DQuat::from_scaled_axis;
        let between = turn((begin * exp(out)).inverse() * unit(last) * exp(-home));
        let shares = [1.0 - s * s * s, 3.0 * t * t - 2.0 * t * t * t, t * t * t];
        let rotation = begin * exp(out * shares[0]) * exp(between * shares[1]) * exp(home * shares[2]);
        let yfov_rad = match (first.yfov_rad, last.yfov_rad) {
            (Some(a), Some(b)) => Some((f64::from(a) * s + f64::from(b) * t) as f32),
            (one, other) => one.or(other),
        };
        Some(FlightKey { time_s, eye_m: eye.as_vec3(), rotation: rotation.normalize().as_quat(), yfov_rad })
    }

    /// How the path goes through a key.
    fn velocity(&self, key: usize) -> Velocity {
        let step = |a: usize, b: usize| {
            let (a, b) = (&self.keys[a], &self.keys[b]);
            let step_s = b.time_s - a.time_s;
            let eye = (b.eye_m.as_dvec3() - a.eye_m.as_dvec3()) / step_s;
            let turned = turn(unit(a).inverse() * unit(b));
            (Velocity { eye, turn: turned / step_s }, step_s)
        };
        let stands = |other: usize| self.keys.get(other).is_some_and(|other| other.is_at(&self.keys[key]));
        if key.checked_sub(1).is_some_and(stands) || stands(key + 1) {
            return Velocity { eye: DVec3::ZERO, turn: DVec3::ZERO };
        }
        match (key.checked_sub(1), key + 1 < self.keys.len()) {
            (Some(before), true) => {
                let ((came, came_s), (goes, goes_s)) = (step(before, key), step(key, key + 1));
                let share = came_s / (came_s + goes_s);
                Velocity { eye: came.eye.lerp(goes.eye, share), turn: came.turn.lerp(goes.turn, share) }
            }
            (Some(before), false) => step(before, key).0,
            (None, true) => step(key, key + 1).0,
            (None, false) => Velocity { eye: DVec3::ZERO, turn: DVec3::ZERO },
        }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`Error::Io`] if it cannot be read; [`Error::Input`] that names the line.
    pub fn load(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, "read", e))?;
        Self::parse(&text)
            .map_err(|(line, problem, remedy)| Error::input(path, format!("line {line}"), problem, remedy))
    }

    /// Writes a file: the whole of it, or none.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn save(&self, path: &Path) -> Result<()> {
        file::write_whole(path, self.text().as_bytes())
    }

    fn text(&self) -> String {
        let mut text = format!("{FIRST}\n{COLUMNS}\n");
        for FlightKey { time_s, eye_m, rotation, yfov_rad } in &self.keys {
            let [x, y, z] = eye_m.to_array();
            let [i, j, k, w] = rotation.to_array();
            let angle = yfov_rad.map_or("-".into(), |angle| angle.to_string());
            // Text takes all.
            let _ = writeln!(text, "{time_s}  {x} {y} {z}  {i} {j} {k} {w}  {angle}");
        }
        text
    }

    /// The line, from 1, what is wrong with it, and what to do.
    fn parse(text: &str) -> std::result::Result<Self, (usize, String, &'static str)> {
        let mut lines = (1..).zip(text.lines().map(|line| line.split('#').next().unwrap_or_default().trim()));
        let first = lines.find(|(_, line)| !line.is_empty());
        if first.is_none_or(|(_, line)| line != FIRST) {
            let line = first.map_or(1, |(number, _)| number);
            return Err((line, format!("is not '{FIRST}'"), "use a file that 'ontile view' recorded"));
        }
        let mut flight = Self::default();
        let mut last = 1;
        for (number, line) in lines.filter(|(_, line)| !line.is_empty()) {
            last = number;
            let key = key(line).and_then(|key| flight.push(key));
            key.map_err(|problem| (number, problem, REMEDY))?;
        }
        match flight.keys.is_empty() {
            true => Err((last, "is the last, and there was no key".into(), REMEDY)),
            false => Ok(flight),
        }
    }
}

/// Metres a second in world space, and radians a second about an axis of the camera's own.
struct Velocity {
    eye: DVec3,
    turn: DVec3,
}

fn unit(key: &FlightKey) -> DQuat {
    key.rotation.as_dquat().normalize()
}

/// Radians about an axis: the shorter way round.
fn turn(rotation: DQuat) -> DVec3 {
    if rotation.w < 0.0 { -rotation } else { rotation }.normalize().to_scaled_axis()
}

fn key(line: &str) -> std::result::Result<FlightKey, String> {
    let words: Vec<_> = line.split_whitespace().collect();
    let [time, numbers @ .., angle] = &words[..] else { return Err("has 1 value, not 9".into()) };
    let bad = |word: &str| format!("has '{word}' where a number is expected");
    let number = |word: &&str| word.parse::<f32>().map_err(|_| bad(word));
    let numbers = numbers.iter().map(number).collect::<std::result::Result<Vec<_>, _>>()?;
    let [x, y, z, i, j, k, w] = numbers[..] else { return Err(format!("has {} values, not 9", words.len())) };
    Ok(FlightKey {
        time_s: time.parse().map_err(|_| bad(time))?,
        eye_m: Vec3::new(x, y, z),
        rotation: Quat::from_xyzw(i, j, k, w),
        yfov_rad: if *angle == "-" { None } else { Some(number(angle)?) },
    })
}

#[cfg(test)]
mod tests;
