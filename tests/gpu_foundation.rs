//! The Vulkan foundation on whatever device is at hand, under the validation layer.

use ash::vk;
use ontile::gpu::*;

fn headless() -> Option<Headless> {
    let options =
        HeadlessOptions { validate: true, application_name: "gpu_foundation".into(), ..Default::default() };
    match Headless::new(&options) {
        Ok(headless) => Some(headless),
        Err(e) => {
            println!("ignored: no Vulkan device with validation: {e}");
            None
        }
    }
}

#[test]
fn smoke() {
    let Some(h) = headless() else { return };
    println!("{}", h.device().caps());
    let m = h.finish();
    assert_eq!(m, Vec::<String>::new());
}
