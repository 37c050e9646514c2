//! Connected components apart, each with its share of the quads.

use std::sync::Arc;

use glam::DVec3;

use crate::engine::field::quads_of;
use crate::engine::mesh::Features;
use crate::engine::mesh::Surface;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::mesh::SurfacePart;
use crate::engine::mesh::TriMesh;
use crate::engine::mesh::closest_on_segment;
use crate::engine::pipeline::sizing::size_at;

/// Size of quads around places with detail, relative to the edge length; others say their size themselves,
const DENSE: f64 = 0.5;
/// which they have within so many times that size of the place,
const DENSE_RADIUS: f64 = 2.0;
/// and by which they grow per edge length beyond.
const DENSE_SLOPE: f64 = 0.3;
/// Dense places nearer to each other than so many times their size are one.
const DENSE_APART: f64 = 1.0;

/// A place where quads are to be smaller.
#[derive(Clone, Copy, Debug)]
pub(super) struct DensePlace {
    pub(super) at: DVec3,
    /// Their size relative to the edge length.
    pub(super) size: f64,
}

impl From<DVec3> for DensePlace {
    fn from(at: DVec3) -> Self {
        Self { at, size: DENSE }
    }
}

/// One connected component of a surface and its density.
#[derive(Clone, Debug)]
pub(super) struct Component {
    pub(super) surface: Surface,
    /// Per vertex, its vertex in the whole surface.
    pub(super) vertices: Vec<u32>,
    /// Per halfedge, its halfedge in the whole surface.
    pub(super) halfedges: Arc<[u32]>,
    /// Length of a quad edge in model units.
    pub(super) edge_length: f64,
    /// Area over squared edge length.
    pub(super) quads: f64,
    /// Per vertex the logarithm of the size relative to the edge length; empty if all quads are to be alike.
    pub(super) log_size: Vec<f64>,
    /// Places with detail below the size of the quads, around which they are to be smaller.
    pub(super) dense: Arc<[DensePlace]>,
    /// Lines to follow, of the whole model.
    pub(super) strokes: Arc<[Vec<DVec3>]>,
}

/// Feature curves shorter than this many quad edges are given up as a whole, or than this many radii if that is less.
const SHORT_CURVE: (f64, f64) = (6.0, 4.0);
/// What is left of a feature curve is kept from this many quad edges on.
const STUMP: f64 = 2.0;

impl Component {
    /// The component without its interior features; `None` if it has none. Corners of the boundary stay.
    pub(super) fn without_features(&self) -> Option<Self> {
        (!self.surface.features.edges.is_empty()).then(|| self.with_edges(Vec::new()))
    }

    /// The component without the feature edges near some places: short curves as a whole, of long ones the part within
    /// `radius` (model units), and what is left of them if it is only a stump. `None` if no feature is there.
    pub(super) fn without_features_near(&self, places: &[DVec3], radius: f64) -> Option<Self> {
        let mesh = &self.surface.mesh;
        let edges = &self.surface.features.edges;
        let ends = |e: &[u32; 2]| e.map(|v| mesh.position(v));
        let length = |e: &[u32; 2]| ends(e)[0].distance(ends(e)[1]);
        let is_near = |e: &[u32; 2]| {
            let [a, b] = ends(e);
            places.iter().any(|&p| closest_on_segment(p, a, b).1.distance(p) <= radius)
        };
        let near: Vec<bool> = edges.iter().map(is_near).collect();
        if !near.contains(&true) {
            return None;
        }
        let curve = curves(edges, &self.surface.features.corners);
        let mut sizes = vec![0.0; edges.len()];
        let mut touched = vec![false; edges.len()];
        for (e, &c) in curve.iter().enumerate() {
            sizes[c] += length(&edges[e]);
            touched[c] |= near[e];
        }
        let short = (SHORT_CURVE.0 * self.edge_length).min(SHORT_CURVE.1 * radius);
        let goes = |e: usize| near[e] || touched[curve[e]] && sizes[curve[e]] < short;
        let mut kept: Vec<[u32; 2]> = (0..edges.len()).filter(|&e| !goes(e)).map(|e| edges[e]).collect();
        // Stumps: curves with a loose end that was none before.
        loop {
            let curve = curves(&kept, &self.surface.features.corners);
            let (before, now) = (Features::degrees(edges, mesh), Features::degrees(&kept, mesh));
            let mut sizes = vec![0.0; kept.len()];
            let mut loose = vec![false; kept.len()];
            for (e, &c) in curve.iter().enumerate() {
                sizes[c] += length(&kept[e]);
                loose[c] |= kept[e].iter().any(|&v| now[v as usize] == 1 && before[v as usize] > 1);
            }
            let is_stump = |e: usize| loose[curve[e]] && sizes[curve[e]] < STUMP * self.edge_length;
            let next: Vec<[u32; 2]> = (0..kept.len()).filter(|&e| !is_stump(e)).map(|e| kept[e]).collect();
            if next.len() == kept.len() {
                break;
            }
            kept = next;
        }
        Some(self.with_edges(kept))
    }

