//! What always gives quads, at any price in regularity: it stands by while something better is tried, and is delivered where
//! nothing better comes.

use glam::DVec3;

use crate::engine::methods::{Method, MethodRef, Parameters, TrianglePairs, TriangleSplit, Value};
use crate::engine::pipeline::attempt::Attempt;
use crate::engine::problem::{Boundary, Problem};

/// A method that needs nothing but a valid surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sure {
    pub(super) method: &'static dyn Method,
    pub(super) fidelity: &'static str,
    pub(super) features: Keep,
    pub(super) change: &'static str,
}

/// What of the features a sure method is to follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Keep {
    All,
    None,
}

/// The sure methods, best first.
pub(super) const SURE: [Sure; 6] = [
    Sure { method: &TrianglePairs, fidelity: "strict", features: Keep::All, change: "of a remesh" },
    Sure { method: &TrianglePairs, fidelity: "loose", features: Keep::None, change: "without features, loosely" },
    Sure { method: &TrianglePairs, fidelity: "strict", features: Keep::None, change: "without features" },
    Sure { method: &TriangleSplit, fidelity: "strict", features: Keep::None, change: "without features" },
    Sure { method: &TriangleSplit, fidelity: "exact", features: Keep::All, change: "of the input" },
    Sure { method: &TriangleSplit, fidelity: "exact", features: Keep::None, change: "of the input without features" },
];
/// The sure method for when there is no time left.
pub(super) const AT_THE_DEADLINE: &Sure =
    &Sure { method: &TriangleSplit, fidelity: "strict", features: Keep::All, change: "at the deadline" };
/// So many of them stand by while something takes long.
pub(super) const STANDBY: usize = 2;
/// A sure method gets smaller quads where it failed until they are of this size, relative to the edge length.
const SMALLEST: f64 = 1.0 / 32.0;

impl Sure {
    /// The attempt, if there is anything to give up that may be.
    pub(super) fn attempt(&self, whole: &Problem, may_give_up: bool) -> Option<Attempt> {
        let mut problem = match self.features {
            Keep::All => whole.clone(),
            Keep::None => whole.without_features().filter(|_| may_give_up)?,
        };
        problem.wishes.boundary = Boundary::Align;
        let mut parameters = Parameters::default();
        let is_known = parameters.set(self.method.parameters(), "fidelity", Value::Choice(self.fidelity));
        debug_assert!(is_known);
        Some(Attempt { method: MethodRef(self.method), parameters, problem, change: self.change })
    }

    /// Whether it takes the triangles of the input, however many they are.
    pub(super) fn is_exact(&self) -> bool {
        self.fidelity == "exact"
    }

    /// The attempt again with quads half as large where it failed; nothing if they are as small as can be, or if the
    /// method takes the triangles of the input.
    pub(super) fn again(&self, attempt: &Attempt, failed: &[DVec3]) -> Option<Attempt> {
        let problem = attempt.problem.halved_at(failed, SMALLEST).filter(|_| !self.is_exact())?;
        Some(Attempt { problem, ..attempt.clone() })
    }
}
