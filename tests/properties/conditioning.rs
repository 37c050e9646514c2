//! Soups and surfaces through conditioning alone.

use std::collections::BTreeSet;

use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;
use quadrille::engine::mesh::condition::{ConditionOptions, condition};
use quadrille::engine::mesh::{Conditioned, TriMesh, TriangleSoup, closest_on_segment};
use quadrille::engine::run::{Blame, Fault, RunContext};

use crate::cases::{Met, for_all};
use crate::soups::{Damage, Damaged, heap, wreck};
use crate::surfaces::surface;
use crate::topology::topology;

const SOUPS: u32 = 10_000;
const SURFACES: u32 = 1_000;
/// A shape of triangles and a distance of vertices, relative to the longest side and to the diagonal, that nothing has to
/// be done about.
const FINE: f64 = 1e-5;

/// Repairs that soups must have needed.
const REPAIRS: [&str; 14] = [
    "components_turned_outward",
    "components_without_area_dropped",
    "degenerate_faces_dropped",
    "double_edges_split",
    "double_faces_dropped",
    "duplicate_faces_dropped",
    "edges_collapsed",
    "edges_flipped",
    "faces_turned",
    "non_manifold_edges_cut",
    "t_vertices_joined",
    "unreferenced_vertices_dropped",
    "vertices_welded",
    "vertices_welded_nearly",
];

/// What conditioning did.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Done {
    Accepted,
    /// Conditioning made itself of what it had made.
    Settled,
    CameBack,
    Dealt(Damage),
    Repaired(&'static str),
}

fn conditioned(soup: &TriangleSoup) -> Result<Option<Conditioned>, TestCaseError> {
    match condition(&RunContext::silent(), soup, &ConditionOptions { cut_non_orientable: true }) {
        Ok(conditioned) => Ok(Some(conditioned)),
        Err(error) if error.fault() == Fault::Input => Ok(None),
        Err(error) => Err(TestCaseError::fail(error.to_string())),
    }
}

fn soup_of(mesh: &TriMesh) -> TriangleSoup {
    TriangleSoup::from_triangles(mesh.positions().to_vec(), mesh.faces())
}

/// Height over the longest side.
fn shape(mesh: &TriMesh, f: usize) -> f64 {
    let [a, b, c] = mesh.triangle(f);
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    2.0 * mesh.area(f) / (longest * longest)
}

/// An oriented manifold without slivers, of which every part comes from a part of the soup.
fn check(soup: &TriangleSoup, made: &Conditioned) -> TestCaseResult {
    let mesh = &made.mesh;
    topology(mesh.faces()).map_err(TestCaseError::fail)?;
    prop_assert!(mesh.n_faces() > 0 && mesh.positions().iter().all(|p| p.is_finite()));
    let used: BTreeSet<u32> = mesh.faces().iter().flatten().copied().collect();
    prop_assert_eq!(used.len(), mesh.n_vertices());
    prop_assert!((0..mesh.n_faces()).all(|f| shape(mesh, f) > 0.99e-6));
    prop_assert_eq!((made.polygon.len(), made.origin.len()), (mesh.n_faces(), used.len()));
    prop_assert!(made.polygon.iter().all(|&p| (p as usize) < soup.n_polygons()));
    prop_assert!(made.origin.iter().all(|&v| (v as usize) < soup.positions.len()));
    Ok(())
}

/// Whether conditioning makes itself of what it made. It need not where it cut: a file says nothing of a cut but that two
/// vertices are at one place, and those of open edges are one vertex. What comes then is as good a manifold.
fn settles(made: &Conditioned) -> Result<bool, TestCaseError> {
    let soup = soup_of(&made.mesh);
    let Some(again) = conditioned(&soup)? else {
        return Err(TestCaseError::fail("what was accepted is refused when it comes again"));
    };
    check(&soup, &again)?;
    let is_same = (again.mesh.positions(), again.mesh.faces()) == (made.mesh.positions(), made.mesh.faces());
    prop_assert!(is_same || !is_clean(&soup), "a clean mesh becomes another: {:?}", again.repairs);
    Ok(is_same)
}

/// A mesh that leaves nothing to do: a manifold, no vertex near another or near an edge that it does not end.
fn is_clean(soup: &TriangleSoup) -> bool {
    let faces: Vec<[u32; 3]> = soup.polygons().filter_map(|p| p.try_into().ok()).collect();
    let Ok(mesh) = TriMesh::try_new(soup.positions.clone(), faces) else { return false };
    let near = FINE * mesh.diagonal();
    let is_fine = |f: usize| shape(&mesh, f) > FINE && mesh.area(f) > near * near;
    let is_apart = |h: usize| {
        let (a, b) = (mesh.origin(h), mesh.target(h));
        let [from, to] = [a, b].map(|v| mesh.position(v));
        let far = |v: u32| closest_on_segment(mesh.position(v), from, to).1.distance(mesh.position(v)) > near;
        (0..mesh.n_vertices() as u32).all(|v| v == a || v == b || far(v))
    };
    mesh.n_faces() == soup.n_polygons()
        && (0..mesh.n_faces()).all(is_fine)
        && (0..mesh.n_halfedges()).filter(|&h| mesh.is_edge_owner(h)).all(is_apart)
}

/// Clean input comes back as it was.
fn check_clean(soup: &TriangleSoup, back: &Conditioned) -> TestCaseResult {
    let given: Vec<u32> = back.mesh.faces().iter().flatten().copied().collect();
    prop_assert_eq!((back.mesh.positions(), given), (&soup.positions[..], soup.indices.clone()));
    prop_assert!(back.repairs.is_empty(), "{:?}", back.repairs);
    Ok(())
}

fn judge(met: &Met<Done>, Damaged { soup, damage }: &Damaged) -> TestCaseResult {
    damage.iter().for_each(|&damage| met.count(Done::Dealt(damage)));
    let Some(conditioned) = conditioned(soup)? else { return Ok(()) };
    met.count(Done::Accepted);
    conditioned.repairs.iter().for_each(|&(name, _)| met.count(Done::Repaired(name)));
    check(soup, &conditioned)?;
    if settles(&conditioned)? {
        met.count(Done::Settled);
    }
    Ok(())
}

#[test]
fn any_soup_becomes_a_manifold_that_stays_as_it_is_or_is_refused() {
    let met = Met::default();
    for_all(SOUPS / 2, heap(), |case| judge(&met, &case));
    for_all(SOUPS / 2, wreck(), |case| judge(&met, &case));
    println!("{met:?}");
    let accepted = met.of(Done::Accepted);
    assert!(accepted >= 2 * SOUPS / 5 && met.of(Done::Settled) >= 19 * accepted / 20, "{met:?}");
    met.assert_each(&Damage::DEALT.map(Done::Dealt), SOUPS / 50);
    met.assert_each(&Damage::FOUND.map(Done::Dealt), SOUPS / 50);
    met.assert_each(&REPAIRS.map(Done::Repaired), SOUPS / 1000);
}

#[test]
fn any_clean_surface_comes_back_as_it_was() {
    let met = Met::default();
    for_all(SURFACES, surface(), |soup| {
        let Some(conditioned) = conditioned(&soup)? else {
            return Err(TestCaseError::fail("a surface is refused"));
        };
        met.count(Done::Accepted);
        check(&soup, &conditioned)?;
        settles(&conditioned)?;
        if is_clean(&soup) {
            met.count(Done::CameBack);
            check_clean(&soup, &conditioned)?;
        }
        Ok(())
    });
    println!("{met:?}");
    assert!(met.of(Done::CameBack) >= SURFACES / 5, "{met:?}");
}
