//! Whether quads form an oriented 2-manifold, and which one.

use crate::engine::certify::{Check, Violation};
use crate::engine::quad::QuadMesh;

/// No twin: the halfedge lies on the boundary.
const NONE: u32 = u32::MAX;

/// Numbers of one connected component.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ComponentTopology {
    /// Boundary loops.
    pub boundaries: usize,
    /// Genus.
    pub genus: usize,
}

impl ComponentTopology {
    /// From V − E + F and the number of boundary loops.
    pub(super) fn new(euler: i64, boundaries: usize) -> Self {
        Self { boundaries, genus: ((2 - boundaries as i64 - euler) / 2).max(0) as usize }
    }
}

/// The connectivity of an oriented 2-manifold of quads. Halfedge `4 q + k` runs from corner `k` of quad `q` to the
/// next corner.
#[derive(Clone, Debug)]
pub struct QuadTopology {
    /// Edges as (lower, higher) vertex, sorted.
    pub edges: Vec<[u32; 2]>,
    /// Per edge, whether it has one quad only.
    pub is_boundary_edge: Vec<bool>,
    /// Per vertex, the number of its edges.
    pub valence: Vec<u32>,
    /// Per vertex, whether it lies on the boundary.
    pub is_boundary_vertex: Vec<bool>,
    /// Per quad, its component, numbered in order of least vertices: files may hold the quads in another order.
    pub component: Vec<u32>,
    /// Per component, its numbers.
    pub components: Vec<ComponentTopology>,
    /// The boundary loops as vertices in order.
    pub loops: Vec<Vec<u32>>,
}

impl QuadTopology {
    /// Boundary loops of all components.
    pub fn boundaries(&self) -> usize {
        self.loops.len()
    }

    /// Genus, summed over the components.
    pub fn genus(&self) -> usize {
        self.components.iter().map(|c| c.genus).sum()
    }
}

/// Proves that the quads form an oriented 2-manifold without unused vertices. O(n log n).
///
/// # Errors
/// All violations that can be told; the later ones only where the earlier leave them a meaning.
pub fn measure_topology(quads: &QuadMesh) -> Result<QuadTopology, Vec<Violation>> {
    faces(quads)?;
    let twin = twins(quads)?;
    let fans = fans(quads, &twin)?;
    Ok(assemble(quads, &twin, &fans))
}

/// Every quad has four different vertices in range and no equal; every vertex is used and finite.
fn faces(quads: &QuadMesh) -> Result<(), Vec<Violation>> {
    let n = quads.positions.len();
    let numbered = || (0u32..).zip(&quads.quads);
    let is_bad = |q: &[u32; 4]| q.iter().any(|&v| v as usize >= n) || (0..4).any(|i| (i + 1..4).any(|j| q[i] == q[j]));
    let mut used = vec![false; n];
    for &v in quads.quads.iter().flatten() {
        if let Some(mark) = used.get_mut(v as usize) {
            *mark = true;
        }
    }
    let mut sets: Vec<([u32; 4], u32)> = numbered()
        .map(|(i, q)| {
            let mut set = *q;
            set.sort_unstable();
            (set, i)
        })
        .collect();
    sets.sort_unstable();
    let found = [
        Violation::at(Check::FourVertices, numbered().filter(|(_, q)| is_bad(q)).map(|(i, _)| i)),
        Violation::at(Check::DuplicateQuad, sets.windows(2).filter(|w| w[0].0 == w[1].0).map(|w| w[1].1)),
        Violation::at(Check::UnusedVertex, (0u32..).zip(&used).filter(|&(_, &u)| !u).map(|(v, _)| v)),
        Violation::at(Check::Finite, (0u32..).zip(&quads.positions).filter(|(_, p)| !p.is_finite()).map(|(v, _)| v)),
    ];
    fail_if_any(found)
}

/// Every edge has one quad, or two that run along it in opposite directions.
fn twins(quads: &QuadMesh) -> Result<Vec<u32>, Vec<Violation>> {
    let mut sides: Vec<(u32, u32, u32)> = Vec::with_capacity(4 * quads.quads.len());
    for h in 0..4 * quads.quads.len() as u32 {
        let (a, b) = ends(quads, h);
        sides.push((a.min(b), a.max(b), h));
    }
    sides.sort_unstable();
    let mut twin = vec![NONE; sides.len()];
    let (mut many_sided, mut twisted) = (Vec::new(), Vec::new());
    for edge in sides.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        match *edge {
            [_] => {}
            [(_, _, h), (_, _, t)] => {
                if ends(quads, h).0 == ends(quads, t).0 {
                    twisted.push(h / 4);
                }
                twin[h as usize] = t;
                twin[t as usize] = h;
            }
            _ => many_sided.push(edge[0].2 / 4),
        }
    }
    fail_if_any([Violation::at(Check::EdgeFaces, many_sided), Violation::at(Check::EdgeOrientation, twisted)])?;
    Ok(twin)
}

