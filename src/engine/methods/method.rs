//! What a method is.

use std::fmt::Debug;

use crate::engine::methods::{Level, MapProduct, Parameter, Parameters, Product};
use crate::engine::problem::Problem;
use crate::engine::run::{Cancelled, RunContext, Stage};

/// A system that proposes quads for one component.
pub trait Method: Debug + Sync {
    /// Its name in a spec, stable.
    fn name(&self) -> &'static str;

    /// What it does, in one sentence.
    fn summary(&self) -> &'static str;

    /// What it cannot do in this version.
    fn cannot(&self) -> &'static [&'static str] {
        &[]
    }

    /// Its own parameters.
    fn parameters(&self) -> &'static [Parameter] {
        &[]
    }

    /// Whether its quads follow the strokes of a problem; otherwise a warning says that they do not.
    fn follows_strokes(&self) -> bool {
        false
    }

    /// The same for a given field.
    fn follows_fields(&self) -> bool {
        false
    }

    /// Where reports say that its quads come from.
    fn level(&self) -> Level;

    /// The stages that a proposal goes through, from which its share of the progress and its predicted cost follow.
    fn stages(&self) -> &'static [Stage];

    /// Proposes something that quads can be made of. Parameters are in their ranges.
    ///
    /// # Errors
    /// [`MethodError`]; the caller then tries something else.
    fn propose(&self, ctx: &RunContext, problem: &Problem, parameters: &Parameters) -> Result<Product, MethodError>;
}

/// A method has nothing to propose.
#[derive(Clone, Debug, thiserror::Error)]
pub enum MethodError {
    /// The run was stopped.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// There is nothing that quads can be made of.
    #[error("{cause}")]
    Nothing {
        /// What failed.
        cause: String,
        /// The map, where one was made: worth reporting though there are no quads.
        map: Option<Box<MapProduct>>,
    },
    /// What its parameters ask for cannot be: no other attempt is made.
    #[error("{cause}")]
    Refused {
        /// What is wrong, and where.
        cause: String,
    },
}
