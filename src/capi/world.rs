//! Worlds: what is to be drawn.

use std::ffi::c_char;
use std::path::Path;

use glam::Vec3;

use super::call::{Failure, OntileResult, Outcome, call, copy_out, destroy, get, get_mut, give, put, text};
use super::elements::*;
use crate::scene::{
    Background, Camera, Decal, Element, Environment, Fog, Id, Image, Instance, Light, Material, Mesh, Scene,
    Texture, World,
};

/// What is to be drawn, and what was done to it since renderers looked.
pub struct OntileWorld {
    pub(super) world: World,
}

/// The kinds of elements.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OntileKind {
    /// OntileMesh.
    Mesh = 0,
    /// OntileMaterial.
    Material = 1,
    /// OntileTexture.
    Texture = 2,
    /// OntileImage.
    Image = 3,
    /// OntileInstance.
    Instance = 4,
    /// OntileLight.
    Light = 5,
    /// OntileDecal.
    Decal = 6,
    /// A camera of a file: ontile_world_camera reads it.
    Camera = 7,
}

/// Adds an element if `id` holds 0, and writes its name there; else puts it in the place of the element that `id` names.
///
/// # Safety
/// `world` and `id` are null or valid.
unsafe fn set<T: Element>(
    world: *mut OntileWorld,
    id: *mut OntileId,
    read: impl FnOnce(&World) -> Outcome<T>,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        let (world, id) = unsafe { (&mut get_mut(world, "world")?.world, get_mut(id, "id")?) };
        let element = read(world)?;
        match *id {
            0 => *id = world.add(element)?.to_bits(),
            bits => world.set(Id::from_bits(bits), element)?,
        }
        Ok(())
    })
}

/// Makes an empty world.
///
/// # Safety
/// `name` is null or ends with a zero; `world` is valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_create(
    name: *const c_char,
    world: *mut *mut OntileWorld,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        unsafe { give(world, "world", || Ok(OntileWorld { world: World::new(text(name, "name")?) })) }
    })
}

/// Loads a world from a glTF file (.gltf or .glb). What had to be left out is in ontile_world_warnings.
///
/// # Safety
/// `path` ends with a zero; `world` is valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_load(
    path: *const c_char,
    world: *mut *mut OntileWorld,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        unsafe {
            give(world, "world", || {
                let scene = Scene::load(Path::new(text(path, "path")?))?;
                Ok(OntileWorld { world: World::from(scene) })
            })
        }
    })
}

/// What loading had to leave out or change, a line each. With `lines` null it writes their size in bytes; else as much as `size` has room
/// for, and how much that was. There is no zero at the end.
///
/// # Safety
/// All pointers are valid, and `lines` has room for `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_warnings(
    world: *const OntileWorld,
    size: *mut usize,
    lines: *mut c_char,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        unsafe {
            let all = get(world, "world")?.world.scene().warnings.join("\n");
            copy_out(all.as_bytes(), size, lines.cast())
        }
    })
}

/// Destroys a world; null is none. Renderers made of it go on as they are.
///
/// # Safety
/// `world` was made by this interface and not destroyed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_destroy(world: *mut OntileWorld) {
    // SAFETY: the caller's promise.
    unsafe { destroy(world) }
}

/// Adds a mesh, or puts it in another's place if `id` holds that one's name.
///
/// # Safety
/// All pointers are valid, and lists as long as the mesh says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_set_mesh(
    world: *mut OntileWorld,
    id: *mut OntileId,
    mesh: *const OntileMesh,
) -> OntileResult {
    // SAFETY: the caller's promise.
    unsafe { set::<Mesh>(world, id, |world| get(mesh, "mesh")?.read(world)) }
}

/// White, rough, opaque, without textures.
#[unsafe(no_mangle)]
pub extern "C" fn ontile_material_default() -> OntileMaterial {
    OntileMaterial::DEFAULT
}

/// Adds a material, or puts it in another's place if `id` holds that one's name.
///
/// # Safety
/// All pointers are valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_set_material(
    world: *mut OntileWorld,
    id: *mut OntileId,
    material: *const OntileMaterial,
) -> OntileResult {
    // SAFETY: the caller's promise.
    unsafe { set::<Material>(world, id, |world| get(material, "material")?.read(world)) }
}

