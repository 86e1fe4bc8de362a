//! A channel's value at a time (glTF 2.0, appendix C), in f64.

use glam::DVec4;

use super::{Channel, Interpolation, Property};

/// Where a time is among a channel's keys: the key before it, and how far it is to the next, 0 to 1, which are so far apart.
struct Between {
    key: usize,
    share: f64,
    seconds: f64,
}

fn between(times_s: &[f32], time_s: f64) -> Between {
    let after = times_s.partition_point(|&t| f64::from(t) <= time_s);
    let key = after.saturating_sub(1);
    let [begin, end] = [key, (key + 1).min(times_s.len() - 1)].map(|i| f64::from(times_s[i]));
    let seconds = end - begin;
    let share = if seconds > 0.0 { ((time_s - begin) / seconds).clamp(0.0, 1.0) } else { 0.0 };
    Between { key, share, seconds }
}

/// The cubic Hermite spline's factors of the value and the tangent that leave a key, and of those that arrive at the next.
fn hermite(t: f64, seconds: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [2.0 * t3 - 3.0 * t2 + 1.0, seconds * (t3 - 2.0 * t2 + t), -2.0 * t3 + 3.0 * t2, seconds * (t3 - t2)]
}

impl Channel {
    /// The value, of `out.len()` numbers, which is [`Self::width`]. The channel has [no problem](Self::problem).
    pub(super) fn sample(&self, time_s: f64, out: &mut [f64]) {
        let Between { key, share, seconds } = between(&self.times_s, time_s);
        let width = out.len();
        // The n-th list of numbers.
        let row = |n: usize| self.values[n * width..(n + 1) * width].iter().map(|v| f64::from(*v));
        let next = (key + 1).min(self.times_s.len() - 1);
        match (self.interpolation, self.property) {
            (Interpolation::Step, _) => out.iter_mut().zip(row(key)).for_each(|(out, v)| *out = v),
            (Interpolation::Linear, Property::Rotation) => {
                let read = |n| {
                    let mut row = row(n);
                    DVec4::from_array(std::array::from_fn(|_| row.next().unwrap_or_default())).normalize()
                };
                out.copy_from_slice(&slerp(read(key), read(next), share).to_array());
            }
            (Interpolation::Linear, _) => {
                for (out, (a, b)) in out.iter_mut().zip(row(key).zip(row(next))) {
                    *out = a * (1.0 - share) + b * share;
                }
            }
            (Interpolation::CubicSpline, _) => {
                let factors = hermite(share, seconds);
                let [value, leaves] = [3 * key + 1, 3 * key + 2].map(row);
                let [end, arrives] = [3 * next + 1, 3 * next].map(row);
                for (out, ((v, l), (e, a))) in out.iter_mut().zip(value.zip(leaves).zip(end.zip(arrives))) {
                    *out = factors[0] * v + factors[1] * l + factors[2] * e + factors[3] * a;
                }
            }
        }
    }
}

/// Between two rotations the shorter way round, at a constant speed. A half turn either way is as short: it goes the way that the
/// quaternions' signs say.
fn slerp(from: DVec4, to: DVec4, share: f64) -> DVec4 {
    let to = if from.dot(to) < 0.0 { -to } else { to };
    // Unlike the arc cosine of their product, exact for small angles too (Kahan 2006, "How Futile are Mindless Assessments of
    // Roundoff", section 12).
    let angle = 2.0 * (from - to).length().atan2((from + to).length());
    // Where the angle squared is nothing beside 1, so is the curve beside its chord.
    let mixed = match angle < 1e-8 {
        true => from * (1.0 - share) + to * share,
        false => from * ((1.0 - share) * angle).sin() + to * (share * angle).sin(),
    };
    mixed.normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec3};

    /// What f64 leaves of a few operations.
    const ROUNDING: f64 = 1e-12;

    fn channel(interpolation: Interpolation, property: Property, times_s: &[f32], values: &[f32]) -> Channel {
        Channel { node: 0, property, interpolation, times_s: times_s.into(), values: values.into() }
    }

    fn one(channel: &Channel, time_s: f64) -> f64 {
        let mut out = [f64::NAN];
        channel.sample(time_s, &mut out);
        out[0]
    }

    #[test]
    fn ends_are_held_and_keys_are_met() {
        let times = [0.5, 1.0, 4.0];
        for (interpolation, values, half_way) in [
            (Interpolation::Step, vec![3.0, -1.0, 7.0], -1.0),
            (Interpolation::Linear, vec![3.0, -1.0, 7.0], 3.0),
            (Interpolation::CubicSpline, vec![9., 3., 9., 9., -1., 0., 0., 7., 9.], 3.0),
        ] {
            let channel = channel(interpolation, Property::Weights, &times, &values);
            for (time, wanted) in
                [(-1.0, 3.0), (0.0, 3.0), (0.5, 3.0), (1.0, -1.0), (2.5, half_way), (4.0, 7.0), (9.0, 7.0)]
            {
                assert!((one(&channel, time) - wanted).abs() < ROUNDING, "{interpolation:?} at {time}");
            }
        }
    }

    /// A cubic is its own spline: t³ - 2t + 1 between keys at uneven times, with its derivative as tangents.
    #[test]
    fn a_cubic_spline_is_exact_for_cubics() {
        let (value, slope) = (|t: f64| t * t * t - 2.0 * t + 1.0, |t: f64| 3.0 * t * t - 2.0);
        // Eighths, so that all of it is exact in f32.
        let times = [0.0_f32, 0.5, 2.0, 2.25];
        let keys: Vec<f32> = times
            .iter()
            .flat_map(|&t| [slope(t.into()), value(t.into()), slope(t.into())].map(|v| v as f32))
            .collect();
        let channel = channel(Interpolation::CubicSpline, Property::Weights, &times, &keys);
        for i in 0..=90 {
            let t = f64::from(i) * 0.025;
            assert!((one(&channel, t) - value(t)).abs() < ROUNDING, "at {t}");
        }
    }

    /// Against turns about an axis, from next to nothing to next to a half turn either way, and the long way's quaternions.
    #[test]
    fn rotations_go_the_shorter_way_at_a_constant_speed() {
        let axis = DVec3::new(1.0, -2.0, 0.5).normalize();
        let start = DQuat::from_axis_angle(DVec3::Y, 0.7);
        for angle in [1e-12, 1e-9, 1e-6, 0.1, 2.0, 3.1, std::f64::consts::PI - 1e-9, -3.1, -1e-7] {
            for sign in [1.0, -1.0] {
                let end = DQuat::from_axis_angle(axis, angle) * start;
                for i in 0..=8 {
                    let share = f64::from(i) / 8.0;
                    let got = slerp(start.into(), DVec4::from(end) * sign, share);
                    let wanted: DVec4 = (DQuat::from_axis_angle(axis, angle * share) * start).into();
                    let off = (got - wanted).length().min((got + wanted).length());
                    // Near a half turn the shorter way is known as well as the sum of the ends is.
                    let bound = if std::f64::consts::PI - angle.abs() < 1e-4 { 1e-6 } else { ROUNDING };
                    assert!(off < bound, "{angle} at {share}: {off}");
                }
            }
        }
        let turned = slerp(DVec4::W, DVec4::X, 0.5);
        assert!((turned - DVec4::new(0.5_f64.sqrt(), 0.0, 0.0, 0.5_f64.sqrt())).length() < ROUNDING);
    }
}
