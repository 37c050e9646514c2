//! Runs that are stopped, and what is delivered then.

use std::sync::{Arc, OnceLock};

use super::*;
use crate::engine::mesh::shapes::sample_surface;
use crate::engine::pipeline::Target;
use crate::engine::run::Observer;

/// Stops the run for a reason whenever a stage of a kind begins.
struct StopAt(Arc<OnceLock<RunContext>>, Vec<(Stage, StopReason)>);

impl Observer for StopAt {
    fn stage_begins(&self, stage: Stage) {
        for &(_, reason) in self.1.iter().filter(|(at, _)| *at == stage) {
            if let Some(ctx) = self.0.get() {
                ctx.stop(reason);
            }
        }
    }
    fn stage_ends(&self, _: Stage) {}
    fn progress(&self, _: u32) {}
}

fn stopped_at(stops: &[(Stage, StopReason)]) -> Result<Outcome, RemeshError> {
    cut_at(stops, &RemeshSpec { target: Target::Quads(600), ..RemeshSpec::default() })
}

fn cut_at(stops: &[(Stage, StopReason)], spec: &RemeshSpec) -> Result<Outcome, RemeshError> {
    let mesh = sample_surface("genus2", 2000).unwrap().mesh;
    let mut soup = TriangleSoup::from_triangles(mesh.positions().to_vec(), mesh.faces());
    soup.colours = vec![[0.5; 4]; soup.positions.len()];
    let handle = Arc::new(OnceLock::new());
    let ctx = RunContext::new(0, StopAt(handle.clone(), stops.to_vec()));
    handle.get_or_init(|| ctx.clone());
    let outcome = remesh(&ctx, &soup, spec);
    assert!(ctx.stopped().is_some(), "{stops:?}");
    outcome
}

#[test]
fn at_the_deadline_small_surfaces_get_what_there_is_and_a_client_gets_nothing() {
    let early = stopped_at(&[(Stage::Map, StopReason::Deadline)]).unwrap().report;
    assert_eq!((early.certified, early.level), (true, Level::L4));
    assert!((early.quads.count as f64 / 600.0 - 1.0).abs() < 0.5, "{}", early.quads.count);
    assert!(early.cut_by_deadline);
    let is_deadline = |w: &Warning| matches!(w.kind, WarningKind::Deadline { .. });
    assert!(early.warnings.iter().any(is_deadline), "{:?}", early.warnings);
}

#[test]
fn every_stage_heeds_a_stop() {
    use Stage::{Certify, Condition, Extract, Features, Field, Map, Optimise, Refine, Round, Write};
    for stage in [Condition, Features, Refine, Field, Map, Round, Extract, Optimise, Certify, Write] {
        for reason in [StopReason::Client, StopReason::Shutdown, StopReason::Overtime] {
            let stopped = stopped_at(&[(stage, reason)]);
            assert!(
                matches!(stopped, Err(RemeshError::Cancelled(Cancelled(r))) if r == reason),
                "{stage:?} {reason:?}"
            );
        }
    }
    // After the deadline as well.
    for late in [Certify, Write] {
        let stops = [(Stage::Map, StopReason::Deadline), (late, StopReason::Client)];
        assert!(matches!(stopped_at(&stops), Err(RemeshError::Cancelled(Cancelled(StopReason::Client)))), "{late:?}");
    }
}

#[test]
fn where_the_time_may_not_suffice_pairs_of_triangles_come_first_and_the_map_is_preferred() {
    let mesh = sample_surface("genus2", 2000).unwrap().mesh;
    let soup = TriangleSoup::from_triangles(mesh.positions().to_vec(), mesh.faces());
    let spec = RemeshSpec { target: Target::Quads(600), time_limit: 1.0, ..RemeshSpec::default() };
    let report = remesh(&RunContext::silent(), &soup, &spec).unwrap().report;
    assert_eq!((report.certified, report.level, report.cut_by_deadline), (true, Level::L0, false));
    let cut = cut_at(&[(Stage::Map, StopReason::Deadline)], &spec).unwrap().report;
    assert_eq!((cut.certified, cut.level, cut.cut_by_deadline), (true, Level::L3, true));
    assert!((cut.quads.count as f64 / 600.0 - 1.0).abs() < 0.25, "{}", cut.quads.count);
}
