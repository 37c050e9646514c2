//! From a harmonic foliation to an integer-grid map: v is the closed form on the same covering that is nearest to the star
//! of du, so that transitions are `z → ± z + τ` by construction.

use crate::engine::field::{CrossField, Frames};
use crate::engine::mesh::TriMesh;
use crate::engine::methods::holomorphic::differential::{Differential, index};
use crate::engine::methods::holomorphic::error::HolomorphicError;
use crate::engine::parameterize::{GridMap, MapAim, MapSystem, Precision, RoundedIntegers, measure_map};
use crate::engine::run::RunContext;
use crate::engine::topology::Matching;
use glam::DVec2;

/// How far the count may be from the one asked for before the scale is tried again, and how often it is.
const COUNT_TOLERANCE: f64 = 0.02;
const MOST_SCALES: usize = 5;
/// Gradients shorter than this share of their mean count as so long: sizes stay finite at zeros.
const LEAST_LENGTH: f64 = 1e-3;

/// The directions of du and what a map needs to follow them.
pub(super) struct Directions {
    pub(super) frames: Frames,
    pub(super) field: CrossField,
    /// Length of du per face, root mean square 1 over the area.
    pub(super) length: Vec<f64>,
}

impl Directions {
    pub(super) fn new(mesh: &TriMesh, differential: &Differential) -> Self {
        let frames = Frames::new(mesh);
        let form = &differential.form;
        let gradient: Vec<DVec2> = (0..mesh.n_faces())
            .map(|f| {
                // Values relative to the first corner.
                let (b, c) = (form.along[3 * f], -form.along[3 * f + 2]);
                let values = [DVec2::ZERO, DVec2::new(b, 0.0), DVec2::new(c, 0.0)];
                one_gradient(mesh, &frames, f, values)
            })
            .collect();
        let mean = (0..mesh.n_faces()).map(|f| mesh.area(f) * gradient[f].length_squared()).sum::<f64>()
            / mesh.total_area().max(f64::MIN_POSITIVE);
        let unit = mean.sqrt().max(f64::MIN_POSITIVE);
        let signs = &differential.foliation.signs;
        let field = CrossField {
            angle: gradient.iter().map(|g| g.y.atan2(g.x)).collect(),
            matching: Matching::from_owners(mesh, |h| if signs.is_exchanged(h) { 2 } else { 0 }),
            quarter_index: (0..mesh.n_vertices() as u32)
                .map(|v| 2 * index(mesh, &differential.foliation, form, v))
                .collect(),
        };
        Self { frames, field, length: gradient.iter().map(|g| g.length() / unit).collect() }
    }

    /// Frames of the metric in which the foliation's leaves are equally dense.
    pub(super) fn flat_frames(&self, mesh: &TriMesh) -> Frames {
        let (mut log, mut n) = (vec![0.0; mesh.n_vertices()], vec![0.0; mesh.n_vertices()]);
        for f in 0..mesh.n_faces() {
            for v in mesh.face(f) {
                log[v as usize] -= self.length[f].max(LEAST_LENGTH).ln();
                n[v as usize] += 1.0;
            }
        }
        let log_size: Vec<f64> = log.iter().zip(&n).map(|(log, n)| log / f64::max(*n, 1.0)).collect();
        Frames::scaled(mesh, &log_size)
    }

    /// Vertices that lie on integer points.
    pub(super) fn pinned(&self) -> Vec<bool> {
        self.field.quarter_index.iter().map(|&q| q != 0).collect()
    }

    /// The factored system of all maps that follow the directions.
    pub(super) fn system(&self, ctx: &RunContext, mesh: &TriMesh) -> Result<MapSystem, HolomorphicError> {
        let along = |f: usize| {
            let x = DVec2::from_angle(self.field.angle[f]) * self.length[f];
            [x, x.perp()]
        };
        let gradients = Some((0..mesh.n_faces()).map(along).collect());
        let aim = MapAim { weight: vec![1.0; mesh.n_faces()], gradients, precision: Precision::Refined };
        let free = vec![false; mesh.n_halfedges()];
        Ok(MapSystem::new(ctx, mesh, &self.frames, &self.field, &free, &[], aim)?)
    }
}

fn one_gradient(mesh: &TriMesh, frames: &Frames, f: usize, values: [DVec2; 3]) -> DVec2 {
    let (edge, other) = (frames.edge(mesh, 3 * f), -frames.edge(mesh, 3 * f + 2));
    let twice = edge.perp_dot(other).max(f64::MIN_POSITIVE);
    // The vector with these products with the two edges.
    (values[1].x * DVec2::new(other.y, -other.x) + values[2].x * DVec2::new(-edge.y, edge.x)) / twice
}

/// Rounds at the scale of the edge length, then at scales corrected by the area of the map, and keeps the best.
pub(super) fn meet_count(
    ctx: &RunContext,
    mesh: &TriMesh,
    frames: &Frames,
    system: &MapSystem,
    (mut scale, wanted): (f64, f64),
) -> Result<(RoundedIntegers, GridMap), HolomorphicError> {
    let mut best: Option<(f64, RoundedIntegers, GridMap)> = None;
    for _ in 0..MOST_SCALES {
        let rounded = system.round(&ctx.attempt(0.4), mesh, scale)?;
        let grid = system.map(mesh, &rounded)?;
        let area = measure_map(mesh, frames, &grid, scale).grid_area.max(1.0);
        let off = (area / wanted).ln().abs();
        if best.as_ref().is_none_or(|b| off < b.0) {
            best = Some((off, rounded, grid));
        }
        if off < COUNT_TOLERANCE {
            break;
        }
        scale *= (wanted / area).sqrt().clamp(0.5, 2.0);
    }
    best.map(|(_, rounded, grid)| (rounded, grid)).ok_or(HolomorphicError::NoScale)
}
