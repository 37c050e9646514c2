use crate::engine::certify::{certify, measure_topology};
use crate::engine::mend::faults::{FAULTS, inject};
use crate::engine::mend::ground::Ground;
use crate::engine::mend::{MendOptions, Mended, mend};
use crate::engine::mesh::shapes::sample_surface;
use crate::engine::mesh::{Surface, SurfaceIndex};
use crate::engine::methods::{Method, Parameters, Product, TrianglePairs};
use crate::engine::problem::{Align, Boundary, Optimise, Wishes, WorkingMesh, split};
use crate::engine::quad::improve::improve_connectivity;
use crate::engine::quad::optimise::mean_edge;
use crate::engine::quad::{Anchor, OptimiseOptions, QuadDraft, optimise};
use crate::engine::run::{RunContext, StopReason};
use rayon::prelude::*;

const SAMPLES: [&str; 10] = [
    "sphere",
    "ellipsoid",
    "torus",
    "genus2",
    "cube",
    "rounded_box",
    "half_pipe",
    "plate_with_holes",
    "dumbbell",
    "noisy_blob",
];

/// Quads of pairs of triangles.
fn pairs(surface: &Surface, quads: usize) -> QuadDraft {
    let wishes = Wishes {
        boundary: Boundary::Align,
        align: Align::Smooth,
        smoothing: 0.5,
        optimise: Optimise::None,
        working_mesh: WorkingMesh::Auto,
        adapts_count: true,
    };
    let edge_length = (surface.mesh.total_area() / quads as f64).sqrt();
    let problem = split(surface, edge_length, true, &wishes, &[], &[], &[]).remove(0);
    match TrianglePairs.propose(&RunContext::silent(), &problem, &Parameters::default()) {
        Ok(Product::Quads(mut draft)) => {
            // Corners are numbered as in the problem.
            for anchor in &mut draft.anchors {
                if let Anchor::Corner(v) = *anchor {
                    *anchor = Anchor::Corner(problem.vertices[v as usize]);
                }
            }
            draft
        }
        other => panic!("{other:?}"),
    }
}

/// A sample with a good draft on it.
fn good(name: &str, triangles: usize, quads: usize) -> (Surface, SurfaceIndex, QuadDraft) {
    let surface = sample_surface(name, triangles).unwrap();
    let index = SurfaceIndex::new(&surface.mesh);
    let ctx = RunContext::silent();
    let draft = pairs(&surface, quads);
    let draft = improve_connectivity(&ctx, &surface, &index, draft).unwrap();
    let options = OptimiseOptions {
        iterations: 12,
        edge_length: mean_edge(&draft),
        log_size: Vec::new(),
        strokes: Vec::new(),
        held: Vec::new(),
    };
    let draft = optimise(&ctx, &surface, &index, draft, &options).unwrap();
    let draft = mended(&surface, &index, draft).draft;
    (surface, index, draft)
}

fn mended(surface: &Surface, index: &SurfaceIndex, draft: QuadDraft) -> Mended {
    mend(&RunContext::silent(), surface, index, draft, &MendOptions::default()).unwrap()
}

fn violations(surface: &Surface, index: &SurfaceIndex, draft: &QuadDraft) -> Vec<String> {
    let certificate = certify(&RunContext::silent(), surface, index, &draft.mesh, 0.0).unwrap();
    certificate.violations.iter().map(ToString::to_string).collect()
}

/// All quads outside the discs, and the vertices that they have, are in the mended draft bit for bit and in order.
fn assert_rest_unchanged(before: &QuadDraft, after: &Mended) {
    let key = |draft: &QuadDraft, v: u32| draft.mesh.positions[v as usize].to_array().map(f64::to_bits);
    let of = |draft: &QuadDraft, quad: &[u32; 4]| quad.map(|v| key(draft, v));
    let kept = (0u32..).zip(&before.mesh.quads).filter(|(q, _)| after.changed.binary_search(q).is_err());
    let mut left = after.draft.mesh.quads.iter();
    let mut vertices: Vec<(u32, u32)> = Vec::new();
    for (q, quad) in kept {
        let wanted = of(before, quad);
        let found = left.find(|other| of(&after.draft, other) == wanted);
        let found = found.unwrap_or_else(|| panic!("quad {q} is not in its place"));
        vertices.extend((0..4).map(|k| (quad[k], found[k])));
    }
    vertices.sort_unstable();
    vertices.dedup();
    assert!(vertices.windows(2).all(|w| w[0].0 < w[1].0 && w[0].1 < w[1].1), "vertices keep their order");
    assert!(vertices.iter().all(|v| before.anchors[v.0 as usize] == after.draft.anchors[v.1 as usize]));
}

