//! Plain Vulkan that counts an empty command buffer, right or with one mistake.

use ontile::gpu::ash::{khr, vk};
use ontile::gpu::{Headless, HeadlessOptions};

/// Mistakes, and the rule that each breaks.
pub const FAULTS: [(&str, &str); 9] = [
    ("none", ""),
    ("no lock", "VUID-vkCmdBeginQuery-queryPool-03223"),
    ("lock given back before the submission", "VUID-vkQueueSubmit-pCommandBuffers-03220"),
    ("no reset", "VUID-vkCmdBeginQuery-None-00807"),
    ("reset in the same command buffer", "VUID-vkCmdBeginQuery-None-02863"),
    ("not begun first", "VUID-vkCmdBeginQuery-queryPool-03224"),
    ("not ended last", "VUID-vkCmdEndQuery-queryPool-03227"),
    ("a pass too many", "VUID-VkPerformanceQuerySubmitInfoKHR-counterPassIndex-03221"),
    ("a pass too few", "VUID-vkGetQueryPoolResults-queryType-09441"),
];

/// What the validation layer says of the mistake.
pub fn run(fault: &str) -> Vec<String> {
    let options = HeadlessOptions {
        device_name_part: Some(super::LAVAPIPE.into()),
        validate: true,
        performance_counters: true,
        ..HeadlessOptions::default()
    };
    let host = Headless::new(&options).unwrap();
    let device = host.device();
    let (raw, family, queue) = (device.raw(), device.queue_family(), *device.queue());
    let locks = khr::performance_query::Device::new(device.instance(), raw);
    // Of the scopes command and command buffer; two passes.
    let mut counters =
        vk::QueryPoolPerformanceCreateInfoKHR::default().queue_family_index(family).counter_indices(&[0, 4]);
    let info = vk::QueryPoolCreateInfo::default()
        .query_type(vk::QueryType::PERFORMANCE_QUERY_KHR)
        .query_count(1)
        .push_next(&mut counters);
    let pool_info = vk::CommandPoolCreateInfo::default()
        .flags(vk::CommandPoolCreateFlags::TRANSIENT)
        .queue_family_index(family);
    let once = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
    let done = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
    // SAFETY: but for the mistake all is used as Vulkan wants it, on one thread, and layer and driver survive each of them.
    unsafe {
        let pool = raw.create_query_pool(&info, None).unwrap();
        let commands = raw.create_command_pool(&pool_info, None).unwrap();
        let buffer = vk::CommandBufferAllocateInfo::default().command_pool(commands).command_buffer_count(1);
        let buffer = raw.allocate_command_buffers(&buffer).unwrap()[0];
        let submit = |pass: u32, record: &dyn Fn()| {
            raw.reset_command_pool(commands, vk::CommandPoolResetFlags::empty()).unwrap();
            raw.begin_command_buffer(buffer, &once).unwrap();
            record();
            raw.end_command_buffer(buffer).unwrap();
            if fault.starts_with("lock given back") && pass == 1 {
                locks.release_profiling_lock();
            }
            let mut performance = vk::PerformanceQuerySubmitInfoKHR::default().counter_pass_index(pass);
            let buffers = [buffer];
            let info = vk::SubmitInfo::default().command_buffers(&buffers).push_next(&mut performance);
            raw.queue_submit(queue, &[info], vk::Fence::null()).unwrap();
            raw.queue_wait_idle(queue).unwrap();
        };
        if fault != "no lock" {
            locks.acquire_profiling_lock(&vk::AcquireProfilingLockInfoKHR::default()).unwrap();
        }
        let reset = || raw.cmd_reset_query_pool(buffer, pool, 0, 1);
        let wait =
            || raw.cmd_pipeline_barrier(buffer, done, done, vk::DependencyFlags::empty(), &[], &[], &[]);
        if fault != "no reset" {
            submit(0, &reset);
        }
        let passes = match fault {
            "a pass too many" => 3,
            "a pass too few" => 1,
            _ => 2,
        };
        for pass in 0..passes {
            submit(pass, &|| {
                if fault.starts_with("reset in") {
                    reset();
                }
                if fault == "not begun first" {
                    wait();
                }
                raw.cmd_begin_query(buffer, pool, 0, vk::QueryControlFlags::empty());
                wait();
                raw.cmd_end_query(buffer, pool, 0);
                if fault == "not ended last" {
                    wait();
                }
            });
        }
        let mut values = [[vk::PerformanceCounterResultKHR::default(); 2]];
        let _ = raw.get_query_pool_results(pool, 0, &mut values, vk::QueryResultFlags::empty());
        if fault != "no lock" && !fault.starts_with("lock given back") {
            locks.release_profiling_lock();
        }
        raw.destroy_command_pool(commands, None);
        raw.destroy_query_pool(pool, None);
    }
    host.finish()
}
