//! Names that downloads are saved under: `duck.quads.obj` for a job on `duck.glb`.

use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};

use crate::service::store::JobRow;

/// What stands for itself in an extended parameter (RFC 8187).
const ENCODED: &AsciiSet = &NON_ALPHANUMERIC.remove(b'-').remove(b'.').remove(b'_').remove(b'~');

/// What a browser does with a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Disposition {
    /// Saves it.
    Attachment,
    /// Shows it.
    Inline,
}

/// The name of a file of a job, after its input, or after the job where the input has no name.
pub(super) fn file_name(job: &JobRow, artefact: &str) -> String {
    let suffix = match artefact.split_once('.') {
        Some(("quad-mesh", ending)) => format!("quads.{ending}"),
        Some(("parameterisation", ending)) => format!("uv.{ending}"),
        Some(("preview" | "archive", ending)) => ending.to_owned(),
        _ => artefact.to_owned(),
    };
    let name = job.input.name.as_deref().unwrap_or_default();
    match name.rsplit_once('.').map_or(name, |(stem, _)| stem) {
        "" => format!("{}.{suffix}", job.id),
        stem => format!("{stem}.{suffix}"),
    }
}

/// The value of `Content-Disposition` (RFC 6266). Clients that do not know the encoded name get one in plain ASCII.
pub(super) fn content_disposition(disposition: Disposition, name: &str) -> String {
    let kind = match disposition {
        Disposition::Attachment => "attachment",
        Disposition::Inline => "inline",
    };
    // Quotes, escapes, folders and what Windows does not take.
    let plain = |c: char| (c == ' ' || c.is_ascii_graphic()) && !"\"\\%/:*?<>|".contains(c);
    let ascii: String = name.chars().map(|c| if plain(c) { c } else { '_' }).collect();
    if ascii == name {
        return format!("{kind}; filename=\"{name}\"");
    }
    format!("{kind}; filename=\"{ascii}\"; filename*=UTF-8''{}", utf8_percent_encode(name, ENCODED))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_outside_ascii_are_encoded_and_cannot_break_out() {
        let attachment = |name| content_disposition(Disposition::Attachment, name);
        assert_eq!(attachment("my duck.quads.obj"), "attachment; filename=\"my duck.quads.obj\"");
        assert_eq!(
            attachment("Büste.quads.obj"),
            "attachment; filename=\"B_ste.quads.obj\"; filename*=UTF-8''B%C3%BCste.quads.obj"
        );
        assert_eq!(attachment("a\"; x=\"b"), "attachment; filename=\"a_; x=_b\"; filename*=UTF-8''a%22%3B%20x%3D%22b");
        assert!(!attachment("a\r\nb").contains(['\r', '\n']));
    }
}
