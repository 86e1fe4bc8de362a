//! Front to back, without changing state more often than any other order.

use std::ops::Range;

/// What a group's members have in common; their order is free.
#[derive(Clone, Debug)]
struct Group {
    /// Groups of the next level; of the innermost level: draws.
    members: Range<usize>,
}

/// Distances summed up, for a mean.
#[derive(Clone, Copy, Debug, Default)]
pub struct Distances {
    sum_m: f32,
    count: u32,
}

impl Distances {
    /// Adds one, in metres.
    pub fn add(&mut self, distance_m: f32) {
        self.sum_m += distance_m;
        self.count += 1;
    }

    fn and(self, other: Self) -> Self {
        Self { sum_m: self.sum_m + other.sum_m, count: self.count + other.count }
    }

    /// Sorts by the mean, nothing last; among equals by index.
    fn sort_key(self, index: usize) -> u64 {
        let mean = if self.count == 0 { f32::INFINITY } else { self.sum_m / self.count as f32 };
        sort_key(mean, index)
    }
}

/// A number that sorts by distance (at least 0), among equals by index (below 2^32).
pub fn sort_key(distance_m: f32, index: usize) -> u64 {
    // Floats that are not negative sort as their bits do.
    u64::from(distance_m.to_bits()) << 32 | index as u64
}

/// The index in a [`sort_key`].
pub fn sorted_index(key: u64) -> usize {
    (key & u64::from(u32::MAX)) as usize
}

/// Draws in groups within groups: those of one group share a state (a pipeline, a material), and follow each other.
///
/// Where everything is opaque, what is near hides what is far only if it is drawn first. A strict order by distance would
/// change state from draw to draw; this one sorts groups by the mean distance of what is in them, and within each its
/// members likewise, so that each state is set once.
#[derive(Clone, Debug)]
pub struct DrawOrder {
    /// Outermost first: level 0 is one group of all.
    levels: Vec<Vec<Group>>,
    /// Per level below the outermost, and of draws last: their distances, and their indices sorted within each group.
    distances: Vec<Vec<Distances>>,
    sorted: Vec<Vec<u64>>,
    order: Vec<usize>,
}

impl DrawOrder {
    /// For draws with these states, outermost first; those that share states must follow each other. The first state's
    /// groups stay in the order given, whatever their distance.
    pub fn new<const STATES: usize>(draws: &[[usize; STATES]]) -> Self {
        let begins = |level: usize| {
            (0..draws.len()).filter(move |&i| i == 0 || draws[i][..level] != draws[i - 1][..level])
        };
        let mut levels = Vec::new();
        for level in 0..=STATES {
            // Of each group of this level, where its draws begin; and likewise of the level below.
            let starts: Vec<_> = begins(level).chain([draws.len()]).collect();
            let below: Vec<_> =
                if level < STATES { begins(level + 1).collect() } else { (0..draws.len()).collect() };
            let member = |draw: usize| below.partition_point(|&start| start < draw);
            let groups = starts.windows(2).map(|w| Group { members: member(w[0])..member(w[1]) });
            levels.push(groups.collect::<Vec<_>>());
        }
        let lengths = || levels[1..].iter().map(Vec::len).chain([draws.len()]);
        Self {
            distances: lengths().map(|n| vec![Distances::default(); n]).collect(),
            sorted: lengths().map(|n| (0..n as u64).collect()).collect(),
            order: (0..draws.len()).collect(),
            levels,
        }
    }

    /// Sorts by the distances of what each draw shows. Allocates nothing.
    pub fn sort(&mut self, of_draw: impl Fn(usize) -> Distances) {
        let Self { levels, distances, sorted, order } = self;
        let innermost = levels.len() - 1;
        for (draw, distances) in distances[innermost].iter_mut().enumerate() {
            *distances = of_draw(draw);
        }
        for level in (1..levels.len()).rev() {
            for (index, group) in levels[level].iter().enumerate() {
                let members = group.members.clone();
                let mut all = Distances::default();
                for (key, member) in sorted[level][members.clone()].iter_mut().zip(members.clone()) {
                    let distances = distances[level][member];
                    *key = distances.sort_key(member);
                    all = all.and(distances);
                }
                distances[level - 1][index] = all;
                sorted[level][members].sort_unstable();
            }
        }
        order.clear();
        flatten(levels, sorted, 0, 0, order);
    }

    /// The draws, from near to far.
    pub fn draws(&self) -> &[usize] {
        &self.order
    }
}

/// Appends the draws of a group in their order.
fn flatten(levels: &[Vec<Group>], sorted: &[Vec<u64>], level: usize, group: usize, order: &mut Vec<usize>) {
    let Some(group) = levels[level].get(group) else { return };
    for member in sorted[level][group.members.clone()].iter().map(|&key| sorted_index(key)) {
        match level + 1 < levels.len() {
            true => flatten(levels, sorted, level + 1, member, order),
            false => order.push(member),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn distances(all: &[f32]) -> impl Fn(usize) -> Distances + '_ {
        move |draw| {
            let mut distances = Distances::default();
            if all[draw] >= 0.0 {
                distances.add(all[draw]);
            }
            distances
        }
    }

    #[test]
    fn groups_are_sorted_by_mean_and_members_within() {
        let mut order = DrawOrder::new(&[[0, 0], [0, 0], [0, 1], [0, 2], [1, 3]]);
        // Means of the second state's groups: 5, 6, none.
        order.sort(distances(&[9.0, 1.0, 6.0, -1.0, 0.0]));
        assert_eq!(order.draws(), [1, 0, 2, 3, 4]);
        order.sort(distances(&[9.0, 9.0, 6.0, 7.0, 0.0]));
        assert_eq!(
            order.draws(),
            [2, 3, 0, 1, 4],
            "equals stay in their order, the first state's groups always"
        );
        let mut nothing = DrawOrder::new::<2>(&[]);
        nothing.sort(|_| unreachable!());
        assert!(nothing.draws().is_empty());
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn every_draw_comes_once_and_states_change_no_more_often(
            mut draws in prop::collection::vec(prop::array::uniform3(0_usize..4), 1..40),
            metres in prop::collection::vec(-1.0_f32..10.0, 40)
        ) {
            draws.sort_unstable();
            let changes = |order: &[usize], level: usize| {
                order.windows(2).filter(|w| draws[w[0]][..level] != draws[w[1]][..level]).count()
            };
            let unsorted: Vec<_> = (0..draws.len()).collect();
            let mut order = DrawOrder::new(&draws);
            order.sort(distances(&metres));
            for level in 1..=3 {
                prop_assert_eq!(changes(order.draws(), level), changes(&unsorted, level));
            }
            let mut all = order.draws().to_vec();
            all.sort_unstable();
            prop_assert_eq!(all, unsorted);
        }
    }
}
