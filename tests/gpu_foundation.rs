//! The Vulkan foundation on whatever device is at hand, under the validation layer: contents arrive, failures unwind,
//! nothing leaks, and nothing is reported.

use ash::vk;
use glam::{Vec2, Vec3};
use ontile::Error;
use ontile::gpu::*;
use ontile::scene;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A device with validation, and the promise that it is silent and leaves nothing behind.
struct Gpu {
    headless: Headless,
    /// One device at a time: the layer's settings and lavapipe's threads are the process's.
    _alone: MutexGuard<'static, ()>,
}

static ALONE: Mutex<()> = Mutex::new(());

impl Gpu {
    fn new() -> Option<Self> {
        let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
        let options =
            HeadlessOptions { validate: true, application_name: "tests".into(), ..Default::default() };
        match Headless::new(&options) {
            Ok(headless) => Some(Self { headless, _alone: alone }),
            Err(e) => {
                println!("ignored: no Vulkan device with validation: {e}");
                None
            }
        }
    }

    fn device(&self) -> &Device {
        self.headless.device()
    }

    fn finish(self) {
        assert_eq!(self.device().live(), Live::default(), "objects are left");
        assert_eq!(self.headless.finish(), Vec::<String>::new());
    }

    /// As [`Self::finish`] where calls had to fail: best practices report each failed call.
    fn finish_after_failures(self) {
        assert_eq!(self.device().live(), Live::default(), "objects are left");
        let mut messages = self.headless.finish();
        messages.retain(|m| !m.contains("Error-Result"));
        assert_eq!(messages, Vec::<String>::new());
    }
}

/// Bytes that look random; a linear congruential generator (Knuth's MMIX constants).
fn noise(count: usize, seed: u64) -> Vec<u8> {
    let mut state = seed;
    (0..count)
        .map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 56) as u8
        })
        .collect()
}

fn picture(width: u32, height: u32, seed: u64) -> scene::Image {
    let rgba8 = noise(width as usize * height as usize * 4, seed);
    scene::Image { name: format!("noise {seed}"), width, height, rgba8 }
}

const SAMPLED: vk::ImageLayout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;

/// Uploads to an image of one level that can be copied from, and returns it with what it holds.
fn uploaded_image(device: &Device) -> (Image, Vec<u8>) {
    let usage =
        vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST | vk::ImageUsageFlags::TRANSFER_SRC;
    let desc = ImageDesc::new("test", vk::Format::R8G8B8A8_UNORM, [16, 8], usage);
    let image = Image::new(device, &desc).unwrap();
    let content = noise(16 * 8 * 4, 1);
    let mut upload = Upload::new(device);
    upload.image(&image, &[&content]).unwrap();
    Commands::run(device, "upload", |r| {
        upload.record(r);
        Ok(())
    })
    .unwrap();
    (image, content)
}

fn level_of(device: &Device, image: &Image, level: u32) -> Vec<u8> {
    let size = image.size().map(|n| (n >> level).max(1));
    let readback = Readback::new(device, image.format(), size).unwrap();
    Commands::run(device, "readback", |r| readback.record(r, image, level, SAMPLED, SAMPLED)).unwrap();
    readback.texels().to_vec()
}

fn bytes_of(device: &Device, buffer: &Buffer) -> Vec<u8> {
    let desc = BufferDesc {
        name: "read back",
        bytes: buffer.size_bytes(),
        usage: vk::BufferUsageFlags::TRANSFER_DST,
        memory: MemoryUse::Readback,
    };
    let target = Buffer::new(device, &desc).unwrap();
    Commands::run(device, "copy", |r| buffer.record_copy(r, &target)).unwrap();
    target.mapped().to_vec()
}

fn storage_buffer(device: &Device, bytes: u64, memory: MemoryUse) -> Result<Buffer, Error> {
    let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_DST;
    Buffer::new(device, &BufferDesc { name: "test", bytes, usage, memory })
}

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

