//! Quads as binary glTF.

use serde_json::json;

use super::corner_values::CornerValues;
use super::glb_file::{File, asset, push_positions};
use super::model::Scene;
use super::{glb_container, glb_looks, glb_skin, ngon};
use crate::engine::attributes::QuadAttributes;
use crate::engine::quad::QuadMesh;

/// More objects than this are one: many programs copy all vertices for each.
pub(super) const MOST_OBJECTS: usize = 1000;

/// What a node is called where the input does not say it.
const NO_NAME: &str = "quads";

/// Triangles with `FB_ngon_encoding`. Positions are rounded to single precision, the only one glTF knows; vertices stay
/// apart even where they round to the same point.
///
/// Where vertices have copies for the sake of normals and texture coordinates, the primitives' attribute `_VERTEX` holds the low
/// and the high half of the index of the vertex itself; the extras of `FB_ngon_encoding` name its accessor.
///
/// Every object is a node with a mesh of one primitive per material; all primitives share the accessors of the vertices.
/// Nodes of meshes have no transform, so that with a skeleton, which moves vertices from where they are, they may be
/// roots of the scene as they should.
pub(super) fn write(mesh: &QuadMesh, attributes: &QuadAttributes, scene: &Scene) -> Vec<u8> {
    if mesh.quads.is_empty() {
        // glTF knows no empty mesh.
        return glb_container::write(&json!({"asset": asset()}), Vec::new());
    }
    let split = split_vertices(mesh, attributes);
    let copies = split.as_ref().map_or(&[][..], |split| split.copies(mesh));
    let vertices = || (0..mesh.positions.len()).chain(copies.iter().map(|&v| v as usize));
    let (n, m) = (mesh.positions.len() + copies.len(), mesh.quads.len());
    let mut file = File { bin: Vec::with_capacity(12 * n + 24 * m), views: Vec::new(), accessors: Vec::new() };

    let bounds = push_positions(&mut file.bin, vertices().map(|v| mesh.positions[v]));
    let view = file.view(0, Some(34962));
    file.accessor(json!({
        "bufferView": view, "componentType": 5126, "count": n, "type": "VEC3", "min": bounds[0], "max": bounds[1],
    }));
    let names = scene.names(&attributes.objects);
    let names = if names.len() > MOST_OBJECTS { &[] } else { names };
    let groups = push_indices(&mut file, mesh, attributes, !names.is_empty(), split.as_ref());

    let mut shared = json!({"POSITION": 0});
    if !attributes.colours.is_empty() {
        let colours = vertices().flat_map(|v| attributes.colours[v]);
        shared["COLOR_0"] = file.floats(colours, n, "VEC4").into();
    }
    let values = || split.iter().flat_map(|split| &split.values);
    if !attributes.normals.is_empty() {
        // Normals have a length, also those of vertices without quads.
        let normal = |&[x, y, z, ..]: &[f32; 5]| if [x, y, z] == [0.0; 3] { [0.0, 0.0, 1.0] } else { [x, y, z] };
        shared["NORMAL"] = file.floats(values().flat_map(normal), n, "VEC3").into();
    }
    if !attributes.uv.is_empty() {
        // glTF counts v downwards from 1.
        shared["TEXCOORD_0"] = file.floats(values().flat_map(|&[.., u, v]| [u, 1.0 - v]), n, "VEC2").into();
    }
    let n_joints = scene.skeleton.joints.len();
    let is_skinned = !attributes.skin.is_empty() && n_joints > 0;
    if is_skinned {
        let influences = vertices().map(|v| attributes.skin[v]);
        let [joints, weights] = glb_skin::push_influences(&mut file, influences, n, n_joints);
        shared["JOINTS_0"] = joints.into();
        shared["WEIGHTS_0"] = weights.into();
    }
    let mut ngon = json!({});
    if let Some(split) = split.as_ref().filter(|_| !copies.is_empty()) {
        let start = file.bin.len();
        file.bin.extend(split.vertex.iter().flat_map(|v| v.to_le_bytes()));
        let view = file.view(start, Some(34962));
        let accessor = file.accessor(json!({"bufferView": view, "componentType": 5123, "count": n, "type": "VEC2"}));
        shared["_VERTEX"] = accessor.into();
        ngon = json!({"extras": {"vertices": accessor}});
    }
    let looks = glb_looks::push(&mut file, attributes, &scene.looks);
    let primitive = |group: &Group| {
        let mut primitive = json!({
            "attributes": shared, "indices": group.indices, "mode": 4, "extensions": {"FB_ngon_encoding": ngon},
        });
        if let Some(number) = group.material.and_then(|m| looks.numbers[m as usize]) {
            primitive["material"] = number.into();
        }
        primitive
    };
    let (mut nodes, mut meshes) = (Vec::new(), Vec::new());
    for groups in groups.chunk_by(|a, b| a.object == b.object) {
        let names = names.get(groups[0].object as usize);
        let name = |name: &str, otherwise: &str| if name.is_empty() { otherwise.to_owned() } else { name.to_owned() };
        let node = name(names.map_or("", |names| &names.node), NO_NAME);
        let mesh = name(names.map_or("", |names| &names.mesh), &node);
        nodes.push(json!({"mesh": meshes.len(), "name": node}));
        meshes.push(json!({"name": mesh, "primitives": groups.iter().map(primitive).collect::<Vec<_>>()}));
    }
    let mut roots: Vec<usize> = (0..nodes.len()).collect();
    let mut skins = Vec::new();
    if is_skinned {
        nodes.iter_mut().for_each(|node| node["skin"] = 0.into());
        let skeleton = glb_skin::push_skeleton(&mut file, &scene.skeleton, nodes.len());
        nodes.extend(skeleton.nodes);
        roots.extend(skeleton.roots);
        skins.push(skeleton.skin);
    }
    let mut json = json!({
        "asset": asset(),
        "extensionsUsed": ["FB_ngon_encoding"],
        "scene": 0,
        "scenes": [{"nodes": roots}],
        "nodes": nodes,
        "meshes": meshes,
        "accessors": file.accessors,
        "bufferViews": file.views,
        "buffers": [{"byteLength": file.bin.len()}],
    });
    looks.add_to(&mut json);
    if !skins.is_empty() {
        json["skins"] = skins.into();
    }
    glb_container::write(&json, file.bin)
}

