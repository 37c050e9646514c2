//! The JSON of materials, textures and samplers: what of it is carried, and which values are valid.

use serde_json::{Map, Value};

use super::super::model::cut;

/// What a field may hold. Other values are left out, so that glTF's default holds.
enum May {
    /// A number from the first to the second.
    Number(f64, f64),
    /// So many such numbers.
    Numbers(usize, f64, f64),
    /// One of these numbers.
    Code(&'static [u64]),
    /// One of these words.
    Word(&'static [&'static str]),
    /// A name.
    Name,
    Flag,
    /// A reference to a texture; more is known of it elsewhere.
    Texture,
    /// Anything: it means nothing to a viewer.
    Anything,
    /// An object with these fields.
    Object(&'static [(&'static str, May)]),
}

const ANY: f64 = f64::MAX;

const MATERIAL: &[(&str, May)] = &[
    ("name", May::Name),
    (
        "pbrMetallicRoughness",
        May::Object(&[
            ("baseColorFactor", May::Numbers(4, 0.0, 1.0)),
            ("baseColorTexture", May::Texture),
            ("metallicFactor", May::Number(0.0, 1.0)),
            ("roughnessFactor", May::Number(0.0, 1.0)),
            ("metallicRoughnessTexture", May::Texture),
        ]),
    ),
    ("normalTexture", May::Texture),
    ("occlusionTexture", May::Texture),
    ("emissiveTexture", May::Texture),
    ("emissiveFactor", May::Numbers(3, 0.0, 1.0)),
    ("alphaMode", May::Word(&["OPAQUE", "MASK", "BLEND"])),
    ("alphaCutoff", May::Number(0.0, ANY)),
    ("doubleSided", May::Flag),
    ("extras", May::Anything),
];

/// A reference to a texture but for its index and the set of coordinates.
const REFERENCE: &[(&str, May)] = &[("scale", May::Number(-ANY, ANY)), ("strength", May::Number(0.0, 1.0))];

const TRANSFORM: &[(&str, May)] = &[
    ("offset", May::Numbers(2, -ANY, ANY)),
    ("rotation", May::Number(-ANY, ANY)),
    ("scale", May::Numbers(2, -ANY, ANY)),
];

const WRAPPING: May = May::Code(&[33071, 33648, 10497]);

const SAMPLER: &[(&str, May)] = &[
    ("magFilter", May::Code(&[9728, 9729])),
    ("minFilter", May::Code(&[9728, 9729, 9984, 9985, 9986, 9987])),
    ("wrapS", WRAPPING),
    ("wrapT", WRAPPING),
    ("name", May::Name),
];

/// Materials of these extensions are carried as they are but for their textures.
const EXTENSIONS: &str = "KHR_materials_";

/// The extension that moves textures.
pub(super) const TEXTURE_TRANSFORM: &str = "KHR_texture_transform";

/// Whether a material may have this extension.
pub(super) fn is_extension(name: &str) -> bool {
    name.starts_with(EXTENSIONS)
}

/// What of a material is carried. Its textures are still those of the file.
pub(super) fn carried(json: &Value) -> Map<String, Value> {
    let mut made = fields(json, MATERIAL);
    let extensions = json.get("extensions").and_then(Value::as_object);
    let known = extensions.into_iter().flatten().filter(|(name, value)| is_extension(name) && value.is_object());
    let carried: Map<String, Value> = known.map(|(name, value)| (name.clone(), plain(value))).collect();
    if !carried.is_empty() {
        made.insert("extensions".to_owned(), carried.into());
    }
    made
}

/// An extension without what belongs to further extensions and to applications, and without lists of what could refer to
/// something: no known extension has any.
fn plain(value: &Value) -> Value {
    let Value::Object(json) = value else { return value.clone() };
    let is_list = |value: &Value| value.as_array().is_some_and(|all| all.iter().any(|x| x.is_array() || x.is_object()));
    let kept = json.iter().filter(|(key, value)| !matches!(key.as_str(), "extras" | "extensions") && !is_list(value));
    // References to textures are moved by an extension.
    let inside = |(key, value): (&String, &Value)| {
        (key.clone(), if key.ends_with("Texture") { value.clone() } else { plain(value) })
    };
    Value::Object(kept.map(inside).collect())
}

/// A reference to a texture.
pub(super) struct Reference {
    /// The texture.
    pub(super) index: usize,
    /// The set of texture coordinates.
    pub(super) set: u64,
    /// What else is carried of the reference.
    pub(super) json: Map<String, Value>,
}

/// Reads a reference to a texture; `None` if it refers to none.
pub(super) fn reference(json: &Map<String, Value>) -> Option<Reference> {
    let index = usize::try_from(json.get("index")?.as_u64()?).ok()?;
    let transform = json.get("extensions").and_then(|extensions| extensions.get(TEXTURE_TRANSFORM));
    let set = |json: &Map<String, Value>| json.get("texCoord").and_then(Value::as_u64);
    let moved = transform.and_then(Value::as_object).and_then(set);
    let mut carried = select(json, REFERENCE);
    if let Some(transform) = transform.filter(|transform| transform.is_object()) {
        let transform: Map<String, Value> =
            [(TEXTURE_TRANSFORM.to_owned(), fields(transform, TRANSFORM).into())].into_iter().collect();
        carried.insert("extensions".to_owned(), transform.into());
    }
    Some(Reference { index, set: moved.or_else(|| set(json)).unwrap_or(0), json: carried })
}

/// What of a sampler is carried.
pub(super) fn sampler(json: &Value) -> Map<String, Value> {
    fields(json, SAMPLER)
}

/// The name of something.
pub(super) fn name(json: &Value) -> Option<String> {
    json.get("name").and_then(Value::as_str).filter(|name| !name.is_empty()).map(cut)
}

fn fields(json: &Value, known: &[(&str, May)]) -> Map<String, Value> {
    json.as_object().map(|json| select(json, known)).unwrap_or_default()
}

fn select(json: &Map<String, Value>, known: &[(&str, May)]) -> Map<String, Value> {
    let field = |(key, may): &(&str, May)| Some(((*key).to_owned(), value(json.get(*key)?, may)?));
    known.iter().filter_map(field).collect()
}

/// A value, if the field may hold it.
fn value(json: &Value, may: &May) -> Option<Value> {
    let is_within = |json: &Value, low: f64, high: f64| json.as_f64().is_some_and(|x| (low..=high).contains(&x));
    let fits = match may {
        May::Number(low, high) => is_within(json, *low, *high),
        May::Numbers(n, low, high) => {
            json.as_array().is_some_and(|all| all.len() == *n && all.iter().all(|x| is_within(x, *low, *high)))
        }
        May::Code(codes) => json.as_u64().is_some_and(|code| codes.contains(&code)),
        May::Word(words) => json.as_str().is_some_and(|word| words.contains(&word)),
        May::Name => return json.as_str().filter(|name| !name.is_empty()).map(|name| cut(name).into()),
        May::Flag => json.is_boolean(),
        May::Texture => json.is_object(),
        May::Anything => true,
        May::Object(known) => {
            let object = fields(json, known);
            return (!object.is_empty()).then(|| object.into());
        }
    };
    fits.then(|| json.clone())
}
