//! Filling: polygons of all lengths, odd faces, parallel arcs, small closed surfaces.

use glam::DVec3;

use crate::engine::mesh::Topology;
use crate::engine::quad::Anchor;
use crate::engine::quad::fill::complete;
use crate::engine::quad::fill::embedded_graph::EmbeddedGraph;
use crate::engine::quad::fill::embedded_graph::GraphArc;
use crate::engine::quad::fill::embedded_graph::GraphNode;
use crate::engine::quad::fill::embedded_graph::Tag;
use crate::engine::quad::fill::faces::Faces;
use crate::engine::quad::fill::manifold::QuadNumbers;
use crate::engine::quad::fill::manifold::quad_numbers;
use crate::engine::quad::fill::patterns::Pattern;
use crate::engine::run::RunContext;

/// The graph of a polygon mesh, polygons counter-clockwise; sides without a neighbour are boundary.
fn from_polygons(positions: &[DVec3], polygons: &[Vec<u32>]) -> EmbeddedGraph {
    let mut ends: Vec<[u32; 2]> = Vec::new();
    for p in polygons {
        for i in 0..p.len() {
            let (a, b) = (p[i], p[(i + 1) % p.len()]);
            if !ends.contains(&[a, b]) && !ends.contains(&[b, a]) {
                ends.push([a, b]);
            }
        }
    }
    let dart = |a: u32, b: u32| {
        let first = ends.iter().position(|&e| e == [a, b]).map(|i| 2 * i as u32);
        first.or_else(|| ends.iter().position(|&e| e == [b, a]).map(|i| 2 * i as u32 + 1)).unwrap()
    };
    let mut ccw = vec![None; 2 * ends.len()];
    let mut inside = vec![false; 2 * ends.len()];
    for p in polygons {
        for i in 0..p.len() {
            let (a, v, b) = (p[(i + p.len() - 1) % p.len()], p[i], p[(i + 1) % p.len()]);
            ccw[dart(v, b) as usize] = Some(dart(v, a));
            inside[dart(v, b) as usize] = true;
        }
    }
    let arcs: Vec<GraphArc> = ends
        .iter()
        .enumerate()
        .map(|(i, &ends)| {
            let outside = [!inside[2 * i], !inside[2 * i + 1]];
            let tag = if outside == [false; 2] { Tag::Plain } else { Tag::Boundary };
            GraphArc { ends, tag, collapsed: false, outside }
        })
        .collect();
    let rotation = (0..positions.len() as u32).map(|v| {
        let mut darts: Vec<u32> =
            (0..2 * arcs.len() as u32).filter(|&d| arcs[d as usize / 2].ends[d as usize % 2] == v).collect();
        // The first dart of an open fan is the one that no other leads to.
        let start = darts.iter().copied().find(|&d| !darts.iter().any(|&e| ccw[e as usize] == Some(d)));
        let mut now = start.or(darts.first().copied());
        darts.clear();
        while let Some(d) = now {
            darts.push(d);
            now = ccw[d as usize].filter(|&n| n != darts[0]);
        }
        darts
    });
    let rotation: Vec<Vec<u32>> = rotation.collect();
    let on_boundary = |v: usize| rotation[v].iter().any(|&d| arcs[d as usize / 2].tag == Tag::Boundary);
    let nodes = positions.iter().enumerate().map(|(v, &position)| GraphNode {
        position,
        anchor: if on_boundary(v) { Anchor::Curve } else { Anchor::Surface },
    });
    let rotation = rotation.iter().map(|darts| darts.iter().map(|&d| (d, 1)).collect::<Vec<_>>());
    EmbeddedGraph::new(nodes.collect(), &arcs, rotation)
}

fn circle(n: u32) -> Vec<DVec3> {
    let angle = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(n);
    (0..n).map(|i| DVec3::new(angle(i).cos(), angle(i).sin(), 0.0)).collect()
}

