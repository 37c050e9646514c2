//! One vertex per fan of faces.

use std::collections::BTreeMap;

use crate::engine::mesh::NONE;
use crate::engine::mesh::condition::draft::Draft;
use crate::engine::mesh::condition::edges::runs;
use crate::engine::mesh::condition::edges::sorted_sides;
use crate::engine::mesh::condition::tally::Tally;
use crate::engine::mesh::next;
use crate::engine::numerics::DisjointSets;

/// Gives every fan of faces that are connected around a vertex its own copy of the vertex. The sides must be joined
/// with opposite senses. Copies follow the order of the vertices and then of their first corners; vertices without
/// faces go.
pub(super) fn split_fans(draft: Draft, tally: &mut Tally) -> Draft {
    let n = draft.twin.len();
    let mut fan = DisjointSets::new(n);
    for (h, &t) in draft.twin.iter().enumerate() {
        if t != NONE && h < t as usize {
            fan.join(h as u32, next(t as usize) as u32);
            fan.join(next(h) as u32, t);
        }
    }
    // The name of a fan is its lowest corner.
    let fan = fan.names();
    let mut roots: Vec<(u32, u32)> =
        (0..n as u32).filter(|&c| fan[c as usize] == c).map(|c| (draft.start(c), c)).collect();
    roots.sort_unstable();
    let mut name = vec![NONE; n];
    for (i, &(_, c)) in roots.iter().enumerate() {
        name[c as usize] = i as u32;
    }
    let vertex = |c: usize| name[fan[c] as usize];
    let faces = (0..draft.faces.len()).map(|f| [0, 1, 2].map(|k| vertex(3 * f + k))).collect();
    let places = roots.chunk_by(|a, b| a.0 == b.0).count();
    tally.add("vertex_copies_made", roots.len() - places);
    Draft {
        positions: roots.iter().map(|r| draft.positions[r.0 as usize]).collect(),
        origin: roots.iter().map(|r| draft.origin[r.0 as usize]).collect(),
        moved: roots.iter().map(|r| draft.moved[r.0 as usize]).collect(),
        faces,
        twin: draft.twin,
        polygon: draft.polygon,
    }
}

/// Rounds in which double edges are split. Faces whose edges are double after so many halvings lie on each other.
const SPLIT_ROUNDS: usize = 8;

/// Splits edges at their midpoint until no two edges have the same ends: a fan may meet a cut edge twice. Where the
/// faces of a split edge lie on each other the new edges double too, hence the rounds; the faces that would go on doubling
/// for ever are dropped.
pub(super) fn split_double_edges(mut draft: Draft, tally: &mut Tally) -> Draft {
    for _ in 0..SPLIT_ROUNDS {
        let doubles = double_edges(&draft);
        if doubles.is_empty() {
            return draft;
        }
        tally.add("double_edges_split", doubles.len());
        // A split gives the side after the split one to a new face; no later split of the round moves it again.
        let mut renamed = BTreeMap::new();
        for h in doubles {
            let h = renamed.get(&h).copied().unwrap_or(h);
            renamed.extend(draft.split_edge(h));
        }
    }
    // Every turn has fewer faces than the last.
    loop {
        let doubles = double_edges(&draft);
        if doubles.is_empty() {
            return draft;
        }
        let mut keep = vec![true; draft.faces.len()];
        for h in doubles {
            for side in [h, draft.twin[h as usize]].into_iter().filter(|&side| side != NONE) {
                keep[side as usize / 3] = false;
            }
        }
        tally.add("double_faces_dropped", keep.iter().filter(|&&k| !k).count());
        draft.retain(&keep);
        draft = split_fans(draft, tally);
    }
}

/// A halfedge of every edge that has the same ends as an edge before it.
fn double_edges(draft: &Draft) -> Vec<u32> {
    let sides = sorted_sides(&draft.faces);
    let stands_for_edge = |&h: &u32| draft.twin[h as usize] == NONE || h < draft.twin[h as usize];
    runs(&sides).flat_map(|run| run.iter().map(|s| s.1).filter(stands_for_edge).skip(1)).collect()
}
