//! Quads as text of Universal Scene Description.

use std::collections::BTreeSet;
use std::fmt::Display;

use glam::DVec3;

use super::text_writer::{push, push_line};
use crate::engine::attributes::QuadAttributes;
use crate::engine::quad::QuadMesh;

/// One `Mesh` without subdivision. The schema knows points as `point3f` only, and importers look for nothing else; the
/// text holds all digits all the same, so that a reader in double precision finds the same numbers.
///
/// Colours are `displayColor`, texture coordinates `st` per corner; materials are subsets of the faces bound to prims
/// that hold nothing but the name.
pub(super) fn write(mesh: &QuadMesh, attributes: &QuadAttributes) -> Vec<u8> {
    let mut out = Vec::with_capacity(64 * mesh.positions.len() + 32 * mesh.quads.len() + 512);
    out.extend_from_slice(
        b"#usda 1.0\n(\n    defaultPrim = \"quads\"\n    upAxis = \"Y\"\n)\n\ndef Mesh \"quads\"\n{\n",
    );
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &p in &mesh.positions {
        low = low.min(p);
        high = high.max(p);
    }
    if !mesh.positions.is_empty() {
        push_line(
            &mut out,
            format_args!("    float3[] extent = [{}, {}]", Tuple(low.to_array()), Tuple(high.to_array())),
        );
    }
    push_list(&mut out, "int[] faceVertexCounts", mesh.quads.iter().map(|_| "4"));
    push_list(&mut out, "int[] faceVertexIndices", mesh.quads.iter().flatten());
    push_list(&mut out, "point3f[] points", mesh.positions.iter().map(|&p| Tuple(p.to_array())));
    push_primvars(&mut out, attributes);
    out.extend_from_slice(b"    uniform token subdivisionScheme = \"none\"\n");
    push_materials(&mut out, attributes);
    out.extend_from_slice(b"}\n");
    out
}

fn push_primvars(out: &mut Vec<u8>, attributes: &QuadAttributes) {
    if !attributes.colours.is_empty() {
        let colours = attributes.colours.iter();
        push_primvar(out, "color3f[] primvars:displayColor", "vertex", colours.map(|&[r, g, b, _]| Tuple([r, g, b])));
        if attributes.colours.iter().any(|&[.., alpha]| alpha < 1.0) {
            let alphas = attributes.colours.iter().map(|[.., alpha]| alpha);
            push_primvar(out, "float[] primvars:displayOpacity", "vertex", alphas);
        }
    }
    if !attributes.uv.is_empty() {
        let corners = attributes.uv.iter().flatten().map(|&[u, v]| Tuple([u, v]));
        push_primvar(out, "texCoord2f[] primvars:st", "faceVarying", corners);
    }
}

fn push_primvar<T: Display>(out: &mut Vec<u8>, name: &str, interpolation: &str, items: impl Iterator<Item = T>) {
    push_list(out, name, items);
    // Metadata stands behind the list.
    out.pop();
    push_line(out, format_args!(" (\n        interpolation = \"{interpolation}\"\n    )"));
}

/// A subset of the faces per material, in the order of the materials; quads without a material are in none.
fn push_materials(out: &mut Vec<u8>, attributes: &QuadAttributes) {
    let mut quads: Vec<Vec<usize>> = vec![Vec::new(); attributes.material_names.len()];
    for (q, &material) in attributes.materials.iter().enumerate() {
        quads[material as usize].push(q);
    }
    let mut taken = BTreeSet::from(["materials".to_owned()]);
    let identifiers: Vec<String> = attributes.material_names.iter().map(|name| identifier(name, &mut taken)).collect();
    let named =
        || attributes.material_names.iter().zip(&identifiers).zip(&quads).filter(|((name, _), _)| !name.is_empty());
    if named().next().is_none() {
        return;
    }
    out.extend_from_slice(b"    uniform token subsetFamily:materialBind:familyType = \"nonOverlapping\"\n");
    for ((_, identifier), quads) in named() {
        push_line(out, format_args!("\n    def GeomSubset \"{identifier}\" ("));
        push_line(out, format_args!("        prepend apiSchemas = [\"MaterialBindingAPI\"]\n    )\n    {{"));
        push_line(out, format_args!("        uniform token elementType = \"face\""));
        push_line(out, format_args!("        uniform token familyName = \"materialBind\""));
        out.extend_from_slice(b"    ");
        push_list(out, "int[] indices", quads.iter());
        push_line(out, format_args!("        rel material:binding = </quads/materials/{identifier}>\n    }}"));
    }
    out.extend_from_slice(b"\n    def Scope \"materials\"\n    {\n");
    for ((name, identifier), _) in named() {
        push_line(out, format_args!("        def Material \"{identifier}\" ("));
        push_line(out, format_args!("            customData = {{"));
        push_line(out, format_args!("                string name = \"{}\"", escaped(name)));
        push_line(out, format_args!("            }}\n        )\n        {{\n        }}"));
    }
    out.extend_from_slice(b"    }\n");
}

/// A name that prims may have and none has yet.
fn identifier(name: &str, taken: &mut BTreeSet<String>) -> String {
    let mut plain: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if !plain.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') {
        plain.insert(0, '_');
    }
    let numbered = (2..).map(|n| format!("{plain}_{n}"));
    let free = std::iter::once(plain.clone()).chain(numbered).find(|name| !taken.contains(name));
    let free = free.unwrap_or(plain);
    taken.insert(free.clone());
    free
}

/// The inside of a string on one line.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '"' | '\\' => escaped.extend(['\\', c]),
            c if c.is_control() => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

/// A tuple as USD writes it.
struct Tuple<T, const N: usize>([T; N]);

impl<T: Display, const N: usize> Display for Tuple<T, N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (i, x) in self.0.iter().enumerate() {
            write!(f, "{}{x}", if i == 0 { "(" } else { ", " })?;
        }
        write!(f, ")")
    }
}

fn push_list<T: Display>(out: &mut Vec<u8>, name: &str, items: impl Iterator<Item = T>) {
    push(out, format_args!("    {name} = ["));
    for (i, item) in items.enumerate() {
        push(out, format_args!("{}{item}", if i == 0 { "" } else { ", " }));
    }
    out.extend_from_slice(b"]\n");
}