const DISK: Topology = Topology { components: 1, boundaries: 1, genus: 0, euler: 1 };
const SPHERE: Topology = Topology { components: 1, boundaries: 0, genus: 0, euler: 2 };

#[test]
fn every_even_polygon_is_filled_without_touching_its_sides() {
    for n in (4..=60).step_by(2).chain([80, 200]) {
        let graph = from_polygons(&circle(n), &[(0..n).collect()]);
        let (draft, report) = complete(&RunContext::silent(), graph, &DISK).unwrap();
        let numbers = quad_numbers(&draft);
        assert_eq!((numbers.euler, numbers.boundaries, numbers.boundary_edges), (1, 1, n as usize));
        assert_eq!((report.odd_faces, report.split_arcs), (0, 0));
    }
}

#[test]
fn an_odd_disk_gets_one_more_side() {
    for n in [3, 5, 7, 11, 25] {
        let graph = from_polygons(&circle(n), &[(0..n).collect()]);
        let (draft, report) = complete(&RunContext::silent(), graph, &DISK).unwrap();
        let numbers = quad_numbers(&draft);
        assert_eq!((numbers.euler, numbers.boundary_edges, report.odd_faces), (1, n as usize + 1, 1));
    }
}

#[test]
fn all_patterns_are_disks_with_the_right_sides() {
    for n in (4..=20).step_by(2) {
        let all = Pattern::candidates(n);
        assert!(all.len() >= n as usize / 4);
        for (i, pattern) in all.iter().enumerate() {
            assert!(!all[..i].contains(pattern));
            for p in [pattern.clone(), Pattern::padded(pattern)] {
                let mut sides: Vec<(u32, u32)> =
                    p.quads.iter().flat_map(|q| (0..4).map(|k| (q[k], q[(k + 1) % 4]))).collect();
                let sum = sides.len();
                sides.sort_unstable();
                sides.dedup();
                assert_eq!(sides.len(), sum);
                let open: Vec<_> = sides.iter().filter(|s| sides.binary_search(&(s.1, s.0)).is_err()).collect();
                assert_eq!(open.len() as u32, n);
                assert!(open.iter().all(|s| s.1 == (s.0 + 1) % n));
                let euler = (n + p.new_nodes) as i64 - (sum + open.len()) as i64 / 2 + p.quads.len() as i64;
                assert_eq!(euler, 1);
            }
        }
    }
}

/// A grid of squares, some of them joined or cut to make odd faces.
fn grid_with(w: u32, h: u32, change: impl Fn(u32, u32) -> Vec<Vec<u32>>) -> EmbeddedGraph {
    let positions = (0..(w + 1) * (h + 1)).map(|i| DVec3::new(f64::from(i % (w + 1)), f64::from(i / (w + 1)), 0.0));
    let polygons: Vec<Vec<u32>> = (0..w * h).flat_map(|i| change(i % w, i / w)).collect();
    from_polygons(&positions.collect::<Vec<_>>(), &polygons)
}

#[test]
fn two_distant_odd_faces_are_joined_by_a_chain() {
    for (p, q) in [((1, 1), (6, 1)), ((1, 1), (6, 5)), ((0, 0), (7, 6)), ((3, 3), (4, 3)), ((3, 3), (4, 4))] {
        let square = |x: u32, y: u32| [y * 9 + x, y * 9 + x + 1, (y + 1) * 9 + x + 1, (y + 1) * 9 + x];
        let graph = grid_with(8, 7, |x, y| {
            let [a, b, c, d] = square(x, y);
            let cut = (x, y) == p || (x, y) == q;
            if cut { vec![vec![a, b, c], vec![a, c, d]] } else { vec![vec![a, b, c, d]] }
        });
        // Each cut square is two triangles: they pair with each other.
        let (draft, report) = complete(&RunContext::silent(), graph, &DISK).unwrap();
        assert_eq!((quad_numbers(&draft).quads, report.odd_faces), (56, 4));
        // One triangle of each pair joined with its neighbour: a pentagon and a triangle far from the other pair.
        let graph = grid_with(8, 7, |x, y| {
            let [a, b, c, d] = square(x, y);
            let cut = (x, y) == p || (x, y) == q;
            if cut {
                vec![vec![a, b, c, d]]
            } else if (x, y) == (p.0, p.1 + 1) {
                vec![vec![a, b, c], vec![a, c, d]]
            } else {
                vec![vec![a, b, c, d]]
            }
        });
        let (draft, _) = complete(&RunContext::silent(), graph, &DISK).unwrap();
        assert_eq!(quad_numbers(&draft).euler, 1);
    }
}

