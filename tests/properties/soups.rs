//! Soups with every kind of damage.

use std::collections::BTreeSet;

use glam::DVec3;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;
use quadrille::engine::mesh::TriangleSoup;
use quadrille::engine::mesh::shapes::sample;

/// What is wrong with a soup.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Damage {
    /// A triangle of a surface was taken away.
    Missing,
    /// A triangle was turned over.
    TurnedOver,
    /// A triangle is there twice.
    Doubled,
    /// Two vertices became one.
    Joined,
    /// A vertex was torn away.
    Moved,
    /// A triangle was put between any three vertices.
    Stray,
    /// A polygon of one or two corners.
    TooFewCorners,
    /// A polygon that names a vertex twice.
    RepeatedCorner,
    /// Two vertices at the same place.
    SamePlace,
    /// Two vertices at nearly the same place.
    NearlySamePlace,
    /// A vertex that no polygon names.
    Unused,
}

impl Damage {
    /// What [`wreck`] does to a surface.
    pub(crate) const DEALT: [Self; 6] =
        [Self::Missing, Self::TurnedOver, Self::Doubled, Self::Joined, Self::Moved, Self::Stray];
    /// What [`heap`] comes with.
    pub(crate) const FOUND: [Self; 5] =
        [Self::TooFewCorners, Self::RepeatedCorner, Self::SamePlace, Self::NearlySamePlace, Self::Unused];
}

/// A soup, and what is wrong with it.
#[derive(Clone, Debug)]
pub(crate) struct Damaged {
    pub(crate) soup: TriangleSoup,
    pub(crate) damage: BTreeSet<Damage>,
}

/// Coordinates of all sizes: a power of ten, and how far from the origin in extents.
pub(crate) fn placement() -> impl Strategy<Value = (i32, f64)> {
    (-9..10i32, prop_oneof![3 => Just(0.0), 1 => -100.0..100.0f64])
}

pub(crate) fn place(soup: &mut TriangleSoup, (exponent, offset): (i32, f64)) {
    let scale = 10f64.powi(exponent);
    soup.positions.iter_mut().for_each(|p| *p = (*p + DVec3::new(offset, -offset, 0.5 * offset)) * scale);
}

/// Polygons over few places, which mostly are on a coarse grid: every kind of degeneracy at once.
pub(crate) fn heap() -> impl Strategy<Value = Damaged> {
    let grid = (0..4i32, 0..4i32, 0..3i32).prop_map(|(x, y, z)| DVec3::new(x.into(), y.into(), z.into()));
    let anywhere = (-1.0..4.0f64, -1.0..4.0f64, -1.0..3.0f64).prop_map(|(x, y, z)| DVec3::new(x, y, z));
    let close = (0..4i32, 0..4i32, -1e-7..1e-7f64).prop_map(|(x, y, z)| DVec3::new(x.into(), y.into(), z));
    let position = prop_oneof![4 => grid, 2 => anywhere, 1 => close];
    let polygon = prop_oneof![4 => vec(0..1000u32, 3), 1 => vec(0..1000u32, 1..7)];
    (vec(position, 3..10), vec(polygon, 1..14), placement()).prop_map(|(positions, polygons, placement)| {
        let n = positions.len() as u32;
        let mut soup = TriangleSoup { positions, ..TriangleSoup::default() };
        for polygon in polygons {
            soup.push_polygon(&polygon.iter().map(|i| i % n).collect::<Vec<u32>>());
        }
        let damage = damage_of(&soup);
        place(&mut soup, placement);
        Damaged { soup, damage }
    })
}

/// What is wrong with a heap, of which neighbouring places are about 1 apart.
fn damage_of(soup: &TriangleSoup) -> BTreeSet<Damage> {
    let used: BTreeSet<u32> = soup.indices.iter().copied().collect();
    let repeats = |polygon: &[u32]| polygon.iter().collect::<BTreeSet<_>>().len() < polygon.len();
    let apart = |(i, p): (usize, &DVec3)| soup.positions[..i].iter().map(move |q| q.distance(*p)).collect::<Vec<_>>();
    let distances: Vec<f64> = soup.positions.iter().enumerate().flat_map(apart).collect();
    let found = [
        (Damage::TooFewCorners, soup.polygons().any(|polygon| polygon.len() < 3)),
        (Damage::RepeatedCorner, soup.polygons().any(repeats)),
        (Damage::SamePlace, distances.contains(&0.0)),
        (Damage::NearlySamePlace, distances.iter().any(|d| (f64::MIN_POSITIVE..1e-6).contains(d))),
        (Damage::Unused, used.len() < soup.positions.len()),
    ];
    found.into_iter().filter_map(|(damage, is_there)| is_there.then_some(damage)).collect()
}

/// A small surface with triangles missing, turned over and doubled, vertices joined and vertices torn away.
pub(crate) fn wreck() -> impl Strategy<Value = Damaged> {
    let base = prop_oneof![16 => Just(("cube", 12)), 4 => Just(("cube", 48)), 1 => Just(("half_pipe", 200))];
    let blows = vec((select(&Damage::DEALT[..]), any::<u32>(), any::<u32>()), 0..10);
    (base, blows, placement()).prop_map(|((name, triangles), blows, placement)| {
        let mut soup = sample(name, triangles, 0.0, 0).unwrap_or_default();
        let mut faces: Vec<Vec<u32>> = soup.polygons().map(<[u32]>::to_vec).collect();
        for &(damage, i, j) in &blows {
            let (n, m) = (soup.positions.len() as u32, faces.len());
            let face = i as usize % m;
            match damage {
                // The last triangle stays.
                Damage::Missing if m > 1 => drop(faces.swap_remove(face)),
                Damage::Missing => {}
                Damage::TurnedOver => faces[face].reverse(),
                Damage::Doubled => faces.push(faces[face].clone()),
                Damage::Joined => faces.iter_mut().flatten().filter(|v| **v == i % n).for_each(|v| *v = j % n),
                Damage::Moved => soup.positions[(i % n) as usize] = soup.positions[(j % n) as usize] * 1.5,
                _ => faces.push(vec![i % n, j % n, (i ^ j) % n]),
            }
        }
        let mut soup = TriangleSoup { positions: soup.positions, ..TriangleSoup::default() };
        faces.iter().for_each(|face| soup.push_polygon(face));
        place(&mut soup, placement);
        Damaged { soup, damage: blows.iter().map(|blow| blow.0).collect() }
    })
}
