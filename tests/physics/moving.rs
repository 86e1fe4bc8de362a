//! What bends and moves, against the reference, which poses it in f64.

use ontile::glam::{Mat4, Vec3};
use ontile::scene::{Image, Scene};

use crate::common::scenes::moving_scenes::{bending, bending_mapped, frozen, moved};
use crate::gpu::{Ask, Gpu};
use crate::over_light::{Fault, catches, differing, spoilt};

/// At rest, in the midst, and at the end.
const TIMES_S: [f64; 4] = [0.0, 0.4, 1.1, 2.0];

/// A picture of one texel, so that no filter's precision shows.
fn texel() -> Image {
    Image { name: "texel".into(), width: 1, height: 1, texels: vec![190, 100, 230, 255].into() }
}

#[test]
fn what_bends_is_lit_as_the_reference_does() {
    let Some(gpu) = Gpu::open() else { return };
    let plain = TIMES_S.map(|time| moved(bending(), time));
    let mut mapped = moved(bending_mapped(), 1.1);
    mapped.images[0] = texel();
    let all = plain.into_iter().chain([mapped]).map(|scene| scene.without_shadows());
    let failed = differing(&gpu, Ask::EXACT, all);
    gpu.finish();
    assert!(failed.is_empty(), "{failed:#?}");
}

fn pose(scene: &mut Scene, mesh: usize) -> &mut ontile::scene::Pose {
    &mut scene.meshes[mesh].deformation.as_mut().expect("it bends").pose
}

const FAULTS: &[Fault] = &[
    ("not bent", |scene| pose(scene, 1).object_from_bind = vec![Mat4::IDENTITY; 3]),
    ("no morph targets", |scene| pose(scene, 2).weights = vec![0.0; 2]),
    ("a weight off by 1 %", |scene| pose(scene, 2).weights[0] *= 1.01),
    ("a joint off by 3 mm", |scene| {
        pose(scene, 1).object_from_bind[2].w_axis += Vec3::X.extend(0.0) * 0.003;
    }),
    ("normals that go as positions", |scene| {
        let mut posed = frozen(scene.clone());
        let normals = &scene.meshes[1].normals;
        let joints = &scene.meshes[1].deformation.as_ref().expect("it bends").pose.object_from_bind;
        // Those of the last ring go by the last joint alone.
        let last = normals.len() - 21;
        for (to, normal) in posed.meshes[1].normals.iter_mut().zip(normals).skip(last / 2) {
            *to = joints[1].transform_vector3(*normal).normalize();
        }
        *scene = posed;
    }),
    ("tangents that stay", |scene| {
        let tangents = scene.meshes[1].tangents.clone();
        *scene = Scene { meshes: frozen(scene.clone()).meshes, ..scene.clone() };
        scene.meshes[1].tangents = tangents;
    }),
    ("normals without morph targets", |scene| {
        scene.meshes[2].deformation.as_mut().expect("it bends").targets[0].normals.clear();
    }),
];

#[test]
fn wrong_poses_are_caught() {
    let mut scene = moved(bending_mapped(), 0.9).without_shadows();
    scene.images[0] = texel();
    catches(&scene, Ask::EXACT, spoilt(&scene, FAULTS));
}