#[test]
fn lone_odd_faces_far_apart_meet_inside_or_at_the_boundary() {
    // A vertex on one side of a square makes two pentagons; the far sides of the two vertices differ.
    let w = 9;
    let id = |x: u32, y: u32| y * (w + 1) + x;
    for far in [2, 5, 7] {
        // Leaving out an edge and drawing a diagonal: (hexagon → pentagon + triangle) at two places.
        let graph = grid_with(w, 7, |x, y| {
            let quad = vec![id(x, y), id(x + 1, y), id(x + 1, y + 1), id(x, y + 1)];
            match (x, y) {
                (1, 3) => {
                    vec![vec![id(1, 3), id(2, 3), id(3, 4), id(2, 4), id(1, 4)], vec![id(2, 3), id(3, 3), id(3, 4)]]
                }
                (2, 3) => vec![],
                (x, 3) if x == far => {
                    vec![vec![id(x, 3), id(x + 1, 3), id(x + 1, 4)], vec![id(x, 3), id(x + 1, 4), id(x, 4)]]
                }
                _ => vec![quad],
            }
        });
        if far == 2 {
            continue;
        }
        let (draft, report) = complete(&RunContext::silent(), graph, &DISK).unwrap();
        assert_eq!(report.odd_faces, 4);
        assert_eq!(quad_numbers(&draft).euler, 1);
    }
}

#[test]
fn small_closed_surfaces_become_simple() {
    // A tetrahedron: four odd faces, no boundary.
    let p = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let graph = from_polygons(&p, &[vec![0, 2, 1], vec![0, 1, 3], vec![1, 2, 3], vec![2, 0, 3]]);
    let (draft, report) = complete(&RunContext::silent(), graph, &SPHERE).unwrap();
    assert_eq!((quad_numbers(&draft).euler, report.odd_faces), (2, 4));
    assert_eq!(quad_numbers(&draft).boundary_edges, 0);
    // A torus of one square: both its arcs are loops at its only node.
    let arc = GraphArc { ends: [0, 0], tag: Tag::Plain, collapsed: false, outside: [false; 2] };
    let node = GraphNode { position: DVec3::ZERO, anchor: Anchor::Surface };
    let graph = EmbeddedGraph::new(vec![node], &[arc, arc], [[(0, 1), (2, 1), (1, 1), (3, 1)]].iter());
    assert_eq!(Faces::new(&graph).len, [4]);
    let torus = Topology { components: 1, boundaries: 0, genus: 1, euler: 0 };
    let (draft, _) = complete(&RunContext::silent(), graph, &torus).unwrap();
    let QuadNumbers { euler, boundaries, components, .. } = quad_numbers(&draft);
    assert_eq!((euler, boundaries, components), (0, 0, 1));
}

