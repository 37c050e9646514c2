//! What vertices of a primitive say besides where they are.

use super::super::error::ReadError;
use super::super::soup_builder::NO_VALUE;
use super::accessor::Accessor;
use super::document::Document;
use super::fault::malformed;

pub(super) fn read_colours(
    document: &Document<'_>,
    i: usize,
    count: usize,
    place: &str,
) -> Result<Vec<[f32; 4]>, ReadError> {
    let accessor = Accessor::of(document, i, place)?;
    if accessor.count != count || !matches!(accessor.components, 3 | 4) {
        return Err(malformed(accessor.place, "COLOR_0 must be VEC3 or VEC4 with one element per vertex"));
    }
    let colours = accessor.floats()?;
    let colours = colours.chunks_exact(accessor.components);
    Ok(colours.map(|c| [c[0] as f32, c[1] as f32, c[2] as f32, c.get(3).map_or(NO_VALUE, |&a| a as f32)]).collect())
}

/// Texture coordinates with v upwards: glTF counts it downwards from 1.
pub(super) fn read_uv(
    document: &Document<'_>,
    i: usize,
    count: usize,
    place: &str,
) -> Result<Vec<[f32; 2]>, ReadError> {
    let accessor = Accessor::of(document, i, place)?;
    if accessor.count != count || accessor.components != 2 {
        return Err(malformed(accessor.place, "TEXCOORD_0 must be VEC2 with one element per vertex"));
    }
    Ok(accessor.floats()?.chunks_exact(2).map(|c| [c[0] as f32, (1.0 - c[1]) as f32]).collect())
}

/// Normals; none where they are not what they should be: no shape depends on them.
pub(super) fn read_normals(document: &Document<'_>, i: usize, count: usize, place: &str) -> Option<Vec<[f32; 3]>> {
    let accessor = Accessor::of(document, i, place).ok()?;
    if accessor.count != count || accessor.components != 3 {
        return None;
    }
    let normals = accessor.floats().ok()?;
    Some(normals.as_chunks::<3>().0.iter().map(|n| n.map(|x| x as f32)).collect())
}

/// Which vertex each one is a copy of, as our own writer says it (itself for most); none if that cannot be: copies
/// follow what they are copies of and are at the same place.
pub(super) fn read_order(document: &Document<'_>, i: usize, positions: &[f64]) -> Option<Vec<u32>> {
    let accessor = Accessor::of(document, i, "/extras").ok()?;
    if 3 * accessor.count != positions.len() || accessor.components != 2 {
        return None;
    }
    let halves = accessor.floats().ok()?;
    let order: Vec<u32> = halves.chunks_exact(2).map(|c| (c[0] + 65536.0 * c[1]) as u32).collect();
    let at = |v: usize| &positions[3 * v..3 * v + 3];
    let is_copy = |(v, &of): (usize, &u32)| {
        let of = of as usize;
        of <= v && order[of] as usize == of && at(of) == at(v)
    };
    order.iter().enumerate().all(is_copy).then_some(order)
}