    /// The same component with smaller quads around more places; `None` if there are no others than so far.
    pub(super) fn denser(&self, places: impl Iterator<Item = DensePlace>) -> Option<Self> {
        let dense = apart(self.dense.iter().copied().chain(places), self.edge_length);
        (dense.len() > self.dense.len()).then(|| Self { dense: dense.into(), ..self.clone() })
    }

    /// Whether all quads are to be alike.
    pub(super) fn is_even(&self) -> bool {
        self.log_size.is_empty() && self.dense.is_empty()
    }

    /// Logarithm of the size of quads at a point near the surface, relative to the edge length.
    pub(super) fn log_size_at(&self, index: &SurfaceIndex, p: DVec3) -> f64 {
        let size = size_at(&self.surface.mesh, index, &self.log_size, p);
        let around = |place: &DensePlace| {
            let away = place.at.distance(p) / self.edge_length;
            place.size + DENSE_SLOPE * (away - DENSE_RADIUS * place.size).max(0.0)
        };
        size + self.dense.iter().map(around).fold(1.0, f64::min).ln()
    }

    /// The same component with quads of `factor` times the edge length.
    pub(super) fn finer(&self, factor: f64) -> Self {
        let (edge_length, quads) = (self.edge_length * factor, self.quads / (factor * factor));
        Self { edge_length, quads, ..self.clone() }
    }

    /// The same component with some of its feature edges only, in their order.
    fn with_edges(&self, edges: Vec<[u32; 2]>) -> Self {
        let mesh = &self.surface.mesh;
        let surface = Surface { mesh: mesh.clone(), features: self.surface.features.restricted(mesh, edges) };
        Self { surface, ..self.clone() }
    }
}

/// Those of the places that are apart from all before them.
fn apart(places: impl Iterator<Item = DensePlace>, edge_length: f64) -> Vec<DensePlace> {
    let mut kept: Vec<DensePlace> = Vec::new();
    for place in places {
        let least = DENSE_APART * place.size * edge_length;
        if kept.iter().all(|other| other.at.distance(place.at) >= least || other.size > place.size) {
            kept.push(place);
        }
    }
    kept
}

/// Per edge, the first edge of its curve: edges that meet where there is no corner.
fn curves(edges: &[[u32; 2]], corners: &[u32]) -> Vec<usize> {
    let mut parent: Vec<usize> = (0..edges.len()).collect();
    let mut ends: Vec<(u32, usize)> = edges.iter().enumerate().flat_map(|(e, v)| [(v[0], e), (v[1], e)]).collect();
    ends.sort_unstable();
    for group in ends.chunk_by(|a, b| a.0 == b.0) {
        if let [(v, e), (_, f)] = *group
            && corners.binary_search(&v).is_err()
        {
            let (e, f) = (root(&parent, e), root(&parent, f));
            parent[e.max(f)] = e.min(f);
        }
    }
    (0..edges.len()).map(|e| root(&parent, e)).collect()
}

