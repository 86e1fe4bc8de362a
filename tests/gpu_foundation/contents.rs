//! What is uploaded arrives, byte for byte.

use super::*;
use glam::{Vec2, Vec3};

#[test]
fn buffers_hold_what_was_uploaded_in_pieces() {
    let Some(gpu) = Gpu::new() else { return };
    let device = gpu.device();
    // More than two staging chunks of 8 MiB, at an odd offset in units of 4 bytes.
    let content = noise((20 << 20) + 12, 7);
    let buffer = storage_buffer(device, content.len() as u64 + 100, MemoryUse::Readback).unwrap();
    let mut upload = Upload::new(device);
    upload.buffer(&buffer, 0, &[0xee; 100]).unwrap();
    upload.buffer(&buffer, 100, &content).unwrap();
    Commands::run(device, "upload", |r| {
        upload.record(r);
        Ok(())
    })
    .unwrap();
    assert!(upload.staged_bytes() >= content.len() as u64);
    // The queue was waited for with a fence, and the memory is coherent.
    assert_eq!(buffer.mapped()[..100], [0xee; 100]);
    assert!(buffer.mapped()[100..] == content[..], "the content differs");

    // A second upload through the same gatherer overwrites a part only.
    upload.buffer(&buffer, 4, &[1; 8]).unwrap();
    Commands::run(device, "upload", |r| {
        upload.record(r);
        Ok(())
    })
    .unwrap();
    assert_eq!(
        buffer.mapped()[..16],
        [0xee, 0xee, 0xee, 0xee, 1, 1, 1, 1, 1, 1, 1, 1, 0xee, 0xee, 0xee, 0xee]
    );
    drop((upload, buffer));
    gpu.finish();
}

/// Levels of a texture as an independent computation has them: doubles, straight from the definition, for
/// sizes that halve evenly.
fn mip_chain_f64(image: &scene::Image, srgb: bool) -> Vec<Vec<f64>> {
    let decode = |v: f64| if v > 0.04045 { ((v + 0.055) / 1.055).powf(2.4) } else { v / 12.92 };
    let encode = |v: f64| if v > 0.0031308 { 1.055 * v.powf(1.0 / 2.4) - 0.055 } else { v * 12.92 };
    let is_curved = |i: usize| srgb && i % 4 != 3;
    let mut size = [image.width as usize, image.height as usize];
    let unit = image.rgba8().iter().map(|&b| f64::from(b) / 255.0);
    let mut texels: Vec<f64> =
        unit.enumerate().map(|(i, v)| if is_curved(i) { decode(v) } else { v }).collect();
    let mut levels = Vec::new();
    loop {
        let encoded = texels.iter().enumerate();
        levels.push(encoded.map(|(i, &v)| 255.0 * if is_curved(i) { encode(v) } else { v }).collect());
        if size == [1, 1] {
            return levels;
        }
        let half = size.map(|n| (n / 2).max(1));
        let [step_x, step_y] = [size[0] / half[0], size[1] / half[1]];
        let mut next = vec![0.0; half[0] * half[1] * 4];
        for (i, sum) in next.iter_mut().enumerate() {
            let (x, y, channel) = (i / 4 % half[0], i / 4 / half[0], i % 4);
            for (dx, dy) in (0..step_x).flat_map(|dx| (0..step_y).map(move |dy| (dx, dy))) {
                *sum += texels[((y * step_y + dy) * size[0] + x * step_x + dx) * 4 + channel];
            }
            *sum /= (step_x * step_y) as f64;
        }
        (texels, size) = (next, half);
    }
}

