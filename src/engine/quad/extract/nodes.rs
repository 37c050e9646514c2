//! The grid points on the surface, in an order in which those on a line are found by search.

use glam::DVec3;
use glam::I64Vec2;

use crate::engine::mesh::next;
use crate::engine::quad::extract::exact_map::ExactMap;
use crate::engine::quad::extract::exact_map::orient;
use crate::engine::quad::extract::gates::crossing;
use crate::engine::quad::extract::gates::gates;
use crate::engine::quad::extract::gates::is_above;
use crate::engine::quad::extract::gates::is_upright;
use crate::engine::quad::extract::ports::Port;
use crate::engine::quad::extract::ports::push_vertex_ports;

/// Where a grid point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// On a vertex.
    Vertex(u32),
    /// Inside an edge that lies on a grid line; the halfedge that stands for the edge.
    Edge(u32),
    /// Inside a face; the flag says that the map keeps its orientation.
    Face(u32, bool),
}

/// A grid point on the surface; `point` is its value in the chart of the face of its place (for a vertex: unused).
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub(super) place: Place,
    pub(super) point: I64Vec2,
}

/// All grid points: per place contiguous, so that neighbours on a line are found by search, not by hashing.
pub(super) struct Nodes {
    pub(super) nodes: Vec<Node>,
    /// Per vertex: its node.
    pub(super) at_vertex: Vec<Option<u32>>,
    /// Per halfedge that stands for its edge: first node of the edge, from its origin on; length 3 F + 1.
    pub(super) at_edge: Vec<u32>,
    /// Per face: first node of the face, by u, then v; length F + 1.
    pub(super) at_face: Vec<u32>,
    /// Nodes of the face places by face, then v, then u.
    by_v: Vec<u32>,
    /// Ports of all nodes, counter-clockwise as seen from outside.
    pub(super) ports: Vec<Port>,
    /// Per node: first port; one entry more than nodes.
    pub(super) first_port: Vec<u32>,
}

impl Nodes {
    /// Finds the grid points and their ports.
    pub(super) fn new(map: &ExactMap<'_>) -> Self {
        let mesh = map.mesh;
        let mut nodes = Vec::new();
        let mut at_vertex = vec![None; mesh.n_vertices()];
        for v in 0..mesh.n_vertices() {
            if map.is_node[v] {
                at_vertex[v] = Some(nodes.len() as u32);
                nodes.push(Node { place: Place::Vertex(v as u32), point: I64Vec2::ZERO });
            }
        }
        let mut at_edge = Vec::with_capacity(mesh.n_halfedges() + 1);
        for h in 0..mesh.n_halfedges() {
            at_edge.push(nodes.len() as u32);
            if mesh.is_edge_owner(h) {
                push_edge_nodes(map, h, &mut nodes);
            }
        }
        at_edge.push(nodes.len() as u32);
        let mut at_face = Vec::with_capacity(mesh.n_faces() + 1);
        for f in 0..mesh.n_faces() {
            at_face.push(nodes.len() as u32);
            push_face_nodes(map, f, &mut nodes);
        }
        at_face.push(nodes.len() as u32);
        let mut by_v: Vec<u32> = (at_face[0]..nodes.len() as u32).collect();
        for f in 0..mesh.n_faces() {
            let range = (at_face[f] - at_face[0]) as usize..(at_face[f + 1] - at_face[0]) as usize;
            by_v[range].sort_unstable_by_key(|&n| (nodes[n as usize].point.y, nodes[n as usize].point.x));
        }
        let mut all = Self { nodes, at_vertex, at_edge, at_face, by_v, ports: Vec::new(), first_port: Vec::new() };
        all.find_ports(map);
        all
    }

    fn find_ports(&mut self, map: &ExactMap<'_>) {
        let mesh = map.mesh;
        for node in &self.nodes {
            self.first_port.push(self.ports.len() as u32);
            match node.place {
                Place::Vertex(v) => push_vertex_ports(map, v, &mut self.ports),
                Place::Edge(edge) => {
                    self.ports.push(Port::Along { edge, forward: true });
                    self.ports.push(Port::Into { halfedge: edge });
                    self.ports.push(Port::Along { edge, forward: false });
                    if let Some(t) = mesh.twin(edge as usize) {
                        self.ports.push(Port::Into { halfedge: t as u32 });
                    }
                }
                Place::Face(_, upright) => {
                    let mut axes = [(0, true), (1, true), (0, false), (1, false)];
                    if !upright {
                        axes.reverse();
                    }
                    self.ports.extend(axes.map(|(run, up)| Port::Axis { run, up }));
                }
            }
        }
        self.first_port.push(self.ports.len() as u32);
    }

    /// The port of node `node` that leaves it in this way.
    pub(super) fn port(&self, node: u32, way: Port) -> Option<u32> {
        let (start, end) = (self.first_port[node as usize], self.first_port[node as usize + 1]);
        (start..end).find(|&p| self.ports[p as usize] == way)
    }

