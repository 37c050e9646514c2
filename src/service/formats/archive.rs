//! Zip archives: one mesh file with what lies beside it.

use std::io::{Cursor, Read, Seek, Write};
use std::sync::{Mutex, PoisonError};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use super::beside::Beside;
use super::error::ReadError;
use super::format::Format;
use super::soup_builder::{ReadLimits, within};

const ZIP: &str = "zip";
/// Real meshes shrink to a tenth, rarely to a hundredth.
const HIGHEST_RATIO: u64 = 500;
/// What may be unpacked whatever it shrank to.
const HARMLESS_SIZE: u64 = 16 << 20;
/// Far more than a mesh needs beside it.
const MAX_ENTRIES: u64 = 10_000;

type Archive<'a> = ZipArchive<Cursor<&'a [u8]>>;

/// The one mesh in an archive, unpacked.
pub(super) struct Unpacked<'a> {
    pub(super) bytes: Vec<u8>,
    pub(super) format: Format,
    /// The other entries of its folder.
    pub(super) beside: Folder<'a>,
    /// What is left of the limits.
    pub(super) limits: ReadLimits,
}

/// Unpacks the one mesh in an archive.
///
/// # Errors
/// With the name of the entry.
pub(super) fn open<'a>(bytes: &'a [u8], limits: &ReadLimits) -> Result<Unpacked<'a>, ReadError> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| broken("archive", &error))?;
    let (index, name, format) = main_file(&mut archive)?;
    let bytes = unpack(&mut archive, index, limits.max_bytes_unpacked)?;
    let limits = ReadLimits { max_bytes_unpacked: limits.max_bytes_unpacked - bytes.len() as u64, ..*limits };
    let folder = name.rfind('/').map_or("", |slash| &name[..=slash]).to_owned();
    Ok(Unpacked { bytes, format, beside: Folder { archive: Mutex::new(archive), folder }, limits })
}

/// Packs files that belong together, as they are, into an archive from which they are read: how a mesh and what lies
/// beside it become one file. The same files in the same order give the same bytes.
///
/// # Errors
/// What reading and writing report, and names that no entry can have.
pub fn pack<'a, R: Read>(files: impl IntoIterator<Item = (&'a str, R)>, out: impl Write + Seek) -> std::io::Result<()> {
    let mut writer = ZipWriter::new(out);
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored).large_file(true);
    for (name, mut file) in files {
        writer.start_file(name, options)?;
        std::io::copy(&mut file, &mut writer)?;
    }
    writer.finish()?;
    Ok(())
}

/// Looks through all names; gives the one mesh file among them.
fn main_file(archive: &mut Archive<'_>) -> Result<(usize, String, Format), ReadError> {
    within("entries of an archive", archive.len() as u64, MAX_ENTRIES)?;
    let mut meshes = Vec::new();
    for i in 0..archive.len() {
        let entry = archive.by_index_raw(i).map_err(|error| broken("directory", &error))?;
        let raw = String::from_utf8_lossy(entry.name_raw()).into_owned();
        let place = || format!("entry {:?}", raw.chars().take(200).collect::<String>());
        if !is_inside(&raw) {
            return Err(ReadError::malformed(ZIP, place(), "the name leads out of the archive"));
        }
        if entry.is_symlink() {
            return Err(ReadError::malformed(ZIP, place(), "a symbolic link; send the file itself"));
        }
        let file = raw.rsplit('/').next().unwrap_or_default();
        // Finder's shadow files bear the endings of what they shadow.
        if entry.is_dir() || file.starts_with('.') || raw.starts_with("__MACOSX/") {
            continue;
        }
        let format = file.rsplit_once('.').and_then(|(_, ending)| Format::from_extension(ending));
        if let Some(format) = format.filter(|&format| format != Format::Zip) {
            if entry.encrypted() {
                return Err(ReadError::malformed(ZIP, place(), "encrypted; send it without a password"));
            }
            meshes.push((i, raw, format));
        }
    }
    let names = || meshes.iter().take(5).map(|(_, name, _)| name.as_str()).collect::<Vec<_>>().join(", ");
    match meshes.len() {
        1 => Ok(meshes.remove(0)),
        0 => Err(ReadError::malformed(ZIP, "archive", "it holds no OBJ, GLB, glTF, PLY or STL")),
        n => Err(ReadError::malformed(ZIP, "archive", format!("it holds {n} meshes ({}); send one", names()))),
    }
}

