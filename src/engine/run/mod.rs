//! One run of the engine: may it go on, how far is it, whose fault is a failure, and what there is to warn of.

mod context;
mod fault;
mod warning;

pub use context::{Cancelled, Observer, RunContext, Silent, Stage, StopReason};
pub use fault::{Blame, Fault};
pub use warning::{Warning, WarningKind};
