use glam::DVec3;

use crate::engine::mesh::Surface;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::mesh::Topology;
use crate::engine::mesh::TriMesh;
use crate::engine::mesh::shapes::sample_surface;
use crate::engine::quad::Anchor;
use crate::engine::quad::QuadDraft;
use crate::engine::quad::QuadMesh;
use crate::engine::quad::improve::improve_connectivity;
use crate::engine::quad::improve::net::QuadNet;
use crate::engine::quad::improve::operations::candidates;
use crate::engine::quad::improve::reach_out;
use crate::engine::quad::improve::remove_doublets;
use crate::engine::quad::improve::valence::irregularity;
use crate::engine::quad::optimise::area_vector;
use crate::engine::quad::optimise::mean_edge;
use crate::engine::quad::optimise::quality;
use crate::engine::run::RunContext;
use crate::engine::run::StopReason;

/// Every triangle of a surface as three quads round its centre.
fn split(surface: &Surface) -> QuadDraft {
    let mesh = &surface.mesh;
    let mut positions = mesh.positions().to_vec();
    let curve = surface.features.halfedge_flags(mesh);
    let mut anchors = vec![Anchor::Surface; positions.len()];
    let mut edges: Vec<([u32; 2], u32)> = Vec::new();
    let mut feature_edges = Vec::new();
    for h in (0..mesh.n_halfedges()).filter(|&h| mesh.is_edge_owner(h)) {
        let (a, b) = (mesh.origin(h), mesh.target(h));
        let middle = positions.len() as u32;
        edges.push(([a.min(b), a.max(b)], middle));
        positions.push(mesh.position(a).midpoint(mesh.position(b)));
        anchors.push(if curve[h] { Anchor::Curve } else { Anchor::Surface });
        if curve[h] {
            anchors[a as usize] = Anchor::Curve;
            anchors[b as usize] = Anchor::Curve;
        }
        if surface.features.is_edge(a, b) {
            feature_edges.extend([[a, middle], [b, middle]]);
        }
    }
    feature_edges.sort_unstable();
    edges.sort_unstable();
    surface.features.corners.iter().for_each(|&c| anchors[c as usize] = Anchor::Corner(c));
    let middle = |a: u32, b: u32| edges[edges.partition_point(|e| e.0 < [a.min(b), a.max(b)])].1;
    let mut quads = Vec::new();
    for (f, &[a, b, c]) in mesh.faces().iter().enumerate() {
        let centre = positions.len() as u32;
        positions.push(mesh.triangle(f).into_iter().sum::<DVec3>() / 3.0);
        anchors.push(Anchor::Surface);
        for [v, next, prev] in [[a, b, c], [b, c, a], [c, a, b]] {
            quads.push([v, middle(v, next), centre, middle(v, prev)]);
        }
    }
    QuadDraft { mesh: QuadMesh { positions, quads }, anchors, feature_edges }
}

/// Topology of quads, if they are a manifold: each as four triangles round its centre.
fn topology(mesh: &QuadMesh) -> Topology {
    let mut positions = mesh.positions.clone();
    let mut faces = Vec::new();
    for q in &mesh.quads {
        let centre = positions.len() as u32;
        positions.push(DVec3::ZERO);
        faces.extend((0..4).map(|k| [q[k], q[(k + 1) % 4], centre]));
    }
    TriMesh::try_new(positions, faces).unwrap().topology()
}

fn irregular(draft: &QuadDraft) -> usize {
    let net = QuadNet::new(draft);
    (0..net.n_vertices() as u32).filter(|&v| irregularity(&net, &draft.mesh.positions, v) > 0.0).count()
}

fn improved(surface: &Surface, draft: &QuadDraft) -> QuadDraft {
    let index = SurfaceIndex::new(&surface.mesh);
    improve_connectivity(&RunContext::silent(), surface, &index, draft.clone()).unwrap()
}

fn worst(draft: &QuadDraft) -> f64 {
    let own = |p: &[DVec3; 4]| quality(p, area_vector(p).normalize_or_zero());
    let all = draft.mesh.quads.iter().map(|q| q.map(|v| draft.mesh.positions[v as usize]));
    all.map(|p| own(&p)).fold(f64::INFINITY, f64::min)
}

