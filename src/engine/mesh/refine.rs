//! Smaller triangles on exactly the same piecewise linear surface.
//!
//! The cross field and the map need triangles that are small against the quads, and they need room at the features:
//! a triangle with two feature edges, or an edge across from feature to feature, would be over-determined.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::engine::mesh::remesh::EditMesh;
use crate::engine::mesh::{Surface, next, prev};
use crate::engine::run::{Cancelled, RunContext};

/// A refined surface.
#[derive(Clone, Debug)]
pub struct Refined {
    /// The same point set, feature curves and corners, with more triangles. Vertices of the original come first and
    /// keep their numbers.
    pub surface: Surface,
    /// Per face the original face that it is a part of.
    pub parent_face: Vec<u32>,
}

/// Bisects longest edges until no edge of the part of an original face `f` is longer than `max_edge(f)` (model units;
/// infinity: leave it) or `max_faces` is reached, largest excess first, so that angles stay above half of what they
/// were. Then, regardless of `max_faces`, makes room at the features: no face has more than one edge on a feature curve
/// or the boundary, and no other edge joins two vertices of them.
///
/// # Errors
/// [`Cancelled`] only.
pub fn refine(
    ctx: &RunContext,
    surface: &Surface,
    max_edge: impl Fn(u32) -> f64,
    max_faces: usize,
) -> Result<Refined, Cancelled> {
    let mut mesh = EditMesh::new(surface);
    let mut parent: Vec<u32> = (0..mesh.faces.len() as u32).collect();
    bisect(ctx, &mut mesh, &mut parent, max_edge, max_faces)?;
    make_room(ctx, &mut mesh, &mut parent)?;
    let edited = mesh.finish().expect("splitting edges and faces of a manifold leaves a manifold");
    Ok(Refined { surface: edited.surface, parent_face: parent })
}

pub(in crate::engine::mesh) fn bisect(
    ctx: &RunContext,
    mesh: &mut EditMesh,
    parent: &mut Vec<u32>,
    max_edge: impl Fn(u32) -> f64,
    max_faces: usize,
) -> Result<(), Cancelled> {
    // Positive floats have the order of their bits.
    let excess = |mesh: &EditMesh, parent: &[u32], f: usize| {
        let ratio = mesh.length_squared(longest(mesh, f)).sqrt() / max_edge(parent[f]);
        (ratio > 1.0).then(|| (ratio.to_bits(), Reverse(f)))
    };
    let living: Vec<usize> = (0..mesh.faces.len()).filter(|&f| mesh.is_alive(f)).collect();
    let dead = mesh.faces.len() - living.len();
    let mut heap: BinaryHeap<_> = living.into_iter().filter_map(|f| excess(mesh, parent, f)).collect();
    while let Some(entry) = heap.pop() {
        let (_, Reverse(f)) = entry;
        if mesh.faces.len() - dead >= max_faces {
            break;
        }
        if excess(mesh, parent, f) != Some(entry) {
            continue;
        }
        if heap.len() % 1024 == 0 {
            ctx.check()?;
        }
        // Walk over longer and longer edges to one that is the longest of both its faces `[rivara_1997]`.
        let mut h = longest(mesh, f);
        while let Some(t) = mesh.twin(h).filter(|&t| longest(mesh, t / 3) != t) {
            h = longest(mesh, t / 3);
        }
        let changed = [Some(h / 3), mesh.twin(h).map(|t| t / 3)];
        let fresh = split_in_half(mesh, parent, h);
        let f = Some(f).filter(|&f| !changed.contains(&Some(f)));
        heap.extend(changed.into_iter().chain(fresh).chain([f]).flatten().filter_map(|f| excess(mesh, parent, f)));
    }
    Ok(())
}

/// The longest halfedge of a face; ties are decided by the edge, so that both of its faces decide alike.
fn longest(mesh: &EditMesh, f: usize) -> usize {
    let key = |h: usize| {
        let (a, b) = (mesh.origin(h), mesh.target(h));
        // Squared lengths must not depend on the direction; they do not, as (−x)² = x².
        (mesh.length_squared(h).to_bits(), a.min(b), a.max(b))
    };
    (3 * f..3 * f + 3).max_by_key(|&h| key(h)).unwrap_or(3 * f)
}

fn split_in_half(mesh: &mut EditMesh, parent: &mut Vec<u32>, h: usize) -> [Option<usize>; 2] {
    let middle = 0.5 * (mesh.position(mesh.origin(h)) + mesh.position(mesh.target(h)));
    let arc = mesh.segment(h).map_or(0.0, |s| 0.5 * mesh.curves.segment(s).t.iter().sum::<f64>());
    let sides = [Some(h / 3), mesh.twin(h).map(|t| t / 3)];
    let (_, fresh) = mesh.split(h, middle, arc);
    for side in sides.into_iter().zip(fresh).filter_map(|(old, new)| old.filter(|_| new.is_some())) {
        parent.push(parent[side]);
    }
    fresh
}

