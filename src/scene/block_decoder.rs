//! Blocks to RGBA8: for devices that have not the format, and for the reference.

use basisu::astc::{decode::decode_block_ldr8, unpack::unpack_block};
use texture2ddecoder as etc2;

use super::TextureFormat;

/// What ASTC demands of blocks that are none (Khronos Data Format 1.3, 23.25).
const ERROR: [u8; 4] = [255, 0, 255, 255];

/// The texels of the largest block.
const MOST: usize = 12 * 12;

/// One level to RGBA8, rows tightly packed. `content` is as long as the size demands.
pub fn decode(format: TextureFormat, content: &[u8], [width, height]: [u32; 2]) -> Vec<u8> {
    let [across, down] = format.block();
    let mut out = vec![0; width as usize * height as usize * 4];
    let mut block = [[0; 4]; MOST];
    let blocks_across = width.div_ceil(across);
    for (i, bytes) in (0..).zip(content.chunks_exact(format.block_bytes() as usize)) {
        decode_block(format, bytes, &mut block);
        let [left, top] = [i % blocks_across * across, i / blocks_across * down];
        let row_bytes = (across.min(width - left) * 4) as usize;
        for y in 0..down.min(height - top) {
            let texels = block[(y * across) as usize..].as_flattened();
            let start = ((top + y) * width + left) as usize * 4;
            out[start..start + row_bytes].copy_from_slice(&texels[..row_bytes]);
        }
    }
    out
}

/// The block's texels, row by row.
fn decode_block(format: TextureFormat, bytes: &[u8], out: &mut [[u8; 4]; MOST]) {
    use TextureFormat as T;
    const PITCH: usize = 16;
    let mut words = [0; 16];
    match format {
        T::Rgba8 => out[0] = [bytes[0], bytes[1], bytes[2], bytes[3]],
        T::Bc1 | T::Bc1Alpha => bcdec_rs::bc1(bytes, out.as_flattened_mut(), PITCH),
        T::Bc3 => bcdec_rs::bc3(bytes, out.as_flattened_mut(), PITCH),
        T::Bc7 => bcdec_rs::bc7(bytes, out.as_flattened_mut(), PITCH),
        T::Etc2 => etc2::decode_etc2_rgb_block(bytes, &mut words),
        T::Etc2Mask => etc2::decode_etc2_rgba1_block(bytes, &mut words),
        T::Etc2Alpha => etc2::decode_etc2_rgba8_block(bytes, &mut words),
        T::Astc(block) => {
            let [width, height] = block.size();
            let texels = bytes
                .try_into()
                .ok()
                .and_then(|bytes| unpack_block(bytes, width, height))
                .and_then(|block| decode_block_ldr8(&block, width, height, true, out));
            if texels.is_none() {
                out.fill(ERROR);
            }
        }
    }
    match format {
        // Words of blue, green, red, alpha from the lowest byte.
        T::Etc2 | T::Etc2Mask | T::Etc2Alpha => {
            for (texel, word) in out.iter_mut().zip(words) {
                let [blue, green, red, alpha] = word.to_le_bytes();
                // What is cut out is black (Khronos Data Format 1.3, 21.1).
                let is_cut = format == T::Etc2Mask && alpha == 0;
                *texel = if is_cut { [0; 4] } else { [red, green, blue, alpha] };
            }
        }
        // The decoder gives the one code of no alpha; without alpha it is black.
        T::Bc1 => out.iter_mut().for_each(|texel| texel[3] = 255),
        _ => {}
    }
}
