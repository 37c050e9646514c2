//! Nearest segments: a bounding volume hierarchy over segments with a reach each.

use crate::engine::mesh::closest_on_segment;
use glam::DVec3;

const LEAF: usize = 4;

/// A segment and how far it reaches: a point belongs to it at most `reach` away.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    pub(super) ends: [DVec3; 2],
    pub(super) reach: f64,
    /// Whatever the caller wants to know it by.
    pub(super) name: u32,
}

impl Segment {
    fn distance(&self, p: DVec3) -> f64 {
        closest_on_segment(p, self.ends[0], self.ends[1]).1.distance(p)
    }

    /// The cosine of the angle between the segment and a unit direction, without sign; 1 for a segment without length.
    pub(super) fn parallel(&self, direction: DVec3) -> f64 {
        (self.ends[1] - self.ends[0]).try_normalize().map_or(1.0, |d| d.dot(direction).abs())
    }
}

struct Node {
    low: DVec3,
    high: DVec3,
    /// First segment of a leaf, or second child of an inner node (the first one follows the node itself).
    start: usize,
    /// Segments of a leaf, 0 for an inner node.
    count: usize,
}

pub(super) struct SegmentIndex {
    nodes: Vec<Node>,
    segments: Vec<Segment>,
}

impl SegmentIndex {
    pub(super) fn new(mut segments: Vec<Segment>) -> Self {
        let mut nodes = Vec::new();
        let n = segments.len();
        if n > 0 {
            build(&mut nodes, &mut segments, 0, n);
        }
        Self { nodes, segments }
    }

    /// Calls `visit` with every segment that reaches `p`, and its distance.
    pub(super) fn reaching(&self, p: DVec3, mut visit: impl FnMut(&Segment, f64)) {
        let mut stack: Vec<usize> = if self.nodes.is_empty() { Vec::new() } else { vec![0] };
        while let Some(at) = stack.pop() {
            let node = &self.nodes[at];
            if p.cmplt(node.low).any() || p.cmpgt(node.high).any() {
                continue;
            }
            if node.count == 0 {
                stack.extend([node.start, at + 1]);
                continue;
            }
            for segment in &self.segments[node.start..node.start + node.count] {
                let distance = segment.distance(p);
                if distance <= segment.reach {
                    visit(segment, distance);
                }
            }
        }
    }

    /// The distance from `p` to the nearest segment; infinite if there is none.
    pub(super) fn distance(&self, p: DVec3) -> f64 {
        let bound = |at: usize| {
            let node = &self.nodes[at];
            (node.low - p).max(p - node.high).max(DVec3::ZERO).length()
        };
        let mut best = f64::INFINITY;
        let mut stack = if self.nodes.is_empty() { Vec::new() } else { vec![(0, 0.0)] };
        while let Some((at, near)) = stack.pop() {
            if near >= best {
                continue;
            }
            let node = &self.nodes[at];
            if node.count > 0 {
                let leaf = &self.segments[node.start..node.start + node.count];
                best = leaf.iter().map(|s| s.distance(p)).fold(best, f64::min);
                continue;
            }
            let mut children = [(at + 1, bound(at + 1)), (node.start, bound(node.start))];
            children.sort_by(|a, b| b.1.total_cmp(&a.1));
            stack.extend(children);
        }
        best
    }
}

fn build(nodes: &mut Vec<Node>, segments: &mut [Segment], offset: usize, n: usize) {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for s in segments.iter() {
        low = low.min(s.ends[0].min(s.ends[1]) - s.reach);
        high = high.max(s.ends[0].max(s.ends[1]) + s.reach);
    }
    let at = nodes.len();
    if n <= LEAF {
        nodes.push(Node { low, high, start: offset, count: n });
        return;
    }
    nodes.push(Node { low, high, start: 0, count: 0 });
    let size = high - low;
    let axis = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
    let half = n / 2;
    let key = |s: &Segment| s.ends[0][axis] + s.ends[1][axis];
    segments.select_nth_unstable_by(half, |a, b| key(a).total_cmp(&key(b)).then(a.name.cmp(&b.name)));
    let (left, right) = segments.split_at_mut(half);
    build(nodes, left, offset, half);
    nodes[at].start = nodes.len();
    build(nodes, right, offset + half, n - half);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hierarchy_agrees_with_the_list() {
        let point = |i: usize, salt: f64| {
            let x = i as f64 + salt;
            DVec3::new((x * 12.9898).sin(), (x * 78.233).sin(), (x * 37.719).sin())
        };
        let segments: Vec<Segment> = (0..200)
            .map(|i| {
                let a = point(i, 0.0);
                Segment { ends: [a, a + 0.2 * point(i, 0.5)], reach: 0.05 + 0.1 * (i % 3) as f64, name: i as u32 }
            })
            .collect();
        let index = SegmentIndex::new(segments.clone());
        for i in 0..300 {
            let p = point(i, 0.77) * 1.3;
            let nearest = segments.iter().map(|s| s.distance(p)).fold(f64::INFINITY, f64::min);
            assert_eq!(index.distance(p), nearest);
            let mut found = Vec::new();
            index.reaching(p, |s, _| found.push(s.name));
            found.sort_unstable();
            let wanted: Vec<u32> = segments.iter().filter(|s| s.distance(p) <= s.reach).map(|s| s.name).collect();
            assert_eq!(found, wanted);
        }
        assert_eq!(SegmentIndex::new(Vec::new()).distance(DVec3::ZERO), f64::INFINITY);
    }
}
