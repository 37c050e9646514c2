//! Quads as Wavefront OBJ.

use std::collections::BTreeMap;

use super::corner_values::CornerValues;
use super::model::Scene;
use super::precision::{Precision, Shortest};
use super::text_writer::{push, push_line};
use crate::engine::attributes::QuadAttributes;
use crate::engine::quad::QuadMesh;

/// What quads without a material get once others have one: OBJ knows no way back to none.
const NO_MATERIAL: &str = "default";

/// One object per component, called as the one of the input that its first quad belongs to. Materials are named only;
/// there is no material library.
pub(super) fn write(quads: &QuadMesh, attributes: &QuadAttributes, scene: &Scene) -> Vec<u8> {
    let mut out = Vec::with_capacity(60 * quads.positions.len() + 30 * quads.quads.len());
    out.extend_from_slice(b"# quads by Quadrille\n");
    let precision = Precision::of(&quads.positions);
    for (v, p) in quads.positions.iter().enumerate() {
        let [x, y, z] = precision.shown_all(*p);
        push(&mut out, format_args!("v {x} {y} {z}"));
        if let Some(&[r, g, b, _]) = attributes.colours.get(v) {
            push(&mut out, format_args!(" {} {} {}", Shortest(r), Shortest(g), Shortest(b)));
        }
        out.push(b'\n');
    }
    let uv = of_corners(quads, &attributes.uv);
    for &[u, v] in uv.iter().flat_map(|uv| &uv.values) {
        push_line(&mut out, format_args!("vt {} {}", Shortest(u), Shortest(v)));
    }
    let normals = of_corners(quads, &attributes.normals);
    for &[x, y, z] in normals.iter().flat_map(|normals| &normals.values) {
        push_line(&mut out, format_args!("vn {} {} {}", Shortest(x), Shortest(y), Shortest(z)));
    }
    let component = components(quads);
    let material = |q: u32| attributes.materials.get(q as usize).copied();
    let mut order: Vec<u32> = (0..quads.quads.len() as u32).collect();
    order.sort_by_key(|&q| (component[q as usize], material(q)));
    let names = material_names(attributes);
    let (mut current, mut current_material) = (None, None);
    let (objects, mut taken) = (scene.names(&attributes.objects), BTreeMap::new());
    for q in order {
        if current != Some(component[q as usize]) {
            current = Some(component[q as usize]);
            let object = attributes.objects.get(q as usize).copied().unwrap_or(0);
            let name = objects.get(object as usize).and_then(|name| written_name(&name.node));
            let name = name.unwrap_or_else(|| format!("component_{}", component[q as usize] + 1));
            push_line(&mut out, format_args!("o {}", unlike_others(name, &mut taken)));
        }
        if material(q) != current_material {
            current_material = material(q);
            let name = material(q).and_then(|m| names.get(m as usize)).map_or(NO_MATERIAL, String::as_str);
            push_line(&mut out, format_args!("usemtl {name}"));
        }
        out.push(b'f');
        for (k, v) in quads.quads[q as usize].into_iter().enumerate() {
            let of_corner = |corners: &[[u32; 4]]| u64::from(corners[q as usize][k]) + 1;
            let (vt, vn) =
                (uv.as_ref().map(|uv| of_corner(&uv.corners)), normals.as_ref().map(|n| of_corner(&n.corners)));
            let v = u64::from(v) + 1;
            match (vt, vn) {
                (None, None) => push(&mut out, format_args!(" {v}")),
                (Some(vt), None) => push(&mut out, format_args!(" {v}/{vt}")),
                (None, Some(vn)) => push(&mut out, format_args!(" {v}//{vn}")),
                (Some(vt), Some(vn)) => push(&mut out, format_args!(" {v}/{vt}/{vn}")),
            }
        }
        out.push(b'\n');
    }
    out
}

/// Values of corners with their numbers; `None` if there are none.
fn of_corners<const N: usize>(quads: &QuadMesh, values: &[[[f32; N]; 4]]) -> Option<CornerValues<N>> {
    (!values.is_empty()).then(|| CornerValues::of(quads, values.iter().copied()))
}

/// A name for each material; materials of the same name stay different.
fn material_names(attributes: &QuadAttributes) -> Vec<String> {
    let mut taken = BTreeMap::new();
    let name = |name: &String| {
        written_name(name).map_or_else(|| NO_MATERIAL.to_owned(), |name| unlike_others(name, &mut taken))
    };
    attributes.material_names.iter().map(name).collect()
}

/// A name on one line that is not continued on the next; `None` if nothing is left of it.
fn written_name(name: &str) -> Option<String> {
    let line: String = name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let line = line.trim().trim_end_matches('\\').trim_end();
    (!line.is_empty()).then(|| line.to_owned())
}

/// A name that nothing has yet: the second `arm` is `arm_2`. Per name, `taken` holds how often it was asked for.
fn unlike_others(name: String, taken: &mut BTreeMap<String, u32>) -> String {
    loop {
        let times = taken.entry(name.clone()).or_insert(0);
        *times += 1;
        if *times == 1 {
            return name;
        }
        let unlike = format!("{name}_{times}");
        if !taken.contains_key(&unlike) {
            taken.insert(unlike.clone(), 1);
            return unlike;
        }
    }
}

/// The component of each quad (joined by vertices), numbered in order of the first quad.
fn components(quads: &QuadMesh) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..quads.positions.len() as u32).collect();
    for quad in &quads.quads {
        let a = root(&mut parent, quad[0]);
        for &v in &quad[1..] {
            let b = root(&mut parent, v);
            parent[b as usize] = a;
        }
    }
    let mut number = vec![u32::MAX; parent.len()];
    let mut n = 0;
    let of_quad = quads.quads.iter().map(|quad| {
        let root = root(&mut parent, quad[0]) as usize;
        if number[root] == u32::MAX {
            number[root] = n;
            n += 1;
        }
        number[root]
    });
    of_quad.collect()
}

fn root(parent: &mut [u32], mut v: u32) -> u32 {
    while parent[v as usize] != v {
        parent[v as usize] = parent[parent[v as usize] as usize];
        v = parent[v as usize];
    }
    v
}
