//! Compressed glTF: read as it was, and damaged without a panic, a hang or a heap of memory. `tests/soak/draco` is the
//! long form.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use draco_core::{
    DataType, EncoderBuffer, EncoderOptions, FaceIndex, GeometryAttributeType, Mesh, MeshEncoder, PointAttribute,
};
use quadrille::engine::mesh::TriangleSoup;
use quadrille::service::formats::{Format, ReadError, ReadLimits, read_soup};
use serde_json::json;

use crate::meshes::{glb, surface};

/// From the densest coding to the fastest: both ways of coding triangles, and all ways of foretelling values.
const SPEEDS: [i32; 5] = [0, 2, 4, 7, 10];
const NAMES: [(GeometryAttributeType, &str, u8); 4] = [
    (GeometryAttributeType::Position, "POSITION", 3),
    (GeometryAttributeType::TexCoord, "TEXCOORD_0", 2),
    (GeometryAttributeType::Normal, "NORMAL", 3),
    (GeometryAttributeType::Color, "COLOR_0", 4),
];
/// Mutated files in the gate and in the long form.
const CASES: [u64; 2] = [400, 20_000];
/// Longest that one small file may take, on a busy machine.
const PATIENCE: Duration = Duration::from_secs(10);

fn limits() -> ReadLimits {
    ReadLimits { max_vertices: 100_000, max_polygons: 100_000, max_bytes_unpacked: 16 << 20 }
}

/// A surface as a Draco stream with as many attributes.
fn stream(soup: &TriangleSoup, attributes: usize, speed: i32) -> Vec<u8> {
    let mut mesh = Mesh::new();
    for &(kind, _, components) in &NAMES[..attributes] {
        let mut attribute = PointAttribute::new();
        attribute.init(kind, components, DataType::Float32, false, soup.positions.len());
        for (i, p) in soup.positions.iter().enumerate() {
            let p = [p.x as f32, p.y as f32, p.z as f32, 1.0];
            for (c, x) in p[..usize::from(components)].iter().enumerate() {
                attribute.buffer_mut().write(4 * (usize::from(components) * i + c), &x.to_le_bytes());
            }
        }
        mesh.add_attribute(attribute);
    }
    mesh.set_num_faces(soup.n_polygons());
    for (f, polygon) in soup.polygons().enumerate() {
        mesh.set_face(FaceIndex(f as u32), [polygon[0].into(), polygon[1].into(), polygon[2].into()]);
    }
    let mut options = EncoderOptions::new();
    options.set_global_int("encoding_speed", speed);
    options.set_global_int("decoding_speed", speed);
    (0..attributes as i32).for_each(|id| options.set_attribute_int(id, "quantization_bits", 14));
    let (mut encoder, mut out) = (MeshEncoder::new(), EncoderBuffer::new());
    encoder.set_mesh(mesh);
    encoder.encode(&options, &mut out).expect("an encoded mesh");
    out.data().to_vec()
}

/// A GLB whose only primitive is this stream.
fn file(stream: &[u8], attributes: usize) -> Vec<u8> {
    let ids: serde_json::Map<_, _> =
        (0..).zip(&NAMES[..attributes]).map(|(id, a)| (a.1.to_owned(), json!(id))).collect();
    let extension = json!({"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": ids}});
    let document = json!({
        "asset": {"version": "2.0"}, "extensionsRequired": ["KHR_draco_mesh_compression"],
        "meshes": [{"primitives": [{"attributes": {}, "extensions": extension}]}],
        "bufferViews": [{"buffer": 0, "byteLength": stream.len()}], "buffers": [{"byteLength": stream.len()}],
    });
    glb(&document, stream)
}

fn streams() -> Vec<(TriangleSoup, usize, Vec<u8>)> {
    let shapes = [("torus", 400), ("half_pipe", 300), ("cube", 100)].map(|(name, n)| surface(name, n));
    let each = shapes.iter().flat_map(|soup| SPEEDS.map(|speed| (soup, speed)));
    let each = each.flat_map(|(soup, speed)| [1, NAMES.len()].map(|attributes| (soup, speed, attributes)));
    each.map(|(soup, speed, attributes)| (soup.clone(), attributes, stream(soup, attributes, speed))).collect()
}

