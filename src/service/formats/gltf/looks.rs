//! Reading what materials look like: their values, and the textures and images that they refer to.
//!
//! A look is worth less than a shape: what is wrong with it is left out with a warning, and only what is too large is an
//! error.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::{Map, Value};

use super::super::error::ReadError;
use super::super::looks::{Encoding, Image, Look, Looks, Texture};
use super::super::soup_builder::within;
use super::document::Document;
use super::fault::{GLTF, malformed};
use super::material::{self, TEXTURE_TRANSFORM};
use crate::engine::run::{Warning, WarningKind};

/// Images of more bytes than this would leave no room for the quads in the 4 GiB that a GLB can have.
const MOST_BYTES: u64 = 2 << 30;
/// Warnings that are listed one by one.
const MOST_WARNINGS: usize = 10;

/// The lists of a glTF that make up the looks of materials.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Lists {
    materials: Vec<Value>,
    textures: Vec<Value>,
    images: Vec<Value>,
    samplers: Vec<Value>,
}

/// Reads the looks of materials; `numbers` holds the index of each in the file, none for those that nothing has or that
/// are none. What is left behind is added to the warnings.
///
/// # Errors
/// If the images are too large.
pub(super) fn read(
    document: &Document<'_>,
    numbers: &[Option<usize>],
    warnings: &mut Vec<Warning>,
) -> Result<Looks, ReadError> {
    if numbers.iter().all(Option::is_none) {
        return Ok(Looks::default());
    }
    let lists: Lists = serde_json::from_slice(document.json).map_err(|error| malformed("JSON", error.to_string()))?;
    let looks = Looks { required: required(document), ..Looks::default() };
    let mut reader = Reader {
        document,
        lists: &lists,
        textures: BTreeMap::new(),
        images: BTreeMap::new(),
        bytes: 0,
        looks,
        lost: Vec::new(),
    };
    for number in numbers {
        let look = match number.and_then(|i| Some((i, lists.materials.get(i)?))) {
            Some((i, json)) => Some(reader.look(i, json)?),
            None => None,
        };
        reader.looks.materials.push(look);
    }
    let more = reader.lost.len().saturating_sub(MOST_WARNINGS);
    let more = (more > 0).then(|| format!("{more} more textures are not carried to the quads"));
    let lost = reader.lost.into_iter().take(MOST_WARNINGS).chain(more);
    warnings.extend(lost.map(|what| Warning::from(WarningKind::AttributesLost { what })));
    Ok(reader.looks)
}

/// The extensions of materials that the file requires.
fn required(document: &Document<'_>) -> Vec<String> {
    let names = document.root.extensions_required.iter();
    names.filter(|name| material::is_extension(name) || *name == TEXTURE_TRANSFORM).cloned().collect()
}

struct Reader<'a> {
    document: &'a Document<'a>,
    lists: &'a Lists,
    /// Number of each texture of the file that was asked for, or why there is none.
    textures: BTreeMap<usize, Result<usize, String>>,
    images: BTreeMap<usize, Result<usize, String>>,
    /// Of all images.
    bytes: u64,
    looks: Looks,
    /// What is left behind, and why.
    lost: Vec<String>,
}