/// Levels of a texture as an independent computation has them: doubles, straight from the definition, for sizes that
/// halve evenly.
fn mip_chain_f64(image: &scene::Image, srgb: bool) -> Vec<Vec<f64>> {
    let decode = |v: f64| if v > 0.04045 { ((v + 0.055) / 1.055).powf(2.4) } else { v / 12.92 };
    let encode = |v: f64| if v > 0.0031308 { 1.055 * v.powf(1.0 / 2.4) - 0.055 } else { v * 12.92 };
    let is_curved = |i: usize| srgb && i % 4 != 3;
    let mut size = [image.width as usize, image.height as usize];
    let unit = image.rgba8.iter().map(|&b| f64::from(b) / 255.0);
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
    let all = Textures::new(device, &mut upload, &images, &textures, &wanted).unwrap();
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
        assert_eq!(level_of(device, image, 0), images[0].rgba8, "level 0 is the picture");
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
    assert!(level_of(device, large, 0) == images[1].rgba8, "a picture cut into pieces arrives whole");

    // One image, two views: all levels, and level 0 alone.
    let (with_mips, without) = (all.get(wanted[0]).unwrap(), all.get(wanted[1]).unwrap());
    assert_ne!(with_mips.0, without.0);
    assert_eq!(all.get(key(3, Srgb)), None, "what was not wanted is not there");

    let unknown = Textures::new(device, &mut Upload::new(device), &images, &textures, &[key(9, Srgb)]);
    assert!(unknown.unwrap_err().to_string().contains("texture 9"));
    drop(all);
    gpu.finish();
}

