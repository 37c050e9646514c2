//! The container of binary glTF: a header, a chunk of JSON, a chunk of bytes.

use super::error::ReadError;

const GLB: &str = "GLB";
/// Kinds of chunks.
const JSON: u32 = 0x4E4F_534A;
const BIN: u32 = 0x004E_4942;

/// The chunks of a GLB.
#[derive(Debug)]
pub(super) struct Chunks<'a> {
    /// The JSON chunk.
    pub(super) json: &'a [u8],
    /// The binary chunk.
    pub(super) bin: Option<&'a [u8]>,
}

/// Bytes by which a length may be wrong: some writers count the padding to four bytes and leave it out, or the reverse.
const PADDING: usize = 3;

/// Takes a GLB apart. Lengths that are wrong by no more than the padding are read as they are meant; nothing is read
/// behind the end of the file.
///
/// # Errors
/// With the byte where header and bytes disagree.
pub(super) fn open(bytes: &[u8]) -> Result<Chunks<'_>, ReadError> {
    let version = word(bytes, 4)?;
    if version != 2 {
        return Err(ReadError::byte(GLB, 4, format!("glTF version {version}; only version 2 is read")));
    }
    let length = word(bytes, 8)? as usize;
    if length > bytes.len() + PADDING {
        let cause = format!("truncated: the header says {length} bytes, there are {}", bytes.len());
        return Err(ReadError::byte(GLB, 8, cause));
    }
    let mut chunks = Chunks { json: &[], bin: None };
    let mut at = 12;
    while at < length.min(bytes.len()) {
        let (size, kind) = (word(bytes, at)? as usize, word(bytes, at + 4)?);
        let start = at + 8;
        if size > bytes.len() - start + PADDING {
            let cause = format!("truncated: a chunk of {size} bytes does not fit into {}", bytes.len());
            return Err(ReadError::byte(GLB, at, cause));
        }
        let (end, next) = ends(bytes, start, size);
        let body = &bytes[start..end.min(bytes.len())];
        match kind {
            JSON if at == 12 => chunks.json = body,
            BIN if chunks.bin.is_none() => chunks.bin = Some(body),
            _ if at == 12 => return Err(ReadError::byte(GLB, 16, "the first chunk is not JSON")),
            _ => {}
        }
        at = next;
    }
    Ok(chunks)
}

/// Where a chunk ends and where the next one begins: behind the padding, unless the binary chunk is found where it would
/// be if the padding were missing, or missing but counted.
fn ends(bytes: &[u8], start: usize, size: usize) -> (usize, usize) {
    let (end, padded) = (start + size, start + size.next_multiple_of(4));
    let is_binary = |at: usize| word(bytes, at + 4) == Ok(BIN);
    let moved = || (1..=PADDING.min(size)).map(|missing| end - missing).find(|&at| is_binary(at));
    match () {
        () if is_binary(padded) => (end, padded),
        () if is_binary(end) => (end, end),
        () => moved().map_or((end, padded), |at| (at, at)),
    }
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

    /// A GLB whose chunks say these sizes and are followed by this much padding.
    fn odd(sizes: [u32; 2], padding: [usize; 2]) -> Vec<u8> {
        let chunk = |size: u32, kind: u32, body: &[u8], padding: usize| {
            [&size.to_le_bytes(), &kind.to_le_bytes(), body, &b"   "[..padding]].concat()
        };
        let body =
            [chunk(sizes[0], JSON, b"{\"a\":1}", padding[0]), chunk(sizes[1], BIN, &[7; 6], padding[1])].concat();
        [b"glTF\x02\0\0\0", (12 + body.len() as u32).to_le_bytes().as_slice(), &body].concat()
    }

    #[test]
    fn padding_may_be_missing_or_counted_or_both() {
        // The JSON has 7 bytes, the rest 6.
        for (sizes, padding) in [
            ([7, 6], [1, 2]),
            ([8, 8], [1, 2]),
            ([7, 6], [0, 0]),
            ([8, 8], [0, 0]),
            ([8, 6], [0, 2]),
            ([7, 8], [1, 0]),
            ([10, 6], [3, 0]),
        ] {
            let glb = odd(sizes, padding);
            let chunks = open(&glb).unwrap();
            assert_eq!(chunks.json.trim_ascii_end(), b"{\"a\":1}", "{sizes:?} {padding:?}");
            assert_eq!(chunks.bin.map(|bin| &bin[..6]), Some([7; 6].as_slice()), "{sizes:?} {padding:?}");
        }
        let mut counted = odd([8, 8], [1, 0]);
        let length = counted.len() as u32 + 2;
        counted[8..12].copy_from_slice(&length.to_le_bytes());
        assert_eq!(open(&counted).unwrap().bin, Some([7; 6].as_slice()));
    }

    #[test]
    fn every_truncation_is_told() {
        let glb = write(&serde_json::json!({"a": 1}), vec![1, 2, 3]);
        for end in 0..glb.len() - PADDING {
            assert!(open(&glb[..end]).unwrap_err().to_string().contains("truncated"), "{end}");
        }
        let mut lie = glb.clone();
        lie[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(open(&lie).is_err());
    }
}
