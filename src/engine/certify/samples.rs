//! Samples along curves, at the scale of the quads that follow them.

use crate::engine::certify::reach::TOLERANCE;
use crate::engine::certify::segments::SegmentIndex;
use crate::engine::certify::trace::Curve;
use crate::engine::mesh::Surface;
use glam::DVec3;

/// A curve has a direction over the length of a quad edge if its ends are apart by more than this part of that length;
/// where it turns back within less than an edge, no chain of quads can follow its turns.
const STRETCHED: f64 = 0.5;
/// A bay of a boundary with a mouth narrower than this many quad edges has no quad of its own, …
const MOUTH: f64 = 0.5;
/// … if it is at most two edges deep, which is as far as quads may be from the surface: the length of its shore, in edges.
const SHORE: f64 = 4.0;
/// Curves get a sample per tenth of a mean quad edge, at most about so many.
const SAMPLES: f64 = 200_000.0;
/// … and each at least so many.
const MIN_SAMPLES: f64 = 8.0;

/// A place on a curve.
pub(super) struct Sample {
    pub(super) position: DVec3,
    /// Of the piece of curve at the sample, and of a chord of about a quad edge around it: scan edges zigzag below
    /// that size, and split triangles follow every zigzag. Zero where it turns back within that chord: any direction is
    /// as good there.
    pub(super) directions: [DVec3; 2],
    pub(super) curve: usize,
    /// Whether the quads may pass it by; see [`bays`].
    pub(super) is_in_bay: bool,
}

/// Mean length of the quad edges along a curve, so that a curve is judged alike whatever else the model has: a mean over
/// the whole model would not be the one of its component. `None` where no quad edge is near.
pub(super) fn local_edge(surface: &Surface, index: &SegmentIndex, curve: &Curve) -> Option<f64> {
    let stride = curve.vertices.len().div_ceil(16);
    let (mut sum, mut n) = (0.0, 0);
    for &v in curve.vertices.iter().step_by(stride) {
        let mut longest: f64 = 0.0;
        index.reaching(surface.mesh.position(v), |segment, _| longest = longest.max(segment.reach));
        if longest > 0.0 {
            sum += longest / TOLERANCE;
            n += 1;
        }
    }
    (n > 0).then(|| sum / f64::from(n))
}

fn length(points: &[DVec3]) -> f64 {
    points.windows(2).map(|w| w[0].distance(w[1])).sum()
}

/// The bays and spits of a boundary curve at the scale of quads with edges of this length, as ranges of its arc length:
/// those with a mouth narrower than `MOUTH` edges, unless they are deeper than quads may be away from the surface; a slit
/// that long has two sides.
fn bays(points: &[DVec3], edge: f64) -> Vec<[f64; 2]> {
    let mut arc = vec![0.0];
    arc.extend(points.windows(2).scan(0.0, |sum, w| {
        *sum += w[0].distance(w[1]);
        Some(*sum)
    }));
    let longest = (SHORE * edge).min(0.5 * arc[points.len() - 1]);
    let mut found = Vec::new();
    let mut at = 0;
    while at + 1 < points.len() {
        let within = arc.partition_point(|&a| a <= arc[at] + longest);
        let is_bay = |&j: &usize| {
            let mouth = points[j].distance(points[at]);
            mouth <= MOUTH * edge && mouth < STRETCHED * (arc[j] - arc[at])
        };
        let end = (at + 1..within).rev().find(is_bay);
        found.extend(end.map(|end| [arc[at], arc[end]]));
        at = end.unwrap_or(at + 1);
    }
    found
}

/// Samples along all curves, in order, evenly by arc length; `lines` are their points, `spans` the lengths of the quad edges
/// along them.
pub(super) fn sample(curves: &[Curve], lines: &[Vec<DVec3>], spans: &[f64]) -> Vec<Sample> {
    let total: f64 = lines.iter().map(|points| length(points)).sum();
    let coarsest = total / SAMPLES;
    let mut samples = Vec::new();
    for (curve, (points, &mean_edge)) in lines.iter().zip(spans).enumerate() {
        let bays = if curves[curve].is_boundary { bays(points, mean_edge) } else { Vec::new() };
        let spacing = (0.1 * mean_edge).max(coarsest);
        let all = length(points);
        let n = if spacing > 0.0 { (all / spacing).ceil().max(MIN_SAMPLES) } else { MIN_SAMPLES };
        let reach = 0.5 * mean_edge;
        let mut walk = [Walk::default(), Walk::default(), Walk::default()];
        for i in 0..n as usize {
            let wanted = (i as f64 + 0.5) / n * all;
            let (before, after) = ((wanted - reach).max(0.0), (wanted + reach).min(all));
            let position = walk[0].to(points, wanted);
            let chord = walk[2].to(points, after) - walk[1].to(points, before);
            let piece = points[walk[0].piece + 1] - points[walk[0].piece];
            let chord = if chord.length() > STRETCHED * (after - before) { chord } else { DVec3::ZERO };
            let directions = [piece, chord].map(DVec3::normalize_or_zero);
            let is_in_bay = bays.get(bays.partition_point(|bay| bay[1] < wanted)).is_some_and(|bay| bay[0] < wanted);
            samples.push(Sample { position, directions, curve, is_in_bay });
        }
    }
    samples
}

/// A place on a polyline that only moves forward.
#[derive(Default)]
struct Walk {
    piece: usize,
    before: f64,
}

impl Walk {
    /// The point at this arc length, not less than the last one asked for.
    fn to(&mut self, points: &[DVec3], wanted: f64) -> DVec3 {
        while self.piece + 2 < points.len() {
            let length = points[self.piece].distance(points[self.piece + 1]);
            if self.before + length >= wanted {
                break;
            }
            self.before += length;
            self.piece += 1;
        }
        let (a, b) = (points[self.piece], points[self.piece + 1]);
        let t = if a == b { 0.0 } else { ((wanted - self.before) / a.distance(b)).clamp(0.0, 1.0) };
        a.lerp(b, t)
    }
}