#[test]
fn a_good_draft_is_left_as_it_is() {
    for name in ["torus", "cube"] {
        let (surface, index, draft) = good(name, 1500, 400);
        assert_eq!(violations(&surface, &index, &draft), [""; 0], "{name}");
        let again = mended(&surface, &index, draft.clone());
        assert_eq!((again.found, again.discs, &again.changed), (0, 0, &Vec::new()), "{name}");
        assert_eq!(again.draft, draft, "{name}");
    }
}

#[test]
fn injected_faults_are_mended_where_they_are() {
    let one = |(s, name): (usize, &&str)| {
        let (surface, index, draft) = good(name, 1500, 400);
        assert_eq!(violations(&surface, &index, &draft), [""; 0], "{name}");
        let topology = measure_topology(&draft.mesh).unwrap().components;
        let ground = Ground::new(&surface, &index, mean_edge(&draft), 0.0);
        let mut lost = Vec::new();
        let (mut tried, mut seed) = (0, 10_000 * s as u64);
        while tried < 20 {
            let fault = FAULTS[tried % FAULTS.len()];
            seed += 1;
            assert!(seed < 10_000 * s as u64 + 2_000, "{name}: no place for {fault:?}");
            let Some(bad) = inject(&ground, &draft, fault, seed) else { continue };
            let after = mended(&surface, &index, bad.clone());
            if after.found == 0 {
                continue;
            }
            tried += 1;
            assert_rest_unchanged(&bad, &after);
            assert_eq!(measure_topology(&after.draft.mesh).unwrap().components, topology, "{name} {fault:?} {seed}");
            let said = violations(&surface, &index, &after.draft);
            if !said.is_empty() || !after.left.is_empty() {
                lost.push(format!("{name} {fault:?} {seed}: {} left, {said:?}", after.left.len()));
            }
        }
        lost
    };
    let lost: Vec<String> = SAMPLES.par_iter().enumerate().map(one).collect::<Vec<_>>().concat();
    assert!(lost.len() <= 4, "{} of 200 faults mended; lost: {lost:#?}", 200 - lost.len());
}

#[test]
fn many_faults_at_once_are_mended_alike_by_any_number_of_threads() {
    let (surface, index, draft) = good("torus", 1500, 900);
    let ground = Ground::new(&surface, &index, mean_edge(&draft), 0.0);
    let mut bad = draft;
    let mut made = 0;
    for seed in 0..24 {
        if let Some(worse) = inject(&ground, &bad, FAULTS[seed % FAULTS.len()], 77 * seed as u64) {
            bad = worse;
            made += 1;
        }
    }
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| mended(&surface, &index, bad.clone()))
    };
    let one = with(1);
    assert!(made > 12 && one.found > 12 && one.discs > 3, "{made} made, {} found", one.found);
    assert_eq!((one.left.len(), violations(&surface, &index, &one.draft)), (0, Vec::new()));
    assert_eq!(one, with(3));
}

#[test]
fn what_left_its_curve_or_its_corner_comes_back() {
    for name in ["cube", "half_pipe"] {
        let (surface, index, draft) = good(name, 1500, 400);
        for anchor in 0..3 {
            let is_meant = |a: &Anchor| match a {
                Anchor::Corner(_) => anchor == 0,
                Anchor::Curve => anchor > 0,
                Anchor::Surface => false,
            };
            let all: Vec<usize> = (0..draft.anchors.len()).filter(|&v| is_meant(&draft.anchors[v])).collect();
            let v = all[all.len() * anchor / 3];
            let mut bad = draft.clone();
            // Off by half an edge, in a direction that no curve has.
            bad.mesh.positions[v] += 0.5 * mean_edge(&draft) * glam::dvec3(0.57, 0.61, -0.55);
            let after = mended(&surface, &index, bad);
            assert!(after.found > 0 && after.left.is_empty(), "{name} {anchor}");
            assert_eq!(violations(&surface, &index, &after.draft), [""; 0], "{name} {anchor}");
        }
    }
}

#[test]
fn a_stopped_run_mends_nothing() {
    let (surface, index, draft) = good("sphere", 700, 200);
    let ctx = RunContext::silent();
    ctx.stop(StopReason::Client);
    assert!(mend(&ctx, &surface, &index, draft, &MendOptions::default()).is_err());
}
