//! The file formats by name, file ending, media type and first bytes.

use super::obj;

/// Formats that meshes are read from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Wavefront OBJ.
    Obj,
    /// Binary glTF 2.0.
    Glb,
    /// glTF 2.0 as JSON, with its buffers in data URIs or beside it.
    Gltf,
    /// Polygon file format, ASCII or binary.
    Ply,
    /// Stereolithography, ASCII or binary.
    Stl,
    /// A zip archive of one mesh file and what lies beside it.
    Zip,
}

impl Format {
    /// The format of a file with this ending, without its dot, in any case.
    pub fn from_extension(extension: &str) -> Option<Self> {
        match extension.to_ascii_lowercase().as_str() {
            "obj" => Some(Self::Obj),
            "glb" | "vrm" => Some(Self::Glb),
            "gltf" => Some(Self::Gltf),
            "ply" => Some(Self::Ply),
            "stl" => Some(Self::Stl),
            "zip" => Some(Self::Zip),
            _ => None,
        }
    }

    /// The format that the first bytes tell of. OBJ has no signature: it is text with an OBJ statement near its start.
    pub fn sniff(bytes: &[u8]) -> Option<Self> {
        if bytes.starts_with(b"glTF") {
            return Some(Self::Glb);
        }
        if bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"PK\x05\x06") {
            return Some(Self::Zip);
        }
        if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
            return Some(Self::Ply);
        }
        if super::stl::claims_binary_length(bytes) {
            return Some(Self::Stl);
        }
        let head = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
        if head.starts_with(b"{") {
            return Some(Self::Gltf);
        }
        if head.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) {
            return Some(Self::Stl);
        }
        obj::looks_like(head).then_some(Self::Obj)
    }

    /// The name in messages and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Obj => "OBJ",
            Self::Glb => "GLB",
            Self::Gltf => "glTF",
            Self::Ply => "PLY",
            Self::Stl => "STL",
            Self::Zip => "zip",
        }
    }

    /// The registered media type.
    pub fn media_type(self) -> &'static str {
        match self {
            Self::Obj => "model/obj",
            Self::Glb => "model/gltf-binary",
            Self::Gltf => "model/gltf+json",
            Self::Ply => "application/ply",
            Self::Stl => "model/stl",
            Self::Zip => "application/zip",
        }
    }
}

/// Formats that quads are written to and read back from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuadFormat {
    /// Wavefront OBJ, with the fewest digits that re-read to the same number.
    Obj,
    /// Binary glTF: triangles with `FB_ngon_encoding`, single precision.
    Glb,
    /// Binary PLY, in the precision that the positions need.
    Ply,
    /// Universal Scene Description as text.
    Usda,
}

impl QuadFormat {
    /// All formats of quads.
    pub const ALL: [Self; 4] = [Self::Obj, Self::Glb, Self::Ply, Self::Usda];

    /// The format of a file with this ending, without its dot, in any case.
    pub fn from_extension(extension: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.extension().eq_ignore_ascii_case(extension))
    }

    /// The file ending, without its dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Glb => "glb",
            Self::Ply => "ply",
            Self::Usda => "usda",
        }
    }

    /// The media type of downloads.
    pub fn media_type(self) -> &'static str {
        match self {
            Self::Obj => "model/obj",
            Self::Glb => "model/gltf-binary",
            Self::Ply => "application/ply",
            Self::Usda => "model/vnd.usda",
        }
    }
}

/// Formats that parameterisations are written to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapFormat {
    /// Wavefront OBJ with one `vt` per corner.
    Obj,
    /// Binary glTF with TEXCOORD_0 per corner.
    Glb,
    /// JSON with transitions, cut edges and singularities.
    Json,
}

impl MapFormat {
    /// All formats of parameterisations.
    pub const ALL: [Self; 3] = [Self::Obj, Self::Glb, Self::Json];

    /// The format of a file with this ending, without its dot, in any case.
    pub fn from_extension(extension: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.extension().eq_ignore_ascii_case(extension))
    }

    /// The file ending, without its dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Glb => "glb",
            Self::Json => "json",
        }
    }

    /// The media type of downloads.
    pub fn media_type(self) -> &'static str {
        match self {
            Self::Obj => "model/obj",
            Self::Glb => "model/gltf-binary",
            Self::Json => "application/json",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_told_by_their_first_bytes() {
        let mut solid_binary = [b"solid but binary".as_slice(), &[0; 64], &1u32.to_le_bytes(), &[0; 50]].concat();
        assert_eq!(solid_binary.len(), 134);
        assert_eq!(Format::sniff(&solid_binary), Some(Format::Stl));
        solid_binary[..5].copy_from_slice(b"\x01\x02\x03\x04\x05");
        for (bytes, format) in [
            (b"glTF\x02\0\0\0".as_slice(), Some(Format::Glb)),
            (b"PK\x03\x04", Some(Format::Zip)),
            (b"ply\r\nformat ascii 1.0", Some(Format::Ply)),
            (b" \n{\"asset\":{}}", Some(Format::Gltf)),
            (b"solid x\nfacet normal", Some(Format::Stl)),
            (&solid_binary, Some(Format::Stl)),
            (b"# a comment\n\nv 0 0 0\n", Some(Format::Obj)),
            (b"mtllib a.mtl\r\no thing", Some(Format::Obj)),
            (b"", None),
            (b"\x89PNG\r\n\x1a\n", None),
            (b"hello world", None),
        ] {
            assert_eq!(Format::sniff(bytes), format, "{}", String::from_utf8_lossy(bytes));
        }
    }

    #[test]
    fn endings_lead_back_to_their_format() {
        for format in QuadFormat::ALL {
            assert_eq!(QuadFormat::from_extension(&format.extension().to_uppercase()), Some(format));
        }
        for format in MapFormat::ALL {
            assert_eq!(MapFormat::from_extension(format.extension()), Some(format));
        }
        assert_eq!(Format::from_extension("STL"), Some(Format::Stl));
        assert_eq!(Format::from_extension("fbx"), None);
    }
}
