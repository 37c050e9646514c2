//! From a cross field to a seamless map, and from there to an integer-grid map.
//!
//! All conditions of an integer-grid map but integrality are linear and are eliminated exactly: transitions by the
//! corner forms, closing fans, straight features and boundaries by `Elimination`. One factorisation of the continuous
//! unknowns serves every density: the right-hand side is proportional to the scale.

use crate::engine::field::CrossField;
use crate::engine::field::Frames;
use crate::engine::mesh::TriMesh;
use crate::engine::numerics::Cholesky;
use crate::engine::parameterize::constraints::{constrain, iso_lines, special_vertices};
use crate::engine::parameterize::corner_forms::{CornerForms, real_parts};
use crate::engine::parameterize::generators::generators;
use crate::engine::parameterize::grid_map::{GridMap, Iso, rotate_integer};
use crate::engine::parameterize::map_aim::{MapAim, Precision};
use crate::engine::parameterize::map_error::MapError;
use crate::engine::parameterize::poisson::{Quadratic, assemble};
use crate::engine::parameterize::quantise::quantise;
use crate::engine::parameterize::reduced::{Reduced, Unknowns};
use crate::engine::parameterize::rounding::{PeriodForm, Periods};
use crate::engine::parameterize::separation::{Elements, Separation, separations};
use crate::engine::parameterize::shortest_cut::cut_costs;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;
use crate::engine::topology::CutGraph;
use crate::engine::topology::Segment;
use crate::engine::topology::cut_and_comb;
use glam::{DVec2, I64Vec2};

/// Most integers for which the dense period matrix is formed (18 MB, and seconds to round); more are found by flow.
const MOST_BY_PERIODS: usize = 1500;
/// Integers by flow are taken if at least this many times fewer neighbours collapse,
const FEWER: usize = 2;
/// and if they cost at most this many times the energy: lengths near to those of the seamless map say nothing of angles.
const DEARER: f64 = 1.5;
/// Most singularities and corners: positions against one origin make the coupling of more of them take minutes.
const MOST_SPECIAL: usize = 2500;

/// The linear system of all maps that follow one cross field on one component.
#[derive(Clone, Debug)]
pub struct MapSystem {
    cut: CutGraph,
    /// What each segment cost to cut: the length of the path between singularities that it is a part of, model units;
    /// 0 for parts of several.
    cut_cost: Vec<f64>,
    forms: CornerForms,
    unknowns: Unknowns,
    iso: Vec<Iso>,
    special: Vec<u32>,
    /// Gradients of u and v per face that the map should have, in the combed charts.
    gradients: Vec<[DVec2; 2]>,
    reduced: Reduced,
    factor: Cholesky<f64>,
    /// Unless there are too many integers.
    periods: Option<Periods>,
    /// Real optimum of the integers for scale 1.
    optimum: Vec<f64>,
    /// Corner values of the map with them.
    seamless: Vec<DVec2>,
    constant: f64,
    /// Real forms that must be integers, in raw unknowns.
    integral: Vec<Vec<(u32, f64)>>,
}

/// Integers of a map and what they cost.
#[derive(Clone, Debug)]
pub struct RoundedIntegers {
    /// Grid units per model unit.
    pub scale: f64,
    q: Vec<f64>,
    /// Neighbouring singularities, corners or curves that lie on the same grid point or line.
    pub fallen_together: usize,
    /// Energy of the seamless map (real integers) relative to ½‖X‖².
    pub curl_energy: f64,
    /// Energy added by rounding, relative to ½‖X‖².
    pub rounding_energy: f64,
}

impl MapSystem {
    /// Sets up and factors the system. `is_feature` is a flag per halfedge (features and boundary), `corners` are
    /// vertices that must lie on integer points, `aim` says which gradients the map should have, and how closely.
    ///
    /// # Errors
    /// [`MapError`] if a solve failed, the integers are not determined, or the run was stopped.
    pub fn new(
        ctx: &RunContext,
        mesh: &TriMesh,
        frames: &Frames,
        field: &CrossField,
        is_feature: &[bool],
        corners: &[u32],
        aim: impl Into<MapAim>,
    ) -> Result<Self, MapError> {
        let aim = aim.into();
        let cost = cut_costs(mesh, &field.quarter_index);
        let (cut, _, turns) = cut_and_comb(mesh, &field.matching, &field.quarter_index, &cost);
        let dearest = |s: &Segment| s.halfedges.iter().map(|&h| cost[h]).fold(0.0, f64::max);
        let cut_cost = cut.segments.iter().map(dearest).collect();
        let gradients = aim.combed(&field.angle, &turns);
        let iso = iso_lines(mesh, frames, &gradients, is_feature);
        let forms = CornerForms::new(mesh, &cut);
        let special: Vec<u32> = special_vertices(mesh, field, corners);
        if special.len() > MOST_SPECIAL {
            return Err(MapError::TooManyIntegers { n: 2 * special.len(), limit: 2 * MOST_SPECIAL });
        }
        let (unknowns, integral) = constrain(mesh, &forms, &iso, &special)?;
        ctx.check()?;
        ctx.advance(0.1);
        let raw: Quadratic = assemble(mesh, frames, &gradients, &aim.weight, &forms);
        let reduced = Reduced::new(&raw, &unknowns);
        let n = unknowns.n_integers;
        ctx.check()?;
        ctx.advance(0.3);
        let factor = reduced.factor()?;
        let mut periods = match n > MOST_BY_PERIODS {
            true => None,
            false => Some(Periods::new(&ctx.span(0.5, 1.0), &reduced, &factor)?.ok_or(MapError::Periods { n })?),
        };
        let optimum = match &mut periods {
            Some(periods) if aim.precision == Precision::Refined => periods.refine(&reduced, &factor).to_vec(),
            Some(periods) => periods.optimum.clone(),
            None => reduced.optimum()?,
        };
        let mut system = Self {
            cut,
            cut_cost,
            forms,
            unknowns,
            iso,
            special,
            gradients,
            reduced,
            factor,
            periods,
            optimum,
            seamless: Vec::new(),
            constant: raw.constant,
            integral,
        };
        system.solve_seamless();
        Ok(system)
    }

