//! The materials of a binary glTF that is written, with their textures and images.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Map, Value, json};

use super::glb_file::File;
use super::looks::{Look, Looks};
use crate::engine::attributes::QuadAttributes;

/// Materials as JSON.
#[derive(Debug, Default)]
pub(super) struct Written {
    materials: Vec<Value>,
    textures: Vec<Value>,
    samplers: Vec<Value>,
    images: Vec<Value>,
    used: BTreeSet<String>,
    required: BTreeSet<String>,
    /// Per material of the quads its number in the file; none for no material.
    pub(super) numbers: Vec<Option<usize>>,
}

/// Appends the images of all materials of the quads. Without texture coordinates materials have no textures; materials
/// of which only the name is known are matt: left to itself, glTF takes surfaces for polished metal.
pub(super) fn push(file: &mut File, attributes: &QuadAttributes, looks: &Looks) -> Written {
    let mut writer = Writer { file, looks, written: Written::default(), known: Known::default() };
    for (i, name) in attributes.material_names.iter().enumerate() {
        let look = attributes.material_numbers.get(i).and_then(|&m| looks.of(m));
        let material = match look {
            Some(look) => Some(writer.look(look, !attributes.uv.is_empty())),
            None if name.is_empty() => None,
            None => Some(json!({"name": name, "pbrMetallicRoughness": {"metallicFactor": 0.0}})),
        };
        let number = material.map(|material| push_to(&mut writer.written.materials, material));
        writer.written.numbers.push(number);
    }
    writer.written
}

impl Written {
    /// Adds the lists of materials, textures, samplers and images to a file, and the extensions that they need.
    pub(super) fn add_to(self, json: &mut Value) {
        let extend = |json: &mut Value, name: &str, items: Vec<Value>| {
            if !items.is_empty() {
                let known = json.get(name).and_then(Value::as_array).cloned().unwrap_or_default();
                json[name] = [known, items].concat().into();
            }
        };
        extend(json, "extensionsUsed", self.used.into_iter().map(Value::from).collect());
        extend(json, "extensionsRequired", self.required.into_iter().map(Value::from).collect());
        extend(json, "materials", self.materials);
        extend(json, "textures", self.textures);
        extend(json, "samplers", self.samplers);
        extend(json, "images", self.images);
    }
}

/// Numbers of what is written already.
#[derive(Default)]
struct Known {
    textures: BTreeMap<usize, usize>,
    images: BTreeMap<usize, usize>,
    /// By their JSON.
    samplers: BTreeMap<String, usize>,
}

struct Writer<'a> {
    file: &'a mut File,
    looks: &'a Looks,
    written: Written,
    known: Known,
}

impl Writer<'_> {
    fn look(&mut self, look: &Look, with_textures: bool) -> Value {
        let mut look = look.clone();
        look.retain_textures(&mut |reference| {
            let index = reference.get("index").and_then(Value::as_u64).filter(|_| with_textures);
            let Some(number) = index.and_then(|index| self.texture(usize::try_from(index).ok()?)) else {
                return false;
            };
            reference.insert("index".to_owned(), number.into());
            self.use_extensions(reference);
            true
        });
        self.use_extensions(&look.json);
        look.json.into()
    }

    /// Notes the extensions of something.
    fn use_extensions(&mut self, json: &Map<String, Value>) {
        let extensions = json.get("extensions").and_then(Value::as_object);
        for name in extensions.into_iter().flat_map(Map::keys) {
            self.written.used.insert(name.clone());
            if self.looks.required.contains(name) {
                self.written.required.insert(name.clone());
            }
        }
    }

    /// The number of a texture; `None` if there is no such texture.
    fn texture(&mut self, index: usize) -> Option<usize> {
        if let Some(&number) = self.known.textures.get(&index) {
            return Some(number);
        }
        let looks = self.looks;
        let texture = looks.textures.get(index)?;
        let mut json = json!({});
        if !texture.sampler.is_empty() {
            json["sampler"] = self.sampler(&texture.sampler).into();
        }
        let mut extensions = Vec::new();
        for &image in &texture.images {
            let extension = looks.images.get(image)?.encoding.extension();
            let number = self.image(image)?;
            match extension {
                None => json["source"] = number.into(),
                Some(name) => {
                    json["extensions"][name] = json!({"source": number});
                    extensions.push(name.to_owned());
                }
            }
        }
        if json.get("source").is_none() {
            self.written.required.extend(extensions.iter().cloned());
        }
        self.written.used.extend(extensions);
        if let Some(name) = &texture.name {
            json["name"] = name.as_str().into();
        }
        let number = push_to(&mut self.written.textures, json);
        self.known.textures.insert(index, number);
        Some(number)
    }

    fn sampler(&mut self, sampler: &Map<String, Value>) -> usize {
        let json = Value::from(sampler.clone());
        let samplers = &mut self.written.samplers;
        *self.known.samplers.entry(json.to_string()).or_insert_with(|| push_to(samplers, json))
    }

    fn image(&mut self, index: usize) -> Option<usize> {
        if let Some(&number) = self.known.images.get(&index) {
            return Some(number);
        }
        let image = self.looks.images.get(index)?;
        let start = self.file.bin.len();
        self.file.bin.extend_from_slice(&image.bytes);
        let view = self.file.view(start, None);
        self.file.align();
        let mut json = json!({"bufferView": view, "mimeType": image.encoding.media_type()});
        if let Some(name) = &image.name {
            json["name"] = name.as_str().into();
        }
        let number = push_to(&mut self.written.images, json);
        self.known.images.insert(index, number);
        Some(number)
    }
}

/// Appends an item and gives its index.
fn push_to(list: &mut Vec<Value>, item: Value) -> usize {
    list.push(item);
    list.len() - 1
}
