//! What must hold of any input: no panic, and certified quads of the same topology wherever there are quads.
//!
//! Ten thousand soups go through conditioning, which is fast; a tenth of them, and surfaces, go through the whole
//! engine. `tests/soak/run` sends all of them through the engine. The cases are the same in every run; another
//! `QUADRILLE_SEED` draws others. Whether results are right is judged here by counting vertices, edges and faces, not by
//! the engine's own certificate alone.

mod cases;
mod conditioning;
mod engine;
mod soups;
mod surfaces;
mod topology;
