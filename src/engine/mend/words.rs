//! The pieces of a disc between the features in it, and their boundaries as words of vertices.

use crate::engine::mend::patch::Patch;
use crate::engine::quad::improve::DEAD;
use std::collections::BTreeMap;

/// A part of a patch that no feature crosses.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    /// Its quads, as indices into the quads of the patch.
    pub(super) quads: Vec<usize>,
    /// Its boundary counter-clockwise, from vertex to vertex; features that end inside, and the cut that makes a disc of
    /// an annulus, are passed on both sides. Empty if the piece is neither a disc nor an annulus.
    pub(super) word: Vec<u32>,
}

/// A side of a quad.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    quad: usize,
    /// The corner where it begins.
    corner: usize,
}

impl Side {
    fn all_of(quad: usize) -> impl Iterator<Item = Self> {
        (0..4).map(move |corner| Self { quad, corner })
    }
}

/// Sides by the vertices from and to which they run.
struct Sides<'a> {
    patch: &'a Patch,
    of: BTreeMap<(u32, u32), Side>,
}

impl<'a> Sides<'a> {
    fn new(patch: &'a Patch) -> Self {
        let living = patch.quads.iter().enumerate().filter(|(_, quad)| **quad != DEAD);
        let ends = |quad: &[u32; 4], k: usize| (quad[k], quad[(k + 1) % 4]);
        let of =
            living.flat_map(|(q, quad)| Side::all_of(q).map(move |side| (ends(quad, side.corner), side))).collect();
        Self { patch, of }
    }

    fn ends(&self, side: Side) -> (u32, u32) {
        let quad = &self.patch.quads[side.quad];
        (quad[side.corner], quad[(side.corner + 1) % 4])
    }

    /// The same side of the quad across, unless a feature lies between.
    fn twin(&self, side: Side) -> Option<Side> {
        let (a, b) = self.ends(side);
        if self.patch.is_feature(a, b) { None } else { self.of.get(&(b, a)).copied() }
    }

    /// The side after one on the boundary of its piece.
    fn next(&self, side: Side) -> Side {
        let after = |side: Side| Side { corner: (side.corner + 1) % 4, ..side };
        let mut side = after(side);
        // At most once round a vertex.
        for _ in 0..self.patch.quads.len() {
            let Some(twin) = self.twin(side) else { break };
            side = after(twin);
        }
        side
    }
}

/// The pieces of a patch in order of their first quads.
pub(super) fn pieces(patch: &Patch) -> Vec<Piece> {
    let sides = Sides::new(patch);
    let mut seen = vec![false; patch.quads.len()];
    let mut pieces = Vec::new();
    for seed in (0..patch.quads.len()).filter(|&q| patch.quads[q] != DEAD) {
        if std::mem::replace(&mut seen[seed], true) {
            continue;
        }
        let (mut quads, mut next) = (vec![seed], 0);
        while let Some(&q) = quads.get(next) {
            next += 1;
            for twin in Side::all_of(q).filter_map(|side| sides.twin(side)) {
                if !std::mem::replace(&mut seen[twin.quad], true) {
                    quads.push(twin.quad);
                }
            }
        }
        quads.sort_unstable();
        let word = word(&sides, &quads).unwrap_or_default();
        pieces.push(Piece { quads, word });
    }
    pieces
}

fn word(sides: &Sides<'_>, quads: &[usize]) -> Option<Vec<u32>> {
    let all = || quads.iter().flat_map(|&q| Side::all_of(q));
    let boundary: Vec<Side> = all().filter(|&s| sides.twin(s).is_none()).collect();
    let mut loops: Vec<Vec<u32>> = Vec::new();
    let mut passed: BTreeMap<Side, ()> = BTreeMap::new();
    for &start in &boundary {
        let (mut at, mut round) = (start, Vec::new());
        while passed.insert(at, ()).is_none() {
            round.push(sides.ends(at).0);
            at = sides.next(at);
        }
        if !round.is_empty() {
            loops.push(round);
        }
    }
    // V − E + F of the piece when it is cut open: a vertex for every side of the boundary, and those inside.
    let on_boundary = |v: u32| loops.iter().any(|l| l.contains(&v));
    let mut inner: Vec<u32> = all().map(|s| sides.ends(s).0).filter(|&v| !on_boundary(v)).collect();
    inner.sort_unstable();
    inner.dedup();
    let (faces, b) = (quads.len() as i64, boundary.len() as i64);
    let euler = inner.len() as i64 + b - (4 * faces + b) / 2 + faces;
    match (&loops[..], euler) {
        ([round], 1) => Some(round.clone()),
        ([first, second], 0) => joined(sides, quads, first, second),
        _ => None,
    }
}

