//! One run of the engine: may it go on, how far is it, whose fault is a failure, and what there is to warn of.

mod budget;
mod context;
mod fault;
mod plan;
mod progress;
mod scope;
mod stage;
mod warning;

pub use budget::Budget;
pub use context::{Cancelled, Observer, RunContext, Silent, StopReason};
pub use fault::{Blame, Fault};
pub use plan::Plan;
pub use stage::Stage;
pub use warning::{Warning, WarningKind};