/// Splits what over-determines a triangle. One pass is enough: every new edge ends at a vertex off all curves. Edges
/// of a face that is split move to later halfedges, so a pass in index order misses none.
pub(in crate::engine::mesh) fn make_room(
    ctx: &RunContext,
    mesh: &mut EditMesh,
    parent: &mut Vec<u32>,
) -> Result<(), Cancelled> {
    let mut h = 0;
    while h < 3 * mesh.faces.len() {
        if h % 4096 == 0 {
            ctx.check()?;
        }
        let on_curve = |v: u32| mesh.on_curve[v as usize];
        if mesh.is_alive(h / 3) && mesh.segment(h).is_none() && on_curve(mesh.origin(h)) && on_curve(mesh.target(h)) {
            split_in_half(mesh, parent, h);
        }
        h += 1;
    }
    for f in 0..mesh.faces.len() {
        if mesh.is_alive(f) && [3 * f, next(3 * f), prev(3 * f)].iter().all(|&h| mesh.segment(h).is_some()) {
            let [a, b, c] = mesh.faces[f].map(|v| mesh.position(v));
            mesh.split_face(f, (a + b + c) / 3.0);
            parent.extend([parent[f]; 2]);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::mesh::remesh::samples::{self, feature_length, flags_per_face};
    use crate::engine::mesh::{SurfaceIndex, TriMesh};

    fn is_roomy(surface: &Surface) -> bool {
        let mesh = &surface.mesh;
        let flags = surface.features.halfedge_flags(mesh);
        let mut on_curve = vec![false; mesh.n_vertices()];
        for h in (0..mesh.n_halfedges()).filter(|&h| flags[h]) {
            on_curve[mesh.origin(h) as usize] = true;
            on_curve[mesh.target(h) as usize] = true;
        }
        let bridge = |h: usize| !flags[h] && on_curve[mesh.origin(h) as usize] && on_curve[mesh.target(h) as usize];
        flags_per_face(surface).iter().all(|&n| n <= 1) && !(0..mesh.n_halfedges()).any(bridge)
    }

    fn longest_edge(mesh: &TriMesh) -> f64 {
        (0..mesh.n_halfedges())
            .map(|h| mesh.position(mesh.origin(h)).distance(mesh.position(mesh.target(h))))
            .fold(0.0, f64::max)
    }

    #[test]
    fn the_refined_surface_is_the_same_surface() {
        for (name, surface) in samples::all() {
            let before = &surface.mesh;
            let goal = 0.3 * longest_edge(before);
            let refined = refine(&RunContext::silent(), &surface, |_| goal, usize::MAX).unwrap();
            let mesh = &refined.surface.mesh;
            assert_eq!(mesh.topology(), before.topology(), "{name}");
            assert!((mesh.total_area() / before.total_area() - 1.0).abs() < 1e-12, "{name}");
            assert!(longest_edge(mesh) <= goal, "{name}");
            assert_eq!(&mesh.positions()[..before.n_vertices()], before.positions(), "{name}");
            assert_eq!(refined.surface.features.corners, surface.features.corners, "{name}");
            let (old, new) = (feature_length(&surface), feature_length(&refined.surface));
            assert!((old.0 - new.0).abs() <= 1e-12 * old.0 && (old.1 - new.1).abs() <= 1e-12 * old.1, "{name}");
            let index = SurfaceIndex::new(before);
            let mut part = vec![0.0; before.n_faces()];
            for (f, &parent) in refined.parent_face.iter().enumerate() {
                let [a, b, c] = mesh.triangle(f);
                let centre = index.closest_where((a + b + c) / 3.0, 1e-9, |face| face == parent);
                assert!(centre.is_some() && mesh.normal(f).dot(before.normal(parent as usize)) > 0.999, "{name}");
                part[parent as usize] += mesh.area(f);
            }
            assert!(part.iter().enumerate().all(|(f, area)| (area / before.area(f) - 1.0).abs() < 1e-9), "{name}");
            assert!(is_roomy(&refined.surface), "{name}");
        }
    }

    #[test]
    fn room_is_made_even_without_a_budget() {
        for (name, surface) in samples::all() {
            let refined = refine(&RunContext::silent(), &surface, |_| 1e-3, 0).unwrap();
            assert!(is_roomy(&refined.surface), "{name}");
            assert!(refined.surface.mesh.n_faces() <= 8 * surface.mesh.n_faces(), "{name}");
        }
    }

    #[test]
    fn only_the_faces_that_ask_are_refined_much() {
        let surface = samples::torus(24, 12);
        let refined =
            refine(&RunContext::silent(), &surface, |f| if f == 7 { 0.01 } else { f64::INFINITY }, usize::MAX);
        let refined = refined.unwrap();
        let in_seven = refined.parent_face.iter().filter(|&&f| f == 7).count();
        assert!(in_seven > 500 && refined.parent_face.len() - in_seven < 5 * surface.mesh.n_faces());
    }
}
