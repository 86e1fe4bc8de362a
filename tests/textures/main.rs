//! Compressed pictures: KTX 2.0 files, what is transcoded from them, and what a GPU shows of them.
//!
//! The files beside this one were encoded by Binomial's `basisu`; each PNG is what its transcoder decodes, mip levels below each
//! other.

#[path = "../common/mod.rs"]
mod common;

#[allow(dead_code, reason = "other tests use the rest")]
#[path = "../common/gltf_build.rs"]
mod gltf_build;

mod bad;
mod files;
mod gltf;
mod gpu;
mod ktx;

use ktx2::Format;
use ontile::scene::{Image, Stored, Texels, TextureFormat};

/// Name, file, what Binomial's transcoder makes of it, levels.
const BASIS: [(&str, &[u8], &[u8], u32); 4] = [
    ("UASTC, Zstandard", include_bytes!("uastc.ktx2"), include_bytes!("uastc.png"), 6),
    ("UASTC, opaque", include_bytes!("uastc_opaque.ktx2"), include_bytes!("uastc_opaque.png"), 1),
    ("ETC1S", include_bytes!("etc1s.ktx2"), include_bytes!("etc1s.png"), 6),
    ("ETC1S with alpha", include_bytes!("etc1s_alpha.ktx2"), include_bytes!("etc1s_alpha.png"), 6),
];

fn read(name: &str, file: &[u8]) -> Image {
    Image::from_ktx2(name, file).unwrap_or_else(|problem| panic!("{name} {problem}"))
}

fn stored(image: &Image) -> &Stored {
    match &image.texels {
        Texels::Stored(stored) => stored,
        Texels::Rgba8(_) => panic!("{} is not compressed", image.name),
    }
}

fn halved(size: [u32; 2], level: u32) -> [u32; 2] {
    size.map(|n| (n >> level).max(1))
}

/// The format of a file, sRGB-encoded.
fn ktx_format(format: TextureFormat) -> Format {
    match format {
        TextureFormat::Rgba8 => Format::R8G8B8A8_SRGB,
        TextureFormat::Bc1 => Format::BC1_RGB_SRGB_BLOCK,
        TextureFormat::Bc1Alpha => Format::BC1_RGBA_SRGB_BLOCK,
        TextureFormat::Bc3 => Format::BC3_SRGB_BLOCK,
        TextureFormat::Bc7 => Format::BC7_SRGB_BLOCK,
        TextureFormat::Etc2 => Format::ETC2_R8G8B8_SRGB_BLOCK,
        TextureFormat::Etc2Mask => Format::ETC2_R8G8B8A1_SRGB_BLOCK,
        TextureFormat::Etc2Alpha => Format::ETC2_R8G8B8A8_SRGB_BLOCK,
        TextureFormat::Astc(block) => {
            let [width, height] = block.size();
            let name = format!("ASTC_{width}x{height}_SRGB_BLOCK");
            *Format::ALL.iter().find(|known| format!("{known:?}") == name).expect("all 14 are known")
        }
    }
}

/// Blocks of a level: noise, of which any is a valid block, or for ASTC one colour.
fn blocks(format: TextureFormat, size: [u32; 2], seed: u8) -> Vec<u8> {
    let count = format.level_bytes(size) as usize;
    if let TextureFormat::Astc(_) = format {
        // Void extent without coordinates, four channels of 16 bits (Khronos Data Format 1.3, 23.22).
        let color = [0xcc, 0xcc, 0x40, 0x40, 0x80 + seed, 0x80 + seed, 0xff, 0xff];
        let block = [[0xfc, 0xfd, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff], color].concat();
        return block.into_iter().cycle().take(count).collect();
    }
    let mut state = u64::from(seed) ^ 0x9e37_79b9_7f4a_7c15;
    (0..count).map(|_| random(&mut state)).collect()
}

/// A byte of Knuth's MMIX generator.
fn random(state: &mut u64) -> u8 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 56) as u8
}
