//! Quads as text of Universal Scene Description.

use std::collections::BTreeSet;
use std::fmt::Display;

use glam::DVec3;

use super::model::{ObjectName, Scene};
use super::precision::{Precision, Shortest};
use super::quads_glb::MOST_OBJECTS;
use super::text_writer::{push, push_line};
use super::usda::VERTICES;
use crate::engine::attributes::QuadAttributes;
use crate::engine::quad::QuadMesh;

/// What a mesh is called where the input does not say it.
const NO_NAME: &str = "mesh";

/// Model units are metres and Y is up, as glTF has it; the other formats that are read say neither. Without these lines
/// importers take centimetres.
const HEADER: &[u8] = b"#usda 1.0\n(\n    defaultPrim = \"quads\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n\n\
    def Xform \"quads\"\n{\n";

/// One `Mesh` without subdivision per object. The schema knows points as `point3f` only, and importers look for nothing
/// else; where the positions need more digits the text holds them all the same, so that a reader in double precision finds
/// the same numbers.
///
/// Colours are `displayColor`, texture coordinates `st` and `normals` per corner; materials are subsets of the faces bound to prims
/// that hold nothing but the name. Vertices belong to one mesh each in this format: those of quads of several objects are
/// in each, and an attribute says which vertex of the whole a point is.
pub(super) fn write(mesh: &QuadMesh, attributes: &QuadAttributes, scene: &Scene) -> Vec<u8> {
    let mut out = Vec::with_capacity(64 * mesh.positions.len() + 32 * mesh.quads.len() + 512);
    out.extend_from_slice(HEADER);
    let precision = Precision::of(&mesh.positions);
    let (names, parts) = parts(mesh, attributes, scene);
    let is_in_order = parts.iter().flat_map(|part| &part.vertices).copied().eq(0..mesh.positions.len() as u32);
    let materials = Materials::of(attributes);
    let mut taken = BTreeSet::from([MATERIALS.to_owned()]);
    for (i, part) in parts.iter().enumerate() {
        let name = names.get(part.object as usize).map_or("", |name| &name.node);
        let identifier = identifier(if name.is_empty() { NO_NAME } else { name }, &mut taken);
        if i > 0 {
            out.push(b'\n');
        }
        push(&mut out, format_args!("    def Mesh \"{identifier}\""));
        if !name.is_empty() && *name != identifier {
            push(&mut out, format_args!(" (\n        displayName = \"{}\"\n    )", escaped(name)));
        }
        out.extend_from_slice(b"\n    {\n");
        push_shape(&mut out, mesh, part, precision);
        if !is_in_order {
            push_list(&mut out, &format!("custom int[] {VERTICES}"), part.vertices.iter());
        }
        push_primvars(&mut out, attributes, part);
        out.extend_from_slice(b"        uniform token subdivisionScheme = \"none\"\n");
        materials.push_subsets(&mut out, attributes, part);
        out.extend_from_slice(b"    }\n");
    }
    materials.push(&mut out);
    out.extend_from_slice(b"}\n");
    out
}

/// The quads of one object.
struct Part {
    object: u32,
    /// Their numbers.
    quads: Vec<u32>,
    /// The vertices at their corners, in order; in the first part also those without quads.
    vertices: Vec<u32>,
    /// Per corner of each quad its number in `vertices`.
    corners: Vec<[u32; 4]>,
}

/// The objects in the order of their numbers, and their names; all quads are one where the names are not known or too many.
fn parts<'a>(mesh: &QuadMesh, attributes: &QuadAttributes, scene: &'a Scene) -> (&'a [ObjectName], Vec<Part>) {
    let names = scene.names(&attributes.objects);
    let names = if names.len() > MOST_OBJECTS { &[] } else { names };
    let object = |q: u32| attributes.objects.get(q as usize).copied().filter(|_| !names.is_empty()).unwrap_or(0);
    let mut order: Vec<u32> = (0..mesh.quads.len() as u32).collect();
    order.sort_by_key(|&q| object(q));
    let mut number = vec![u32::MAX; mesh.positions.len()];
    let mut without_quads = vec![true; mesh.positions.len()];
    mesh.quads.iter().flatten().for_each(|&v| without_quads[v as usize] = false);
    let mut alone: Vec<u32> = (0..).zip(&without_quads).filter_map(|(v, &alone)| alone.then_some(v)).collect();
    let mut parts = Vec::new();
    for quads in order.chunk_by(|&q, &r| object(q) == object(r)) {
        let corners = quads.iter().flat_map(|&q| mesh.quads[q as usize]);
        let mut vertices: Vec<u32> = corners.chain(std::mem::take(&mut alone)).collect();
        vertices.sort_unstable();
        vertices.dedup();
        (0..).zip(&vertices).for_each(|(i, &v)| number[v as usize] = i);
        let corners = quads.iter().map(|&q| mesh.quads[q as usize].map(|v| number[v as usize])).collect();
        parts.push(Part { object: object(quads[0]), quads: quads.to_vec(), vertices, corners });
    }
    (names, parts)
}

