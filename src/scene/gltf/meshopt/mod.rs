//! KHR_meshopt_compression and EXT_meshopt_compression: buffer views that hold their bytes in codes of their own.
//!
//! The older extension is the newer one without version 1 of the codec of attributes and without the filter of colours; what says
//! that it is the older and has them is read all the same.

mod attributes;
mod filters;
mod indices;
#[cfg(test)]
mod tests;

use gltf::json::{self, Index};
use serde::Deserialize;

/// The extension of a buffer view.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Compressed {
    /// What has the codes.
    pub buffer: Index<json::Buffer>,
    #[serde(default)]
    pub byte_offset: u64,
    pub byte_length: u64,
    byte_stride: u64,
    count: u64,
    mode: String,
    filter: Option<String>,
}

/// Field of the extension, and what is wrong with it.
pub type Problem = (&'static str, String);

impl Compressed {
    /// The `byte_length` bytes of the view that `codes` stand for.
    pub fn decode(&self, codes: &[u8], byte_length: u64) -> Result<Vec<u8>, Problem> {
        let (count, stride) = self.shape(byte_length)?;
        let filter = self.filter.as_deref().unwrap_or("NONE");
        let data = |problem: String| ("byteLength", problem);
        let mut bytes = match self.mode.as_str() {
            "ATTRIBUTES" => attributes::decode(codes, count, stride).map_err(data)?,
            "TRIANGLES" => indices::decode_triangles(codes, count, stride).map_err(data)?,
            _ => indices::decode_sequence(codes, count, stride).map_err(data)?,
        };
        match filter {
            "OCTAHEDRAL" => filters::octahedral(&mut bytes, stride),
            "QUATERNION" => filters::quaternion(&mut bytes),
            "EXPONENTIAL" => filters::exponential(&mut bytes),
            "COLOR" => filters::color(&mut bytes, stride),
            _ => {}
        }
        Ok(bytes)
    }

    /// Count and stride, once they are what modes and filters allow.
    fn shape(&self, byte_length: u64) -> Result<(usize, usize), Problem> {
        let (count, stride) = (self.count, self.byte_stride);
        let strides: &[u64] = match (self.mode.as_str(), self.filter.as_deref().unwrap_or("NONE")) {
            ("ATTRIBUTES", "NONE" | "EXPONENTIAL") => &[],
            ("ATTRIBUTES", "OCTAHEDRAL" | "COLOR") => &[4, 8],
            ("ATTRIBUTES", "QUATERNION") => &[8],
            ("TRIANGLES" | "INDICES", "NONE") => &[2, 4],
            ("ATTRIBUTES" | "TRIANGLES" | "INDICES", filter) => {
                let mode = &self.mode;
                return Err((
                    "filter",
                    format!("'{}' is none that {mode} has", super::source::shortened(filter)),
                ));
            }
            (mode, _) => {
                let mode = super::source::shortened(mode);
                return Err(("mode", format!("'{mode}' is not ATTRIBUTES, TRIANGLES or INDICES")));
            }
        };
        let fits = match strides {
            [] => stride % 4 == 0 && (4..=256).contains(&stride),
            some => some.contains(&stride),
        };
        if !fits {
            let allowed = match strides {
                [] => "a multiple of 4 from 4 to 256".into(),
                some => format!("one of {some:?}"),
            };
            return Err(("byteStride", format!("is {stride}, not {allowed}")));
        }
        if count == 0 || self.mode == "TRIANGLES" && count % 3 != 0 {
            return Err(("count", format!("is {count}, which is no number of {}", self.mode)));
        }
        match count.checked_mul(stride) {
            Some(bytes) if bytes == byte_length => Ok((count as usize, stride as usize)),
            _ => Err((
                "count",
                format!("is {count} elements of {stride} bytes, but the view has {byte_length} bytes"),
            )),
        }
    }
}

/// Codes that are still to be read.
struct Codes<'a>(&'a [u8]);

impl<'a> Codes<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or("ends within the data")?;
        self.0 = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> Result<u8, String> {
        let (&byte, rest) = self.0.split_first().ok_or("ends within the data")?;
        self.0 = rest;
        Ok(byte)
    }

    /// After the last element nothing may be left.
    fn end(&self) -> Result<(), String> {
        match self.0.len() {
            0 => Ok(()),
            left => Err(format!("has {left} bytes that no element uses")),
        }
    }
}

/// The first byte says what follows.
fn header(codes: &[u8], known: &[u8]) -> Result<u8, String> {
    match codes.first() {
        Some(byte) if known.contains(byte) => Ok(*byte),
        Some(byte) => Err(format!("has data that begins with {byte:#04x}, not {known:#04x?}")),
        None => Err("is 0".into()),
    }
}