/// Every vertex has one fan. Returns per vertex the first halfedge of its fan, on the boundary a boundary halfedge.
fn fans(quads: &QuadMesh, twin: &[u32]) -> Result<Vec<u32>, Vec<Violation>> {
    let mut first = vec![NONE; quads.positions.len()];
    let mut degree = vec![0u32; quads.positions.len()];
    for (h, &t) in (0u32..).zip(twin) {
        let v = ends(quads, h).0 as usize;
        degree[v] += 1;
        if first[v] == NONE || t == NONE {
            first[v] = h;
        }
    }
    let is_split = |v: usize| {
        let (mut h, mut met) = (first[v], 0);
        while met <= degree[v] {
            met += 1;
            h = twin[before(h) as usize];
            if h == NONE || h == first[v] {
                break;
            }
        }
        met != degree[v]
    };
    let split = (0..first.len()).filter(|&v| is_split(v)).map(|v| v as u32);
    fail_if_any([Violation::at(Check::VertexFan, split)])?;
    Ok(first)
}

fn assemble(quads: &QuadMesh, twin: &[u32], first: &[u32]) -> QuadTopology {
    let (component, n_components) = flood(quads, twin);
    let mut euler = vec![0i64; n_components];
    let mut edges: Vec<([u32; 2], bool)> = Vec::new();
    let mut valence = vec![0u32; first.len()];
    for (h, &t) in (0u32..).zip(twin) {
        if t == NONE || h < t {
            let (a, b) = ends(quads, h);
            edges.push(([a.min(b), a.max(b)], t == NONE));
            valence[a as usize] += 1;
            valence[b as usize] += 1;
            euler[component[h as usize / 4] as usize] -= 1;
        }
    }
    edges.sort_unstable();
    for &c in &component {
        euler[c as usize] += 1;
    }
    for &h in first {
        euler[component[h as usize / 4] as usize] += 1;
    }
    let is_boundary_vertex: Vec<bool> = first.iter().map(|&h| twin[h as usize] == NONE).collect();
    let mut boundaries = vec![0usize; n_components];
    let mut loops = Vec::new();
    let mut seen = vec![false; first.len()];
    for v in 0..first.len() {
        let (mut at, mut round) = (v, Vec::new());
        while is_boundary_vertex[at] && !seen[at] {
            seen[at] = true;
            round.push(at as u32);
            at = ends(quads, first[at]).1 as usize;
        }
        if !round.is_empty() {
            boundaries[component[first[v] as usize / 4] as usize] += 1;
            loops.push(round);
        }
    }
    let components = euler.iter().zip(&boundaries).map(|(&e, &b)| ComponentTopology::new(e, b)).collect();
    let (edges, is_boundary_edge) = edges.into_iter().unzip();
    QuadTopology { edges, is_boundary_edge, valence, is_boundary_vertex, component, components, loops }
}

fn flood(quads: &QuadMesh, twin: &[u32]) -> (Vec<u32>, usize) {
    let mut component = vec![NONE; quads.quads.len()];
    let mut seeds: Vec<usize> = (0..component.len()).collect();
    seeds.sort_by_key(|&q| quads.quads[q].iter().min());
    let mut n = 0;
    let mut stack = Vec::new();
    for seed in seeds {
        if component[seed] != NONE {
            continue;
        }
        component[seed] = n;
        stack.push(seed);
        while let Some(q) = stack.pop() {
            for &t in &twin[4 * q..4 * q + 4] {
                if t != NONE && component[t as usize / 4] == NONE {
                    component[t as usize / 4] = n;
                    stack.push(t as usize / 4);
                }
            }
        }
        n += 1;
    }
    (component, n as usize)
}

fn ends(quads: &QuadMesh, h: u32) -> (u32, u32) {
    let q = quads.quads[h as usize / 4];
    (q[h as usize % 4], q[(h as usize + 1) % 4])
}

fn before(h: u32) -> u32 {
    if h.is_multiple_of(4) { h + 3 } else { h - 1 }
}

fn fail_if_any<const N: usize>(found: [Option<Violation>; N]) -> Result<(), Vec<Violation>> {
    let violations: Vec<Violation> = found.into_iter().flatten().collect();
    if violations.is_empty() { Ok(()) } else { Err(violations) }
}
