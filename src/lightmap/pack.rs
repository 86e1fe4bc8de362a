//! Rectangles side by side.

/// Where rectangles lie, and how high they reach.
#[derive(Debug, PartialEq)]
pub struct Packed {
    /// Of each rectangle its lower corner.
    pub places: Vec<[u32; 2]>,
    /// What all of them take.
    pub size: [u32; 2],
}

/// Puts rectangles on shelves of this width, highest first. One that is wider has a shelf of its own. What is beyond u32 is
/// the largest u32.
pub fn pack(sizes: &[[u32; 2]], width: u32) -> Packed {
    let mut order: Vec<_> = (0..sizes.len()).collect();
    order.sort_by_key(|&i| (std::cmp::Reverse(sizes[i][1]), std::cmp::Reverse(sizes[i][0]), i));
    let mut places = vec![[0; 2]; sizes.len()];
    let (mut x, mut y, mut shelf, mut widest) = (0_u32, 0_u32, 0, 0);
    for i in order {
        let [w, h] = sizes[i];
        if x.saturating_add(w) > width {
            (x, y, shelf) = (0, y.saturating_add(shelf), 0);
        }
        places[i] = [x, y];
        x = x.saturating_add(w);
        shelf = shelf.max(h);
        widest = widest.max(x);
    }
    Packed { places, size: [widest, y.saturating_add(shelf)] }
}

/// Packs rectangles into about a square.
pub fn pack_square(sizes: &[[u32; 2]]) -> Packed {
    let area: u64 = sizes.iter().map(|[w, h]| u64::from(*w) * u64::from(*h)).sum();
    let widest = sizes.iter().map(|s| s[0]).max().unwrap_or(0);
    pack(sizes, widest.max((area as f64).sqrt().ceil() as u32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangles_lie_side_by_side_and_waste_little() {
        let sizes: Vec<[u32; 2]> = (1..200).map(|i| [1 + i * 7919 % 31, 1 + i * 104_729 % 23]).collect();
        for packed in [pack(&sizes, 200), pack_square(&sizes)] {
            let mut texels = vec![false; (packed.size[0] * packed.size[1]) as usize];
            for ([w, h], [x, y]) in sizes.iter().zip(&packed.places) {
                for (i, j) in (0..w * h).map(|k| (x + k % w, y + k / w)) {
                    let texel = &mut texels[(j * packed.size[0] + i) as usize];
                    assert!(!std::mem::replace(texel, true), "{i}, {j} is taken twice");
                }
            }
            let used = texels.iter().filter(|t| **t).count() as f64 / texels.len() as f64;
            assert!(used > 0.85, "{used}");
        }
        assert_eq!(pack(&[], 8).size, [0, 0]);
    }
}
