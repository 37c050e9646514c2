//! The numbers that linear systems are made of.

use std::ops::{AddAssign, Mul, SubAssign};

use faer::c64;
use faer::traits::ComplexField;

/// A real or complex number.
pub trait Scalar: ComplexField + Copy + Send + Sync + AddAssign + SubAssign + Mul<Output = Self> {
    /// The complex conjugate; real numbers are their own.
    fn conjugate(self) -> Self;
    /// The real part.
    fn real_part(self) -> f64;
    /// A real number.
    fn from_real(value: f64) -> Self;
    /// The product with a real number.
    fn scaled(self, factor: f64) -> Self;
}

impl Scalar for f64 {
    #[inline]
    fn conjugate(self) -> Self {
        self
    }

    #[inline]
    fn real_part(self) -> f64 {
        self
    }

    #[inline]
    fn from_real(value: f64) -> Self {
        value
    }

    #[inline]
    fn scaled(self, factor: f64) -> Self {
        self * factor
    }
}

impl Scalar for c64 {
    #[inline]
    fn conjugate(self) -> Self {
        self.conj()
    }

    #[inline]
    fn real_part(self) -> f64 {
        self.re
    }

    #[inline]
    fn from_real(value: f64) -> Self {
        Self::new(value, 0.0)
    }

    #[inline]
    fn scaled(self, factor: f64) -> Self {
        self * factor
    }
}
