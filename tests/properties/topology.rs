//! Topology by counting, without anything of the engine.

use std::collections::BTreeMap;

/// Euler characteristic and number of loops of the boundary; an error where an edge has more than two faces, two faces
/// run along an edge in the same direction, or a vertex has two fans.
pub(crate) fn topology<const N: usize>(faces: &[[u32; N]]) -> Result<(i64, usize), String> {
    let mut side = BTreeMap::new();
    let mut corners: BTreeMap<u32, Vec<(usize, usize)>> = BTreeMap::new();
    for (f, face) in faces.iter().enumerate() {
        for k in 0..N {
            if side.insert((face[k], face[(k + 1) % N]), (f, k)).is_some() {
                return Err(format!("two faces run from {} to {}", face[k], face[(k + 1) % N]));
            }
            corners.entry(face[k]).or_default().push((f, k));
        }
    }
    let edges = side.keys().filter(|&&(a, b)| a < b || !side.contains_key(&(b, a))).count();
    let mut after = BTreeMap::new();
    for &(a, b) in side.keys().filter(|&&(a, b)| !side.contains_key(&(b, a))) {
        if after.insert(a, b).is_some() {
            return Err(format!("the boundary meets itself at {a}"));
        }
    }
    for (&v, around) in &corners {
        // From the boundary if there is one, across edges, all corners are met.
        let is_first = |&&(f, k): &&(usize, usize)| !side.contains_key(&(faces[f][(k + 1) % N], v));
        let first = around.iter().find(is_first).copied().unwrap_or(around[0]);
        let across = |(f, k): (usize, usize)| side.get(&(v, faces[f][(k + N - 1) % N])).copied();
        let fan = std::iter::successors(Some(first), |&c| across(c).filter(|&c| c != first));
        let met = fan.take(around.len() + 1).count();
        if met != around.len() {
            return Err(format!("vertex {v} has {} corners, {met} in one fan", around.len()));
        }
    }
    let mut loops = 0;
    while let Some((start, mut at)) = after.pop_first() {
        loops += 1;
        while at != start {
            at = after.remove(&at).ok_or("the boundary ends")?;
        }
    }
    Ok((corners.len() as i64 - edges as i64 + faces.len() as i64, loops))
}
