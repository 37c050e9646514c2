//! Quadrille: a triangle mesh in, a parameterisation and a certified pure quad mesh out.
//!
//! Two halves. [`engine`] is pure, synchronous, deterministic geometry: it knows no file, no clock, no environment, no
//! network and no JSON. `service` (cargo feature `service`, on by default) is everything with a socket, a timer or a
//! wire format. Start reading at [`engine::pipeline::remesh`], the list of stages of one run; `ARCHITECTURE.md` has the
//! floor plan and follows one request from its upload to its results.

pub mod engine;
#[cfg(feature = "service")]
pub mod service;
