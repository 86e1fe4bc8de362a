//! When frames are drawn.

use std::time::{Duration, Instant};

/// The times of frames, and when the next one should begin.
pub(super) struct Clock {
    last: Instant,
    told: Instant,
    frames: u32,
    refresh: Duration,
    pace: Pace,
}

impl Clock {
    pub(super) fn new() -> Self {
        let now = Instant::now();
        Self { last: now, told: now, frames: 0, refresh: Duration::ZERO, pace: Pace::default() }
    }

    /// A frame begins: seconds since the one before.
    pub(super) fn begin(&mut self) -> f32 {
        let now = Instant::now();
        let since = now - self.last;
        self.last = now;
        since.as_secs_f32()
    }

    /// A frame is on its way, to a screen that is refreshed so often; the GPU took so long for one of those before, if it tells.
    pub(super) fn drawn(&mut self, gpu: Option<Duration>, refresh: Duration) {
        self.frames += 1;
        self.refresh = refresh;
        if let Some(gpu) = gpu {
            self.pace.took(gpu, refresh);
        }
    }

    /// When the next frame should begin, where each refresh of the screen is waited for.
    pub(super) fn next(&self) -> Instant {
        self.last + self.pace.wait(self.refresh)
    }

    /// Milliseconds a frame, twice a second.
    pub(super) fn tell_ms(&mut self) -> Option<f64> {
        let elapsed = self.told.elapsed();
        if elapsed < Duration::from_millis(500) {
            return None;
        }
        let ms = elapsed.as_secs_f64() * 1e3 / f64::from(self.frames.max(1));
        (self.told, self.frames) = (Instant::now(), 0);
        Some(ms)
    }
}

/// How many refreshes of the screen each frame stays.
///
/// Frames that take a little longer than a refresh would be shown for one and for two by turns, which looks worse than two for each. So the
/// interval is a whole number of refreshes: longer as soon as a few frames need it, shorter again only when a second of them would fit.
#[derive(Debug, Default, PartialEq)]
struct Pace {
    /// Beyond the one that each frame takes.
    more: u32,
    /// Frames in a row that wanted a longer interval, or a shorter one.
    longer: u32,
    shorter: u32,
}

impl Pace {
    /// The share of an interval that the GPU may take: the rest is for the CPU and for what else the GPU does.
    const MOST_SHARE: f64 = 0.9;
    /// Slower frames are not paced.
    const MOST_REFRESHES: u32 = 4;
    /// A slow frame by itself is no reason.
    const LONGER_AFTER: u32 = 3;
    /// A change back and forth is seen more than a low rate.
    const SHORTER_AFTER: u32 = 60;

    fn took(&mut self, gpu: Duration, refresh: Duration) {
        let refreshes = (gpu.as_secs_f64() / (refresh.as_secs_f64() * Self::MOST_SHARE)).ceil();
        let wanted = (refreshes as u32).clamp(1, Self::MOST_REFRESHES) - 1;
        self.longer = if wanted > self.more { self.longer + 1 } else { 0 };
        self.shorter = if wanted < self.more { self.shorter + 1 } else { 0 };
        if self.longer >= Self::LONGER_AFTER {
            *self = Self { more: wanted, ..Self::default() };
        } else if self.shorter >= Self::SHORTER_AFTER {
            *self = Self { more: self.more - 1, ..Self::default() };
        }
    }

    /// From the begin of a frame to that of the next. The last half of a refresh is left to the screen, which shows a frame no sooner
    /// than it is due.
    fn wait(&self, refresh: Duration) -> Duration {
        match self.more {
            0 => Duration::ZERO,
            more => refresh * more + refresh / 2,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_whole_refreshes_and_change_seldom() {
        let refresh = Duration::from_millis(16);
        let mut pace = Pace::default();
        let mut after = |ms: u64, frames: u32| {
            (0..frames).for_each(|_| pace.took(Duration::from_millis(ms), refresh));
            pace.wait(refresh)
        };
        assert_eq!(after(10, 100), Duration::ZERO);
        // One slow frame, and again after others, is none too many.
        assert_eq!(after(20, 2), Duration::ZERO);
        assert_eq!(after(10, 1), Duration::ZERO);
        assert_eq!(after(20, 2), Duration::ZERO);
        assert_eq!(after(20, 1), Duration::from_millis(24));
        // What would just fit might not the next time.
        assert_eq!(after(15, 200), Duration::from_millis(24));
        assert_eq!(after(10, 59), Duration::from_millis(24));
        assert_eq!(after(20, 1), Duration::from_millis(24));
        assert_eq!(after(10, 60), Duration::ZERO);
        // Slides are not paced beyond four, and come back step by step.
        assert_eq!(after(500, 3), Duration::from_millis(56));
        assert_eq!(after(5, 60), Duration::from_millis(40));
        assert_eq!(after(5, 120), Duration::ZERO);
    }
}
