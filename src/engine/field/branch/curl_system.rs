//! The linear system of the curl energy.
//!
//! Without bound grid lines ψ is a complex number per interior edge, seen on the other side through `i^m`, and zero on
//! the boundary. A coordinate that is constant along an edge has no say in the residual there: its part of ψ takes any
//! value, on each side of the edge its own. At such edges ψ is made of real unknowns, and the system is a real one.

use faer::c64;
use rayon::prelude::*;

use crate::engine::field::branch::sides::{PAIRS, Sides, slot};
use crate::engine::field::cross_field::FieldError;
use crate::engine::mesh::NONE;
use crate::engine::mesh::TriMesh;
use crate::engine::numerics::{Cholesky, Pattern, Scalar};

/// Shift of the diagonal relative to its mean: without boundary and branch points constants have no energy.
const PIN: f64 = 1e-10;

/// Where the unknowns stand.
#[derive(Clone, Debug)]
pub(super) enum System {
    /// One complex unknown per interior edge.
    Free(Pattern),
    /// Real unknowns.
    Bound(BoundSystem),
}

/// A factorisation of one of the two.
#[derive(Clone, Debug)]
pub(super) enum Factor {
    Free(Cholesky<c64>),
    Bound(Cholesky<f64>),
}

/// The real unknowns of a surface with bound grid lines.
#[derive(Clone, Debug)]
pub(super) struct BoundSystem {
    is_bound: Vec<bool>,
    /// Per halfedge its two real unknowns. Free edges have the real and the imaginary part in the chart of the owner,
    /// the same on both sides; bound ones the part of the constant coordinate on this side, and that of the other
    /// coordinate. [`NONE`]: zero.
    unknowns: Vec<[u32; 2]>,
    n: usize,
    pattern: Pattern,
}

/// Pairs of the six unknowns of a face, each once.
const ENTRIES: usize = 21;

impl System {
    pub(super) fn new(mesh: &TriMesh, sides: &Sides, is_bound: &[bool]) -> Self {
        if is_bound.contains(&true) {
            Self::Bound(BoundSystem::new(mesh, is_bound))
        } else {
            free(&sides.edge, sides.owner.len())
        }
    }

    /// Whether a grid line is bound to the edge of halfedge `h`.
    pub(super) fn is_bound(&self, h: usize) -> bool {
        matches!(self, Self::Bound(system) if system.is_bound[h])
    }

    /// ψ per halfedge, in the chart of its face. `along`: the field along each halfedge; `turns`: `i^m` across the owner
    /// of each interior edge; `last` lends its pattern.
    pub(super) fn solve(
        &self,
        mesh: &TriMesh,
        sides: &Sides,
        turns: &[c64],
        along: &[c64],
        last: Option<&Factor>,
    ) -> Result<(Vec<c64>, Factor), FieldError> {
        match self {
            Self::Free(pattern) => {
                let n = sides.owner.len();
                let of_faces: Vec<[c64; 6]> =
                    (0..mesh.n_faces()).into_par_iter().map(|f| on_sheets(mesh, sides, turns, f)).collect();
                let matrix = pattern.matrix(of_faces.into_iter().flatten().chain(pinned(sides, n)));
                let factor = match last {
                    Some(Factor::Free(last)) => last.refactor(&matrix)?,
                    _ => Cholesky::new(&matrix)?,
                };
                let jump =
                    |(&h, &turn): (&usize, &c64)| along[h] + mesh.twin(h).map_or(0.0.into(), |t| turn * along[t]);
                let mut x: Vec<c64> = sides.owner.iter().zip(turns).map(jump).collect();
                factor.solve(&mut x);
                let at = |h: usize| match sides.edge[h] {
                    NONE => 0.0.into(),
                    e => sides.seen_from(mesh, turns, h) * x[e as usize],
                };
                Ok(((0..mesh.n_halfedges()).map(at).collect(), Factor::Free(factor)))
            }
            Self::Bound(system) => {
                let basis: Vec<[c64; 2]> = (0..mesh.n_halfedges())
                    .into_par_iter()
                    .map(|h| system.basis(mesh, sides, turns, along, h))
                    .collect();
                let of_faces: Vec<[f64; ENTRIES]> = (0..mesh.n_faces())
                    .into_par_iter()
                    .map(|f| system.of_face(&sides.stiffness[f], &basis, f))
                    .collect();
                let matrix = system.pattern.matrix(of_faces.into_iter().flatten().chain(pinned(sides, system.n)));
                let factor = match last {
                    Some(Factor::Bound(last)) => last.refactor(&matrix)?,
                    _ => Cholesky::new(&matrix)?,
                };
                let parts = || system.unknowns.iter().zip(&basis);
                let mut x = vec![0.0; system.n];
                for ((unknowns, basis), along) in parts().zip(along) {
                    for (&u, b) in unknowns.iter().zip(basis).filter(|(u, _)| **u != NONE) {
                        x[u as usize] += (b.conj() * *along).re;
                    }
                }
                factor.solve(&mut x);
                let value = |u: u32| if u == NONE { 0.0 } else { x[u as usize] };
                let at = |(unknowns, basis): (&[u32; 2], &[c64; 2])| {
                    basis[0] * value(unknowns[0]) + basis[1] * value(unknowns[1])
                };
                Ok((parts().map(at).collect(), Factor::Bound(factor)))
            }
        }
    }
}

