//! The steps of conditioning in order.

use glam::DVec3;

use crate::engine::mesh::Conditioned;
use crate::engine::mesh::NONE;
use crate::engine::mesh::TriMesh;
use crate::engine::mesh::TriangleSoup;
use crate::engine::mesh::condition::ConditionError;
use crate::engine::mesh::condition::degenerate::mend;
use crate::engine::mesh::condition::doubled::drop_duplicates;
use crate::engine::mesh::condition::doubled::folds;
use crate::engine::mesh::condition::doubled::second_sides;
use crate::engine::mesh::condition::draft::Draft;
use crate::engine::mesh::condition::fans::split_double_edges;
use crate::engine::mesh::condition::fans::split_fans;
use crate::engine::mesh::condition::orient::orient;
use crate::engine::mesh::condition::pairing::Pairing;
use crate::engine::mesh::condition::pairing::pair_sides;
use crate::engine::mesh::condition::patches::senses;
use crate::engine::mesh::condition::shards::drop_shards;
use crate::engine::mesh::condition::shells::shells_upon_others;
use crate::engine::mesh::condition::t_vertices::join_t_vertices;
use crate::engine::mesh::condition::tally::Tally;
use crate::engine::mesh::condition::thin::drop_flat_components;
use crate::engine::mesh::condition::triangulate::Triangles;
use crate::engine::mesh::condition::triangulate::triangulate;
use crate::engine::mesh::condition::weld::weld;
use crate::engine::run::{RunContext, Warning, WarningKind};

/// Extents that leave room for products of six lengths.
const EXTENTS: std::ops::RangeInclusive<f64> = 1e-50..=1e50;
/// Rounds in which zero-thickness folds are taken away, each shortening them by a row of faces.
const FOLD_ROUNDS: usize = 32;

/// What the caller allows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ConditionOptions {
    /// Cut components that are not orientable open instead of refusing them.
    pub cut_non_orientable: bool,
}

/// Makes an oriented 2-manifold without degenerate triangles of a soup. Clean input keeps its vertices and faces in
/// their order. O(F log F).
///
/// ```
/// use glam::DVec3;
/// use quadrille::engine::mesh::{TriangleSoup, condition::{ConditionOptions, condition}};
/// use quadrille::engine::run::RunContext;
///
/// // Two triangles of a square that share no vertex, the second one upside down.
/// let (x, y) = (DVec3::X, DVec3::Y);
/// let soup = TriangleSoup::from_triangles(vec![DVec3::ZERO, x, y, x, y, x + y], &[[0, 1, 2], [3, 4, 5]]);
/// let conditioned = condition(&RunContext::silent(), &soup, &ConditionOptions::default())?;
/// assert_eq!((conditioned.mesh.n_vertices(), conditioned.mesh.n_faces()), (4, 2));
/// assert_eq!(conditioned.mesh.topology().boundaries, 1);
/// # Ok::<(), quadrille::engine::mesh::condition::ConditionError>(())
/// ```
///
/// # Errors
/// [`ConditionError`]: no faces, nothing finite, no area, a one-sided component, or stopped.
pub fn condition(
    ctx: &RunContext,
    soup: &TriangleSoup,
    options: &ConditionOptions,
) -> Result<Conditioned, ConditionError> {
    let polygons = soup.n_polygons();
    if polygons == 0 {
        return Err(ConditionError::Empty);
    }
    let mut tally = Tally::default();
    let frame = Frame::of(soup)?;
    let positions: Vec<DVec3> = soup.positions.iter().map(|&p| p * frame.scale).collect();
    let mut triangles = triangulate(ctx, soup, &positions, &mut tally)?;
    weld(&mut triangles, &positions, frame.diagonal, &mut tally);
    ctx.check()?;
    if triangles.corners.is_empty() {
        return Err(ConditionError::ZeroArea { polygons });
    }
    join_t_vertices(ctx, &mut triangles, &positions, frame.diagonal, &mut tally)?;
    let mut partner = join_faces(ctx, &mut triangles, &positions, &mut tally)?;
    let (dropped, shells) = shells_upon_others(&triangles.corners, &partner, &positions);
    if shells > 0 {
        tally.add("duplicate_shells_dropped", shells);
        triangles.retain(|f| !dropped[f]);
        partner = join_faces(ctx, &mut triangles, &positions, &mut tally)?;
    }
    open_one_sided(&triangles, &mut partner, options, &mut tally)?;
    let is_inside_out = orient(ctx, &mut triangles.corners, &mut partner, &positions, &mut tally)?;
    ctx.check()?;
    let n = positions.len();
    let draft = Draft {
        positions,
        origin: (0..n as u32).collect(),
        moved: vec![false; n],
        faces: triangles.corners,
        twin: partner,
        polygon: triangles.polygon,
    };
    let mut draft = split_double_edges(split_fans(draft, &mut tally), &mut tally);
    drop_flat_components(&mut draft, &mut tally);
    drop_shards(&mut draft, frame.diagonal, &mut tally);
    if draft.faces.is_empty() {
        return Err(ConditionError::ZeroArea { polygons });
    }
    let draft = mend(ctx, draft, &mut tally)?;
    if draft.faces.is_empty() {
        return Err(ConditionError::NothingLeft { polygons });
    }
    let mut conditioned = finish(soup, draft, frame.scale, tally)?;
    if is_inside_out {
        conditioned.warnings.push(WarningKind::InsideOut {}.into());
    }
    Ok(conditioned)
}

