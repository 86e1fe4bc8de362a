//! Bytes: the GLB container, files beside the main one, and data URIs.

use std::fs;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use base64::Engine;
use base64::alphabet;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use crate::{Error, Result};

/// Padding may be left out: some exporters do.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

const EXPORT_AGAIN: &str = "export the file again";

/// The two parts of a glTF file.
pub struct Container {
    pub json: Vec<u8>,
    /// The BIN chunk of a GLB.
    pub bin: Option<Vec<u8>>,
}

/// Reads `path`, which may be a GLB or plain JSON (told apart by the first bytes, not by the name).
pub fn read_container(path: &Path) -> Result<Container> {
    let is_file = fs::metadata(path).map_err(|e| Error::io(path, "read", e))?.is_file();
    if !is_file {
        return Err(Error::input(path, "file", "is not a regular file", "name a .gltf or .glb file"));
    }
    let bytes = fs::read(path).map_err(|e| Error::io(path, "read", e))?;
    if bytes.starts_with(b"glTF") {
        split_glb(path, &bytes)
    } else {
        let json = bytes.strip_prefix(b"\xEF\xBB\xBF").map(<[u8]>::to_vec).unwrap_or(bytes);
        Ok(Container { json, bin: None })
    }
}

/// glTF 2.0 section 4.4: a 12-byte header, then chunks of length, type and data.
fn split_glb(path: &Path, bytes: &[u8]) -> Result<Container> {
    let bad = |element: String, problem: String| Error::input(path, element, problem, EXPORT_AGAIN);
    let word = |at: usize| {
        let bytes = bytes.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?))
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(bad("GLB header".into(), format!("the file ends after {} of 12 bytes", bytes.len())));
    };
    if version != 2 {
        return Err(Error::input(
            path,
            "GLB header.version",
            format!("is {version}, but only 2 is known"),
            "convert the file to glTF 2.0",
        ));
    }
    let length = length as usize;
    if length > bytes.len() {
        let problem = format!("says {length} bytes, but the file has {}: it is truncated", bytes.len());
        return Err(bad("GLB header.length".into(), problem));
    }
    let (mut json, mut bin) = (None, None);
    let (mut at, mut index) = (12, 0);
    while at < length {
        let element = format!("GLB chunk {index}");
        let (Some(size), Some(kind)) = (word(at), word(at + 4)) else {
            return Err(bad(element, "its header is truncated".into()));
        };
        let end = (at + 8).checked_add(size as usize).filter(|&end| end <= length).ok_or_else(|| {
            bad(element.clone(), format!("says {size} bytes, but the file ends before: it is truncated"))
        })?;
        let data = &bytes[at + 8..end];
        match (&kind.to_le_bytes(), index) {
            (b"JSON", 0) => json = Some(data.to_vec()),
            (b"BIN\0", 1) => bin = Some(data.to_vec()),
            (_, 0) => return Err(bad(element, "is not the JSON chunk".into())),
            // Unknown chunks are to be ignored.
            _ => {}
        }
        (at, index) = (end, index + 1);
    }
    let json = json.ok_or_else(|| bad("GLB chunk 0".into(), "the JSON chunk is missing".into()))?;
    Ok(Container { json, bin })
}

/// The bytes that `uri` stands for: a data URI's content or a file's, relative to the folder of `path`.
///
/// At most `limit` bytes of a file are read.
pub fn read_uri(path: &Path, element: &str, uri: &str, limit: u64) -> Result<Vec<u8>> {
    let bad = |problem: String, remedy: &str| Error::input(path, element, problem, remedy);
    if uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:")) {
        return decode_data_uri(&uri[5..]).map_err(|problem| bad(problem, EXPORT_AGAIN));
    }
    let file = beside(path, uri).map_err(|problem| bad(problem, "put the file beside the glTF file"))?;
    let missing = |e: std::io::Error| {
        bad(format!("cannot read {}: {e}", file.display()), "put the file there or correct the URI")
    };
    if !fs::metadata(&file).map_err(missing)?.is_file() {
        return Err(bad(format!("{} is not a regular file", file.display()), "correct the URI"));
    }
    let mut bytes = Vec::new();
    fs::File::open(&file).and_then(|f| f.take(limit).read_to_end(&mut bytes)).map_err(missing)?;
    Ok(bytes)
}

/// RFC 2397: `[media type][;base64],content`, without the scheme.
fn decode_data_uri(rest: &str) -> Result<Vec<u8>, String> {
    let (head, content) = rest.split_once(',').ok_or("the data URI has no comma")?;
    let content = percent_decode(content)?;
    if head.to_ascii_lowercase().ends_with(";base64") {
        BASE64.decode(content).map_err(|e| format!("the data URI is not valid base64: {e}"))
    } else {
        Ok(content)
    }
}

/// As [`beside`], of a file in the folder of `path` or below: files that only this program reads have no reason to be elsewhere,
/// while glTF allows `../` for buffers and images.
pub fn below(path: &Path, uri: &str) -> Result<PathBuf, String> {
    let file = beside(path, uri)?;
    let within = file.strip_prefix(path.parent().unwrap_or(Path::new(""))).unwrap_or(&file);
    let mut depth = 0_i64;
    for part in within.components() {
        depth += if part == Component::ParentDir { -1 } else { i64::from(part != Component::CurDir) };
        if depth < 0 {
            return Err(format!("'{}' leaves the folder of the glTF file", shortened(uri)));
        }
    }
    Ok(file)
}

/// The file that a relative URI names.
pub fn beside(path: &Path, uri: &str) -> Result<PathBuf, String> {
    let scheme = uri.split_once(':').map(|(scheme, _)| scheme).filter(|s| !s.contains('/'));
    if scheme.is_some() || uri.starts_with("//") {
        return Err(format!(
            "'{}' is not a relative path; nothing is fetched from elsewhere",
            shortened(uri)
        ));
    }
    let decoded = String::from_utf8(percent_decode(uri)?)
        .map_err(|_| format!("'{}' is not UTF-8 once decoded", shortened(uri)))?;
    if decoded.is_empty() || Path::new(&decoded).is_absolute() {
        return Err(format!("'{}' is not a relative path", shortened(uri)));
    }
    Ok(path.parent().unwrap_or(Path::new("")).join(decoded))
}

/// RFC 3986 section 2.1.
fn percent_decode(text: &str) -> Result<Vec<u8>, String> {
    let mut out = Vec::with_capacity(text.len());
    let mut bytes = text.bytes();
    while let Some(byte) = bytes.next() {
        if byte != b'%' {
            out.push(byte);
            continue;
        }
        let digit = |b: Option<u8>| char::from(b?).to_digit(16);
        match (digit(bytes.next()), digit(bytes.next())) {
            (Some(high), Some(low)) => out.push((high * 16 + low) as u8),
            _ => return Err("the URI has a '%' without two hexadecimal digits".into()),
        }
    }
    Ok(out)
}

/// The start of a long text, for messages.
pub fn shortened(text: &str) -> String {
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.into(),
    }
}
