//! Faces that touch, lie on each other, or have one side only.

use glam::DVec3;

use crate::engine::mesh::TriangleSoup;
use crate::engine::mesh::condition::tests::{
    Ends, Sides, add_box, check, count, exploded, good, merged, run, strip, unit_box,
};
use crate::engine::mesh::condition::{ConditionError, ConditionOptions, condition};
use crate::engine::run::{Blame, Fault, RunContext};

#[test]
fn boxes_that_touch_stay_two() {
    let places = [("vertex", DVec3::ONE), ("edge", DVec3::new(1.0, 1.0, 0.0)), ("face", DVec3::X)];
    for (name, at) in places {
        let mut soup = unit_box();
        add_box(&mut soup, at, 1.0);
        for soup in [soup.clone(), exploded(&soup), merged(&soup)] {
            let t = good(&soup).mesh.topology();
            assert_eq!((t.components, t.boundaries, t.euler), (2, 0, 4), "sharing a {name}");
        }
    }
}

#[test]
fn boxes_on_an_edge_stay_two_whichever_way_they_face() {
    let mut soup = unit_box();
    add_box(&mut soup, DVec3::new(1.0, 1.0, 0.0), 1.0);
    let mut soup = merged(&soup);
    for p in 6..12 {
        soup.indices[4 * p..4 * p + 4].reverse();
    }
    let c = good(&soup);
    assert_eq!((c.mesh.topology().components, c.mesh.topology().euler), (2, 4));
    assert_eq!(count(&c, "faces_turned") + count(&c, "components_turned_outward"), 0);
}

#[test]
fn a_fin_on_a_sheet_is_cut_off() {
    let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let mut soup = TriangleSoup {
        positions: vec![
            p(-1.0, 0.0, 0.0),
            p(-1.0, 1.0, 0.0),
            p(0.0, 0.0, 0.0),
            p(0.0, 1.0, 0.0),
            p(1.0, 0.0, 0.0),
            p(1.0, 1.0, 0.0),
            p(0.0, 0.0, 1.0),
            p(0.0, 1.0, 1.0),
        ],
        ..Default::default()
    };
    for q in [[0, 2, 3, 1], [2, 4, 5, 3], [2, 6, 7, 3]] {
        soup.push_polygon(&q);
    }
    let c = good(&soup);
    let (component, n) = c.mesh.components();
    assert_eq!((n, component), (2, vec![0, 0, 0, 0, 1, 1]));
    assert_eq!(count(&c, "non_manifold_edges_cut"), 1);
    assert_eq!(c.warnings.len(), 1);
}

#[test]
fn one_sided_surfaces_are_refused_or_cut() {
    for (soup, euler) in
        [(strip(20, 3, Ends::Mirrored, Sides::Open), 0), (strip(20, 8, Ends::Mirrored, Sides::Closed), 0)]
    {
        let error = run(&soup).unwrap_err();
        assert!(matches!(error, ConditionError::NonOrientable { component: 0, .. }));
        assert_eq!(error.fault(), Fault::Input);
        assert!(!error.elements().is_empty() && error.elements().len() <= 20);
        let options = ConditionOptions { cut_non_orientable: true };
        let c = condition(&RunContext::silent(), &soup, &options).unwrap();
        check(&soup, &c);
        let t = c.mesh.topology();
        // A cut along arcs between boundaries adds one per arc, along loops nothing.
        assert!(t.boundaries > 0 && t.components == 1 && t.euler >= euler, "{t:?}");
        let cut = count(&c, "non_orientable_edges_cut");
        assert!(cut > 0 && cut < 60, "{cut}");
    }
}

#[test]
fn faces_that_are_there_twice_are_kept_once() {
    let mut soup = unit_box();
    soup.push_polygon(&[0, 2, 3, 1]);
    let c = good(&soup);
    assert_eq!((c.mesh.topology().euler, count(&c, "duplicate_faces_dropped")), (2, 2));
    // The same with the opposite sense.
    let mut soup = unit_box();
    soup.push_polygon(&[3, 2, 0, 1]);
    let c = good(&soup);
    assert_eq!((c.mesh.topology().components, c.mesh.topology().euler), (1, 2));
}

#[test]
fn a_sheet_with_two_sides_becomes_one_sheet() {
    let annulus = strip(12, 2, Ends::Straight, Sides::Open);
    let mut soup = annulus.clone();
    for polygon in annulus.polygons() {
        let mut back = polygon.to_vec();
        back.reverse();
        // The same diagonal as in front.
        back.rotate_left(1);
        soup.push_polygon(&back);
    }
    for soup in [soup.clone(), exploded(&soup)] {
        let c = good(&soup);
        assert_eq!((c.mesh.n_faces(), c.mesh.topology().boundaries), (48, 2));
        assert_eq!(count(&c, "double_faces_dropped"), 48);
    }
}

#[test]
fn coincident_faces_that_share_one_edge_become_a_manifold() {
    let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let positions = vec![
        p(0.0, 2.0, 1.0),
        p(0.0, 0.0, 1.0),
        p(1.0, 3.0, 0.0),
        p(1e-8, 1.0, 0.99999999),
        p(1.00000001, 1.0, -1e-8),
        p(1e-8, 1.0, 0.99999999),
        p(1.0, 3.0, 1.0),
        p(3.0, 1.0, 2.0),
    ];
    let polygons: [&[u32]; 13] = [
        &[0, 0, 7],
        &[0, 5, 3, 7],
        &[0, 3, 2, 0, 6],
        &[0, 3, 0],
        &[0, 7, 3],
        &[0, 7, 4],
        &[3, 2, 6],
        &[3, 0, 3],
        &[6, 1, 0, 6, 7],
        &[2, 6, 0],
        &[2, 5, 6],
        &[7, 7, 0, 4, 0],
        &[5, 1, 2],
    ];
    let mut soup = TriangleSoup { positions, ..TriangleSoup::default() };
    for polygon in polygons {
        soup.push_polygon(polygon);
    }
    let options = ConditionOptions { cut_non_orientable: true };
    check(&soup, &condition(&RunContext::silent(), &soup, &options).unwrap());
}
