//! The whole service in one process: store, queue, worker, HTTP, and their orderly end.

mod error;
mod running;
mod start;

pub use error::AppError;
pub use running::Running;
pub use start::{Role, start, start_with};
