//! Medians, with how far they can be trusted.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Quartiles of repeated measurements.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Half are at most this.
    pub median: f64,
    /// A quarter are at most this.
    pub first_quartile: f64,
    /// Three quarters are at most this.
    pub third_quartile: f64,
    /// How many there were.
    pub count: usize,
}

impl Summary {
    /// Between ranks, quartiles are interpolated; `None` without values.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().checked_sub(1)?;
        // Linear between the two nearest ranks.
        let quantile = |q: f64| {
            let rank = q * last as f64;
            let below = sorted[rank.floor() as usize];
            below + (sorted[rank.ceil() as usize] - below) * rank.fract()
        };
        Some(Self {
            median: quantile(0.5),
            first_quartile: quantile(0.25),
            third_quartile: quantile(0.75),
            count: sorted.len(),
        })
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digits = f.precision().unwrap_or(2);
        let Self { median, first_quartile, third_quartile, .. } = self;
        write!(f, "{median:.digits$} [{first_quartile:.digits$}, {third_quartile:.digits$}]")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_lie_between_ranks() {
        let of = |values: &[f64]| Summary::of(values.iter().copied());
        let summary = of(&[4.0, 1.0, 3.0, 2.0]).unwrap();
        assert_eq!((summary.first_quartile, summary.median, summary.third_quartile), (1.75, 2.5, 3.25));
        assert_eq!(summary.to_string(), "2.50 [1.75, 3.25]");
        assert_eq!(of(&[7.0]).unwrap().third_quartile, 7.0);
        assert_eq!(of(&[]), None);
    }
}
