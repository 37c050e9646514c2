//! Which triangles are too thin to have a usable normal, and components that have no others.

use glam::DVec3;

use crate::engine::mesh::condition::draft::Draft;
use crate::engine::mesh::condition::patches::components;
use crate::engine::mesh::condition::tally::Tally;

/// Least height of a triangle relative to the diagonal of its component.
const MIN_HEIGHT: f64 = 1e-9;
/// Least height of a triangle relative to its longest side.
pub(super) const MIN_SHAPE: f64 = 1e-6;
/// Files of single precision hold coordinates to 6e-8 of their size: the parts of a split triangle of less than about
/// thirty times that height may have no area in them. Relative to the coordinates or the diagonal, whichever is less:
/// models far from the origin keep their detail.
const MIN_HEIGHT_WRITTEN: f64 = 2e-6;
/// Longest side that may collapse in any thin triangle, relative to the diagonal of the component.
const MAX_COLLAPSED: f64 = 1e-5;

/// What is too thin in one component.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    pub(super) least_height: f64,
    pub(super) max_collapsed: f64,
}

/// Twice the area over the longest side.
pub(super) fn height([a, b, c]: [DVec3; 3]) -> f64 {
    let longest = longest([a, b, c]);
    if longest > 0.0 { (b - a).cross(c - a).length() / longest } else { 0.0 }
}

pub(super) fn longest([a, b, c]: [DVec3; 3]) -> f64 {
    a.distance(b).max(b.distance(c)).max(c.distance(a))
}

pub(super) fn is_thin(triangle: [DVec3; 3], scale: Scale) -> bool {
    height(triangle) < scale.least_height.max(MIN_SHAPE * longest(triangle))
}

pub(super) fn triangle(draft: &Draft, f: u32) -> [DVec3; 3] {
    draft.faces[f as usize].map(|v| draft.positions[v as usize])
}

/// Drops components in which every triangle is thin: they have no area.
pub(super) fn drop_flat_components(draft: &mut Draft, tally: &mut Tally) {
    let (component, scales) = scales(draft);
    let mut has_area = vec![false; scales.len()];
    for f in 0..draft.faces.len() {
        let c = component[f] as usize;
        has_area[c] |= !is_thin(triangle(draft, f as u32), scales[c]);
    }
    let flat = has_area.iter().filter(|&&area| !area).count();
    if flat > 0 {
        let keep: Vec<bool> = component.iter().map(|&c| has_area[c as usize]).collect();
        tally.add("degenerate_faces_dropped", keep.iter().filter(|&&k| !k).count());
        draft.retain(&keep);
    }
    tally.add("components_without_area_dropped", flat);
}

pub(super) fn scales(draft: &Draft) -> (Vec<u32>, Vec<Scale>) {
    let (component, n) = components(&draft.twin);
    let mut low = vec![DVec3::INFINITY; n];
    let mut high = vec![DVec3::NEG_INFINITY; n];
    for (f, &c) in component.iter().enumerate() {
        for p in triangle(draft, f as u32) {
            low[c as usize] = low[c as usize].min(p);
            high[c as usize] = high[c as usize].max(p);
        }
    }
    let scale = |c: usize| {
        let diagonal = low[c].distance(high[c]);
        let far = low[c].abs().max(high[c].abs()).max_element();
        // Below a few units in the last place of the coordinates a height is rounding.
        let least_height =
            (MIN_HEIGHT * diagonal).max(16.0 * f64::EPSILON * far).max(MIN_HEIGHT_WRITTEN * far.min(diagonal));
        Scale { least_height, max_collapsed: MAX_COLLAPSED * diagonal }
    };
    (component, (0..n).map(scale).collect())
}

pub(super) fn longest_side([a, b, c]: [DVec3; 3]) -> usize {
    let (ab, bc, ca) = (a.distance_squared(b), b.distance_squared(c), c.distance_squared(a));
    if ab >= bc && ab >= ca {
        0
    } else if bc >= ca {
        1
    } else {
        2
    }
}
