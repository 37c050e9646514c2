//! Where the numbers come from: views, sparse and quantised accessors, data URIs.

use super::*;

#[test]
fn interleaved_and_sparse_accessors() {
    // Position and normal, 24 bytes apart, from byte 4 of the view.
    let bin = bytes!(f32: 9, 1, 2, 3, 0, 0, 1, 4, 5, 6, 0, 0, 1, 7, 8, 9);
    let interleaved = document(
        json!({"attributes": {"POSITION": 0}}),
        json!([{"bufferView": 0, "byteOffset": 4, "componentType": 5126, "count": 3, "type": "VEC3"}]),
        json!([{"buffer": 0, "byteLength": 64, "byteStride": 24}]),
        64,
    );
    let soup = read_glb((interleaved, bin)).unwrap();
    assert_eq!(soup.positions, [DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 6.0), DVec3::new(7.0, 8.0, 9.0)]);

    // Zeros but for elements 1 and 2.
    let bin = [bytes!(u16: 1, 2), bytes!(f32: 1, 0, 0, 0, 1, 0)].concat();
    let sparse = json!({
        "componentType": 5126, "count": 3, "type": "VEC3", "sparse": {
            "count": 2,
            "indices": {"bufferView": 0, "componentType": 5123},
            "values": {"bufferView": 1},
        },
    });
    let views = json!([{"buffer": 0, "byteLength": 4}, {"buffer": 0, "byteOffset": 4, "byteLength": 24}]);
    let sample = (document(json!({"attributes": {"POSITION": 0}}), json!([sparse]), views, 28), bin);
    assert_eq!(read_glb(sample.clone()).unwrap().positions, [DVec3::ZERO, DVec3::X, DVec3::Y]);
    let mut outside = sample.clone();
    outside.1[2] = 3;
    assert!(matches!(read_glb(outside), Err(ReadError::IndexOutOfRange { index: 3, count: 3, .. })));
    // Without a view nothing but the limit stands against a count.
    let huge = patched(sample, "/accessors/0/count", json!(4_000_000_000u64));
    assert!(matches!(read_glb(huge), Err(ReadError::TooLarge { .. })));
}

#[test]
fn quantised_positions() {
    let bin = bytes!(i16: -32768, 0, 0, 0, 32767, 0, 0, 0, 0, 16384, 0, 0);
    let sample = |kind: u32, normalised: bool| {
        let mut json = document(
            json!({"attributes": {"POSITION": 0}}),
            json!([{"bufferView": 0, "componentType": kind, "normalized": normalised, "count": 3, "type": "VEC3"}]),
            json!([{"buffer": 0, "byteLength": 24, "byteStride": 8}]),
            24,
        );
        json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        json["nodes"][0]["scale"] = json!([2, 2, 2]);
        read_glb((json, bin.clone())).unwrap().positions
    };
    assert_eq!(sample(5122, true), [-2.0 * DVec3::X, 2.0 * DVec3::X, DVec3::Y * 2.0 * (16384.0 / 32767.0)]);
    assert_eq!(sample(5122, false)[2], DVec3::Y * 32768.0);
    assert_eq!(sample(5123, false)[0], DVec3::X * 65536.0);
    assert_eq!(sample(5121, true)[0], DVec3::Y * 2.0 * (128.0 / 255.0));
    assert_eq!(sample(5120, true)[1], DVec3::new(-1.0 / 127.0, 1.0, 0.0) * 2.0);
}

#[test]
fn data_uris_and_text() {
    let (mut json, bin) = triangle();
    use base64::Engine;
    let data = base64::engine::general_purpose::STANDARD.encode(&bin);
    json["buffers"][0]["uri"] = json!(format!("data:application/octet-stream;base64,{data}"));
    let text = serde_json::to_vec_pretty(&json).unwrap();
    assert_eq!(read(&text, &Alone, &ReadLimits::default()).unwrap().soup.n_polygons(), 1);
    let few = ReadLimits { max_bytes_unpacked: 50, ..ReadLimits::default() };
    assert!(matches!(read(&text, &Alone, &few), Err(ReadError::TooLarge { what: "bytes unpacked", .. })));
}
