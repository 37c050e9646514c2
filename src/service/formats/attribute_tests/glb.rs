//! How GLB holds them: copies of vertices, and a primitive per material.

use super::*;

#[test]
fn copies_in_glb_go_back_to_their_own_vertices() {
    // Two cubes at the same place: which vertex a copy belongs to does not follow from where it is.
    let (one, painted) = painted();
    let n = one.positions.len() as u32;
    let mut two = one.clone();
    two.positions.extend(&one.positions);
    two.quads.extend(one.quads.iter().map(|quad| quad.map(|v| v + n)));
    let uv = painted.uv.iter().chain(&painted.uv).copied().collect();
    let bytes = write_quads(&two, &QuadAttributes { uv, ..QuadAttributes::default() }, QuadFormat::Glb);
    assert_same_quads(&read_quads(&bytes, QuadFormat::Glb).unwrap(), &two);

    // An order that cannot be is none: all vertices are read, and no more than that is wrong.
    let chunks = glb_container::open(&bytes).unwrap();
    let mut json: Value = serde_json::from_slice(chunks.json).unwrap();
    let count = json["accessors"][0]["count"].as_u64().unwrap() as usize;
    assert!(count > two.positions.len());
    json["meshes"][0]["primitives"][0]["extensions"]["FB_ngon_encoding"]["extras"]["vertices"] = 0.into();
    let damaged = glb_container::write(&json, chunks.bin.unwrap().to_vec());
    assert_eq!(read_quads(&damaged, QuadFormat::Glb).unwrap().positions.len(), count);
}

#[test]
fn every_primitive_names_its_material_and_starts_its_quads_apart() {
    let (mesh, attributes) = painted();
    let bytes = write_quads(&mesh, &attributes, QuadFormat::Glb);
    let chunks = glb_container::open(&bytes).unwrap();
    let json: Value = serde_json::from_slice(chunks.json).unwrap();
    let (bin, accessors) = (chunks.bin.unwrap(), json["accessors"].as_array().unwrap());
    let primitives = json["meshes"][0]["primitives"].as_array().unwrap();
    let names: Vec<_> =
        primitives.iter().map(|p| p["material"].as_u64().map(|m| &json["materials"][m as usize]["name"])).collect();
    assert_eq!(names, [Some(&"paint (old)".into()), None, Some(&"2nd".into()), Some(&"2nd ".into())]);
    let mut quads = 0;
    for primitive in primitives {
        let accessor = &accessors[primitive["indices"].as_u64().unwrap() as usize];
        let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let start = view["byteOffset"].as_u64().unwrap() + accessor["byteOffset"].as_u64().unwrap_or(0);
        let count = accessor["count"].as_u64().unwrap() as usize;
        let indices = bin[start as usize..][..4 * count].as_chunks::<4>().0;
        let anchors: Vec<u32> = indices.chunks(6).map(|quad| u32::from_le_bytes(quad[0])).collect();
        assert!(anchors.windows(2).all(|pair| pair[0] != pair[1]));
        quads += anchors.len();
        for attribute in primitive["attributes"].as_object().unwrap().values() {
            assert_eq!(accessors[attribute.as_u64().unwrap() as usize]["count"], accessors[0]["count"]);
        }
    }
    assert_eq!(quads, mesh.quads.len());
}
