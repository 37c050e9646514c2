//! Polygons to triangles, and what cannot become one.

use glam::DVec2;
use glam::DVec3;

use crate::engine::mesh::TriangleSoup;
use crate::engine::mesh::condition::tally::Tally;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// Triangles over positions of the soup.
#[derive(Debug, Default)]
pub(super) struct Triangles {
    /// Corners per triangle.
    pub(super) corners: Vec<[u32; 3]>,
    /// Polygon of the soup per triangle.
    pub(super) polygon: Vec<u32>,
}

impl Triangles {
    /// Keeps the triangles for which `keep` holds, in order.
    pub(super) fn retain(&mut self, keep: impl Fn(usize) -> bool) {
        let kept: Vec<usize> = (0..self.corners.len()).filter(|&f| keep(f)).collect();
        self.corners = kept.iter().map(|&f| self.corners[f]).collect();
        self.polygon = kept.iter().map(|&f| self.polygon[f]).collect();
    }
}

/// Cuts every polygon of which all corners are finite into triangles. `positions` are those of the soup, scaled.
pub(super) fn triangulate(
    ctx: &RunContext,
    soup: &TriangleSoup,
    positions: &[DVec3],
    tally: &mut Tally,
) -> Result<Triangles, Cancelled> {
    let mut out = Triangles::default();
    let (mut not_finite, mut degenerate) = (0, 0);
    let mut ring = Vec::new();
    for (p, polygon) in soup.polygons().enumerate() {
        if p % 4096 == 0 {
            ctx.check()?;
        }
        if !polygon.iter().all(|&v| positions[v as usize].is_finite()) {
            not_finite += 1;
            continue;
        }
        let before = out.corners.len();
        match *polygon {
            [a, b, c] if a != b && b != c && c != a => out.corners.push([a, b, c]),
            _ => {
                ring.clear();
                ring.extend_from_slice(polygon);
                ring.dedup();
                while ring.len() > 1 && ring.first() == ring.last() {
                    ring.pop();
                }
                if ring.len() >= 3 {
                    cut_polygon(ctx, &ring, positions, &mut out.corners)?;
                }
            }
        }
        if out.corners.len() == before {
            degenerate += 1;
        }
        out.polygon.resize(out.corners.len(), p as u32);
    }
    tally.add("not_finite_faces_dropped", not_finite);
    tally.add("degenerate_faces_dropped", degenerate + soup.dropped_by_reader);
    Ok(out)
}

/// Cuts one polygon in the plane that fits it best (Newell's normal). Triangles that name a vertex twice are left
/// out: they come from slits, which polygons with holes have.
fn cut_polygon(ctx: &RunContext, ring: &[u32], positions: &[DVec3], out: &mut Vec<[u32; 3]>) -> Result<(), Cancelled> {
    let at = |i: usize| positions[ring[i % ring.len()] as usize];
    let centre = (0..ring.len()).map(at).sum::<DVec3>() / ring.len() as f64;
    let normal = (0..ring.len()).map(|i| (at(i) - centre).cross(at(i + 1) - centre)).sum::<DVec3>();
    // A polygon without area: any triangulation will do, its triangles are mended later.
    let normal = normal.try_normalize().unwrap_or(DVec3::Z);
    let x = normal.any_orthonormal_vector();
    let y = normal.cross(x);
    let flat: Vec<DVec2> = (0..ring.len()).map(|i| at(i) - centre).map(|d| DVec2::new(d.dot(x), d.dot(y))).collect();
    let triangles = if ring.len() == 4 { cut_quad(&flat) } else { clip_ears(ctx, &flat)? };
    for [a, b, c] in triangles.into_iter().map(|t| t.map(|i| ring[i])) {
        if a != b && b != c && c != a {
            out.push([a, b, c]);
        }
    }
    Ok(())
}

