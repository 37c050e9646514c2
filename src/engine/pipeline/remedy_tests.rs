//! What each remedy and each sure method changes, and when it has nothing to offer.

use glam::DVec3;

use crate::engine::mesh::shapes::sample_surface;
use crate::engine::methods::quad_cover::QuadCover;
use crate::engine::methods::{MethodRef, Parameters, Value};
use crate::engine::pipeline::attempt::Attempt;
use crate::engine::pipeline::remedies::{Case, Diagnosis, REMEDIES};
use crate::engine::pipeline::sure::{Keep, Sure, at_the_deadline, sure_methods};
use crate::engine::problem::{Align, Boundary, Optimise, Problem, Wishes, WorkingMesh, split};
use crate::engine::run::RunContext;

const WISHES: Wishes = Wishes {
    boundary: Boundary::Free,
    align: Align::Curvature,
    smoothing: 0.5,
    optimise: Optimise::Balance,
    working_mesh: WorkingMesh::Auto,
    adapts_count: true,
};

/// A sample with so many quads.
fn problem(name: &str, quads: f64) -> Problem {
    let surface = sample_surface(name, 2000).unwrap();
    let edge_length = (surface.mesh.total_area() / quads).sqrt();
    split(&surface, edge_length, true, &WISHES, &[], &[], &[]).remove(0)
}

fn asked(problem: &Problem) -> Attempt {
    Attempt {
        method: MethodRef(&QuadCover),
        parameters: Parameters::default(),
        problem: problem.clone(),
        change: "as asked for",
    }
}

/// What the remedy with these words offers, if anything.
fn offered(base: &Problem, diagnosis: Diagnosis, places: &[DVec3], may_give_up: bool, change: &str) -> Option<Problem> {
    let asked = asked(base);
    let case = Case { asked: &asked, base, places, last: &asked, diagnosis, may_give_up };
    let mut offers = REMEDIES.iter().filter(|remedy| remedy.helps.contains(&diagnosis)).filter_map(|remedy| {
        let attempt = (remedy.attempt)(&RunContext::silent(), &case).unwrap()?;
        assert_eq!(attempt.method, MethodRef(&QuadCover), "remedies keep the method");
        (attempt.change == change).then_some(attempt.problem)
    });
    offers.next()
}

#[test]
fn what_is_complete_needs_no_remedy() {
    assert!(REMEDIES.iter().all(|remedy| !remedy.helps.is_empty() && !remedy.helps.contains(&Diagnosis::Complete)));
}

#[test]
fn a_free_boundary_is_followed() {
    let change = "with the boundary followed";
    let pipe = problem("half_pipe", 300.0);
    let followed = offered(&pipe, Diagnosis::Nothing, &[], true, change).unwrap();
    assert_eq!((followed.wishes.boundary, followed.wishes.optimise), (Boundary::Align, Optimise::Balance));
    assert!(offered(&followed, Diagnosis::Nothing, &[], true, change).is_none(), "it is already");
    assert!(offered(&problem("cube", 300.0), Diagnosis::Nothing, &[], true, change).is_none(), "there is none");
}

#[test]
fn quads_get_smaller_where_they_fail_and_around_small_handles() {
    let change = "with smaller quads at some places";
    let cube = problem("cube", 600.0);
    let place = [cube.surface.mesh.position(0)];
    let mut base = cube.clone();
    for size in [0.5, 0.25, 0.125] {
        base = offered(&base, Diagnosis::Local, &place, true, change).unwrap();
        assert!((base.log_size_at(place[0]).exp() - size).abs() < 1e-9, "{size}");
    }
    assert!(offered(&base, Diagnosis::Local, &place, true, change).is_none(), "they are small enough");
    assert!(offered(&cube, Diagnosis::Local, &[], true, change).is_none(), "nothing failed");
    let torus = problem("torus", 100.0).with_edges_times(3.5);
    let around = offered(&torus, Diagnosis::Global, &[], true, change).unwrap();
    assert!(around.refined.iter().all(|place| (0.1..1.0).contains(&place.size)));
    assert!(offered(&torus, Diagnosis::Incomplete, &[], true, change).is_none(), "the handle was kept");
}

#[test]
fn features_go_near_what_failed_and_then_everywhere_but_never_the_users() {
    let (near, bare) = ("without the features at some places", "without features");
    let cube = problem("cube", 600.0);
    let place = [cube.surface.mesh.position(cube.surface.features.corners[0])];
    let all = cube.surface.features.edges.len();
    let left = |change: &str, places: &[DVec3], may: bool| {
        offered(&cube, Diagnosis::Local, places, may, change).map(|p| p.surface.features.edges.len())
    };
    assert!(left(near, &place, true).is_some_and(|n| n > 0 && n < all));
    assert_eq!(left(bare, &place, true), Some(0));
    assert_eq!([left(near, &place, false), left(bare, &place, false), left(near, &[], true)], [None; 3]);
    assert!(offered(&problem("sphere", 600.0), Diagnosis::Local, &place, true, bare).is_none());
}

#[test]
fn fields_get_smoother_and_quads_more() {
    let cube = problem("cube", 600.0);
    let smoother = offered(&cube, Diagnosis::NoQuads, &[], true, "of a smoother field").unwrap();
    assert_eq!(smoother.wishes.smoothing, 0.75);
    let smoothest = Problem { wishes: Wishes { smoothing: 1.0, ..WISHES }, ..cube.clone() };
    assert!(offered(&smoothest, Diagnosis::NoQuads, &[], true, "of a smoother field").is_none());
    let finer = offered(&cube, Diagnosis::Global, &[], true, "with more quads").unwrap();
    assert!((finer.quads / cube.quads - 1.0 / 0.49).abs() < 1e-9);
    assert!(offered(&cube, Diagnosis::Local, &[], true, "with more quads").is_none(), "few places are no reason");
}

#[test]
fn sure_methods_are_asked_as_their_rows_say() {
    let cube = problem("cube", 600.0);
    let all = sure_methods(&cube, true);
    for sure in all.iter().chain(&at_the_deadline(&cube, true)) {
        let attempt = sure.attempt(&cube);
        let fidelity = attempt.method.0.parameters().iter().find(|p| p.name == "fidelity").unwrap();
        assert_eq!(attempt.parameters.get(fidelity), Value::Choice(sure.fidelity));
        assert_eq!(attempt.problem.surface.features.edges.is_empty(), sure.features == Keep::None);
        assert_eq!(attempt.problem.wishes.boundary, Boundary::Align);
        let again = sure.again(&attempt, &[cube.surface.mesh.position(0)]);
        assert_eq!(again.is_some(), !sure.is_exact(), "the triangles of the input are what they are");
        assert!(sure.again(&attempt, &[]).is_none());
    }
    assert!(all.is_sorted_by_key(Sure::is_exact), "the input's own triangles come last");
    // Where nothing is to be given up, each method is asked once, and none follows less than all.
    let sphere = problem("sphere", 600.0);
    for rows in [sure_methods(&cube, false), sure_methods(&sphere, true)] {
        let mut names: Vec<_> = rows.iter().map(|sure| (sure.method.name(), sure.fidelity)).collect();
        assert_eq!(names.len(), 4);
        names.dedup();
        assert_eq!(names.len(), 4);
        assert!(rows.iter().all(|sure| sure.features == Keep::All), "the user's edges stay");
    }
}
