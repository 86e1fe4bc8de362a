//! Worlds that move by themselves.

use std::ffi::c_char;
use std::path::Path;

use super::call::{OntileResult, call, copy_out, get, get_mut, give, text};
use super::world::OntileWorld;
use crate::scene::{Play, Scene, World};

/// As ontile_world_load, but what the file's animations move is where ontile_world_animate puts it. A file without animations is loaded
/// as there.
///
/// # Safety
/// `path` ends with a zero; `world` is valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_load_moving(
    path: *const c_char,
    world: *mut *mut OntileWorld,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        unsafe {
            give(world, "world", || {
                let scene = Scene::load_moving(Path::new(text(path, "path")?))?;
                Ok(OntileWorld { world: World::from(scene) })
            })
        }
    })
}

/// The animations of a world, a line each: how many seconds it takes, a space, its name. The n-th line is animation n, from 0. With `lines`
/// null it writes their size in bytes; else as much as `size` has room for, and how much that was. There is no zero at the end.
///
/// # Safety
/// All pointers are valid, and `lines` has room for `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_animations(
    world: *const OntileWorld,
    size: *mut usize,
    lines: *mut c_char,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        unsafe {
            let motion = get(world, "world")?.world.scene().motion.as_ref();
            let animations = motion.map(|motion| &motion.animations[..]).unwrap_or_default();
            let line = |a: &crate::scene::Animation| format!("{} {}", a.duration_s(), a.name);
            let all = animations.iter().map(line).collect::<Vec<_>>().join("\n");
            copy_out(all.as_bytes(), size, lines.cast())
        }
    })
}

/// Moves all that the animation moves to where it is after so many seconds; ontile_renderer_update brings renderers there. Nothing repeats:
/// after the last key it stays. Cameras that move are read by ontile_world_camera.
///
/// # Safety
/// `world` is valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_animate(
    world: *mut OntileWorld,
    animation: usize,
    time_s: f64,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        let world = unsafe { &mut get_mut(world, "world")?.world };
        Ok(world.animate(&[Play { animation, time_s }])?)
    })
}
