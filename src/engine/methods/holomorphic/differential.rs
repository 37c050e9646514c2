//! The harmonic foliation of a class: branch points moved to where it has zeros instead of poles.
//!
//! With a branch point beside its place, the harmonic form has a simple pole there and a double zero half-way to the place.
//! The energy does not see that (it is cubic there), so the coefficient of the pole is brought to zero by Newton's method,
//! all branch points at once.

use std::collections::VecDeque;

use glam::{DVec2, DVec3};

use crate::engine::calculus::{CalculusError, Laplacian, OneForm, Stars};
use crate::engine::mesh::{TriMesh, prev};
use crate::engine::methods::holomorphic::cluster::surroundings;
use crate::engine::methods::holomorphic::foliation::Foliation;
use crate::engine::numerics::DisjointSets;
use crate::engine::run::RunContext;

/// Solves at most; 3 to 30 were seen.
const MOST_SOLVES: usize = 32;
/// Solves after which poles go step by step to the zeros beside them.
const LATE: usize = 14;
/// Newton's steps are shortened by this: neighbours answer each other.
const DAMPING: f64 = 0.8;
/// Steps are at most so many edges long; where one turns back, the next ones are shorter by `SLOWER`, else longer by `FASTER`:
/// aims far away, as those of branch points that have come too near to each other, are directions only.
const LONGEST: f64 = 10.0;
const SLOWER: f64 = 0.5;
const FASTER: f64 = 1.2;
/// Branch points nearer to each other than this many edges are looked at together, but no more than so many.
const TOGETHER: f64 = 4.0;
const MOST_TOGETHER: usize = 6;
/// A branch point goes to another vertex only if that brings it to this share of the way to its aim: else neighbours would be
/// exchanged for ever.
const NEARER: f64 = 0.75;
/// … and aims farther than so many edges are directions only.
const FAR: f64 = 2.0;
/// Vertices around a pole among which its double zero is looked for.
const MOST_LOOKED_AT: usize = 40;
/// Steps go at most this share of the way to the next branch point.
const CLAMP: f64 = 0.45;

/// How far a branch point may go at once, model units, and where it went last.
#[derive(Clone, Copy, Debug)]
struct Pace {
    reach: f64,
    last: DVec3,
}

/// A foliation with its harmonic form.
#[derive(Clone, Debug)]
pub(super) struct Differential {
    pub(super) foliation: Foliation,
    /// The harmonic form du, with the signs of the foliation.
    pub(super) form: OneForm,
    /// Solves that it took.
    pub(super) solves: usize,
}

/// Number of zeros by order, and of poles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Indices {
    /// Zeros with multiplicity.
    pub(super) zeros: usize,
    /// Poles.
    pub(super) poles: usize,
}

/// Moves the branch points until all of them are zeros.
///
/// # Errors
/// A stop, or a failed solve.
pub(super) fn harmonic_differential(
    ctx: &RunContext,
    mesh: &TriMesh,
    stars: &Stars,
    mut foliation: Foliation,
) -> Result<Differential, CalculusError> {
    let mut branch: Vec<u32> = foliation.signs.branch_points(mesh);
    let mut best: Option<((usize, usize), Differential)> = None;
    let mut solves = 0;
    let mut solver = Solver::new(mesh, stars);
    let mut paces = vec![Pace { reach: f64::INFINITY, last: DVec3::ZERO }; branch.len()];
    loop {
        ctx.check()?;
        let form = solver.solve(&foliation)?;
        solves += 1;
        ctx.advance(1.0 - 0.8_f64.powi(solves as i32));
        let mut moves = moves(mesh, &foliation, &form, &branch, &mut paces);
        let poles = indices(mesh, &foliation, &form).poles;
        if poles > 0 && (moves.is_empty() || solves > LATE) {
            let steps = towards_zeros(mesh, &foliation, &form, &branch);
            moves = if steps.is_empty() { moves } else { steps };
        }
        let rank = (poles, moves.len());
        if best.as_ref().is_none_or(|b| rank < b.0) {
            best = Some((rank, Differential { foliation: foliation.clone(), form, solves }));
        }
        // Without poles what is left are steps of an edge to and fro.
        if moves.is_empty() || solves >= MOST_SOLVES || (poles == 0 && solves >= LATE) {
            break;
        }
        for (k, path) in moves {
            for h in path {
                // Another one may have come in the way meanwhile.
                let to = mesh.target(h);
                if mesh.origin(h) != branch[k] || branch.contains(&to) {
                    break;
                }
                foliation.drag(mesh, h);
                branch[k] = to;
            }
        }
    }
    let mut found = match best {
        Some((_, found)) => found,
        None => Differential { form: solver.solve(&foliation)?, foliation, solves },
    };
    found.solves = solves;
    Ok(found)
}

