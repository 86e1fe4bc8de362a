//! What fails unwinds with a clear error, and the validation layer speaks up.

use super::*;

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
    assert!(messages.iter().any(|m| m.to_lowercase().contains("layout")), "{messages:?}");

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
fn vendors_checks_are_on() {
    let Some(gpu) = Gpu::new() else { return };
    // Arm advises against samplers that limit the level of detail.
    let limited = vk::SamplerCreateInfo::default().min_lod(1.0).max_lod(2.0);
    let device = gpu.device().raw();
    // SAFETY: valid usage, though not advisable; destroyed at once, before anything uses it.
    unsafe { device.destroy_sampler(device.create_sampler(&limited, None).unwrap(), None) };
    let reported = gpu.headless.messages().iter().any(|m| m.contains("[Arm]"));
    // Layers older than VK_EXT_layer_settings learn of vendors' checks from this variable alone; newer ones
    // reject it.
    let asked = std::env::var("VK_LAYER_ENABLES").is_ok_and(|v| v.contains("VENDOR_SPECIFIC_ARM"));
    if !reported && !asked {
        return println!(
            "ignored: this validation layer makes vendors' checks only if VK_LAYER_ENABLES asks for them"
        );
    }
    assert!(reported, "{:?}", gpu.headless.messages());
}
