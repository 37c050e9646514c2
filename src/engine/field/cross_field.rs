//! A cross per face and what follows from it: matching and singularities.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use faer::c64;
use rayon::prelude::*;

use crate::engine::field::frames::Frames;
use crate::engine::mesh::TriMesh;
use crate::engine::mesh::prev;
use crate::engine::numerics::SolveError;
use crate::engine::run::Cancelled;
use crate::engine::topology::Matching;
use crate::engine::topology::Singularity;

/// No cross field was found.
#[derive(Clone, Debug, thiserror::Error)]
pub enum FieldError {
    /// The run was stopped.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A linear solve failed.
    #[error("the cross field could not be solved for: {0}")]
    Solve(#[from] SolveError),
}

/// A cross per face, as the angle of one of its four directions in the frame of the face.
#[derive(Clone, Debug)]
pub struct CrossField {
    /// Angle per face, radians; only its value modulo a quarter turn means anything.
    pub angle: Vec<f64>,
    /// Rotation across each halfedge.
    pub matching: Matching,
    /// Index in quarters per vertex; 0 at boundary vertices.
    pub quarter_index: Vec<i32>,
}

impl CrossField {
    /// Matches each cross to its neighbours by the smallest turn (docs/methods/quadcover.md, 1) and finds the singularities.
    pub fn from_angles(mesh: &TriMesh, frames: &Frames, angle: Vec<f64>) -> Self {
        let matching = Matching::from_owners(mesh, |h| {
            let t = mesh.twin(h).map_or(h, |t| t);
            let turn = angle[h / 3] + frames.transport(mesh, h) - angle[t / 3];
            -(turn / FRAC_PI_2).round() as i32
        });
        let quarter_index = indices(mesh, frames, &angle, &matching);
        Self { angle, matching, quarter_index }
    }

    /// Finds the singularities again after the matching was changed.
    pub(super) fn update_indices(&mut self, mesh: &TriMesh, frames: &Frames) {
        self.quarter_index = indices(mesh, frames, &self.angle, &self.matching);
    }

    /// The singular interior vertices in index order.
    pub fn singularities(&self) -> Vec<Singularity> {
        (0..self.quarter_index.len() as u32)
            .map(|vertex| Singularity { vertex, quarters: self.quarter_index[vertex as usize] })
            .filter(|s| s.quarters != 0)
            .collect()
    }
}

/// The complex number of length 1 at this angle. In the linear systems a cross is that of four times its angle.
pub(super) fn unit(angle: f64) -> c64 {
    c64::new(angle.cos(), angle.sin())
}

fn indices(mesh: &TriMesh, frames: &Frames, angle: &[f64], matching: &Matching) -> Vec<i32> {
    (0..mesh.n_vertices() as u32)
        .into_par_iter()
        .map(|v| if mesh.is_boundary_vertex(v) { 0 } else { index(mesh, frames, angle, matching, v) })
        .collect()
}

/// How far the cross of the halfedge's face turns, from the cross of the twin's face, after transport and matching;
/// in (−π, π].
#[inline]
pub(super) fn residual(mesh: &TriMesh, frames: &Frames, angle: &[f64], matching: &Matching, h: usize) -> f64 {
    let Some(t) = mesh.twin(h) else { return 0.0 };
    let turn = angle[h / 3] + frames.transport(mesh, h) - angle[t / 3] + f64::from(matching.across(h)) * FRAC_PI_2;
    turn - TAU * (turn / TAU).round()
}

/// `4 (Ω − Σ r) / 2π`, the sum taken counter-clockwise around an interior vertex.
fn index(mesh: &TriMesh, frames: &Frames, angle: &[f64], matching: &Matching, v: u32) -> i32 {
    let mut defect = TAU;
    for h in mesh.fan(v) {
        let incoming = prev(h);
        let corner = PI - (frames.angle[h] - frames.angle[incoming]).rem_euclid(TAU);
        defect -= corner;
        defect -= residual(mesh, frames, angle, matching, incoming);
    }
    (defect / FRAC_PI_2).round() as i32
}
