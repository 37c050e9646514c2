//! From an accepted job to its ending: the queue, the worker, progress, cancellation, expiry.
//!
//! ```text
//! Jobs::submit ─ row + ticket in one transaction ─► TicketQueue ─► Worker ─► Driver (engine pool) ─► Store::finish
//!                                                       ▲            │ Recorder: stage, progress, cancel flag
//!                                                       └─ shutdown, failing storage: row + new ticket
//! ```

mod driver;
mod ending;
mod engine_pool;
mod in_work;
mod live;
mod queue;
#[cfg(test)]
mod queue_tests;
mod recorder;
mod storage_retry;
mod submissions;
mod sweep;
mod worker;

pub use driver::{Driver, InputFile, Inspection, Made, Products};
pub use engine_pool::{EnginePool, run_blocking};
pub use live::{Live, Running};
pub use queue::{Handler, SqliteQueue, Ticket, TicketQueue};
pub use submissions::{Accepted, JobMesh, JobRequest, Jobs};
pub use sweep::sweep_until;
pub use worker::Worker;
pub(in crate::service) use worker::hex;
