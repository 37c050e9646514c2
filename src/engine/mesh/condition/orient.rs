//! One sense of rotation per component: the one that was given, or else outward where there is an outside.

use glam::DVec3;

use crate::engine::mesh::NONE;
use crate::engine::mesh::condition::patches::Senses;
use crate::engine::mesh::condition::patches::senses;
use crate::engine::mesh::condition::tally::Tally;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// Turns faces over until every component agrees with itself (the edges where this is impossible are cut before). What
/// was given with one sense keeps it; closed components that were not enclose a positive volume. Returns whether the
/// closed components together are inside out.
pub(super) fn orient(
    ctx: &RunContext,
    corners: &mut [[u32; 3]],
    partner: &mut [u32],
    positions: &[DVec3],
    tally: &mut Tally,
) -> Result<bool, Cancelled> {
    let Senses { patch, n_patches, mut flip, .. } = senses(corners, partner);
    let turned = flip.iter().filter(|&&f| f).count();
    tally.add("faces_turned", turned);

    let mut shells = vec![Shell::new(); n_patches];
    for f in 0..corners.len() {
        let shell = &mut shells[patch[f] as usize];
        shell.faces.push(f as u32);
        shell.closed &= partner[3 * f..3 * f + 3].iter().all(|&t| t != NONE);
        shell.mixed |= flip[f];
        for v in corners[f] {
            shell.low = shell.low.min(positions[v as usize]);
            shell.high = shell.high.max(positions[v as usize]);
        }
    }
    for shell in shells.iter_mut().filter(|shell| shell.closed) {
        // Volumes about the shell's own centre: far from the origin they would drown in rounding.
        let centre = 0.5 * (shell.low + shell.high);
        let volume = |&f: &u32| {
            let [a, b, c] = corners[f as usize].map(|v| positions[v as usize] - centre);
            let sign = if flip[f as usize] { -1.0 } else { 1.0 };
            sign * a.dot(b.cross(c))
        };
        shell.volume = shell.faces.iter().map(volume).sum();
    }
    let mut outward = 0;
    for shell in shells.iter_mut().filter(|shell| shell.volume < 0.0 && shell.mixed) {
        ctx.check()?;
        outward += 1;
        shell.volume = -shell.volume;
        for &f in &shell.faces {
            flip[f as usize] = !flip[f as usize];
        }
    }
    tally.add("components_turned_outward", outward);
    for f in (0..corners.len()).filter(|&f| flip[f]) {
        turn_over(f, corners, partner);
    }
    Ok(shells.iter().map(|shell| shell.volume).sum::<f64>() < 0.0)
}

/// Faces of a component with what is known of it.
#[derive(Clone)]
struct Shell {
    faces: Vec<u32>,
    closed: bool,
    /// Given with both senses.
    mixed: bool,
    /// Six times the enclosed volume, 0 if open.
    volume: f64,
    low: DVec3,
    high: DVec3,
}

impl Shell {
    fn new() -> Self {
        let (low, high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        Self { faces: Vec::new(), closed: true, mixed: false, volume: 0.0, low, high }
    }
}

/// Exchanges the last two corners of face `f`; its halfedge k becomes 2 − k.
fn turn_over(f: usize, corners: &mut [[u32; 3]], partner: &mut [u32]) {
    corners[f].swap(1, 2);
    partner.swap(3 * f, 3 * f + 2);
    for h in 3 * f..3 * f + 3 {
        if partner[h] != NONE {
            partner[partner[h] as usize] = h as u32;
        }
    }
}
