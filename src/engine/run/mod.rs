//! One run of the engine: may it go on, how far is it, and whose fault is a failure.

mod context;
mod fault;

pub use context::{Cancelled, Observer, RunContext, Silent, Stage, StopReason};
pub use fault::{Blame, Fault};
