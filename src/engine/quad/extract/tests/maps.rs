//! Surfaces with grid maps that are known exactly.

use glam::DVec2;
use glam::DVec3;
use glam::I64Vec2;
use glam::IVec3;

use crate::engine::mesh::Features;
use crate::engine::mesh::TriMesh;
use crate::engine::mesh::next;
use crate::engine::mesh::prev;
use crate::engine::numerics::Random;
use crate::engine::parameterize::GridMap;
use crate::engine::parameterize::Iso;
use crate::engine::parameterize::rotate;

pub(super) struct Model {
    pub(super) mesh: TriMesh,
    pub(super) features: Features,
    pub(super) map: GridMap,
}

impl Model {
    /// The transitions follow from the values: along an edge both charts see the same vector up to a turn.
    fn new(mesh: TriMesh, features: Features, uv: Vec<DVec2>) -> Self {
        let n = mesh.n_halfedges();
        let mut map =
            GridMap { uv, rotation: vec![0; n], translation: vec![I64Vec2::ZERO; n], iso: vec![Iso::None; n] };
        for h in 0..n {
            let d = map.uv[next(h)] - map.uv[h];
            if let Some(t) = mesh.twin(h) {
                let e = map.uv[t] - map.uv[next(t)];
                let r = (0..4).min_by(|&r, &s| (rotate(e, r) - d).length().total_cmp(&(rotate(e, s) - d).length()));
                let r = r.unwrap();
                map.rotation[h] = r;
                map.translation[h] = (map.uv[h] - rotate(map.uv[next(t)], r)).round().as_i64vec2();
            }
            if mesh.is_boundary(h) || features.is_edge(mesh.origin(h), mesh.target(h)) {
                map.iso[h] = if d.x.abs() < d.y.abs() { Iso::U } else { Iso::V };
            }
        }
        Self { mesh, features, map }
    }

    pub(super) fn singular(&self, v: u32) -> bool {
        !self.mesh.is_boundary_vertex(v)
            && self.mesh.fan(v).map(|h| u32::from(self.map.rotation[prev(h)])).sum::<u32>() % 4 != 0
    }

    /// Moves the value of vertex `v` by `by`, given in the chart of its first face.
    pub(super) fn shift(&mut self, v: u32, by: DVec2) {
        let mut turn = 0u8;
        for h in self.mesh.fan(v).collect::<Vec<_>>() {
            self.map.uv[h] += rotate(by, (4 - turn) & 3);
            turn = (turn + self.map.rotation[prev(h)]) & 3;
        }
    }

    pub(super) fn is_free(&self, v: u32) -> bool {
        let on_curve = |h: usize| self.map.iso[h] != Iso::None || self.map.iso[prev(h)] != Iso::None;
        !self.singular(v) && !self.mesh.is_boundary_vertex(v) && !self.mesh.fan(v).any(on_curve)
    }
}

/// A rectangle of `w` by `h` grid units in `columns` by `rows` jittered cells, optionally closed to a tube or torus,
/// with values offset by `offset`, and optionally a straight feature at column `feature`.
pub(super) struct Sheet {
    pub(super) size: [i64; 2],
    pub(super) cells: [u32; 2],
    pub(super) closed: [bool; 2],
    pub(super) offset: I64Vec2,
    pub(super) feature: Option<u32>,
    pub(super) jitter: f64,
    pub(super) seed: u64,
}

impl Sheet {
    pub(super) fn plane(w: i64, h: i64) -> Self {
        let cells = [w as u32 + 2, h as u32 + 1];
        Self { size: [w, h], cells, closed: [false; 2], offset: I64Vec2::ZERO, feature: None, jitter: 0.3, seed: 1 }
    }

    pub(super) fn build(&self) -> Model {
        let [m, k] = self.cells;
        let mut dice = Random::new(self.seed);
        let wrap = [if self.closed[0] { m } else { m + 1 }, if self.closed[1] { k } else { k + 1 }];
        let id = |i: u32, j: u32| (j % wrap[1]) * wrap[0] + i % wrap[0];
        // Jitter in cells, along the boundary and the feature only.
        let jitter: Vec<DVec2> = (0..wrap[0] * wrap[1])
            .map(|v| {
                let (i, j) = (v % wrap[0], v / wrap[0]);
                let mut by = DVec2::new(dice.signed(), dice.signed()) * self.jitter;
                if (!self.closed[0] && (i == 0 || i == m)) || self.feature == Some(i) {
                    by.x = 0.0;
                }
                if !self.closed[1] && (j == 0 || j == k) {
                    by.y = 0.0;
                }
                by
            })
            .collect();
        let size = DVec2::new(self.size[0] as f64, self.size[1] as f64);
        let cell = size / DVec2::new(f64::from(m), f64::from(k));
        let at = |i: u32, j: u32| (DVec2::new(f64::from(i), f64::from(j)) + jitter[id(i, j) as usize]) * cell;
        let position = |z: DVec2| {
            let turn = std::f64::consts::TAU * z / size;
            match self.closed {
                [false, _] => DVec3::new(z.x, z.y, 0.0),
                [true, false] => DVec3::new(turn.x.cos(), turn.x.sin(), z.y),
                _ => {
                    let r = 3.0 + turn.y.cos();
                    DVec3::new(r * turn.x.cos(), r * turn.x.sin(), turn.y.sin())
                }
            }
        };
        let positions = (0..wrap[0] * wrap[1]).map(|v| position(at(v % wrap[0], v / wrap[0]))).collect();
        let (mut faces, mut uv) = (Vec::new(), Vec::new());
        for (i, j) in (0..m * k).map(|c| (c % m, c / m)) {
            let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            let turn = dice.below(2);
            for t in [[0, 1, 2], [0, 2, 3]] {
                let t = t.map(|x| corners[(x + turn) % 4]);
                faces.push(t.map(|(i, j)| id(i, j)));
                uv.extend(t.map(|(i, j)| at(i, j) + self.offset.as_dvec2()));
            }
        }
        let mesh = TriMesh::try_new(positions, faces).unwrap();
        let mut features = Features::default();
        if let Some(i) = self.feature {
            features.edges = (0..k).map(|j| [id(i, j), id(i, j + 1)]).map(|[a, b]| [a.min(b), a.max(b)]).collect();
            features.edges.sort_unstable();
        }
        if self.closed == [false; 2] {
            features.corners = vec![id(0, 0), id(m, 0), id(0, k), id(m, k)];
        }
        Model::new(mesh, features, uv)
    }
}