/// Harmonic forms of foliations on one mesh.
pub(super) struct Solver<'a> {
    mesh: &'a TriMesh,
    stars: &'a Stars,
    last: Option<Laplacian>,
}

impl<'a> Solver<'a> {
    pub(super) fn new(mesh: &'a TriMesh, stars: &'a Stars) -> Self {
        Self { mesh, stars, last: None }
    }

    /// The harmonic form of a foliation's class with its branch points.
    pub(super) fn solve(&mut self, foliation: &Foliation) -> Result<OneForm, CalculusError> {
        let Self { mesh, stars, .. } = *self;
        let free = vec![false; mesh.n_vertices()];
        let laplacian = match &self.last {
            Some(last) => last.with_signs(mesh, stars, &foliation.signs, &free)?,
            None => Laplacian::new(mesh, stars, &foliation.signs, &free)?,
        };
        let form = laplacian.harmonic(mesh, stars, &foliation.form);
        self.last = Some(laplacian);
        Ok(form)
    }
}

/// The paths that branch points are to take, by their numbers.
fn moves(
    mesh: &TriMesh,
    foliation: &Foliation,
    form: &OneForm,
    branch: &[u32],
    paces: &mut [Pace],
) -> Vec<(usize, Vec<usize>)> {
    let edge_at = |p: u32| {
        let lengths = || mesh.fan(p).map(|h| mesh.position(mesh.target(h)).distance(mesh.position(p)));
        lengths().sum::<f64>() / lengths().count() as f64
    };
    let edges: Vec<f64> = branch.iter().map(|&p| edge_at(p)).collect();
    let distance = |i: usize, j: usize| mesh.position(branch[i]).distance(mesh.position(branch[j]));
    let mut sets = DisjointSets::new(branch.len());
    for i in 0..branch.len() {
        for j in 0..i {
            if distance(i, j) < TOGETHER * 0.5 * (edges[i] + edges[j]) {
                sets.join(i as u32, j as u32);
            }
        }
    }
    let mut moves = Vec::new();
    for first in 0..branch.len() {
        if sets.find(first as u32) != first as u32 {
            continue;
        }
        let members: Vec<usize> = (first..branch.len()).filter(|&k| sets.find(k as u32) == first as u32).collect();
        if members.len() > MOST_TOGETHER {
            continue;
        }
        let others = || (0..branch.len()).filter(|k| !members.contains(k));
        let next = members.iter().flat_map(|&i| others().map(move |j| distance(i, j))).fold(f64::INFINITY, f64::min);
        let edge = members.iter().map(|&k| edges[k]).sum::<f64>() / members.len() as f64;
        let points: Vec<u32> = members.iter().map(|&k| branch[k]).collect();
        let Some(around) = surroundings(mesh, &foliation.signs, form, &points, (next, edge)) else { continue };
        let mut goals: Vec<u32> = Vec::new();
        for (m, &k) in members.iter().enumerate() {
            let whole = around.aims[m] - around.now[m];
            let is_free = |v: u32| v == branch[k] || !branch.contains(&v) && !goals.contains(&v);
            let nearest = |step: DVec2| {
                let to = around.now[m] + step;
                let free = around.vertices.iter().filter(|(v, _)| is_free(*v));
                free.min_by(|a, b| a.1.distance(to).total_cmp(&b.1.distance(to)).then(a.0.cmp(&b.0))).map(|s| s.0)
            };
            // Where the shortened step leads no nearer to another vertex, the whole one may.
            let within = |reach: f64| {
                let short = nearest((DAMPING * whole).clamp_length_max(reach.min(CLAMP * next).max(edge)));
                short.filter(|&v| v != branch[k]).or_else(|| nearest(whole.clamp_length_max(edge)))
            };
            let towards = |v: u32| mesh.position(v) - mesh.position(branch[k]);
            let pace = &mut paces[k];
            let mut goal = within(pace.reach);
            if goal.is_some_and(|v| towards(v).dot(pace.last) < 0.0) {
                pace.reach *= SLOWER;
                goal = within(pace.reach);
            } else {
                pace.reach = (pace.reach * FASTER).min(LONGEST * edge);
            }
            let Some(goal) = goal.filter(|&v| v != branch[k]) else { continue };
            let is_short = around.aims[m].distance(around.now[m]) < FAR * edge;
            let left = |v: u32| around.vertices.iter().find(|s| s.0 == v).map(|s| s.1.distance(around.aims[m]));
            if is_short && left(goal) > left(branch[k]).map(|left| NEARER * left) {
                continue;
            }
            if let Some(path) = path(mesh, branch[k], goal, &around.vertices, branch) {
                pace.last = towards(goal);
                goals.push(goal);
                moves.push((k, path));
            }
        }
    }
    moves
}

