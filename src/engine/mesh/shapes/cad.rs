//! Sample parts with sharp edges: plates and gears with holes, extruded from plane outlines.

use crate::engine::mesh::shapes::patches::PatchComplex;
use glam::{DVec2, DVec3, dvec2, dvec3};
use std::f64::consts::{PI, TAU};

/// A curve piece in the plane, from parameter 0 to 1.
type Curve = Box<dyn Fn(f64) -> DVec2 + Send + Sync>;

fn line(a: DVec2, b: DVec2) -> Curve {
    Box::new(move |s| a + s * (b - a))
}

/// An arc around `centre`.
fn arc(centre: DVec2, radius: f64, from: f64, to: f64) -> Curve {
    Box::new(move |s| {
        let angle = from + s * (to - from);
        centre + radius * dvec2(angle.cos(), angle.sin())
    })
}

/// Which way a horizontal region looks.
#[derive(Clone, Copy)]
enum Facing {
    Up,
    Down,
}

/// The region between two curves, the inner one on the left of the outer one, at height `z`.
fn add_strip(net: &mut PatchComplex, inner: Curve, outer: Curve, z: f64, facing: Facing) {
    let at = move |s: f64, t: f64| {
        let (a, b) = (inner(s), outer(s));
        (a + t * (b - a)).extend(z)
    };
    match facing {
        Facing::Up => net.add(move |s, t| at(t, s)),
        Facing::Down => net.add(at),
    }
}

/// A vertical wall over a curve; its outside is on the right of the curve.
fn add_wall(net: &mut PatchComplex, curve: Curve, low: f64, high: f64) {
    net.add(move |s, t| curve(s).extend(low + t * (high - low)));
}

/// A plate of 3 by 2 square cells, each with a round through hole: genus 6.
pub(super) fn plate_with_holes() -> PatchComplex {
    let (columns, rows, radius, half_height) = (3, 2, 0.28, 0.12);
    let mut net = PatchComplex::default();
    for row in 0..rows {
        for column in 0..columns {
            let centre = dvec2(f64::from(column) - 1.0, f64::from(row) - 0.5);
            // Eight sides per cell: corners and middles of the square, counter-clockwise.
            let square =
                [(0.5, 0.0), (0.5, 0.5), (0.0, 0.5), (-0.5, 0.5), (-0.5, 0.0), (-0.5, -0.5), (0.0, -0.5), (0.5, -0.5)]
                    .map(|(x, y)| centre + dvec2(x, y));
            for k in 0..8 {
                let (from, to) = (k as f64 * PI / 4.0, (k as f64 + 1.0) * PI / 4.0);
                for (z, facing) in [(half_height, Facing::Up), (-half_height, Facing::Down)] {
                    add_strip(&mut net, arc(centre, radius, from, to), line(square[k], square[(k + 1) % 8]), z, facing);
                }
                add_wall(&mut net, arc(centre, radius, to, from), -half_height, half_height);
                let outside = match k {
                    7 | 0 => column == columns - 1,
                    1 | 2 => row == rows - 1,
                    3 | 4 => column == 0,
                    _ => row == 0,
                };
                if outside {
                    add_wall(&mut net, line(square[k], square[(k + 1) % 8]), -half_height, half_height);
                }
            }
        }
    }
    net
}

