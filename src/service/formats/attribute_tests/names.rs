//! Names of objects, joints and materials.

use super::*;

#[test]
fn names_and_skins_are_in_the_files_that_can_hold_them() {
    let (mesh, attributes, scene) = rigged();
    for format in QuadFormat::ALL {
        let bytes = write_model(&mesh, &attributes, &scene, format);
        assert_same_quads(&read_quads(&bytes, format).unwrap(), &mesh);
        if format == QuadFormat::Ply {
            assert_eq!(bytes, write_quads(&mesh, &attributes, format));
        }
    }
    let read = |format: QuadFormat| {
        let bytes = write_model(&mesh, &attributes, &scene, format);
        read_model(&bytes, Format::from_extension(format.extension()), &Alone, &ReadLimits::default()).unwrap()
    };
    let glb = read(QuadFormat::Glb);
    assert_eq!((&glb.scene.objects, &glb.scene.skeleton), (&scene.objects, &scene.skeleton));
    assert_eq!(glb.soup.skin, attributes.skin);
    let mut expected: Vec<_> = mesh.quads.iter().zip(&attributes.objects).map(|(q, &o)| (sorted(q), o)).collect();
    let mut made: Vec<_> = glb.soup.polygons().zip(&glb.soup.objects).map(|(q, &o)| (sorted(q), o)).collect();
    expected.sort_unstable();
    made.sort_unstable();
    assert_eq!(made, expected);
    // One component is one object of an OBJ.
    let obj = read(QuadFormat::Obj);
    assert_eq!(
        (obj.scene.objects.as_slice(), obj.soup.objects.len()),
        ([ObjectName::new("left leg", "left leg")].as_slice(), 0)
    );
    // Every object is a prim of USDA, and the vertices that two of them share are one again in the end.
    let text = String::from_utf8(write_model(&mesh, &attributes, &scene, QuadFormat::Usda)).unwrap();
    for line in
        ["def Mesh \"left_leg\" (", "displayName = \"left leg\"", "def Mesh \"right_leg\" (", "def Material \"_2nd\""]
    {
        assert_eq!(text.matches(line).count(), 1, "{line}");
    }
    let apart = text.replace("quadrille:vertices", "other");
    let apart = read_quads(apart.as_bytes(), QuadFormat::Usda).unwrap();
    assert!(apart.positions.len() > mesh.positions.len() && apart.quads.len() == mesh.quads.len());
    // Numbers of objects that the quads did not get mean nothing.
    let unknown = QuadAttributes { objects: Vec::new(), ..attributes.clone() };
    let text = String::from_utf8(write_model(&mesh, &unknown, &scene, QuadFormat::Obj)).unwrap();
    assert!(text.contains("\no component_1\n"));
}

#[test]
fn components_of_one_object_have_different_names() {
    let (one, n) = (cube(1), 8);
    let mut mesh = QuadMesh::default();
    for copy in 0..5 {
        mesh.positions.extend(&one.positions);
        mesh.quads.extend(one.quads.iter().map(|quad| quad.map(|v| v + copy * n)));
    }
    let objects = (0..30).map(|q| [0, 0, 1, 2, 0][q / 6]).collect();
    let attributes = QuadAttributes { objects, ..QuadAttributes::default() };
    let objects = ["arm", "arm_2", " \t"].map(|name| ObjectName::new(name, "")).to_vec();
    let scene = Scene { objects, ..Scene::default() };
    let text = String::from_utf8(write_model(&mesh, &attributes, &scene, QuadFormat::Obj)).unwrap();
    let names: Vec<_> = text.lines().filter_map(|line| line.strip_prefix("o ")).collect();
    assert_eq!(names, ["arm", "arm_2", "arm_2_2", "component_4", "arm_3"]);
    let single = Scene { objects: scene.objects[..1].to_vec(), ..Scene::default() };
    let text = String::from_utf8(write_model(&one, &QuadAttributes::default(), &single, QuadFormat::Obj)).unwrap();
    assert!(text.contains("\no arm\n"));
}

#[test]
fn names_of_materials_cannot_break_lines() {
    let (mesh, mut attributes) = painted();
    attributes.material_names = ["a\nf 1 1 1", "b\\", " \t", "\"\\"].map(str::to_owned).to_vec();
    for format in QuadFormat::ALL {
        assert_same_quads(&read_quads(&write_quads(&mesh, &attributes, format), format).unwrap(), &mesh);
    }
}
