//! A driver that does what a job's tags say, so that the life of jobs can be tested without geometry.

use std::time::Duration;

use quadrille::engine::run::{RunContext, Stage};
use quadrille::service::jobs::{Driver, InputFile, Inspection, Made, Products};
use quadrille::service::wire::{Problem, ProblemKind, ReportBody, ResolvedSpec};

/// Tags: `slow` runs until it is stopped, `deaf` runs for two seconds and cannot be stopped, `panic`, `abort` (the whole
/// process), `fail`; anything else succeeds at once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scripted;

impl Driver for Scripted {
    fn inspect(&self, input: &InputFile, _: bool) -> Result<Inspection, Problem> {
        if input.bytes.starts_with(b"bad") {
            return Err(Problem::new(ProblemKind::UnreadableMesh, "It says bad."));
        }
        Ok(Inspection { format: "obj".to_owned(), vertices: Some(3), faces: Some(1) })
    }

    fn run(&self, context: &RunContext, input: &InputFile, spec: &ResolvedSpec) -> Result<Products, Problem> {
        let has = |tag: &str| spec.options.tags.iter().any(|known| known == tag);
        context.stage(Stage::Read, |_| self.play(context, &has))?;
        context.advance(0.5);
        context.stage(Stage::Write, |_| Ok::<_, Stopped>(()))?;
        let file = |name, media_type| Made { name, media_type, bytes: [name.as_bytes(), &input.bytes].concat() };
        Ok(Products {
            files: vec![
                file("quad-mesh.obj", "model/obj"),
                file("quad-mesh.glb", "model/gltf-binary"),
                file("quad-mesh.ply", "application/ply"),
                file("quad-mesh.usda", "model/vnd.usda"),
            ],
            report: report(),
        })
    }

    fn preview(&self, quads: &[u8], size: u32) -> Result<Vec<u8>, Problem> {
        Ok(format!("{size} pixels of {} bytes", quads.len()).into_bytes())
    }
}

impl Scripted {
    fn play(self, context: &RunContext, has: &dyn Fn(&str) -> bool) -> Result<(), Stopped> {
        if has("abort") {
            std::process::abort();
        }
        assert!(!has("panic"), "on purpose");
        if has("deaf") {
            std::thread::sleep(Duration::from_secs(2));
        }
        if has("fail") {
            return Err(Stopped(Problem::new(ProblemKind::NoQuadMesh, "No quads today.").at(Stage::Extract)));
        }
        while has("slow") {
            context.check().map_err(|stopped| Stopped(Problem::stopped(stopped.0)))?;
            std::thread::sleep(Duration::from_millis(5));
        }
        Ok(())
    }
}

struct Stopped(Problem);

impl From<quadrille::engine::run::Cancelled> for Stopped {
    fn from(stopped: quadrille::engine::run::Cancelled) -> Self {
        Self(Problem::stopped(stopped.0))
    }
}

impl From<Stopped> for Problem {
    fn from(stopped: Stopped) -> Self {
        stopped.0
    }
}

fn report() -> ReportBody {
    let spread = serde_json::json!({"max": 0.0, "mean": 0.0});
    serde_json::from_value(serde_json::json!({
        "version": "0", "method": "quadcover", "certified": true, "level": "L0", "component_levels": ["L0"],
        "input": {"vertices": 3, "triangles": 1, "components": 1, "boundaries": 1, "genus": 0, "feature_edges": 0,
                  "repairs": {}},
        "quads": {"count": 3, "vertices": 7, "irregular_interior": 1, "irregular_boundary": 0, "valences": {"3": 1},
                  "components": 1, "boundaries": 1, "genus": 0, "rsd_edge": 0.0, "rsd_angle": 0.0,
                  "scaled_jacobian": {"min": 1.0, "mean": 1.0}, "hausdorff": spread, "feature_error": spread,
                  "flipped": 0},
        "map": null, "timings_ms": {"total": 1.0}, "peak_memory_bytes": 0, "cut_by_deadline": false, "warnings": [],
        "edge_length": 1.0, "features": {"detected": 0, "kept": 0, "dropped": 0, "given_up": []}, "symmetry": []
    }))
    .expect("the shape of a report")
}
