//! Which joints move a vertex, and how much.

/// Joints that a vertex may have.
const MAX_JOINTS: usize = 4;
/// Different joints of one place that are told apart before the smallest are left out: four each of the corners of a
/// triangle, or of the four sets that files have at most.
const MAX_AT_ONCE: usize = 16;
/// Weights whose sum is this near 1 are left as they are, so that writing and reading them changes nothing.
const NORMALISED: f64 = 4e-7;

/// One to four different joints with their weights, the largest first. Weights are positive and their sum is 1 to single
/// precision; places without a joint hold joint 0 and weight 0. Joints are numbers only: what they are and how they hang
/// together is not known here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Influences {
    joints: [u16; MAX_JOINTS],
    weights: [f32; MAX_JOINTS],
}

impl Influences {
    /// What one joint alone moves.
    pub fn one(joint: u16) -> Self {
        Self { joints: [joint, 0, 0, 0], weights: [1.0, 0.0, 0.0, 0.0] }
    }

    /// The four largest of these weights, divided by their sum. Weights of the same joint are added; what is no positive
    /// finite number is none. `None` if nothing is left.
    pub fn of(pairs: impl IntoIterator<Item = (u16, f64)>) -> Option<Self> {
        let (mut known, mut n) = ([(0u16, 0.0f64); MAX_AT_ONCE], 0);
        for (joint, weight) in pairs.into_iter().filter(|(_, weight)| weight.is_finite() && *weight > 0.0) {
            match known[..n].iter_mut().find(|(other, _)| *other == joint) {
                Some((_, sum)) => *sum += weight,
                None if n < MAX_AT_ONCE => {
                    known[n] = (joint, weight);
                    n += 1;
                }
                None => {
                    let least = known.iter_mut().min_by(|a, b| a.1.total_cmp(&b.1));
                    if let Some(least) = least.filter(|least| least.1 < weight) {
                        *least = (joint, weight);
                    }
                }
            }
        }
        let known = &mut known[..n];
        known.sort_unstable_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let largest = &known[..n.min(MAX_JOINTS)];
        let sum: f64 = largest.iter().map(|(_, weight)| weight).sum();
        if !(sum > 0.0 && sum.is_finite()) {
            return None;
        }
        let scale = if (sum - 1.0).abs() < NORMALISED { 1.0 } else { 1.0 / sum };
        let mut made = Self::one(largest[0].0);
        for (k, &(joint, weight)) in largest.iter().enumerate().skip(1) {
            let weight = (scale * weight) as f32;
            if weight > 0.0 {
                (made.joints[k], made.weights[k]) = (joint, weight);
            }
        }
        // The largest takes what rounding lost.
        let others: f64 = made.weights[1..].iter().map(|&weight| f64::from(weight)).sum();
        made.weights[0] = if scale == 1.0 { largest[0].1 as f32 } else { (1.0 - others) as f32 };
        Some(made)
    }

    /// The mean of three, weighted by `weights`.
    pub fn blend(weights: [f64; 3], of: [Self; 3]) -> Self {
        let pairs = weights.into_iter().zip(&of).flat_map(|(share, one)| one.pairs().map(move |(j, w)| (j, share * w)));
        Self::of(pairs).unwrap_or(of[0])
    }

    /// Joints, parallel to [`Self::weights`].
    pub fn joints(&self) -> [u16; MAX_JOINTS] {
        self.joints
    }

    /// Weights, the largest first.
    pub fn weights(&self) -> [f32; MAX_JOINTS] {
        self.weights
    }

    /// How much a joint moves the vertex.
    pub fn weight_of(&self, joint: u16) -> f64 {
        self.pairs().find(|&(other, _)| other == joint).map_or(0.0, |(_, weight)| weight)
    }

    /// Half the sum of the differences of all weights: 0 for equals, 1 where no joint is shared.
    pub fn difference(&self, other: &Self) -> f64 {
        let own = self.pairs().map(|(joint, weight)| (weight - other.weight_of(joint)).abs());
        let foreign = other.pairs().filter(|&(joint, _)| self.weight_of(joint) == 0.0).map(|(_, weight)| weight);
        0.5 * own.chain(foreign).sum::<f64>()
    }

    fn pairs(&self) -> impl Iterator<Item = (u16, f64)> {
        let pairs = self.joints.into_iter().zip(self.weights);
        pairs.filter(|&(_, weight)| weight > 0.0).map(|(joint, weight)| (joint, f64::from(weight)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(of: &Influences) -> f64 {
        of.weights().iter().map(|&weight| f64::from(weight)).sum()
    }

    #[test]
    fn the_four_largest_are_kept_and_their_sum_is_one() {
        let made = Influences::of([(7, 0.1), (3, 0.2), (9, 0.05), (1, 0.2), (4, 0.3), (7, 0.15)]).unwrap();
        assert_eq!(made.joints(), [4, 7, 1, 3]);
        assert!((made.weight_of(7) - 0.25 / 0.95).abs() < 1e-7 && made.weight_of(9) == 0.0);
        assert!((sum(&made) - 1.0).abs() < 1e-7);
        // What was written is read as it is.
        let pairs = made.joints().into_iter().zip(made.weights().map(f64::from));
        assert_eq!(Influences::of(pairs), Some(made));
        // More joints than are told apart: the large ones win nevertheless.
        let many = Influences::of((0..100).map(|j| (j, f64::from(j)))).unwrap();
        assert_eq!(many.joints(), [99, 98, 97, 96]);
    }

    #[test]
    fn nonsense_is_no_weight() {
        assert_eq!(Influences::of([]), None);
        assert_eq!(Influences::of([(1, 0.0), (2, -1.0), (3, f64::NAN), (4, f64::INFINITY)]), None);
        assert_eq!(Influences::of([(1, -1.0), (2, 7.0)]), Some(Influences::one(2)));
        assert_eq!(Influences::of([(1, f64::MAX), (2, f64::MAX)]), None);
        let tiny = Influences::of([(1, 1e-300), (2, 1.0)]).unwrap();
        assert_eq!((tiny.joints(), tiny.weights()), ([2, 0, 0, 0], [1.0, 0.0, 0.0, 0.0]));
    }

    #[test]
    fn blending_is_linear_in_every_joint() {
        let of = [
            Influences::of([(0, 0.5), (1, 0.5)]).unwrap(),
            Influences::of([(1, 0.25), (2, 0.75)]).unwrap(),
            Influences::one(3),
        ];
        let made = Influences::blend([0.5, 0.3, 0.2], of);
        for (joint, expected) in [(0, 0.25), (1, 0.325), (2, 0.225), (3, 0.2)] {
            assert!((made.weight_of(joint) - expected).abs() < 1e-7, "{joint}");
        }
        assert_eq!(Influences::blend([0.0, 0.0, 1.0], of), of[2]);
        assert!((of[0].difference(&of[1]) - 0.75).abs() < 1e-7 && of[0].difference(&of[0]) == 0.0);
    }
}
