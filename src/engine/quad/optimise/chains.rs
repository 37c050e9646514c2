//! Which curve of the surface each chain of quad edges on features or on the boundary follows.

use glam::DVec3;

use crate::engine::quad::Anchor;
use crate::engine::quad::QuadDraft;
use crate::engine::quad::optimise::curves::Curve;
use crate::engine::quad::optimise::incidence::counted_edges;

/// Points of a chain by which its curve is chosen.
const VOTES: usize = 12;
/// Least spacing of neighbours on a chain, as a share of the mean gap; closer ones are spread out anew.
const MIN_SPACING: f64 = 0.02;

/// How far a vertex may slide in one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Limit {
    /// Up to this arc parameter, where the chain ends at a corner.
    Arc(f64),
    /// Up to this vertex of the same chain.
    Vertex(u32),
    /// Nothing known: a little only.
    Loose,
}

/// Where a vertex sits on a curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slider {
    pub(crate) vertex: u32,
    pub(crate) curve: u32,
    pub(crate) arc: f64,
    /// Towards smaller and towards larger arc parameters.
    pub(crate) limits: [Limit; 2],
    /// Mean gap of its chain, 0 if that is not known.
    pub(crate) gap: f64,
}

struct Chain {
    /// All vertices in order; of a closed chain each one once.
    vertices: Vec<u32>,
    closed: bool,
}

/// Puts every vertex that is anchored to a curve onto one, in the order in which its chain runs along it.
pub(crate) fn place_chains(draft: &QuadDraft, curves: &[Curve]) -> Vec<Slider> {
    let mut sliders = Vec::new();
    if curves.is_empty() {
        return sliders;
    }
    let positions = &draft.mesh.positions;
    for chain in chains_of(draft) {
        let inner = inner_of(&chain);
        if inner.is_empty() {
            continue;
        }
        let votes: Vec<DVec3> =
            inner.iter().step_by(inner.len().div_ceil(VOTES)).map(|&v| positions[v as usize]).collect();
        let corner = |v: u32| match draft.anchors[v as usize] {
            Anchor::Corner(c) => Some(c),
            _ => None,
        };
        let (first, last) = (chain.vertices[0], chain.vertices[chain.vertices.len() - 1]);
        let ends = if chain.closed { None } else { corner(first).zip(corner(last)) };
        let between =
            |c: &Curve| ends.is_some_and(|(a, b)| !c.is_closed() && (c.ends() == [a, b] || c.ends() == [b, a]));
        let known = nearest_curve(curves, &votes, between);
        let free = || nearest_curve(curves, &votes, |_| true);
        let Some(curve) = known.or_else(free) else { continue };
        place(&chain, inner, &curves[curve], curve as u32, ends.filter(|_| known.is_some()), positions, &mut sliders);
    }
    sliders
}

fn inner_of(chain: &Chain) -> &[u32] {
    if chain.closed { &chain.vertices } else { &chain.vertices[1..chain.vertices.len() - 1] }
}

fn nearest_curve(curves: &[Curve], votes: &[DVec3], may: impl Fn(&Curve) -> bool) -> Option<usize> {
    let mut best = (f64::INFINITY, None);
    for (c, curve) in curves.iter().enumerate().filter(|(_, c)| may(c)) {
        let mut sum = 0.0;
        for &p in votes {
            sum += curve.nearest(p).distance_squared;
            if sum >= best.0 {
                break;
            }
        }
        if sum < best.0 {
            best = (sum, Some(c));
        }
    }
    best.1
}

fn place(
    chain: &Chain,
    inner: &[u32],
    curve: &Curve,
    number: u32,
    ends: Option<(u32, u32)>,
    positions: &[DVec3],
    sliders: &mut Vec<Slider>,
) {
    let length = curve.length();
    let mut arcs: Vec<f64> = inner.iter().map(|&v| curve.nearest(positions[v as usize]).arc).collect();
    // The way from one to the next, the short way round a closed curve.
    let short = |d: f64| if curve.is_closed() { d - length * (d / length).round() } else { d };
    let mut forward = arcs.windows(2).map(|w| short(w[1] - w[0])).sum::<f64>() >= 0.0;
    if let Some((a, b)) = ends
        && a != b
    {
        forward = curve.ends() == [a, b];
    }
    let mut order: Vec<u32> = inner.to_vec();
    if !forward {
        order.reverse();
        arcs.reverse();
    }
    let n = order.len();
    let gap = match ends {
        Some(_) => length / (n + 1) as f64,
        None if chain.closed && curve.is_closed() => length / n as f64,
        None => 0.0,
    };
    if ends.is_some() {
        let all = || std::iter::once(0.0).chain(arcs.iter().copied()).chain(std::iter::once(length));
        if all().zip(all().skip(1)).any(|(a, b)| b - a < MIN_SPACING * gap) {
            arcs = (1..=n).map(|i| gap * i as f64).collect();
        }
    } else if chain.closed && curve.is_closed() && n >= 3 {
        let steps: Vec<f64> = (0..n).map(|i| (arcs[(i + 1) % n] - arcs[i]).rem_euclid(length)).collect();
        let once = (steps.iter().sum::<f64>() / length).round() == 1.0;
        if !once || steps.iter().any(|&s| s < MIN_SPACING * gap) {
            arcs = (0..n).map(|i| curve.wrap(arcs[0] + gap * i as f64)).collect();
        }
    }
    let limit = |i: Option<usize>, end: f64| match (i, ends) {
        (Some(i), _) if i < n => Limit::Vertex(order[i]),
        (_, Some(_)) => Limit::Arc(end),
        _ if chain.closed => Limit::Vertex(order[i.map_or(n - 1, |_| 0)]),
        _ => Limit::Loose,
    };
    for i in 0..n {
        let limits = [limit(i.checked_sub(1), 0.0), limit(Some(i + 1), length)];
        sliders.push(Slider { vertex: order[i], curve: number, arc: arcs[i], limits, gap });
    }
}

/// Chains of quad edges on features and on the boundary, cut wherever a vertex is a corner or a junction.
fn chains_of(draft: &QuadDraft) -> Vec<Chain> {
    let mut links: Vec<[u32; 2]> = draft.feature_edges.clone();
    links.extend(counted_edges(&draft.mesh.quads).into_iter().filter(|e| e.1 == 1).map(|e| e.0));
    links.extend(links.clone().into_iter().map(|[a, b]| [b, a]));
    links.sort_unstable();
    links.dedup();
    let of = |v: u32| links.partition_point(|l| l[0] < v)..links.partition_point(|l| l[0] <= v);
    let slides = |v: u32| !matches!(draft.anchors[v as usize], Anchor::Corner(_)) && of(v).len() == 2;
    let mut used = vec![false; links.len()];
    let mut chains = Vec::new();
    for only_ends in [true, false] {
        for first in 0..links.len() {
            let start = links[first][0];
            if used[first] || only_ends && slides(start) {
                continue;
            }
            let mut vertices = vec![start];
            let mut link = first;
            loop {
                let [a, b] = links[link];
                used[link] = true;
                used[links.partition_point(|l| *l < [b, a])] = true;
                vertices.push(b);
                match of(b).find(|&l| !used[l]) {
                    Some(next) if slides(b) => link = next,
                    _ => break,
                }
            }
            let closed = !only_ends && vertices[vertices.len() - 1] == start;
            if closed {
                vertices.pop();
            }
            chains.push(Chain { vertices, closed });
        }
    }
    chains
}