/// Where the model is and how large.
struct Frame {
    /// Power of two that makes the extent about 1, so that scaling loses no digit.
    scale: f64,
    /// Diagonal of the bounding box in scaled units.
    diagonal: f64,
}

impl Frame {
    fn of(soup: &TriangleSoup) -> Result<Self, ConditionError> {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for polygon in soup.polygons() {
            let corner = |&v: &u32| soup.positions[v as usize];
            if polygon.iter().map(corner).all(DVec3::is_finite) {
                for p in polygon.iter().map(corner) {
                    low = low.min(p);
                    high = high.max(p);
                }
            }
        }
        let extent = (high - low).max_element();
        if extent == f64::NEG_INFINITY {
            return Err(ConditionError::AllNotFinite { polygons: soup.n_polygons() });
        }
        if extent == 0.0 {
            return Err(ConditionError::ZeroArea { polygons: soup.n_polygons() });
        }
        if !EXTENTS.contains(&extent) {
            return Err(ConditionError::Extent { extent: format!("{extent:e}") });
        }
        let scale = (-extent.log2().round()).exp2();
        Ok(Self { scale, diagonal: ((high - low) * scale).length() })
    }
}

/// Drops duplicate faces and second sides and joins the sides of the rest; returns the partner of each halfedge.
fn join_faces(
    ctx: &RunContext,
    triangles: &mut Triangles,
    positions: &[DVec3],
    tally: &mut Tally,
) -> Result<Vec<u32>, ConditionError> {
    let mut round = 0;
    loop {
        let opposite = drop_duplicates(triangles, tally);
        let Pairing { partner, non_manifold_edges } = pair_sides(&triangles.corners, positions);
        ctx.check()?;
        let mut dropped = second_sides(&partner, &opposite);
        if !dropped.contains(&true) && round < FOLD_ROUNDS {
            dropped = folds(&partner, &opposite);
        }
        let n = dropped.iter().filter(|&&d| d).count();
        if n == 0 {
            tally.add("non_manifold_edges_cut", non_manifold_edges);
            return Ok(partner);
        }
        tally.add("double_faces_dropped", n);
        triangles.retain(|f| !dropped[f]);
        round += 1;
    }
}

/// Refuses components with only one side, or cuts them where the senses of their faces clash.
fn open_one_sided(
    triangles: &Triangles,
    partner: &mut [u32],
    options: &ConditionOptions,
    tally: &mut Tally,
) -> Result<(), ConditionError> {
    let senses = senses(&triangles.corners, partner);
    let Some(&first) = senses.reversing.first() else {
        return Ok(());
    };
    let component = senses.patch[first as usize / 3];
    if !options.cut_non_orientable {
        let here = senses.reversing.iter().map(|h| h / 3).filter(|&f| senses.patch[f as usize] == component);
        let mut elements: Vec<u64> = here.map(|f| u64::from(triangles.polygon[f as usize])).collect();
        elements.dedup();
        elements.truncate(20);
        return Err(ConditionError::NonOrientable { component: component as usize, elements });
    }
    for &h in &senses.reversing {
        let t = partner[h as usize];
        partner[h as usize] = NONE;
        partner[t as usize] = NONE;
    }
    tally.add("non_orientable_edges_cut", senses.reversing.len());
    Ok(())
}

fn finish(soup: &TriangleSoup, draft: Draft, scale: f64, mut tally: Tally) -> Result<Conditioned, ConditionError> {
    let mut referenced = vec![false; soup.positions.len()];
    for &v in &soup.indices {
        referenced[v as usize] = true;
    }
    tally.add("unreferenced_vertices_dropped", referenced.iter().filter(|&&r| !r).count());
    let place = |v: usize| {
        if draft.moved[v] { draft.positions[v] / scale } else { soup.positions[draft.origin[v] as usize] }
    };
    let positions = (0..draft.origin.len()).map(place).collect();
    let mesh = TriMesh::try_new(positions, draft.faces)?;
    let repairs = tally.into_counts();
    let warnings = warnings(&repairs);
    Ok(Conditioned { mesh, polygon: draft.polygon, origin: draft.origin, repairs, warnings })
}

/// The repairs that change what the surface is.
fn warnings(repairs: &[(&'static str, usize)]) -> Vec<Warning> {
    let kind = |&(name, n): &(&'static str, usize)| match name {
        "not_finite_faces_dropped" => Some(WarningKind::FacesDropped { faces: n }),
        "non_manifold_edges_cut" => Some(WarningKind::NonManifoldCut { edges: n }),
        "non_orientable_edges_cut" => Some(WarningKind::NonOrientableCut { edges: n }),
        "duplicate_shells_dropped" => Some(WarningKind::DuplicateShell { shells: n }),
        "components_without_area_dropped" | "components_without_volume_dropped" => {
            Some(WarningKind::ComponentDropped { components: n })
        }
        _ => None,
    };
    repairs.iter().filter_map(kind).map(Warning::from).collect()
}
