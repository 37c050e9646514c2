//! Admissible systems of curves: disjoint, essential, no two homotopic `[zhao_2020]` section 5.6.
//!
//! Curves are shortest closed strips of triangles through some roots that no other curve occupies. A strip crosses chains of
//! edges between which it separates; the parities of its crossings say what it separates, so that each face gets a few
//! bits by one search from a root and each edge that closes a loop is judged in constant time.

use crate::engine::calculus::{Side, generators};
use crate::engine::mesh::TriMesh;
use crate::engine::methods::holomorphic::error::HolomorphicError;
use crate::engine::methods::holomorphic::pants::cut_to_pants;
use crate::engine::methods::holomorphic::shortest_loop::shortest_loop;
use crate::engine::methods::holomorphic::strip::Strip;
use crate::engine::run::RunContext;

/// Which system of curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CurveSystem {
    /// One shortest loop per handle.
    Handles,
    /// The single shortest loop.
    Single,
    /// As many as there can be: one per handle, and those that cut the rest into pairs of pants.
    Pants,
}

/// Most handles: crossings are counted in the bits of one number, two per handle.
pub(super) const MOST_HANDLES: usize = 64;
/// Searches per curve, each through another root.
const ROOTS: usize = 4;

/// Finds the system on a closed connected surface of genus 1 or more. `seed` chooses the roots.
///
/// # Errors
/// A stop, too many handles, or too few curves because there is no room for them between the triangles.
pub(super) fn curve_system(
    ctx: &RunContext,
    mesh: &TriMesh,
    system: CurveSystem,
    seed: usize,
) -> Result<Vec<Strip>, HolomorphicError> {
    let genus = mesh.topology().genus;
    if genus > MOST_HANDLES {
        return Err(HolomorphicError::TooManyHandles(genus, MOST_HANDLES));
    }
    let start = seed * mesh.n_vertices() / 7 % mesh.n_vertices().max(1);
    let generators = generators(ctx, mesh, Side::Tangential, start as u32)?;
    let mut bits = vec![0u128; mesh.n_halfedges()];
    for (i, generator) in generators.iter().enumerate() {
        for step in &generator.chain {
            bits[step.halfedge] ^= 1 << i;
            mesh.twin(step.halfedge).into_iter().for_each(|t| bits[t] ^= 1 << i);
        }
    }
    let wanted = if system == CurveSystem::Single { 1 } else { genus };
    let mut is_taken = vec![false; mesh.n_faces()];
    let mut strips: Vec<Strip> = Vec::new();
    let mut classes: Vec<u128> = Vec::new();
    // Loops that are short through their own generator's faces come first.
    let roots: Vec<usize> = generators.iter().map(|g| g.chain[g.chain.len() / 2].halfedge / 3).collect();
    for round in 0..wanted {
        let mut best: Option<(f64, Strip, u128)> = None;
        // A loop is new if its class modulo 2 does not depend on those of the others: only then does cutting along it leave the
        // surface in one piece.
        let accepts = |class: u128| reduced(&classes, class) != 0;
        for k in 0..ROOTS.max(roots.len()) {
            let root = roots[(k + round) % roots.len()];
            if let Some(found) = shortest_loop(ctx, mesh, &is_taken, &bits, root, &accepts)?
                && best.as_ref().is_none_or(|b| found.0 < b.0)
            {
                best = Some(found);
            }
        }
        let Some((_, strip, class)) = best else {
            return Err(HolomorphicError::Curves { found: strips.len(), wanted });
        };
        let class = reduced(&classes, class);
        // Kept in echelon form: the leading bit of each is in no other.
        classes.iter_mut().filter(|c| **c >> class.ilog2() & 1 == 1).for_each(|c| *c ^= class);
        classes.push(class);
        strip.faces().for_each(|f| is_taken[f] = true);
        strips.push(strip);
    }
    if system == CurveSystem::Pants {
        cut_to_pants(ctx, mesh, &mut is_taken, &mut strips)?;
    }
    Ok(strips)
}

fn reduced(classes: &[u128], mut class: u128) -> u128 {
    for known in classes {
        if class >> known.ilog2() & 1 == 1 {
            class ^= known;
        }
    }
    class
}
