//! Reads the JSON of a spec field by field, as the table says, and judges it; all violations are found at once.

use std::collections::BTreeMap;

use crate::engine::pipeline::{Boundary, GivenVectors, Target};
use crate::service::wire::fields::{Fields, Violations};
use crate::service::wire::spec::resolved::ResolvedSpec;
use crate::service::wire::spec::table::{FIELDS, GROUPS, LATER};
use crate::service::wire::{Problem, ProblemKind, Violation};

/// Most bytes of a spec without its long lists.
const PLAIN_BYTES: usize = 1 << 20;
/// Most bytes of a spec with feature edges, strokes or a field.
pub const SPEC_BYTES: usize = 16 << 20;

impl ResolvedSpec {
    /// Reads and judges the text of a spec; the problem is `invalid-spec` with all violations. An empty text means all
    /// defaults.
    ///
    /// ```
    /// use quadrille::engine::pipeline::Target;
    /// use quadrille::service::wire::ResolvedSpec;
    ///
    /// let spec = ResolvedSpec::from_json(br#"{"target": {"quads": 800}, "deadline_s": 20}"#).expect("a valid spec");
    /// assert_eq!((spec.spec.target, spec.options.deadline_s), (Target::Quads(800), 20.0));
    /// let problem = ResolvedSpec::from_json(br#"{"target": {"quads": 0}, "sede": 1}"#).expect_err("two violations");
    /// let mut places: Vec<_> = problem.errors.iter().map(|error| error.pointer.as_str()).collect();
    /// places.sort();
    /// assert_eq!(places, ["/sede", "/target/quads"]);
    /// ```
    pub fn from_json(text: &[u8]) -> Result<Self, Problem> {
        Self::with_flags(text, &BTreeMap::new()).map_err(Problem::invalid_spec)
    }

    /// The same where the JSON texts in `flags`, by names of fields, stand for what the text says about these fields.
    pub(in crate::service) fn with_flags(
        text: &[u8],
        flags: &BTreeMap<&'static str, String>,
    ) -> Result<Self, Vec<Violation>> {
        if text.len() > SPEC_BYTES {
            let message = format!("has {} bytes; the most is {SPEC_BYTES}", text.len());
            return Err(vec![Violation::new("", message)]);
        }
        let text = std::str::from_utf8(text).map_err(|error| vec![Violation::new("", format!("not JSON: {error}"))])?;
        let text = if text.trim_ascii().is_empty() { "null" } else { text };
        let mut violations = Vec::new();
        let (resolved, long) = Self::read(text, flags, &mut violations);
        if text.len() - long > PLAIN_BYTES {
            let message = format!(
                "has {} bytes besides features.edges, strokes and field; the most is {PLAIN_BYTES}",
                text.len() - long
            );
            violations.push(Violation::new("", message));
        }
        resolved.judge(&mut violations);
        if violations.is_empty() { Ok(resolved) } else { Err(violations) }
    }

    /// Reads every field that can be read, and notes the others; with the bytes of the long lists.
    fn read(text: &str, flags: &BTreeMap<&'static str, String>, found: &mut Vec<Violation>) -> (Self, usize) {
        let (mut resolved, mut long) = (Self::default(), 0);
        let mut top = Fields::of(text, "", found);
        let groups: Vec<_> = GROUPS.iter().map(|group| (group.name, top.take(group.name))).collect();
        resolved.read_group(None, &mut top, flags, &mut long);
        for (name, instead) in LATER {
            if top.take_quietly(name).is_some() {
                top.violations(name).add("", format!("{name} is not available in this version; {instead}"));
            }
        }
        top.finish();
        for (name, text) in groups {
            let mut fields = Fields::of(text.unwrap_or("null"), &format!("/{name}"), found);
            resolved.read_group(Some(name), &mut fields, flags, &mut long);
            fields.finish();
        }
        (resolved, long)
    }

    fn read_group(
        &mut self,
        group: Option<&str>,
        fields: &mut Fields<'_, '_>,
        flags: &BTreeMap<&'static str, String>,
        long: &mut usize,
    ) {
        for field in FIELDS {
            let (own, name) = field.path();
            if own != group {
                continue;
            }
            let written = fields.take(name);
            if field.values.is_long() {
                *long += written.map_or(0, str::len);
            }
            if let Some(json) = flags.get(field.name).map(String::as_str).or(written) {
                (field.read)(json, &mut fields.violations(name), self);
            }
        }
    }

    /// What fields say about each other; each of them was judged when it was read.
    fn judge(&self, found: &mut Vec<Violation>) {
        let mut violations = Violations::at("", found);
        // The half of a symmetric surface is cut open along the plane, and must follow the cut.
        if self.spec.boundary == Boundary::Free && self.spec.symmetry.is_wanted() {
            violations.add("/boundary", "cannot be free together with symmetry; leave one of them out");
        }
        if let Some(field) = &self.spec.field {
            if !self.spec.strokes.is_empty() {
                violations.add("/strokes", "cannot be given together with field, which says all directions");
            }
            if matches!(field.vectors, GivenVectors::Frames(_)) {
                if self.spec.adaptive_size > 0.0 {
                    violations.add("/adaptive_size", "must be 0 with field.frames, which say the sizes");
                }
                if self.spec.density_from_vertex_colour {
                    violations.add("/density_from_vertex_colour", "must be off with field.frames, which say the sizes");
                }
            }
        }
        if self.accept.count.is_some() && !matches!(self.spec.target, Target::Quads(_)) {
            violations.add("/accept/count", "needs a target in quads, from which it is counted");
        }
    }
}

impl Problem {
    /// The problem that a spec with these violations gets.
    pub fn invalid_spec(violations: Vec<Violation>) -> Self {
        let detail = match violations.as_slice() {
            [only] => format!("{}: {}", if only.pointer.is_empty() { "spec" } else { &only.pointer }, only.message),
            many => format!("{} fields of the spec cannot be used; see errors", many.len()),
        };
        Problem { errors: violations, ..Problem::new(ProblemKind::InvalidSpec, detail) }
    }
}
