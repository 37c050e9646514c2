//! Which two sides meet at an edge, also where more than two faces do.

use std::f64::consts::PI;

use glam::DVec3;

use crate::engine::mesh::NONE;
use crate::engine::mesh::condition::edges::Side;
use crate::engine::mesh::condition::edges::apex;
use crate::engine::mesh::condition::edges::origin;
use crate::engine::mesh::condition::edges::runs;
use crate::engine::mesh::condition::edges::sorted_sides;
use crate::engine::mesh::condition::patches::Senses;
use crate::engine::mesh::condition::patches::senses;

/// Sides of triangles joined two by two.
pub(super) struct Pairing {
    /// Per halfedge the one it is joined to, or [`NONE`].
    pub(super) partner: Vec<u32>,
    /// Edges with more than two faces, which were cut.
    pub(super) non_manifold_edges: usize,
}

/// A side at a non-manifold edge, in its place around the edge.
#[derive(Clone, Copy)]
struct Blade {
    h: u32,
    angle: f64,
    /// Runs along the edge from the lower to the higher vertex, seen from the outside of its patch: then the solid
    /// that it bounds ends here, going counter-clockwise around the edge; otherwise it begins.
    ends: bool,
    patch: u32,
}

/// Joins the sides. Edges with two faces: these two. With more: if solids begin and end by turns around the edge, the
/// two sides of each solid; otherwise the two sides of one piece that agree, then the pairs that go on straightest; the
/// rest stays open. No pair is made that would make a surface one-sided.
pub(super) fn pair_sides(corners: &[[u32; 3]], positions: &[DVec3]) -> Pairing {
    let sides = sorted_sides(corners);
    let mut partner = vec![NONE; 3 * corners.len()];
    let mut many_sided: Vec<&[Side]> = Vec::new();
    for run in runs(&sides) {
        match *run {
            [(_, h), (_, t)] => join_sides(&mut partner, h, t),
            [_] => {}
            _ => many_sided.push(run),
        }
    }
    let non_manifold_edges = many_sided.len();
    if non_manifold_edges > 0 {
        let senses = senses(corners, &partner);
        let inverted = inside_out(corners, positions, &sides, &senses);
        let mut parity = Parity::new(senses.n_patches);
        let mut open = Vec::new();
        for run in many_sided {
            let blades = blades_around(run, corners, positions, &senses, &inverted);
            match by_turns(&blades) {
                Some(order) => {
                    for pair in order.chunks_exact(2) {
                        parity.unite(pair[0].patch, pair[1].patch, false);
                        join_sides(&mut partner, pair[0].h, pair[1].h);
                    }
                }
                None => open.push(blades),
            }
        }
        for blades in open {
            join_straightest(&blades, &mut parity, &mut partner);
        }
    }
    Pairing { partner, non_manifold_edges }
}

fn join_sides(partner: &mut [u32], h: u32, t: u32) {
    partner[h as usize] = t;
    partner[t as usize] = h;
}

/// Per patch: whether it belongs to closed parts of the model that, as they are given, enclose a negative volume.
fn inside_out(corners: &[[u32; 3]], positions: &[DVec3], sides: &[Side], senses: &Senses) -> Vec<bool> {
    let mut part = Parity::new(senses.n_patches);
    for run in runs(sides) {
        for s in &run[1..] {
            part.unite(senses.patch[run[0].1 as usize / 3], senses.patch[s.1 as usize / 3], false);
        }
    }
    let mut volume = vec![0.0; senses.n_patches];
    let mut closed = vec![true; senses.n_patches];
    for (f, face) in corners.iter().enumerate() {
        let [a, b, c] = face.map(|v| positions[v as usize]);
        let sign = if senses.flip[f] { -1.0 } else { 1.0 };
        volume[part.find(senses.patch[f]).0 as usize] += sign * a.dot(b.cross(c));
    }
    for run in runs(sides).filter(|run| run.len() == 1) {
        closed[part.find(senses.patch[run[0].1 as usize / 3]).0 as usize] = false;
    }
    (0..senses.n_patches as u32)
        .map(|p| part.find(p).0 as usize)
        .map(|root| closed[root] && volume[root] < 0.0)
        .collect()
}

