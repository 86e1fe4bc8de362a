//! Comparing two ways that were measured in turns, and finding where one overtakes another.

use std::cmp::Ordering;

use serde::Serialize;

/// Ratios nearer to 1 than this are called level: what changes from one run to the next without any change of code.
pub const LEVEL: f64 = 1.02;

/// The ratio of two ways over the rounds that both took part in.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ratio {
    pub median: f64,
    /// Of the median, with 95 % confidence; the smallest and largest ratio where there are fewer than six.
    pub low: f64,
    pub high: f64,
}

impl Ratio {
    /// The median of `a / b`, round by round: what disturbs a round disturbs both. `None` without rounds.
    pub fn of(a: &[f64], b: &[f64]) -> Option<Self> {
        let mut ratios: Vec<f64> = a.iter().zip(b).map(|(a, b)| a / b).collect();
        ratios.sort_by(f64::total_cmp);
        let (low, high) = median_ranks(ratios.len())?;
        Some(Self { median: median(&ratios)?, low: ratios[low], high: ratios[high] })
    }

    /// Whether the first is cheaper (`Less`), dearer (`Greater`), or neither beyond doubt.
    pub fn order(&self) -> Ordering {
        if self.high < 1.0 / LEVEL {
            Ordering::Less
        } else if self.low > LEVEL {
            Ordering::Greater
        } else {
            Ordering::Equal
        }
    }
}

/// Of sorted numbers, or numbers that are sorted here.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    (n > 0).then(|| (sorted[(n - 1) / 2] + sorted[n / 2]) * 0.5)
}

/// The ranks (from 0) of the sorted values that enclose the median with at least 95 % confidence whatever the
/// distribution: the number of values below the median is binomial with p = 1/2.
fn median_ranks(count: usize) -> Option<(usize, usize)> {
    let last = count.checked_sub(1)?;
    let mut below = 0.5_f64.powi(count as i32);
    let mut tail = below;
    let mut rank = 0;
    // Leaves out values at both ends as long as their tails hold at most 2.5 % each.
    while rank < last / 2 {
        below *= (count - rank) as f64 / (rank + 1) as f64;
        if tail + below > 0.025 {
            break;
        }
        tail += below;
        rank += 1;
    }
    Some((rank, last - rank))
}

/// One way's cost at each place of a sweep; `None` where it was not measured.
pub type Series<'a> = (&'a str, Vec<Option<f64>>);

/// From where on a way is the cheapest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Winner {
    pub name: String,
    /// The first place; the sweep's beginning for the first winner.
    pub from: f64,
}

/// Which way is the cheapest from where to where, `xs` ascending. Between two places costs run straight on logarithmic
/// axes; a way that is no more than [`LEVEL`] dearer than the cheapest keeps its place.
pub fn winners(xs: &[f64], series: &[Series<'_>]) -> Vec<Winner> {
    let mut winners: Vec<Winner> = Vec::new();
    let mut current: Option<usize> = None;
    for (i, &x) in xs.iter().enumerate() {
        let cost = |way: usize| series[way].1.get(i).copied().flatten();
        let measured = (0..series.len()).filter_map(|way| Some((way, cost(way)?)));
        let Some((best, best_cost)) = measured.min_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
        if current.is_some_and(|way| cost(way).is_some_and(|cost| cost <= best_cost * LEVEL)) {
            continue;
        }
        let from = match current {
            Some(old) if i > 0 => crossing(xs, &series[best].1, &series[old].1, i).unwrap_or(x),
            _ => x,
        };
        current = Some(best);
        winners.push(Winner { name: series[best].0.to_owned(), from });
    }
    winners
}

/// Where `new` falls below `old` between places `i - 1` and `i`.
fn crossing(xs: &[f64], new: &[Option<f64>], old: &[Option<f64>], i: usize) -> Option<f64> {
    let gap = |i: usize| Some(((*new.get(i)?)? / (*old.get(i)?)?).ln());
    let (before, after) = (gap(i - 1)?, gap(i)?);
    // A way that was level before it was dearer may never have been dearer at the place before.
    let t = if before > after { (before / (before - after)).clamp(0.0, 1.0) } else { 0.0 };
    Some((xs[i - 1].ln() * (1.0 - t) + xs[i].ln() * t).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_are_those_of_the_middle() {
        assert_eq!(median(&[]), None);
        assert_eq!(median(&[3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), Some(2.5));
    }

    #[test]
    fn the_median_lies_between_the_ranks_of_the_tables() {
        // Conover, Practical Nonparametric Statistics: 95 % intervals of the median leave out so many at each end.
        for (count, left_out) in [(1, 0), (5, 0), (6, 0), (9, 1), (12, 2), (15, 3), (20, 5), (25, 7)] {
            assert_eq!(median_ranks(count), Some((left_out, count - 1 - left_out)), "{count}");
        }
        assert_eq!(median_ranks(0), None);
    }

    #[test]
    fn noise_that_falls_on_both_cancels_out_of_ratios() {
        let noise = [1.0, 5.0, 1.1, 0.9, 30.0, 1.0, 2.0, 1.0, 1.0];
        let a: Vec<f64> = noise.iter().map(|n| n * 3.0).collect();
        let ratio = Ratio::of(&a, &noise).unwrap();
        assert!((ratio.median - 3.0).abs() < 1e-12 && ratio.order() == Ordering::Greater);
        assert_eq!(Ratio::of(&noise, &a).unwrap().order(), Ordering::Less);
        assert_eq!(Ratio::of(&noise, &noise.map(|n| n * 1.01)).unwrap().order(), Ordering::Equal);
        // One round of nine says nothing.
        let mut outlier = noise;
        outlier[0] = 50.0;
        assert_eq!(Ratio::of(&outlier, &noise).unwrap().order(), Ordering::Equal);
        assert_eq!(Ratio::of(&[], &[]), None);
    }

    #[test]
    fn winners_change_where_the_lines_cross() {
        let xs = [1.0, 4.0, 16.0, 64.0];
        let all = |costs: [f64; 4]| costs.map(Some).to_vec();
        // Both are powers of x: 8 = x * 1 at x = 8, exactly between the places on logarithmic axes.
        let found = winners(&xs, &[("linear", all(xs)), ("constant", all([8.0; 4]))]);
        assert_eq!(found[0], Winner { name: "linear".into(), from: 1.0 });
        assert_eq!(found[1].name, "constant");
        assert!((found[1].from - 8.0).abs() < 1e-9, "{found:?}");
        assert_eq!(found.len(), 2);
        // Level ways do not take turns; a way that ends early is replaced where it ends.
        let noisy = [("a", all([1.0, 1.01, 1.0, 1.01])), ("b", all([1.01, 1.0, 1.01, 1.0]))];
        assert_eq!(winners(&xs, &noisy).len(), 1);
        let short = [("a", vec![Some(1.0), Some(1.0)]), ("b", all([2.0; 4]))];
        assert_eq!(winners(&xs, &short)[1], Winner { name: "b".into(), from: 16.0 });
        assert_eq!(winners(&xs, &[("never", vec![None; 4])]), []);
    }
}
