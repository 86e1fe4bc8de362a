//! Error metrics of plain numbers.

/// The differences between two sequences of values, gathered one pair at a time.
///
/// ```
/// use ontile::measure::metrics::ErrorStats;
/// let stats: ErrorStats = [(1.0, 2.0), (5.0, 2.0)].into_iter().collect();
/// assert_eq!((stats.max(), stats.mean(), stats.mse()), (3.0, 2.0, 5.0));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ErrorStats {
    count: usize,
    max: f64,
    sum_abs: f64,
    sum_squares: f64,
}

impl ErrorStats {
    /// Counts one pair.
    pub fn add(&mut self, a: f64, b: f64) {
        let difference = (a - b).abs();
        self.count += 1;
        self.max = self.max.max(difference);
        self.sum_abs += difference;
        self.sum_squares += difference * difference;
    }

    /// The statistics of both sequences together.
    pub fn union(self, other: Self) -> Self {
        Self {
            count: self.count + other.count,
            max: self.max.max(other.max),
            sum_abs: self.sum_abs + other.sum_abs,
            sum_squares: self.sum_squares + other.sum_squares,
        }
    }

    /// Pairs counted.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The largest absolute difference.
    pub fn max(&self) -> f64 {
        self.max
    }

    /// The mean absolute difference; 0 if nothing was counted.
    pub fn mean(&self) -> f64 {
        self.sum_abs / self.count.max(1) as f64
    }

    /// The mean squared difference; 0 if nothing was counted.
    pub fn mse(&self) -> f64 {
        self.sum_squares / self.count.max(1) as f64
    }
}

impl FromIterator<(f64, f64)> for ErrorStats {
    fn from_iter<I: IntoIterator<Item = (f64, f64)>>(pairs: I) -> Self {
        let mut stats = Self::default();
        pairs.into_iter().for_each(|(a, b)| stats.add(a, b));
        stats
    }
}

/// The peak signal-to-noise ratio in decibels, `10 log10(peak² / mse)`; infinite if `mse` is 0.
pub fn psnr_db(mse: f64, peak: f64) -> f64 {
    if mse == 0.0 { f64::INFINITY } else { 10.0 * (peak * peak / mse).log10() }
}

/// `|value - reference|` as a share of `|reference|`, or of `floor` where the reference is smaller than that.
pub fn relative_error(reference: f64, value: f64, floor: f64) -> f64 {
    (value - reference).abs() / reference.abs().max(floor)
}

/// The smallest of `values` that at least `share` (0 to 1) of them do not exceed (nearest rank); `None` if there
/// are none. Reorders `values`.
pub fn percentile(values: &mut [f64], share: f64) -> Option<f64> {
    let rank = (share * values.len() as f64).ceil() as usize;
    let last = values.len().checked_sub(1)?;
    let index = rank.saturating_sub(1).min(last);
    Some(*values.select_nth_unstable_by(index, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statistics_match_hand_numbers() {
        // Differences 1, 0, 3, 4: sum 8, squares 1 + 9 + 16 = 26.
        let pairs = [(1.0, 2.0), (7.0, 7.0), (-1.0, 2.0), (4.0, 0.0)];
        let stats: ErrorStats = pairs.into_iter().collect();
        assert_eq!((stats.count(), stats.max(), stats.mean(), stats.mse()), (4, 4.0, 2.0, 6.5));

        let (left, right) = pairs.split_at(1);
        let joined = left.iter().copied().collect::<ErrorStats>().union(right.iter().copied().collect());
        assert_eq!(joined, stats);
    }

    #[test]
    fn nothing_counted_is_no_difference() {
        let stats = ErrorStats::default();
        assert_eq!((stats.count(), stats.max(), stats.mean(), stats.mse()), (0, 0.0, 0.0, 0.0));
    }

    #[test]
    fn psnr_matches_known_values() {
        // One step of 255 everywhere: 20 log10(255) = 48.1308 dB. A tenth of the peak: 20 dB.
        const PRINTED_DIGITS: f64 = 5e-5;
        assert!((psnr_db(1.0, 255.0) - 48.1308).abs() < PRINTED_DIGITS);
        assert!((psnr_db(0.01, 1.0) - 20.0).abs() < 1e-12);
        assert!((psnr_db(255.0 * 255.0, 255.0)).abs() < 1e-12);
        assert_eq!(psnr_db(0.0, 255.0), f64::INFINITY);
    }

    #[test]
    fn relative_error_has_a_floor() {
        assert_eq!(relative_error(4.0, 5.0, 0.5), 0.25);
        assert_eq!(relative_error(-4.0, -3.0, 0.5), 0.25);
        assert_eq!(relative_error(0.0, 1.0, 0.5), 2.0);
    }

    #[test]
    fn percentile_is_the_nearest_rank() {
        let shuffled = || -> Vec<f64> { (0..20).map(|i| f64::from((i * 7) % 20 + 1)).collect() };
        assert_eq!(percentile(&mut shuffled(), 0.95), Some(19.0));
        assert_eq!(percentile(&mut shuffled(), 0.951), Some(20.0));
        assert_eq!(percentile(&mut shuffled(), 0.0), Some(1.0));
        assert_eq!(percentile(&mut shuffled(), 1.0), Some(20.0));
        assert_eq!(percentile(&mut [3.0], 0.5), Some(3.0));
        assert_eq!(percentile(&mut [], 0.5), None);
    }
}
