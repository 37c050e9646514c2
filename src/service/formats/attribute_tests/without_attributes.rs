//! Files of quads without attributes, byte for byte.

use super::*;

#[test]
fn files_without_attributes_are_what_they_were() {
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.0, 1.0, 0.0]].map(glam::DVec3::from_array);
    let mesh = QuadMesh { positions: positions.to_vec(), quads: vec![[0, 1, 2, 3]] };
    let bytes = |format| write_quads(&mesh, &QuadAttributes::default(), format);
    let text = |format| String::from_utf8(bytes(format)).unwrap();
    assert_eq!(
        text(QuadFormat::Obj),
        "# quads by Quadrille\nv 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\no component_1\nf 1 2 3 4\n"
    );
    assert_eq!(
        text(QuadFormat::Usda),
        "#usda 1.0\n(\n    defaultPrim = \"quads\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n\n\
         def Xform \"quads\"\n{\n    def Mesh \"mesh\"\n    {\n        \
         float3[] extent = [(0, 0, 0), (1, 1, 0.5)]\n        int[] faceVertexCounts = [4]\n        \
         int[] faceVertexIndices = [0, 1, 2, 3]\n        \
         point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0.5), (0, 1, 0)]\n        \
         uniform token subdivisionScheme = \"none\"\n    }\n}\n"
    );
    let header = "ply\nformat binary_little_endian 1.0\ncomment quads by Quadrille\nelement vertex 4\nproperty float x\n\
                  property float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let ply = bytes(QuadFormat::Ply);
    assert!(ply.starts_with(header.as_bytes()));
    assert_eq!(ply.len(), header.len() + 4 * 12 + 17);
    let glb = bytes(QuadFormat::Glb);
    let chunks = glb_container::open(&glb).unwrap();
    assert_eq!(
        std::str::from_utf8(chunks.json).unwrap().trim_end(),
        concat!(
            r#"{"asset":{"version":"2.0","generator":"Quadrille "#,
            env!("CARGO_PKG_VERSION"),
            r#""},"extensionsUsed":["FB_ngon_encoding"],"scene":0,"scenes":[{"nodes":[0]}],"#,
            r#""nodes":[{"mesh":0,"name":"quads"}],"meshes":[{"name":"quads","primitives":[{"attributes":{"POSITION":0},"#,
            r#""indices":1,"mode":4,"extensions":{"FB_ngon_encoding":{}}}]}],"accessors":[{"bufferView":0,"#,
            r#""componentType":5126,"count":4,"type":"VEC3","min":[0.0,0.0,0.0],"max":[1.0,1.0,0.5]},{"bufferView":1,"#,
            r#""componentType":5125,"count":6,"type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteLength":48,"#,
            r#""target":34962},{"buffer":0,"byteOffset":48,"byteLength":24,"target":34963}],"buffers":[{"byteLength":72}]}"#
        )
    );
    assert_eq!(chunks.bin.map(<[u8]>::len), Some(72));
}
