//! Numbers without the digits that depend on the order of a sum.

/// Bits that are dropped of the 52 after the point: what is left is exact to 1e-12.
const DROPPED: u32 = 12;

/// A positive number rounded to twelve digits. Sums over a surface differ in their last digits with the numbering of its
/// vertices and faces; a length that is made of one is compared with the lengths of edges all over a remesh, and on a shape
/// that repeats itself one different digit is enough for another mesh.
pub fn rounded(x: f64) -> f64 {
    let unit = 1u64 << DROPPED;
    f64::from_bits((x.to_bits() + unit / 2) & !(unit - 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_differ_in_their_last_digits_become_the_same() {
        for x in [1.0, 0.182_670_336_489_05, 1.999_999_999_999_9, 1e-300, 3e17] {
            assert!((rounded(x) / x - 1.0).abs() < 1e-12, "{x}");
            assert_eq!(rounded(rounded(x)), rounded(x), "{x}");
        }
        assert_eq!(rounded(0.182_670_336_489_051_65), rounded(0.182_670_336_489_049_62));
        assert_eq!((rounded(0.0), rounded(2.0)), (0.0, 2.0));
    }
}