/// Steps of one edge from branch points that are poles to the nearest zero at another vertex: the double zero that a pole
/// comes with.
fn towards_zeros(mesh: &TriMesh, foliation: &Foliation, form: &OneForm, branch: &[u32]) -> Vec<(usize, Vec<usize>)> {
    let mut moves: Vec<(usize, Vec<usize>)> = Vec::new();
    for (k, &p) in branch.iter().enumerate() {
        if index(mesh, foliation, form, p) <= 0 {
            continue;
        }
        // Per vertex reached, the halfedge out of p on the way to it.
        let mut reached: Vec<(u32, Option<usize>)> = vec![(p, None)];
        let mut at = 0;
        while at < reached.len().min(MOST_LOOKED_AT) {
            let (v, first) = reached[at];
            at += 1;
            if v != p && !branch.contains(&v) && index(mesh, foliation, form, v) < 0 {
                moves.extend(first.map(|h| (k, vec![h])));
                break;
            }
            for h in mesh.fan(v) {
                let w = mesh.target(h);
                let is_open = first.is_some() || !branch.contains(&w);
                if is_open && !reached.iter().any(|(known, _)| *known == w) {
                    reached.push((w, first.or(Some(h))));
                }
            }
        }
    }
    moves
}

/// Halfedges from one vertex to another over vertices that are seen and no branch points.
fn path(mesh: &TriMesh, from: u32, to: u32, seen: &[(u32, DVec2)], branch: &[u32]) -> Option<Vec<usize>> {
    let mut by: Vec<(u32, usize)> = Vec::new();
    let mut queue = VecDeque::from([from]);
    while let Some(v) = queue.pop_front() {
        if v == to {
            let mut path = Vec::new();
            let mut at = to;
            while at != from {
                let &(_, h) = by.iter().find(|(w, _)| *w == at)?;
                path.push(h);
                at = mesh.origin(h);
            }
            path.reverse();
            return Some(path);
        }
        for h in mesh.fan(v) {
            let w = mesh.target(h);
            let is_open = w != from && !branch.contains(&w) && seen.iter().any(|s| s.0 == w);
            if is_open && !by.iter().any(|(known, _)| *known == w) {
                by.push((w, h));
                queue.push_back(w);
            }
        }
    }
    None
}

/// The index of an interior vertex in halves, from the changes of sign of the form around it: 0 at regular ones, −1 at simple
/// zeros of the quadratic differential, −2 at double ones, 1 at poles. Edges along which u is constant, as between branch points
/// that are neighbours, count as if it rose a little along the one of their halfedges that stands for them.
pub(super) fn index(mesh: &TriMesh, foliation: &Foliation, form: &OneForm, v: u32) -> i32 {
    let signs = &foliation.signs;
    let rise = |h: usize| match form.along[h] {
        0.0 if mesh.is_edge_owner(h) => f64::MIN_POSITIVE,
        0.0 => -signs.across(h) * f64::MIN_POSITIVE,
        along => along,
    };
    let mut sign = 1.0;
    let mut values = Vec::with_capacity(8);
    for h in mesh.fan(v) {
        values.push(sign * rise(h));
        sign *= signs.across(prev(h));
    }
    // The first edge once more, on the sheet that the walk ends on.
    values.push(sign * values[0]);
    2 - values.windows(2).filter(|pair| (pair[0] > 0.0) != (pair[1] > 0.0)).count() as i32
}

/// Counts zeros and poles.
pub(super) fn indices(mesh: &TriMesh, foliation: &Foliation, form: &OneForm) -> Indices {
    let mut found = Indices::default();
    for v in 0..mesh.n_vertices() as u32 {
        let index = index(mesh, foliation, form, v);
        found.zeros += (-index).max(0) as usize;
        found.poles += index.max(0) as usize;
    }
    found
}
