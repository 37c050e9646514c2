-- A spec may be megabytes long, and every update of a row writes all of it again: the whole spec moves to a table of its
-- own, and what stays has the lengths of the long lists in their place.

CREATE TABLE remesh_specs (
    job_id TEXT PRIMARY KEY REFERENCES remesh_jobs (id) ON DELETE CASCADE,
    spec TEXT NOT NULL
);

INSERT INTO remesh_specs (job_id, spec) SELECT id, spec FROM remesh_jobs;

UPDATE remesh_jobs SET spec = json_remove(json_set(spec,
    '$.strokes', json_object('count', json_array_length(spec, '$.strokes')),
    '$.features.edges', json_object('count', json_array_length(spec, '$.features.edges')),
    '$.accept', json_object('level', NULL, 'count', NULL, 'distance', NULL)), '$.webhook');
