//! The only error that a caller of the engine sees.

use crate::engine::field::GivenFieldError;
use crate::engine::mesh::condition::ConditionError;
use crate::engine::run::Blame;
use crate::engine::run::Cancelled;
use crate::engine::run::Fault;
use crate::engine::run::Stage;

/// A run ended without quads.
#[derive(Clone, Debug, thiserror::Error)]
pub enum RemeshError {
    /// The input cannot be conditioned.
    #[error(transparent)]
    Condition(ConditionError),
    /// The run was stopped.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The deadline passed while a component had no certified quads yet.
    #[error("{stop}; tried for component {component}: {causes}")]
    DeadlineExceeded {
        /// Index of the component; components are ordered by their lowest face index.
        component: usize,
        /// What was tried, and why it failed.
        causes: String,
        /// The reason of the stop.
        stop: Cancelled,
    },
    /// The target edge length would give more quads than the limit.
    #[error("a target edge length of {edge_length} asks for about {quads:.0} quads; the limit is {limit:.0}")]
    TooManyQuads {
        /// The edge length asked for, model units.
        edge_length: f64,
        /// Quads that it amounts to.
        quads: f64,
        /// The limit.
        limit: f64,
    },
    /// A given field does not fit the input.
    #[error(transparent)]
    Field(#[from] GivenFieldError),
    /// Exact symmetry was asked for, and the model has none.
    #[error("the model is not symmetric in {axis}: {cause}; leave symmetry out, or give a model that is")]
    NotSymmetric {
        /// The normal of the mirror plane: the name of a coordinate axis, or a vector.
        axis: String,
        /// Why the model is not symmetric.
        cause: String,
    },
    /// The quads of all components together do not pass the certificate.
    #[error("the quads did not pass the certificate: {cause}")]
    NotCertified {
        /// All violations.
        cause: String,
    },
    /// No attempt for this component gave quads that pass the certificate.
    #[error("no certified quads were found for component {component}: {cause}")]
    NoQuads {
        /// Index of the component; components are ordered by their lowest face index.
        component: usize,
        /// What was tried, and why it failed.
        cause: String,
    },
}

impl From<ConditionError> for RemeshError {
    fn from(e: ConditionError) -> Self {
        if let ConditionError::Cancelled(c) = e { Self::Cancelled(c) } else { Self::Condition(e) }
    }
}

impl RemeshError {
    /// The stage that failed.
    pub fn stage(&self) -> Stage {
        match self {
            Self::Condition(_) | Self::Field(_) | Self::NotSymmetric { .. } => Stage::Condition,
            Self::Cancelled(_) | Self::DeadlineExceeded { .. } | Self::TooManyQuads { .. } => Stage::Refine,
            Self::NoQuads { .. } | Self::NotCertified { .. } => Stage::Certify,
        }
    }
}

impl Blame for RemeshError {
    fn fault(&self) -> Fault {
        match self {
            Self::Condition(e) => e.fault(),
            Self::Field(e) => e.fault(),
            Self::Cancelled(_) | Self::DeadlineExceeded { .. } => Fault::Cancelled,
            Self::TooManyQuads { .. } => Fault::Limit,
            Self::NoQuads { .. } | Self::NotCertified { .. } | Self::NotSymmetric { .. } => Fault::Unsatisfiable,
        }
    }

    fn tried(&self) -> Option<String> {
        match self {
            Self::DeadlineExceeded { component, causes, .. } => Some(format!("component {component}: {causes}")),
            _ => None,
        }
    }

    fn spec_field(&self) -> &'static str {
        if let Self::Field(e) = self { e.spec_field() } else { "" }
    }

    fn elements(&self) -> Vec<u64> {
        match self {
            Self::Condition(e) => e.elements(),
            Self::Field(e) => e.elements(),
            _ => Vec::new(),
        }
    }
}
