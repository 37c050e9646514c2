//! The methods that there are: those of this version, and those that a program which embeds the engine adds.

use std::sync::RwLock;

use crate::engine::methods::{Method, STANDARD};

/// Methods added by the program, for as long as it runs.
static ADDED: RwLock<Vec<MethodRef>> = RwLock::new(Vec::new());

/// A method, told apart by its name.
#[derive(Clone, Copy, Debug)]
pub struct MethodRef(pub &'static dyn Method);

impl MethodRef {
    /// Its name.
    pub fn name(self) -> &'static str {
        self.0.name()
    }
}

impl Default for MethodRef {
    fn default() -> Self {
        Self(STANDARD[0])
    }
}

impl PartialEq for MethodRef {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl Eq for MethodRef {}

/// All methods, those of this version first.
pub fn all() -> Vec<MethodRef> {
    let added = ADDED.read().unwrap_or_else(std::sync::PoisonError::into_inner);
    STANDARD.iter().map(|&method| MethodRef(method)).chain(added.iter().copied()).collect()
}

/// The method of this name.
///
/// ```
/// use quadrille::engine::{methods::by_name, pipeline::RemeshSpec};
///
/// let spec = RemeshSpec { method: by_name("triangle-pairs").expect("a standard method"), ..RemeshSpec::default() };
/// assert_eq!(spec.method.name(), "triangle-pairs");
/// assert!(by_name("magic").is_none());
/// ```
pub fn by_name(name: &str) -> Option<MethodRef> {
    all().into_iter().find(|method| method.name() == name)
}

/// Adds a method, to be called before the first run; `false`, and nothing happens, if its name is taken.
#[must_use]
pub fn register(method: &'static dyn Method) -> bool {
    if by_name(method.name()).is_some() {
        return false;
    }
    ADDED.write().unwrap_or_else(std::sync::PoisonError::into_inner).push(MethodRef(method));
    true
}