fn is_inside(name: &str) -> bool {
    let has_drive = name.as_bytes().get(1) == Some(&b':');
    let leaves = name.split(['/', '\\']).any(|part| part == "..");
    !(name.starts_with(['/', '\\']) || has_drive || leaves || name.contains('\0'))
}

/// Unpacks an entry. Its claimed size is judged first, and no more than that is ever read.
fn unpack(archive: &mut Archive<'_>, index: usize, limit: u64) -> Result<Vec<u8>, ReadError> {
    let entry = archive.by_index(index).map_err(|error| broken("entry", &error))?;
    let place = format!("entry {:?}", String::from_utf8_lossy(entry.name_raw()));
    let (size, packed) = (entry.size(), entry.compressed_size());
    within("bytes unpacked", size, limit)?;
    within("bytes unpacked from so few", size, packed.saturating_mul(HIGHEST_RATIO).max(HARMLESS_SIZE))?;
    let mut bytes = Vec::new();
    entry
        .take(size + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| ReadError::malformed(ZIP, &*place, error.to_string()))?;
    if bytes.len() as u64 == size {
        Ok(bytes)
    } else {
        Err(ReadError::malformed(ZIP, place, format!("it says {size} bytes and does not unpack to them")))
    }
}

fn broken(place: &str, error: &zip::result::ZipError) -> ReadError {
    ReadError::malformed(ZIP, place, error.to_string())
}

/// The files beside the main one.
#[derive(Debug)]
pub(super) struct Folder<'a> {
    archive: Mutex<Archive<'a>>,
    folder: String,
}

