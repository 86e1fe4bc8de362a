//! PNG, JPEG and WebP into RGBA8; KTX 2.0 stays as it is.

use std::borrow::Cow;
use std::io::Cursor;

use ::image::{ImageDecoder, ImageFormat, ImageReader, Limits};
use rayon::prelude::*;

use super::document::{Document, MAX_TEXELS};
use super::source;
use crate::Result;
use crate::scene::Image;
use crate::scene::ktx::MAX_SIDE;

/// An image file is not believed to be larger.
const MAX_FILE_BYTES: u64 = 1 << 30;

/// Decodes the glTF images with these indices.
pub fn decode_all(doc: &Document, indices: &[usize]) -> Result<Vec<Image>> {
    let mut encoded = Vec::with_capacity(indices.len());
    let mut texels = 0;
    for &index in indices {
        let bytes = encoded_bytes(doc, index)?;
        let (width, height) = dimensions(&bytes).map_err(|problem| undecodable(doc, index, problem))?;
        texels += u64::from(width) * u64::from(height);
        if texels > MAX_TEXELS {
            let problem = format!("brings the scene's images to more than {MAX_TEXELS} texels");
            return Err(doc.bad(format!("images[{index}]"), problem, "make the images smaller"));
        }
        encoded.push(bytes);
    }
    let decoded: Vec<_> = encoded.par_iter().map(|bytes| decode(bytes)).collect();
    let images = indices.iter().zip(decoded).map(|(&index, decoded)| {
        let image = decoded.map_err(|problem| undecodable(doc, index, problem))?;
        let json = &doc.root.images[index];
        let name = json.name.clone().or_else(|| json.uri.clone().filter(|uri| !uri.starts_with("data:")));
        Ok(Image { name: name.unwrap_or_else(|| format!("image {index}")), ..image })
    });
    images.collect()
}

fn undecodable(doc: &Document, index: usize, problem: String) -> crate::Error {
    let remedy = format!("store it as a PNG, JPEG, WebP or KTX2 of at most {MAX_SIDE} texels a side");
    doc.bad(format!("images[{index}]"), problem, remedy)
}

/// The image file, from wherever it is.
pub fn encoded_bytes<'a>(doc: &'a Document, index: usize) -> Result<Cow<'a, [u8]>> {
    let image = &doc.root.images[index];
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) => {
            let element = format!("images[{index}].uri");
            source::read_uri(doc.path, &element, uri, MAX_FILE_BYTES).map(Cow::Owned)
        }
        (None, Some(view)) => doc.view(view, &format!("images[{index}].bufferView")).map(Cow::Borrowed),
        (None, None) => {
            let remedy = "give the image one of them";
            Err(doc.bad(format!("images[{index}]"), "has neither uri nor bufferView", remedy))
        }
    }
}

fn decoder(bytes: &[u8]) -> Result<impl ImageDecoder, String> {
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string())?;
    if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP)) {
        return Err("is neither PNG nor JPEG nor WebP nor KTX2".into());
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    // Sixteen bits in four channels, and as much again for the decoder's own buffers.
    limits.max_alloc = Some(u64::from(MAX_SIDE) * u64::from(MAX_SIDE) * 8 * 2);
    reader.limits(limits);
    reader.into_decoder().map_err(|e| format!("cannot be decoded: {e}"))
}

fn dimensions(bytes: &[u8]) -> Result<(u32, u32), String> {
    let (width, height) = match bytes.starts_with(&ktx2::MAGIC) {
        true => {
            let header =
                ktx2::Reader::new(bytes).map_err(|e| format!("is a damaged KTX file: {e}"))?.header();
            (header.pixel_width, header.pixel_height)
        }
        false => decoder(bytes)?.dimensions(),
    };
    match width.min(height) {
        0 => Err("has no texels".into()),
        _ if width.max(height) > MAX_SIDE => Err(format!("is {width} x {height} texels")),
        _ => Ok((width, height)),
    }
}

fn decode(bytes: &[u8]) -> Result<Image, String> {
    if bytes.starts_with(&ktx2::MAGIC) {
        return Image::from_ktx2("", bytes);
    }
    let image = ::image::DynamicImage::from_decoder(decoder(bytes)?)
        .map_err(|e| format!("cannot be decoded: {e}"))?;
    let rgba = image.into_rgba8();
    let name = String::new();
    Ok(Image { name, width: rgba.width(), height: rgba.height(), texels: rgba.into_raw().into() })
}