/// A gear wheel: twelve teeth, a bore, a thinner web with six round holes: genus 7.
pub(super) fn gear() -> PatchComplex {
    let teeth = 12;
    let (bore, hub, rim, root, tip) = (0.35, 0.62, 1.45, 1.7, 2.05);
    let (thick, thin) = (0.35, 0.14);
    let o = DVec2::ZERO;
    let mut net = PatchComplex::default();
    // Angle at which block k begins: odd blocks carry a tooth.
    let angle = move |k: usize| TAU * k as f64 / (2 * teeth) as f64;
    let polar = |r: f64, a: f64| dvec2(r * a.cos(), r * a.sin());
    for k in 0..2 * teeth {
        let (from, to) = (angle(k), angle(k + 1));
        let ring = |r: f64| arc(o, r, from, to);
        for (side, facing) in [(1.0, Facing::Up), (-1.0, Facing::Down)] {
            add_strip(&mut net, ring(bore), ring(hub), side * thick, facing);
            add_strip(&mut net, ring(rim), ring(root), side * thick, facing);
        }
        add_wall(&mut net, arc(o, bore, to, from), -thick, thick);
        add_wall(&mut net, ring(hub), thin, thick);
        add_wall(&mut net, ring(hub), -thick, -thin);
        add_wall(&mut net, arc(o, rim, to, from), thin, thick);
        add_wall(&mut net, arc(o, rim, to, from), -thick, -thin);
        if k % 2 == 0 {
            add_wall(&mut net, ring(root), -thick, thick);
            continue;
        }
        let taper = 0.22 * (to - from);
        let crown = || arc(o, tip, from + taper, to - taper);
        add_strip(&mut net, ring(root), crown(), thick, Facing::Up);
        add_strip(&mut net, ring(root), crown(), -thick, Facing::Down);
        add_wall(&mut net, crown(), -thick, thick);
        add_wall(&mut net, line(polar(root, from), polar(tip, from + taper)), -thick, thick);
        add_wall(&mut net, line(polar(tip, to - taper), polar(root, to)), -thick, thick);
    }
    for hole in 0..teeth / 2 {
        // A cell of the web over four blocks; its outline has four arcs outside, a spoke, four arcs inside, a spoke.
        let first = 4 * hole;
        let middle = angle(first + 2);
        let centre = polar(0.5 * (hub + rim), middle);
        let mut outline: Vec<Curve> = Vec::new();
        let mut ends = Vec::new();
        for k in first..first + 4 {
            outline.push(arc(o, rim, angle(k), angle(k + 1)));
            ends.push(polar(rim, angle(k)));
        }
        outline.push(line(polar(rim, angle(first + 4)), polar(hub, angle(first + 4))));
        ends.push(polar(rim, angle(first + 4)));
        for k in (first..first + 4).rev() {
            outline.push(arc(o, hub, angle(k + 1), angle(k)));
            ends.push(polar(hub, angle(k + 1)));
        }
        outline.push(line(polar(hub, angle(first)), polar(rim, angle(first))));
        ends.push(polar(hub, angle(first)));
        // Directions from the hole's centre to the ends of the sides, turning counter-clockwise from the first.
        let mut turn: Vec<f64> = ends.iter().map(|e| (e.y - centre.y).atan2(e.x - centre.x)).collect();
        for k in 1..turn.len() {
            while turn[k] < turn[k - 1] {
                turn[k] += TAU;
            }
        }
        turn.push(turn[0] + TAU);
        for (k, curve) in outline.into_iter().enumerate() {
            let shared = std::sync::Arc::new(curve);
            for (z, facing) in [(thin, Facing::Up), (-thin, Facing::Down)] {
                let outer = shared.clone();
                let outer: Curve = Box::new(move |s| outer(s));
                add_strip(&mut net, arc(centre, 0.27, turn[k], turn[k + 1]), outer, z, facing);
            }
            add_wall(&mut net, arc(centre, 0.27, turn[k + 1], turn[k]), -thin, thin);
        }
    }
    net
}

/// The edges of the unit cube's frame as pairs of points, for surfaces built around it.
pub(super) fn cube_frame() -> Vec<(DVec3, DVec3)> {
    let corner = |i: usize| dvec3((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2 & 1) as f64) * 2.0 - DVec3::ONE;
    let mut edges = Vec::new();
    for a in 0..8usize {
        for bit in [1, 2, 4] {
            if a & bit == 0 {
                edges.push((corner(a), corner(a | bit)));
            }
        }
    }
    edges
}
