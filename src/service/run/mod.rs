//! One run from bytes to certified files, for the command line and for workers alike.
//!
//! Read → engine → write → read again → certificate → report. The engine has no clock: the deadline is a timer thread
//! that stops the run, and the seconds of every stage are taken by an observer.

mod accept;
mod check;
mod deadline;
mod driver;
mod execute;
mod inspect;
mod memory;
mod stage_clock;

pub use check::{CertificateBody, check_quads};
pub use driver::EngineDriver;
pub use execute::{Input, Products, Wanted, execute, read_limits};
pub use inspect::{ContentsBody, ImageBody, InspectionBody, SurfaceBody, inspect_file};
