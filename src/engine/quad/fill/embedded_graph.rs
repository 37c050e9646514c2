//! A graph embedded in an oriented surface, as a rotation system.

use glam::DVec3;

use crate::engine::quad::Anchor;

/// What an arc of the graph lies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Tag {
    /// The surface.
    Plain,
    /// An interior feature curve.
    Feature,
    /// The boundary.
    Boundary,
}

/// A node: where it is and what it must stay on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GraphNode {
    pub(crate) position: DVec3,
    pub(crate) anchor: Anchor,
}

/// An arc. Its darts are 2 a (from the first to the second end) and 2 a + 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GraphArc {
    pub(crate) ends: [u32; 2],
    pub(crate) tag: Tag,
    /// Both ends are the same grid point of a folded map.
    pub(crate) collapsed: bool,
    /// Per dart, whether the outside of the surface is to its left.
    pub(crate) outside: [bool; 2],
}

/// Darts around nodes. The face to the left of dart d is walked by [`EmbeddedGraph::next`]; faces outside the surface
/// (one per boundary loop) are faces like others, but marked.
#[derive(Clone, Debug, Default)]
pub(crate) struct EmbeddedGraph {
    pub(super) nodes: Vec<GraphNode>,
    /// Per dart, the node where it begins.
    pub(super) node: Vec<u32>,
    ccw: Vec<u32>,
    cw: Vec<u32>,
    /// Per dart, quarter turns in the map from it to the next dart counter-clockwise: 1 where the map is as it should
    /// be, −1 where it is flipped, and sums of these where darts in between are gone.
    pub(super) turn: Vec<i32>,
    /// Per dart, whether the outside is to its left.
    pub(super) outside: Vec<bool>,
    /// Per arc.
    pub(super) alive: Vec<bool>,
    pub(super) tag: Vec<Tag>,
    pub(super) collapsed: Vec<bool>,
}

impl EmbeddedGraph {
    /// A graph from its arcs and, per node, the darts that leave it, counter-clockwise, each with the quarter turns in
    /// the map to the next one.
    pub(crate) fn new(
        nodes: Vec<GraphNode>,
        arcs: &[GraphArc],
        rotation: impl Iterator<Item = impl AsRef<[(u32, i32)]>>,
    ) -> Self {
        let mut graph = Self {
            nodes,
            node: arcs.iter().flat_map(|a| a.ends).collect(),
            ccw: vec![0; 2 * arcs.len()],
            cw: vec![0; 2 * arcs.len()],
            turn: vec![1; 2 * arcs.len()],
            outside: arcs.iter().flat_map(|a| a.outside).collect(),
            alive: vec![true; arcs.len()],
            tag: arcs.iter().map(|a| a.tag).collect(),
            collapsed: arcs.iter().map(|a| a.collapsed).collect(),
        };
        for darts in rotation {
            let darts = darts.as_ref();
            for (i, &(d, turn)) in darts.iter().enumerate() {
                graph.link(d, darts[(i + 1) % darts.len()].0);
                graph.turn[d as usize] = turn;
            }
        }
        graph
    }

    fn link(&mut self, d: u32, after: u32) {
        self.ccw[d as usize] = after;
        self.cw[after as usize] = d;
    }

