-- Our own tables. SQLite compares table names without case, and the queue owns "Jobs" and "Workers" in the same file.

CREATE TABLE assets (
    id TEXT PRIMARY KEY,
    sha256 TEXT NOT NULL UNIQUE,
    bytes INTEGER NOT NULL,
    format TEXT,
    name TEXT,
    vertices INTEGER,
    faces INTEGER,
    blob TEXT NOT NULL,
    -- 1: uploaded by name and kept until it is deleted; 0: lives as long as the jobs that use it.
    pinned INTEGER NOT NULL,
    created_at INTEGER NOT NULL
);

CREATE TABLE remesh_jobs (
    id TEXT PRIMARY KEY,
    status TEXT NOT NULL,
    stage TEXT,
    -- Thousandths, never falls.
    progress INTEGER NOT NULL DEFAULT 0,
    -- How often a worker began, and how many of these ended by an orderly shutdown instead of a crash.
    attempt INTEGER NOT NULL DEFAULT 0,
    excused INTEGER NOT NULL DEFAULT 0,
    -- The only ticket of the queue that may start this job.
    ticket TEXT NOT NULL,
    cancel_requested INTEGER NOT NULL DEFAULT 0,
    priority INTEGER NOT NULL,
    method TEXT NOT NULL,
    spec TEXT NOT NULL,
    tags TEXT NOT NULL,
    asset_id TEXT NOT NULL REFERENCES assets (id),
    input TEXT NOT NULL,
    result TEXT,
    problem TEXT,
    artefacts TEXT,
    idempotency_key TEXT UNIQUE,
    fingerprint TEXT NOT NULL,
    created_at INTEGER NOT NULL,
    started_at INTEGER,
    finished_at INTEGER,
    expires_at INTEGER
);

CREATE INDEX remesh_jobs_in_line ON remesh_jobs (status, priority DESC, id);
CREATE INDEX remesh_jobs_of_asset ON remesh_jobs (asset_id);
CREATE INDEX remesh_jobs_expiry ON remesh_jobs (expires_at);

CREATE TABLE remesh_tags (
    tag TEXT NOT NULL,
    job_id TEXT NOT NULL REFERENCES remesh_jobs (id) ON DELETE CASCADE,
    PRIMARY KEY (tag, job_id)
) WITHOUT ROWID;
CREATE INDEX remesh_tags_of_job ON remesh_tags (job_id);

CREATE TABLE remesh_events (
    job_id TEXT NOT NULL REFERENCES remesh_jobs (id) ON DELETE CASCADE,
    seq INTEGER NOT NULL,
    kind TEXT NOT NULL,
    data TEXT NOT NULL,
    PRIMARY KEY (job_id, seq)
) WITHOUT ROWID;
