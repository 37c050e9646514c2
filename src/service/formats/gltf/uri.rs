//! Where buffers come from: data URIs, and files beside the glTF. There is no other way out of here.

use std::borrow::Cow;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::general_purpose::GeneralPurpose;
use base64::engine::{DecodePaddingMode, GeneralPurposeConfig};

use super::super::beside::Beside;
use super::super::error::ReadError;
use super::fault::malformed;

/// The bytes behind a URI, at most `limit` of them.
pub(super) fn load(uri: &str, beside: &dyn Beside, place: &str, limit: u64) -> Result<Vec<u8>, ReadError> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (kind, data) = data.split_once(',').ok_or_else(|| malformed(place, "a data URI without a comma"))?;
        if kind.ends_with(";base64") {
            let config = GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
            let decoded = GeneralPurpose::new(&STANDARD, config).decode(data);
            return decoded.map_err(|error| malformed(place, format!("a data URI that is not base64: {error}")));
        }
        return Ok(percent_decoded(data).into_owned());
    }
    let missing = || ReadError::MissingBuffer { uri: uri.chars().take(200).collect() };
    let path = percent_decoded(uri);
    let path = std::str::from_utf8(&path).map_err(|_| missing())?;
    let path = path.strip_prefix("./").unwrap_or(path);
    // A scheme, a root or a way up leads out of the folder.
    if path.contains([':', '\\']) || path.starts_with('/') || path.split('/').any(|part| part == "..") {
        return Err(missing());
    }
    beside.get(path, limit)?.ok_or_else(missing)
}

fn percent_decoded(text: &str) -> Cow<'_, [u8]> {
    if !text.contains('%') {
        return Cow::Borrowed(text.as_bytes());
    }
    let (bytes, mut out, mut i) = (text.as_bytes(), Vec::new(), 0);
    while i < bytes.len() {
        let hex = bytes.get(i + 1..i + 3).and_then(|hex| std::str::from_utf8(hex).ok());
        match hex.and_then(|hex| u8::from_str_radix(hex, 16).ok()).filter(|_| bytes[i] == b'%') {
            Some(byte) => {
                out.push(byte);
                i += 3;
            }
            None => {
                out.push(bytes[i]);
                i += 1;
            }
        }
    }
    Cow::Owned(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug)]
    struct OneFile;

    impl Beside for OneFile {
        fn get(&self, path: &str, _: u64) -> Result<Option<Vec<u8>>, ReadError> {
            Ok((path == "a b.bin").then(|| vec![7]))
        }
    }

    #[test]
    fn only_data_and_files_beside_are_loaded() {
        let load = |uri: &str| load(uri, &OneFile, "/buffers/0", 100);
        assert_eq!(load("data:application/octet-stream;base64,AQID").unwrap(), [1, 2, 3]);
        assert_eq!(load("data:;base64,AQI=").unwrap(), [1, 2]);
        assert_eq!(load("data:,a%00b%").unwrap(), b"a\0b%");
        assert_eq!(load("a%20b.bin").unwrap(), [7]);
        assert_eq!(load("./a b.bin").unwrap(), [7]);
        for outside in ["/a b.bin", "../a b.bin", "x/..%2fa b.bin", "file:///etc/passwd", "http://x/y", "C:\\a", "b"] {
            let uri = outside.to_owned();
            assert_eq!(load(outside).unwrap_err(), ReadError::MissingBuffer { uri });
        }
        assert!(load("data:;base64,****").unwrap_err().to_string().contains("/buffers/0"));
        assert!(load("data:;base64").is_err());
    }
}