/// Adds a texture, or puts it in another's place if `id` holds that one's name.
///
/// # Safety
/// All pointers are valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_set_texture(
    world: *mut OntileWorld,
    id: *mut OntileId,
    texture: *const OntileTexture,
) -> OntileResult {
    // SAFETY: the caller's promise.
    unsafe { set::<Texture>(world, id, |world| get(texture, "texture")?.read(world)) }
}

/// Adds a picture, or puts it in another's place if `id` holds that one's name.
///
/// # Safety
/// All pointers are valid, and the picture has as many bytes as it says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_set_image(
    world: *mut OntileWorld,
    id: *mut OntileId,
    image: *const OntileImage,
) -> OntileResult {
    // SAFETY: the caller's promise.
    unsafe { set::<Image>(world, id, |_| get(image, "image")?.read()) }
}

/// Adds an instance of a mesh, or puts it in another's place if `id` holds that one's name.
///
/// # Safety
/// All pointers are valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_set_instance(
    world: *mut OntileWorld,
    id: *mut OntileId,
    instance: *const OntileInstance,
) -> OntileResult {
    // SAFETY: the caller's promise.
    unsafe { set::<Instance>(world, id, |world| get(instance, "instance")?.read(world)) }
}

/// Moves an instance: an affine matrix, column by column.
///
/// # Safety
/// `world` is valid, and `world_from_object` has 16 numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_place(
    world: *mut OntileWorld,
    instance: OntileId,
    world_from_object: *const f32,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        let (world, matrix) = unsafe {
            (get_mut(world, "world")?, get(world_from_object.cast::<[f32; 16]>(), "world_from_object")?)
        };
        Ok(world.world.place(Id::from_bits(instance), glam::Mat4::from_cols_array(matrix))?)
    })
}

/// White, directional, along -Z, of no intensity.
#[unsafe(no_mangle)]
pub extern "C" fn ontile_light_default() -> OntileLight {
    OntileLight::DEFAULT
}

/// Adds a light, or puts it in another's place if `id` holds that one's name.
///
/// # Safety
/// All pointers are valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_set_light(
    world: *mut OntileWorld,
    id: *mut OntileId,
    light: *const OntileLight,
) -> OntileResult {
    // SAFETY: the caller's promise.
    unsafe { set::<Light>(world, id, |_| get(light, "light")?.read()) }
}

/// Adds a decal, or puts it in another's place if `id` holds that one's name.
///
/// # Safety
/// All pointers are valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_set_decal(
    world: *mut OntileWorld,
    id: *mut OntileId,
    decal: *const OntileDecal,
) -> OntileResult {
    // SAFETY: the caller's promise.
    unsafe { set::<Decal>(world, id, |world| get(decal, "decal")?.read(world)) }
}

/// Takes an element out. What others refer to stays: the message names who does.
///
/// # Safety
/// `world` is valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_remove(
    world: *mut OntileWorld,
    kind: u32,
    id: OntileId,
) -> OntileResult {
    fn remove<T: Element>(world: &mut World, id: OntileId) -> crate::Result<()> {
        world.remove(Id::<T>::from_bits(id)).map(drop)
    }
    call(|| {
        // SAFETY: the caller's promise.
        let world = &mut unsafe { get_mut(world, "world") }?.world;
        let remove = match kind {
            0 => remove::<Mesh>,
            1 => remove::<Material>,
            2 => remove::<Texture>,
            3 => remove::<Image>,
            4 => remove::<Instance>,
            5 => remove::<Light>,
            6 => remove::<Decal>,
            7 => remove::<Camera>,
            other => return Err(Failure::Argument(format!("kind is {other}, and there is none such"))),
        };
        Ok(remove(world, id)?)
    })
}

