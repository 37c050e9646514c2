//! Surfaces glued from four-sided parametric patches, at a chosen number of triangles.

use crate::engine::mesh::TriMesh;
use crate::engine::numerics::DisjointSets;
use glam::DVec3;
use std::collections::BTreeMap;

/// A map of the unit square into space; (s, t) = (0,0), (1,0), (1,1), (0,1) is counter-clockwise seen from outside.
type Patch = Box<dyn Fn(f64, f64) -> DVec3 + Send + Sync>;

/// Patches that share whole sides. Two patches are glued where they have both ends of a side in common, so no two
/// different sides may have the same two ends.
#[derive(Default)]
pub(super) struct PatchComplex {
    patches: Vec<Patch>,
}

/// Corner numbers per patch, and per patch the chords (see `PatchComplex::chords`) in s and in t.
struct Gluing {
    corners: Vec<[u32; 4]>,
    chords: Vec<[usize; 2]>,
    lengths: Vec<f64>,
}

impl PatchComplex {
    /// Adds a patch.
    pub(super) fn add(&mut self, patch: impl Fn(f64, f64) -> DVec3 + Send + Sync + 'static) {
        self.patches.push(Box::new(patch));
    }

    /// Equal corners get equal numbers.
    fn corners(&self) -> Vec<[u32; 4]> {
        let mut known: Vec<DVec3> = Vec::new();
        let mut number = |p: DVec3| {
            let at = known.iter().position(|&q| q.distance(p) < 1e-6).unwrap_or_else(|| {
                known.push(p);
                known.len() - 1
            });
            at as u32
        };
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        self.patches.iter().map(|patch| square.map(|(s, t)| number(patch(s, t)))).collect()
    }

    /// Sides that face each other in a patch must be divided alike. A chord is a class of such sides; its length is
    /// the mean length of its sides.
    fn glue(&self) -> Gluing {
        let corners = self.corners();
        let mut side = BTreeMap::new();
        let mut chords_of = DisjointSets::default();
        let mut sides = Vec::new();
        for quad in &corners {
            let four: [usize; 4] = std::array::from_fn(|k| {
                let (a, b) = (quad[k], quad[(k + 1) % 4]);
                *side.entry((a.min(b), a.max(b))).or_insert_with(|| chords_of.push() as usize)
            });
            sides.push(four);
        }
        for four in &sides {
            for k in 0..2 {
                chords_of.join(four[k] as u32, four[k + 2] as u32);
            }
        }
        let (mut sum, mut count) = (vec![0.0; chords_of.len()], vec![0.0; chords_of.len()]);
        let chord_of = chords_of.names();
        let chords: Vec<[usize; 2]> =
            sides.iter().map(|four| [four[0], four[1]].map(|side| chord_of[side] as usize)).collect();
        for (patch, chord) in self.patches.iter().zip(&chords) {
            for edge in [0.0, 1.0] {
                sum[chord[0]] += arc_length(|u| patch(u, edge));
                sum[chord[1]] += arc_length(|u| patch(edge, u));
            }
            count[chord[0]] += 2.0;
            count[chord[1]] += 2.0;
        }
        let lengths = sum.iter().zip(&count).map(|(s, n): (&f64, &f64)| s / n.max(1.0)).collect();
        Gluing { corners, chords, lengths }
    }

