//! What drivers do otherwise than their features say: a table, each row with where it was seen.

use ash::vk::DriverId;

use super::Caps;
use crate::plan::{Merging, Strategy};

/// What is known of a driver.
struct Driver {
    id: DriverId,
    /// Why local reads must not be used, although the driver has them.
    broken_local_read: Option<&'static str>,
    /// What keeps a frame on the chip, where the driver has it.
    best: Strategy,
    why: &'static str,
}

/// Mesa's driver for Apple's GPUs, which ash does not name yet.
const MESA_HONEYKRISP: DriverId = DriverId::from_raw(26);
/// Mesa's for PowerVR, likewise.
const MESA_POWERVR: DriverId = DriverId::from_raw(25);

const fn driver(id: DriverId, best: Strategy, why: &'static str) -> Driver {
    Driver { id, broken_local_read: None, best, why }
}

/// "Measured": on the driver itself, with no hardware (Turnip, by tests/tiles; PanVK and PowerVR of Mesa 26.2.6, by what jobs they
/// make of three stages) or with it (NVIDIA). "Source": of Mesa 26, by file and function.
const DRIVERS: [Driver; 8] = [
    // Measured: 3 fragment jobs for 3 subpasses, 1 for a rendering (Mali-G610). Source: it has no render passes of its own, and
    // those of Mesa (vk_render_pass.c, vk_common_CmdNextSubpass2) end one rendering and begin another for each subpass.
    driver(
        DriverId::MESA_PANVK,
        Strategy::LocalRead,
        "Mesa's PanVK makes a job of each subpass, and one of a whole rendering with local reads",
    ),
    // Measured: the same bytes and bins where all is needed all the time; 28 bins of 480x160 against 34 of 960x64 where lights are
    // added one by one to packed128 (Adreno 660, 1920x1080; tests/tiles has both).
    driver(
        DriverId::MESA_TURNIP,
        Strategy::Subpasses,
        "Mesa's Turnip merges both, and gives subpasses larger bins: attachments that are not needed at the same time share \
         tile memory",
    ),
    // Measured: 1 job for 3 subpasses (GX6250), 2 on BXS-4-64.
    driver(MESA_POWERVR, Strategy::Subpasses, "Mesa's PowerVR driver merges subpasses"),
    // Source: hk_CmdPipelineBarrier2 (hk_cmd_buffer.c) ends the control stream, inside a rendering too, and subpasses are
    // vk_common_CmdNextSubpass2's.
    driver(
        MESA_HONEYKRISP,
        Strategy::Subpasses,
        "Mesa's Honeykrisp merges neither: it flushes the tiles at every barrier and between subpasses",
    ),
    // Source: cmd_buffer_can_merge_subpass (v3dv_cmd_buffer.c) wants the same attachments in both.
    driver(
        DriverId::MESA_V3DV,
        Strategy::Subpasses,
        "Mesa's V3DV merges subpasses of the same attachments only, and renderings no better",
    ),
    // tests/combinations: the same picture, bit for bit.
    driver(
        DriverId::MESA_LLVMPIPE,
        Strategy::Subpasses,
        "lavapipe is no tiler: it stores every stage either way",
    ),
    // Measured on an H200 (driver 580.159): the same pictures of three shipped scenes, and times within 0.1 % of each other.
    driver(
        DriverId::NVIDIA_PROPRIETARY,
        Strategy::Subpasses,
        "NVIDIA's GPUs keep no attachment on the chip either way",
    ),
    Driver {
        id: DriverId::GOOGLE_SWIFTSHADER,
        broken_local_read: Some("SwiftShader says that it has local reads, and crashes in them"),
        best: Strategy::Subpasses,
        why: "SwiftShader is no tiler",
    },
];

/// What a driver makes of the strategies.
pub(super) fn merging(caps: &Caps) -> Merging {
    let known = DRIVERS.iter().find(|driver| driver.id.as_raw() == caps.driver_id);
    let unknown = Merging::default();
    let local_read = match known.and_then(|driver| driver.broken_local_read) {
        _ if !caps.local_read => unknown.local_read,
        Some(reason) => Err(reason),
        None => Ok(()),
    };
    match known {
        Some(driver) if driver.best != Strategy::LocalRead || local_read.is_ok() => {
            Merging { local_read, best: driver.best, why: driver.why }
        }
        _ => Merging { local_read, ..unknown },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(id: DriverId, local_read: bool) -> Merging {
        merging(&Caps { driver_id: id.as_raw(), local_read, ..Caps::default() })
    }

    #[test]
    fn every_driver_has_one_row_and_a_reason_that_names_it() {
        for (index, driver) in DRIVERS.iter().enumerate() {
            assert!(DRIVERS[..index].iter().all(|other| other.id != driver.id), "{}", driver.why);
            assert!(driver.why.len() > 20 && !driver.why.ends_with('.'), "{}", driver.why);
            assert_ne!(driver.best, Strategy::Auto);
        }
    }

    #[test]
    fn what_a_driver_lacks_is_never_its_best() {
        assert_eq!(of(DriverId::MESA_PANVK, true).best, Strategy::LocalRead);
        let old = of(DriverId::MESA_PANVK, false);
        assert_eq!((old.best, old.local_read.is_ok()), (Strategy::Subpasses, false));
        let broken = of(DriverId::GOOGLE_SWIFTSHADER, true).local_read.unwrap_err();
        assert!(broken.contains("SwiftShader"), "{broken}");
        let unknown = of(DriverId::from_raw(9999), true);
        assert_eq!((unknown.best, unknown.local_read), (Strategy::Subpasses, Ok(())));
    }
}
