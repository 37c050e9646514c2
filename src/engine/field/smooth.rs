//! The smoothest cross field that follows features, boundary and stable curvature.
//!
//! A cross is the complex number `c = e^{4iθ}` per face; the energy is `Σ w |c_s e^{4iρ} − c_t|²` over interior edges
//! (`[knoeppel_2013]`, restated for faces) plus an alignment to principal directions that grows with
//! their anisotropy over one quad. Faces at features and at the boundary are fixed. Normalising and solving again with
//! a decreasing time step (Merriman–Bence–Osher) removes spurious dipoles.

use crate::engine::field::branch::{BranchOptions, BranchSearch, Effort, Surroundings, search_branch_points};
use crate::engine::field::cleanup::{cancel_pairs, mend_sectors};
use crate::engine::field::cross_field::{CrossField, FieldError, unit};
use crate::engine::field::curvature::Guidance;
use crate::engine::field::frames::Frames;
use crate::engine::field::smooth_system::System;
use crate::engine::field::strokes::StrokeGuidance;
use crate::engine::field::transfer::FieldStart;
use crate::engine::field::turning::Turning;
use crate::engine::mesh::TriMesh;
use crate::engine::numerics::Random;
use crate::engine::run::RunContext;
use faer::c64;

/// What the field is asked for.
#[derive(Clone, Debug)]
pub struct FieldOptions {
    /// Length of a quad edge in model units.
    pub edge_length: f64,
    /// 0 follows the guidance as hard as possible, 1 is as smooth as possible.
    pub smoothing: f64,
    /// Whether and how branch points are moved to where the field can be integrated best.
    pub branch_points: Option<BranchOptions>,
    /// Lines to follow.
    pub strokes: Option<StrokeGuidance>,
    /// Crosses to begin with instead of the smoothest ones. Their branch points are only moved a little.
    pub start: Option<FieldStart>,
}

/// Normalised solves after the first, each with half the time step of the last.
const NORMALISED_SOLVES: usize = 3;

/// Share of the area whose principal directions are trusted, those with the most anisotropy (`[kaelberer_2013]` section
/// 5.1.2: 10 to 30 %). The other faces follow them: the solve does at once what the thesis does by parallel transport
/// breadth first and smoothing, and leaves no seams where the fronts meet.
/// The factor of (5.2) against noise is left out: the tensors are averaged over a quad, and with it the
/// energy of the maps is higher.
const TRUSTED: f64 = 0.2;
/// Faces nearly as anisotropic as the last trusted one are trusted too: on a cylinder all are alike.
const MIN_TRUSTED: f64 = 0.95;

/// Singularities of opposite index nearer than this many quad edges are cancelled: the grid cannot hold them apart
/// without bending far around.
const PAIR_DISTANCE: f64 = 1.5;

/// The same for those that a search has brought to where they are, on the mesh that it ended on and on the next.
/// The search does not know that the grid will hold them one quad apart.
const SEARCHED_PAIR_DISTANCE: f64 = 1.3;
const CARRIED_PAIR_DISTANCE: f64 = 1.0;
/// Crosses of another mesh are smoothed over about this many quad edges.
const START_REACH: f64 = 0.15;

/// Weight of a stroke in its faces: more than their neighbours', whose three edges weigh about ten.
const STROKE: f64 = 100.0;

/// How far the steps of a field have come in its time: means of four models of 5,000 and 8,000 quads.
struct Shares {
    /// The field is smooth.
    smoothed: f64,
    /// The system by which the crosses follow their matching is factored.
    factored: f64,
    /// The branch points have been searched for; a second search may follow.
    searched: f64,
}

const SHARES: Shares = Shares { smoothed: 0.1, factored: 0.15, searched: 0.9 };
/// The same for a field that is carried over from another mesh.
const SHARES_CONTINUED: Shares = Shares { smoothed: 0.15, factored: 0.25, searched: 0.75 };

