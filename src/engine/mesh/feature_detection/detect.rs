//! The steps of feature detection in order.

use crate::engine::mesh::Conditioned;
use crate::engine::mesh::Features;
use crate::engine::mesh::TriMesh;
use crate::engine::mesh::TriangleSoup;
use crate::engine::mesh::feature_detection::corners::find_corners;
use crate::engine::mesh::feature_detection::network::Network;
use crate::engine::mesh::feature_detection::prune::prune;
use crate::engine::mesh::feature_detection::seeds::mark_explicit;
use crate::engine::mesh::feature_detection::seeds::mark_material_borders;
use crate::engine::mesh::feature_detection::seeds::mark_split_normals;

/// What is a feature.
#[derive(Clone, Debug, PartialEq)]
pub struct FeatureOptions {
    /// Angle between face normals in degrees, 0 to 180, above which an edge is sharp; 180 = none.
    pub angle_degrees: f64,
    /// Whether borders between materials are features.
    pub materials: bool,
    /// Whether edges are features where the normals that the soup gives to their two sides differ.
    pub normals: bool,
    /// Explicit feature edges as pairs of positions of the soup.
    pub explicit: Vec<[u32; 2]>,
    /// Length in model units, about two quad edges, below which sharp chains are noise unless both their ends are
    /// junctions or on the boundary; also how closely sharpness is looked at. 0 keeps every sharp edge. Material
    /// borders, split normals and explicit edges are never dropped.
    pub min_length: f64,
}

impl Default for FeatureOptions {
    fn default() -> Self {
        Self { angle_degrees: 40.0, materials: true, normals: false, explicit: Vec::new(), min_length: 0.0 }
    }
}

/// Finds the feature network of a conditioned surface. `soup` is the one it was made of. O(F log F).
///
/// ```
/// use quadrille::engine::mesh::condition::{ConditionOptions, condition};
/// use quadrille::engine::mesh::{FeatureOptions, detect_features, shapes::sample};
/// use quadrille::engine::run::RunContext;
///
/// let soup = sample("cube", 300, 0.0, 0).expect("one of the samples");
/// let conditioned = condition(&RunContext::silent(), &soup, &ConditionOptions::default())?;
/// let features = detect_features(&conditioned, &soup, &FeatureOptions::default());
/// assert_eq!(features.corners.len(), 8);
/// # Ok::<(), quadrille::engine::mesh::condition::ConditionError>(())
/// ```
pub fn detect_features(conditioned: &Conditioned, soup: &TriangleSoup, options: &FeatureOptions) -> Features {
    let mesh = &conditioned.mesh;
    let mut network = Network::new(mesh);
    if options.materials {
        mark_material_borders(conditioned, soup, &mut network);
    }
    if options.normals {
        mark_split_normals(conditioned, soup, &mut network);
    }
    mark_explicit(conditioned, soup, &options.explicit, &mut network);
    if options.angle_degrees < 180.0 {
        network.mark_sharp(options.angle_degrees.to_radians());
        network.grow(0.5 * options.angle_degrees.to_radians());
        prune(&mut network, options.angle_degrees.to_radians(), options.min_length);
    }
    let corners = find_corners(mesh, &network, options.min_length);
    Features { edges: network.edges(), corners }
}

/// Part of the length of all sharp edges from which the features make up a constructed shape: what is sharp besides is
/// detail then, not noise.
const CONSTRUCTED: f64 = 0.85;
/// Detail is looked at this much more closely,
const CLOSER: f64 = 0.5;
/// and is heeded up to this share of the length of the features.
const MOST_DETAIL: f64 = 0.15;
/// Largest mesh in which it is looked for.
const MOST_FACES_DETAILED: usize = 200_000;

/// Features with what is known of those that were left out.
#[derive(Clone, Debug, Default)]
pub struct Detected {
    /// The feature network.
    pub features: Features,
    /// Vertices at detail of a constructed shape that quads of the size behind `min_length` cannot show: smaller quads are
    /// needed there. Sorted.
    pub detail: Vec<u32>,
    /// Edges above the feature angle that are no features, as (lower, higher) vertex, sorted: noise, or detail.
    pub dropped: Vec<[u32; 2]>,
}

/// As [`detect_features`], with the detail of constructed shapes and the sharp edges that were left out. O(F log F).
pub fn detect_features_and_detail(
    conditioned: &Conditioned,
    soup: &TriangleSoup,
    options: &FeatureOptions,
) -> Detected {
    let mut sharp = Network::new(&conditioned.mesh);
    if options.angle_degrees < 180.0 {
        sharp.mark_sharp(options.angle_degrees.to_radians());
    }
    let sharp = sharp.edges();
    let (features, detail) = with_detail(conditioned, soup, options, &sharp);
    let is_dropped = |e: &[u32; 2]| features.edges.binary_search(e).is_err();
    Detected { dropped: sharp.into_iter().filter(is_dropped).collect(), features, detail }
}

fn with_detail(
    conditioned: &Conditioned,
    soup: &TriangleSoup,
    options: &FeatureOptions,
    sharp: &[[u32; 2]],
) -> (Features, Vec<u32>) {
    let mesh = &conditioned.mesh;
    let features = detect_features(conditioned, soup, options);
    let lengths = |edges: &mut dyn Iterator<Item = [u32; 2]>| -> f64 {
        edges.map(|e| mesh.position(e[0]).distance(mesh.position(e[1]))).sum()
    };
    let total = lengths(&mut features.edges.iter().copied());
    let is_constructed = total >= CONSTRUCTED * lengths(&mut sharp.iter().copied());
    if features.edges.is_empty() || !is_constructed || mesh.n_faces() > MOST_FACES_DETAILED {
        return (features, Vec::new());
    }
    let closer = FeatureOptions { min_length: CLOSER * options.min_length, ..options.clone() };
    let closer = detect_features(conditioned, soup, &closer);
    let is_new = |e: &[u32; 2]| features.edges.binary_search(e).is_err();
    let detail: Vec<[u32; 2]> = closer.edges.iter().copied().filter(is_new).collect();
    if lengths(&mut detail.iter().copied()) > MOST_DETAIL * total {
        return (features, Vec::new());
    }
    let mut detail = detail.concat();
    detail.sort_unstable();
    detail.dedup();
    (closer, detail)
}

/// The feature network that these edges make up, given as (lower, higher) vertex and sorted, with its corners and those
/// of the boundary. `min_length` as in [`FeatureOptions`]. O(F log F).
pub fn features_of_edges(mesh: &TriMesh, edges: &[[u32; 2]], min_length: f64) -> Features {
    let mut network = Network::new(mesh);
    for h in 0..mesh.n_halfedges() {
        let (a, b) = (mesh.origin(h), mesh.target(h));
        if !mesh.is_boundary(h) && edges.binary_search(&[a.min(b), a.max(b)]).is_ok() {
            network.set(h, true);
        }
    }
    let corners = find_corners(mesh, &network, min_length);
    Features { edges: network.edges(), corners }
}