    /// The map before rounding is the same at every scale but for the scale.
    fn solve_seamless(&mut self) {
        let z = self.reduced.solve_continuous(&self.factor, 1.0, &self.optimum);
        self.seamless = self.corners(&self.unknowns.expand(&z, &self.optimum));
    }

    /// Number of integers.
    pub fn n_integers(&self) -> usize {
        self.unknowns.n_integers
    }

    /// Gradients that the map should have: see the field.
    pub fn gradients(&self) -> &[[DVec2; 2]] {
        &self.gradients
    }

    /// Integers for a density of `scale` grid units per model unit: by the period matrix; by flow where there are too many
    /// for that, or where far fewer neighbours collapse then for little more energy.
    ///
    /// # Errors
    /// [`Cancelled`] if the run was stopped, [`MapError::NoFlow`] if there are too many integers for the period matrix and
    /// no flow was found.
    pub fn round(&self, ctx: &RunContext, mesh: &TriMesh, scale: f64) -> Result<RoundedIntegers, MapError> {
        let seamless = self.seamless_at(scale);
        let elements = self.elements(mesh, &seamless);
        let separations = separations(&elements);
        let mut best = match &self.periods {
            Some(periods) => Some(periods.round(&ctx.span(0.1, 0.5), scale, &separations)?),
            None => None,
        };
        if best.as_ref().is_none_or(|b| b.1 > 0)
            && let Some(by_flow) =
                self.flow(&ctx.span(if best.is_some() { 0.5 } else { 0.1 }, 1.0), &elements, scale, &separations)?
        {
            let is_better = |b: &(Vec<f64>, usize)| {
                let excess = |q: &[f64]| self.periods.as_ref().map_or(0.0, |p| p.excess(scale, q));
                FEWER * by_flow.1 <= b.1 && excess(&by_flow.0) <= DEARER * excess(&b.0)
            };
            if best.as_ref().is_none_or(is_better) {
                best = Some(by_flow);
            }
        }
        let (q, fallen_together) = best.ok_or(MapError::NoFlow { n: self.n_integers() })?;
        Ok(self.rounded(scale, q, fallen_together))
    }

    /// As [`MapSystem::round`] by flow alone; `None` if there is none.
    #[cfg(test)]
    pub(super) fn round_by_flow(
        &self,
        ctx: &RunContext,
        mesh: &TriMesh,
        scale: f64,
    ) -> Result<Option<RoundedIntegers>, Cancelled> {
        let seamless = self.seamless_at(scale);
        let elements = self.elements(mesh, &seamless);
        let found = self.flow(ctx, &elements, scale, &separations(&elements))?;
        Ok(found.map(|(q, fallen_together)| self.rounded(scale, q, fallen_together)))
    }

    /// The same system as if it had too many integers for the period matrix.
    #[cfg(test)]
    pub(super) fn without_periods(mut self) -> Self {
        self.optimum = self.reduced.optimum().unwrap();
        self.periods = None;
        self.solve_seamless();
        self
    }

    /// What integers add in energy to this system's map, relative to ½‖X‖².
    #[cfg(test)]
    pub(super) fn added_energy(&self, integers: &RoundedIntegers) -> f64 {
        self.rounded(integers.scale, integers.q.clone(), 0).rounding_energy
    }

    fn seamless_at(&self, scale: f64) -> Vec<DVec2> {
        self.seamless.iter().map(|z| *z * scale).collect()
    }

