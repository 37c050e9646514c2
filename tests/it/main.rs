//! The service from outside, over real sockets. `scripted` stands in for the geometry where a test is about the life of
//! jobs; every other test runs the real thing.

mod attributes;
mod bad_meshes;
mod browsers;
mod child;
mod client;
mod command_line;
mod compression;
mod connections;
mod crashes;
mod deadlines;
mod draco;
mod files;
mod harmonic;
mod life;
mod lists;
mod looks;
mod meshes;
mod program;
mod progress;
mod real;
mod refusals;
mod rounding;
mod routes;
mod scripted;
mod server;
mod several;
mod specs;
mod storage;
#[path = "../properties/topology.rs"]
mod topology;
mod toy_method;
mod typical_failures;
