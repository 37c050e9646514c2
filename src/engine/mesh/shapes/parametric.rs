//! Sample surfaces with a closed formula.

use crate::engine::mesh::shapes::patches::PatchComplex;
use glam::{DVec3, dvec3};
use std::f64::consts::{FRAC_PI_4, PI, TAU};

/// How the sides of a cube are divided.
#[derive(Clone, Copy)]
enum Division {
    /// By equal lengths.
    Lengths,
    /// By equal angles seen from the centre, so that a projection to the sphere comes out nearly uniform.
    Angles,
}

/// The six sides of the cube [-1, 1]³ through a map of space.
fn cube_net(division: Division, map: impl Fn(DVec3) -> DVec3 + Send + Sync + Copy + 'static) -> PatchComplex {
    let frames = [
        (DVec3::X, DVec3::Y, DVec3::Z),
        (DVec3::Y, DVec3::Z, DVec3::X),
        (DVec3::Z, DVec3::X, DVec3::Y),
        (DVec3::NEG_X, DVec3::Z, DVec3::Y),
        (DVec3::NEG_Y, DVec3::X, DVec3::Z),
        (DVec3::NEG_Z, DVec3::Y, DVec3::X),
    ];
    let warp = move |s: f64| match division {
        Division::Lengths => 2.0 * s - 1.0,
        Division::Angles => ((2.0 * s - 1.0) * FRAC_PI_4).tan(),
    };
    let mut net = PatchComplex::default();
    for (n, u, v) in frames {
        net.add(move |s, t| map(n + u * warp(s) + v * warp(t)));
    }
    net
}

/// The unit cube around the origin; 12 triangles at the least.
pub(super) fn cube() -> PatchComplex {
    cube_net(Division::Lengths, |p| 0.5 * p)
}

/// The unit sphere.
pub(super) fn sphere() -> PatchComplex {
    cube_net(Division::Angles, DVec3::normalize)
}

/// An ellipsoid with three different axes.
pub(super) fn ellipsoid() -> PatchComplex {
    cube_net(Division::Angles, |p| p.normalize() * dvec3(1.0, 0.7, 0.45))
}

/// A box with quarter-round edges: the points at distance r from a smaller box.
pub(super) fn rounded_box() -> PatchComplex {
    let (half, r) = (dvec3(1.0, 0.7, 0.5), 0.25);
    let mut net = PatchComplex::default();
    // Per axis: the lower round, the flat, the upper round. Angles go 0..90 degrees over a round.
    for (axis, sign) in [(0, 1.0), (1, 1.0), (2, 1.0), (0, -1.0), (1, -1.0), (2, -1.0)] {
        let (u_axis, v_axis) =
            if sign > 0.0 { ((axis + 1) % 3, (axis + 2) % 3) } else { ((axis + 2) % 3, (axis + 1) % 3) };
        for i in 0..3i32 {
            for j in 0..3i32 {
                net.add(move |s, t| {
                    // Offsets inside the core box, and directions by half angles: 45 degrees of each round.
                    let part = |k: i32, x: f64, core: f64| match k {
                        0 => (-core, -((1.0 - x) * FRAC_PI_4).tan()),
                        1 => (core * (2.0 * x - 1.0), 0.0),
                        _ => (core, (x * FRAC_PI_4).tan()),
                    };
                    let (cu, du) = part(i, s, half[u_axis] - r);
                    let (cv, dv) = part(j, t, half[v_axis] - r);
                    let (mut centre, mut direction) = (DVec3::ZERO, DVec3::ZERO);
                    centre[axis] = sign * (half[axis] - r);
                    centre[u_axis] = cu;
                    centre[v_axis] = cv;
                    direction[axis] = sign;
                    direction[u_axis] = du;
                    direction[v_axis] = dv;
                    centre + r * direction.normalize()
                });
            }
        }
    }
    net
}

/// A bumpy star-shaped ball: smooth noise of three octaves on the radius.
pub(super) fn noisy_blob() -> PatchComplex {
    cube_net(Division::Angles, |p| {
        let d = p.normalize();
        let mut radius = 1.0;
        for (k, amplitude) in [(1.7, 0.16), (2.9, 0.05), (5.3, 0.012)] {
            let q = d * k + dvec3(0.3, 1.1, 2.3) * k;
            radius += amplitude
                * ((2.1 * q.x + 1.3 * q.y.sin()).sin()
                    + (1.9 * q.y + 1.1 * q.z.sin()).sin()
                    + (2.3 * q.z + 1.2 * q.x.sin()).sin());
        }
        radius * d
    })
}

/// A closed tube around a closed curve with the given number of turns of its frame; `circle(angle around)`.
fn tube(parts: usize, point: impl Fn(f64, f64) -> DVec3 + Send + Sync + Copy + 'static) -> PatchComplex {
    let mut net = PatchComplex::default();
    let around = 4;
    for i in 0..parts {
        for j in 0..around {
            net.add(move |s, t| {
                let u = ((i as f64 + s) / parts as f64).fract();
                let v = ((j as f64 + t) / around as f64).fract();
                point(TAU * u, TAU * v)
            });
        }
    }
    net
}

/// A torus of radii 1 and 0.4.
pub(super) fn torus() -> PatchComplex {
    tube(4, |u, v| {
        let radius = 1.0 + 0.4 * v.cos();
        dvec3(radius * u.cos(), radius * u.sin(), 0.4 * v.sin())
    })
}

/// A tube along a trefoil knot.
pub(super) fn trefoil() -> PatchComplex {
    tube(12, |u, v| {
        let centre = |u: f64| {
            let r = 2.0 + (3.0 * u).cos();
            dvec3(r * (2.0 * u).cos(), r * (2.0 * u).sin(), 1.2 * (3.0 * u).sin())
        };
        let tangent = (centre(u + 1e-4) - centre(u - 1e-4)).normalize();
        // The knot lies on a torus: the torus' centre circle gives a frame that closes up.
        let spoke = centre(u) - 2.0 * dvec3((2.0 * u).cos(), (2.0 * u).sin(), 0.0);
        let x = (spoke - spoke.dot(tangent) * tangent).normalize();
        let y = x.cross(tangent);
        centre(u) + 0.5 * (x * v.cos() + y * v.sin())
    })
}

/// An open half cylinder: one boundary loop with four corners.
pub(super) fn half_pipe() -> PatchComplex {
    let mut net = PatchComplex::default();
    net.add(|s, t| {
        let angle = PI * s;
        dvec3(angle.cos(), 3.0 * (t - 0.5), -angle.sin())
    });
    net
}
