//! How half meta-edges run in the plane (`[tong_2006]` section 3.1).

/// How a half meta-edge runs in the chart of its meta-face: quarter turns from +u, so 0 to 3 are u, v, −u, −v.
pub(super) type Tag = u8;

const NAMES: [&str; 4] = ["u", "v", "-u", "-v"];

/// The name of a tag.
pub(super) fn name(tag: Tag) -> &'static str {
    NAMES[usize::from(tag & 3)]
}

/// The tag of a name.
pub(super) fn of_name(name: &str) -> Option<Tag> {
    NAMES.iter().position(|known| *known == name).map(|tag| tag as Tag)
}