fn root(parent: &[usize], mut e: usize) -> usize {
    while parent[e] != e {
        e = parent[e];
    }
    e
}

/// Fewest quads that a component gets, and more for each boundary loop and each handle: fewer cannot show its shape.
const MIN_QUADS: f64 = 24.0;
const MIN_QUADS_OF_BOUNDARY: f64 = 12.0;
const MIN_QUADS_OF_HANDLE: f64 = 24.0;

/// At most by this factor are quads longer than asked for because small components take more than their share.
const MOST_STRETCHED: f64 = 1.5;

/// Fewest quads of a component.
fn least_quads(mesh: &TriMesh) -> f64 {
    let topology = mesh.topology();
    MIN_QUADS + MIN_QUADS_OF_BOUNDARY * topology.boundaries as f64 + MIN_QUADS_OF_HANDLE * topology.genus as f64
}

/// How much longer the edges of all components must be, at most [`MOST_STRETCHED`], for their number of quads to be what
/// it would be if none had a least number. Per component its share and that number.
fn stretch(quads: &[(f64, f64)]) -> f64 {
    let sum = |stretch: f64| quads.iter().map(|&(share, least)| (share / (stretch * stretch)).max(least)).sum::<f64>();
    let wanted: f64 = quads.iter().map(|q| q.0).sum();
    let (mut low, mut high) = (1.0, MOST_STRETCHED);
    if sum(low) <= wanted * (1.0 + 1e-9) {
        return low;
    }
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if sum(middle) > wanted { low = middle } else { high = middle }
    }
    high
}