/// The word of an annulus cut along a shortest chain of edges inside.
fn joined(sides: &Sides<'_>, quads: &[usize], first: &[u32], second: &[u32]) -> Option<Vec<u32>> {
    let mut neighbours: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for side in quads.iter().flat_map(|&q| Side::all_of(q)) {
        if sides.twin(side).is_some() {
            let (a, b) = sides.ends(side);
            neighbours.entry(a).or_default().push(b);
        }
    }
    let mut from: BTreeMap<u32, u32> = first.iter().map(|&v| (v, v)).collect();
    let (mut queue, mut next) = (first.to_vec(), 0);
    let end = loop {
        let &v = queue.get(next)?;
        next += 1;
        if second.contains(&v) {
            break v;
        }
        for &w in neighbours.get(&v).into_iter().flatten() {
            from.entry(w).or_insert_with(|| {
                queue.push(w);
                v
            });
        }
    };
    let mut chain = vec![end];
    while let Some(&before) = from.get(&chain[chain.len() - 1])
        && before != chain[chain.len() - 1]
    {
        chain.push(before);
    }
    // The chain runs from the second loop to the first now.
    let start = chain[chain.len() - 1];
    if start == end {
        return None;
    }
    let turned = |round: &[u32], v: u32| {
        let i = round.iter().position(|&w| w == v).unwrap_or(0);
        [&round[i..], &round[..i]].concat()
    };
    let inside = &chain[1..chain.len() - 1];
    let mut word = turned(first, start);
    word.push(start);
    word.extend(inside.iter().rev());
    word.extend(turned(second, end));
    word.push(end);
    word.extend(inside);
    Some(word)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::mend::patch::Freedom;
    use crate::engine::quad::Anchor;
    use glam::DVec3;

    /// The quads of an n by m grid that are chosen, with features; vertex (i, j) is i (m + 1) + j.
    fn grid(n: u32, m: u32, chosen: impl Fn(u32, u32) -> bool, features: &[[u32; 2]]) -> Patch {
        let at = |i: u32, j: u32| i * (m + 1) + j;
        let cells = (0..n * m).map(|c| (c / m, c % m)).filter(|&(i, j)| chosen(i, j));
        let quads = cells.map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]).collect();
        let k = ((n + 1) * (m + 1)) as usize;
        Patch {
            origin: (0..k as u32).collect(),
            positions: vec![DVec3::ZERO; k],
            anchors: vec![Anchor::Surface; k],
            freedom: vec![Freedom::Fixed; k],
            quads,
            around: Vec::new(),
            around_stances: Vec::new(),
            features: features.to_vec(),
            size: 1.0,
            points: Vec::new(),
            reach: 1.0,
            known: Vec::new(),
        }
    }

    /// Every side of the boundary stands in the word once, and those of cuts in both directions.
    fn check(patch: &Patch, piece: &Piece, sides: usize) {
        assert_eq!(piece.word.len(), sides);
        let pairs: Vec<(u32, u32)> = (0..sides).map(|i| (piece.word[i], piece.word[(i + 1) % sides])).collect();
        let own = |a: u32, b: u32| {
            let side = |q: &[u32; 4]| (0..4).any(|k| (q[k], q[(k + 1) % 4]) == (a, b));
            piece.quads.iter().any(|&q| side(&patch.quads[q]))
        };
        assert!(pairs.iter().all(|&(a, b)| own(a, b)), "{pairs:?}");
        let twice = pairs.iter().filter(|&&(a, b)| pairs.contains(&(b, a))).count();
        let open = pairs.iter().filter(|&&(a, b)| !own(b, a)).count();
        assert!(twice + open >= sides && twice % 2 == 0, "{twice} {open}");
    }

    #[test]
    fn a_disc_is_one_piece_and_a_feature_through_it_makes_two() {
        let whole = grid(2, 3, |_, _| true, &[]);
        let [piece] = &pieces(&whole)[..] else { panic!() };
        check(&whole, piece, 10);
        // Vertices 1, 5, 9 run across.
        let cut = grid(2, 3, |_, _| true, &[[1, 5], [5, 9]]);
        let [first, second] = &pieces(&cut)[..] else { panic!() };
        check(&cut, first, 6);
        check(&cut, second, 8);
        // A feature that ends inside is passed on both sides.
        let slit = grid(2, 3, |_, _| true, &[[1, 5]]);
        let [piece] = &pieces(&slit)[..] else { panic!() };
        check(&slit, piece, 12);
    }

    #[test]
    fn an_annulus_is_cut_and_more_holes_are_left_alone() {
        let ring = grid(5, 5, |i, j| (i, j) != (2, 2), &[]);
        let [piece] = &pieces(&ring)[..] else { panic!() };
        check(&ring, piece, 20 + 4 + 2 * 2);
        let holes = grid(7, 5, |i, j| j != 2 || i % 2 == 0 || i == 5, &[]);
        let [piece] = &pieces(&holes)[..] else { panic!() };
        assert!(piece.word.is_empty());
    }
}
