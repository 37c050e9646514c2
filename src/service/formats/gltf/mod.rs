//! Reading glTF 2.0: JSON or GLB, all that bears on where the surface is, what moves it and what it looks like. Animations,
//! cameras and morph targets are passed over; skinned meshes are read in their bind pose.
//!
//! The crate `gltf` parses the JSON, without its validation, which refuses every required extension it was not compiled
//! with. So nothing is trusted here: every index, offset, stride and count is checked where it is used.

mod accessor;
mod bind;
mod document;
mod draco;
mod draco_cache;
mod fault;
mod influences;
mod looks;
mod material;
mod matrix;
mod meshopt;
mod primitive;
mod scene;
mod uri;
mod values;

use gltf::json::Root;
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::validation::Checked;

use super::beside::Beside;
use super::error::ReadError;
use super::model::{Model, ObjectName};
use super::soup_builder::{ReadLimits, SoupBuilder};
use crate::engine::run::{Warning, WarningKind};
use bind::Binder;
use document::Document;
use fault::GLTF;
use primitive::Shared;
use scene::Instance;

/// Reads all instances of all meshes of the default scene: their polygons, what their nodes are called, and the joints
/// that move them.
///
/// # Errors
/// With the JSON pointer of the faulty element.
pub(super) fn read(bytes: &[u8], beside: &dyn Beside, limits: &ReadLimits) -> Result<Model, ReadError> {
    let document = Document::open(bytes, beside, limits)?;
    let mut builder = SoupBuilder::new(limits);
    let graph = scene::graph(&document.root)?;
    let (mut binder, mut shared) = (Binder::new(&document, &graph), Shared::default());
    for instance in &graph.instances {
        builder.new_object(name(&document.root, instance));
        primitive::append_mesh(&document, instance, &mut binder, &mut shared, &mut builder)?;
    }
    let materials = builder.materials_of_file();
    let mut model = builder.finish_model(GLTF)?;
    model.scene.skeleton = binder.finish();
    model.warnings = left_behind(&document.root);
    model.scene.looks = looks::read(&document, &materials, &mut model.warnings)?;
    Ok(model)
}

/// What an instance is called: one without a name as its mesh.
fn name(root: &Root, instance: &Instance) -> ObjectName {
    let mesh = root.meshes.get(instance.mesh).and_then(|mesh| mesh.name.as_deref()).unwrap_or_default();
    let node = instance.node.and_then(|node| root.nodes[node].name.as_deref()).filter(|name| !name.is_empty());
    ObjectName::new(node.unwrap_or(mesh), mesh)
}

/// What quads do not carry, though they could be expected to.
fn left_behind(root: &Root) -> Vec<Warning> {
    let has_targets = |p: &Primitive| p.targets.as_ref().is_some_and(|targets| !targets.is_empty());
    let has_targets = root.meshes.iter().any(|mesh| mesh.primitives.iter().any(has_targets));
    let animations = (!root.animations.is_empty()).then_some("animations are not carried to the quads");
    let targets =
        has_targets.then_some("morph targets are not carried to the quads, which have the shape without them");
    let second = Checked::Valid(Semantic::TexCoords(1));
    let has_second = root.meshes.iter().any(|mesh| mesh.primitives.iter().any(|p| p.attributes.contains_key(&second)));
    let second = has_second.then_some("of several sets of texture coordinates only the first is carried to the quads");
    let lost = animations.into_iter().chain(targets).chain(second).map(str::to_owned);
    lost.map(|what| WarningKind::AttributesLost { what }.into()).collect()
}

#[cfg(test)]
mod looks_tests;
#[cfg(test)]
mod skin_tests;
#[cfg(test)]
mod tests;
