//! The table of problems.

use super::*;
use crate::engine::field::GivenFieldError;
use crate::engine::pipeline::RemeshError;

#[derive(Debug, thiserror::Error)]
#[error("no face is usable")]
struct Refusal(Fault);

impl Blame for Refusal {
    fn fault(&self) -> Fault {
        self.0
    }
    fn elements(&self) -> Vec<u64> {
        (0..50).collect()
    }
}

#[test]
fn slugs_are_unique_and_statuses_are_errors() {
    let mut slugs: Vec<_> = ProblemKind::ALL.iter().map(|kind| kind.slug()).collect();
    slugs.sort_unstable();
    slugs.dedup();
    assert_eq!(slugs.len(), ProblemKind::ALL.len());
    for &kind in ProblemKind::ALL {
        assert!((400..600).contains(&kind.status()));
        assert_ne!(kind.exit_code(), 0);
        assert_eq!(ProblemKind::from_type_uri(&kind.type_uri()), Some(kind));
    }
}

#[test]
fn faults_become_problems_with_at_most_twenty_elements() {
    let given = RemeshError::from(GivenFieldError::Degenerate { polygons: vec![7] });
    let unfit = problem_of_fault(&given, Some(given.stage()), None);
    assert_eq!((unfit.kind, unfit.elements.as_slice()), (ProblemKind::InvalidSpec, [7].as_slice()));
    assert_eq!(unfit.errors[0].pointer, "/field");
    let problem = problem_of_fault(&Refusal(Fault::Input), Some(Stage::Condition), None);
    assert_eq!((problem.kind.status(), problem.kind.exit_code()), (422, 3));
    assert_eq!(problem.detail, "No face is usable.");
    assert_eq!(problem.elements.len(), 20);
    let body = serde_json::to_value(problem.body(None)).unwrap();
    assert_eq!(body["type"], "urn:quadrille:problem:mesh-rejected");
    assert_eq!(body["stage"], "condition");
}

#[test]
fn causes_of_our_own_bugs_stay_inside() {
    let problem = problem_of_fault(&Refusal(Fault::Internal), None, None);
    assert!(!problem.detail.contains("usable"));
    assert_eq!(problem.kind.exit_code(), 70);
    let late = problem_of_fault(&Refusal(Fault::Cancelled), None, Some(StopReason::Deadline));
    assert_eq!((late.kind.status(), late.kind.exit_code()), (504, 5));
}

#[test]
fn a_passed_deadline_names_what_was_tried() {
    let stop = Cancelled(StopReason::Deadline);
    let causes = "quadcover as asked for: 2 quads have no area".to_owned();
    let error = RemeshError::DeadlineExceeded { component: 3, causes, stop };
    let late = problem_of_fault(&error, Some(error.stage()), Some(StopReason::Deadline));
    assert_eq!((late.kind, late.stage), (ProblemKind::DeadlineExceeded, None));
    assert!(late.detail.ends_with("Tried so far: component 3: quadcover as asked for: 2 quads have no area."));
    let plain = problem_of_fault(&RemeshError::Cancelled(stop), None, Some(StopReason::Deadline));
    assert!(late.detail.starts_with(&plain.detail) && !plain.detail.contains("Tried"));
}
