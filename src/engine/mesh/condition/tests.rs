use glam::DVec3;

use super::*;
use crate::engine::mesh::Conditioned;
use crate::engine::mesh::TriangleSoup;
use crate::engine::run::RunContext;

fn run(soup: &TriangleSoup) -> Result<Conditioned, ConditionError> {
    condition(&RunContext::silent(), soup, &ConditionOptions::default())
}

fn box_at(corner: DVec3, soup: &mut TriangleSoup) {
    let base = soup.positions.len() as u32;
    soup.positions
        .extend((0..8).map(|i| corner + DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1))));
    for q in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
        soup.push_polygon(&q.map(|i| base + i));
    }
}

#[test]
fn a_cube_of_quads_is_a_sphere_without_repairs() {
    let mut soup = TriangleSoup::default();
    box_at(DVec3::ZERO, &mut soup);
    let c = run(&soup).unwrap();
    assert_eq!(c.mesh.topology().euler, 2);
    assert_eq!(c.mesh.n_faces(), 12);
    assert!(c.repairs.is_empty(), "{:?}", c.repairs);
    assert_eq!(c.polygon, (0..12).map(|f| f / 2).collect::<Vec<u32>>());
}
