//! Everything with a socket, a timer or a wire format.

pub mod wire;
