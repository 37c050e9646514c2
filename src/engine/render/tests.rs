use super::*;
use crate::engine::quad::QuadMesh;
use glam::{DVec3, dvec3};

/// A cube of n × n squares per side.
fn cube(n: u32) -> QuadMesh {
    let mut mesh = QuadMesh::default();
    let mut vertex = |p: DVec3| {
        let known = mesh.positions.iter().position(|q: &DVec3| q.distance(p) < 1e-9);
        known.unwrap_or_else(|| {
            mesh.positions.push(p);
            mesh.positions.len() - 1
        }) as u32
    };
    let mut quads = Vec::new();
    for (axis, side) in [(0, 1.0), (1, 1.0), (2, 1.0), (0, -1.0), (1, -1.0), (2, -1.0)] {
        let (u, w) = if side > 0.0 { ((axis + 1) % 3, (axis + 2) % 3) } else { ((axis + 2) % 3, (axis + 1) % 3) };
        for i in 0..n {
            for j in 0..n {
                quads.push([(0, 0), (1, 0), (1, 1), (0, 1)].map(|(a, b)| {
                    let mut p = DVec3::ZERO;
                    p[axis] = side;
                    p[u] = 2.0 * f64::from(i + a) / f64::from(n) - 1.0;
                    p[w] = 2.0 * f64::from(j + b) / f64::from(n) - 1.0;
                    vertex(p)
                }));
            }
        }
    }
    mesh.quads = quads;
    mesh
}

fn options(view: View) -> RenderOptions {
    RenderOptions { width: 200, height: 160, view, ..RenderOptions::default() }
}

fn pixel(image: &Image, x: usize, y: usize) -> [u8; 3] {
    let at = 4 * (y * image.width + x);
    [image.rgba[at], image.rgba[at + 1], image.rgba[at + 2]]
}

const FRONT: View = View::From { towards: DVec3::Z, up: DVec3::Y };

#[test]
fn a_square_side_fills_the_middle_and_keeps_its_shape() {
    let image = render_quads(&cube(4), &options(FRONT));
    assert_eq!((image.width, image.height, image.rgba.len()), (200, 160, 4 * 200 * 160));
    // The front side is a centred square; its outline is a crease: dark.
    let is_dark = |x: usize, y: usize| pixel(&image, x, y).iter().all(|&c| c < 150);
    let row: Vec<usize> = (0..200).filter(|&x| is_dark(x, 75)).collect();
    let column: Vec<usize> = (0..160).filter(|&y| is_dark(95, y)).collect();
    let extent = |list: &[usize]| (list[0], list[list.len() - 1]);
    let ((left, right), (top, bottom)) = (extent(&row), extent(&column));
    assert!((right - left).abs_diff(bottom - top) <= 2, "{left} {right} {top} {bottom}");
    assert!((left + right).abs_diff(199) <= 2 && (top + bottom).abs_diff(159) <= 2);
    // Background outside, bright surface within a quad.
    assert!(pixel(&image, 3, 3).iter().all(|&c| c > 225));
    assert!(pixel(&image, 100 - 18, 80 - 18).iter().all(|&c| c > 150));
}

#[test]
fn irregular_vertices_are_marked_in_their_colour() {
    let corner = View::From { towards: DVec3::ONE, up: DVec3::Y };
    let plain = render_quads(&cube(3), &RenderOptions { mark_irregular: false, ..options(corner) });
    let marked = render_quads(&cube(3), &options(corner));
    // All corners of a cube have valence 3: blue; nothing else of the picture is.
    let blue = |image: &Image| {
        let strong = |p: &[u8]| p[2] > 120 && p[2] / 2 > p[0].max(p[1] / 2);
        image.rgba.chunks(4).filter(|p| strong(p)).count()
    };
    assert_eq!(blue(&plain), 0);
    assert!(blue(&marked) > 7 * 6, "{}", blue(&marked));
    let differing = plain.rgba.chunks(4).zip(marked.rgba.chunks(4)).filter(|(p, q)| p != q).count();
    assert!(differing > 50 && differing < 200 * 160 / 10, "{differing}");
}

#[test]
fn what_is_hidden_is_not_seen() {
    let front = render_quads(&cube(3), &options(FRONT));
    let mut with_more = cube(3);
    let n = with_more.positions.len() as u32;
    with_more.positions.extend([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(x, y)| dvec3(x, y, 0.0)));
    with_more.quads.push([n, n + 1, n + 2, n + 3]);
    let other = render_quads(&with_more, &options(FRONT));
    assert_eq!(pixel(&front, 82, 62), pixel(&other, 82, 62));
    let alone = QuadMesh { quads: vec![[n, n + 1, n + 2, n + 3]], positions: with_more.positions };
    assert_ne!(render_quads(&alone, &options(FRONT)).rgba, other.rgba);
}

#[test]
fn pictures_are_repeatable_and_bad_meshes_are_drawn_as_far_as_possible() {
    let mut mesh = cube(5);
    let image = render_quads(&mesh, &options(View::Auto));
    assert_eq!(image, render_quads(&mesh, &options(View::Auto)));
    let used = mesh.positions.len();
    mesh.positions.push(DVec3::NAN);
    mesh.quads.push([0, 1, 2, used as u32]);
    mesh.quads.push([0, 1, 2, 9999]);
    assert_eq!(image, render_quads(&mesh, &options(View::Auto)));
    let empty = render_quads(&QuadMesh::default(), &options(View::Auto));
    assert!(empty.rgba.iter().all(|&c| c > 200));
}
