//! The Vulkan foundation on whatever device is at hand, under the validation layer: contents arrive, failures
//! unwind, nothing leaks, and nothing is reported.

mod contents;
mod mistakes;
mod objects;

use ash::vk;
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
    let texels = noise(width as usize * height as usize * 4, seed);
    scene::Image { name: format!("noise {seed}"), width, height, texels: texels.into() }
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
