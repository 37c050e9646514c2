-- Seconds that a running job is expected to take from here on; null while that is unknown.
ALTER TABLE remesh_jobs ADD COLUMN seconds_left INTEGER;