/// The surface of a set of unit cubes, each square with its own chart of `n` by `n` grid units in `m` by `m` jittered
/// cells. Sharp edges are features if asked for.
pub(super) fn polycube(cubes: &[[i32; 3]], n: i64, m: i32, sharp: bool, seed: u64) -> Model {
    let mut dice = Random::new(seed);
    let cubes: Vec<IVec3> = cubes.iter().map(|&c| IVec3::from_array(c)).collect();
    let mut keys: Vec<IVec3> = Vec::new();
    let mut squares = Vec::new();
    for &c in &cubes {
        for axis in 0..3 {
            for side in [-1, 1] {
                let normal = [IVec3::X, IVec3::Y, IVec3::Z][axis] * side;
                if cubes.contains(&(c + normal)) {
                    continue;
                }
                let (mut p, mut q) = ([IVec3::Y, IVec3::Z, IVec3::X][axis], [IVec3::Z, IVec3::X, IVec3::Y][axis]);
                if side < 0 {
                    (p, q) = (q, p);
                }
                // Corner with p × q pointing out.
                let base = c * 2 + normal + IVec3::ONE - p - q;
                squares.push((base * m, p * 2, q * 2));
            }
        }
    }
    for &(base, p, q) in &squares {
        keys.extend((0..=m).flat_map(|i| (0..=m).map(move |j| base + p * i + q * j)));
    }
    let order = |a: &IVec3, b: &IVec3| a.to_array().cmp(&b.to_array());
    keys.sort_by(order);
    keys.dedup();
    let id = |key: IVec3| keys.binary_search_by(|k| order(k, &key)).unwrap() as u32;
    let mut positions: Vec<DVec3> = keys.iter().map(|k| k.as_dvec3() / f64::from(2 * m)).collect();
    let (mut faces, mut uv) = (Vec::new(), Vec::new());
    let mut borders: Vec<([u32; 2], IVec3)> = Vec::new();
    for &(base, p, q) in &squares {
        let jitter: Vec<DVec2> = (0..(m + 1) * (m + 1))
            .map(|c| {
                let (i, j) = (c / (m + 1), c % (m + 1));
                let inner = i > 0 && i < m && j > 0 && j < m;
                if inner { DVec2::new(dice.signed(), dice.signed()) * 0.3 } else { DVec2::ZERO }
            })
            .collect();
        let by = |i: i32, j: i32| jitter[(i * (m + 1) + j) as usize];
        for (i, j) in (0..m * m).map(|c| (c / m, c % m)) {
            let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            let turn = dice.below(2);
            for t in [[0, 1, 2], [0, 2, 3]] {
                let t = t.map(|x| corners[(x + turn) % 4]);
                faces.push(t.map(|(i, j)| id(base + p * i + q * j)));
                uv.extend(
                    t.map(|(i, j)| (DVec2::new(f64::from(i), f64::from(j)) + by(i, j)) * (n as f64 / f64::from(m))),
                );
            }
        }
        for (i, j) in (0..=m).flat_map(|i| (0..=m).map(move |j| (i, j))) {
            let shift = p.as_dvec3() * by(i, j).x + q.as_dvec3() * by(i, j).y;
            positions[id(base + p * i + q * j) as usize] += shift / f64::from(2 * m);
        }
        for i in 0..m {
            for (a, b) in [((i, 0), (i + 1, 0)), ((i, m), (i + 1, m)), ((0, i), (0, i + 1)), ((m, i), (m, i + 1))] {
                let [a, b] = [a, b].map(|(i, j)| id(base + p * i + q * j));
                borders.push(([a.min(b), a.max(b)], p.cross(q).signum()));
            }
        }
    }
    let mesh = TriMesh::try_new(positions, faces).unwrap();
    let mut features = Features::default();
    if sharp {
        borders.sort_by_key(|b| (b.0, b.1.to_array()));
        features.edges = borders.windows(2).filter(|w| w[0].0 == w[1].0 && w[0].1 != w[1].1).map(|w| w[0].0).collect();
        let ends = |v: u32| features.edges.iter().filter(|e| e.contains(&v)).count();
        let grid = |v: &u32| keys[*v as usize].to_array().iter().all(|x| x % (2 * m) == 0);
        features.corners = (0..keys.len() as u32).filter(|&v| grid(&v) && ends(v) > 0 && ends(v) != 2).collect();
    }
    Model::new(mesh, features, uv)
}