#[test]
fn compressed_meshes_are_read() {
    for (soup, attributes, stream) in streams() {
        let read = read_soup(&file(&stream, attributes), Some(Format::Glb), &limits()).unwrap();
        assert_eq!(read.n_polygons(), soup.n_polygons());
        assert_eq!((read.uv.is_empty(), read.colours.is_empty()), (attributes == 1, attributes == 1));
        let near = |p: &glam::DVec3| soup.positions.iter().any(|q| p.distance(*q) < 1e-3);
        assert!(read.positions.iter().all(near), "quantisation moved a vertex");
    }
}

/// Numbers that look drawn by chance.
struct Draw(u64);

impl Draw {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % n as u64) as usize
    }
}

/// The stream after a few accidents, half of them near its start, where its counts are.
fn damaged(stream: &[u8], other: &[u8], draw: &mut Draw) -> Vec<u8> {
    const WORDS: [&[u8]; 6] = [&[0xff; 4], &[0; 4], &[0xff, 0xff, 0xff, 0x7f], &[0x80; 5], &[0xff, 0x0f], &[1]];
    let mut bytes = stream.to_vec();
    for _ in 0..[1, 1, 2, 4, 8][draw.below(5)] {
        let range = if draw.below(2) == 0 { bytes.len().min(40) } else { bytes.len() };
        let at = draw.below(range.max(1)).min(bytes.len());
        let length = bytes.len();
        let end = |n: usize| (at + n).min(length);
        match draw.below(7) {
            0 => bytes[at..end(1)].fill(draw.below(256) as u8),
            1 => bytes[at..end(1)].iter_mut().for_each(|b| *b ^= 1 << draw.below(8)),
            2 => drop(bytes.splice(at..at, WORDS[draw.below(6)].iter().copied())),
            3 => drop(bytes.drain(at..end([1, 4, 50][draw.below(3)]))),
            4 => {
                let word = WORDS[draw.below(6)];
                drop(bytes.splice(at..end(word.len()), word.iter().copied()));
            }
            5 => {
                let from = draw.below(other.len());
                bytes.splice(at..end(30), other[from..(from + 30).min(other.len())].iter().copied());
            }
            _ => bytes.truncate(at.max(11)),
        }
    }
    bytes
}

/// Peak of the resident memory in MiB, where the system says it.
fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib >> 10)
}

#[test]
fn damaged_streams_end_in_a_result() {
    let is_long = std::env::var_os("QUADRILLE_SOAK").is_some();
    let seed = std::env::var("QUADRILLE_SEED").map_or(1, |seed| seed.parse().expect("a whole number"));
    let (streams, mut draw, before) = (streams(), Draw(seed), peak());
    let (mut read, mut refused, mut slowest, mut panics) = (0, 0, Duration::ZERO, Vec::new());
    for case in 0..CASES[usize::from(is_long)] {
        let (_, attributes, stream) = &streams[draw.below(streams.len())];
        let bytes = file(&damaged(stream, &streams[draw.below(streams.len())].2, &mut draw), *attributes);
        let start = Instant::now();
        match catch_unwind(AssertUnwindSafe(|| read_soup(&bytes, Some(Format::Glb), &limits()))) {
            Ok(Ok(soup)) => {
                assert!(soup.indices.iter().all(|&v| (v as usize) < soup.positions.len()), "case {case}");
                read += 1;
            }
            Ok(Err(ReadError::UnsupportedExtension { name })) => panic!("{name} is not read"),
            Ok(Err(_)) => refused += 1,
            Err(_) => panics.push(case),
        }
        slowest = slowest.max(start.elapsed());
        assert!(slowest < PATIENCE, "case {case} of QUADRILLE_SEED={seed} took {slowest:?}");
    }
    println!("{read} read, {refused} refused, slowest {slowest:?}, memory from {before:?} to {:?} MiB", peak());
    assert!(panics.is_empty(), "panics in {} cases of QUADRILLE_SEED={seed}: {panics:?}", panics.len());
    assert!(read > 0 && refused > 0, "{read} read, {refused} refused");
    // Alone in its process the test knows whose memory it is.
    if let (true, Some(before), Some(after)) = (is_long, before, peak()) {
        assert!(after < before + 256, "memory grew from {before} to {after} MiB");
    }
}