/// Smooths a cross field; then its branch points are searched for, if that is asked for. `is_feature` is a flag per
/// halfedge: features, and the boundary where it is to be followed.
///
/// # Errors
/// [`FieldError`] if the run was stopped or a solve failed.
pub fn smooth_cross_field(
    ctx: &RunContext,
    mesh: &TriMesh,
    frames: &Frames,
    is_feature: &[bool],
    guidance: Option<&Guidance>,
    options: &FieldOptions,
) -> Result<(CrossField, BranchSearch), FieldError> {
    let fixed = fixed_crosses(mesh, frames, is_feature);
    let (mut alignment, mut target) = alignment(mesh, frames, guidance, options);
    follow_strokes(options.strokes.as_ref(), &mut alignment, &mut target);
    let mut system = System::new(mesh, frames, &fixed);
    let shares = if options.start.is_some() { &SHARES_CONTINUED } else { &SHARES };
    ctx.advance(0.3 * shares.smoothed);
    ctx.check()?;
    let c = match &options.start {
        Some(start) => continued(mesh, frames, &mut system, start, options.edge_length)?,
        None => smoothest(
            &ctx.span(0.0, shares.smoothed),
            mesh,
            frames,
            &mut system,
            (&alignment, &target),
            &fixed,
            options,
        )?,
    };
    ctx.advance(shares.smoothed);
    ctx.check()?;
    let angle = c.iter().map(|c| 0.25 * c.im.atan2(c.re)).collect();
    let mut field = CrossField::from_angles(mesh, frames, angle);
    let mended = mend_sectors(mesh, frames, &mut field, is_feature);
    field.update_indices(mesh, frames);
    let pair_distance = if options.start.is_some() { CARRIED_PAIR_DISTANCE } else { PAIR_DISTANCE };
    let cancelled = cancel_pairs(mesh, frames, &mut field, is_feature, pair_distance * options.edge_length);
    let mut found = BranchSearch::default();
    if cancelled + mended > 0 || options.branch_points.is_some() {
        let is_fixed: Vec<bool> = fixed.iter().map(Option::is_some).collect();
        let turning = Turning::new(mesh, frames, &is_fixed, &alignment)?;
        let rest = field.angle.clone();
        ctx.advance(shares.factored);
        ctx.check()?;
        turning.relax(mesh, frames, &mut field, &rest);
        if let Some(branch_points) = &options.branch_points {
            let around = Surroundings { mesh, frames, is_feature, turning: &turning, edge_length: options.edge_length };
            let effort = if options.start.is_some() { Effort::Touch } else { Effort::Full };
            found = search_branch_points(
                &ctx.span(shares.factored, shares.searched),
                &around,
                &mut field,
                branch_points,
                effort,
            )?;
            let near = SEARCHED_PAIR_DISTANCE * options.edge_length;
            if cancel_pairs(mesh, frames, &mut field, is_feature, near) > 0 {
                turning.relax(mesh, frames, &mut field, &rest);
                found.go_on(search_branch_points(
                    &ctx.span(shares.searched, 1.0),
                    &around,
                    &mut field,
                    branch_points,
                    Effort::Touch,
                )?);
            }
        }
    }
    Ok((field, found))
}

/// The smooth field that follows its guidance: a linear solve, then some whose result is normalised.
fn smoothest(
    ctx: &RunContext,
    mesh: &TriMesh,
    frames: &Frames,
    system: &mut System,
    (alignment, target): (&[f64], &[c64]),
    fixed: &[Option<c64>],
    options: &FieldOptions,
) -> Result<Vec<c64>, FieldError> {
    let total_alignment: f64 = alignment.iter().sum();
    let stiffness: f64 = system.diagonal.iter().sum();
    let mut c: Vec<c64> = if fixed.iter().any(Option::is_some) || total_alignment > 1e-6 * stiffness {
        let shift: Vec<f64> = alignment.iter().map(|a| a + 1e-9).collect();
        let rhs: Vec<c64> = alignment.iter().zip(target).map(|(a, q)| *q * *a).collect();
        system.solve(&shift, &rhs)?
    } else {
        smallest_eigenvector(ctx, mesh, system)?
    };
    normalise(&mut c);
    let mass: Vec<f64> = (0..mesh.n_faces()).map(|f| frames.area(mesh, f)).collect();
    let mut step = options.edge_length.powi(2);
    for solve in 0..NORMALISED_SOLVES {
        ctx.check()?;
        ctx.advance((1 + solve) as f64 / (1 + NORMALISED_SOLVES) as f64);
        let shift: Vec<f64> = alignment.iter().zip(&mass).map(|(a, m)| a + m / step).collect();
        let rhs: Vec<c64> = (0..c.len()).map(|f| target[f] * alignment[f] + c[f] * (mass[f] / step)).collect();
        c = system.solve(&shift, &rhs)?;
        normalise(&mut c);
        step *= 0.5;
    }
    Ok(c)
}

/// The field of another mesh, smoothed over what is small there.
fn continued(
    mesh: &TriMesh,
    frames: &Frames,
    system: &mut System,
    start: &FieldStart,
    edge_length: f64,
) -> Result<Vec<c64>, FieldError> {
    let reach = (START_REACH * edge_length).powi(2);
    let weight = |f: usize| if start.cross[f] == c64::new(0.0, 0.0) { 1e-9 } else { frames.area(mesh, f) / reach };
    let shift: Vec<f64> = (0..mesh.n_faces()).map(weight).collect();
    let rhs: Vec<c64> = shift.iter().zip(&start.cross).map(|(a, c)| *c * *a).collect();
    let mut c = system.solve(&shift, &rhs)?;
    normalise(&mut c);
    Ok(c)
}

