//! Which quads meet at a vertex, and which vertices may be moved at the same time.

/// The quads of every vertex, and classes of vertices that share no quad.
#[derive(Clone, Debug)]
pub(crate) struct Incidence {
    start: Vec<u32>,
    /// Corners 4 q + k, grouped by vertex.
    corners: Vec<u32>,
    /// Vertices of each colour in index order. No two vertices of one colour belong to one quad, so moving one does
    /// not change what the move of another is judged by: the order within a colour does not matter.
    pub(crate) colours: Vec<Vec<u32>>,
}

impl Incidence {
    pub(crate) fn new(n_vertices: usize, quads: &[[u32; 4]]) -> Self {
        let mut start = vec![0u32; n_vertices + 1];
        for &v in quads.iter().flatten() {
            start[v as usize + 1] += 1;
        }
        for v in 0..n_vertices {
            start[v + 1] += start[v];
        }
        let mut fill = start.clone();
        let mut corners = vec![0u32; 4 * quads.len()];
        for (q, quad) in quads.iter().enumerate() {
            for (k, &v) in quad.iter().enumerate() {
                corners[fill[v as usize] as usize] = (4 * q + k) as u32;
                fill[v as usize] += 1;
            }
        }
        let mut incidence = Self { start, corners, colours: Vec::new() };
        incidence.colours = incidence.colour(quads);
        incidence
    }

    fn colour(&self, quads: &[[u32; 4]]) -> Vec<Vec<u32>> {
        let n_vertices = self.start.len() - 1;
        let mut colour = vec![u32::MAX; n_vertices];
        let mut classes: Vec<Vec<u32>> = Vec::new();
        let mut taken: Vec<u32> = Vec::new();
        for v in 0..n_vertices as u32 {
            if self.corners_of(v).is_empty() {
                continue;
            }
            taken.clear();
            taken.extend(self.corners_of(v).iter().flat_map(|&c| quads[c as usize / 4]).map(|w| colour[w as usize]));
            taken.sort_unstable();
            let mut free = 0;
            for &c in &taken {
                free += u32::from(c == free);
            }
            colour[v as usize] = free;
            if free as usize == classes.len() {
                classes.push(Vec::new());
            }
            classes[free as usize].push(v);
        }
        classes
    }

    /// Corners 4 q + k at vertex `v`.
    pub(crate) fn corners_of(&self, v: u32) -> &[u32] {
        &self.corners[self.start[v as usize] as usize..self.start[v as usize + 1] as usize]
    }
}

/// The edges of quads as (lower, higher) vertex index, sorted, with the number of quads at each.
pub(crate) fn counted_edges(quads: &[[u32; 4]]) -> Vec<([u32; 2], u32)> {
    let side = |q: &[u32; 4], k: usize| [q[k].min(q[(k + 1) % 4]), q[k].max(q[(k + 1) % 4])];
    let mut edges: Vec<_> = quads.iter().flat_map(|q| (0..4).map(move |k| side(q, k))).collect();
    edges.sort_unstable();
    let mut counted: Vec<([u32; 2], u32)> = Vec::with_capacity(edges.len() / 2);
    for edge in edges {
        match counted.last_mut() {
            Some((last, n)) if *last == edge => *n += 1,
            _ => counted.push((edge, 1)),
        }
    }
    counted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_of_one_colour_share_no_quad() {
        let at = |i: u32, j: u32| 5 * i + j;
        let quads: Vec<_> = (0..16).map(|n| (n / 4, n % 4)).collect::<Vec<_>>();
        let quads: Vec<[u32; 4]> =
            quads.into_iter().map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]).collect();
        let incidence = Incidence::new(25, &quads);
        assert_eq!(incidence.colours.iter().map(Vec::len).sum::<usize>(), 25);
        for class in &incidence.colours {
            for quad in &quads {
                assert!(quad.iter().filter(|v| class.contains(v)).count() <= 1);
            }
        }
        assert_eq!(incidence.corners_of(6).len(), 4);
        let edges = counted_edges(&quads);
        assert_eq!((edges.len(), edges.iter().filter(|e| e.1 == 1).count()), (40, 16));
    }
}
