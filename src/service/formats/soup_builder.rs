//! Building a soup under limits.

use std::collections::BTreeMap;

use glam::DVec3;

use super::error::ReadError;
use super::model::{Model, ObjectName, Scene};
use crate::engine::mesh::Influences;
use crate::engine::mesh::TriangleSoup;

/// How much a file may hold. Judged from what the file claims before anything is allocated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReadLimits {
    /// Vertices, before welding and counting every instance.
    pub max_vertices: u64,
    /// Triangles, counting a polygon of n corners as n − 2.
    pub max_polygons: u64,
    /// Bytes that an archive, data URIs and compressed buffers may unpack to.
    pub max_bytes_unpacked: u64,
}

impl Default for ReadLimits {
    /// 20 million vertices, 40 million triangles, 4 GiB.
    fn default() -> Self {
        Self { max_vertices: 20_000_000, max_polygons: 40_000_000, max_bytes_unpacked: 4 << 30 }
    }
}

/// What makes materials the same.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
enum MaterialKey {
    Name(String),
    /// In the list of the file.
    Index(usize),
}

/// A soup under construction that never grows beyond its limits.
#[derive(Debug)]
pub(super) struct SoupBuilder {
    soup: TriangleSoup,
    max_vertices: u64,
    max_triangles: u64,
    triangles: u64,
    primitives: u64,
    material: Option<u32>,
    material_numbers: BTreeMap<MaterialKey, u32>,
    /// The object that polygons belong to from now on; those of earlier objects are filled in when it changes.
    object: u32,
    /// Empty as long as no object was named.
    objects: Vec<ObjectName>,
}

impl SoupBuilder {
    pub(super) fn new(limits: &ReadLimits) -> Self {
        Self {
            soup: TriangleSoup::default(),
            // Indices and polygon ends are u32, whatever the limits say.
            max_vertices: limits.max_vertices.min(u64::from(u32::MAX) - 1),
            max_triangles: limits.max_polygons.min(u64::from(u32::MAX) / 3),
            triangles: 0,
            primitives: 0,
            material: None,
            material_numbers: BTreeMap::new(),
            object: 0,
            objects: Vec::new(),
        }
    }

    /// Fails if this many more vertices would be too many. Call with what the file claims, before reading it.
    pub(super) fn claim_vertices(&self, more: u64) -> Result<(), ReadError> {
        let claimed = more.saturating_add(self.soup.positions.len() as u64);
        within("vertices", claimed, self.max_vertices)
    }

    /// Fails if this many more triangles would be too many. Call with what the file claims, before reading it.
    pub(super) fn claim_triangles(&self, more: u64) -> Result<(), ReadError> {
        within("triangles", more.saturating_add(self.triangles), self.max_triangles)
    }

    /// Counts parts of a model, which cost time even where they hold nothing.
    pub(super) fn claim_primitives(&mut self, more: u64) -> Result<(), ReadError> {
        self.primitives = self.primitives.saturating_add(more);
        within("primitives, counting every instance,", self.primitives, MAX_PRIMITIVES)
    }

    pub(super) fn n_vertices(&self) -> usize {
        self.soup.positions.len()
    }

    pub(super) fn n_corners(&self) -> usize {
        self.soup.indices.len()
    }

    pub(super) fn vertex(&mut self, position: DVec3) -> Result<(), ReadError> {
        self.claim_vertices(1)?;
        self.soup.positions.push(position);
        if !self.soup.colours.is_empty() {
            self.soup.colours.push([NO_VALUE; 4]);
        }
        if !self.soup.skin.is_empty() {
            self.soup.skin.push(Influences::one(0));
        }
        Ok(())
    }

    /// Gives the last vertex a colour; vertices without one are white as soon as one has one.
    pub(super) fn colour(&mut self, colour: [f32; 4]) {
        self.soup.colours.resize(self.soup.positions.len(), [NO_VALUE; 4]);
        if let Some(last) = self.soup.colours.last_mut() {
            *last = colour;
        }
    }

    /// Gives the last vertex joints and weights; vertices without hang on joint 0 as soon as one has some.
    pub(super) fn influences(&mut self, influences: Influences) {
        self.soup.skin.resize(self.soup.positions.len(), Influences::one(0));
        if let Some(last) = self.soup.skin.last_mut() {
            *last = influences;
        }
    }

    /// Polygons from now on belong to a new object; gives its number.
    pub(super) fn new_object(&mut self, name: ObjectName) -> u32 {
        if self.objects.is_empty() && self.soup.n_polygons() > 0 {
            self.objects.push(ObjectName::default());
        }
        self.objects.push(name);
        let number = self.objects.len() as u32 - 1;
        self.object(number);
        number
    }

    /// Polygons from now on belong to a known object.
    pub(super) fn object(&mut self, number: u32) {
        self.soup.objects.resize(self.soup.n_polygons(), self.object);
        self.object = number;
    }

    /// Polygons from now on are of the material of this name.
    pub(super) fn material(&mut self, name: &str) {
        self.set_material(MaterialKey::Name(name.to_owned()), name);
    }

    /// Polygons from now on are of this material of the file, which may have materials of the same name.
    pub(super) fn material_of_file(&mut self, index: usize, name: &str) {
        self.set_material(MaterialKey::Index(index), name);
    }

    fn set_material(&mut self, key: MaterialKey, name: &str) {
        if self.material.is_none() && self.soup.n_polygons() > 0 {
            let unnamed = self.material_number(MaterialKey::Name(String::new()), "");
            self.soup.materials.resize(self.soup.n_polygons(), unnamed);
        }
        self.material = Some(self.material_number(key, name));
    }

