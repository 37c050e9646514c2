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
}

/// What of the features a sure method is to follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Keep {
    All,
    None,
}

/// The sure methods, best first.
const SURE: [Sure; 6] = [
    Sure { method: &TrianglePairs, fidelity: "strict", features: Keep::All },
    Sure { method: &TrianglePairs, fidelity: "loose", features: Keep::None },
    Sure { method: &TrianglePairs, fidelity: "strict", features: Keep::None },
    Sure { method: &TriangleSplit, fidelity: "strict", features: Keep::None },
    Sure { method: &TriangleSplit, fidelity: "exact", features: Keep::All },
    Sure { method: &TriangleSplit, fidelity: "exact", features: Keep::None },
];
/// The sure method for when there is no time left.
const AT_THE_DEADLINE: Sure = Sure { method: &TriangleSplit, fidelity: "strict", features: Keep::All };
/// So many of them stand by while something takes long.
pub(super) const STANDBY: usize = 2;
/// A sure method gets smaller quads where it failed until they are of this size, relative to the edge length.
const SMALLEST: f64 = 1.0 / 32.0;

/// The sure methods for a component, each once: where there are no features that may be given up, those that follow none
/// follow all.
pub(super) fn sure_methods(whole: &Problem, may_give_up: bool) -> Vec<Sure> {
    each_once(&SURE, whole, may_give_up)
}

/// The sure methods for a component when there is no time left.
pub(super) fn at_the_deadline(whole: &Problem, may_give_up: bool) -> Vec<Sure> {
    let rows = [Keep::All, Keep::None].map(|features| Sure { features, ..AT_THE_DEADLINE });
    each_once(&rows, whole, may_give_up)
}

fn each_once(rows: &[Sure], whole: &Problem, may_give_up: bool) -> Vec<Sure> {
    let gives_up = may_give_up && !whole.surface.features.edges.is_empty();
    let mut found: Vec<Sure> = Vec::new();
    for row in rows {
        let row = Sure { features: if gives_up { row.features } else { Keep::All }, ..*row };
        let is_same = |other: &Sure| {
            let key = |sure: &Sure| (sure.method.name(), sure.fidelity, sure.features);
            key(other) == key(&row)
        };
        if !found.iter().any(is_same) {
            found.push(row);
        }
    }
    found
}

impl Sure {
    /// The attempt at a component.
    pub(super) fn attempt(&self, whole: &Problem) -> Attempt {
        let without = if self.features == Keep::None { whole.without_features() } else { None };
        let mut problem = without.unwrap_or_else(|| whole.clone());
        problem.wishes.boundary = Boundary::Align;
        let mut parameters = Parameters::default();
        let is_known = parameters.set(self.method.parameters(), "fidelity", Value::Choice(self.fidelity));
        debug_assert!(is_known);
        Attempt { method: MethodRef(self.method), parameters, problem, change: self.change() }
    }

    fn change(&self) -> &'static str {
        match (self.fidelity, self.features) {
            ("exact", Keep::All) => "of the input",
            ("exact", Keep::None) => "of the input without features",
            ("loose", Keep::All) => "of a loose remesh",
            ("loose", Keep::None) => "of a loose remesh without features",
            (_, Keep::All) => "of a remesh",
            (_, Keep::None) => "of a remesh without features",
        }
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
