//! Appending text to bytes.

use std::fmt::Arguments;
use std::io::Write as _;

/// Appends text.
pub(super) fn push(out: &mut Vec<u8>, text: Arguments<'_>) {
    out.write_fmt(text).expect("writing to memory cannot fail");
}

/// Appends a line.
pub(super) fn push_line(out: &mut Vec<u8>, text: Arguments<'_>) {
    push(out, text);
    out.push(b'\n');
}