    /// Positions and triangles, as close to `triangles` as one edge length for the whole surface allows; at least two
    /// per patch.
    pub(super) fn triangulate(&self, triangles: usize) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let gluing = self.glue();
        let divisions = |h: f64| -> Vec<usize> {
            gluing.lengths.iter().map(|l| ((l / h).round() as usize).clamp(1, 4000)).collect()
        };
        let count = |n: &[usize]| -> usize { gluing.chords.iter().map(|c| 2 * n[c[0]] * n[c[1]]).sum() };
        // The count falls with h; bisect, keep the best.
        let longest = gluing.lengths.iter().copied().fold(0.0, f64::max);
        let (mut low, mut high) = (longest * 1e-4, longest * 2.0);
        let mut best = divisions(high);
        for _ in 0..60 {
            let h = (low * high).sqrt();
            let n = divisions(h);
            if count(&n).abs_diff(triangles) < count(&best).abs_diff(triangles) {
                best.clone_from(&n);
            }
            if count(&n) > triangles { low = h } else { high = h }
        }
        self.emit(&gluing, &best)
    }

    fn emit(&self, gluing: &Gluing, divisions: &[usize]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let corner_count = gluing.corners.iter().flatten().max().map_or(0, |m| m + 1);
        let mut positions = vec![DVec3::ZERO; corner_count as usize];
        let mut first_on_side: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        let mut faces = Vec::new();
        for ((patch, quad), chord) in self.patches.iter().zip(&gluing.corners).zip(&gluing.chords) {
            let (n, m) = (divisions[chord[0]], divisions[chord[1]]);
            let place = |i: usize, j: usize| patch(i as f64 / n as f64, j as f64 / m as f64);
            for (k, (i, j)) in [(0, 0), (n, 0), (n, m), (0, m)].into_iter().enumerate() {
                positions[quad[k] as usize] = place(i, j);
            }
            // Sides: the points of a side are numbered from its lower end, by whichever patch comes first.
            let side_points: [Vec<u32>; 4] = std::array::from_fn(|k| {
                let (a, b) = (quad[k], quad[(k + 1) % 4]);
                let inner = if k % 2 == 0 { n } else { m } - 1;
                let first = *first_on_side.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let first = positions.len() as u32;
                    for step in 1..=inner {
                        let u = if a < b { step } else { inner + 1 - step };
                        let (i, j) = [(u, 0), (n, u), (n.wrapping_sub(u), m), (0, m.wrapping_sub(u))][k];
                        positions.push(place(i, j));
                    }
                    first
                });
                let inner = inner as u32;
                (0..inner).map(|u| if a < b { first + u } else { first + inner - 1 - u }).collect()
            });
            let first_inside = positions.len() as u32;
            for j in 1..m {
                for i in 1..n {
                    positions.push(place(i, j));
                }
            }
            let at = |i: usize, j: usize| -> u32 {
                match (i, j) {
                    (0, 0) => quad[0],
                    (i, 0) if i == n => quad[1],
                    (i, j) if i == n && j == m => quad[2],
                    (0, j) if j == m => quad[3],
                    (i, 0) => side_points[0][i - 1],
                    (i, j) if i == n => side_points[1][j - 1],
                    (i, j) if j == m => side_points[2][n - 1 - i],
                    (0, j) => side_points[3][m - 1 - j],
                    (i, j) => first_inside + ((j - 1) * (n - 1) + i - 1) as u32,
                }
            };
            for j in 0..m {
                for i in 0..n {
                    let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    let long = |x: u32, y: u32| positions[x as usize].distance(positions[y as usize]);
                    // A clearly shorter diagonal wins, otherwise all run alike: valence 6.
                    if long(b, d) < 0.97 * long(a, c) {
                        faces.extend([[a, b, d], [b, c, d]]);
                    } else {
                        faces.extend([[a, b, c], [a, c, d]]);
                    }
                }
            }
        }
        (positions, faces)
    }
}

fn arc_length(curve: impl Fn(f64) -> DVec3) -> f64 {
    (0..16).map(|i| curve(f64::from(i) / 16.0).distance(curve(f64::from(i + 1) / 16.0))).sum()
}

/// Unit vertex normals, weighted by area.
pub(super) fn vertex_normals(mesh: &TriMesh) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; mesh.n_vertices()];
    for f in 0..mesh.n_faces() {
        let area = mesh.area_vector(f);
        for v in mesh.face(f) {
            normals[v as usize] += area;
        }
    }
    normals.into_iter().map(DVec3::normalize_or_zero).collect()
}