    pub(super) fn n_darts(&self) -> u32 {
        self.node.len() as u32
    }
    pub(super) fn is_alive(&self, d: u32) -> bool {
        self.alive[d as usize / 2]
    }
    pub(super) fn tag_of(&self, d: u32) -> Tag {
        self.tag[d as usize / 2]
    }
    pub(super) fn origin(&self, d: u32) -> u32 {
        self.node[d as usize]
    }
    pub(super) fn target(&self, d: u32) -> u32 {
        self.node[d as usize ^ 1]
    }
    /// The dart after `d` around its origin.
    pub(super) fn ccw(&self, d: u32) -> u32 {
        self.ccw[d as usize]
    }
    /// The dart before `d` around its origin.
    pub(super) fn cw(&self, d: u32) -> u32 {
        self.cw[d as usize]
    }
    /// The dart after `d` around the face to its left.
    pub(super) fn next(&self, d: u32) -> u32 {
        self.cw(d ^ 1)
    }
    /// The darts around the face to the left of `d`.
    pub(super) fn face(&self, d: u32) -> impl Iterator<Item = u32> + '_ {
        let mut now = Some(d);
        std::iter::from_fn(move || {
            let here = now?;
            now = Some(self.next(here)).filter(|&n| n != d);
            Some(here)
        })
    }

    /// The darts that leave the origin of `d`, counter-clockwise.
    pub(super) fn around(&self, d: u32) -> impl Iterator<Item = u32> + '_ {
        let mut now = Some(d);
        std::iter::from_fn(move || {
            let here = now?;
            now = Some(self.ccw(here)).filter(|&n| n != d);
            Some(here)
        })
    }

    /// Number of darts that leave the origin of `d`, counted up to `limit`.
    pub(super) fn degree(&self, d: u32, limit: usize) -> usize {
        self.around(d).take(limit).count()
    }

    /// Takes an arc away. Keeps the surface if its two sides are different faces, or if it ends at a node of degree 1.
    pub(super) fn remove(&mut self, arc: u32) {
        for d in [2 * arc, 2 * arc + 1] {
            let (before, after) = (self.cw(d), self.ccw(d));
            self.turn[before as usize] += self.turn[d as usize];
            self.link(before, after);
            self.link(d, d);
        }
        self.alive[arc as usize] = false;
    }

    /// Zips the darts `d` and `ccw(d)`: the second arc comes to lie on the first one and is gone, its far node becomes
    /// that of the first. The far nodes must differ.
    pub(super) fn zip(&mut self, d: u32) {
        let s = self.ccw(d);
        let (t, w, kept) = (d ^ 1, s ^ 1, self.target(d));
        for e in self.around(w).collect::<Vec<_>>() {
            self.node[e as usize] = kept;
        }
        let (before_t, before_w, after_w) = (self.cw(t), self.cw(w), self.ccw(w));
        let turn_w = self.turn[w as usize];
        if after_w != w {
            self.link(before_t, after_w);
            self.link(before_w, t);
        }
        self.turn[before_t as usize] += turn_w;
        self.link(w, w);
        self.remove(s / 2);
    }

    /// Contracts an arc that is not a loop: the darts of its second node come to stand where the arc stood around its
    /// first. The caller must give the darts their new node (nodes are joined in a batch).
    pub(super) fn contract(&mut self, arc: u32) {
        let (d, t) = (2 * arc, 2 * arc + 1);
        let (before, after) = (self.cw(d), self.ccw(d));
        let (first, last) = (self.ccw(t), self.cw(t));
        // Both darts leave in the same direction of the map: the line comes back to where it began.
        let (turn_d, turn_t) = (self.turn[d as usize], self.turn[t as usize]);
        if before == d {
            self.turn[last as usize] += turn_d + turn_t;
        } else if first == t {
            self.turn[before as usize] += turn_t + turn_d;
        } else {
            self.turn[before as usize] += turn_t;
            self.turn[last as usize] += turn_d;
        }
        match (before == d, first == t) {
            (true, true) => {}
            (true, false) => self.link(last, first),
            (false, true) => self.link(before, after),
            (false, false) => {
                self.link(before, first);
                self.link(last, after);
            }
        }
        self.link(d, d);
        self.link(t, t);
        self.alive[arc as usize] = false;
    }

    /// A new node without arcs.
    pub(super) fn add_node(&mut self, node: GraphNode) -> u32 {
        self.nodes.push(node);
        self.nodes.len() as u32 - 1
    }

    /// A new arc, and its first dart. Both darts must then be put in their place.
    pub(super) fn add_arc(&mut self, ends: [u32; 2], tag: Tag, outside: [bool; 2]) -> u32 {
        let d = self.n_darts();
        self.node.extend(ends);
        self.ccw.extend([d, d + 1]);
        self.cw.extend([d, d + 1]);
        self.turn.extend([1; 2]);
        self.outside.extend(outside);
        self.alive.push(true);
        self.tag.push(tag);
        self.collapsed.push(false);
        d
    }

    /// Splits the arc of dart `d` in two by a new node and returns the dart of the second part, in the direction of `d`.
    pub(super) fn split(&mut self, d: u32) -> u32 {
        let t = d ^ 1;
        let (a, b) = (self.nodes[self.origin(d) as usize], self.nodes[self.target(d) as usize]);
        let tag = self.tag_of(d);
        let anchor = if tag == Tag::Plain { Anchor::Surface } else { Anchor::Curve };
        let middle = self.add_node(GraphNode { position: a.position.midpoint(b.position), anchor });
        let outside = [self.outside[d as usize], self.outside[t as usize]];
        let second = self.add_arc([middle, self.target(d)], tag, outside);
        let (before, after) = (self.cw(t), self.ccw(t));
        if before == t {
            self.link(second ^ 1, second ^ 1);
        } else {
            self.link(before, second ^ 1);
            self.link(second ^ 1, after);
        }
        self.node[t as usize] = middle;
        self.link(t, second);
        self.link(second, t);
        second
    }

    /// A new plain arc between two nodes, and its first dart. Both darts must then be put in their place.
    pub(super) fn draw(&mut self, from: u32, to: u32) -> u32 {
        self.add_arc([from, to], Tag::Plain, [false; 2])
    }

    /// Puts a new dart in its place: counter-clockwise after `before`.
    pub(super) fn place_after(&mut self, dart: u32, before: u32) {
        let after = self.ccw(before);
        self.link(before, dart);
        self.link(dart, after);
    }
}
