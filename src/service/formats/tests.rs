//! Tests across formats: damaged files, and real ones.

use std::path::{Path, PathBuf};

use proptest::prelude::*;
use serde_json::json;

use super::map::tests::with_square;
use super::quads::tests::cube;
use super::*;
use crate::engine::attributes::QuadAttributes;
use crate::engine::mesh::TriangleSoup;

/// Valid files of every format that is read, small.
fn samples() -> Vec<(Format, Vec<u8>)> {
    let mesh = cube(2);
    let obj = write_quads(&mesh, &QuadAttributes::default(), QuadFormat::Obj);
    let mut stl = vec![b' '; 80];
    stl.extend(2u32.to_le_bytes());
    stl.extend((0..24u32).flat_map(|i| (i as f32).to_le_bytes()).chain([0; 4]));
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    zip.start_file("mesh.obj", zip::write::SimpleFileOptions::default()).unwrap();
    std::io::Write::write_all(&mut zip, &obj).unwrap();
    let glb = write_quads(&mesh, &QuadAttributes::default(), QuadFormat::Glb);
    let encoded = ::meshopt::encode_vertex_buffer(&[[0f32; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).unwrap();
    let n = encoded.len();
    let data = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, encoded);
    let compressed = json!({"buffer": 0, "byteLength": n, "byteStride": 12, "count": 3, "mode": "ATTRIBUTES"});
    let meshopt = json!({
        "asset": {"version": "2.0"},
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36, "extensions": {"EXT_meshopt_compression": compressed}}],
        "buffers": [{"byteLength": n, "uri": format!("data:;base64,{data}")}],
    });
    let png = "data:image/png;base64,iVBORw0KGgo=";
    let textured = json!({
        "asset": {"version": "2.0"},
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "accessors": [{"count": 3, "componentType": 5126, "type": "VEC3"}],
        "materials": [{"normalTexture": {"index": 0, "scale": 2.0}, "extensions": {"KHR_materials_clearcoat":
            {"clearcoatTexture": {"index": 1, "extensions": {"KHR_texture_transform": {"rotation": 1}}}}}}],
        "textures": [{"source": 0, "sampler": 0}, {"extensions": {"EXT_texture_webp": {"source": 1}}}],
        "samplers": [{"wrapS": 33071}], "images": [{"uri": png}, {"bufferView": 0}],
        "bufferViews": [{"buffer": 0, "byteLength": 12}],
        "buffers": [{"byteLength": 12, "uri": "data:;base64,UklGRgQAAABXRUJQ"}],
    });
    let (painted, attributes) = super::attribute_tests::painted();
    let (mesh_of_rig, rig, scene) = super::attribute_tests::rigged();
    vec![
        (Format::Glb, write_model(&mesh_of_rig, &rig, &scene, QuadFormat::Glb)),
        (Format::Obj, write_quads(&painted, &attributes, QuadFormat::Obj)),
        (Format::Glb, write_quads(&painted, &attributes, QuadFormat::Glb)),
        (Format::Obj, obj),
        (Format::Glb, glb),
        (Format::Gltf, meshopt.to_string().into_bytes()),
        (Format::Gltf, textured.to_string().into_bytes()),
        (Format::Glb, with_square(|map| write_map(map, MapFormat::Glb))),
        (Format::Obj, with_square(|map| write_map(map, MapFormat::Obj))),
        (Format::Ply, write_quads(&mesh, &QuadAttributes::default(), QuadFormat::Ply)),
        (Format::Ply, b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n".to_vec()),
        (Format::Stl, stl),
        (Format::Stl, b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n".to_vec()),
        (Format::Zip, zip.finish().unwrap().into_inner()),
    ]
}

/// What every reader promises of a soup.
fn assert_sound(soup: &TriangleSoup) {
    let n = soup.positions.len() as u32;
    assert!(soup.indices.iter().all(|&v| v < n));
    assert!(soup.n_polygons() > 0);
    assert!(soup.polygon_ends.windows(2).all(|pair| pair[0] < pair[1]));
    assert_eq!(soup.polygon_ends.last().map(|&end| end as usize), Some(soup.indices.len()));
    assert!(soup.colours.is_empty() || soup.colours.len() == soup.positions.len());
    assert!(soup.colours.iter().flatten().all(|c| (0.0..=1.0).contains(c)));
    assert!(soup.uv.is_empty() || soup.uv.len() == soup.indices.len());
    assert!(soup.uv.iter().flatten().all(|c| c.is_finite()));
    assert!(soup.skin.is_empty() || soup.skin.len() == soup.positions.len());
    assert!(soup.objects.is_empty() || soup.objects.len() == soup.n_polygons());
    assert!(soup.materials.is_empty() || soup.materials.len() == soup.n_polygons());
    assert!(soup.materials.iter().all(|&m| (m as usize) < soup.material_names.len()));
}

/// Small limits, so that a lucky count does not make the test slow.
fn small() -> ReadLimits {
    ReadLimits { max_vertices: 10_000, max_polygons: 10_000, max_bytes_unpacked: 1 << 20 }
}

fn read_all_ways(bytes: &[u8], format: Format) {
    for format in [Some(format), None] {
        if let Ok(soup) = read_soup(bytes, format, &small()) {
            assert_sound(&soup);
        }
    }
}

#[test]
fn samples_are_read_with_and_without_their_format() {
    for (format, bytes) in samples() {
        let soup = read_soup(&bytes, Some(format), &small()).unwrap_or_else(|error| panic!("{format:?}: {error}"));
        assert_sound(&soup);
        assert_eq!(read_soup(&bytes, None, &small()).as_ref(), Ok(&soup), "{format:?}");
    }
    assert_eq!(read_soup(b"", None, &small()), Err(ReadError::UnknownFormat));
    assert_eq!(read_soup(&[0x89, 1, 2, 3, 0xff], None, &small()), Err(ReadError::UnknownFormat));
}

#[test]
fn every_truncation_ends_in_a_result() {
    for (format, bytes) in samples() {
        for end in 0..bytes.len() {
            read_all_ways(&bytes[..end], format);
        }
        assert!(read_soup(&[], Some(format), &small()).is_err());
    }
    let usda = write_quads(&cube(1), &QuadAttributes::default(), QuadFormat::Usda);
    for end in 0..usda.len() - 3 {
        assert!(read_quads(&usda[..end], QuadFormat::Usda).is_err(), "{end}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn noise_ends_in_a_result(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        for (format, magic) in [
            (Format::Obj, b"f ".as_slice()), (Format::Glb, b"glTF\x02\0\0\0"), (Format::Gltf, b"{"),
            (Format::Ply, b"ply\nformat binary_little_endian 1.0\n"), (Format::Stl, b"solid "), (Format::Zip, b"PK\x03\x04"),
        ] {
            read_all_ways(&bytes, format);
            read_all_ways(&[magic, &bytes].concat(), format);
        }
        let _ = read_quads(&[b"#usda ", bytes.as_slice()].concat(), QuadFormat::Usda);
    }

    #[test]
    fn damage_ends_in_a_result(
        edits in proptest::collection::vec((any::<u16>(), any::<u8>(), 0..4u8), 1..6),
        end in any::<u16>(),
    ) {
        let usda = (None, write_quads(&cube(1), &QuadAttributes::default(), QuadFormat::Usda));
        for (format, mut bytes) in samples().into_iter().map(|(f, b)| (Some(f), b)).chain([usda]) {
            for &(at, value, kind) in &edits {
                let at = at as usize % bytes.len();
                match kind {
                    0 => bytes[at] = value,
                    1 => bytes[at] ^= 1 << (value % 8),
                    2 => bytes.insert(at, value),
                    _ => bytes[at] = b"0123456789-.e[]{}\",/\n \xff"[value as usize % 23],
                }
            }
            bytes.truncate(bytes.len() - (end as usize % bytes.len()) / 8);
            match format {
                Some(format) => read_all_ways(&bytes, format),
                None => drop(read_quads(&bytes, QuadFormat::Usda)),
            }
        }
    }
}

/// The shared models beside the project, where there are any.
fn models(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/meshes").join(folder);
    let Ok(entries) = std::fs::read_dir(&folder) else {
        eprintln!("skipped: there are no models in {}", folder.display());
        return Vec::new();
    };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    paths
}

fn extension(path: &Path) -> &str {
    path.extension().and_then(|extension| extension.to_str()).unwrap_or_default()
}

#[test]
fn real_obj_files_are_read_completely() {
    for path in models("").into_iter().chain(models("messy")).filter(|path| extension(path) == "obj") {
        let bytes = std::fs::read(&path).unwrap();
        let soup = read_soup(&bytes, Some(Format::Obj), &ReadLimits::default()).unwrap();
        assert_sound(&soup);
        let starts = |word: &[u8]| bytes.split(|&b| b == b'\n').filter(|line| line.starts_with(word)).count();
        assert_eq!((soup.positions.len(), soup.n_polygons()), (starts(b"v "), starts(b"f ")), "{}", path.display());
        assert_eq!(Format::sniff(&bytes), Some(Format::Obj));
    }
}

#[test]
fn real_gltf_files_are_read_or_refused_by_name() {
    // Vertices and triangles as the manifest counts them; a strip of four corners is two triangles. Nodes may show a
    // mesh several times, hence "at least".
    let manifest = models("gltf").into_iter().find(|path| extension(path) == "csv");
    let manifest = manifest.map(|path| std::fs::read_to_string(path).unwrap());
    for line in manifest.unwrap_or_default().lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let (name, triangles) = (fields[0], fields[6].parse::<usize>().unwrap());
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/meshes/gltf");
        let path = root.join(name);
        let bytes = std::fs::read(&path).unwrap();
        let bytes = match name.rsplit_once('/') {
            Some((folder, _)) => zipped(&root.join(folder)),
            None => bytes,
        };
        let result = read_soup(&bytes, None, &ReadLimits::default());
        let soup = result.unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_sound(&soup);
        eprintln!("{name}: {} vertices, {} polygons", soup.positions.len(), soup.n_polygons());
        assert!(soup.n_polygons() >= triangles, "{name}");
    }
}

fn zipped(folder: &Path) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let name = entry.file_name().into_string().unwrap();
        zip.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        std::io::Write::write_all(&mut zip, &std::fs::read(entry.path()).unwrap()).unwrap();
    }
    zip.finish().unwrap().into_inner()
}
