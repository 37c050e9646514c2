//! How irregular a vertex is.

use glam::DVec3;

use crate::engine::quad::Anchor;
use crate::engine::quad::improve::net::Fan;
use crate::engine::quad::improve::net::QuadNet;

/// Squared deviation of the number of quads at `v` from the ideal: 4 round a vertex of the surface, 2 on each side of a
/// curve, and at a corner as many right angles as each of its sectors has. Vertices without a proper fan cost nothing.
pub(crate) fn irregularity(net: &QuadNet, positions: &[DVec3], v: u32) -> f64 {
    let Some(fan) = net.fan(v) else { return 0.0 };
    if fan.closed && net.is_free(v) {
        return square(fan.quads.len() as f64 - 4.0);
    }
    let is_corner = matches!(net.anchors[v as usize], Anchor::Corner(_));
    let mut sum = 0.0;
    for sector in sectors(net, v, &fan) {
        let angle: f64 = sector.iter().map(|&slot| corner_angle(net, positions, slot, v)).sum();
        let right_angles = (angle / std::f64::consts::FRAC_PI_2).round().max(1.0);
        let ideal = match (is_corner, fan.closed) {
            (false, true) if sector.len() == fan.quads.len() => 4.0,
            (false, _) => 2.0,
            (true, _) => right_angles,
        };
        sum += square(sector.len() as f64 - ideal);
    }
    sum
}

fn square(x: f64) -> f64 {
    x * x
}

/// The quads round `v` between one feature edge (or the boundary) and the next.
fn sectors(net: &QuadNet, v: u32, fan: &Fan) -> Vec<Vec<u32>> {
    let n = fan.quads.len();
    let first = if fan.closed { (0..n).find(|&i| net.is_feature(v, fan.spokes[i])).unwrap_or(0) } else { 0 };
    let mut sectors: Vec<Vec<u32>> = Vec::new();
    for i in (0..n).map(|i| (first + i) % n) {
        if sectors.is_empty() || net.is_feature(v, fan.spokes[i]) {
            sectors.push(Vec::new());
        }
        sectors.last_mut().into_iter().for_each(|s| s.push(fan.quads[i]));
    }
    sectors
}

fn corner_angle(net: &QuadNet, positions: &[DVec3], slot: u32, v: u32) -> f64 {
    let (quad, k) = (&net.quads[slot as usize], net.corner(slot, v));
    let here = positions[v as usize];
    let e = positions[quad[(k + 1) % 4] as usize] - here;
    let f = positions[quad[(k + 3) % 4] as usize] - here;
    if e.length_squared() > 0.0 && f.length_squared() > 0.0 { e.angle_between(f) } else { 0.0 }
}