/// A torus of n × m squares whose rings are joined with a shift, so that one chain of quads winds through all of them, and
/// two quads squeezed between two arcs that join the same nodes.
fn torus_with_parallel_arcs(n: u32, m: u32, shift: u32) -> EmbeddedGraph {
    let id = |i: u32, j: u32| if j == m { (i + shift) % n } else { j * n + i % n };
    let squares = (0..n * m).map(|k| (k % n, k / n));
    let squares = squares.map(|(i, j)| vec![id(i, j), id((i + 1) % n, j), id((i + 1) % n, j + 1), id(i, j + 1)]);
    let positions: Vec<DVec3> = (0..n * m).map(|k| DVec3::new(f64::from(k % n), f64::from(k / n), 0.0)).collect();
    let mut graph = from_polygons(&positions, &squares.collect::<Vec<_>>());
    let (a, b) = (id(3, 5), id(4, 5));
    let d = (0..graph.n_darts()).find(|&d| (graph.origin(d), graph.target(d)) == (a, b)).unwrap();
    let [first, second, third, beside] = {
        let node =
            |graph: &mut EmbeddedGraph, position| graph.add_node(GraphNode { position, anchor: Anchor::Surface });
        let (p, q) = (node(&mut graph, positions[a as usize]), node(&mut graph, positions[b as usize]));
        [(a, p), (p, q), (q, b), (a, b)].map(|(from, to)| graph.draw(from, to))
    };
    let before = graph.cw(d ^ 1);
    graph.place_after(first, d);
    graph.place_after(beside, first);
    graph.place_after(second, first ^ 1);
    graph.place_after(third, second ^ 1);
    graph.place_after(beside ^ 1, before);
    graph.place_after(third ^ 1, beside ^ 1);
    graph
}

#[test]
fn parallel_arcs_are_parted_near_by_where_a_chain_would_wind_through_the_whole_surface() {
    let torus = Topology { components: 1, boundaries: 0, genus: 1, euler: 0 };
    let (n, m) = (20, 30);
    let graph = torus_with_parallel_arcs(n, m, 7);
    assert_eq!(Faces::new(&graph).inside(|len| len == 4).len() as u32, n * m + 2);
    let (draft, report) = complete(&RunContext::silent(), graph, &torus).unwrap();
    let QuadNumbers { euler, boundaries, components, quads, .. } = quad_numbers(&draft);
    assert_eq!((euler, boundaries, components), (0, 0, 1));
    assert!((1..20).contains(&report.split_arcs), "{report:?}");
    assert!((quads as u32) < n * m + 30, "{quads}");
    // Where the chain is short it is split, and all new nodes have four arcs: a ring of circumference two.
    let (long, around) = (12, 2);
    let id = |i: u32, j: u32| (j % around) * long + i % long;
    let darts = |k: u32| {
        let (i, j) = (k % long, k / long);
        let along = 2 * k;
        let up = 2 * (long * around + k);
        [(along, 1), (up, 1), (2 * id(i + long - 1, j) + 1, 1), (2 * (long * around + id(i, j + around - 1)) + 1, 1)]
    };
    let arc = |ends: [u32; 2]| GraphArc { ends, tag: Tag::Plain, collapsed: false, outside: [false; 2] };
    let cells = 0..long * around;
    let arcs: Vec<GraphArc> = (cells.clone().map(|k| arc([k, id(k % long + 1, k / long)])))
        .chain(cells.clone().map(|k| arc([k, id(k % long, k / long + 1)])))
        .collect();
    let node = GraphNode { position: DVec3::ZERO, anchor: Anchor::Surface };
    let nodes = vec![node; (long * around) as usize];
    let graph = EmbeddedGraph::new(nodes, &arcs, cells.map(darts));
    let (draft, report) = complete(&RunContext::silent(), graph, &torus).unwrap();
    assert_eq!((report.split_arcs as u32, quad_numbers(&draft).quads as u32), (long, long * (around + 1)));
}

#[test]
fn a_graph_on_another_surface_is_refused() {
    let graph = from_polygons(&circle(4), &[vec![0, 1, 2, 3]]);
    assert!(complete(&RunContext::silent(), graph, &SPHERE).is_err());
    assert!(complete(&RunContext::silent(), EmbeddedGraph::default(), &SPHERE).is_err());
}