/// What must survive: the chains of feature edges, the boundary, the anchored vertices, by position.
fn skeleton(draft: &QuadDraft) -> (Vec<[u64; 3]>, Vec<[[u64; 3]; 2]>) {
    let key = |v: u32| draft.mesh.positions[v as usize].to_array().map(f64::to_bits);
    let held = (0..draft.anchors.len()).filter(|&v| draft.anchors[v] != Anchor::Surface);
    let mut held: Vec<_> = held.map(|v| key(v as u32)).collect();
    let mut edges: Vec<_> = draft.feature_edges.iter().map(|e| e.map(key)).collect();
    edges.iter_mut().for_each(|e| e.sort_unstable());
    held.sort_unstable();
    edges.sort_unstable();
    (held, edges)
}

#[test]
fn splits_of_triangles_become_more_regular_and_keep_topology_and_features() {
    for (name, triangles) in [("genus2", 900), ("half_pipe", 450), ("cube", 300), ("gear", 1300)] {
        let surface = sample_surface(name, triangles).unwrap();
        let draft = split(&surface);
        let result = improved(&surface, &draft);
        let (before, after) = (irregular(&draft), irregular(&result));
        assert!(2 * after < before, "{name}: {before} to {after}");
        assert_eq!(topology(&result.mesh), topology(&draft.mesh));
        assert_eq!(skeleton(&result), skeleton(&draft));
        assert!(worst(&result) >= worst(&draft).min(0.25) - 1e-12);
    }
}

#[test]
fn a_regular_grid_stays_bit_for_bit() {
    let surface = sample_surface("torus", 450).unwrap();
    let (n, m) = (24, 12);
    let at = |i: usize, j: usize| ((i % n) * m + j % m) as u32;
    let spot = |k: usize| {
        let (s, c) = (std::f64::consts::TAU * (k / m) as f64 / n as f64).sin_cos();
        let (t, d) = (std::f64::consts::TAU * (k % m) as f64 / m as f64).sin_cos();
        DVec3::new((1.0 + 0.4 * d) * c, (1.0 + 0.4 * d) * s, 0.4 * t)
    };
    let quads = (0..n * m).map(|k| (k / m, k % m));
    let quads = quads.map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]).collect();
    let mesh = QuadMesh { positions: (0..n * m).map(spot).collect(), quads };
    let draft = QuadDraft { anchors: vec![Anchor::Surface; mesh.positions.len()], mesh, feature_edges: vec![] };
    assert_eq!(improved(&surface, &draft), draft);
}

#[test]
fn every_candidate_that_is_applied_keeps_a_manifold_and_is_undone_exactly() {
    let surface = sample_surface("genus2", 700).unwrap();
    let draft = split(&surface);
    let whole = topology(&draft.mesh);
    let mut net = QuadNet::new(&draft);
    let (mut applied, mut kept) = (0, 0);
    for v in (0..net.n_vertices() as u32).step_by(29) {
        for mut change in candidates(&net, &[v]) {
            let quads = net.quads.clone();
            if net.try_apply(&mut change) {
                let alive: Vec<[u32; 4]> =
                    net.quads.iter().copied().filter(|q| *q != crate::engine::quad::improve::net::DEAD).collect();
                let mut used: Vec<u32> = alive.iter().flatten().copied().collect();
                used.sort_unstable();
                used.dedup();
                let number = |v: u32| used.binary_search(&v).unwrap() as u32;
                let mesh = QuadMesh {
                    positions: vec![DVec3::ZERO; used.len()],
                    quads: alive.iter().map(|q| q.map(number)).collect(),
                };
                assert_eq!(topology(&mesh), whole);
                applied += 1;
                // Every now and then a change stays, so that later ones meet odd neighbourhoods.
                if applied % 5 == 0 {
                    kept += 1;
                    break;
                }
                net.apply(&mut change);
            }
            assert_eq!(net.quads, quads);
        }
    }
    assert!(applied > 100 && kept > 20, "{applied} {kept}");
}

/// The draft with a quad cut in two along a bent diagonal: its middle, a new vertex, has two quads.
fn with_doublet(draft: &QuadDraft, quad: usize, anchor: Anchor) -> QuadDraft {
    let mut draft = draft.clone();
    let [a, b, c, d] = draft.mesh.quads[quad];
    let v = draft.mesh.positions.len() as u32;
    let centre: DVec3 = [a, b, c, d].map(|v| draft.mesh.positions[v as usize]).iter().sum::<DVec3>() / 4.0;
    draft.mesh.positions.push(centre);
    draft.anchors.push(anchor);
    draft.mesh.quads[quad] = [a, b, c, v];
    draft.mesh.quads.push([a, v, c, d]);
    draft
}

