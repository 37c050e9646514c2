//! Patterns of quads that fill a polygon with an even number of sides.

/// Quads over the corners 0 to n − 1 of a polygon, counter-clockwise, and further nodes from n on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Pattern {
    pub(crate) sides: u32,
    pub(crate) new_nodes: u32,
    pub(crate) quads: Vec<[u32; 4]>,
}

/// Above this number of sides only grids are tried.
const MANY_SIDES: u32 = 20;
/// Above this number of sides only some grids are tried.
const VERY_MANY_SIDES: u32 = 64;

impl Pattern {
    /// An `a` by `b` grid whose first corner is at polygon corner `at`; 2 (a + b) sides. With a = 1 there are no new nodes.
    pub(crate) fn grid(a: u32, b: u32, at: u32) -> Self {
        let sides = 2 * (a + b);
        let id = |x: u32, y: u32| {
            let round = match (x, y) {
                (_, 0) => x,
                (x, y) if x == a => a + y,
                (x, y) if y == b => a + b + (a - x),
                (0, y) => 2 * a + b + (b - y),
                (x, y) => return sides + (x - 1) + (y - 1) * (a - 1),
            };
            (round + at) % sides
        };
        let quad = |x, y| [id(x, y), id(x + 1, y), id(x + 1, y + 1), id(x, y + 1)];
        let quads = (0..b).flat_map(|y| (0..a).map(move |x| (x, y))).map(|(x, y)| quad(x, y)).collect();
        Self { sides, new_nodes: (a - 1) * (b - 1), quads }
    }

    /// Grids around one centre, `spokes.len()` of them, grid i between spokes i and i + 1 of so many segments. Side i of
    /// the patch has as many segments as spokes i − 1 and i + 1 together; the first side begins at polygon corner `at`.
    pub(crate) fn star(spokes: &[u32], at: u32) -> Self {
        let k = spokes.len();
        let sides = 2 * spokes.iter().sum::<u32>();
        let centre = sides;
        let mut new_nodes = 1;
        let mut inner_of_spoke = Vec::new();
        for &s in spokes {
            inner_of_spoke.push(sides + new_nodes);
            new_nodes += s - 1;
        }
        let mut foot = spokes[k - 1];
        let mut quads = Vec::new();
        for i in 0..k {
            let j = (i + 1) % k;
            let (a, b, inner) = (spokes[i], spokes[j], sides + new_nodes);
            new_nodes += (a - 1) * (b - 1);
            let id = |x: u32, y: u32| match (x, y) {
                (0, 0) => centre,
                (x, 0) if x < a => inner_of_spoke[i] + x - 1,
                (0, y) if y < b => inner_of_spoke[j] + y - 1,
                (x, y) if x == a => (foot + y + at) % sides,
                (x, y) if y == b => (foot + b + (a - x) + at) % sides,
                (x, y) => inner + (x - 1) + (y - 1) * (a - 1),
            };
            for y in 0..b {
                for x in 0..a {
                    quads.push([id(x, y), id(x + 1, y), id(x + 1, y + 1), id(x, y + 1)]);
                }
            }
            foot += b + a;
        }
        Self { sides, new_nodes, quads }
    }

    /// A ring of quads around `core`, a pattern for as many sides: new arcs join only new nodes to each other and each
    /// polygon corner to its own new node, so they duplicate nothing.
    pub(crate) fn padded(core: &Pattern) -> Self {
        let n = core.sides;
        let ring = (0..n).map(|i| [i, (i + 1) % n, n + (i + 1) % n, n + i]);
        let quads = ring.chain(core.quads.iter().map(|q| q.map(|v| v + n))).collect();
        Self { sides: n, new_nodes: core.new_nodes + n, quads }
    }

    /// All patterns that are tried for a polygon, for an even number of sides from 4 on.
    pub(crate) fn candidates(sides: u32) -> Vec<Self> {
        let mut all = Vec::new();
        let half = sides / 2;
        let some = [1, 2, 3, half / 4, half / 3, half / 2];
        let (widths, step): (Vec<u32>, u32) =
            if sides > VERY_MANY_SIDES { (some.to_vec(), half / 16) } else { ((1..=half / 2).collect(), 1) };
        for a in widths {
            // The grid a by b at `at` is the grid b by a at `at + a`, and the same at `at + half`.
            let b = half - a;
            let turns = if a == b { a } else { half };
            all.extend((0..turns).step_by(step as usize).map(|at| Self::grid(a, b, at)));
        }
        if sides <= MANY_SIDES {
            for k in [3, 5] {
                compositions(half, k, &mut Vec::new(), &mut |spokes| {
                    // Turning the list of spokes by one is the same as beginning at another corner.
                    if (1..spokes.len()).all(|turn| spokes <= &turned(spokes, turn)[..]) {
                        all.extend((0..sides).map(|at| Self::star(spokes, at)));
                    }
                });
            }
        }
        all
    }
}

fn turned(list: &[u32], by: usize) -> Vec<u32> {
    let mut list = list.to_vec();
    list.rotate_left(by);
    list
}

/// All lists of `parts` positive numbers with this sum.
fn compositions(sum: u32, parts: u32, head: &mut Vec<u32>, visit: &mut impl FnMut(&[u32])) {
    if parts == 1 {
        head.push(sum);
        visit(head);
        head.pop();
        return;
    }
    for first in 1..sum.saturating_sub(parts - 2) {
        head.push(first);
        compositions(sum - first, parts - 1, head, visit);
        head.pop();
    }
}
