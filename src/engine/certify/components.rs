//! Components of the quads against components of the surface.

use crate::engine::certify::distance::triangulate;
use crate::engine::certify::shape::mean;
use crate::engine::certify::{Check, ComponentTopology, QuadTopology, Violation};
use crate::engine::mesh::{NONE, SurfaceIndex, SurfacePart, TriMesh};
use crate::engine::quad::QuadMesh;
use crate::engine::run::{Cancelled, RunContext};
use rayon::prelude::*;

/// One connected component of the quads.
pub(super) struct QuadPart {
    pub(super) mesh: QuadMesh,
    /// Per vertex of the component, its vertex in the whole.
    pub(super) vertices: Vec<u32>,
    /// Per quad of the component, its quad in the whole.
    pub(super) quads: Vec<u32>,
}

/// The components of the quads, in order of least vertices.
pub(super) fn parts(quads: &QuadMesh, topology: &QuadTopology) -> Vec<QuadPart> {
    let empty = || QuadPart { mesh: QuadMesh::default(), vertices: Vec::new(), quads: Vec::new() };
    let mut parts: Vec<QuadPart> = topology.components.iter().map(|_| empty()).collect();
    let mut local = vec![NONE; quads.positions.len()];
    for ((q, quad), &c) in (0u32..).zip(&quads.quads).zip(&topology.component) {
        let part = &mut parts[c as usize];
        part.quads.push(q);
        part.mesh.quads.push(quad.map(|v| {
            if local[v as usize] == NONE {
                local[v as usize] = part.vertices.len() as u32;
                part.vertices.push(v);
                part.mesh.positions.push(quads.positions[v as usize]);
            }
            local[v as usize]
        }));
    }
    parts
}

/// The topology of a connected surface.
fn topology_of(mesh: &TriMesh) -> ComponentTopology {
    let topology = mesh.topology();
    ComponentTopology::new(topology.euler, topology.boundaries)
}

/// Which component of the quads stands for which component of the surface: (component of the surface, component of the
/// quads), and the violations. Partners have the same topology and lie over one another, on average nearer than a quad's
/// mean diagonal: the ones in the same place of both orders, if they fit; then those whose vertices are mostly nearest to
/// one component of the surface, if neither has another partner; and then, where components of the surface touch or lie in
/// the same place, the nearest that is left. `index` is the one of the whole surface `mesh`.
///
/// # Errors
/// Only that the run was stopped.
pub(super) fn pair(
    ctx: &RunContext,
    mesh: &TriMesh,
    index: &SurfaceIndex,
    surface: &[SurfacePart],
    quads: &[QuadPart],
    topology: &QuadTopology,
) -> Result<(Vec<(usize, usize)>, Vec<Violation>), Cancelled> {
    let wanted: Vec<ComponentTopology> = surface.iter().map(|part| topology_of(&part.surface.mesh)).collect();
    let violations = totals(&topology.components, &wanted);
    // The index of the whole is that of the only part, too.
    let whole = (surface.len() == 1).then_some(index);
    // Quads mostly come in the order of the surface; that is believed where it fits.
    let in_order = surface.len() == quads.len();
    let fits = |i: usize| {
        ctx.check()?;
        Ok(in_order && topology.components[i] == wanted[i] && distance(&surface[i], whole, &quads[i]) <= CLEAR)
    };
    let fitting: Vec<bool> = (0..surface.len()).into_par_iter().map(fits).collect::<Result<_, Cancelled>>()?;
    let mut pairs: Vec<(usize, usize)> = (0..surface.len()).filter(|&i| fitting[i]).map(|i| (i, i)).collect();
    let is_open = |i: &usize| !fitting.get(*i).is_some_and(|&fits| fits);
    let mut open: Vec<usize> = (0..surface.len()).filter(is_open).collect();
    // The other ones by the votes of their vertices.
    let (of_face, n) = mesh.components();
    let vote = |c: usize| {
        ctx.check()?;
        let mut votes = vec![0usize; n];
        for &p in &quads[c].mesh.positions {
            votes[of_face[index.closest(p).face as usize] as usize] += 1;
        }
        Ok((c, (0..n).max_by_key(|&s| (votes[s], n - s))))
    };
    let voters: Vec<usize> = (0..quads.len()).filter(|c| !in_order || is_open(c)).collect();
    let winners: Vec<(usize, Option<usize>)> = voters.par_iter().map(|&c| vote(c)).collect::<Result<_, Cancelled>>()?;
    let mut owners: Vec<Vec<usize>> = vec![Vec::new(); surface.len()];
    for &(c, winner) in &winners {
        if let Some(s) = winner {
            owners[s].push(c);
        }
    }
    open.retain(|&s| match owners[s].as_slice() {
        [c] if topology.components[*c] == wanted[s] && distance(&surface[s], whole, &quads[*c]) <= NEAR => {
            pairs.push((s, *c));
            false
        }
        _ => true,
    });
    let mut left: Vec<usize> = (0..quads.len()).filter(|c| pairs.iter().all(|p| p.1 != *c)).collect();
    let mut lost = Vec::new();
    for s in open {
        ctx.check()?;
        let alike = left.iter().copied().filter(|&c| topology.components[c] == wanted[s]);
        let costs: Vec<(f64, usize)> = alike.map(|c| (distance(&surface[s], None, &quads[c]), c)).collect();
        match costs.iter().min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some(&(cost, c)) if cost <= NEAR => {
                left.retain(|&other| other != c);
                pairs.push((s, c));
            }
            _ => lost.push(s as u32),
        }
    }
    pairs.sort_unstable();
    Ok((pairs, violations.into_iter().chain(Violation::at(Check::ComponentMatch, lost)).collect()))
}

