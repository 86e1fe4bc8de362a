//! Scenes whose parts bend and move.

use super::*;
use ontile::glam::Quat;
use ontile::scene::{
    Animation, Channel, Deformation, Follower, Follows, Influence, Interpolation, MorphTarget, Motion, Node,
    NodeTransform, Particle, Particles, Play, Pose, Property, Shadow, Skin,
};

/// As they are drawn: at a time when nothing is at rest.
pub fn all() -> Vec<Scene> {
    vec![moved(bending(), 0.7), moved(bending_mapped(), 1.1)]
}

/// The scene at a time.
pub fn moved(mut scene: Scene, time_s: f64) -> Scene {
    scene.animate(&[Play { animation: 0, time_s }]).expect("it has an animation");
    scene
}

/// Of the nodes: where the arm's joints begin, the blob, the ball, the lamp, the eye.
const JOINTS: usize = 1;
const BLOB: usize = 4;
const BALL: usize = 5;
const LAMP: usize = 6;
const EYE: usize = 7;

/// [`shadow_scenes::room`] with an arm of three joints that bends, stretches and is sheared, a blob with two morph targets, a ball that rolls,
/// a spot that swings and a camera that nears; a sun and a bulb, all with shadows.
pub fn bending() -> Scene {
    let room = shadow_scenes::room();
    let mut scene =
        Scene { name: "bending".into(), cameras: room.cameras, lights: Vec::new(), ..Scene::default() };
    let floor = Mat4::from_rotation_x(-PI / 2.0) * Mat4::from_scale(Vec3::splat(4.0));
    let wall = at(0.0, 2.0, -2.0) * Mat4::from_scale(Vec3::splat(4.0));
    add(&mut scene, square(), rough("floor", Vec3::splat(0.6)), &[floor, wall]);
    add(&mut scene, arm(), rough("arm", Vec3::new(0.7, 0.4, 0.3)), &[Mat4::IDENTITY]);
    add(&mut scene, blob(), rough("blob", Vec3::new(0.4, 0.6, 0.3)), &[at(1.0, 0.5, 0.3)]);
    let ball = Mat4::from_scale(Vec3::splat(0.25));
    add(&mut scene, sphere(), rough("ball", Vec3::new(0.4, 0.5, 0.7)), &[at(-1.2, 0.25, 0.9) * ball]);
    for mesh in &mut scene.meshes {
        mesh.tangents.clear();
        mesh.texcoords = Default::default();
        let targets = mesh.deformation.iter_mut().flat_map(|deformation| &mut deformation.targets);
        targets.for_each(|target| target.tangents.clear());
    }
    let lights = shadow_scenes::one_light_each().into_iter().flat_map(|scene| scene.lights);
    scene.lights = lights.filter(|light| ["sun", "spot", "bulb"].contains(&&*light.name)).collect();
    scene.lights[1].dynamic = true;
    // Arm, blob, ball: after floor and wall.
    scene.instances[2..].iter_mut().for_each(|instance| instance.dynamic = true);
    scene.motion = Some(motion(&scene.lights[1], &scene.cameras[0]));
    scene
}

/// With sparks that follow the ball.
pub fn with_sparks(mut scene: Scene) -> Scene {
    let glow = Material { emissive_factor: Vec3::new(3.0, 1.5, 0.5), ..Material::default() };
    scene.materials.push(glow);
    let positions_node = vec![Vec3::new(0.0, 2.0, 0.0), Vec3::new(1.5, 1.0, 0.0)];
    let spark = Particle { position_world: Vec3::ZERO, size_m: 0.3, rotation_rad: 0.3, color: Vec3::ONE };
    let list = vec![spark; positions_node.len()];
    let what = Follows::Particles { particles: scene.particles.len(), positions_node };
    scene.particles.push(Particles::new(scene.materials.len() - 1, 0.1, list));
    scene.motion.as_mut().expect("it moves").followers.push(Follower { node: BALL, what });
    scene
}

/// The same with normal maps, whose tangents bend too, and an arm that is seen through.
pub fn bending_mapped() -> Scene {
    let mut scene = Scene { name: "bending_mapped".into(), ..bending() };
    scene.images = vec![bumps()];
    scene.textures = vec![Texture { image: 0, sampler: Sampler::default() }];
    let (arm, blob) = (arm(), blob());
    for (index, mesh) in [(1, arm), (2, blob)] {
        let pose = scene.meshes[index].deformation.as_ref().expect("it bends").pose.clone();
        let material = scene.meshes[index].material;
        scene.meshes[index] = Mesh { material, ..mesh };
        scene.meshes[index].deformation.as_mut().expect("it bends").pose = pose;
        scene.materials[material].normal_texture = Some(texture(0));
    }
    let material = scene.meshes[1].material;
    scene.materials[material].alpha_mode = AlphaMode::Blend;
    scene.materials[material].base_color_factor.w = 0.6;
    scene
}

