//! Whose fault a failure is. The engine knows no status codes: the service maps faults to them in one table.

/// The kind of a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The input cannot be used; another input can.
    Input,
    /// What the request says of the input does not fit it.
    Request,
    /// The request cannot be met on this input.
    Unsatisfiable,
    /// A limit on size or memory was reached.
    Limit,
    /// The run was stopped.
    Cancelled,
    /// A bug of ours.
    Internal,
}

/// Errors that know whose fault they are.
pub trait Blame: std::error::Error {
    /// Whose fault it is.
    fn fault(&self) -> Fault;
    /// What was tried before a run was stopped, and why it failed.
    fn tried(&self) -> Option<String> {
        None
    }
    /// The field of the spec that does not fit the input; empty where it is the input that cannot be used.
    fn spec_field(&self) -> &'static str {
        ""
    }
    /// At most 20 offending elements in the numbering of the input (vertices or faces, as the message says).
    fn elements(&self) -> Vec<u64> {
        Vec::new()
    }
}
