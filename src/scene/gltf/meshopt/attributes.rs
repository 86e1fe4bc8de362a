//! Mode 0: elements as differences from the ones before, byte by byte (KHR_meshopt_compression, appendix A).

use super::{Codes, header};

/// Bit widths of the groups' differences, by what a group's two bits say.
const WIDTHS_V0: [usize; 4] = [0, 2, 4, 8];
const WIDTHS_V1: [[usize; 4]; 2] = [[0, 1, 2, 4], [1, 2, 4, 8]];

/// How differences of four bytes are meant.
#[derive(Clone, Copy)]
enum Channel {
    Bytes,
    Shorts,
    /// An exclusive or, rotated right by so many bits, since the encoder rotates left.
    Xor(u32),
}

pub fn decode(codes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, String> {
    let is_v1 = header(codes, &[0xa0, 0xa1])? == 0xa1;
    let codes = &codes[1..];
    let (tail_len, least) = if is_v1 { (stride + stride / 4, 24) } else { (stride, 32) };
    let body_len = codes.len().checked_sub(tail_len.max(least)).ok_or("is too short for the last element")?;
    let tail = &codes[codes.len() - tail_len..];
    let (mut last, channels) = (tail[..stride].to_vec(), &tail[stride..]);
    let channels: Vec<Channel> = match is_v1 {
        true => channels.iter().map(|&c| channel(c)).collect::<Result<_, _>>()?,
        false => vec![Channel::Bytes; stride / 4],
    };

    let block_len = ((8192 / stride) & !15).min(256);
    // Every block has headers, without which no room is made for it.
    let headers = count.div_ceil(block_len) * if is_v1 { stride / 4 } else { stride };
    if headers > body_len {
        return Err(format!("is too short for {count} elements of {stride} bytes"));
    }
    let mut body = Codes(&codes[..body_len]);
    let mut deltas = vec![0; stride * block_len];
    let mut out = vec![0; count * stride];
    for block in out.chunks_mut(block_len * stride) {
        let len = block.len() / stride;
        read_deltas(&mut body, is_v1, len, &mut deltas, block_len)?;
        for (i, &channel) in channels.iter().enumerate() {
            let planes: [&[u8]; 4] = std::array::from_fn(|k| &deltas[(i * 4 + k) * block_len..][..len]);
            let last = &mut last[i * 4..i * 4 + 4];
            let mut value = [last[0], last[1], last[2], last[3]];
            for (j, element) in block.chunks_exact_mut(stride).enumerate() {
                value = next(channel, value, planes.map(|plane| plane[j]));
                element[i * 4..i * 4 + 4].copy_from_slice(&value);
            }
            last.copy_from_slice(&value);
        }
    }
    body.end()?;
    Ok(out)
}

fn channel(code: u8) -> Result<Channel, String> {
    match (code & 15, code >> 4) {
        (0, 0) => Ok(Channel::Bytes),
        (1, 0) => Ok(Channel::Shorts),
        (2, bits) => Ok(Channel::Xor(u32::from(bits))),
        _ => Err(format!("has a channel of unknown mode {code:#04x}")),
    }
}

fn next(channel: Channel, value: [u8; 4], delta: [u8; 4]) -> [u8; 4] {
    match channel {
        Channel::Bytes => {
            std::array::from_fn(|i| value[i].wrapping_add(delta[i] >> 1 ^ (delta[i] & 1).wrapping_neg()))
        }
        Channel::Shorts => {
            let sum = |i: usize| {
                let [value, delta] = [value, delta].map(|of| u16::from_le_bytes([of[i], of[i + 1]]));
                value.wrapping_add(delta >> 1 ^ (delta & 1).wrapping_neg()).to_le_bytes()
            };
            let ([a, b], [c, d]) = (sum(0), sum(2));
            [a, b, c, d]
        }
        Channel::Xor(bits) => {
            (u32::from_le_bytes(value) ^ u32::from_le_bytes(delta).rotate_right(bits)).to_le_bytes()
        }
    }
}

/// The differences of a block of `len` elements: for each byte of an element a plane of `plane_len`.
fn read_deltas(
    body: &mut Codes,
    is_v1: bool,
    len: usize,
    deltas: &mut [u8],
    plane_len: usize,
) -> Result<(), String> {
    let stride = deltas.len() / plane_len;
    let control = if is_v1 { body.take(stride / 4)? } else { &[] };
    for (k, plane) in deltas.chunks_exact_mut(plane_len).enumerate() {
        let widths = match control.get(k / 4).map(|byte| byte >> (k % 4 * 2) & 3) {
            None => WIDTHS_V0,
            Some(2) => {
                plane.fill(0);
                continue;
            }
            Some(3) => {
                plane[..len].copy_from_slice(body.take(len)?);
                continue;
            }
            Some(mode) => WIDTHS_V1[usize::from(mode)],
        };
        let groups = len.div_ceil(16);
        let header = body.take(groups.div_ceil(4))?;
        for (i, group) in plane.chunks_exact_mut(16).take(groups).enumerate() {
            read_group(body, widths[usize::from(header[i / 4] >> (i % 4 * 2) & 3)], group)?;
        }
    }
    Ok(())
}

/// Sixteen differences of so many bits; all of them set say that a byte follows.
fn read_group(body: &mut Codes, width: usize, group: &mut [u8]) -> Result<(), String> {
    match width {
        0 => group.fill(0),
        8 => group.copy_from_slice(body.take(16)?),
        _ => {
            let packed = body.take(width * 2)?;
            let most = (1 << width) - 1;
            for (i, delta) in group.iter_mut().enumerate() {
                let at = i * width;
                let shift = if width == 1 { at % 8 } else { 8 - width - at % 8 };
                let small = packed[at / 8] >> shift & most;
                *delta = if small == most { body.byte()? } else { small };
            }
        }
    }
    Ok(())
}
