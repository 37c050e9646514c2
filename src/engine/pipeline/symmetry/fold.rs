//! From the whole to its half, quarter or eighth.

use glam::DVec3;

use crate::engine::mesh::{Surface, SurfaceIndex, TriMesh};
use crate::engine::pipeline::error::RemeshError;
use crate::engine::pipeline::symmetry::halve::{Half, halve};
use crate::engine::pipeline::symmetry::mirror::Mirror;
use crate::engine::pipeline::symmetry::planes::{AxisPlane, MirrorPlane, Planes};
use crate::engine::pipeline::symmetry::unfold::{Unfolding, unfold_surface};
use crate::engine::run::{Cancelled, RunContext, Warning, WarningKind};

/// Models whose image is further from them than this part of their diagonal are refused.
pub(in crate::engine::pipeline) const MOST: f64 = 0.05;
/// From this part on it is worth a warning.
const WORTH_A_WARNING: f64 = 0.001;
/// The middle of the model is the plane only if it agrees this much better than the origin, as a part of the diagonal.
const BETTER: f64 = 0.001;

/// A part of a surface of which all others are images.
pub(in crate::engine::pipeline) struct Fold {
    /// The part.
    pub(in crate::engine::pipeline) surface: Surface,
    /// Its sizes per vertex, empty if all quads are to be alike.
    pub(in crate::engine::pipeline) log_size: Vec<f64>,
    /// How to come back: the last plane first.
    pub(in crate::engine::pipeline) unfoldings: Vec<Unfolding>,
    /// The planes, in the model.
    pub(in crate::engine::pipeline) planes: Vec<MirrorPlane>,
}

/// Folds a surface, which is in the frame of the planes, at them. What is worth knowing is added to the warnings; `min_length` is that
/// of the feature detection.
///
/// # Errors
/// [`RemeshError::NotSymmetric`]; [`RemeshError::Cancelled`].
pub(in crate::engine::pipeline) fn fold(
    ctx: &RunContext,
    whole: &Surface,
    log_size: &[f64],
    planes: &Planes,
    min_length: f64,
    warnings: &mut Vec<Warning>,
) -> Result<Fold, RemeshError> {
    let mut part = Half { surface: whole.clone(), log_size: log_size.to_vec(), on_planes: Vec::new() };
    let mut mirrors = Vec::new();
    for &AxisPlane { axis, at } in &planes.planes {
        let (mirror, away) = plane(ctx, &whole.mesh, axis, at)?;
        let name = name_of(&planes.in_model(axis, mirror.at));
        let refused = |cause: String| RemeshError::NotSymmetric { axis: name.clone(), cause };
        if away > MOST {
            return Err(refused(format!(
                "its mirror image is up to {:.1} % of the diagonal away from it",
                100.0 * away
            )));
        }
        if away > WORTH_A_WARNING {
            warnings.push(WarningKind::SymmetryDeviation { percent: 100.0 * away, axis: name.clone() }.into());
        }
        let half = halve(&part, mirror, min_length)
            .ok_or_else(|| refused(format!("the plane {name} = {} does not cut it in two halves", mirror.at)))?;
        let again = unfold_surface(&half.surface, &[Unfolding { mirror, on_plane: Vec::new() }]);
        if again.map(|again| again.mesh.topology()) != Some(part.surface.mesh.topology()) {
            return Err(refused(format!("the two halves at {name} = {} are not alike", mirror.at)));
        }
        part = half;
        mirrors.push(mirror);
    }
    let Half { surface, log_size, on_planes } = part;
    let in_model = mirrors.iter().map(|mirror| planes.in_model(mirror.axis, mirror.at)).collect();
    let unfoldings = mirrors.into_iter().zip(on_planes).rev();
    let unfoldings = unfoldings.map(|(mirror, on_plane)| Unfolding { mirror, on_plane }).collect();
    Ok(Fold { surface, log_size, unfoldings, planes: in_model })
}

/// The direction of a plane's normal, for people.
fn name_of(plane: &MirrorPlane) -> String {
    let [x, y, z] = plane.normal.to_array();
    plane.axis().map_or_else(|| format!("({x:.3}, {y:.3}, {z:.3})"), |axis| ["x", "y", "z"][axis].to_owned())
}

/// The plane across an axis, where it is known or where it agrees with the model, and how far the model's image is from it
/// there, in diagonals.
fn plane(ctx: &RunContext, mesh: &TriMesh, axis: usize, at: Option<f64>) -> Result<(Mirror, f64), Cancelled> {
    let lo = mesh.positions().iter().copied().reduce(DVec3::min).unwrap_or_default();
    let hi = mesh.positions().iter().copied().reduce(DVec3::max).unwrap_or_default();
    let bounds = [lo, hi];
    let diagonal = (hi - lo).length();
    let index = SurfaceIndex::new(mesh);
    let away = |mirror: Mirror| {
        let mut away: f64 = 0.0;
        for (v, &p) in mesh.positions().iter().enumerate() {
            if v % 4096 == 0 {
                ctx.check()?;
            }
            away = away.max(index.closest(mirror.image(p)).distance);
        }
        Ok::<_, Cancelled>(away / diagonal)
    };
    if let Some(at) = at {
        let known = Mirror::new(axis, at, bounds);
        return Ok((known, away(known)?));
    }
    let middle = 0.5 * (lo[axis] + hi[axis]);
    let [origin, middle] = [0.0, middle].map(|at| Mirror::new(axis, at, bounds));
    // Where the origin is outside there is nothing to compare.
    let by_origin = if lo[axis] < 0.0 && hi[axis] > 0.0 { away(origin)? } else { f64::INFINITY };
    if by_origin <= BETTER {
        return Ok((origin, by_origin));
    }
    let by_middle = away(middle)?;
    Ok(if by_origin <= by_middle + BETTER { (origin, by_origin) } else { (middle, by_middle) })
}