impl Beside for Folder<'_> {
    fn get(&self, path: &str, limit: u64) -> Result<Option<Vec<u8>>, ReadError> {
        let mut archive = self.archive.lock().unwrap_or_else(PoisonError::into_inner);
        // Who sends files one by one often loses their folders.
        let file = path.rsplit('/').next().unwrap_or_default();
        let mut places = [path, file].into_iter().map(|path| format!("{}{path}", self.folder));
        let index = places.find_map(|place| archive.index_for_name(&place));
        index.map(|index| unpack(&mut archive, index, limit)).transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::super::beside::Alone;
    use super::super::read::read_model;
    use super::*;
    use crate::engine::mesh::TriangleSoup;

    const TRIANGLE: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

    fn archive(entries: &[(&str, &[u8])]) -> Vec<u8> {
        let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
        for (name, bytes) in entries {
            writer.start_file(*name, SimpleFileOptions::default()).unwrap();
            writer.write_all(bytes).unwrap();
        }
        writer.finish().unwrap().into_inner()
    }

    fn read_all(bytes: &[u8]) -> Result<TriangleSoup, ReadError> {
        read_within(bytes, &ReadLimits::default())
    }

    fn read_within(bytes: &[u8], limits: &ReadLimits) -> Result<TriangleSoup, ReadError> {
        read_model(bytes, Some(Format::Zip), &Alone, limits).map(|model| model.soup)
    }

    fn with_buffer(uri: &str) -> String {
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}}],
            "bufferViews": [{{"buffer": 0, "byteLength": 36}}], "buffers": [{{"uri": "{uri}", "byteLength": 36}}]}}"#
        )
    }

    #[test]
    fn one_mesh_among_other_files() {
        let soup = read_all(&archive(&[("read.me", b"x"), ("a/b.OBJ", TRIANGLE), ("__MACOSX/a/._b.OBJ", b"\0")]));
        assert_eq!(soup.unwrap().n_polygons(), 1);
        let bin: Vec<u8> =
            [0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
        let text = with_buffer("data/my%20mesh.bin");
        let soup = read_all(&archive(&[("m/x.gltf", text.as_bytes()), ("m/data/my mesh.bin", &bin)]));
        assert_eq!(soup.unwrap().n_polygons(), 1);
        // Not beside the glTF.
        let error = read_all(&archive(&[("m/x.gltf", text.as_bytes()), ("data/my mesh.bin", &bin)])).unwrap_err();
        assert_eq!(error, ReadError::MissingBuffer { uri: "data/my%20mesh.bin".to_owned() });
        let out = with_buffer("../x.bin");
        let error = read_all(&archive(&[("m/x.gltf", out.as_bytes()), ("x.bin", &bin)])).unwrap_err();
        assert_eq!(error, ReadError::MissingBuffer { uri: "../x.bin".to_owned() });
    }

    #[test]
    fn packed_files_are_found_beside_their_mesh() {
        let bin = [0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].map(f32::to_le_bytes).concat();
        let text = with_buffer("data/mesh.bin");
        let packed = |name: &str| {
            let mut out = Cursor::new(Vec::new());
            pack([(name, bin.as_slice()), ("x.gltf", text.as_bytes())], &mut out).unwrap();
            out.into_inner()
        };
        for name in ["mesh.bin", "data/mesh.bin"] {
            assert_eq!(read_all(&packed(name)).unwrap().n_polygons(), 1, "{name}");
            assert_eq!(packed(name), packed(name));
        }
        assert!(matches!(read_all(&packed("other/mesh.bin")), Err(ReadError::MissingBuffer { .. })));
    }

    #[test]
    fn names_that_lead_out_are_refused() {
        for name in ["../x.obj", "a/../../x.obj", "/x.obj", "C:/x.obj", "a\\..\\x.obj", "\\x.obj", "a/../x.obj"] {
            // The writer would mend such names: patch them in.
            let honest = "n".repeat(name.len());
            let mut bytes = archive(&[("mesh.obj", TRIANGLE), (&honest, b"y")]);
            for at in 0..bytes.len() - name.len() {
                if bytes[at..].starts_with(honest.as_bytes()) {
                    bytes[at..at + name.len()].copy_from_slice(name.as_bytes());
                }
            }
            let error = read_all(&bytes).unwrap_err().to_string();
            assert!(error.contains("leads out of the archive"), "{name}: {error}");
        }
    }

    #[test]
    fn symbolic_links_are_refused() {
        let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
        writer.start_file("mesh.obj", SimpleFileOptions::default()).unwrap();
        writer.write_all(TRIANGLE).unwrap();
        writer.add_symlink("link.bin", "/etc/hostname", SimpleFileOptions::default()).unwrap();
        let error = read_all(&writer.finish().unwrap().into_inner()).unwrap_err().to_string();
        assert!(error.contains("symbolic link"), "{error}");
    }

    #[test]
    fn bombs_are_refused_by_their_size_and_their_ratio() {
        let zeros = vec![0; 20 << 20];
        let bomb = archive(&[("x.stl", &zeros)]);
        assert!(bomb.len() < 100_000);
        assert!(matches!(read_all(&bomb), Err(ReadError::TooLarge { claimed: 20_971_520, .. })));
        let few = ReadLimits { max_bytes_unpacked: 20, ..ReadLimits::default() };
        let error = read_within(&archive(&[("x.obj", TRIANGLE)]), &few).unwrap_err();
        assert_eq!(error, ReadError::TooLarge { what: "bytes unpacked", claimed: 32, limit: 20 });
    }

    #[test]
    fn archives_without_one_mesh_are_refused() {
        let fault = |bytes: &[u8]| read_all(bytes).unwrap_err().to_string();
        assert!(fault(&archive(&[("x.txt", b"x")])).contains("holds no OBJ"));
        assert!(fault(&archive(&[("x.obj", TRIANGLE), ("y.obj", TRIANGLE)])).contains("2 meshes (x.obj, y.obj)"));
        assert!(fault(&archive(&[("x.zip", &archive(&[("x.obj", TRIANGLE)]))])).contains("holds no OBJ"));
        let whole = archive(&[("x.obj", TRIANGLE)]);
        for end in 0..whole.len() {
            assert!(read_all(&whole[..end]).is_err());
        }
    }
}