    /// Lowest and highest node of face `f` on the line where axis `fix` has the value `c`.
    pub(super) fn on_line(&self, f: usize, fix: usize, c: i64) -> Option<(u32, u32)> {
        let (start, end) = (self.at_face[f], self.at_face[f + 1]);
        let run: &[u32] = &self.by_v[(start - self.at_face[0]) as usize..(end - self.at_face[0]) as usize];
        let point = |i: usize| self.nodes[if fix == 0 { start as usize + i } else { run[i] as usize }].point[fix];
        let (mut low, mut high) = (0, run.len());
        while low < high {
            let middle = (low + high) / 2;
            if point(middle) < c { low = middle + 1 } else { high = middle }
        }
        let mut last = low;
        while last < run.len() && point(last) == c {
            last += 1;
        }
        let node = |i: usize| if fix == 0 { start + i as u32 } else { run[i] };
        (low < last).then(|| (node(low), node(last - 1)))
    }

    /// The node of face `f` at `point`.
    pub(super) fn in_face(&self, f: usize, point: I64Vec2) -> Option<u32> {
        let (start, end) = (self.at_face[f] as usize, self.at_face[f + 1] as usize);
        let key = |node: &Node| (node.point.x, node.point.y);
        self.nodes[start..end].binary_search_by_key(&(point.x, point.y), key).ok().map(|i| (start + i) as u32)
    }

    /// The node at `point` (chart of its face) on the edge that `edge` stands for.
    pub(super) fn on_edge(&self, edge: usize, point: I64Vec2) -> Option<u32> {
        let (start, end) = (self.at_edge[edge], self.at_edge[edge + 1]);
        let first = self.nodes.get(start as usize).filter(|_| start < end)?.point;
        let step = if end - start > 1 { self.nodes[start as usize + 1].point - first } else { I64Vec2::ONE };
        let (there, unit) = ((point - first).abs().max_element(), step.abs().max_element());
        let n = start + u32::try_from(there / unit).ok()?;
        (n < end && self.nodes[n as usize].point == point).then_some(n)
    }

    /// Position of node `n` on the surface.
    pub(super) fn position(&self, map: &ExactMap<'_>, n: usize) -> DVec3 {
        let (mesh, point) = (map.mesh, self.nodes[n].point);
        match self.nodes[n].place {
            Place::Vertex(v) => mesh.position(v),
            Place::Edge(h) => {
                let h = h as usize;
                let (a, b) = (map.corner[h], map.corner[next(h)]);
                let run = 1 - map.line_axis(h).unwrap_or(0);
                let t = (point[run] - a[run]) as f64 / (b[run] - a[run]) as f64;
                mesh.position(mesh.origin(h)).lerp(mesh.position(mesh.target(h)), t)
            }
            Place::Face(f, _) => {
                let f = f as usize;
                let z = [map.corner[3 * f], map.corner[3 * f + 1], map.corner[3 * f + 2]];
                let weight = |k: usize| orient(point, z[(k + 1) % 3], z[(k + 2) % 3]) as f64;
                let (w, [a, b, c]) = ([weight(0), weight(1), weight(2)], mesh.triangle(f));
                let total = w[0] + w[1] + w[2];
                if total == 0.0 { (a + b + c) / 3.0 } else { (a * w[0] + b * w[1] + c * w[2]) / total }
            }
        }
    }
}

fn push_edge_nodes(map: &ExactMap<'_>, h: usize, nodes: &mut Vec<Node>) {
    let Some(fix) = map.line_axis(h) else { return };
    let (a, b, run) = (map.corner[h], map.corner[next(h)], 1 - fix);
    let step = map.one * (b[run] - a[run]).signum();
    if step == 0 {
        return;
    }
    let mut point = a;
    let floor = a[run].div_euclid(map.one) * map.one;
    point[run] = if step > 0 || floor == a[run] { floor + step } else { floor };
    while (b[run] - point[run]).signum() == step.signum() {
        nodes.push(Node { place: Place::Edge(h as u32), point });
        point[run] += step;
    }
}

fn push_face_nodes(map: &ExactMap<'_>, f: usize, nodes: &mut Vec<Node>) {
    let z = [map.corner[3 * f], map.corner[3 * f + 1], map.corner[3 * f + 2]];
    let low = z[0].x.min(z[1].x).min(z[2].x);
    let high = z[0].x.max(z[1].x).max(z[2].x);
    let mut c = (low.div_euclid(map.one) + 1) * map.one;
    while c < high {
        if let Some([p, q]) = gates(map, f, 0, c) {
            let (a, b) = (crossing(map, p, c), crossing(map, q, c));
            let mut y = a.min(b).div_euclid(map.one) * map.one;
            while y <= a.max(b) + 1 {
                let point = I64Vec2::new(c, y);
                if let (Some(s), Some(t)) = (is_above(map, p, 0, point), is_above(map, q, 0, point))
                    && s != t
                {
                    nodes.push(Node { place: Place::Face(f as u32, is_upright(map, [p, q], [s, t])), point });
                }
                y += map.one;
            }
        }
        c += map.one;
    }
}
