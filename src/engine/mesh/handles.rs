//! Small handles of a surface, found by a tree and a cotree: what is left of the edges are two loops per handle
//! (`[erickson_2005]`).

use glam::DVec3;

use crate::engine::mesh::ShortestPaths;
use crate::engine::mesh::TriMesh;
use crate::engine::numerics::DisjointSets;
use crate::engine::run::{Cancelled, RunContext};

/// A handle with a short loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmallHandle {
    /// Mean of the vertices of the loop.
    pub centre: DVec3,
    /// Length of the loop along edges, model units.
    pub girth: f64,
}

/// The loops shorter than `longest` (model units) among two for each handle of a connected surface: shortest paths from
/// one vertex to both ends of an edge, without what they share. Those of small handles are short wherever the paths
/// come from. O(F log F).
///
/// # Errors
/// [`Cancelled`] if the run was asked to stop.
pub fn small_handles(ctx: &RunContext, mesh: &TriMesh, longest: f64) -> Result<Vec<SmallHandle>, Cancelled> {
    if mesh.topology().genus == 0 {
        return Ok(Vec::new());
    }
    let paths = ShortestPaths::new(mesh, std::iter::once(0));
    ctx.check()?;
    let mut is_used = vec![false; mesh.n_halfedges()];
    for h in paths.by.iter().copied().flatten() {
        is_used[h] = true;
        mesh.twin(h).into_iter().for_each(|t| is_used[t] = true);
    }
    let mut edges: Vec<usize> = (0..mesh.n_halfedges()).filter(|&h| mesh.is_edge_owner(h) && !is_used[h]).collect();
    let across: Vec<f64> = (0..mesh.n_halfedges()).map(|h| paths.across(mesh, h)).collect();
    edges.sort_by(|&a, &b| across[b].total_cmp(&across[a]));
    ctx.check()?;
    // The dearest edges are left out first; the boundary loops are faces like others.
    let mut outside = vec![0; mesh.n_halfedges()];
    let loops = mesh.boundary_loops();
    loops.iter().enumerate().for_each(|(i, halfedges)| halfedges.iter().for_each(|&h| outside[h] = i));
    let mut faces = DisjointSets::new(mesh.n_faces() + loops.len());
    let mut small = Vec::new();
    for h in edges {
        let other = mesh.twin(h).map_or(mesh.n_faces() + outside[h], |t| t / 3);
        let is_handle = !faces.join(h as u32 / 3, other as u32);
        if is_handle && let Some(handle) = around(&paths, mesh, h, longest) {
            small.push(handle);
        }
    }
    Ok(small)
}

/// The loop through an edge, if it is shorter than `longest`.
fn around(paths: &ShortestPaths, mesh: &TriMesh, h: usize, longest: f64) -> Option<SmallHandle> {
    let (mut a, mut b) = (mesh.origin(h), mesh.target(h));
    let (mut sum, mut n) = (mesh.position(a) + mesh.position(b), 2.0);
    let mut girth = mesh.position(a).distance(mesh.position(b));
    while a != b {
        // The one farther from the root goes on: paths that have met stay together.
        if paths.distance[a as usize] < paths.distance[b as usize] {
            std::mem::swap(&mut a, &mut b);
        }
        let (before, step) = paths.before(mesh, a)?;
        a = before;
        girth += step;
        if girth >= longest {
            return None;
        }
        if a != b {
            (sum, n) = (sum + mesh.position(a), n + 1.0);
        }
    }
    Some(SmallHandle { centre: sum / n, girth })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::mesh::shapes::sample_surface;

    #[test]
    fn loops_of_the_size_of_the_handles_are_found_and_no_others() {
        let found = |name: &str, longest: f64| {
            let mesh = sample_surface(name, 3000).unwrap().mesh;
            small_handles(&RunContext::silent(), &mesh, longest * mesh.diagonal()).unwrap()
        };
        assert!(found("sphere", 10.0).is_empty() && found("half_pipe", 10.0).is_empty(), "no handle");
        assert_eq!(found("torus", 10.0).len(), 2);
        assert_eq!(found("genus2", 10.0).len(), 4);
        assert!(found("torus", 0.05).is_empty(), "both loops are longer");
        // The loop around the tube is the shorter one; its middle lies within the tube.
        let mesh = sample_surface("torus", 3000).unwrap().mesh;
        let mut loops = found("torus", 10.0);
        loops.sort_by(|a, b| a.girth.total_cmp(&b.girth));
        let shorter = small_handles(&RunContext::silent(), &mesh, 0.5 * (loops[0].girth + loops[1].girth)).unwrap();
        assert_eq!(shorter, loops[..1]);
        let nearest = mesh.positions().iter().map(|p| p.distance(loops[0].centre)).fold(f64::INFINITY, f64::min);
        assert!(nearest < loops[0].girth / 4.0, "{nearest} {}", loops[0].girth);
    }
}