fn doubled_area(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// The diagonal that leaves the better shaped worse triangle; the first one on a tie, so that grids stay regular.
fn cut_quad(p: &[DVec2]) -> Vec<[usize; 3]> {
    let shape = |t: [usize; 3]| {
        let [a, b, c] = t.map(|i| p[i]);
        let lengths = (b - a).length_squared() + (c - b).length_squared() + (a - c).length_squared();
        if lengths > 0.0 { doubled_area(a, b, c) / lengths } else { 0.0 }
    };
    let first = [[0, 1, 2], [0, 2, 3]];
    let second = [[1, 2, 3], [1, 3, 0]];
    let worse = |pair: [[usize; 3]; 2]| shape(pair[0]).min(shape(pair[1]));
    if worse(second) > worse(first) + 1e-6 { second.to_vec() } else { first.to_vec() }
}

/// Ear clipping around the ring, every second ear first, which keeps the triangles of round polygons fat. Where a
/// polygon crosses itself and no ear is left, the next corner is clipped anyway: the result always has n − 2 triangles.
fn clip_ears(ctx: &RunContext, p: &[DVec2]) -> Result<Vec<[usize; 3]>, Cancelled> {
    let n = p.len();
    let mut next: Vec<usize> = (0..n).map(|i| (i + 1) % n).collect();
    let mut prev: Vec<usize> = (0..n).map(|i| (i + n - 1) % n).collect();
    let extent = p.iter().fold(0.0_f64, |e, q| e.max(q.abs().max_element()));
    let tiny = 1e-14 * extent * extent;
    let convex = |i: usize, prev: &[usize], next: &[usize]| doubled_area(p[prev[i]], p[i], p[next[i]]) > tiny;
    let mut blocking: Vec<usize> = (0..n).filter(|&i| !convex(i, &prev, &next)).collect();
    let mut out = Vec::with_capacity(n.saturating_sub(2));
    let (mut i, mut left, mut misses) = (0, n, 0);
    while left > 3 {
        if out.len() % 64 == 0 {
            ctx.check()?;
        }
        let (a, c) = (prev[i], next[i]);
        let is_ear = convex(i, &prev, &next) && !blocking.iter().any(|&j| is_inside(p[j], p[a], p[i], p[c]));
        if !is_ear && misses < left {
            misses += 1;
            i = c;
            continue;
        }
        out.push([a, i, c]);
        next[a] = c;
        prev[c] = a;
        left -= 1;
        misses = 0;
        // Clipping can only make corners more convex: those that blocked may cease to.
        blocking.retain(|&j| j != i && ((j != a && j != c) || !convex(j, &prev, &next)));
        i = next[c];
    }
    if n >= 3 {
        out.push([prev[i], i, next[i]]);
    }
    Ok(out)
}

/// Whether `q` lies in the closed triangle, but is none of its corners.
fn is_inside(q: DVec2, a: DVec2, b: DVec2, c: DVec2) -> bool {
    q != a
        && q != b
        && q != c
        && doubled_area(a, b, q) >= 0.0
        && doubled_area(b, c, q) >= 0.0
        && doubled_area(c, a, q) >= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn areas(points: &[(f64, f64)]) -> Vec<f64> {
        let p: Vec<DVec2> = points.iter().map(|&(x, y)| DVec2::new(x, y)).collect();
        let triangles = clip_ears(&RunContext::silent(), &p).unwrap();
        assert_eq!(triangles.len(), p.len() - 2);
        triangles.iter().map(|t| 0.5 * doubled_area(p[t[0]], p[t[1]], p[t[2]])).collect()
    }

    #[test]
    fn a_comb_is_cut_into_positive_triangles_of_its_area() {
        let mut comb = vec![(0.0, -1.0), (10.0, -1.0)];
        for i in (0..5).rev() {
            let x = 2.0 * f64::from(i);
            comb.extend([(x + 2.0, 0.0), (x + 1.5, 4.0), (x + 0.5, 4.0)]);
        }
        comb.push((0.0, 0.0));
        let areas = areas(&comb);
        assert!(areas.iter().all(|&a| a > 0.0), "{areas:?}");
        let want = 10.0 + 5.0 * 6.0;
        assert!((areas.iter().sum::<f64>() - want).abs() < 1e-12);
    }

    #[test]
    fn corners_on_a_straight_side_make_no_flat_triangle() {
        let square = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0), (3.0, 3.0), (0.0, 3.0)];
        assert!(areas(&square).iter().all(|&a| a > 0.0));
    }

    #[test]
    fn a_dart_is_cut_at_its_reflex_corner() {
        let dart: Vec<DVec2> =
            [(0.0, 0.0), (2.0, -3.0), (0.0, 5.0), (-2.0, -3.0)].iter().map(|&(x, y)| DVec2::new(x, y)).collect();
        let cut = cut_quad(&dart);
        assert!(cut.iter().all(|t| t.contains(&0) && t.contains(&2)), "{cut:?}");
        assert!(cut.iter().all(|t| doubled_area(dart[t[0]], dart[t[1]], dart[t[2]]) > 0.0));
    }
}