/// A tube along +Y from 0 to 1.6 whose vertices go by two of three joints, with eight places for them: two sets, which
/// together add up to 1 or to 2.
fn arm() -> Mesh {
    const RINGS: u32 = 24;
    const SECTORS: u32 = 20;
    let mut mesh = Mesh::default();
    let mut influences = Vec::new();
    for ring in 0..=RINGS {
        for sector in 0..=SECTORS {
            let (along, phi) = (ring as f32 / RINGS as f32, TAU * sector as f32 / SECTORS as f32);
            let out = Vec3::new(phi.sin(), 0.0, phi.cos());
            mesh.positions.push(out * (0.22 - 0.1 * along) + Vec3::Y * (1.6 * along));
            mesh.normals.push((out + Vec3::Y * 0.0625).normalize());
            mesh.tangents.push(Vec4::new(phi.cos(), 0.0, -phi.sin(), 1.0));
            mesh.texcoords[0].push(Vec2::new(phi / TAU * 2.0, -2.0 * along));
            let place = along * 2.0;
            let first = (place as u16).min(1);
            let share = place - f32::from(first);
            // Smooth, so that normals turn as surfaces do.
            let share = share * share * (3.0 - 2.0 * share);
            // What counts is each weight's share.
            let all = if ring % 2 == 0 { 1.0 } else { 2.0 };
            let weights = [all * (1.0 - share), 0.0, 0.0, 0.0];
            influences.push(Influence { joints: [first, 0, 0, 0], weights });
            let rest = [0.0, 0.25 * share, 0.0, 0.75 * share].map(|weight| all * weight);
            influences.push(Influence { joints: [0, first + 1, 2, first + 1], weights: rest });
            if ring < RINGS && sector < SECTORS {
                let a = ring * (SECTORS + 1) + sector;
                let b = a + SECTORS + 1;
                mesh.indices.extend([a, a + 1, b, a + 1, b + 1, b]);
            }
        }
    }
    let pose = Pose { object_from_bind: vec![Mat4::IDENTITY; 3], weights: Vec::new() };
    mesh.deformation = Some(Deformation { influences, targets: Vec::new(), pose });
    mesh
}

/// A ball that swells above and is drawn out sideways.
fn blob() -> Mesh {
    let mut mesh = sphere();
    mesh.positions.iter_mut().for_each(|p| *p *= 0.4);
    let positions: Vec<_> = mesh.positions.iter().map(|p| Vec3::Y * (p.y + 0.4) * 0.8).collect();
    let normals: Vec<_> = mesh.normals.iter().map(|n| Vec3::Y * (-0.6 * n.y)).collect();
    let up = MorphTarget { positions, normals, tangents: Vec::new() };
    let positions = mesh.positions.iter().map(|p| Vec3::X * p.x * p.x.abs()).collect();
    let tangents = mesh.tangents.iter().map(|t| Vec3::X * t.x).collect();
    let side = MorphTarget { positions, normals: Vec::new(), tangents };
    let pose = Pose { object_from_bind: Vec::new(), weights: vec![0.0; 2] };
    mesh.deformation = Some(Deformation { influences: Vec::new(), targets: vec![up, side], pose });
    mesh
}

fn node(name: &str, parent: Option<usize>, translation: Vec3, rotation: Quat) -> Node {
    let transform = NodeTransform::Parts { translation, rotation, scale: Vec3::ONE };
    Node { name: name.into(), parent, transform, weights: Vec::new() }
}