impl Reader<'_> {
    fn look(&mut self, index: usize, material: &Value) -> Result<Look, ReadError> {
        let mut look = Look { json: material::carried(material) };
        let mut too_large = None;
        look.retain_textures(&mut |reference| {
            if too_large.is_some() {
                return false;
            }
            match self.reference(reference) {
                Ok(Ok(renumbered)) => {
                    *reference = renumbered;
                    true
                }
                Ok(Err(why)) => {
                    let name = material::name(material).unwrap_or_else(|| format!("number {index}"));
                    self.lost.push(format!("a texture of the material {name:?} is not carried to the quads: {why}"));
                    false
                }
                Err(error) => {
                    too_large = Some(error);
                    false
                }
            }
        });
        too_large.map_or(Ok(look), Err)
    }

    /// A reference to a texture with its number among those that are carried, or why it is not.
    fn reference(&mut self, json: &Map<String, Value>) -> Result<Result<Map<String, Value>, String>, ReadError> {
        let Some(reference) = material::reference(json) else { return Ok(Err("it has no index".to_owned())) };
        if reference.set > 0 {
            return Ok(Err(format!("it needs texture coordinates {}; only those of set 0 are carried", reference.set)));
        }
        let texture = match self.textures.get(&reference.index) {
            Some(known) => known.clone(),
            None => {
                let texture = self.texture(reference.index)?;
                self.textures.entry(reference.index).or_insert(texture).clone()
            }
        };
        Ok(texture.map(|number| {
            let mut made = Map::from_iter([("index".to_owned(), number.into())]);
            made.extend(reference.json);
            made
        }))
    }

    fn texture(&mut self, index: usize) -> Result<Result<usize, String>, ReadError> {
        let lists = self.lists;
        let Some(json) = lists.textures.get(index) else { return Ok(Err(format!("there is no texture {index}"))) };
        let of_extension = |encoding: Encoding| json.pointer(&format!("/extensions/{}/source", encoding.extension()?));
        let sources = [json.get("source"), of_extension(Encoding::WebP), of_extension(Encoding::Ktx2)];
        let mut images: Vec<usize> = Vec::new();
        let mut why = "it has no image".to_owned();
        for source in sources.into_iter().flatten() {
            let Some(source) = source.as_u64().and_then(|i| usize::try_from(i).ok()) else { continue };
            let image = match self.images.get(&source) {
                Some(known) => known.clone(),
                None => {
                    let image = self.image(source)?;
                    self.images.entry(source).or_insert(image).clone()
                }
            };
            let extension = |image: usize| self.looks.images[image].encoding.extension();
            match image {
                Ok(image) if images.iter().all(|&other| extension(other) != extension(image)) => images.push(image),
                Ok(_) => {}
                Err(cause) => why = cause,
            }
        }
        if images.is_empty() {
            return Ok(Err(why));
        }
        let sampler =
            json.get("sampler").and_then(Value::as_u64).and_then(|i| lists.samplers.get(usize::try_from(i).ok()?));
        let sampler = sampler.map(material::sampler).unwrap_or_default();
        self.looks.textures.push(Texture { name: material::name(json), sampler, images });
        Ok(Ok(self.looks.textures.len() - 1))
    }

    fn image(&mut self, index: usize) -> Result<Result<usize, String>, ReadError> {
        let Some(json) = self.lists.images.get(index) else { return Ok(Err(format!("there is no image {index}"))) };
        let bytes = match self.bytes_of(json, &format!("/images/{index}")) {
            Err(error @ ReadError::TooLarge { .. }) => return Err(error),
            Err(error) => return Ok(Err(error.to_string())),
            Ok(bytes) => bytes,
        };
        let Some(encoding) = Encoding::of(&bytes) else {
            return Ok(Err(format!("image {index} is neither PNG, JPEG, WebP nor KTX2")));
        };
        self.bytes = self.bytes.saturating_add(bytes.len() as u64);
        within("bytes of images", self.bytes, MOST_BYTES)?;
        self.looks.images.push(Image { name: material::name(json), encoding, bytes });
        Ok(Ok(self.looks.images.len() - 1))
    }

    /// The bytes of an image, which count as unpacked: many images may be the same bytes of a file.
    fn bytes_of(&self, json: &Value, place: &str) -> Result<Vec<u8>, ReadError> {
        if let Some(uri) = json.get("uri").and_then(Value::as_str) {
            return self.document.load(uri, place);
        }
        let view = json.get("bufferView").and_then(Value::as_u64).and_then(|i| usize::try_from(i).ok());
        let view = view.ok_or_else(|| ReadError::malformed(GLTF, place, "an image without bytes"))?;
        let bytes = self.document.view(view, place)?.bytes;
        self.document.unpack(bytes.len() as u64)?;
        Ok(bytes.to_vec())
    }
}
