//! Where clients' wishes become rows: submit, cancel, delete.

use std::time::Duration;

use serde_json::json;
use sha2::{Digest, Sha256};
use uuid::Uuid;

use crate::engine::run::StopReason;
use crate::service::config::{JobsConfig, LimitsConfig};
use crate::service::jobs::{Live, SqliteQueue, Ticket, TicketQueue, hex};
use crate::service::store::assets::Adopted;
use crate::service::store::{AssetRow, Cancelling, JobRow, NewAsset, NewJob, Store, assets, jobs};
use crate::service::wire::{InputBody, JobStatus, Problem, ProblemKind, ResolvedSpec, Violation};

/// The mesh of an order.
#[derive(Clone, Debug)]
pub enum OrderMesh {
    /// Just uploaded; its bytes lie in the object store.
    New(NewAsset),
    /// Uploaded before.
    Known(AssetRow),
}

/// A request for a job that was found valid.
#[derive(Clone, Debug)]
pub struct Order {
    /// The mesh.
    pub mesh: OrderMesh,
    /// The spec.
    pub spec: ResolvedSpec,
    /// The client's key.
    pub idempotency_key: Option<String>,
}

/// An accepted order.
#[derive(Clone, Debug)]
pub struct Accepted {
    /// The job.
    pub job: JobRow,
    /// Whether it is a new one and not that of an earlier request with the same key.
    pub fresh: bool,
}

/// Accepts, cancels and deletes. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Desk {
    /// Rows and blobs.
    pub store: Store,
    /// Where tickets go.
    pub queue: SqliteQueue,
    /// Shortcuts within this process.
    pub live: Live,
    /// Retention.
    pub jobs: JobsConfig,
    /// Length of the line, longest deadline.
    pub limits: LimitsConfig,
}

impl Desk {
    /// Accepts an order: row and ticket in one transaction, so a job that was acknowledged will run.
    pub async fn submit(&self, order: Order) -> Result<Accepted, Problem> {
        self.judge(&order.spec)?;
        let uploaded = match &order.mesh {
            OrderMesh::New(new) => Some(new.blob.clone()),
            OrderMesh::Known(_) => None,
        };
        let written = self.write(order).await;
        let unused = written.as_ref().map_or(uploaded.as_ref(), |(_, unused)| unused.as_ref());
        if let Some(blob) = unused {
            self.store.blobs().remove(blob).await?;
        }
        let (accepted, _) = written?;
        if accepted.fresh {
            metrics::counter!("quadrille_jobs_accepted_total").increment(1);
            self.live.ring(accepted.job.id);
        }
        Ok(accepted)
    }

    fn judge(&self, spec: &ResolvedSpec) -> Result<(), Problem> {
        let longest = self.limits.deadline_s;
        if spec.options.deadline_s > longest {
            let message = format!("must be at most {longest} on this server, not {}", spec.options.deadline_s);
            return Err(Problem::invalid_spec(vec![Violation::new("/deadline_s", message)]));
        }
        Ok(())
    }

    /// The job and a blob that nothing needs any more.
    async fn write(&self, order: Order) -> Result<(Accepted, Option<String>), Problem> {
        let (sha256, uploaded) = match &order.mesh {
            OrderMesh::New(new) => (&new.sha256, Some(&new.blob)),
            OrderMesh::Known(known) => (&known.sha256, None),
        };
        let fingerprint = hex(&Sha256::digest(format!("{sha256}\n{}", json!(order.spec.request))));
        let mut tx = self.store.write().await?;
        if let Some(key) = &order.idempotency_key
            && let Some(job) = jobs::by_key(&mut tx, key).await?
        {
            if job.fingerprint != fingerprint {
                let detail = "This Idempotency-Key was used with another mesh or spec; use a new key for a new job.";
                return Err(Problem::new(ProblemKind::IdempotencyConflict, detail));
            }
            return Ok((Accepted { job, fresh: false }, uploaded.cloned()));
        }
        if self.store.waiting(&mut tx).await? >= self.limits.queued_jobs {
            let detail = format!("{} jobs are waiting, and no more are accepted.", self.limits.queued_jobs);
            return Err(Problem { retry_after: Some(30), ..Problem::new(ProblemKind::QueueFull, detail) });
        }
        let (Adopted { asset, unused }, format) = match &order.mesh {
            OrderMesh::New(new) => (assets::adopt(&mut tx, self.store.blobs(), new).await?, new.format.clone()),
            OrderMesh::Known(known) => (Adopted { asset: known.clone(), unused: None }, known.format.clone()),
        };
        let input = InputBody { sha256: asset.sha256, bytes: asset.bytes, format, ..InputBody::default() };
        let (id, number, priority) = (Uuid::now_v7(), Uuid::now_v7(), order.spec.options.priority);
        let job = NewJob {
            id,
            ticket: number,
            spec: order.spec.request,
            asset_id: asset.id,
            input,
            idempotency_key: order.idempotency_key,
            fingerprint,
        };
        jobs::insert(&mut tx, &job).await?;
        self.queue.enqueue(&mut tx, Ticket { job: id, number }, priority, Duration::ZERO).await?;
        tx.commit().await.map_err(crate::service::store::StoreError::from)?;
        let job = self.store.job(id).await?.ok_or_else(Problem::internal)?;
        Ok((Accepted { job, fresh: true }, unused))
    }

    /// Cancels a job; a finished one stays as it is.
    pub async fn cancel(&self, id: Uuid) -> Result<Cancelling, Problem> {
        let problem = Problem::stopped(StopReason::Client).body(Some(format!("/v1/jobs/{id}")));
        let keep_ms = i64::try_from(self.jobs.retention.as_millis()).unwrap_or(i64::MAX);
        let done = self.store.request_cancel(id, &problem, keep_ms).await?;
        match done {
            Cancelling::Done => {
                metrics::counter!("quadrille_jobs_finished_total", "status" => JobStatus::Cancelled.name())
                    .increment(1);
                self.live.ring(id);
            }
            Cancelling::Asked => self.live.stop(id, StopReason::Client),
            Cancelling::Finished | Cancelling::Unknown => {}
        }
        Ok(done)
    }

    /// Removes a job with all its files, stopping it first; `false` if there is none.
    pub async fn delete(&self, id: Uuid) -> Result<bool, Problem> {
        let known = self.store.delete_job(id).await?;
        self.live.stop(id, StopReason::Client);
        self.live.ring(id);
        Ok(known)
    }
}
