//! Pairs that must not collapse on the grid: singularities, corners, feature curves and boundaries that are near
//! each other on the surface.
//!
//! Regions of nearest elements are grown along edges; where two regions meet, the path between their elements is
//! unfolded into one chart. If the longer of its two coordinates is a difference of integers, it must stay at least one
//! grid unit and keep its sign; otherwise the strip between the two elements would have no width.

use std::collections::BTreeMap;

use crate::engine::mesh::NONE;
use crate::engine::mesh::TriMesh;
use crate::engine::mesh::{next, prev};
use crate::engine::numerics::PathSearch;
use crate::engine::parameterize::corner_forms::{CornerForms, Form, real_parts};
use crate::engine::parameterize::grid_map::{Iso, rotate};
use crate::engine::parameterize::reduced::{Place, Unknowns};
use crate::engine::topology::CutGraph;
use glam::DVec2;

/// A difference of integers that must stay at least one, with its sign.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Separation {
    /// Terms over integer unknowns; the sign is chosen so that the value must be ≥ 1.
    pub(super) form: Vec<(u32, f64)>,
}

impl Separation {
    /// The difference for these integers.
    pub(super) fn value(&self, q: &[f64]) -> f64 {
        self.form.iter().map(|&(i, c)| c * q[i as usize]).sum()
    }

    /// Whether these integers let the two collapse, or change places.
    pub(super) fn is_violated(&self, q: &[f64]) -> bool {
        is_violated(self.value(q))
    }
}

/// Whether a value that must be ≥ 1 is not; between points of even index halves are possible.
pub(super) fn is_violated(value: f64) -> bool {
    value < 0.5
}

/// What the search knows of the map.
pub(super) struct Elements<'a> {
    pub(super) mesh: &'a TriMesh,
    pub(super) cut: &'a CutGraph,
    pub(super) forms: &'a CornerForms,
    pub(super) unknowns: &'a Unknowns,
    pub(super) iso: &'a [Iso],
    /// Vertices on integer points, sorted.
    pub(super) special: &'a [u32],
    /// Corner values of the seamless map in grid units of the density asked for.
    pub(super) seamless: &'a [DVec2],
}

/// Paths longer than this many grid units cannot be rounded to nothing.
const LONGEST: f64 = 2.5;
/// The coordinate that must not vanish is at least so long in the seamless map.
pub(super) const SHORTEST: f64 = 0.02;

/// Finds the pairs. O(F log F).
pub(super) fn separations(elements: &Elements<'_>) -> Vec<Separation> {
    let mesh = elements.mesh;
    let turned = corner_quarters(mesh, elements.cut);
    let integral = integral_coordinates(elements, &turned);
    let mut found: BTreeMap<Vec<(u32, i64)>, Separation> = BTreeMap::new();
    let special: Vec<u32> = elements.special.to_vec();
    let all: Vec<u32> = (0..mesh.n_vertices() as u32).filter(|&v| integral[v as usize] != [false; 2]).collect();
    for sources in [special, all] {
        let (from, step) = grow(elements, &sources);
        for h in (0..mesh.n_halfedges()).filter(|&h| mesh.is_edge_owner(h)) {
            let (a, b) = (mesh.origin(h), mesh.target(h));
            let (source_a, source_b) = (from[a as usize], from[b as usize]);
            if source_a == NONE || source_b == NONE || source_a == source_b {
                continue;
            }
            let mut path = vec![(h, next(h))];
            walk_back(mesh, &step, a, |s| path.insert(0, s));
            walk_back(mesh, &step, b, |(x, y)| path.push((y, x)));
            if let Some(separation) = separate(elements, &turned, &integral, &path) {
                let key = separation.form.iter().map(|&(i, c)| (i, (2.0 * c).round() as i64)).collect();
                found.entry(key).or_insert(separation);
            }
        }
    }
    found.into_values().collect()
}

/// Per corner, the rotation of its chart against the chart of the first corner of its fan: differences obey
/// `z_corner = i^q z_first`.
fn corner_quarters(mesh: &TriMesh, cut: &CutGraph) -> Vec<u8> {
    let mut quarters = vec![0u8; mesh.n_halfedges()];
    for v in 0..mesh.n_vertices() as u32 {
        let mut q = 0u8;
        for h in mesh.fan(v) {
            quarters[h] = q;
            if let Some((segment, along)) = cut.segment_of[prev(h)] {
                let m = cut.segments[segment as usize].quarters;
                q = if along { (q + 4 - m) & 3 } else { (q + m) & 3 };
            }
        }
    }
    quarters
}

