//! The door: a grid map in, quads out.

use crate::engine::mesh::Features;
use crate::engine::mesh::TriMesh;
use crate::engine::parameterize::GridMap;
use crate::engine::quad::QuadDraft;
use crate::engine::quad::extract::error::ExtractError;
use crate::engine::quad::extract::exact_map::{BoundaryInGrid, ExactMap};
use crate::engine::quad::extract::grid_graph::features_off_grid;
use crate::engine::quad::extract::grid_graph::{PortOut, grid_graph};
use crate::engine::quad::extract::nodes::Nodes;
use crate::engine::quad::fill::FillReport;
use crate::engine::quad::fill::complete;
use crate::engine::quad::fill::{BoundaryLoop, Exit, add_boundary_strips};
use crate::engine::run::RunContext;

/// Quads of a map, and what was wrong with the map.
#[derive(Clone, Debug, Default)]
pub struct Extraction {
    /// A pure quad manifold with the topology of the mesh.
    pub draft: QuadDraft,
    /// What was found and repaired.
    pub report: ExtractionReport,
}

/// What an extraction found and repaired.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExtractionReport {
    /// Triangles whose orientation the map reverses.
    pub flipped_triangles: usize,
    /// Triangles without area in the map.
    pub degenerate_triangles: usize,
    /// Largest gap of the map at a seam, grid units.
    pub seam_residual: f64,
    /// Largest move of a coordinate that had to become an integer, grid units.
    pub snap_residual: f64,
    /// Interior feature edges that the map does not put on a grid line: these features are not in the result.
    pub features_off_grid: usize,
    /// Grid points on the surface, copies by folds included.
    pub grid_points: usize,
    /// What was repaired to come to quads.
    pub fill: FillReport,
}

/// Extracts the quads of `map`, an integer-grid map of one connected component with some triangles flipped or without
/// area. Corners of `features` become quad vertices (`Anchor::Corner`, numbered as in `mesh`), feature curves and the
/// boundary become chains of quad edges. Linear in the size of mesh and result for maps with few defects.
///
/// A square of two triangles, as 2 by 2 cells of the grid:
///
/// ```
/// use glam::{DVec2, I64Vec2};
/// use quadrille::engine::mesh::{Features, TriMesh};
/// use quadrille::engine::{parameterize::{GridMap, Iso}, quad::extract::extract_quads, run::RunContext};
///
/// let (corners, faces) = ([DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y], [[0, 1, 2], [0, 2, 3]]);
/// let mesh = TriMesh::try_new(corners.map(|p| p.extend(0.0)).to_vec(), faces.to_vec())?;
/// let uv = faces.iter().flatten().map(|&v| 2.0 * corners[v as usize]).collect();
/// let iso = vec![Iso::V, Iso::U, Iso::None, Iso::None, Iso::V, Iso::U];
/// let map = GridMap { uv, rotation: vec![0; 6], translation: vec![I64Vec2::ZERO; 6], iso };
/// let features = Features { edges: Vec::new(), corners: vec![0, 1, 2, 3] };
/// let extraction = extract_quads(&RunContext::silent(), &mesh, &features, &map)?;
/// assert_eq!(extraction.draft.mesh.quads.len(), 4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ExtractError`]; whatever is returned without error is an oriented pure quad manifold with the components,
/// boundary loops and Euler characteristic of `mesh`.
pub fn extract_quads(
    ctx: &RunContext,
    mesh: &TriMesh,
    features: &Features,
    map: &GridMap,
) -> Result<Extraction, ExtractError> {
    extract(ctx, mesh, features, map, BoundaryInGrid::OnLines)
}

/// As [`extract_quads`] for a map whose boundary lies anywhere in the grid: the cells that lie inside as a whole, and a
/// row of quads between them and each boundary loop.
///
/// # Errors
/// [`ExtractError`]; `Unrepairable` also where no row of quads has room.
pub fn extract_inner_quads(
    ctx: &RunContext,
    mesh: &TriMesh,
    features: &Features,
    map: &GridMap,
) -> Result<Extraction, ExtractError> {
    extract(ctx, mesh, features, map, BoundaryInGrid::Anywhere)
}

fn extract(
    ctx: &RunContext,
    mesh: &TriMesh,
    features: &Features,
    map: &GridMap,
    boundary: BoundaryInGrid,
) -> Result<Extraction, ExtractError> {
    let exact = ExactMap::new(mesh, features, map, boundary)?;
    let orientations = (0..mesh.n_faces()).map(|f| exact.orientation(f).signum());
    let (mut flipped_triangles, mut degenerate_triangles) = (0, 0);
    for sign in orientations {
        flipped_triangles += usize::from(sign < 0);
        degenerate_triangles += usize::from(sign == 0);
    }
    let nodes = Nodes::new(&exact);
    let (mut graph, out) = grid_graph(ctx, &exact, features, &nodes)?;
    if boundary == BoundaryInGrid::Anywhere {
        let (exits, loops) = exits(mesh, features, &out);
        add_boundary_strips(ctx, &mut graph, &exits, &loops)?;
    }
    let (draft, fill) = complete(ctx, graph, &mesh.topology())?;
    let report = ExtractionReport {
        flipped_triangles,
        degenerate_triangles,
        seam_residual: exact.seam_residual,
        snap_residual: exact.snap_residual,
        features_off_grid: features_off_grid(&exact, features),
        grid_points: nodes.nodes.len(),
        fill,
    };
    Ok(Extraction { draft, report })
}

/// The boundary loops as seen from outside, and which grid lines end at them.
fn exits(mesh: &TriMesh, features: &Features, out: &[PortOut]) -> (Vec<Exit>, Vec<BoundaryLoop>) {
    let mut place = vec![(0, 0); mesh.n_halfedges()];
    let mut loops = Vec::new();
    for (loop_number, mut halfedges) in mesh.boundary_loops().into_iter().enumerate() {
        halfedges.reverse();
        halfedges.iter().enumerate().for_each(|(i, &h)| place[h] = (loop_number, i));
        let vertices = || halfedges.iter().map(|&h| mesh.origin(h));
        loops.push(BoundaryLoop {
            points: vertices().map(|v| mesh.position(v)).collect(),
            corner: vertices().map(|v| features.is_corner(v).then_some(v)).collect(),
        });
    }
    let exit = |out: &PortOut| {
        let (loop_number, point) = place[out.halfedge];
        Exit { before: out.before, loop_number, end: out.is_feature.then_some(point) }
    };
    (out.iter().map(exit).collect(), loops)
}
