//! Numbers in text files.

/// A decimal number, also as some exporters spell what is none: `nan`, `-nan(ind)`, `1.#QNAN`, `1.#INF`, and exponents
/// with `d`. `None` if it is no number at all.
pub(super) fn decimal(token: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(token).ok()?;
    text.parse().ok().or_else(|| odd_decimal(text))
}

fn odd_decimal(text: &str) -> Option<f64> {
    let lower = text.to_ascii_lowercase();
    let unsigned = lower.trim_start_matches(['+', '-']);
    if unsigned.starts_with("nan") || unsigned.starts_with("1.#") {
        return Some(f64::NAN);
    }
    lower.replace('d', "e").parse().ok().filter(|_| unsigned.starts_with(|c: char| c.is_ascii_digit() || c == '.'))
}

/// A signed integer with nothing behind it.
pub(super) fn integer(token: &[u8]) -> Option<i64> {
    let (negative, digits) = match token {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    if digits.is_empty() || digits.len() > 18 {
        return None;
    }
    let mut value = 0i64;
    for &digit in digits {
        if !digit.is_ascii_digit() {
            return None;
        }
        value = 10 * value + i64::from(digit - b'0');
    }
    Some(if negative { -value } else { value })
}

/// The words of a line or file, split at white space.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odd_numbers_are_numbers() {
        assert_eq!(decimal(b"-1.5E+3"), Some(-1500.0));
        assert_eq!(decimal(b".5"), Some(0.5));
        assert_eq!(decimal(b"+2."), Some(2.0));
        assert_eq!(decimal(b"1.25D-02"), Some(0.0125));
        for nan in [b"nan".as_slice(), b"-NaN", b"-nan(ind)", b"1.#QNAN", b"-1.#IND"] {
            assert!(decimal(nan).unwrap().is_nan());
        }
        for none in [b"".as_slice(), b"x", b"1,5", b"d5", b"0x10", b"--1", b"\xff"] {
            assert_eq!(decimal(none), None);
        }
        assert_eq!(integer(b"-12"), Some(-12));
        for none in [b"".as_slice(), b"-", b"1.0", b"99999999999999999999", b"1/2"] {
            assert_eq!(integer(none), None);
        }
    }
}