/// Per vertex, whether u and v are integers, in the chart of its first corner.
fn integral_coordinates(elements: &Elements<'_>, turned: &[u8]) -> Vec<[bool; 2]> {
    let mesh = elements.mesh;
    let mut integral = vec![[false; 2]; mesh.n_vertices()];
    for h in 0..mesh.n_halfedges() {
        if elements.iso[h] == Iso::None {
            continue;
        }
        for corner in [h, next(h)] {
            let is_u = (elements.iso[h] == Iso::U) != (turned[corner] & 1 == 1);
            integral[mesh.origin(corner) as usize][usize::from(!is_u)] = true;
        }
    }
    for &v in elements.special {
        integral[v as usize] = [true; 2];
    }
    integral
}

/// A step along an edge, as two corners of one face.
type Step = (usize, usize);

/// Nearest source of each vertex by length in the grid, and the step by which it was reached.
fn grow(elements: &Elements<'_>, sources: &[u32]) -> (Vec<u32>, Vec<Option<Step>>) {
    let mesh = elements.mesh;
    let mut from = vec![NONE; mesh.n_vertices()];
    let mut step: Vec<Option<Step>> = vec![None; mesh.n_vertices()];
    let mut search = PathSearch::new(mesh.n_vertices());
    for &v in sources {
        from[v as usize] = v;
        search.start(v, 0.0);
    }
    while let Some((d, v)) = search.nearest() {
        if d > 0.5 * LONGEST {
            break;
        }
        for h in mesh.fan(v) {
            for (here, there) in [(h, next(h)), (h, prev(h))] {
                let w = mesh.origin(there);
                let longer = d + (elements.seamless[there] - elements.seamless[here]).length();
                if search.reach(w, longer, there as u32, v) {
                    from[w as usize] = from[v as usize];
                    step[w as usize] = Some((here, there));
                }
            }
        }
    }
    (from, step)
}

fn walk_back(mesh: &TriMesh, step: &[Option<Step>], mut v: u32, mut visit: impl FnMut(Step)) {
    while let Some((here, there)) = step[v as usize] {
        visit((here, there));
        v = mesh.origin(here);
    }
}

/// Unfolds the path into the chart of its first corner; a separation if its longer coordinate is one of integers.
fn separate(elements: &Elements<'_>, turned: &[u8], integral: &[[bool; 2]], path: &[Step]) -> Option<Separation> {
    let mesh = elements.mesh;
    let mut difference = DVec2::ZERO;
    let mut form: Form = Vec::new();
    let mut quarters = 0u8;
    for (k, &(a, b)) in path.iter().enumerate() {
        if k > 0 {
            // From the chart of the last face to this one around their common vertex.
            let last = path[k - 1].1;
            quarters = (quarters + turned[last] + 4 - turned[a]) & 3;
        }
        difference += rotate(elements.seamless[b] - elements.seamless[a], quarters);
        for (corner, sign) in [(b, 0), (a, 2)] {
            let terms = &elements.forms.corner[corner];
            form.extend(terms.iter().map(|t| {
                let mut t = *t;
                t.quarters = (t.quarters + quarters + sign) & 3;
                t
            }));
        }
    }
    let coordinate = usize::from(difference.y.abs() > difference.x.abs());
    if difference[coordinate].abs() < SHORTEST || difference.length() > LONGEST {
        return None;
    }
    // Which coordinate of each end, in its own first chart, this is.
    let (start, end) = (path[0].0, path[path.len() - 1].1);
    let at_start = coordinate ^ usize::from(turned[start] & 1);
    let at_end = coordinate ^ usize::from((quarters + turned[end]) & 1);
    if !integral[mesh.origin(start) as usize][at_start] || !integral[mesh.origin(end) as usize][at_end] {
        return None;
    }
    integer_form(elements.unknowns, &real_parts(&form)[coordinate], difference[coordinate].signum())
}

/// The form over integer unknowns; `None` if it is constant or needs others.
fn integer_form(unknowns: &Unknowns, raw: &[(u32, f64)], sign: f64) -> Option<Separation> {
    let mut sum: BTreeMap<u32, f64> = BTreeMap::new();
    for &(x, c) in raw {
        for &(y, d) in &unknowns.forms[x as usize] {
            *sum.entry(y).or_insert(0.0) += c * d;
        }
    }
    let mut form = Vec::with_capacity(sum.len());
    for (x, c) in sum.into_iter().filter(|&(_, c)| c != 0.0) {
        match unknowns.place[x as usize] {
            Place::Integer(i) => form.push((i, sign * c)),
            _ => return None,
        }
    }
    (!form.is_empty()).then_some(Separation { form })
}
