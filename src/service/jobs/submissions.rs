//! Requests of clients become rows: submit, cancel, delete.

use std::time::Duration;

use sha2::{Digest, Sha256};
use uuid::Uuid;

use crate::engine::run::StopReason;
use crate::service::config::{JobsConfig, LimitsConfig};
use crate::service::jobs::{Live, SqliteQueue, Ticket, TicketQueue, hex};
use crate::service::store::assets::Adopted;
use crate::service::store::{AssetRow, Cancelling, JobFilter, JobRow, NewAsset, NewJob, Store, assets, jobs};
use crate::service::wire::{InputBody, JobStatus, Problem, ProblemKind, SpecDocument, Violation};

/// Jobs that are cancelled or removed in one transaction; others may write between two.
const BATCH: u32 = 100;

/// The mesh of a new job.
#[derive(Clone, Debug)]
pub enum JobMesh {
    /// Just uploaded; its bytes lie in the object store.
    New(NewAsset),
    /// Uploaded before.
    Known(AssetRow),
}

/// A request for a job that was found valid.
#[derive(Clone, Debug)]
pub struct JobRequest {
    /// The mesh.
    pub mesh: JobMesh,
    /// The spec.
    pub spec: SpecDocument,
    /// The client's key.
    pub idempotency_key: Option<String>,
}

/// An accepted job.
#[derive(Clone, Debug)]
pub struct Accepted {
    /// The job.
    pub job: JobRow,
    /// Whether it is a new one and not that of an earlier request with the same key.
    pub fresh: bool,
}

/// Accepts, cancels and deletes. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Jobs {
    /// Rows and blobs.
    pub store: Store,
    /// Where tickets go.
    pub queue: SqliteQueue,
    /// Runs and changes within this process.
    pub live: Live,
    /// Retention.
    pub jobs: JobsConfig,
    /// Length of the queue, longest deadline.
    pub limits: LimitsConfig,
}

impl Jobs {
    /// Accepts a new job: row and ticket in one transaction, so a job that was acknowledged will run.
    pub async fn submit(&self, request: JobRequest) -> Result<Accepted, Problem> {
        self.judge(&request.spec)?;
        let uploaded = match &request.mesh {
            JobMesh::New(new) => Some(new.blob.clone()),
            JobMesh::Known(_) => None,
        };
        let written = self.write(request).await;
        let unused = written.as_ref().map_or(uploaded.as_ref(), |(_, unused)| unused.as_ref());
        if let Some(blob) = unused {
            self.store.blobs().remove(blob).await?;
        }
        let (accepted, _) = written?;
        if accepted.fresh {
            metrics::counter!("quadrille_jobs_accepted_total").increment(1);
            self.live.notify(accepted.job.id);
        }
        Ok(accepted)
    }

    fn judge(&self, spec: &SpecDocument) -> Result<(), Problem> {
        let longest = self.limits.deadline_s;
        if spec.deadline_s > longest {
            let message = format!("must be at most {longest} on this server, not {}", spec.deadline_s);
            return Err(Problem::invalid_spec(vec![Violation::new("/deadline_s", message)]));
        }
        Ok(())
    }

    /// The job and a blob that nothing needs any more.
    async fn write(&self, request: JobRequest) -> Result<(Accepted, Option<String>), Problem> {
        let (sha256, uploaded) = match &request.mesh {
            JobMesh::New(new) => (&new.sha256, Some(&new.blob)),
            JobMesh::Known(known) => (&known.sha256, None),
        };
        let fingerprint = hex(&Sha256::digest(format!("{sha256}\n{}", hex(&request.spec.sha256))));
        let mut tx = self.store.write().await?;
        if let Some(key) = &request.idempotency_key
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
        // The same bytes may have come under another name first.
        let (Adopted { asset, unused }, name, format) = match &request.mesh {
            JobMesh::New(new) => {
                (assets::adopt(&mut tx, self.store.blobs(), new).await?, new.name.clone(), new.format.clone())
            }
            JobMesh::Known(known) => {
                (Adopted { asset: known.clone(), unused: None }, known.name.clone(), known.format.clone())
            }
        };
        let input = InputBody { sha256: asset.sha256, bytes: asset.bytes, name, format, ..InputBody::default() };
        let (id, number, priority) = (Uuid::now_v7(), Uuid::now_v7(), request.spec.priority);
        let job = NewJob {
            id,
            ticket: number,
            spec: request.spec,
            asset_id: asset.id,
            input,
            idempotency_key: request.idempotency_key,
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
        Ok(self.cancel_each(&[id]).await?.pop().unwrap_or(Cancelling::Unknown))
    }

    async fn cancel_each(&self, ids: &[Uuid]) -> Result<Vec<Cancelling>, Problem> {
        let problem = |id| Problem::stopped(StopReason::Client).body(Some(format!("/v1/jobs/{id}")));
        let keep_ms = i64::try_from(self.jobs.retention.as_millis()).unwrap_or(i64::MAX);
        let done = self.store.request_cancel(ids, problem, keep_ms).await?;
        for (&id, done) in ids.iter().zip(&done) {
            match done {
                Cancelling::Done => {
                    metrics::counter!("quadrille_jobs_finished_total", "status" => JobStatus::Cancelled.name())
                        .increment(1);
                    self.live.notify(id);
                }
                Cancelling::Asked => self.live.stop(id, StopReason::Client),
                Cancelling::Finished | Cancelling::Unknown => {}
            }
        }
        Ok(done)
    }

    /// Cancels all jobs that pass `filter` and are not finished; their number.
    pub async fn cancel_all(&self, mut filter: JobFilter) -> Result<u64, Problem> {
        let unfinished = [JobStatus::Queued, JobStatus::Running];
        let wanted = |status: &JobStatus| filter.statuses.is_empty() || filter.statuses.contains(status);
        filter.statuses = unfinished.into_iter().filter(wanted).collect();
        if filter.statuses.is_empty() {
            return Ok(0);
        }
        let mut cancelled = 0;
        while let Some(ids) = self.next_batch(&mut filter).await? {
            let done = self.cancel_each(&ids).await?;
            cancelled += done.iter().filter(|done| matches!(done, Cancelling::Done | Cancelling::Asked)).count();
        }
        Ok(cancelled as u64)
    }

    /// The newest jobs that pass `filter`, which then goes on behind them.
    async fn next_batch(&self, filter: &mut JobFilter) -> Result<Option<Vec<Uuid>>, Problem> {
        let ids = self.store.job_ids(filter, BATCH).await?;
        filter.before = ids.last().copied();
        Ok((!ids.is_empty()).then_some(ids))
    }

    /// Removes a job with all its files, stopping it first; `false` if there is none.
    pub async fn delete(&self, id: Uuid) -> Result<bool, Problem> {
        Ok(!self.delete_each(&[id]).await?.is_empty())
    }

    async fn delete_each(&self, ids: &[Uuid]) -> Result<Vec<Uuid>, Problem> {
        let deleted = self.store.delete_jobs(ids).await?;
        for &id in ids {
            self.live.stop(id, StopReason::Client);
            self.live.notify(id);
        }
        Ok(deleted)
    }

    /// Removes all jobs that pass `filter` with all their files, stopping them first; their number.
    pub async fn delete_all(&self, mut filter: JobFilter) -> Result<u64, Problem> {
        let mut deleted = 0;
        while let Some(ids) = self.next_batch(&mut filter).await? {
            deleted += self.delete_each(&ids).await?.len();
        }
        Ok(deleted as u64)
    }
}