fn push_shape(out: &mut Vec<u8>, mesh: &QuadMesh, part: &Part, precision: Precision) {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let points = || part.vertices.iter().map(|&v| mesh.positions[v as usize]);
    for p in points() {
        low = low.min(p);
        high = high.max(p);
    }
    let tuple = |p: DVec3| Tuple(precision.shown_all(p));
    push_line(out, format_args!("        float3[] extent = [{}, {}]", tuple(low), tuple(high)));
    push_list(out, "int[] faceVertexCounts", part.quads.iter().map(|_| "4"));
    push_list(out, "int[] faceVertexIndices", part.corners.iter().flatten());
    push_list(out, "point3f[] points", points().map(tuple));
}

fn push_primvars(out: &mut Vec<u8>, attributes: &QuadAttributes, part: &Part) {
    if !attributes.colours.is_empty() {
        let colours = || part.vertices.iter().map(|&v| attributes.colours[v as usize]);
        let rgb = colours().map(|[r, g, b, _]| Tuple([r, g, b].map(Shortest)));
        push_primvar(out, "color3f[] primvars:displayColor", "vertex", rgb);
        if colours().any(|[.., alpha]| alpha < 1.0) {
            let alphas = colours().map(|[.., alpha]| Shortest(alpha));
            push_primvar(out, "float[] primvars:displayOpacity", "vertex", alphas);
        }
    }
    if !attributes.normals.is_empty() {
        let corners = part.quads.iter().flat_map(|&q| attributes.normals[q as usize]);
        let corners = corners.map(|normal| Tuple(normal.map(Shortest)));
        push_primvar(out, "normal3f[] normals", "faceVarying", corners);
    }
    if !attributes.uv.is_empty() {
        let corners = part.quads.iter().flat_map(|&q| attributes.uv[q as usize]);
        let corners = corners.map(|uv| Tuple(uv.map(Shortest)));
        push_primvar(out, "texCoord2f[] primvars:st", "faceVarying", corners);
    }
}

fn push_primvar<T: Display>(out: &mut Vec<u8>, name: &str, interpolation: &str, items: impl Iterator<Item = T>) {
    push_list(out, name, items);
    // Metadata stands behind the list.
    out.pop();
    push_line(out, format_args!(" (\n            interpolation = \"{interpolation}\"\n        )"));
}

/// Where the materials are.
const MATERIALS: &str = "materials";

/// The named materials, with the names of their prims.
struct Materials<'a>(Vec<Option<(&'a str, String)>>);

impl<'a> Materials<'a> {
    fn of(attributes: &'a QuadAttributes) -> Self {
        let mut taken = BTreeSet::new();
        let named = |name: &'a String| (!name.is_empty()).then(|| (name.as_str(), identifier(name, &mut taken)));
        Self(attributes.material_names.iter().map(named).collect())
    }

    /// A subset of the faces per material, in the order of the materials; quads without a material are in none.
    fn push_subsets(&self, out: &mut Vec<u8>, attributes: &QuadAttributes, part: &Part) {
        let mut faces: Vec<Vec<usize>> = vec![Vec::new(); self.0.len()];
        for (face, &q) in part.quads.iter().enumerate() {
            if let Some(&material) = attributes.materials.get(q as usize) {
                faces[material as usize].push(face);
            }
        }
        let used = || self.0.iter().zip(&faces).filter(|(_, faces)| !faces.is_empty());
        let mut used = used().filter_map(|(material, faces)| Some((material.as_ref()?, faces))).peekable();
        if used.peek().is_some() {
            out.extend_from_slice(b"        uniform token subsetFamily:materialBind:familyType = \"nonOverlapping\"\n");
        }
        for ((_, identifier), faces) in used {
            push_line(out, format_args!("\n        def GeomSubset \"{identifier}\" ("));
            push_line(
                out,
                format_args!("            prepend apiSchemas = [\"MaterialBindingAPI\"]\n        )\n        {{"),
            );
            push_line(out, format_args!("            uniform token elementType = \"face\""));
            push_line(out, format_args!("            uniform token familyName = \"materialBind\""));
            out.extend_from_slice(b"    ");
            push_list(out, "int[] indices", faces.iter());
            let target = format!("</quads/{MATERIALS}/{identifier}>");
            push_line(out, format_args!("            rel material:binding = {target}\n        }}"));
        }
    }

    /// The prims of the materials themselves.
    fn push(&self, out: &mut Vec<u8>) {
        if self.0.iter().all(Option::is_none) {
            return;
        }
        push_line(out, format_args!("\n    def Scope \"{MATERIALS}\"\n    {{"));
        for (name, identifier) in self.0.iter().flatten() {
            push_line(out, format_args!("        def Material \"{identifier}\" ("));
            push_line(out, format_args!("            customData = {{"));
            push_line(out, format_args!("                string name = \"{}\"", escaped(name)));
            push_line(out, format_args!("            }}\n        )\n        {{\n        }}"));
        }
        out.extend_from_slice(b"    }\n");
    }
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
    push(out, format_args!("        {name} = ["));
    for (i, item) in items.enumerate() {
        push(out, format_args!("{}{item}", if i == 0 { "" } else { ", " }));
    }
    out.extend_from_slice(b"]\n");
}
