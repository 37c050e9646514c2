//! What materials look like, in the terms of glTF: factors, textures, images.

use serde_json::{Map, Value};

/// The looks of the materials of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Looks {
    /// Per material of the soup its look; none, or no list at all, where the file has no more than a name.
    pub materials: Vec<Option<Look>>,
    /// The textures of the looks.
    pub textures: Vec<Texture>,
    /// The images of the textures.
    pub images: Vec<Image>,
    /// Extensions of materials that the file requires.
    pub required: Vec<String>,
}

impl Looks {
    /// The look of a material of the soup.
    pub(super) fn of(&self, material: u32) -> Option<&Look> {
        self.materials.get(material as usize)?.as_ref()
    }
}

/// A material as in glTF. All its values are what glTF allows, and the indices of its textures are those of
/// [`Looks::textures`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Look {
    /// The material's JSON.
    pub(super) json: Map<String, Value>,
}

impl Look {
    /// Calls `keep` with every reference to a texture, and leaves out those that it does not want.
    pub(super) fn retain_textures(&mut self, keep: &mut dyn FnMut(&mut Map<String, Value>) -> bool) {
        retain_textures(&mut self.json, keep);
    }
}

fn retain_textures(json: &mut Map<String, Value>, keep: &mut dyn FnMut(&mut Map<String, Value>) -> bool) {
    json.retain(|key, value| match value {
        _ if key == "extras" => true,
        Value::Object(texture) if key.ends_with("Texture") => keep(texture),
        Value::Object(inside) => {
            retain_textures(inside, keep);
            true
        }
        _ => !key.ends_with("Texture"),
    });
}

/// An image and how it is sampled.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Texture {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// Filters and wrapping as in glTF; empty for what a viewer does without being told.
    pub(super) sampler: Map<String, Value>,
    /// Indices of the same picture in different encodings in [`Looks::images`]: at least one, and at most one that all
    /// viewers know and one for each extension.
    pub images: Vec<usize>,
}

/// An image, byte for byte as the file has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// How it is encoded.
    pub encoding: Encoding,
    /// The bytes.
    pub bytes: Vec<u8>,
}

/// How an image is encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Portable Network Graphics.
    Png,
    /// JPEG.
    Jpeg,
    /// WebP, of `EXT_texture_webp`.
    WebP,
    /// Khronos Texture 2.0, of `KHR_texture_basisu`.
    Ktx2,
}

impl Encoding {
    /// The encoding of an image by its first bytes; `None` for those that glTF does not know.
    pub(super) fn of(bytes: &[u8]) -> Option<Self> {
        match bytes {
            [0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1a, b'\n', ..] => Some(Self::Png),
            [0xff, 0xd8, 0xff, ..] => Some(Self::Jpeg),
            [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some(Self::WebP),
            [0xab, b'K', b'T', b'X', b' ', b'2', b'0', 0xbb, b'\r', b'\n', 0x1a, b'\n', ..] => Some(Self::Ktx2),
            _ => None,
        }
    }

    /// The registered media type.
    pub fn media_type(self) -> &'static str {
        match self {
            Self::Png => "image/png",
            Self::Jpeg => "image/jpeg",
            Self::WebP => "image/webp",
            Self::Ktx2 => "image/ktx2",
        }
    }

    /// The extension of textures that refers to such images; none for those that need none.
    pub(super) fn extension(self) -> Option<&'static str> {
        match self {
            Self::Png | Self::Jpeg => None,
            Self::WebP => Some("EXT_texture_webp"),
            Self::Ktx2 => Some("KHR_texture_basisu"),
        }
    }
}