/// The sides of one edge by angle; sides without an angle (their triangle has no area) come first, at 0.
fn blades_around(
    run: &[Side],
    corners: &[[u32; 3]],
    positions: &[DVec3],
    senses: &Senses,
    inverted: &[bool],
) -> Vec<Blade> {
    let (a, b) = ((run[0].0 >> 32) as u32, run[0].0 as u32);
    let start = positions[a as usize];
    let axis = (positions[b as usize] - start).normalize_or_zero();
    let x = if axis == DVec3::ZERO { DVec3::X } else { axis.any_orthonormal_vector() };
    let y = axis.cross(x);
    let mut blades: Vec<Blade> = run
        .iter()
        .map(|&(_, h)| {
            let f = h as usize / 3;
            let r = positions[apex(corners, h) as usize] - start;
            let patch = senses.patch[f];
            let ends = (origin(corners, h) == a) ^ senses.flip[f] ^ inverted[patch as usize];
            Blade { h, angle: r.dot(y).atan2(r.dot(x)), ends, patch }
        })
        .collect();
    blades.sort_by(|p, q| p.angle.total_cmp(&q.angle).then(p.h.cmp(&q.h)));
    blades
}

/// The sides as begin, end, begin, end, … if they can be read so going around; sides at the same angle may be read in
/// any order.
fn by_turns(blades: &[Blade]) -> Option<Vec<Blade>> {
    if !blades.len().is_multiple_of(2) {
        return None;
    }
    for start in [true, false] {
        let mut order: Vec<Blade> = Vec::with_capacity(blades.len());
        let mut wants_end = start;
        for level in blades.chunk_by(|p, q| p.angle == q.angle) {
            let mut left = level.to_vec();
            while let Some(i) = left.iter().position(|blade| blade.ends == wants_end) {
                order.push(left.remove(i));
                wants_end = !wants_end;
            }
            if !left.is_empty() {
                break;
            }
        }
        if order.len() == blades.len() {
            // Starting with an end means that the last solid reaches around the angle π.
            if start {
                order.rotate_right(1);
            }
            return Some(order);
        }
    }
    None
}

fn join_straightest(blades: &[Blade], parity: &mut Parity, partner: &mut [u32]) {
    let mut candidates = Vec::new();
    for (i, p) in blades.iter().enumerate() {
        for (j, q) in blades.iter().enumerate().skip(i + 1) {
            let of_one_piece = p.patch == q.patch && p.ends != q.ends;
            let bend = ((q.angle - p.angle).abs() - PI).abs();
            candidates.push((!of_one_piece, bend, p.ends == q.ends, i, j));
        }
    }
    // Of faces on top of each other, those that agree without being turned over.
    candidates.sort_by(|p, q| p.0.cmp(&q.0).then(p.1.total_cmp(&q.1)).then((p.2, p.3, p.4).cmp(&(q.2, q.3, q.4))));
    let mut taken = vec![false; blades.len()];
    for (_, _, _, i, j) in candidates {
        let (p, q) = (blades[i], blades[j]);
        if !taken[i] && !taken[j] && parity.unite(p.patch, q.patch, p.ends == q.ends) {
            taken[i] = true;
            taken[j] = true;
            join_sides(partner, p.h, q.h);
        }
    }
}

/// Union-find of patches with the relation "must be turned over against each other".
struct Parity {
    parent: Vec<u32>,
    turned: Vec<bool>,
}

impl Parity {
    fn new(n: usize) -> Self {
        Self { parent: (0..n as u32).collect(), turned: vec![false; n] }
    }

    /// Root of `v`, and whether `v` is turned against it.
    fn find(&mut self, v: u32) -> (u32, bool) {
        let (mut root, mut turned) = (v, false);
        while self.parent[root as usize] != root {
            turned ^= self.turned[root as usize];
            root = self.parent[root as usize];
        }
        let (mut at, mut at_turned) = (v, turned);
        while self.parent[at as usize] != at {
            let (up, up_turned) = (self.parent[at as usize], at_turned ^ self.turned[at as usize]);
            self.parent[at as usize] = root;
            self.turned[at as usize] = at_turned;
            (at, at_turned) = (up, up_turned);
        }
        (root, turned)
    }

    /// Adds a relation; false if it contradicts those before.
    fn unite(&mut self, a: u32, b: u32, turned: bool) -> bool {
        let ((ra, ta), (rb, tb)) = (self.find(a), self.find(b));
        if ra == rb {
            return ta ^ tb == turned;
        }
        let (low, high) = (ra.min(rb), ra.max(rb));
        self.parent[high as usize] = low;
        self.turned[high as usize] = ta ^ tb ^ turned;
        true
    }
}
