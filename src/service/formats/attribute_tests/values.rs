//! Materials, colours, normals and texture coordinates, in every format that holds them.

use super::*;

#[test]
fn the_quads_of_every_format_are_the_same_with_attributes() {
    let (mesh, all) = painted();
    let some = [
        all.clone(),
        QuadAttributes { uv: all.uv.clone(), ..QuadAttributes::default() },
        QuadAttributes { uv: Vec::new(), ..all.clone() },
        QuadAttributes { normals: all.normals.clone(), ..QuadAttributes::default() },
        QuadAttributes { normals: Vec::new(), ..all.clone() },
        QuadAttributes { colours: all.colours.clone(), ..QuadAttributes::default() },
    ];
    for attributes in &some {
        for format in QuadFormat::ALL {
            let bytes = write_quads(&mesh, attributes, format);
            let made = read_quads(&bytes, format).unwrap_or_else(|error| panic!("{format:?}: {error}"));
            assert_same_quads(&made, &mesh);
            assert_eq!(bytes, write_quads(&mesh, attributes, format));
            for (a, b) in made.positions.iter().zip(&mesh.positions) {
                assert_eq!(*a, if format == QuadFormat::Glb { b.as_vec3().as_dvec3() } else { *b });
            }
        }
    }
}

#[test]
fn obj_and_glb_hold_materials_colours_normals_and_texture_coordinates() {
    let (mesh, attributes) = painted();
    for format in [QuadFormat::Obj, QuadFormat::Glb] {
        let soup = read_back(&write_quads(&mesh, &attributes, format), format);
        let found = attributes_by_quad(&soup);
        for (q, quad) in mesh.quads.iter().enumerate() {
            let mut key = quad.to_vec();
            key.sort_unstable();
            let (name, uv, normals) = &found[&key];
            let expected = attributes.material_names[attributes.materials[q] as usize].as_str();
            let expected = match format {
                QuadFormat::Obj => {
                    match expected {
                        "" => "default",
                        // Without its space it would be the name of another.
                        "2nd " => "2nd_2",
                        name => name,
                    }
                }
                _ => expected,
            };
            assert_eq!(name.as_deref(), Some(expected), "{format:?}");
            for (k, &v) in quad.iter().enumerate() {
                let (a, b) = (uv[&v], attributes.uv[q][k]);
                assert!((a[0] - b[0]).abs() == 0.0 && (a[1] - b[1]).abs() < 1e-6, "{format:?}: {a:?}, {b:?}");
                assert_eq!(normals[&v], attributes.normals[q][k], "{format:?}");
            }
        }
        for (made, colour) in soup.colours.iter().zip(&attributes.colours) {
            let alpha = if format == QuadFormat::Obj { 1.0 } else { colour[3] };
            assert_eq!(*made, [colour[0], colour[1], colour[2], alpha], "{format:?}");
        }
        assert_eq!(soup.colours.len(), mesh.positions.len());
    }
}

#[test]
fn ply_holds_colours_as_bytes() {
    let (mesh, attributes) = painted();
    let soup = read_back(&write_quads(&mesh, &attributes, QuadFormat::Ply), QuadFormat::Ply);
    assert_eq!(soup.colours.len(), mesh.positions.len());
    for (made, colour) in soup.colours.iter().flatten().zip(attributes.colours.iter().flatten()) {
        assert!((made - colour).abs() <= 0.5001 / 255.0);
    }
    assert!(soup.uv.is_empty() && soup.materials.is_empty());
}

#[test]
fn usda_holds_primvars_and_subsets() {
    let (mesh, attributes) = painted();
    let text = String::from_utf8(write_quads(&mesh, &attributes, QuadFormat::Usda)).unwrap();
    let list = |line: &str| line.split_once("= [").unwrap().1.split(']').next().unwrap().to_owned();
    let line =
        |name: &str| text.lines().find(|line| line.trim_start().starts_with(name)).unwrap_or_else(|| panic!("{name}"));
    for name in ["texCoord2f[] primvars:st", "normal3f[] normals"] {
        assert_eq!(list(line(name)).split("), (").count(), 4 * mesh.quads.len());
    }
    assert_eq!(list(line("color3f[] primvars:displayColor")).split("), (").count(), mesh.positions.len());
    assert_eq!(list(line("float[] primvars:displayOpacity")).split(", ").count(), mesh.positions.len());
    let subsets: Vec<Vec<usize>> = text
        .lines()
        .filter(|line| line.trim_start().starts_with("int[] indices"))
        .map(|line| list(line).split(", ").map(|q| q.parse().unwrap()).collect())
        .collect();
    // The quads of the material without a name are in no subset.
    let of = |m: u32| (0..mesh.quads.len()).filter(|&q| attributes.materials[q] == m).collect::<Vec<_>>();
    assert_eq!(subsets, [of(0), of(2), of(3)]);
    for name in ["paint__old_", "_2nd", "_2nd_"] {
        assert!(
            text.contains(&format!("def GeomSubset \"{name}\"")) && text.contains(&format!("def Material \"{name}\""))
        );
        assert!(text.contains(&format!("rel material:binding = </quads/materials/{name}>")));
    }
}
