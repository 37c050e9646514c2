use super::*;

const VERTICES: &str = "element vertex 4\nproperty uchar red\nproperty double z\nproperty list uchar short extra\n\
    property float x\nproperty uchar blue\nproperty float y\nproperty uchar green\n";

fn header(encoding: &str, rest: &str) -> String {
    format!("ply\nformat {encoding} 1.0\ncomment x\nobj_info y\n{rest}end_header\n")
}

fn read_bytes(bytes: &[u8]) -> Result<TriangleSoup, ReadError> {
    read(bytes, &ReadLimits::default())
}

fn binary(big: bool) -> Vec<u8> {
    let faces = "element other 2\nproperty int a\nelement face 2\nproperty float quality\nproperty list uint ushort vertex_index\n";
    let name = if big { "binary_big_endian" } else { "binary_little_endian" };
    let mut bytes = header(name, &format!("{VERTICES}{faces}")).into_bytes();
    let mut push = |value: &[u8]| {
        let mut value = value.to_vec();
        if big {
            value.reverse();
        }
        bytes.extend(value);
    };
    for [x, y, z] in [[0.0, 0.0, 0.5f32], [1.0, 0.0, 0.5], [1.0, 1.0, 0.5], [0.0, 1.0, 0.5]] {
        push(&[255]);
        push(&f64::from(z).to_le_bytes());
        push(&[2]);
        push(&7i16.to_le_bytes());
        push(&(-7i16).to_le_bytes());
        push(&x.to_le_bytes());
        push(&[0]);
        push(&y.to_le_bytes());
        push(&[51]);
    }
    push(&1i32.to_le_bytes());
    push(&2i32.to_le_bytes());
    for corners in [[0u16, 1, 2, 3].as_slice(), &[2, 1, 0]] {
        push(&1f32.to_le_bytes());
        push(&(corners.len() as u32).to_le_bytes());
        corners.iter().for_each(|c| push(&c.to_le_bytes()));
    }
    bytes
}

fn check(soup: &TriangleSoup) {
    let z = 0.5;
    let square = [[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]];
    assert_eq!(soup.positions, square.map(DVec3::from_array));
    assert_eq!(soup.polygons().collect::<Vec<_>>(), [[0, 1, 2, 3].as_slice(), &[2, 1, 0]]);
    assert_eq!(soup.colours, [[1.0, 0.2, 0.0, 1.0]; 4]);
}

#[test]
fn every_encoding_and_order_of_properties() {
    check(&read_bytes(&binary(false)).unwrap());
    check(&read_bytes(&binary(true)).unwrap());
    let faces = "element face 2\nproperty list uchar int vertex_indices\n";
    let body = "255 0.5 0 0 0 0 51\n255 0.5 1 9 1 0 0 51\n255 .5 0 1 0 1 51 255 0.5 0 0 0 1 51\n4 0 1 2 3\n3 2 1 0";
    check(&read_bytes(format!("{}{body}", header("ascii", &format!("{VERTICES}{faces}"))).as_bytes()).unwrap());
}

#[test]
fn strips_are_triangles() {
    let text = header(
        "ascii",
        "element vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
         element tristrips 1\nproperty list int int vertex_indices\n",
    ) + "0 0 0 1 0 0 0 1 0 1 1 0 0 2 0\n9 0 1 2 3 -1 2 3 4 4";
    let soup = read_bytes(text.as_bytes()).unwrap();
    assert_eq!(soup.polygons().collect::<Vec<_>>(), [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
    assert_eq!(soup.dropped_by_reader, 1);
}

#[test]
fn every_truncation_is_told() {
    let bytes = binary(false);
    for end in 0..bytes.len() {
        assert!(read_bytes(&bytes[..end]).is_err(), "{end}");
    }
}

#[test]
fn claims_are_judged_before_reading() {
    let xyz = "property float x\nproperty float y\nproperty float z\n";
    let claim = |count: &str, encoding: &str| {
        let faces = "element face 1\nproperty list uchar int vertex_indices\n";
        let text = header(encoding, &format!("element vertex {count}\n{xyz}{faces}"));
        read_bytes(text.as_bytes()).unwrap_err()
    };
    assert_eq!(
        claim("4000000000", "ascii"),
        ReadError::TooLarge { what: "vertices", claimed: 4_000_000_000, limit: 20_000_000 }
    );
    assert!(claim("19000000", "binary_big_endian").to_string().contains("truncated"));
    assert!(claim("-1", "ascii").to_string().contains("line 5"));
    let idle = header("ascii", "element nothing 18446744073709551615\nelement face 0\nproperty int a\n");
    assert_eq!(read_bytes(idle.as_bytes()).unwrap_err(), ReadError::Empty { format: "PLY" });
}

#[test]
fn faults_have_a_place() {
    let text = |body: &str| {
        let xyz = "property float x\nproperty float y\nproperty float z\n";
        let faces = "element face 1\nproperty list char int vertex_indices\n";
        header("ascii", &format!("element vertex 1\n{xyz}{faces}")) + body
    };
    let fault = |body: &str| read_bytes(text(body).as_bytes()).unwrap_err().to_string();
    let start = text("").len();
    assert_eq!(
        fault("0 0 0 3 0 1 0"),
        format!("PLY, byte {}: index 1 is out of range, there are 1 vertices", start + 9)
    );
    assert_eq!(fault("0 0 0 3 0 -1 0").matches("index -1").count(), 1);
    assert!(fault("0 x 0 3 0 0 0").contains(&format!("byte {}: \"x\"", start + 2)));
    assert!(fault("0 0 0 -3 0 0 0").contains("list of length -3"));
    assert!(fault("0 0 0 3 0 0").contains("truncated"));
}