    fn material_number(&mut self, key: MaterialKey, name: &str) -> u32 {
        let names = &mut self.soup.material_names;
        *self.material_numbers.entry(key).or_insert_with(|| {
            names.push(name.to_owned());
            names.len() as u32 - 1
        })
    }

    /// Per material of the soup its index in the file; none for those that no polygon has or that have only a name.
    pub(super) fn materials_of_file(&self) -> Vec<Option<usize>> {
        let mut used = vec![false; self.soup.material_names.len()];
        self.soup.materials.iter().for_each(|&m| used[m as usize] = true);
        let mut indices = vec![None; used.len()];
        for (key, &number) in &self.material_numbers {
            if let MaterialKey::Index(index) = key {
                indices[number as usize] = used[number as usize].then_some(*index);
            }
        }
        indices
    }

    /// Appends a polygon whose corners are known, or will be shown by [`Self::finish`], to be in range. Fewer than
    /// three corners are dropped and counted.
    pub(super) fn polygon(&mut self, corners: &[u32]) -> Result<(), ReadError> {
        if corners.len() < 3 {
            self.dropped(1);
            return Ok(());
        }
        let triangles = corners.len() as u64 - 2;
        self.claim_triangles(triangles)?;
        self.triangles += triangles;
        self.soup.push_polygon(corners);
        if let Some(material) = self.material {
            self.soup.materials.push(material);
        }
        let n = self.soup.indices.len();
        if !self.soup.uv.is_empty() {
            self.soup.uv.resize(n, [0.0; 2]);
        }
        if !self.soup.normals.is_empty() {
            self.soup.normals.resize(n, [0.0; 3]);
        }
        Ok(())
    }

    /// Gives the last corners texture coordinates, v upwards; corners without are at the origin as soon as one has some.
    pub(super) fn uv(&mut self, uv: impl ExactSizeIterator<Item = [f32; 2]>) {
        give_last(&mut self.soup.uv, self.soup.indices.len(), uv);
    }

    /// Gives the last corners normals; corners without have none as soon as one has one.
    pub(super) fn normals(&mut self, normals: impl ExactSizeIterator<Item = [f32; 3]>) {
        give_last(&mut self.soup.normals, self.soup.indices.len(), normals);
    }

    /// Counts polygons that were left out. They count against the limit: instances of a mesh that is nothing but such
    /// polygons cost time, too.
    pub(super) fn dropped(&mut self, n: usize) {
        self.triangles = self.triangles.saturating_add(n as u64);
        self.soup.dropped_by_reader += n;
    }

    /// The polygons alone.
    pub(super) fn finish(self, format: &'static str) -> Result<TriangleSoup, ReadError> {
        Ok(self.finish_model(format)?.soup)
    }

    /// The polygons and the names of their objects.
    pub(super) fn finish_model(mut self, format: &'static str) -> Result<Model, ReadError> {
        if self.soup.n_polygons() == 0 {
            return Err(ReadError::Empty { format });
        }
        // Some writers say 0 to 255.
        if self.soup.colours.iter().flatten().any(|&c| c > 1.0) {
            self.soup.colours.iter_mut().flatten().for_each(|c| *c /= 255.0);
        }
        self.soup.colours.iter_mut().flatten().for_each(|c| *c = if c.is_nan() { 1.0 } else { c.clamp(0.0, 1.0) });
        let objects = self.name_objects();
        Ok(Model { soup: self.soup, scene: Scene { objects, ..Scene::default() }, warnings: Vec::new() })
    }

    /// The objects that have polygons. One alone needs no numbers, and where none has a name there are none.
    fn name_objects(&mut self) -> Vec<ObjectName> {
        let mut names = std::mem::take(&mut self.objects);
        if names.len() > 1 {
            self.object(self.object);
            let mut used = vec![false; names.len()];
            self.soup.objects.iter().for_each(|&o| used[o as usize] = true);
            let before = |count: &mut u32, &used: &bool| Some(std::mem::replace(count, *count + u32::from(used)));
            let numbers: Vec<u32> = used.iter().scan(0, before).collect();
            self.soup.objects.iter_mut().for_each(|o| *o = numbers[*o as usize]);
            names = names.into_iter().zip(used).filter_map(|(name, used)| used.then_some(name)).collect();
        }
        if names.iter().all(|name| *name == ObjectName::default()) {
            names = Vec::new();
        }
        if names.len() < 2 {
            self.soup.objects = Vec::new();
        }
        names
    }
}

/// Gives the last of n corners these values, and zeros to those that have none.
fn give_last<const N: usize>(list: &mut Vec<[f32; N]>, n: usize, values: impl ExactSizeIterator<Item = [f32; N]>) {
    list.resize(n - values.len().min(n), [0.0; N]);
    list.extend(values.map(|value| value.map(|c| if c.is_finite() { c } else { 0.0 })));
    list.resize(n, [0.0; N]);
}

/// Far more than any scene holds.
const MAX_PRIMITIVES: u64 = 1_000_000;
/// A component that the file does not say; it becomes 1 in the end.
pub(super) const NO_VALUE: f32 = f32::NAN;

pub(super) fn within(what: &'static str, claimed: u64, limit: u64) -> Result<(), ReadError> {
    if claimed > limit { Err(ReadError::TooLarge { what, claimed, limit }) } else { Ok(()) }
}
