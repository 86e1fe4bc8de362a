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

/// Two values of two choices: choice, value, choice, value.
pub type Pair = (usize, usize, usize, usize);

/// For choices with so many values each: rows of one value a choice, few, all of them `allowed`, in which each two values of two
/// choices are together at least once; and the pairs for which no such row was found. Greedy: of some random rows around a pair
/// that has not met, the one with the most such pairs.
pub fn pairwise(
    values: &[usize],
    seed: u64,
    allowed: impl Fn(&[usize]) -> bool,
) -> (Vec<Vec<usize>>, Vec<Pair>) {
    const CANDIDATES: usize = 30;
    /// Of random rows around a pair before it is given up.
    const TRIES: usize = 600;
    let mut random = Seeded(seed);
    let choices = values.len();
    let mut missing = Vec::new();
    for (i, j) in (0..choices).flat_map(|j| (0..j).map(move |i| (i, j))) {
        missing.extend((0..values[i]).flat_map(|a| (0..values[j]).map(move |b| (i, a, j, b))));
    }
    let (mut rows, mut impossible) = (Vec::new(), Vec::new());
    while !missing.is_empty() {
        let pair = missing[random.below(missing.len())];
        let (i, a, j, b) = pair;
        let mut candidate = || {
            let mut row: Vec<_> = values.iter().map(|&n| random.below(n)).collect();
            (row[i], row[j]) = (a, b);
            row
        };
        let meets = |row: &[usize], &(i, a, j, b): &Pair| row[i] == a && row[j] == b;
        let random_rows = (0..TRIES).map(|_| candidate());
        let candidates: Vec<_> = random_rows.filter(|row| allowed(row)).take(CANDIDATES).collect();
        let met = |row: &Vec<usize>| missing.iter().filter(|pair| meets(row, pair)).count();
        match candidates.into_iter().max_by_key(met) {
            Some(best) => {
                missing.retain(|pair| !meets(&best, pair));
                rows.push(best);
            }
            None => {
                missing.retain(|other| *other != pair);
                impossible.push(pair);
            }
        }
    }
    (rows, impossible)
}