fn totals(found: &[ComponentTopology], wanted: &[ComponentTopology]) -> Vec<Violation> {
    let sum = |list: &[ComponentTopology]| -> (usize, usize) {
        (list.iter().map(|c| c.boundaries).sum(), list.iter().map(|c| c.genus).sum())
    };
    let ((b, g), (b0, g0)) = (sum(found), sum(wanted));
    let unequal = [
        Violation::unequal(Check::Components, found.len(), wanted.len()),
        Violation::unequal(Check::Boundaries, b, b0),
        Violation::unequal(Check::Genus, g, g0),
    ];
    unequal.into_iter().flatten().collect()
}

/// Components farther apart, in the measure of [`distance`], do not belong together.
const NEAR: f64 = 1.0;
/// … and those nearer than this certainly do: less than what being inside out adds.
const CLEAR: f64 = 0.4;
/// Vertices of a component of the surface that are looked at for its distance.
const SAMPLES: usize = 200;

/// The mean distance from a component of the surface to one of the quads, in diagonals of its quads. Where the
/// quads nearest to a vertex face the other way, half a diagonal is added: sheets that lie in the same place are told
/// apart by their sides.
fn distance(surface: &SurfacePart, index: Option<&SurfaceIndex>, quads: &QuadPart) -> f64 {
    let Some(triangles) = triangulate(&quads.mesh) else { return f64::INFINITY };
    let mesh = &surface.surface.mesh;
    let own;
    let sides = match index {
        Some(index) => index,
        None => {
            own = SurfaceIndex::new(mesh);
            &own
        }
    };
    let index = SurfaceIndex::new(&triangles);
    // The mean over the area: many tiny quads at a few handles must not make the others look far away.
    let (mut cubes, mut squares) = (0.0, 0.0);
    for q in &quads.mesh.quads {
        let [a, b, c, d] = q.map(|v| quads.mesh.positions[v as usize]);
        let diagonal = 0.5 * (a.distance(c) + b.distance(d));
        squares += diagonal.powi(2);
        cubes += diagonal.powi(3);
    }
    let unit = cubes / squares;
    let step = mesh.n_vertices().div_ceil(SAMPLES).max(1);
    let distances: Vec<f64> = (0..mesh.n_vertices() as u32)
        .step_by(step)
        .map(|v| {
            let p = mesh.position(v);
            let foot = index.closest(p);
            let opposed = index.normal(foot.face).dot(sides.smooth_normal(&sides.closest(p))) < 0.0;
            foot.distance / unit + if opposed { 0.5 } else { 0.0 }
        })
        .collect();
    mean(&distances)
}
