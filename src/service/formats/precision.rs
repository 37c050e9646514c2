//! How many digits numbers in files need.

use std::fmt::{Display, Formatter, LowerExp, Result};

use glam::DVec3;

/// The precision of a list of positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Precision {
    /// Every coordinate is a number of single precision.
    Single,
    /// At least one is not.
    Double,
}

impl Precision {
    /// The least precision that holds these positions.
    pub(super) fn of(positions: &[DVec3]) -> Self {
        let is_single = |x: f64| f64::from(x as f32) == x;
        match positions.iter().all(|p| p.to_array().into_iter().all(is_single)) {
            true => Self::Single,
            false => Self::Double,
        }
    }

    /// A coordinate as text.
    pub(super) fn shown(self, x: f64) -> Shown {
        match self {
            Self::Single => Shown::Single(Shortest(x as f32)),
            Self::Double => Shown::Double(Shortest(x)),
        }
    }

    /// A position as text.
    pub(super) fn shown_all(self, p: DVec3) -> [Shown; 3] {
        p.to_array().map(|x| self.shown(x))
    }
}

/// What a text says, where all of it was written in single precision: the fewest digits that tell a single precision number
/// from its neighbours are another number in double precision. Text in which one number needs more digits stays as it is.
pub(super) fn as_written(positions: &mut [DVec3]) {
    let is_short = |x: f64| Shortest(x as f32).to_string().parse() == Ok(x);
    if positions.iter().all(|p| p.to_array().into_iter().all(is_short)) {
        positions.iter_mut().for_each(|p| *p = p.as_vec3().as_dvec3());
    }
}

/// A coordinate in its precision.
#[derive(Clone, Copy, Debug)]
pub(super) enum Shown {
    Single(Shortest<f32>),
    Double(Shortest<f64>),
}

impl Display for Shown {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            Self::Single(x) => x.fmt(f),
            Self::Double(x) => x.fmt(f),
        }
    }
}

/// A number with the fewest digits that re-read to it, with an exponent where it would need many zeros.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shortest<T>(pub(super) T);

impl<T: Copy + Display + LowerExp + Into<f64>> Display for Shortest<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let size: f64 = self.0.into().abs();
        if size == 0.0 || (1e-4..1e16).contains(&size) { Display::fmt(&self.0, f) } else { LowerExp::fmt(&self.0, f) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_read_back_the_same() {
        for (x, text) in [
            (0.1, "0.1"),
            (0.0, "0"),
            (-250.0, "-250"),
            (1e-4, "0.0001"),
            (1.25e-7, "1.25e-7"),
            (1e300, "1e300"),
            (1.0 / 3.0, "0.3333333333333333"),
            (f64::from(0.1f32), "0.10000000149011612"),
        ] {
            assert_eq!(Shortest(x).to_string(), text);
            assert_eq!(text.parse(), Ok(x));
        }
        assert_eq!(Shortest(1.25e-7f32).to_string(), "1.25e-7");
        assert_eq!(Precision::Single.shown(f64::from(0.1f32)).to_string(), "0.1");
    }

    #[test]
    fn text_of_single_precision_means_single_precision() {
        let single = [0.1f32, 1.0 / 3.0, 1e-30, 16_777_216.0, 3.402_823_5e38, -0.0].map(f64::from);
        let mut read = [DVec3::ZERO; 2];
        let positions = [DVec3::from_slice(&single[..3]), DVec3::from_slice(&single[3..])];
        assert_eq!(Precision::of(&positions), Precision::Single);
        for (p, q) in read.iter_mut().zip(&positions) {
            *p = DVec3::from_array(Precision::Single.shown_all(*q).map(|x| x.to_string().parse().unwrap()));
        }
        assert_ne!(read, positions);
        as_written(&mut read);
        assert_eq!(read, positions);
        // One number that single precision does not hold, and every digit counts.
        for odd in [1.0 / 3.0, 1e300, f64::NAN, 16_777_217.0] {
            let mut double = [DVec3::new(0.1, 0.2, odd)];
            assert_eq!(Precision::of(&double), Precision::Double);
            let before = double.map(|p| p.to_array().map(f64::to_bits));
            as_written(&mut double);
            assert_eq!(double.map(|p| p.to_array().map(f64::to_bits)), before);
        }
    }
}