#[test]
fn doublets_are_removed_and_what_does_not_fit_is_left_alone() {
    let surface = sample_surface("sphere", 600).unwrap();
    let draft = with_doublet(&split(&surface), 100, Anchor::Surface);
    let result = improved(&surface, &draft);
    let net = QuadNet::new(&result);
    assert!((0..net.n_vertices() as u32).all(|v| net.valence(v) > 2));
    let broken = QuadDraft { anchors: vec![], ..draft.clone() };
    assert_eq!(improved(&surface, &broken), broken);
    let ctx = RunContext::silent();
    ctx.stop(StopReason::Client);
    let index = SurfaceIndex::new(&surface.mesh);
    assert!(improve_connectivity(&ctx, &surface, &index, draft).is_err());
}

#[test]
fn doublets_get_a_third_quad_or_go_and_what_is_anchored_stays() {
    let surface = sample_surface("sphere", 900).unwrap();
    let index = SurfaceIndex::new(&surface.mesh);
    let ctx = RunContext::silent();
    let good = split(&surface);
    assert_eq!(remove_doublets(&ctx, &surface, &index, &good).unwrap(), None);
    let doublets = |d: &QuadDraft| {
        let net = QuadNet::new(d);
        (0..net.n_vertices() as u32).filter(|&v| net.valence(v) == 2).count()
    };
    for anchor in [Anchor::Surface, Anchor::Corner(0)] {
        let draft = with_doublet(&good, 600, anchor);
        let place = *draft.mesh.positions.last().unwrap();
        assert_eq!(doublets(&draft), 1);
        let single = remove_doublets(&ctx, &surface, &index, &draft).unwrap().unwrap();
        assert_eq!(doublets(&single), 0);
        assert_eq!(topology(&single.mesh), topology(&good.mesh));
        let up = |q: &[u32; 4]| {
            let p = q.map(|v| single.mesh.positions[v as usize]);
            area_vector(&p).dot(p.iter().sum::<DVec3>()) > 0.0
        };
        assert!(single.mesh.quads.iter().all(up));
        let corners = single.anchors.iter().zip(&single.mesh.positions).filter(|(a, _)| **a == Anchor::Corner(0));
        let corners: Vec<DVec3> = corners.map(|(_, &p)| p).collect();
        assert_eq!(corners, if anchor == Anchor::Surface { vec![] } else { vec![place] });
        let far = |p: &&DVec3| p.distance(place) > 0.6;
        let kept: Vec<&DVec3> = single.mesh.positions.iter().filter(far).collect();
        assert_eq!(kept, good.mesh.positions.iter().filter(far).collect::<Vec<_>>());
    }
    ctx.stop(StopReason::Client);
    assert!(remove_doublets(&ctx, &surface, &index, &with_doublet(&good, 600, Anchor::Surface)).is_err());
}

#[test]
fn a_horn_that_the_quads_cut_off_is_reached() {
    // A sphere of quads, and a surface that has grown a horn since.
    let sphere = sample_surface("sphere", 500).unwrap();
    let draft = split(&sphere);
    let fine = sample_surface("sphere", 8000).unwrap();
    let top = fine.mesh.position(77).normalize();
    let h = mean_edge(&draft);
    let grown = |p: &DVec3| *p * (1.0 + 1.5 * h * (1.0 - p.normalize().distance(top) / (1.5 * h)).max(0.0));
    let positions: Vec<DVec3> = fine.mesh.positions().iter().map(grown).collect();
    let mesh = TriMesh::try_new(positions, fine.mesh.faces().to_vec()).unwrap();
    let surface = Surface { mesh, features: fine.features };
    let index = SurfaceIndex::new(&surface.mesh);
    let ctx = RunContext::silent();
    let tip = surface.mesh.position(77);
    let nearest = |d: &QuadDraft| d.mesh.positions.iter().map(|p| p.distance(tip)).fold(f64::INFINITY, f64::min);
    let reached = reach_out(&ctx, &surface, &index, &draft, h).unwrap().unwrap();
    assert!(nearest(&reached) < 0.5 * nearest(&draft), "{} {}", nearest(&reached), nearest(&draft));
    assert_eq!(reached.mesh.quads, draft.mesh.quads);
    assert!(worst(&reached) >= worst(&draft).min(0.3) - 1e-9);
    // On its own surface there is nothing to reach for.
    assert_eq!(reach_out(&ctx, &sphere, &SurfaceIndex::new(&sphere.mesh), &draft, h).unwrap(), None);
}
