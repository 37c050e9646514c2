//! Mirror planes, and the frame in which they lie across the axes: a plane in any direction is one across an axis of the
//! turned model.

use glam::{DMat3, DVec3};

use crate::engine::mesh::{Surface, TriMesh};

/// The points p with `p · normal = offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorPlane {
    /// A unit vector, towards the side that is kept and mirrored.
    pub normal: DVec3,
    /// Distance of the plane from the origin along the normal, model units.
    pub offset: f64,
}

impl MirrorPlane {
    /// The coordinate axis, 0 to 2, that is its normal; `None` if none is.
    pub fn axis(&self) -> Option<usize> {
        (0..3).find(|&axis| self.normal == DVec3::AXES[axis])
    }

    /// The mirror image of a point.
    pub fn image(&self, p: DVec3) -> DVec3 {
        p - 2.0 * (p.dot(self.normal) - self.offset) * self.normal
    }
}

/// A plane across an axis of the frame.
#[derive(Clone, Copy, Debug)]
pub(in crate::engine::pipeline) struct AxisPlane {
    /// 0, 1 or 2.
    pub(super) axis: usize,
    /// Where it is on the axis; to be found at the origin or in the middle of the model if that is not known.
    pub(super) at: Option<f64>,
}

/// Planes at right angles to each other, and the frame whose axes are their normals.
#[derive(Clone, Debug)]
pub(in crate::engine::pipeline) struct Planes {
    /// The rotation from the model into the frame; none if the axes are the model's.
    turn: Option<DMat3>,
    /// The planes in the frame.
    pub(super) planes: Vec<AxisPlane>,
}

impl Planes {
    /// Planes across coordinate axes (0 to 2, each at most once), which are to be found.
    pub(in crate::engine::pipeline) fn across(axes: &[usize]) -> Self {
        Self { turn: None, planes: axes.iter().map(|&axis| AxisPlane { axis, at: None }).collect() }
    }

    /// Known planes, at most three and at right angles to each other.
    pub(in crate::engine::pipeline) fn known(planes: &[MirrorPlane]) -> Self {
        let of_axis = |plane: &MirrorPlane| plane.axis().map(|axis| AxisPlane { axis, at: Some(plane.offset) });
        if let Some(planes) = planes.iter().map(of_axis).collect() {
            return Self { turn: None, planes };
        }
        let first = planes[0].normal;
        let second = match planes.get(1) {
            Some(plane) => plane.normal.reject_from_normalized(first).normalize(),
            None => first.any_orthonormal_vector(),
        };
        // A third plane may have either side; that which is kept is the one of larger coordinates in the frame.
        let third = first.cross(second);
        let offset = |k: usize| match planes.get(k) {
            Some(plane) if k == 2 && plane.normal.dot(third) < 0.0 => -plane.offset,
            Some(plane) => plane.offset,
            None => 0.0,
        };
        let planes = (0..planes.len().min(3)).map(|axis| AxisPlane { axis, at: Some(offset(axis)) }).collect();
        Self { turn: Some(DMat3::from_cols(first, second, third).transpose()), planes }
    }

    /// The rotation from the model into the frame, if it is another.
    pub(in crate::engine::pipeline) fn turn(&self) -> Option<DMat3> {
        self.turn
    }

    /// A plane of the frame, in the model.
    pub(super) fn in_model(&self, axis: usize, at: f64) -> MirrorPlane {
        let normal = self.turn.map_or(DVec3::AXES[axis], |turn| turn.row(axis));
        MirrorPlane { normal, offset: at }
    }
}

/// A surface with its points moved by a rotation.
pub(in crate::engine::pipeline) fn turned(surface: &Surface, turn: DMat3) -> Surface {
    let positions = surface.mesh.positions().iter().map(|&p| turn * p).collect();
    let mesh = TriMesh::try_new(positions, surface.mesh.faces().to_vec()).expect("a turned manifold is a manifold");
    Surface { mesh, features: surface.features.clone() }
}