#[test]
fn samplers_are_shared() {
    let Some(gpu) = Gpu::new() else { return };
    let mut cache = SamplerCache::new(gpu.device());
    assert!(cache.is_empty());
    let trilinear = scene::Sampler::default();
    let nearest =
        scene::Sampler { mag_linear: false, min_linear: false, mip_linear: Some(false), ..trilinear };
    let first = cache.get(trilinear).unwrap();
    assert_eq!(cache.get(trilinear).unwrap(), first);
    assert_ne!(cache.get(nearest).unwrap(), first);
    // Without mips only the view differs.
    let base_only = scene::Sampler { mip_linear: None, ..nearest };
    assert_eq!(cache.get(base_only).unwrap(), cache.get(nearest).unwrap());
    assert_eq!(cache.len(), 2);
    assert_eq!(gpu.device().live().objects["sampler"], 2);
    drop(cache);
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
    let streams = [textured, Streams::default(), textured];
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

#[test]
fn transient_images_take_lazy_memory_where_there_is_some() {
    let Some(gpu) = Gpu::new() else { return };
    let device = gpu.device();
    let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::INPUT_ATTACHMENT;
    // One below and one above the size from which images get memory of their own.
    for size in [[64, 64], [1280, 720]] {
        let desc = ImageDesc::new("normal", vk::Format::R8G8B8A8_UNORM, size, usage);
        let image = Image::transient(device, &desc, false).unwrap();
        assert!(image.usage().contains(vk::ImageUsageFlags::TRANSIENT_ATTACHMENT));
        assert_eq!(image.committed_bytes().is_some(), device.caps().lazily_allocated_memory);
        assert!(image.allocated_bytes() >= u64::from(size[0]) * u64::from(size[1]) * 4);
        assert_eq!(device.live().bytes, image.allocated_bytes());
        assert_ne!(image.view(), vk::ImageView::null());
        let captured = Image::transient(device, &desc, true).unwrap();
        assert_eq!(captured.committed_bytes(), None, "a capture needs ordinary memory");
    }
    let depth = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::INPUT_ATTACHMENT;
    let depth = ImageDesc::new("depth", vk::Format::D32_SFLOAT, [64, 64], depth);
    drop(Image::transient(device, &depth, false).unwrap());
    gpu.finish();
}

#[test]
fn failed_creations_unwind() {
    let Some(gpu) = Gpu::new() else { return };
    let device = gpu.device();
    let error = storage_buffer(device, 1 << 50, MemoryUse::Device).unwrap_err();
    assert!(matches!(error, Error::Vulkan { .. }), "{error}");
    assert!(storage_buffer(device, 0, MemoryUse::Device).is_err());

    let sampled = vk::ImageUsageFlags::SAMPLED;
    let huge = ImageDesc::new("huge", vk::Format::R8G8B8A8_UNORM, [1 << 20, 1 << 20], sampled);
    let error = Image::new(device, &huge).unwrap_err().to_string();
    assert!(error.contains("'huge'") && error.contains("stay within"), "{error}");
    let format = ImageDesc::new("odd", vk::Format::R64G64B64A64_SFLOAT, [4, 4], sampled);
    assert!(Image::new(device, &format).unwrap_err().to_string().contains("R64G64B64A64_SFLOAT"));

    // What was made before a failure goes with it: contents that do not fit, commands that give up.
    let (image, content) = uploaded_image(device);
    let mut upload = Upload::new(device);
    assert!(upload.image(&image, &[&content[1..]]).is_err());
    assert!(upload.image(&image, &[&content, &content]).is_err());
    let small = storage_buffer(device, 16, MemoryUse::Device).unwrap();
    assert!(upload.buffer(&small, 8, &[0; 12]).is_err());
    assert!(upload.buffer(&small, u64::MAX, &[0; 12]).is_err());
    let readback = Readback::new(device, vk::Format::R8G8B8A8_UNORM, [1, 1]).unwrap();
    let wrong_size = Commands::run(device, "wrong", |r| readback.record(r, &image, 0, SAMPLED, SAMPLED));
    assert!(wrong_size.is_err());
    assert!(Readback::new(device, vk::Format::BC1_RGB_UNORM_BLOCK, [4, 4]).is_err());
    drop((image, upload, small, readback));
    gpu.finish_after_failures();
}

#[test]
fn memory_that_runs_out_is_an_error() {
    let Some(gpu) = Gpu::new() else { return };
    let device = gpu.device();
    let largest_heap = device.caps().memory_types.iter().map(|t| t.heap_bytes).max().unwrap();
    let side = device.caps().max_image_dimension_2d;
    // As many rows of 16-byte texels as the heap holds, and one more.
    let rows = largest_heap / (u64::from(side) * 16) + 1;
    if rows > u64::from(side) {
        println!("ignored: the largest image fits into this device's memory");
    } else {
        let format = vk::Format::R32G32B32A32_SFLOAT;
        let desc = ImageDesc::new("large", format, [side, rows as u32], vk::ImageUsageFlags::SAMPLED);
        let error = Image::new(device, &desc).unwrap_err();
        let expected = vk::Result::ERROR_OUT_OF_DEVICE_MEMORY;
        assert!(matches!(error, Error::Vulkan { result, .. } if result == expected), "{error}");
    }
    gpu.finish_after_failures();
}

#[test]
fn queries_answer_or_say_nothing() {
    let Some(gpu) = Gpu::new() else { return };
    let device = gpu.device();
    let queries = Queries::new(device, 2, 2).unwrap();
    let mut commands = Commands::new(device, "queries").unwrap();
    commands
        .record(|r| {
            let _label = r.label("queries");
            queries.reset(r, 1);
            queries.timestamp(r, 1, 0, vk::PipelineStageFlags::TOP_OF_PIPE);
            queries.begin_statistics(r, 1);
            queries.end_statistics(r, 1);
            queries.timestamp(r, 1, 1, vk::PipelineStageFlags::BOTTOM_OF_PIPE);
            Ok(())
        })
        .unwrap();
    commands.submit().unwrap();
    assert!(commands.submit().is_err(), "commands run once");
    commands.wait().unwrap();
    let results = queries.results(1).unwrap();
    assert_eq!(results.timestamps_ns.is_some(), device.caps().timestamp_valid_bits > 0);
    if let Some(times) = results.timestamps_ns {
        assert_eq!((times.len(), times[0]), (2, 0.0));
        assert!((0.0..1e10).contains(&times[1]), "{times:?} ns");
    }
    // Nothing was drawn.
    let nothing = device.features().pipeline_statistics.then(PipelineStatistics::default);
    assert_eq!(results.statistics, nothing);
    drop((queries, commands));
    gpu.finish();
}

#[test]
fn a_damaged_pipeline_cache_starts_empty() {
    let Some(gpu) = Gpu::new() else { return };
    let device = gpu.device();
    let blob = PipelineCache::new(device, &[]).unwrap().blob().unwrap();
    let again = PipelineCache::new(device, &blob).unwrap();
    assert_eq!(again.blob().unwrap().len(), blob.len());
    let mut damaged = blob.clone();
    *damaged.last_mut().unwrap() ^= 1;
    for bad in [&damaged[..], &blob[..blob.len() / 2], &[0; 7], &[0xff; 4096]] {
        // The driver never sees it: a cache is made, and is as one from nothing.
        assert_eq!(PipelineCache::new(device, bad).unwrap().blob().unwrap().len(), blob.len());
    }
    drop(again);
    gpu.finish();
}

#[test]
fn an_unknown_device_is_refused_with_a_list() {
    let Ok(devices) = devices() else { return println!("ignored: no Vulkan device") };
    let Some(first) = devices.first() else { return println!("ignored: no Vulkan device") };
    let options = HeadlessOptions { device_name_part: Some("no such device".into()), ..Default::default() };
    let error = Headless::new(&options).unwrap_err().to_string();
    assert!(error.contains("no such device") && error.contains(&first.name), "{error}");
    let part = first.name.to_uppercase();
    let options = HeadlessOptions { device_name_part: Some(part), ..Default::default() };
    assert_eq!(Headless::new(&options).unwrap().device().caps().name, first.name);
    assert!(first.to_string().contains(&first.driver));
}

#[test]
fn mistakes_are_reported() {
    // Silence elsewhere means something only if the layer speaks up here.
    let Some(gpu) = Gpu::new() else { return };
    let device = gpu.device();
    let (image, _) = uploaded_image(device);
    let readback = Readback::new(device, image.format(), image.size()).unwrap();
    assert_eq!(gpu.headless.messages(), Vec::<String>::new());

    // Core: the image is in another layout.
    let general = vk::ImageLayout::GENERAL;
    Commands::run(device, "wrong layout", |r| readback.record(r, &image, 0, general, SAMPLED)).unwrap();
    let messages = gpu.headless.messages();
    assert!(messages.iter().any(|m| m.contains("Layout")), "{messages:?}");

    // Synchronisation: two copies to one place, unordered.
    let buffer = storage_buffer(device, 64, MemoryUse::Device).unwrap();
    let mut upload = Upload::new(device);
    upload.buffer(&buffer, 0, &[1; 64]).unwrap();
    upload.buffer(&buffer, 32, &[2; 32]).unwrap();
    Commands::run(device, "hazard", |r| {
        upload.record(r);
        Ok(())
    })
    .unwrap();
    let messages = gpu.headless.messages();
    assert!(
        messages.iter().any(|m| m.contains("WRITE-AFTER-WRITE") || m.contains("WRITE_AFTER_WRITE")),
        "{messages:?}"
    );

    // An object that outlives its device's owner.
    drop((image, readback, upload));
    let messages = gpu.headless.finish();
    assert!(messages.iter().any(|m| m.contains("still in use")), "{messages:?}");
    drop(buffer);
}

#[test]
fn vendors_checks_are_on_where_the_environment_asks() {
    // Layers older than VK_EXT_layer_settings learn of them from the environment alone (.cargo/config.toml).
    let asked = std::env::var("VK_LAYER_ENABLES").unwrap_or_default();
    if !asked.contains("VENDOR_SPECIFIC_ARM") {
        return println!("ignored: VK_LAYER_ENABLES does not ask for the vendors' checks");
    }
    let Some(gpu) = Gpu::new() else { return };
    let mut cache = SamplerCache::new(gpu.device());
    // Arm advises against wrapping differently along the axes.
    let wrap_v = scene::Wrap::ClampToEdge;
    cache.get(scene::Sampler { wrap_v, ..Default::default() }).unwrap();
    let messages = gpu.headless.messages();
    assert!(messages.iter().any(|m| m.contains("wrapping")), "{messages:?}");
}
