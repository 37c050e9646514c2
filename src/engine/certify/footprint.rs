//! The surface's normal averaged over the footprint of a quad.
//!
//! A quad cannot follow a wrinkle below its size. What it must agree with is the mean direction of the surface beneath
//! it, and only of the sheet that it lies on: the mean is taken over what a walk over neighbours reaches, never over what
//! merely lies near. Walks do not cross features: there the surface turns, and quads end there as well.

use crate::engine::mesh::{FaceCells, NONE, Surface, closest_on_triangle};
use glam::DVec3;

/// Extent of a cell in edges of a quad: a footprint is two edges wide, so some sixty cells make its mean.
const CELL: f64 = 0.25;
/// Most cells in one mean: eight times those of a flat footprint; what is left out lies furthest from the start.
const MAX_CELLS: usize = 512;
/// Cells that turn by more than 120 degrees (cosine) are the two sides of a sheet that is thinner than they are.
const SHARP: f64 = -0.5;
/// Slots of the set of cells that were seen, a power of two.
const SLOTS: usize = 2048;

/// Faces joined to cells of a quarter of a quad's edge, so that a mean costs the same however fine the triangles are.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    cells: FaceCells,
    /// Per cell, twice its area vector.
    area: Vec<DVec3>,
    /// Per cell, the centroid and the largest distance of a face's centroid from it.
    ball: Vec<(DVec3, f64)>,
}

/// Where a mean is taken: a ball.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    pub(super) centre: DVec3,
    pub(super) radius: f64,
}

/// What the walk that takes a mean goes over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Steps {
    /// The cells.
    Cells,
    /// Single faces, for quads much smaller than the cells are made for.
    Faces,
}

impl Cells {
    /// Joins the faces of a surface to cells for quads with edges of this length. `barrier`: per halfedge, whether a walk
    /// stops there. O(F log F).
    pub(super) fn new(surface: &Surface, barrier: &[bool], edge_length: f64) -> Self {
        let mesh = &surface.mesh;
        let cells = FaceCells::new(mesh, barrier, 0.5 * CELL * edge_length);
        let middle = |f: u32| mesh.triangle(f as usize).iter().sum::<DVec3>() / 3.0;
        let (mut area, mut ball) = (Vec::with_capacity(cells.len()), Vec::with_capacity(cells.len()));
        for cell in 0..cells.len() as u32 {
            let faces = cells.faces(cell);
            let size: f64 = faces.iter().map(|&f| mesh.area(f as usize)).sum();
            let weighted: DVec3 = faces.iter().map(|&f| mesh.area(f as usize) * middle(f)).sum();
            let centre = if size > 0.0 { weighted / size } else { middle(faces[0]) };
            let radius = faces.iter().map(|&f| middle(f).distance(centre)).fold(0.0, f64::max);
            area.push(faces.iter().map(|&f| mesh.area_vector(f as usize)).sum());
            ball.push((centre, radius));
        }
        Self { cells, area, ball }
    }

    /// The mean normal over what a walk from a face reaches within a ball, and on no longer ways than its radius. Zero only
    /// if all of it has no area.
    pub(super) fn mean(&self, surface: &Surface, barrier: &[bool], face: u32, ball: Ball, steps: Steps) -> DVec3 {
        let mesh = &surface.mesh;
        let mut walk = Walk::new();
        let mut sum = DVec3::ZERO;
        walk.offer(Step {
            at: match steps {
                Steps::Faces => face,
                Steps::Cells => self.cells.of(face),
            },
            way: 0.0,
            from: ball.centre,
            normal: DVec3::ZERO,
        });
        while let Some(step) = walk.next() {
            let single = match steps {
                Steps::Faces => Some(step.at),
                Steps::Cells => Some(self.cells.faces(step.at)).filter(|faces| faces.len() == 1).map(|faces| faces[0]),
            };
            let (area, place, slack) = match single {
                None => {
                    let (centre, radius) = self.ball[step.at as usize];
                    (self.area[step.at as usize], centre, radius)
                }
                Some(face) => {
                    let corners = mesh.triangle(face as usize);
                    (part_within(&corners, 2.0 * ball.radius), closest_on_triangle(ball.centre, &corners).1, 0.0)
                }
            };
            // The quad may hover over its start: the way begins there.
            let way = if walk.taken == 1 { 0.0 } else { step.way + step.from.distance(place) };
            let normal = area.normalize_or_zero();
            if way > ball.radius + slack || normal.dot(step.normal) < SHARP {
                continue;
            }
            sum += area;
            let mut offer = |at: u32| walk.offer(Step { at, way, from: place, normal });
            match steps {
                Steps::Faces => {
                    let f = 3 * step.at as usize;
                    (f..f + 3).filter(|&h| !barrier[h]).filter_map(|h| mesh.twin(h)).for_each(|t| offer(t as u32 / 3));
                }
                Steps::Cells => self.cells.neighbours(step.at).iter().for_each(|&cell| offer(cell)),
            }
        }
        sum.normalize_or_zero()
    }
}

/// Twice the area vector of the part of a triangle that a ball of this diameter can hold.
fn part_within(&[a, b, c]: &[DVec3; 3], diameter: f64) -> DVec3 {
    let area = (b - a).cross(c - a);
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    if longest <= diameter {
        return area;
    }
    let height = area.length() / longest;
    area * (diameter / longest) * if height > diameter { diameter / height } else { 1.0 }
}

/// One cell of a walk and how it was reached.
#[derive(Clone, Copy)]
struct Step {
    at: u32,
    /// Length of the way to `from`.
    way: f64,
    /// The place from which the cell was reached, and the normal there.
    from: DVec3,
    normal: DVec3,
}

/// A walk in breadth, each cell once, without memory from the heap.
struct Walk {
    queue: [Step; MAX_CELLS],
    filled: usize,
    taken: usize,
    seen: [u32; SLOTS],
}

impl Walk {
    fn new() -> Self {
        let nowhere = Step { at: NONE, way: 0.0, from: DVec3::ZERO, normal: DVec3::ZERO };
        Self { queue: [nowhere; MAX_CELLS], filled: 0, taken: 0, seen: [NONE; SLOTS] }
    }

    fn offer(&mut self, step: Step) {
        if self.filled == MAX_CELLS {
            return;
        }
        let mut slot = (step.at.wrapping_mul(0x9E37_79B1) >> 16) as usize % SLOTS;
        while self.seen[slot] != NONE {
            if self.seen[slot] == step.at {
                return;
            }
            slot = (slot + 1) % SLOTS;
        }
        self.seen[slot] = step.at;
        self.queue[self.filled] = step;
        self.filled += 1;
    }

    fn next(&mut self) -> Option<Step> {
        let step = (self.taken < self.filled).then(|| self.queue[self.taken])?;
        self.taken += 1;
        Some(step)
    }
}
