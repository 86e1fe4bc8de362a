//! Combinations of choices such that every two values of any two choices meet.

/// A sequence of numbers that looks random and is the same everywhere (SplitMix64).
pub struct Seeded(pub u64);

impl Seeded {
    /// Below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n as u64) as usize
    }
}

/// For choices with so many values each: rows of one value a choice, few, in which each two values of two choices are together
/// at least once. Greedy: of some random rows around a pair that has not met, the one with the most such pairs.
pub fn pairwise(values: &[usize], seed: u64) -> Vec<Vec<usize>> {
    const CANDIDATES: usize = 30;
    let mut random = Seeded(seed);
    let choices = values.len();
    let mut missing = Vec::new();
    for (i, j) in (0..choices).flat_map(|j| (0..j).map(move |i| (i, j))) {
        missing.extend((0..values[i]).flat_map(|a| (0..values[j]).map(move |b| (i, a, j, b))));
    }
    let mut rows = Vec::new();
    while !missing.is_empty() {
        let (i, a, j, b) = missing[random.below(missing.len())];
        let mut candidate = || {
            let mut row: Vec<_> = values.iter().map(|&n| random.below(n)).collect();
            (row[i], row[j]) = (a, b);
            row
        };
        let meets = |row: &[usize], &(i, a, j, b): &(usize, usize, usize, usize)| row[i] == a && row[j] == b;
        let candidates: Vec<_> = (0..CANDIDATES).map(|_| candidate()).collect();
        let met = |row: &Vec<usize>| missing.iter().filter(|pair| meets(row, pair)).count();
        let best = candidates.into_iter().max_by_key(met).expect("there are some");
        missing.retain(|pair| !meets(&best, pair));
        rows.push(best);
    }
    rows
}
