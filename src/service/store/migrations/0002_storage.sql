-- Since when an input cannot be read or a result cannot be written, in milliseconds since 1970; NULL: all is well.
ALTER TABLE remesh_jobs ADD COLUMN faulty_since INTEGER;

-- One row, written to find out whether the database can be written to.
CREATE TABLE probes (
    id INTEGER PRIMARY KEY,
    at INTEGER NOT NULL
);
