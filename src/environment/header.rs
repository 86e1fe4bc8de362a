//! What is wrong with pictures that the decoders refuse, in words that tell what to do.

use image::ImageError;

use super::panorama::{MAX_WIDTH, size_problem};

/// How Radiance files start.
pub const RADIANCE: &[u8] = b"#?RADIANCE";

/// The one encoding that is read: red, green and blue with a shared exponent.
const RGBE: &str = "32-bit_rle_rgbe";

const COMPLETE: &str = "give a complete .hdr or .exr file";
const TOP_DOWN: &str =
    "save it with rows from the top and texels from the left, which .hdr files write as '-Y height +X width'";

/// Where, what, and what to do.
type Problem = (String, String, &'static str);

/// Looks at the header of a Radiance file: lines up to an empty one, then the size (Ward, "Real Pixels", Graphics Gems II).
pub fn check(bytes: &[u8]) -> Result<(), Problem> {
    let problem = |text: String, remedy| Err(("header".to_owned(), text, remedy));
    let mut lines = bytes.split_inclusive(|&b| b == b'\n').map(|line| line.strip_suffix(b"\n"));
    loop {
        match lines.next() {
            Some(Some(b"")) => break,
            Some(Some(line)) => {
                if let Some(format) =
                    line.strip_prefix(b"FORMAT=").filter(|f| f.trim_ascii() != RGBE.as_bytes())
                {
                    let text = format!("says FORMAT={}, but only {RGBE} is read", shown(format));
                    return problem(text, "save it with colours in RGB (RGBE)");
                }
            }
            Some(None) | None => {
                return problem("ends before the picture: the file is cut off".into(), COMPLETE);
            }
        }
    }
    let Some(Some(line)) = lines.next() else {
        return problem("ends before the picture: the file is cut off".into(), COMPLETE);
    };
    let text = String::from_utf8_lossy(line);
    let words: Vec<_> = text.split_ascii_whitespace().collect();
    let ["-Y", height, "+X", width] = words[..] else {
        return problem(format!("says '{}' for the picture's size and direction", shown(line)), TOP_DOWN);
    };
    match (width.parse(), height.parse()) {
        (Ok(width), Ok(height)) => size_problem(width, height).map_or(Ok(()), Err),
        _ => problem(format!("says '{}' for the picture's size", shown(line)), "export the picture again"),
    }
}

/// The start of what a file says.
fn shown(bytes: &[u8]) -> String {
    String::from_utf8_lossy(&bytes[..bytes.len().min(60)]).into_owned()
}

/// What a decoder says, and what to do.
pub fn undecodable(error: &ImageError) -> (String, String) {
    let said = error.to_string();
    let remedy = match error {
        _ if said.contains("rgb channels") => {
            "save it with the channels R, G and B in one layer that is not deep".into()
        }
        ImageError::Limits(_) => format!("scale it down to at most {MAX_WIDTH} columns"),
        _ if said.contains("window size") => format!("give a picture of at most {MAX_WIDTH} columns"),
        ImageError::Unsupported(_) => "save it as a plain .hdr or .exr picture in RGB".into(),
        _ => COMPLETE.into(),
    };
    (format!("cannot be decoded: {said}"), remedy)
}
