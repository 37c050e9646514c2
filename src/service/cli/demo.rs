//! `quadrille demo`: a real server, a real job over its own HTTP API, and the results as files.

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use reqwest::multipart::{Form, Part};
use serde::de::DeserializeOwned;

use crate::engine::mesh::shapes::{DEFAULT_SHAPE, sample};
use crate::service::app::{self, Role};
use crate::service::cli::failure::Failure;
use crate::service::cli::files::{Existing, Outputs};
use crate::service::cli::interrupt;
use crate::service::cli::sample::write_obj;
use crate::service::cli::serve::ServeArgs;
use crate::service::telemetry;
use crate::service::wire::{JobBody, JobStatus, Problem, ProblemBody, ProblemKind, ReportBody};

/// Where the results go.
const FOLDER: &str = "quadrille-demo";
const TRIANGLES: usize = 12_000;
const QUADS: u64 = 3_000;
/// Longest wait for one answer.
const REQUEST_TIMEOUT: Duration = Duration::from_secs(120);

/// Arguments of `demo`.
#[derive(Debug, Args)]
pub(super) struct DemoArgs {
    /// End after the results are saved instead of serving on
    #[arg(long)]
    once: bool,
    /// Sample surface to submit; `quadrille sample --list` shows all
    #[arg(long, value_name = "NAME", default_value = DEFAULT_SHAPE)]
    sample: String,
    #[command(flatten)]
    serve: ServeArgs,
}

pub(super) fn run(args: DemoArgs) -> Result<(), Failure> {
    let folder = PathBuf::from(FOLDER);
    let data = folder.join("data").to_string_lossy().into_owned();
    let mut defaults = vec![("data", data), ("log.filter", "warn".to_owned())];
    if args.once {
        // Nobody is told this address, so any port will do, and a server that is already there is left alone.
        defaults.push(("listen", "127.0.0.1:0".to_owned()));
    }
    let config = args.serve.config(&defaults)?;
    telemetry::start(&config.log).map_err(|error| Failure::Usage(error.to_string()))?;
    let soup = sample(&args.sample, TRIANGLES, 0.0, 0).ok_or_else(|| {
        Failure::Usage(format!("there is no sample {}; quadrille sample --list shows all", args.sample))
    })?;
    std::fs::create_dir_all(&folder)
        .map_err(|error| Failure::Usage(format!("cannot make the folder {FOLDER}: {error}")))?;

    interrupt::runtime()?.block_on(async {
        let running = app::start(config, Role::All).await?;
        let base = format!("http://{}", running.address());
        println!("Server    {base}");
        let outcome = tokio::select! {
            outcome = visit(&base, &args.sample, write_obj(&soup), &folder) => outcome,
            () = interrupt::asked_to_end() => Err(Problem::stopped(crate::engine::run::StopReason::Client).into()),
        };
        if outcome.is_ok() && !args.once {
            println!("Page      {base}/ (documentation at {base}/docs); Ctrl-C ends the server");
            interrupt::asked_to_end().await;
        }
        running.stop().await;
        outcome
    })
}

