//! Quads at seams of texture coordinates.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::engine::attributes::QuadAttributes;
use crate::engine::attributes::tests::{Vertices, carried, grid, quads, soup, tube};

fn assert_uv(made: &QuadAttributes, expected: &[Vec<(DVec3, [f32; 2])>]) {
    assert_eq!(made.uv.len(), expected.len());
    for (q, (made, expected)) in made.uv.iter().zip(expected).enumerate() {
        for (a, &(p, b)) in made.iter().zip(expected) {
            assert!((a[0] - b[0]).abs() < 1e-5 && (a[1] - b[1]).abs() < 1e-5, "{q} at {p}: {a:?} instead of {b:?}");
        }
    }
}

#[test]
fn corners_on_a_seam_are_on_the_side_of_their_quad() {
    let input = tube(36, 9, 0.0);
    for vertices in [Vertices::Shared, Vertices::OfTheirOwn] {
        // Quads much smaller, larger and as large as the faces, with corners on the seam.
        for (columns, rows) in [(12, 4), (36, 9), (4, 3)] {
            let cells = tube(columns, rows, 0.0);
            assert_uv(&carried(&soup(&input, vertices), &quads(&cells)), &cells);
        }
    }
}

#[test]
fn no_quad_stretches_across_a_seam() {
    for turned in [0.5, 0.1, 0.93] {
        let made = carried(&soup(&tube(36, 9, 0.0), Vertices::Shared), &quads(&tube(12, 4, turned)));
        let mut total = 0.0;
        for uv in &made.uv {
            let (low, high) = uv.iter().fold((f32::MAX, f32::MIN), |(l, h), uv| (l.min(uv[0]), h.max(uv[0])));
            assert!(high - low < 1.01 / 12.0, "{uv:?}");
            total += high - low;
        }
        // Only the four quads on the seam lose what lies on the other side of it.
        assert!(total > 4.0 * (1.0 - 0.6 / 12.0) && total < 4.01, "{total}");
    }
}

#[test]
fn a_seam_that_ends_inside_is_no_way_around() {
    // A disc in polar coordinates; the seam goes from the boundary to the centre.
    let disc = |sectors: u32, radii: &'static [f64]| {
        let at = move |i: u32, j: u32| {
            let angle = TAU * f64::from(j % sectors) / f64::from(sectors);
            radii[i as usize] * DVec3::new(angle.cos(), angle.sin(), 0.0)
        };
        grid(radii.len() as u32 - 1, sectors, at, move |i, j| [j as f32 / sectors as f32, radii[i as usize] as f32])
    };
    let mut input = disc(64, &[0.05, 0.1, 0.2, 0.4, 0.7, 1.0]);
    for k in 0..64u32 {
        let at = |k: u32| {
            let angle = TAU * f64::from(k % 64) / 64.0;
            0.05 * DVec3::new(angle.cos(), angle.sin(), 0.0)
        };
        let uv = |k: u32| [k as f32 / 64.0, 0.05];
        input.push(vec![(DVec3::ZERO, [(k as f32 + 0.5) / 64.0, 0.0]), (at(k), uv(k)), (at(k + 1), uv(k + 1))]);
    }
    let cells = disc(8, &[0.1, 1.0]);
    assert_uv(&carried(&soup(&input, Vertices::Shared), &quads(&cells)), &cells);
    assert_uv(&carried(&soup(&input, Vertices::OfTheirOwn), &quads(&cells)), &cells);
}