/// The vertices, split where normals or texture coordinates differ: both as one value per corner, so that a vertex has as few
/// copies as may be, with zeros for what there is not. `None` if there is neither.
fn split_vertices(mesh: &QuadMesh, attributes: &QuadAttributes) -> Option<CornerValues<5>> {
    let QuadAttributes { normals, uv, .. } = attributes;
    if normals.is_empty() && uv.is_empty() {
        return None;
    }
    let of_quad = |q: usize| {
        let (normals, uv) = (normals.get(q).copied().unwrap_or_default(), uv.get(q).copied().unwrap_or_default());
        std::array::from_fn(|k| [normals[k][0], normals[k][1], normals[k][2], uv[k][0], uv[k][1]])
    };
    Some(CornerValues::of(mesh, (0..mesh.quads.len()).map(of_quad)))
}

/// Quads of one object and material.
struct Group {
    object: u32,
    material: Option<u32>,
    /// Number of the accessor of their indices.
    indices: usize,
}

/// Appends the triangles of all quads, object after object and in each material after material.
fn push_indices(
    file: &mut File,
    mesh: &QuadMesh,
    attributes: &QuadAttributes,
    by_object: bool,
    split: Option<&CornerValues<5>>,
) -> Vec<Group> {
    let start = file.bin.len();
    let object = |q: usize| attributes.objects.get(q).copied().filter(|_| by_object).unwrap_or(0);
    let key = |q: usize| (object(q), attributes.materials.get(q).copied());
    let mut order: Vec<usize> = (0..mesh.quads.len()).collect();
    order.sort_by_key(|&q| key(q));
    // Which quads follow each other decides where they may start.
    let first = if order.is_sorted() {
        ngon::first_corners(mesh)
    } else {
        let quads = order.iter().map(|&q| mesh.quads[q]).collect();
        ngon::first_corners(&QuadMesh { positions: mesh.positions.clone(), quads })
    };
    for (&q, first) in order.iter().zip(first) {
        let quad = split.map_or(mesh.quads[q], |split| split.corners[q]);
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| quad[(first as usize + k) % 4].to_le_bytes());
        for index in [a, b, c, a, c, d] {
            file.bin.extend_from_slice(&index);
        }
    }
    let view = file.view(start, Some(34963));
    let mut before = 0;
    let groups = order.chunk_by(|&q, &r| key(q) == key(r)).map(|group| {
        let mut accessor = json!({"bufferView": view});
        if before > 0 {
            accessor["byteOffset"] = (24 * before).into();
        }
        before += group.len();
        accessor["componentType"] = 5125.into();
        accessor["count"] = (6 * group.len()).into();
        accessor["type"] = "SCALAR".into();
        let (object, material) = key(group[0]);
        Group { object, material, indices: file.accessor(accessor) }
    });
    groups.collect()
}

#[cfg(test)]
mod tests {
    use super::super::format::QuadFormat;
    use super::super::quads::tests::cube;
    use super::super::{read_quads, write_quads};
    use super::*;

    #[test]
    fn quads_come_back_but_for_their_first_corner() {
        let mesh = cube(4);
        let back =
            read_quads(&write_quads(&mesh, &QuadAttributes::default(), QuadFormat::Glb), QuadFormat::Glb).unwrap();
        let rounded: Vec<_> = mesh.positions.iter().map(|p| p.as_vec3().as_dvec3()).collect();
        assert_eq!(back.positions, rounded);
        // Near 12345 single precision has steps of a thousandth: no two vertices may have become one.
        assert_eq!(back.quads.len(), mesh.quads.len());
        for (a, b) in mesh.quads.iter().zip(&back.quads) {
            let turned = (0..4).map(|k| [0, 1, 2, 3].map(|i| a[(i + k) % 4]));
            assert!(turned.into_iter().any(|turned| turned == *b));
        }
    }

    #[test]
    fn no_quads_are_a_valid_file() {
        let bytes = write(&QuadMesh::default(), &QuadAttributes::default(), &Scene::default());
        let error = read_quads(&bytes, QuadFormat::Glb).unwrap_err().to_string();
        assert!(error.contains("no polygons"), "{error}");
    }
}