#[test]
fn textures_and_their_mips_arrive() {
    let Some(gpu) = Gpu::new() else { return };
    let device = gpu.device();
    // 2048 x 1100 is larger than a staging chunk, and odd from its third level on.
    let images = [picture(64, 16, 1), picture(2048, 1100, 2)];
    let mipped = scene::Sampler::default();
    let base_only = scene::Sampler { mip_linear: None, ..mipped };
    let texture = |image, sampler| scene::Texture { image, sampler };
    let textures = [texture(0, mipped), texture(0, base_only), texture(1, base_only), texture(1, mipped)];
    let key = |texture, encoding| TextureKey { texture, encoding };
    use ColorEncoding::{Linear, Srgb};
    let wanted = [key(0, Srgb), key(1, Srgb), key(0, Linear), key(2, Srgb), key(3, Linear)];
    let mut upload = Upload::new(device);
    let all = Textures::new(device, &mut upload, &images, &textures, &wanted, None).unwrap();
    Commands::run(device, "upload", |r| {
        upload.record(r);
        Ok(())
    })
    .unwrap();
    drop(upload);

    // Rounding to a byte is off by half at most; the rest is the f32 arithmetic's.
    const ROUNDING: f64 = 0.5 + 1e-3;
    for (encoding, srgb) in [(Srgb, true), (Linear, false)] {
        let image = all.image(0, encoding).unwrap();
        let expected = mip_chain_f64(&images[0], srgb);
        assert_eq!(image.levels() as usize, expected.len());
        assert_eq!(level_of(device, image, 0), images[0].rgba8(), "level 0 is the picture");
        for (level, expected) in (0..).zip(&expected) {
            let texels = level_of(device, image, level);
            assert_eq!(texels.len(), expected.len());
            for (&byte, e) in texels.iter().zip(expected) {
                assert!(
                    (f64::from(byte) - e).abs() <= ROUNDING,
                    "{encoding:?} level {level}: {byte} for {e}"
                );
            }
        }
    }
    // A mip chain only where a sampler uses one.
    assert_eq!(all.image(1, Srgb).unwrap().levels(), 1);
    let large = all.image(1, Linear).unwrap();
    // 2048, 1024, ..., 1.
    assert_eq!(large.levels(), 12);
    assert!(level_of(device, large, 0) == images[1].rgba8(), "a picture cut into pieces arrives whole");

    // One image, two views: all levels, and level 0 alone.
    let (with_mips, without) = (all.get(wanted[0]).unwrap(), all.get(wanted[1]).unwrap());
    assert_ne!(with_mips.0, without.0);
    assert_eq!(all.get(key(3, Srgb)), None, "what was not wanted is not there");

    let unknown = Textures::new(device, &mut Upload::new(device), &images, &textures, &[key(9, Srgb)], None);
    assert!(unknown.unwrap_err().to_string().contains("texture 9"));
    drop(all);
    gpu.finish();
}

#[test]
fn geometry_arrives_where_its_offsets_say() {
    let Some(gpu) = Gpu::new() else { return };
    let device = gpu.device();
    let point = |i: usize| Vec3::new(i as f32, 0.5, -(i as f32));
    let mesh = |n: usize, indices: &[u32]| scene::Mesh {
        positions: (0..n).map(point).collect(),
        normals: vec![Vec3::Z; n],
        texcoords: [(0..n).map(|i| Vec2::new(i as f32, 2.0)).collect(), vec![]],
        indices: indices.to_vec(),
        ..Default::default()
    };
    let meshes = [mesh(3, &[0, 1, 2]), mesh(70_000, &[0, 69_999, 5]), mesh(4, &[3, 2, 1])];
    let textured = Streams { normals: true, texcoords: [true, false], ..Default::default() };
    let streams = [textured, Streams::default(), textured].map(Some);
    let mut upload = Upload::new(device);
    let geometry = Geometry::new(device, &mut upload, &meshes, &streams).unwrap();
    Commands::run(device, "upload", |r| {
        upload.record(r);
        Ok(())
    })
    .unwrap();
    let vertices = bytes_of(device, geometry.vertices().unwrap());
    let indices = bytes_of(device, geometry.indices().unwrap());
    // Nothing but what was asked for: positions alone for the second mesh.
    assert_eq!(vertices.len(), 70_000 * 12 + (3 + 4) * (12 + 12 + 8));
    assert_eq!(indices.len(), 6 * 2 + 3 * 4);
    let floats = |at: u64, count: usize| -> Vec<f32> {
        let bytes = &vertices[at as usize..][..count * 4];
        bytes.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
    };
    // What a draw would fetch for the mesh's vertex `i` from the streams bound at its group's offsets.
    for (mesh, range) in meshes.iter().zip(geometry.meshes()) {
        let group = &geometry.groups()[range.group];
        for i in [0, mesh.positions.len() - 1] {
            let vertex = range.vertex_offset as u64 + i as u64;
            assert_eq!(floats(group.offsets_bytes[0] + vertex * 12, 3), mesh.positions[i].to_array());
            if group.streams.normals {
                assert_eq!(floats(group.offsets_bytes[1] + vertex * 12, 3), mesh.normals[i].to_array());
                assert_eq!(floats(group.offsets_bytes[2] + vertex * 8, 2), mesh.texcoords[0][i].to_array());
            }
        }
        let size = if mesh.positions.len() > 65_535 { 4 } else { 2 };
        let start =
            geometry.index_offset_bytes(range.index_width) as usize + range.first_index as usize * size;
        let fetched = indices[start..][..range.index_count as usize * size].chunks(size);
        let fetched: Vec<u32> =
            fetched.map(|b| b.iter().rev().fold(0, |n, &byte| n << 8 | u32::from(byte))).collect();
        assert_eq!(fetched, mesh.indices);
    }
    let none = Geometry::new(device, &mut upload, &[], &[]).unwrap();
    assert!(none.vertices().is_none() && none.indices().is_none());
    drop((geometry, none, upload));
    gpu.finish();
}
