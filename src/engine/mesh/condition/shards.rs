//! Closed components without volume.

use glam::DVec3;

use crate::engine::mesh::NONE;
use crate::engine::mesh::condition::draft::Draft;
use crate::engine::mesh::condition::patches::components;
use crate::engine::mesh::condition::tally::Tally;
use crate::engine::mesh::condition::thin::triangle;

/// A closed component thinner than this part of the model's diagonal has no volume: eight times the rounding of single
/// precision, in which most files are written.
const MIN_THICKNESS: f64 = 8.0 * f32::EPSILON as f64;

/// Drops closed components whose mean thickness, twice the volume over the area, is nothing at the size of the model
/// (`diagonal`): shards that exporters and cuts leave behind. A model that has nothing else keeps them.
pub(super) fn drop_shards(draft: &mut Draft, diagonal: f64, tally: &mut Tally) {
    let (component, n) = components(&draft.twin);
    let (mut volume, mut area, mut is_closed) = (vec![0.0; n], vec![0.0; n], vec![true; n]);
    let mut origin: Vec<Option<DVec3>> = vec![None; n];
    for (f, &c) in component.iter().enumerate() {
        let c = c as usize;
        let [p, q, r] = triangle(draft, f as u32);
        // Seen from a point of the component, so that its distance from the origin costs no digits.
        let from = *origin[c].get_or_insert(p);
        volume[c] += (p - from).dot((q - from).cross(r - from)) / 6.0;
        area[c] += 0.5 * (q - p).cross(r - p).length();
        is_closed[c] &= draft.twin[3 * f..3 * f + 3].iter().all(|&t| t != NONE);
    }
    let is_shard = |c: usize| is_closed[c] && 2.0 * f64::abs(volume[c]) <= MIN_THICKNESS * diagonal * area[c];
    let shards = (0..n).filter(|&c| is_shard(c)).count();
    if shards == 0 || shards == n {
        return;
    }
    let keep: Vec<bool> = component.iter().map(|&c| !is_shard(c as usize)).collect();
    draft.retain(&keep);
    tally.add("components_without_volume_dropped", shards);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::mesh::TriangleSoup;
    use crate::engine::mesh::condition::{ConditionOptions, condition};
    use crate::engine::mesh::shapes::sample_surface;
    use crate::engine::run::RunContext;

    #[test]
    fn shards_without_volume_go_unless_there_is_nothing_else() {
        let mesh = sample_surface("cube", 300).unwrap().mesh;
        let mut soup = TriangleSoup::from_triangles(mesh.positions().to_vec(), mesh.faces());
        let boxes = soup.n_polygons();
        let shard = |soup: &mut TriangleSoup, at: DVec3, thick: f64| {
            let n = soup.positions.len() as u32;
            soup.positions.extend(
                [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::splat(0.3) * DVec3::new(1.0, 1.0, thick)]
                    .map(|p| at + 0.1 * p),
            );
            for [a, b, c] in [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] {
                soup.push_polygon(&[n + a, n + b, n + c]);
            }
        };
        shard(&mut soup, DVec3::splat(2.0), 1e-6);
        shard(&mut soup, DVec3::splat(3.0), 1e-3);
        let run = |soup: &TriangleSoup| condition(&RunContext::silent(), soup, &ConditionOptions::default()).unwrap();
        let c = run(&soup);
        assert_eq!(c.repairs.iter().find(|r| r.0 == "components_without_volume_dropped").map(|r| r.1), Some(1));
        assert_eq!(c.mesh.topology().components, 2, "a thin one with some volume stays");
        assert!(c.polygon.iter().all(|&p| (p as usize) < boxes || (p as usize) >= boxes + 4));
        let mut alone = TriangleSoup::default();
        shard(&mut alone, DVec3::splat(2.0), 1e-6);
        assert_eq!(run(&alone).mesh.topology().components, 1);
    }
}
