//! The energy of maps as a quadratic form of their integers, for those who measure roundings.

use crate::engine::parameterize::rounding::gram::Basis;
use crate::engine::parameterize::rounding::periods::Periods;

/// The energy that integers `q` add to the best map at a scale: `(q − s q*)ᵀ P (q − s q*)` (`[kaelberer_2013]` section 6.3),
/// relative to `s² ½‖X‖²`.
#[derive(Clone, Debug)]
pub struct PeriodForm {
    /// Number of integers.
    pub n: usize,
    /// `P`, n × n, row after row.
    pub matrix: Vec<f64>,
    /// The real optimum `q*` at scale 1.
    pub optimum: Vec<f64>,
    /// The basis of the thesis, translations along a shortest cut graph: n × n, one vector per row.
    pub shortest_cut: Vec<f64>,
    /// In a reduced basis (`[lenstra_1982]`), per integer the energy that its unit adds when those before it follow: the squared
    /// diagonal of the Cholesky factor. `None` where there are too many integers for one.
    pub reduced: Option<Vec<f64>>,
}

impl PeriodForm {
    /// Energies are multiplied by `unit`.
    pub(in crate::engine::parameterize) fn new(periods: &Periods, shortest_cut: Basis, unit: f64) -> Self {
        let n = periods.gram.n;
        let scaled = |rows: &[f64]| rows.iter().map(|p| unit * p).collect();
        let reduced = periods.lattice.as_ref().and_then(|lattice| {
            let factor = lattice.gram.cholesky(&(0..n).collect::<Vec<_>>())?;
            Some(factor.iter().step_by(n + 1).map(|d| unit * d * d).collect())
        });
        Self {
            n,
            matrix: scaled(&periods.gram.rows),
            optimum: periods.optimum.clone(),
            shortest_cut: shortest_cut.vectors,
            reduced,
        }
    }
}
