use super::*;
use crate::engine::mesh::TriMesh;
use crate::engine::mesh::shapes::sample_surface;

/// The twelve edges and six faces of a box around the origin, on the surface of the index.
fn cube(index: &SurfaceIndex, half: f64) -> QuadLayout {
    let corner = |v: u32| DVec3::from([0, 1, 2].map(|k| if v >> k & 1 == 1 { half } else { -half }));
    let node = |v: u32| LayoutNode { position: index.closest(corner(v)).position, anchor: Anchor::Surface };
    let nodes: Vec<LayoutNode> = (0..8).map(node).collect();
    let mut layout = QuadLayout { nodes, ..QuadLayout::default() };
    for face in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
        let side = |k: usize| (face[k], face[(k + 1) % 4]);
        let sides = [0, 1, 2, 3].map(|k| {
            let (a, b) = side(k);
            let ends = [a.min(b), a.max(b)];
            let known = layout.arcs.iter().position(|arc| arc.ends == ends);
            let arc = known.unwrap_or_else(|| {
                let [p, q] = ends.map(|v| layout.nodes[v as usize].position);
                let points = (0..=16).map(|i| index.closest(p.lerp(q, f64::from(i) / 16.0)).position).collect();
                layout.arcs.push(LayoutArc { ends, points, course: ArcCourse::Surface });
                layout.arcs.len() - 1
            });
            Side { arc: arc as u32, is_reversed: a > b }
        });
        layout.patches.push(sides);
    }
    layout
}

#[test]
fn a_cube_on_a_sphere_becomes_quads_of_the_count_asked_for() {
    let surface = sample_surface("sphere", 3000).unwrap();
    let index = SurfaceIndex::new(&surface.mesh);
    let layout = cube(&index, surface.mesh.diagonal());
    for n in [1usize, 2, 5, 9] {
        let wanted = 6 * n * n;
        let edge_length = (surface.mesh.total_area() / wanted as f64).sqrt();
        let draft = quads_of_layout(&RunContext::silent(), &index, &layout, edge_length, Some(wanted as f64)).unwrap();
        assert_eq!((draft.mesh.quads.len(), draft.mesh.positions.len()), (wanted, wanted + 2));
        let halves = draft.mesh.quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let mesh = TriMesh::try_new(draft.mesh.positions, halves).unwrap();
        assert_eq!(mesh.topology(), surface.mesh.topology());
        // Outward: the volume is positive and, with many quads, that of the sphere.
        let volume =
            |mesh: &TriMesh| (0..mesh.n_faces()).map(|f| mesh.triangle(f)[0].dot(mesh.area_vector(f))).sum::<f64>();
        let share = volume(&mesh) / volume(&surface.mesh);
        assert!(share > 0.3 && share < 1.01 && (n < 9 || share > 0.95), "{n}: {share}");
    }
}

#[test]
fn opposite_sides_have_as_many_segments_and_a_box_keeps_its_proportions() {
    let surface = sample_surface("cube", 1200).unwrap();
    let index = SurfaceIndex::new(&surface.mesh);
    let mut layout = cube(&index, surface.mesh.diagonal());
    // Arcs along x are said to be three times as long.
    for arc in layout.arcs.iter_mut().filter(|arc| arc.ends[0] ^ arc.ends[1] == 1) {
        let (a, b) = (arc.points[0], arc.points[16]);
        arc.points = vec![a, b, a, b];
    }
    let side = (surface.mesh.total_area() / 6.0).sqrt();
    let draft = quads_of_layout(&RunContext::silent(), &index, &layout, 0.5 * side, None).unwrap();
    assert_eq!(draft.mesh.quads.len(), 2 * (6 * 2 + 6 * 2 + 2 * 2));
}

#[test]
fn layouts_that_do_not_fit_together_are_refused() {
    let surface = sample_surface("sphere", 500).unwrap();
    let index = SurfaceIndex::new(&surface.mesh);
    let quads = |layout: &QuadLayout| quads_of_layout(&RunContext::silent(), &index, layout, 0.5, None);
    let good = cube(&index, surface.mesh.diagonal());
    let mut open = good.clone();
    open.patches[3].swap(0, 1);
    assert_eq!(quads(&open).unwrap_err(), LayoutError::OpenPatch { patch: 3 });
    let mut short = good.clone();
    short.arcs[2].points.truncate(1);
    assert_eq!(quads(&short).unwrap_err(), LayoutError::Arc { arc: 2 });
    let mut missing = good;
    missing.patches[1][1].arc = 99;
    assert_eq!(quads(&missing).unwrap_err(), LayoutError::Arc { arc: 99 });
}