/// Crosses of faces that have a feature or boundary edge.
fn fixed_crosses(mesh: &TriMesh, frames: &Frames, is_feature: &[bool]) -> Vec<Option<c64>> {
    (0..mesh.n_faces())
        .map(|f| (3 * f..3 * f + 3).find(|&h| is_feature[h]).map(|h| unit(4.0 * frames.angle[h])))
        .collect()
}

/// Weight and target of the guidance per face. The weight is the area in quads times the squared anisotropy over one
/// quad, so that the field follows curvature after a distance of `1/(anisotropy · h)` quads.
fn alignment(
    mesh: &TriMesh,
    frames: &Frames,
    guidance: Option<&Guidance>,
    options: &FieldOptions,
) -> (Vec<f64>, Vec<c64>) {
    let n = mesh.n_faces();
    let Some(guidance) = guidance.filter(|_| options.smoothing < 1.0) else {
        return (vec![0.0; n], vec![c64::new(0.0, 0.0); n]);
    };
    let strength = (1.0 - options.smoothing) / options.smoothing.max(1e-3);
    let h = options.edge_length;
    let size = |f: usize| mesh.face(f).map(|v| frames.size(v)).iter().sum::<f64>() / 3.0;
    let area: Vec<f64> = (0..n).map(|f| frames.area(mesh, f)).collect();
    let turn: Vec<f64> = (0..n).map(|f| guidance.anisotropy[f] * h * size(f)).collect();
    let least = MIN_TRUSTED * trusted_from(&turn, &area);
    let weight = (0..n)
        .map(|f| if turn[f] >= least { strength * turn[f].min(1.0).powi(2) * area[f] / (h * h) } else { 0.0 })
        .collect();
    (weight, guidance.angle.iter().map(|a| unit(4.0 * a)).collect())
}

/// The value that the most stable share of the area does not fall below.
fn trusted_from(stability: &[f64], area: &[f64]) -> f64 {
    let mut order: Vec<usize> = (0..stability.len()).collect();
    order.sort_unstable_by(|&a, &b| stability[b].total_cmp(&stability[a]));
    let mut left = TRUSTED * area.iter().sum::<f64>();
    let last = order.into_iter().find(|&f| {
        left -= area[f];
        left <= 0.0
    });
    last.map_or(0.0, |f| stability[f])
}

/// Makes the field follow strokes: their faces are all but fixed.
fn follow_strokes(strokes: Option<&StrokeGuidance>, alignment: &mut [f64], target: &mut [c64]) {
    let Some(strokes) = strokes else { return };
    for ((alignment, target), &cross) in alignment.iter_mut().zip(target).zip(&strokes.cross) {
        let norm = cross.re.hypot(cross.im);
        if norm > 0.0 {
            (*alignment, *target) = (STROKE, cross * (1.0 / norm));
        }
    }
}

fn normalise(c: &mut [c64]) {
    for c in c {
        let norm = c.re.hypot(c.im);
        *c = if norm > 1e-300 { *c * (1.0 / norm) } else { c64::new(1.0, 0.0) };
    }
}

/// Inverse iteration for the smoothest field of all when nothing pins it down.
fn smallest_eigenvector(ctx: &RunContext, mesh: &TriMesh, system: &mut System) -> Result<Vec<c64>, FieldError> {
    let scale: f64 = system.diagonal.iter().sum::<f64>() / system.n.max(1) as f64;
    let n = system.n;
    let factor = system.factor(&vec![1e-8 * scale; mesh.n_faces()])?;
    // A start without symmetry, the same in every run with this seed.
    let mut random = Random::new(ctx.seed());
    let mut x: Vec<c64> = (0..n).map(|_| unit(random.unit() * std::f64::consts::TAU)).collect();
    for _ in 0..20 {
        ctx.check()?;
        factor.solve(&mut x);
        let norm = x.iter().map(|c| c.re * c.re + c.im * c.im).sum::<f64>().sqrt().max(1e-300);
        x.iter_mut().for_each(|c| *c *= 1.0 / norm);
    }
    Ok(system.spread(&x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_stable_share_of_the_area_is_trusted() {
        let stability: Vec<f64> = (0..100).map(|i| f64::from(i * 37 % 100)).collect();
        // 20 of 100; and 22 of 110, where the first ten count twice.
        assert_eq!(trusted_from(&stability, &[1.0; 100]), 80.0);
        let area: Vec<f64> = stability.iter().map(|&s| if s >= 90.0 { 2.0 } else { 1.0 }).collect();
        assert_eq!(trusted_from(&stability, &area), 88.0);
        assert_eq!(trusted_from(&[3.0; 7], &[1.0; 7]), 3.0, "where all are alike all are trusted");
        assert_eq!(trusted_from(&[], &[]), 0.0);
    }
}
