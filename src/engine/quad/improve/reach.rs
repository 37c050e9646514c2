//! Tips and ridges that the quads cut off are reached by pulling vertices out to them.

use glam::DVec3;
use rayon::prelude::*;

use crate::engine::mesh::Surface;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::mesh::TriMesh;
use crate::engine::mesh::closest_on_triangle;
use crate::engine::quad::QuadDraft;
use crate::engine::quad::QuadMesh;
use crate::engine::quad::improve::facing::is_turned_over;
use crate::engine::quad::improve::net::QuadNet;
use crate::engine::quad::improve::shaping::Shaping;
use crate::engine::quad::optimise::SurfaceWalker;
use crate::engine::quad::optimise::area_vector;
use crate::engine::quad::optimise::is_sound;
use crate::engine::quad::optimise::mean_edge;
use crate::engine::quad::optimise::quality;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// Points of the surface farther from the quads than this part of a quad edge are reached for.
const FAR: f64 = 0.45;
/// Rounds of pulling; every round pulls vertices that do not share a quad.
const ROUNDS: usize = 12;
/// Least scaled Jacobian that a pull may leave, unless it was worse before.
const LEAST: f64 = 0.3;
/// The same for points farther away than [`VERY_FAR`] (quad edges).
const LEAST_VERY_FAR: f64 = 0.12;
const VERY_FAR: f64 = 0.8;
/// Parts of the way that are tried.
const PULLS: [f64; 3] = [1.0, 0.6, 0.3];
/// A pull must leave at most this part of the distance.
const GAIN: f64 = 0.85;
/// At most about so many points of the surface are looked at.
const POINTS: usize = 100_000;

/// Pulls free vertices to places of the surface that lie far from all quads: tips of horns and fingers, and ridges
/// between two rows of quads. Quads keep a decent shape; anchored vertices and the connectivity stay. `None` if nothing
/// was pulled. `index` is the one of `surface.mesh`, `edge_length` the length of a quad edge in model units.
///
/// # Errors
/// [`Cancelled`] if the run was asked to stop.
pub fn reach_out(
    ctx: &RunContext,
    surface: &Surface,
    index: &SurfaceIndex,
    draft: &QuadDraft,
    edge_length: f64,
) -> Result<Option<QuadDraft>, Cancelled> {
    let mean = mean_edge(draft);
    if !(is_sound(surface, draft) && mean > 0.0 && mean.is_finite()) {
        return Ok(None);
    }
    let walker = SurfaceWalker::new(surface, index, mean);
    let mut shaping = Shaping::new(&walker, draft, 0.5 * mean);
    let net = QuadNet::new(draft);
    let mut pulled = false;
    for round in 0..ROUNDS {
        let part = ctx.part(round, ROUNDS);
        let mesh = QuadMesh { positions: shaping.positions.clone(), quads: draft.mesh.quads.clone() };
        let mut again = false;
        let mut taken = vec![false; mesh.quads.len()];
        for far in far_points(&part, surface, &mesh, FAR * edge_length)? {
            let least = if far.distance > VERY_FAR * edge_length { LEAST_VERY_FAR } else { LEAST };
            again |= pull(index, &net, &mut shaping, &far, least, &mut taken);
        }
        pulled |= again;
        if !again {
            break;
        }
    }
    Ok(pulled.then(|| net.into_draft(&shaping.positions, draft)))
}

/// A point of the surface and the quad nearest to it.
struct Far {
    point: DVec3,
    /// The point of the quads nearest to it.
    foot: DVec3,
    distance: f64,
    quad: u32,
}

/// Vertices of the surface farther from the quads than `least`, the farthest first.
fn far_points(ctx: &RunContext, surface: &Surface, quads: &QuadMesh, least: f64) -> Result<Vec<Far>, Cancelled> {
    let mut positions = quads.positions.clone();
    let mut faces = Vec::with_capacity(4 * quads.quads.len());
    for q in &quads.quads {
        let centre = positions.len() as u32;
        positions.push(q.iter().map(|&v| quads.positions[v as usize]).sum::<DVec3>() / 4.0);
        faces.extend((0..4).map(|k| [q[k], q[(k + 1) % 4], centre]));
    }
    let Ok(triangles) = TriMesh::try_new(positions, faces) else { return Ok(Vec::new()) };
    let index = SurfaceIndex::new(&triangles);
    let n = surface.mesh.n_vertices();
    let chosen: Vec<u32> = (0..n as u32).step_by(n.div_ceil(POINTS).max(1)).collect();
    let look = |(i, &v): (usize, &u32)| {
        if i % 32 == 0 {
            ctx.check()?;
            ctx.step(chosen.len().div_ceil(32));
        }
        let point = surface.mesh.position(v);
        let foot = index.closest(point);
        Ok(Far { point, foot: foot.position, distance: foot.distance, quad: foot.face / 4 })
    };
    let mut far: Vec<Far> = chosen.par_iter().enumerate().map(look).collect::<Result<_, Cancelled>>()?;
    far.retain(|f| f.distance > least);
    far.sort_by(|a, b| b.distance.total_cmp(&a.distance));
    Ok(far)
}

