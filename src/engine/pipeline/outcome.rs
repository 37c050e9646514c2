//! The parameterisation of all components as one.

use glam::DVec3;

use crate::engine::methods::Data;
use crate::engine::parameterize::GridMap;
use crate::engine::pipeline::report::{BranchReport, MapReport, Singularity};
use crate::engine::pipeline::solve::Solution;
use crate::engine::problem::{Problem, WorkingMesh};

/// A parameterisation on its working mesh.
#[derive(Clone, Debug)]
pub struct MapOutcome {
    /// Vertices of the working mesh.
    pub positions: Vec<DVec3>,
    /// Triangles of the working mesh.
    pub faces: Vec<[u32; 3]>,
    /// The map.
    pub grid: GridMap,
    /// Grid units per model unit, of the component with the most quads.
    pub scale: f64,
    /// Its singularities.
    pub singularities: Vec<Singularity>,
    /// Its measures.
    pub report: MapReport,
}

/// Joins the maps of the components that have one; `None` if none has. Maps that live on the input come in its order.
pub(super) fn assemble_map(problems: &[Problem], solutions: &[Solution], choice: WorkingMesh) -> Option<MapOutcome> {
    let mut joined = MapOutcome {
        positions: Vec::new(),
        faces: Vec::new(),
        grid: GridMap::default(),
        scale: 0.0,
        singularities: Vec::new(),
        report: MapReport::default(),
    };
    let (mut weight, mut followed, mut searched, mut largest) = (0.0, 0.0, 0.0, 0.0);
    let (mut vertices, mut halfedges) = (Vec::new(), Vec::new());
    for (problem, solution) in problems.iter().zip(solutions) {
        let Some(map) = &solution.map else { continue };
        let mesh = &map.surface.mesh;
        let shift = joined.positions.len() as u32;
        vertices.extend_from_slice(&problem.vertices);
        halfedges.extend_from_slice(&problem.halfedges);
        joined.positions.extend_from_slice(mesh.positions());
        joined.faces.extend(mesh.faces().iter().map(|f| f.map(|v| v + shift)));
        for s in &map.singularities {
            joined.singularities.push(Singularity {
                vertex: s.vertex + shift,
                index_quarters: s.quarters,
                uv: map.grid.uv[mesh.outgoing(s.vertex)].to_array(),
            });
        }
        joined.grid.uv.extend_from_slice(&map.grid.uv);
        joined.grid.rotation.extend_from_slice(&map.grid.rotation);
        joined.grid.translation.extend_from_slice(&map.grid.translation);
        joined.grid.iso.extend_from_slice(&map.grid.iso);
        if problem.quads > largest {
            (largest, joined.scale) = (problem.quads, map.scale);
        }
        let area = mesh.total_area();
        weight += area;
        let report = &mut joined.report;
        report.triangles += mesh.n_faces();
        report.flipped += map.measures.flipped;
        report.seam_residual = report.seam_residual.max(map.measures.seam_residual);
        report.arap_mean += area * map.measures.arap_mean;
        report.conformal_mean += area * map.measures.conformal_mean;
        if let (Some(curl), Some(rounding)) = (map.curl_energy, map.rounding_energy) {
            *report.curl_energy.get_or_insert_default() += area * curl;
            *report.rounding_energy.get_or_insert_default() += area * rounding;
            followed += area;
        }
        if map.details != Data::None {
            report.details.push(map.details.clone());
        }
        let search = &map.branch_search;
        if search.evaluations > 0 {
            let all = report.branch_search.get_or_insert_default();
            searched += area;
            for k in 0..2 {
                all.points[k] += search.points[k];
                all.curl_energy[k] += area * search.energy[k];
            }
            all.evaluations += search.evaluations;
            all.accepted += search.accepted;
        }
    }
    if joined.faces.is_empty() {
        return None;
    }
    let report = &mut joined.report;
    report.arap_mean /= weight;
    report.conformal_mean /= weight;
    for mean in [&mut report.curl_energy, &mut report.rounding_energy].into_iter().flatten() {
        *mean /= followed;
    }
    if let Some(BranchReport { curl_energy, .. }) = &mut report.branch_search {
        curl_energy.iter_mut().for_each(|energy| *energy /= searched);
    }
    // A method may have split the triangles nevertheless; then there is no order to come back to.
    if choice == WorkingMesh::Input && 3 * joined.faces.len() == halfedges.len() {
        joined.put_in_order(&vertices, &halfedges);
    }
    joined.report.singularities = joined.singularities.clone();
    Some(joined)
}

impl MapOutcome {
    /// Puts vertices, faces and their corners into the order of numbers that all of them have elsewhere.
    fn put_in_order(&mut self, vertices: &[u32], halfedges: &[u32]) {
        let by = |numbers: &[u32]| {
            let mut order: Vec<usize> = (0..numbers.len()).collect();
            order.sort_unstable_by_key(|&i| numbers[i]);
            order
        };
        let (of_vertices, of_halfedges) = (by(vertices), by(halfedges));
        let mut rank = vec![0; of_vertices.len()];
        (0..).zip(&of_vertices).for_each(|(new, &old)| rank[old] = new);
        let corner = |h: usize| rank[self.faces[h / 3][h % 3] as usize];
        self.faces = of_halfedges.chunks_exact(3).map(|h| [h[0], h[1], h[2]].map(corner)).collect();
        self.positions = of_vertices.iter().map(|&v| self.positions[v]).collect();
        for singularity in &mut self.singularities {
            singularity.vertex = rank[singularity.vertex as usize];
        }
        let GridMap { uv, rotation, translation, iso } = &mut self.grid;
        *uv = of_halfedges.iter().map(|&h| uv[h]).collect();
        *rotation = of_halfedges.iter().map(|&h| rotation[h]).collect();
        *translation = of_halfedges.iter().map(|&h| translation[h]).collect();
        *iso = of_halfedges.iter().map(|&h| iso[h]).collect();
    }
}
