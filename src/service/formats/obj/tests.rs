use super::*;
use crate::engine::mesh::TriangleSoup;

fn read_text(text: &str) -> Result<TriangleSoup, ReadError> {
    read(text.as_bytes(), &ReadLimits::default()).map(|model| model.soup)
}

#[test]
fn polygons_of_any_degree_in_every_spelling() {
    let soup = read_text(
        "\u{feff}# comment\r\nmtllib x.mtl\no thing\nv 0 0 0 1.0\r\nv 1 0 0\nv 1 1 0 # corner\n\tv  0\t1e0 0\nv 0.5 2 0\n\
         vn 0 0 1\nvt 0 0\ng a b\ns 1\nf 1 2 3\nf -5// -4//1 -3/1/1 -2/1\nf 1 2 \\\r\n 3 \\\n5 4\nl 1 2\nf 1 2\nwhat is this\n",
    )
    .unwrap();
    assert_eq!(soup.positions.len(), 5);
    assert_eq!(soup.positions[3], DVec3::Y);
    let polygons: Vec<_> = soup.polygons().collect();
    assert_eq!(polygons, [[0, 1, 2].as_slice(), &[0, 1, 2, 3], &[0, 1, 2, 4, 3]]);
    assert_eq!(soup.dropped_by_reader, 1);
    assert!(soup.colours.is_empty() && soup.materials.is_empty());
}

#[test]
fn vertices_may_follow_faces_and_may_be_no_numbers() {
    let soup = read_text("f 1 2 3\nv 0 0 0\nv nan 0 0\nv 1.#QNAN inf 0").unwrap();
    assert_eq!(soup.polygon(0), [0, 1, 2]);
    assert!(soup.positions[1].x.is_nan() && soup.positions[2].y.is_infinite());
}

#[test]
fn old_line_ends() {
    assert_eq!(read_text("v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r").unwrap().n_polygons(), 1);
}

#[test]
fn colours_and_materials() {
    let text = "v 0 0 0\nv 1 0 0 1 0.5 0\nv 0 1 0 0 0 1\nf 1 2 3\nusemtl red paint \nf 3 2 1\nusemtl b\nf 1 2 3\nusemtl red paint\nf 1 2 3";
    let soup = read_text(text).unwrap();
    assert_eq!(soup.colours, [[1.0; 4], [1.0, 0.5, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]]);
    assert_eq!(soup.materials, [0, 1, 2, 1]);
    assert_eq!(soup.material_names, ["", "red paint", "b"]);
    let bytes = read_text("v 0 0 0 255 0 0\nv 1 0 0 0 0 51\nv 0 1 0\nf 1 2 3").unwrap();
    assert_eq!(bytes.colours[1], [0.0, 0.0, 0.2, 1.0]);
    assert_eq!(bytes.colours[2], [1.0; 4]);
}

#[test]
fn objects_have_names() {
    let read = |text: &str| read(text.as_bytes(), &ReadLimits::default()).unwrap();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let model =
        read(&format!("{triangle}o left arm \r\nf 1 2 3\no empty\no right\nf 1 2 3\nf 3 2 1\no left arm\nf 1 2 3\n"));
    let names: Vec<_> = model.scene.objects.iter().map(|name| name.node.as_str()).collect();
    assert_eq!((names, model.soup.objects), (vec!["", "left arm", "right"], vec![0, 1, 2, 2, 1]));
    // One alone needs no numbers, and one without a name is none.
    let model = read(&format!("o a\n{triangle}o a\nf 1 2 3\no b\n"));
    assert_eq!((model.scene.objects, model.soup.objects), (vec![ObjectName::new("a", "a")], vec![]));
    for nothing in [triangle.to_owned(), format!("o \n{triangle}"), format!("o\n{triangle}o  \nf 1 2 3\n")] {
        let model = read(&nothing);
        assert!(model.scene.objects.is_empty() && model.soup.objects.is_empty());
    }
}

#[test]
fn texture_coordinates_belong_to_corners() {
    let text =
        "vt 0.25 1\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1/1 2//1 3/-1/1\nf 1/7 2\nf 3 2/2/3 1/9\nvt 0.5\nf 1 2 3";
    let soup = read_text(text).unwrap();
    let (none, one, two) = ([0.0; 2], [0.25, 1.0], [0.5, 0.0]);
    let expected = [none, none, none, one, none, one, none, two, none, none, none, none];
    assert_eq!((soup.n_polygons(), soup.uv), (4, expected.to_vec()));
    assert!(read_text("vt 0 0\nv 0 0 0\nf 1/3 1/x 1/0").unwrap().uv.is_empty());
    assert_eq!(read_text("vt nan x\nv 0 0 0\nf 1/1 1/1 1/1").unwrap().uv, [none; 3]);
}

#[test]
fn normals_belong_to_corners() {
    let soup = read_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2/5/-1 3\nf 3//2 2 1/1\nvn 1 0 x").unwrap();
    let (none, z) = ([0.0; 3], [0.0, 0.0, 1.0]);
    assert_eq!(soup.normals, [z, z, none, [1.0, 0.0, 0.0], none, none]);
    assert!(soup.uv.is_empty());
}

#[test]
fn bad_lines_are_named() {
    let place = |text: &str| read_text(text).unwrap_err().to_string();
    assert!(place("v 0 0\n").starts_with("OBJ, line 1: a vertex with 2"));
    assert!(place("v 0 0 0\n\nv 0 x 0\n").starts_with("OBJ, line 3: \"x\""));
    assert!(place("v 0 0 0\nf 1 1 a\n").contains("line 2"));
    assert!(place("v 0 0 0\nf 1 1 1\nf 1 2 1\n").contains("line 3: index 2"));
    assert!(place("v 0 0 0\nf 1 0 1\n").contains("index 0"));
    assert!(place("v 0 0 0\nf 1 -2 1\n").contains("index -2"));
    assert!(place("v 0 0 0\nf 1 1 4294967297\n").contains("index 4294967297"));
    assert_eq!(read_text("v 0 0 0\n").unwrap_err(), ReadError::Empty { format: "OBJ" });
}

#[test]
fn limits_hold() {
    let few = ReadLimits { max_vertices: 2, ..ReadLimits::default() };
    let error = read(b"v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3", &few).unwrap_err();
    assert_eq!(error, ReadError::TooLarge { what: "vertices", claimed: 3, limit: 2 });
    let few = ReadLimits { max_polygons: 1, ..ReadLimits::default() };
    let error = read(b"v 0 0 0\nf 1 1 1 1", &few).unwrap_err();
    assert_eq!(error, ReadError::TooLarge { what: "triangles", claimed: 2, limit: 1 });
}