/// Pulls the best free vertex of the quad nearest to a far point to it, or else the two ends of a side across: a ridge
/// between two rows of quads is not reached by one vertex. Tells whether it did. Quads at a pulled vertex are taken for
/// this round.
fn pull(
    index: &SurfaceIndex,
    net: &QuadNet,
    shaping: &mut Shaping<'_>,
    far: &Far,
    least: f64,
    taken: &mut [bool],
) -> bool {
    let quad = net.quads[far.quad as usize];
    let is_untaken = |v: u32| net.at[v as usize].iter().all(|&q| !taken[q as usize]);
    let is_free = |&v: &u32| net.is_free(v) && net.fan(v).is_some() && is_untaken(v);
    let there = |shaping: &Shaping<'_>, v: u32| far.point - shaping.positions[v as usize];
    let across = far.point - far.foot;
    let mut ways: Vec<(f64, Vec<u32>)> = Vec::new();
    for v in quad.iter().copied().filter(is_free) {
        ways.push((there(shaping, v).length(), vec![v]));
    }
    for k in 0..4 {
        let ends = [quad[k], quad[(k + 1) % 4]];
        if ends.iter().all(is_free) {
            // After the single ones: it moves more.
            let middle = 0.5 * (there(shaping, ends[0]) + there(shaping, ends[1]));
            ways.push((1e3 * far.distance + middle.length(), ends.to_vec()));
        }
    }
    ways.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (_, vertices) in ways {
        let mut around: Vec<u32> = vertices.iter().flat_map(|&v| net.at[v as usize].iter().copied()).collect();
        around.sort_unstable();
        around.dedup();
        let before = least_qualities(net, shaping, &around);
        let turned_before = turned_over(index, net, shaping, &around);
        let old = shaping.places(&vertices);
        for part in PULLS {
            for (&v, old) in vertices.iter().zip(&old) {
                let way = if vertices.len() == 1 { far.point - old.0 } else { across };
                shaping.positions[v as usize] = old.0 + part * way;
            }
            shaping.draw(&vertices);
            let now = least_qualities(net, shaping, &around);
            let is_decent = (0..2).all(|k| now[k] >= before[k].min(least));
            if is_decent
                && distance(net, shaping, &around, far.point) <= GAIN * far.distance
                && turned_over(index, net, shaping, &around) <= turned_before
            {
                around.iter().for_each(|&q| taken[q as usize] = true);
                return true;
            }
            shaping.put_back(&vertices, &old);
        }
    }
    false
}

/// The worst corner of some quads, against their own normals and against the surface.
fn least_qualities(net: &QuadNet, shaping: &Shaping<'_>, slots: &[u32]) -> [f64; 2] {
    let own = |&slot: &u32| {
        let p = net.quads[slot as usize].map(|w| shaping.positions[w as usize]);
        quality(&p, area_vector(&p).normalize_or_zero())
    };
    let least = |of: &dyn Fn(&u32) -> f64| slots.iter().map(of).fold(f64::INFINITY, f64::min);
    [least(&own), least(&|&slot| shaping.quality(net, slot))]
}

/// Quads that the certificate would not let pass.
fn turned_over(index: &SurfaceIndex, net: &QuadNet, shaping: &Shaping<'_>, slots: &[u32]) -> usize {
    let is_over =
        |&&slot: &&u32| is_turned_over(index, &net.quads[slot as usize].map(|w| shaping.positions[w as usize]));
    slots.iter().filter(is_over).count()
}

/// Distance from a point to some quads.
fn distance(net: &QuadNet, shaping: &Shaping<'_>, slots: &[u32], point: DVec3) -> f64 {
    let of = |&slot: &u32| {
        let p = net.quads[slot as usize].map(|w| shaping.positions[w as usize]);
        let centre = p.iter().sum::<DVec3>() / 4.0;
        let side = |k: usize| closest_on_triangle(point, &[p[k], p[(k + 1) % 4], centre]).1.distance(point);
        (0..4).map(side).fold(f64::INFINITY, f64::min)
    };
    slots.iter().map(of).fold(f64::INFINITY, f64::min)
}
