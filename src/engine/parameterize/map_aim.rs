//! What a map is to be like, face by face.

use std::f64::consts::FRAC_PI_2;

use glam::DVec2;

/// The gradients that a map should have and how closely it is to have them.
#[derive(Clone, Debug)]
pub struct MapAim {
    /// Weight per face, positive.
    pub weight: Vec<f64>,
    /// Per face the gradients of u and v at scale 1, in the frame of the face and the chart of the cross field, the second
    /// counter-clockwise of the first; `None` where both have length 1 along the crosses.
    pub gradients: Option<Vec<[DVec2; 2]>>,
    /// How exactly the map is to be the projection of these gradients.
    pub precision: Precision,
}

/// How exactly a map is to be a projection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// To what the regularised period matrix leaves, about 1e-9. Integers are rounded afterwards.
    Usual,
    /// To about 1e-12, by one more step with the residual of the whole system.
    Refined,
}

impl From<Vec<f64>> for MapAim {
    /// Unit crosses with these weights.
    fn from(weight: Vec<f64>) -> Self {
        Self { weight, gradients: None, precision: Precision::Usual }
    }
}

impl MapAim {
    /// The gradients in combed charts, whose directions are `quarters` turns behind those of the cross field.
    pub(super) fn combed(&self, angle: &[f64], quarters: &[u8]) -> Vec<[DVec2; 2]> {
        let combed = |f: usize| match &self.gradients {
            None => {
                let x = DVec2::from_angle(angle[f] - f64::from(quarters[f]) * FRAC_PI_2);
                [x, x.perp()]
            }
            Some(gradients) => {
                let [x, y] = gradients[f];
                match quarters[f] & 3 {
                    0 => [x, y],
                    1 => [-y, x],
                    2 => [-x, -y],
                    _ => [y, -x],
                }
            }
        };
        (0..angle.len()).map(combed).collect()
    }
}