/// What is added to the diagonal for each of `n` unknowns.
fn pinned<T: Scalar>(sides: &Sides, n: usize) -> impl Iterator<Item = T> {
    let mean = sides.stiffness.iter().map(|s| s[0] + s[1] + s[2]).sum::<f64>() / n.max(1) as f64;
    std::iter::repeat_n(T::from_real(PIN * mean), n)
}

/// One complex unknown per interior edge: the entries of the faces, six each, and then the diagonal. Sides at the
/// boundary, and pairs of sides that are one edge, have entries of value 0.
fn free(edge: &[u32], n: usize) -> System {
    if n == 0 {
        return System::Free(Pattern::new(0, std::iter::empty()));
    }
    let of_face = |f: &[u32]| {
        PAIRS.map(|(i, j)| match (f[i], f[j]) {
            (NONE, NONE) => (0, 0),
            (NONE, e) | (e, NONE) => (e, e),
            (a, b) => (a.max(b), a.min(b)),
        })
    };
    let diagonal = (0..n as u32).map(|e| (e, e));
    let places: Vec<(u32, u32)> = edge.chunks_exact(3).flat_map(of_face).chain(diagonal).collect();
    System::Free(Pattern::new(n, places.into_iter()))
}

/// The complex entries of a face in the order of the pattern: of each pair of sides the one below the diagonal.
fn on_sheets(mesh: &TriMesh, sides: &Sides, turns: &[c64], f: usize) -> [c64; 6] {
    let side = [0, 1, 2].map(|k| match sides.edge[3 * f + k] {
        NONE => 0.0.into(),
        _ => sides.seen_from(mesh, turns, 3 * f + k),
    });
    let mut entries = sides.stiffness[f].map(c64::from);
    for (entry, (i, j)) in entries.iter_mut().zip(PAIRS) {
        let (a, b) = (sides.edge[3 * f + i], sides.edge[3 * f + j]);
        *entry *= match a == b && i != j {
            true => 0.0.into(),
            false if a >= b => side[i].conj() * side[j],
            false => side[j].conj() * side[i],
        };
    }
    entries
}

impl BoundSystem {
    fn new(mesh: &TriMesh, is_bound: &[bool]) -> Self {
        let mut unknowns = vec![[NONE; 2]; mesh.n_halfedges()];
        let mut n = 0;
        let mut next = || {
            n += 1;
            n - 1
        };
        for h in (0..mesh.n_halfedges()).filter(|&h| mesh.is_edge_owner(h)) {
            match (mesh.twin(h), is_bound[h]) {
                (Some(t), false) => {
                    unknowns[h] = [next(), next()];
                    unknowns[t] = unknowns[h];
                }
                (Some(t), true) => {
                    unknowns[h] = [next(), next()];
                    unknowns[t] = [next(), unknowns[h][1]];
                }
                (None, true) => unknowns[h] = [next(), NONE],
                (None, false) => {}
            }
        }
        let places = (0..mesh.n_faces()).flat_map(|f| {
            let of_face = &unknowns[3 * f..3 * f + 3];
            pairs().map(|(p, q)| match (of_face[p / 2][p % 2], of_face[q / 2][q % 2]) {
                (NONE, NONE) => (0, 0),
                (NONE, u) | (u, NONE) => (u, u),
                (u, w) => (u.max(w), u.min(w)),
            })
        });
        let places: Vec<(u32, u32)> = places.chain((0..n).map(|u| (u, u))).collect();
        let pattern = Pattern::new(n as usize, places.into_iter());
        Self { is_bound: is_bound.to_vec(), unknowns, n: n as usize, pattern }
    }

    /// What the two unknowns of a halfedge stand for in the chart of its face. The constant coordinate of a bound edge is
    /// the one that the field changes less along it, as its owner sees it.
    fn basis(&self, mesh: &TriMesh, sides: &Sides, turns: &[c64], along: &[c64], h: usize) -> [c64; 2] {
        let (one, i) = (c64::new(1.0, 0.0), c64::new(0.0, 1.0));
        let pair = match mesh.twin(h).filter(|_| !mesh.is_edge_owner(h)).unwrap_or(h) {
            owner if self.is_bound[owner] && along[owner].re.abs() >= along[owner].im.abs() => [i, one],
            _ => [one, i],
        };
        match sides.edge[h] {
            NONE => pair,
            _ => pair.map(|direction| sides.seen_from(mesh, turns, h) * direction),
        }
    }

    /// The entries of a face in the order of the pattern.
    fn of_face(&self, stiffness: &[f64; 6], basis: &[[c64; 2]], f: usize) -> [f64; ENTRIES] {
        let mut entries = [0.0; ENTRIES];
        for (entry, (p, q)) in entries.iter_mut().zip(pairs()) {
            let of = |p: usize| (self.unknowns[3 * f + p / 2][p % 2], basis[3 * f + p / 2][p % 2]);
            let ((u, x), (w, y)) = (of(p), of(q));
            if u != NONE && w != NONE {
                // Two sides that are one edge share unknowns: the pair counts in both orders.
                let twice = if u == w && p != q { 2.0 } else { 1.0 };
                *entry = twice * stiffness[slot(p / 2, q / 2)] * (x.conj() * y).re;
            }
        }
        entries
    }
}

/// The pairs of the six unknowns of a face.
fn pairs() -> impl Iterator<Item = (usize, usize)> {
    (0..6).flat_map(|p| (0..=p).map(move |q| (p, q)))
}
