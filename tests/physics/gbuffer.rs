//! What geometry writes to the `exact` G-buffer, against the surfaces that the reference's rays find.

use ontile::plan::GBuffer;
use ontile::reference::{Attributes, Frame, Stored, View, decode, render};
use ontile::scene::{Camera, Scene};

use crate::SIZE;
use crate::gpu::{Ask, Gpu};
use crate::scenes;

/// How far off each attribute is at one pixel.
type Differences = [(&'static str, f64); 5];

/// The greatest difference that 99.9 % of the pixels may have, in the order of [`differences`].
///
/// Everything is interpolated in f32, which has 24 bits (6e-8). A plane equation over the whole screen loses some of
/// them where its terms cancel: a few hundred units in the last place are left for depths, fewer for the others.
/// Normals turn by up to a radian in ten pixels, and vertices may be snapped to 1 / 256 pixel.
const BOUNDS: [f64; 5] = [2e-5, 4e-4, 1e-5, 1e-5, 1e-4];

fn differences(found: &Attributes, expected: &Attributes, view: &View) -> Differences {
    let distance = (expected.position_world - view.position_world).length();
    let dark = 1e-3;
    let prelit =
        (found.prelit - expected.prelit).abs() / expected.prelit.max(ontile::glam::DVec3::splat(dark));
    [
        ("position / distance", (found.position_world - expected.position_world).length() / distance),
        ("normal, rad", (found.normal_world - expected.normal_world).length()),
        ("base colour", (found.base_color - expected.base_color).abs().max_element()),
        (
            "roughness and metallic",
            (found.roughness - expected.roughness).abs().max((found.metallic - expected.metallic).abs()),
        ),
        ("light without lights, relative", prelit.max_element()),
    ]
}

/// The quantile of [`crate::error::PROMISED_PART`] of each difference, over covered pixels that are not at edges.
///
/// # Errors
/// Says which pixel differs in kind: covered or not, lit or not.
fn compare(
    scene: &Scene,
    camera: &Camera,
    expected: &Frame,
    gbuffer: &[Stored],
    light_factor: f64,
) -> Result<Differences, String> {
    let (view, exact) = (View::new(camera, SIZE), GBuffer::exact());
    let mut all: Vec<Differences> = Vec::new();
    for (index, (pixel, stored)) in expected.pixels.iter().zip(gbuffer).enumerate() {
        if pixel.edge {
            continue;
        }
        let place = [index as u32 % SIZE[0], index as u32 / SIZE[0]];
        let found = decode(&exact, stored, &view, place, light_factor);
        if found.lit != pixel.attributes.lit {
            return Err(format!("{}, {}: lit is {} at {place:?}", scene.name, camera.name, found.lit));
        }
        // Nothing clears the depth of what no one lights, so only covered pixels have one.
        if pixel.covered {
            all.push(differences(&found, &pixel.attributes, &view));
        }
    }
    let beyond = ((1.0 - crate::error::PROMISED_PART) * all.len() as f64) as usize;
    let names = all.first().ok_or("nothing is covered")?.map(|(name, _)| name);
    Ok(std::array::from_fn(|k| {
        let mut values: Vec<f64> = all.iter().map(|d| d[k].1).collect();
        values.sort_by(|a, b| b.total_cmp(a));
        (names[k], values[beyond])
    }))
}

/// Whether every attribute is within its bound; a NaN is not.
fn within(differences: &Differences) -> bool {
    differences.iter().zip(BOUNDS).all(|((_, value), bound)| *value <= bound)
}

#[test]
fn surfaces_are_the_references() {
    let Some(gpu) = Gpu::open() else { return };
    let mut failed = Vec::new();
    for scene in scenes::all() {
        for camera in &scene.cameras {
            let (rendered, gbuffer) = gpu.render_with_gbuffer(&scene, camera, Ask::EXACT);
            let expected = render(&scene, camera, &rendered.settings);
            let differences = compare(&scene, camera, &expected, &gbuffer, rendered.settings.light_scale);
            let text = match &differences {
                Ok(all) => all.map(|(name, value)| format!("{name} {value:.1e}")).join(", "),
                Err(reason) => reason.clone(),
            };
            println!("{}, {}: {text}", scene.name, camera.name);
            if !differences.as_ref().is_ok_and(within) {
                failed.push(format!("{}, {}: {differences:?}", scene.name, camera.name));
            }
        }
    }
    gpu.finish();
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn every_fault_is_caught() {
    type Fault = (&'static str, fn(&mut Scene));
    const FAULTS: &[Fault] = &[
        ("moved by 2 mm", |s| s.instances[0].world_from_object.w_axis.y += 2e-3),
        ("normal axes swapped", |s| {
            for normal in s.meshes.iter_mut().flat_map(|m| &mut m.normals) {
                std::mem::swap(&mut normal.x, &mut normal.z);
            }
        }),
        ("a mirror forgotten", |s| s.instances.iter_mut().for_each(|i| i.world_from_object.x_axis *= -1.0)),
        ("vertex colour forgotten", |s| s.meshes.iter_mut().for_each(|m| m.colors.clear())),
        ("roughness off by half a step of 8 bits", |s| {
            s.materials.iter_mut().for_each(|m| m.roughness_factor += 0.002);
        }),
        ("ambient off by 1 %", |s| s.ambient_nt *= 1.01),
        ("emission forgotten", |s| s.materials.iter_mut().for_each(|m| m.emissive_factor *= 0.0)),
        ("unlit forgotten", |s| s.materials.iter_mut().for_each(|m| m.unlit = false)),
    ];
    let Some(gpu) = Gpu::open() else { return };
    let scene = scenes::surfaces();
    let camera = &scene.cameras[0];
    let (rendered, gbuffer) = gpu.render_with_gbuffer(&scene, camera, Ask::EXACT);
    let check = |reference: &Scene| {
        let expected = render(reference, camera, &rendered.settings);
        compare(&scene, camera, &expected, &gbuffer, rendered.settings.light_scale)
    };
    assert!(check(&scene).is_ok_and(|d| within(&d)));
    for (name, fault) in FAULTS {
        let mut faulty = scene.clone();
        fault(&mut faulty);
        let found = check(&faulty);
        assert!(!found.as_ref().is_ok_and(within), "{name}: not caught, {found:?}");
    }
    gpu.finish();
}