fn motion(spot: &Light, camera: &Camera) -> Motion {
    let towards = Quat::from_rotation_arc(Vec3::NEG_Z, spot.direction_world);
    let (_, looking, eye) = camera.world_from_view.to_scale_rotation_translation();
    let mut nodes = vec![
        node("stand", None, Vec3::new(-0.3, 0.0, 0.2), Quat::from_rotation_y(0.4)),
        node("shoulder", Some(0), Vec3::ZERO, Quat::IDENTITY),
        node("elbow", Some(JOINTS), Vec3::Y * 0.8, Quat::IDENTITY),
        node("hand", Some(JOINTS + 1), Vec3::Y * 0.8, Quat::IDENTITY),
        node("blob", None, Vec3::new(1.0, 0.5, 0.3), Quat::IDENTITY),
        node("ball", None, Vec3::new(-1.2, 0.25, 0.9), Quat::IDENTITY),
        node("spot", None, spot.position_world, towards),
        node("eye", None, eye, looking),
    ];
    nodes[BLOB].weights = vec![0.0; 2];
    if let NodeTransform::Parts { scale, .. } = &mut nodes[BALL].transform {
        *scale = Vec3::splat(0.25);
    }
    let bind = |height: f32| Mat4::from_translation(Vec3::Y * -height);
    let skin = Skin { joints: vec![1, 2, 3], joint_from_bind: [0.0, 0.8, 1.6].map(bind).to_vec() };
    let follows = |node, what| Follower { node, what };
    Motion {
        nodes,
        skins: vec![skin],
        followers: vec![
            follows(0, Follows::Skin { mesh: 1, instance: 2, skin: 0 }),
            follows(BLOB, Follows::Weights { mesh: 2 }),
            follows(BLOB, Follows::Instance(3)),
            follows(BALL, Follows::Instance(4)),
            follows(LAMP, Follows::Light(1)),
            follows(EYE, Follows::Camera(0)),
        ],
        animations: vec![Animation { name: "all".into(), channels: channels(spot.position_world, eye) }],
    }
}

fn channels(lamp: Vec3, eye: Vec3) -> Vec<Channel> {
    let channel = |node, property, interpolation, times_s: &[f32], values: Vec<f32>| Channel {
        node,
        property,
        interpolation,
        times_s: times_s.to_vec(),
        values,
    };
    let turns = |axis: Vec3, angles: &[f32]| -> Vec<f32> {
        angles.iter().flat_map(|&a| Quat::from_axis_angle(axis, a).to_array()).collect()
    };
    let flat = |list: &[[f32; 3]]| list.concat();
    use Interpolation::{CubicSpline, Linear, Step};
    let none = [0.0; 3];
    let stretch = [none, [1.0; 3], none, none, [0.8, 1.3, 1.6], none, none, [1.0; 3], none];
    let [x, y, z] = lamp.to_array();
    let near = eye - (eye - Vec3::Y * 0.5) * 0.15;
    vec![
        channel(JOINTS, Property::Rotation, Linear, &[0.0, 1.0, 2.0], turns(Vec3::Z, &[0.0, -0.5, 0.0])),
        channel(JOINTS + 1, Property::Rotation, Linear, &[0.0, 1.0, 2.0], turns(Vec3::X, &[0.0, 1.6, 0.0])),
        channel(JOINTS + 1, Property::Scale, CubicSpline, &[0.0, 1.0, 2.0], flat(&stretch)),
        channel(JOINTS + 2, Property::Rotation, Linear, &[0.0, 2.0], turns(Vec3::Y, &[0.0, 1.2])),
        channel(BLOB, Property::Weights, Linear, &[0.0, 1.0, 2.0], vec![0.0, 0.0, 1.0, -0.4, 0.2, 0.9]),
        channel(BLOB, Property::Rotation, Linear, &[0.0, 2.0], turns(Vec3::Y, &[0.0, 1.0])),
        channel(
            BALL,
            Property::Translation,
            Linear,
            &[0.0, 2.0],
            flat(&[[-1.2, 0.25, 0.9], [0.4, 0.25, 1.2]]),
        ),
        channel(LAMP, Property::Translation, Linear, &[0.0, 2.0], flat(&[[x, y, z], [x - 0.6, y + 0.2, z]])),
        channel(EYE, Property::Translation, Step, &[0.0, 1.5], flat(&[eye.to_array(), near.to_array()])),
    ]
}

/// The same in the same pose, but of meshes that nothing bends: posed here, once.
pub fn frozen(mut scene: Scene) -> Scene {
    scene.meshes = scene.meshes.iter().map(|mesh| mesh.posed().into_owned()).collect();
    scene.motion = None;
    scene
}

/// Without what the lights of [`bending`] have of sun: what cascades show depends on all that was there before.
pub fn with_lamps_alone(mut scene: Scene) -> Scene {
    scene.lights[0].shadow = None;
    scene.lights[2].shadow = Some(Shadow::default());
    scene
}