    fn elements<'a>(&'a self, mesh: &'a TriMesh, seamless: &'a [DVec2]) -> Elements<'a> {
        Elements {
            mesh,
            cut: &self.cut,
            forms: &self.forms,
            unknowns: &self.unknowns,
            iso: &self.iso,
            special: &self.special,
            seamless,
        }
    }

    /// Integers by flow, and how many separations they violate.
    fn flow(
        &self,
        ctx: &RunContext,
        elements: &Elements<'_>,
        scale: f64,
        separations: &[Separation],
    ) -> Result<Option<(Vec<f64>, usize)>, Cancelled> {
        let real: Vec<f64> = self.optimum.iter().map(|q| scale * q).collect();
        let z = self.reduced.solve_continuous(&self.factor, scale, &real);
        let q = quantise(ctx, elements, &self.unknowns.expand(&z, &real))?;
        let violated = |q: &[f64]| separations.iter().filter(|s| s.is_violated(q)).count();
        Ok(q.map(|q| {
            let n_violated = violated(&q);
            (q, n_violated)
        }))
    }

    fn rounded(&self, scale: f64, q: Vec<f64>, fallen_together: usize) -> RoundedIntegers {
        let norm = self.constant * scale * scale;
        let rounding_energy = match &self.periods {
            Some(periods) => periods.excess(scale, &q),
            None => self.energy(scale, &q) + self.gain() * scale * scale,
        } / norm;
        let curl_energy = ((self.constant - self.gain()) / self.constant).max(0.0);
        RoundedIntegers { scale, q, fallen_together, curl_energy, rounding_energy }
    }

    /// What the best seamless map gains at scale 1: its energy is E* = constant − bᵀ x*, with x* the optimum of all
    /// unknowns, real integers included.
    fn gain(&self) -> f64 {
        -self.energy(1.0, &self.optimum)
    }

    /// Energy of the best map with these integers, up to the constant.
    fn energy(&self, scale: f64, q: &[f64]) -> f64 {
        let z = self.reduced.solve_continuous(&self.factor, scale, q);
        self.reduced.energy(scale, &z, q)
    }

    fn periods(&self) -> Result<&Periods, MapError> {
        let too_many = MapError::TooManyIntegers { n: self.n_integers(), limit: MOST_BY_PERIODS };
        self.periods.as_ref().ok_or(too_many)
    }

    /// The energy as a form of the integers, for measuring.
    ///
    /// # Errors
    /// [`MapError::TooManyIntegers`] if there is no such matrix.
    pub fn period_form(&self) -> Result<PeriodForm, MapError> {
        let shortest_cut = generators(&self.cut, &self.forms, &self.unknowns, &self.cut_cost);
        Ok(PeriodForm::new(self.periods()?, shortest_cut, 1.0 / self.constant))
    }

    /// Integers near a real optimum, found by the search of [`MapSystem::round`] with nothing to keep apart.
    ///
    /// # Errors
    /// [`Cancelled`] if the run was stopped, [`MapError::TooManyIntegers`] if there is no period matrix.
    pub fn nearest(&self, ctx: &RunContext, target: &[f64]) -> Result<Vec<f64>, MapError> {
        Ok(self.periods()?.nearest(ctx, target, &[])?.0)
    }

    /// The seamless map before rounding, for measuring: corner values in grid units at scale 1.
    pub fn seamless_corners(&self) -> &[DVec2] {
        &self.seamless
    }

    /// The map with these integers.
    ///
    /// # Errors
    /// [`MapError::Fractions`] if positions that must be integers are not.
    pub fn map(&self, mesh: &TriMesh, rounded: &RoundedIntegers) -> Result<GridMap, MapError> {
        let z = self.reduced.solve_continuous(&self.factor, rounded.scale, &rounded.q);
        self.grid_map(mesh, &z, &rounded.q)
    }

    fn grid_map(&self, mesh: &TriMesh, z: &[f64], q: &[f64]) -> Result<GridMap, MapError> {
        let raw = self.unknowns.expand(z, q);
        let off_grid = |form: &Vec<(u32, f64)>| {
            let value: f64 = form.iter().map(|&(x, c)| c * raw[x as usize]).sum();
            (value - value.round()).abs() > 1e-6
        };
        let n = self.integral.iter().filter(|f| off_grid(f)).count();
        if n > 0 {
            return Err(MapError::Fractions { n });
        }
        let mut rotation = vec![0u8; mesh.n_halfedges()];
        let mut translation = vec![I64Vec2::ZERO; mesh.n_halfedges()];
        for (k, segment) in self.cut.segments.iter().enumerate() {
            let u = 2 * (self.forms.n_vertices + k);
            let tau = I64Vec2::new(raw[u].round() as i64, raw[u + 1].round() as i64);
            let m = segment.quarters;
            let back = (4 - m) & 3;
            for &h in &segment.halfedges {
                (rotation[h], translation[h]) = (m, tau);
                if let Some(t) = mesh.twin(h) {
                    (rotation[t], translation[t]) = (back, -rotate_integer(tau, back));
                }
            }
        }
        Ok(GridMap { uv: self.corners(&raw), rotation, translation, iso: self.iso.clone() })
    }

    fn corners(&self, raw: &[f64]) -> Vec<DVec2> {
        let value = |form: &Vec<(u32, f64)>| form.iter().map(|&(x, c)| c * raw[x as usize]).sum::<f64>();
        self.forms
            .corner
            .iter()
            .map(|form| {
                let [re, im] = real_parts(form);
                DVec2::new(value(&re), value(&im))
            })
            .collect()
    }
}
