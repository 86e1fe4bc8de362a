//! Medians, with how far they can be trusted.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Quartiles of repeated measurements.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Summary {
    pub median: f64,
    pub first_quartile: f64,
    pub third_quartile: f64,
    pub count: usize,
}

impl Summary {
    /// `None` without values.
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
