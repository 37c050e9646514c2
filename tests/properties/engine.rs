//! Soups and surfaces through the whole engine.

use std::cell::Cell;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;
use quadrille::engine::mesh::TriangleSoup;
use quadrille::engine::pipeline::{Effort, Outcome, RemeshError, RemeshSpec, remesh};
use quadrille::engine::run::{Blame, Fault, RunContext, StopReason, WarningKind};

use crate::cases::{Met, for_all, is_soak, kept, number_of_cases};
use crate::soups::{Damage, Damaged, heap, wreck};
use crate::surfaces::{spec, surface};
use crate::topology::topology;

/// No case may take longer, by far: these are models of at most a few hundred triangles.
const LIMIT: Duration = Duration::from_secs(60);

/// One run, with a limit to its work; one that takes far too long is stopped and fails its test.
fn run(soup: &TriangleSoup, spec: &RemeshSpec) -> Result<Result<Outcome, RemeshError>, TestCaseError> {
    let ctx = RunContext::silent();
    // The gate is about what is certified, not about how good it is.
    let effort = if is_soak() { Effort::Normal } else { Effort::Fast };
    let spec = &RemeshSpec { effort, ..spec.clone() };
    let (running, over) = channel::<()>();
    let late = ctx.clone();
    std::thread::spawn(move || {
        if over.recv_timeout(LIMIT) == Err(RecvTimeoutError::Timeout) {
            late.stop(StopReason::Deadline);
        }
    });
    let result = remesh(&ctx, soup, spec);
    drop(running);
    prop_assert!(ctx.stopped().is_none(), "not over after {LIMIT:?}");
    Ok(result)
}

/// Certified quads, as manifold as the surface that they were made for and of its topology, and nothing went wrong
/// on the way.
fn check(outcome: &Outcome) -> TestCaseResult {
    let (quads, report) = (&outcome.quads, &outcome.report);
    prop_assert!(report.certified, "not certified: {:?}", report.warnings);
    prop_assert!(quads.positions.iter().all(|p| p.is_finite()));
    let contained = report.warnings.iter().find(|w| matches!(w.kind, WarningKind::InternalError { .. }));
    prop_assert!(contained.is_none(), "{:?}", report.warnings);
    let made = topology(&quads.quads).map_err(TestCaseError::fail)?;
    let given = topology(outcome.surface.mesh.faces()).map_err(TestCaseError::fail)?;
    prop_assert_eq!(made, given);
    Ok(())
}

/// Quads of a soup, or the refusal of it; whether there are quads.
fn check_soup(Damaged { soup, .. }: &Damaged, spec: &RemeshSpec) -> Result<bool, TestCaseError> {
    match run(soup, spec)? {
        Ok(outcome) => check(&outcome).map(|()| true),
        Err(error) => {
            prop_assert!(error.fault() == Fault::Input, "{}: {error}", kept(soup));
            Ok(false)
        }
    }
}

/// Soups of one kind, of which enough are accepted, and which come with every one of these kinds of damage.
fn check_soups(soups: impl Strategy<Value = Damaged>, kinds: &[Damage]) {
    let cases = number_of_cases(150, 5_000);
    let (accepted, met) = (Cell::new(0), Met::default());
    for_all(cases, (soups, spec()), |(case, spec)| {
        case.damage.iter().for_each(|&damage| met.count(damage));
        accepted.set(accepted.get() + u32::from(check_soup(&case, &spec)?));
        Ok(())
    });
    assert!(accepted.get() >= 2 * cases / 5, "{accepted:?} of {cases}");
    met.assert_each(kinds, cases / 50);
}

#[test]
fn any_heap_of_polygons_becomes_certified_quads_or_is_refused() {
    check_soups(heap(), &Damage::FOUND);
}

#[test]
fn any_wreck_of_a_surface_becomes_certified_quads_or_is_refused() {
    check_soups(wreck(), &Damage::DEALT);
}

#[test]
fn any_surface_becomes_certified_quads() {
    for_all(number_of_cases(100, 1_000), (surface(), spec()), |(soup, spec)| {
        let outcome = run(&soup, &spec)?.map_err(|e| TestCaseError::fail(format!("{}: {e}", kept(&soup))))?;
        check(&outcome)?;
        let faces: Vec<[u32; 3]> = soup.polygons().filter_map(|p| p.try_into().ok()).collect();
        prop_assert_eq!(topology(&outcome.quads.quads), topology(&faces));
        Ok(())
    });
}