/// The names of all elements of a kind. With `ids` null it writes their number; else as many as `count` has room for, and how many that
/// were.
///
/// # Safety
/// `world` and `count` are valid, and `ids` has room for `count` names.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_ids(
    world: *const OntileWorld,
    kind: u32,
    count: *mut usize,
    ids: *mut OntileId,
) -> OntileResult {
    fn all<T: Element>(world: &World) -> Vec<OntileId> {
        world.ids::<T>().map(Id::to_bits).collect()
    }
    call(|| {
        // SAFETY: the caller's promise.
        let (world, count) = unsafe { (&get(world, "world")?.world, get_mut(count, "count")?) };
        let all = match kind {
            0 => all::<Mesh>(world),
            1 => all::<Material>(world),
            2 => all::<Texture>(world),
            3 => all::<Image>(world),
            4 => all::<Instance>(world),
            5 => all::<Light>(world),
            6 => all::<Decal>(world),
            7 => all::<Camera>(world),
            other => return Err(Failure::Argument(format!("kind is {other}, and there is none such"))),
        };
        if ids.is_null() {
            *count = all.len();
            return Ok(());
        }
        *count = all.len().min(*count);
        // SAFETY: the caller's promise; the two do not overlap.
        unsafe { std::ptr::copy_nonoverlapping(all.as_ptr(), ids, *count) };
        Ok(())
    })
}

/// Reads a camera that a file brought.
///
/// # Safety
/// All pointers are valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_camera(
    world: *const OntileWorld,
    id: OntileId,
    camera: *mut OntileCamera,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        let found = unsafe { get(world, "world") }?.world.get(Id::<Camera>::from_bits(id));
        let found = found.ok_or_else(|| Failure::Argument("id names no camera of the world".into()))?;
        // SAFETY: the caller's promise.
        unsafe { put(camera, "camera", OntileCamera::of(found)) }
    })
}

/// Radiance from everywhere alike, cd/m2: three numbers, linear Rec.709.
///
/// # Safety
/// `world` is valid, and `radiance` has three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_set_ambient(
    world: *mut OntileWorld,
    radiance: *const f32,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        let (world, radiance) =
            unsafe { (get_mut(world, "world")?, get(radiance.cast::<[f32; 3]>(), "radiance")?) };
        Ok(world.world.set_ambient(Vec3::from_array(*radiance))?)
    })
}

/// What is seen where there is no surface, as linear display light; null is the environment, if there is one, else black.
///
/// # Safety
/// `world` is valid, and `color` is null or has three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_set_background(
    world: *mut OntileWorld,
    color: *const f32,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        let (world, color) = unsafe { (get_mut(world, "world")?, color.cast::<[f32; 3]>().as_ref()) };
        let background = match color {
            Some(color) => Background::Color(Vec3::from_array(*color)),
            None => Background::Environment,
        };
        Ok(world.world.set_background(background)?)
    })
}

/// Fog of a radiance (cd/m2, three numbers, linear Rec.709) and a density per metre; a density of 0 is none.
///
/// # Safety
/// `world` is valid, and `color` has three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_set_fog(
    world: *mut OntileWorld,
    color: *const f32,
    density: f32,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        let (world, color) = unsafe { (get_mut(world, "world")?, get(color.cast::<[f32; 3]>(), "color")?) };
        let fog = Fog { color_nt: Vec3::from_array(*color), density_per_m: density, height: None };
        Ok(world.world.set_fog((density != 0.0).then_some(fog))?)
    })
}

/// Radiance from far away, from a picture of all directions (.hdr; twice as wide as high); null is none.
///
/// # Safety
/// `world` is valid, and `path` is null or ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_set_environment(
    world: *mut OntileWorld,
    path: *const c_char,
) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        let (world, path) = unsafe { (get_mut(world, "world")?, text(path, "path")?) };
        let environment = (!path.is_empty()).then(|| Environment::load(Path::new(path))).transpose()?;
        Ok(world.world.set_environment(environment)?)
    })
}

/// Once every renderer of the world was made or updated: forgets what was done to it.
///
/// # Safety
/// `world` is valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ontile_world_clear_changes(world: *mut OntileWorld) -> OntileResult {
    call(|| {
        // SAFETY: the caller's promise.
        unsafe { get_mut(world, "world") }?.world.clear_changes();
        Ok(())
    })
}