/// What any client would do: submit, wait, download.
async fn visit(base: &str, name: &str, mesh: Vec<u8>, folder: &Path) -> Result<(), Failure> {
    let client = reqwest::Client::builder().timeout(REQUEST_TIMEOUT).build().map_err(unreachable)?;
    let spec = serde_json::json!({"target": {"quads": QUADS}, "tags": ["demo"]}).to_string();
    println!("Mesh      {name}, {} bytes of OBJ", mesh.len());
    let form = Form::new()
        .part("mesh", Part::bytes(mesh.clone()).file_name(format!("{name}.obj")))
        .part("spec", Part::text(spec));
    let request = client.post(format!("{base}/v1/jobs")).header("Prefer", "wait=30").multipart(form);
    let mut job: JobBody = json(request).await?;
    println!("Job       {base}{}", job.urls.self_);
    while !job.status.is_final() {
        tokio::time::sleep(Duration::from_millis(200)).await;
        job = json(client.get(format!("{base}{}", job.urls.self_))).await?;
    }
    if job.status != JobStatus::Succeeded {
        return Err(job.problem.map_or_else(|| Problem::internal().into(), |body| failure(&body)));
    }

    // The folder is the demo's own: what an earlier one left there is replaced.
    let mut outputs = Outputs::new(Existing::Replace);
    outputs.add(&folder.join(format!("{name}.obj")), mesh)?;
    let downloads = [
        ("preview.png", job.urls.preview.clone()),
        ("report.json", job.urls.report.clone()),
        ("parameterisation.obj", format!("{}?format=obj", job.urls.parameterisation)),
        ("quads.glb", format!("{}?format=glb", job.urls.quad_mesh)),
        ("quads.obj", format!("{}?format=obj", job.urls.quad_mesh)),
    ];
    let mut report = None;
    for (file, path) in downloads {
        let bytes = match bytes(client.get(format!("{base}{path}"))).await {
            // A result of the fallback has no parameterisation; the demo shows what there is.
            Err(Failure::Problem(problem)) if problem.kind == ProblemKind::NoArtefact => continue,
            other => other?,
        };
        if file == "report.json" {
            report = serde_json::from_slice::<ReportBody>(&bytes).ok();
        }
        outputs.add(&folder.join(file), bytes)?;
    }
    outputs.publish()?;
    let report = report.ok_or_else(|| Failure::Output("the report could not be read".to_owned()))?;
    print_figures(&report);
    println!("Files     {}/", folder.display());
    Ok(())
}

fn print_figures(report: &ReportBody) {
    let quads = &report.quads;
    println!("Input     {} triangles, genus {}", report.input.triangles, report.input.genus);
    println!(
        "Quads     {} quads, {} vertices, {} irregular; certified: {}, level {}",
        quads.count,
        quads.vertices,
        quads.irregular_interior,
        report.certified,
        report.level.name()
    );
    println!(
        "Quality   RSD of edges {:.3}, of angles {:.3}; scaled Jacobian {:.2} to 1, mean {:.3}; distance {:.3} %",
        quads.rsd_edge,
        quads.rsd_angle,
        quads.scaled_jacobian.min,
        quads.scaled_jacobian.mean,
        100.0 * quads.hausdorff.max
    );
    if let Some(map) = &report.map {
        println!(
            "Map       {} triangles, {} singularities, {} flipped, seams exact to {:.1e}",
            map.triangles,
            map.singularities.len(),
            map.flipped,
            map.seam_residual
        );
    }
    let total = report.timings_ms.get("total").and_then(serde_json::Value::as_f64).unwrap_or_default();
    println!("Time      {:.2} s, {} MiB at most", total / 1000.0, report.peak_memory_bytes >> 20);
}

async fn json<T: DeserializeOwned>(request: reqwest::RequestBuilder) -> Result<T, Failure> {
    let bytes = bytes(request).await?;
    serde_json::from_slice(&bytes)
        .map_err(|error| Failure::Output(format!("the server's answer is not as agreed: {error}")))
}

async fn bytes(request: reqwest::RequestBuilder) -> Result<Vec<u8>, Failure> {
    let response = request.send().await.map_err(unreachable)?;
    let status = response.status();
    let body = response.bytes().await.map_err(unreachable)?.to_vec();
    if status.is_success() {
        return Ok(body);
    }
    match serde_json::from_slice::<ProblemBody>(&body) {
        Ok(problem) => Err(failure(&problem)),
        Err(_) => Err(Failure::Output(format!("the server answered {status}"))),
    }
}

fn unreachable(error: reqwest::Error) -> Failure {
    Failure::Output(format!("the server cannot be reached: {error}"))
}

/// A problem that came over the wire.
fn failure(body: &ProblemBody) -> Failure {
    let kind = ProblemKind::from_type_uri(&body.type_).unwrap_or(ProblemKind::Internal);
    Problem { errors: body.errors.clone(), ..Problem::new(kind, body.detail.clone()) }.into()
}
