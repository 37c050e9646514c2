//! The container of binary glTF: a header, a chunk of JSON, a chunk of bytes.

use super::error::ReadError;

const GLB: &str = "GLB";

/// The chunks of a GLB.
#[derive(Debug)]
pub(super) struct Chunks<'a> {
    /// The JSON chunk.
    pub(super) json: &'a [u8],
    /// The binary chunk.
    pub(super) bin: Option<&'a [u8]>,
}

/// Takes a GLB apart.
///
/// # Errors
/// With the byte where header and bytes disagree.
pub(super) fn open(bytes: &[u8]) -> Result<Chunks<'_>, ReadError> {
    let version = word(bytes, 4)?;
    if version != 2 {
        return Err(ReadError::byte(GLB, 4, format!("glTF version {version}; only version 2 is read")));
    }
    let length = word(bytes, 8)? as usize;
    let Some(bytes) = bytes.get(..length) else {
        let cause = format!("truncated: the header says {length} bytes, there are {}", bytes.len());
        return Err(ReadError::byte(GLB, 8, cause));
    };
    let mut chunks = Chunks { json: &[], bin: None };
    let mut at = 12;
    while at < length {
        let (size, kind) = (word(bytes, at)? as usize, word(bytes, at + 4)?);
        let body = at.checked_add(8 + size).and_then(|end| bytes.get(at + 8..end)).ok_or_else(|| {
            ReadError::byte(GLB, at, format!("truncated: a chunk of {size} bytes does not fit into {length}"))
        })?;
        match kind {
            0x4E4F_534A if at == 12 => chunks.json = body,
            0x004E_4942 if chunks.bin.is_none() => chunks.bin = Some(body),
            _ if at == 12 => return Err(ReadError::byte(GLB, 16, "the first chunk is not JSON")),
            _ => {}
        }
        at += 8 + size.next_multiple_of(4);
    }
    Ok(chunks)
}

fn word(bytes: &[u8], at: usize) -> Result<u32, ReadError> {
    let word = bytes.get(at..at + 4).and_then(|word| word.try_into().ok());
    word.map(u32::from_le_bytes).ok_or_else(|| ReadError::byte(GLB, bytes.len(), "truncated inside a header"))
}

/// Puts a GLB together. A GLB has at most 4 GiB, far more than the meshes that are made here.
pub(super) fn write(json: &serde_json::Value, mut bin: Vec<u8>) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    bin.resize(bin.len().next_multiple_of(4), 0);
    let bin_chunk = if bin.is_empty() { 0 } else { 8 + bin.len() };
    let size = |n: usize| u32::try_from(n).expect("meshes are limited to far less than 4 GiB").to_le_bytes();
    let mut out = Vec::with_capacity(20 + text.len() + bin_chunk);
    out.extend_from_slice(b"glTF\x02\0\0\0");
    out.extend_from_slice(&size(20 + text.len() + bin_chunk));
    out.extend_from_slice(&size(text.len()));
    out.extend_from_slice(b"JSON");
    out.extend_from_slice(&text);
    if !bin.is_empty() {
        out.extend_from_slice(&size(bin.len()));
        out.extend_from_slice(b"BIN\0");
        out.extend_from_slice(&bin);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_come_back_padded() {
        let glb = write(&serde_json::json!({"a": 1}), vec![1, 2, 3]);
        assert_eq!(glb.len() % 4, 0);
        let chunks = open(&glb).unwrap();
        assert_eq!((chunks.json, chunks.bin), (b"{\"a\":1} ".as_slice(), Some([1, 2, 3, 0].as_slice())));
    }

    #[test]
    fn every_truncation_is_told() {
        let glb = write(&serde_json::json!({"a": 1}), vec![1, 2, 3]);
        for end in 0..glb.len() {
            assert!(open(&glb[..end]).unwrap_err().to_string().contains("truncated"), "{end}");
        }
        let mut lie = glb.clone();
        lie[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(open(&lie).is_err());
    }
}