/// Splits a surface; components in order of their first faces, vertices and faces of each in their order. `log_size`
/// are sizes relative to the edge length per vertex, empty if all quads are to be alike; `detail` vertices around which
/// quads are to be smaller, sorted. With `keeps_count` what small components take more than their share is taken from
/// the others.
pub(super) fn split(
    surface: &Surface,
    edge_length: f64,
    keeps_count: bool,
    log_size: &[f64],
    detail: &[u32],
    strokes: &[Vec<DVec3>],
) -> Vec<Component> {
    let strokes: Arc<[Vec<DVec3>]> = strokes.into();
    let parts = surface.parts();
    let sizes_of = |part: &SurfacePart| -> Vec<f64> {
        part.vertices.iter().filter_map(|&v| log_size.get(v as usize).copied()).collect()
    };
    let area_of = |part: &SurfacePart| match sizes_of(part) {
        sizes if sizes.is_empty() => part.surface.mesh.total_area(),
        sizes => quads_of(&part.surface.mesh, &sizes),
    };
    let edge_length = if keeps_count && parts.len() > 1 {
        let quads = |part| (area_of(part) / (edge_length * edge_length), least_quads(&part.surface.mesh));
        edge_length * stretch(&parts.iter().map(quads).collect::<Vec<_>>())
    } else {
        edge_length
    };
    let component = |part: SurfacePart| {
        let area = part.surface.mesh.total_area();
        let least = least_quads(&part.surface.mesh);
        // A component's own edge length is the one that gives its share of the quads.
        let mut log_size = sizes_of(&part);
        let shift = 0.5 * (area_of(&part) / area).ln();
        log_size.iter_mut().for_each(|log| *log += shift);
        let edge_length = (edge_length * (-shift).exp()).min((area / least).sqrt());
        let detailed = part.vertices.iter().filter(|v| detail.binary_search(v).is_ok());
        let dense = apart(detailed.map(|&v| surface.mesh.position(v).into()), edge_length);
        Component {
            surface: part.surface,
            vertices: part.vertices,
            halfedges: part.halfedges.into(),
            edge_length,
            quads: area / (edge_length * edge_length),
            log_size,
            dense: dense.into(),
            strokes: strokes.clone(),
        }
    };
    parts.into_iter().map(component).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::mesh::shapes::sample_surface;

    /// A cube and the length of its side.
    fn cube(edges_per_side: f64) -> (Component, DVec3, f64) {
        let surface = sample_surface("cube", 1200).unwrap();
        let corner = surface.mesh.position(surface.features.corners[0]);
        let side = (surface.mesh.total_area() / 6.0).sqrt();
        let component = split(&surface, side / edges_per_side, true, &[], &[], &[]).remove(0);
        (component, corner, side)
    }

    #[test]
    fn short_curves_go_as_a_whole_and_long_ones_only_near_the_place() {
        let (coarse, corner, side) = cube(4.0);
        let (all, bare) = (coarse.surface.features.edges.len(), coarse.without_features().unwrap());
        assert_eq!((bare.surface.features.edges.len(), bare.surface.features.corners.len()), (0, 0));
        assert!(bare.without_features().is_none() && bare.without_features_near(&[corner], side).is_none());
        let less = coarse.without_features_near(&[corner], 0.4 * side).unwrap();
        assert_eq!(4 * less.surface.features.edges.len(), 3 * all, "three of twelve sides");
        assert_eq!(less.surface.features.corners.len(), 7);
        let (fine, corner, side) = cube(10.0);
        assert!(fine.without_features_near(&[corner * 3.0], 0.1 * side).is_none());
        let less = fine.without_features_near(&[corner], 0.3 * side).unwrap();
        let lost = (all - less.surface.features.edges.len()) as f64 / all as f64;
        assert!((lost - 3.0 * 0.3 / 12.0).abs() < 0.03, "{lost}");
        // One corner is gone, and three loose ends are new.
        assert_eq!(less.surface.features.corners.len(), 10);
        // What is left of each side would be a stump.
        let stumps = fine.without_features_near(&[corner], 0.9 * side).unwrap();
        assert_eq!(4 * stumps.surface.features.edges.len(), 3 * all);
    }

    #[test]
    fn what_small_components_take_is_taken_from_the_others() {
        let quads = [(900.0, 24.0), (60.0, 24.0), (2.0, 24.0), (1.0, 48.0)];
        let stretch = stretch(&quads);
        let taken: f64 = quads.iter().map(|&(share, least)| (share / (stretch * stretch)).max(least)).sum();
        assert!((taken - 963.0).abs() < 1e-3, "{taken}");
        assert_eq!(super::stretch(&[(900.0, 24.0), (60.0, 24.0)]), 1.0, "none takes more than its share");
        assert_eq!(super::stretch(&[(30.0, 24.0), (1.0, 500.0)]), MOST_STRETCHED);
    }

    #[test]
    fn quads_are_half_as_large_around_dense_places_and_grow_away_from_them() {
        let (cube, corner, side) = cube(10.0);
        assert!(cube.is_even());
        let denser = cube.denser([corner, corner * 1.01].map(DensePlace::from).into_iter()).unwrap();
        assert_eq!((denser.dense.len(), denser.is_even()), (1, false), "two places so near are one");
        assert!(denser.denser(std::iter::once(corner.into())).is_none());
        let index = SurfaceIndex::new(&cube.surface.mesh);
        let along = DVec3::X * -corner.x.signum() * cube.edge_length;
        let sizes = [0.0, 0.9, 2.0, 3.0].map(|d| denser.log_size_at(&index, corner + d * along).exp());
        let wanted = [0.5, 0.5, 0.8, 1.0];
        assert!(sizes.iter().zip(wanted).all(|(s, w)| (s - w).abs() < 1e-9), "{sizes:?} of {side}");
        // What was asked for besides is kept.
        let log_size = vec![0.7; cube.vertices.len()];
        let larger = Component { log_size, ..denser };
        assert!((larger.log_size_at(&index, corner + 5.0 * along) - 0.7).abs() < 1e-9);
    }
}
