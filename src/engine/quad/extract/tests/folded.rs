//! Maps with triangles flipped: still a pure quad manifold of the same topology.
