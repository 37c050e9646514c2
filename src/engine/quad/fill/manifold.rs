//! What tests demand of quads.

use crate::engine::quad::QuadDraft;

/// Numbers of a quad mesh that is an oriented manifold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct QuadNumbers {
    pub(crate) quads: usize,
    pub(crate) euler: i64,
    pub(crate) boundaries: usize,
    pub(crate) boundary_edges: usize,
    pub(crate) components: usize,
}

/// Panics if the quads are not an oriented manifold without unused vertices; counts it otherwise.
pub(crate) fn quad_numbers(draft: &QuadDraft) -> QuadNumbers {
    let quads = &draft.mesh.quads;
    let n = draft.mesh.positions.len();
    assert_eq!(draft.anchors.len(), n);
    assert!(draft.mesh.positions.iter().all(|p| p.is_finite()));
    let mut sides: Vec<(u32, u32, usize)> = Vec::new();
    for (q, quad) in quads.iter().enumerate() {
        let mut sorted = *quad;
        sorted.sort_unstable();
        assert!(sorted.windows(2).all(|w| w[0] != w[1]), "quad {quad:?} names a vertex twice");
        (0..4).for_each(|k| sides.push((quad[k], quad[(k + 1) % 4], q)));
    }
    sides.sort_unstable();
    assert!(sides.windows(2).all(|w| (w[0].0, w[0].1) != (w[1].0, w[1].1)), "an edge is used twice in one direction");
    let find = |a: u32, b: u32| sides.binary_search_by_key(&(a, b), |s| (s.0, s.1)).ok().map(|i| sides[i].2);
    let boundary: Vec<(u32, u32)> = sides.iter().map(|s| (s.0, s.1)).filter(|&(a, b)| find(b, a).is_none()).collect();
    let edges = (sides.len() + boundary.len()) / 2;

    // One fan per vertex: at a vertex as many fans as there are boundary edges out of it, or one closed fan.
    let mut quads_at = vec![0usize; n];
    quads.iter().flatten().for_each(|&v| quads_at[v as usize] += 1);
    assert!(quads_at.iter().all(|&c| c > 0), "unused vertex");
    for v in 0..n as u32 {
        let open = boundary.iter().filter(|e| e.0 == v).count();
        assert!(open <= 1, "vertex {v} has {open} open fans");
        let start = boundary.iter().find(|e| e.0 == v).map(|e| e.1);
        let start = start.unwrap_or_else(|| sides[sides.partition_point(|s| s.0 < v)].1);
        let (mut w, mut met) = (start, 0);
        while let Some(q) = find(v, w) {
            met += 1;
            let k = quads[q].iter().position(|&x| x == v).unwrap();
            w = quads[q][(k + 3) % 4];
            if w == start || met > quads_at[v as usize] {
                break;
            }
        }
        assert_eq!(met, quads_at[v as usize], "vertex {v} has more than one fan");
    }

    let mut boundaries = 0;
    let mut seen = vec![false; boundary.len()];
    for i in 0..boundary.len() {
        if seen[i] {
            continue;
        }
        boundaries += 1;
        let mut j = i;
        while !seen[j] {
            seen[j] = true;
            j = boundary.iter().position(|e| e.0 == boundary[j].1).unwrap();
        }
    }
    let mut component: Vec<u32> = (0..n as u32).collect();
    loop {
        let mut changed = false;
        for quad in quads {
            let least = quad.map(|v| component[v as usize]).into_iter().min().unwrap();
            for &v in quad {
                changed |= component[v as usize] != least;
                component[v as usize] = least;
            }
        }
        if !changed {
            break;
        }
    }
    component.sort_unstable();
    component.dedup();
    let euler = n as i64 - edges as i64 + quads.len() as i64;
    let numbers = QuadNumbers {
        quads: quads.len(),
        euler,
        boundaries,
        boundary_edges: boundary.len(),
        components: component.len(),
    };
    for e in &draft.feature_edges {
        assert!(find(e[0], e[1]).is_some() && find(e[1], e[0]).is_some(), "feature edge {e:?} is not an inner edge");
    }
    numbers
}
