use super::*;

fn tetrahedron() -> TriMesh {
    let p = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    TriMesh::try_new(p, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).unwrap()
}

#[test]
fn a_tetrahedron_is_a_sphere() {
    let mesh = tetrahedron();
    assert_eq!(mesh.topology(), Topology { components: 1, boundaries: 0, genus: 0, euler: 2 });
    for v in 0..4 {
        assert_eq!(mesh.fan(v).count(), 3);
        assert!(mesh.fan(v).all(|h| mesh.origin(h) == v));
    }
    for h in 0..mesh.n_halfedges() {
        let t = mesh.twin(h).unwrap();
        assert_eq!((mesh.origin(h), mesh.target(h)), (mesh.target(t), mesh.origin(t)));
    }
}

#[test]
fn an_open_fan_starts_at_the_boundary() {
    let p = vec![DVec3::ZERO, DVec3::X, DVec3::Y, -DVec3::X];
    let mesh = TriMesh::try_new(p, vec![[0, 2, 3], [0, 1, 2]]).unwrap();
    assert_eq!(mesh.fan(0).count(), 2);
    assert!(mesh.is_boundary_vertex(0));
    assert_eq!(mesh.target(mesh.outgoing(0)), 1);
    assert_eq!(mesh.boundary_loops().len(), 1);
}

#[test]
fn what_is_not_a_manifold_is_refused() {
    let p = vec![DVec3::ZERO; 5];
    let three = TriMesh::try_new(p.clone(), vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
    assert_eq!(three.unwrap_err(), MeshError::BadEdge { a: 0, b: 1 });
    let bow_tie = TriMesh::try_new(p, vec![[0, 1, 2], [0, 3, 4]]);
    assert_eq!(bow_tie.unwrap_err(), MeshError::BadVertex { vertex: 0 });
}
