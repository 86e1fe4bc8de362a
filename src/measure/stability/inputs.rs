//! Numbers that mean nothing, and numbers without measure: what of them reaches the picture.

use glam::{DVec3, Mat4, Vec3, Vec4};

use super::bench::light_of;
use super::parts::{add, bulb, camera, floor, plain, sphere, square, sun};
use super::{Answer, Bench, Bound, Case, Findings, Lab, Sweep, exact};
use crate::environment::Panorama;
use crate::gpu::View;
use crate::plan::{LightWay, Options, Tonemap};
use crate::scene::{
    AlphaMode, Background, Environment, Fog, FogHeight, Image, Light, LightKind, Projection, Sampler, Scene,
    Texture, TextureRef,
};
use crate::{Error, Result};

pub const INPUTS: Sweep = Sweep {
    name: "inputs",
    title: "NaN, infinity and numbers without measure in any input",
    varies: "each number of a scene and a view in turn: NaN, infinity, minus infinity, 3e38, -3e38, 1e-38",
    about: "A NaN in one pixel spreads with every filter, resolve and history that touches it. A file is checked when it is \
            loaded; a scene that is built by hand when a renderer is made.",
    needs_device: true,
    find: inputs,
};

/// Something of the scene becomes this number.
type Change = fn(&mut Scene, f32);

const INPUTS_OF_A_SCENE: &[(&str, &[Change])] = &[
    (
        "materials",
        &[
            |s, x| s.materials[0].base_color_factor.y = x,
            |s, x| s.materials[0].base_color_factor.w = x,
            |s, x| s.materials[0].metallic_factor = x,
            |s, x| s.materials[0].roughness_factor = x,
            |s, x| s.materials[0].normal_scale = x,
            |s, x| s.materials[0].occlusion_strength = x,
            |s, x| s.materials[0].emissive_factor.z = x,
            |s, x| s.materials[0].alpha_mode = AlphaMode::Mask { cutoff: x },
        ],
    ),
    (
        "texture transforms",
        &[|s, x| {
            let material = &mut s.materials[0];
            let slots = [&mut material.base_color_texture, &mut material.normal_texture];
            for slot in slots.into_iter().flatten() {
                slot.uv_from_texcoord[0].x = x;
            }
        }],
    ),
    ("vertex positions", &[|s, x| s.meshes[0].positions[30].x = x]),
    ("vertex normals", &[|s, x| s.meshes[0].normals.iter_mut().step_by(3).for_each(|n| n.y = x)]),
    (
        "vertex tangents",
        &[
            |s, x| s.meshes[0].tangents.iter_mut().step_by(3).for_each(|t| t.z = x),
            |s, x| s.meshes[0].tangents.iter_mut().step_by(3).for_each(|t| t.w = x),
        ],
    ),
    ("texture coordinates", &[|s, x| s.meshes[0].texcoords[0].iter_mut().step_by(3).for_each(|t| t.x = x)]),
    ("vertex colours", &[|s, x| s.meshes[0].colors.iter_mut().step_by(3).for_each(|c| c.y = x)]),
    (
        "placements",
        &[
            |s, x| s.instances[0].world_from_object.x_axis.x = x,
            |s, x| s.instances[0].world_from_object.w_axis.y = x,
        ],
    ),
    (
        "lights",
        &[
            |s, x| s.lights[1].color.x = x,
            |s, x| s.lights[1].position_world.y = x,
            |s, x| s.lights[1].range_m = Some(x),
            |s, x| s.lights[0].direction_world.y = x,
            |s, x| s.lights[0].kind = LightKind::Directional { illuminance_lx: x },
            |s, x| s.lights[1].kind = LightKind::Point { intensity_cd: x },
            |s, x| {
                s.lights[2].kind =
                    LightKind::Spot { intensity_cd: x, inner_cone_rad: 0.2, outer_cone_rad: 0.5 }
            },
            |s, x| {
                s.lights[2].kind =
                    LightKind::Spot { intensity_cd: 1.0, inner_cone_rad: x, outer_cone_rad: 0.5 }
            },
            |s, x| {
                s.lights[2].kind =
                    LightKind::Spot { intensity_cd: 1.0, inner_cone_rad: 0.2, outer_cone_rad: x }
            },
        ],
    ),
    ("light from all around", &[|s, x| s.ambient_nt.x = x]),
    (
        "fog",
        &[
            |s, x| s.fog.as_mut().expect("it has fog").density_per_m = x,
            |s, x| s.fog.as_mut().expect("it has fog").color_nt.x = x,
            |s, x| s.fog.as_mut().expect("it has fog").height = Some(FogHeight { base_m: x, scale_m: 1.0 }),
            |s, x| s.fog.as_mut().expect("it has fog").height = Some(FogHeight { base_m: 0.0, scale_m: x }),
        ],
    ),
    ("background", &[|s, x| s.background = Background::Color(Vec3::new(0.1, x, 0.2))]),
    (
        "cameras",
        &[
            |s, x| s.cameras[0].world_from_view.x_axis.x = x,
            |s, x| s.cameras[0].world_from_view.w_axis.y = x,
            |s, x| {
                s.cameras[0].projection = Projection::Perspective { yfov_rad: x, znear_m: 0.1, zfar_m: None }
            },
            |s, x| {
                s.cameras[0].projection = Projection::Perspective { yfov_rad: 0.7, znear_m: x, zfar_m: None }
            },
            |s, x| {
                s.cameras[0].projection =
                    Projection::Perspective { yfov_rad: 0.7, znear_m: 0.1, zfar_m: Some(x) }
            },
            |s, x| {
                s.cameras[0].projection =
                    Projection::Orthographic { xmag_m: 1.0, ymag_m: x, znear_m: 0.1, zfar_m: 9.0 }
            },
        ],
    ),
];

/// A scene that uses all of these.
fn scene() -> Scene {
    let mut scene = Scene { name: "inputs".into(), ..Scene::default() };
    scene.cameras.push(camera(Vec3::new(0.0, 1.0, 4.0), Vec3::ZERO));
    let mut ball = sphere();
    ball.colors = vec![Vec4::ONE; ball.positions.len()];
    let texel = |i: u32| [120 + (i % 7) as u8 * 4, 130, 250, 255];
    scene.images =
        vec![Image { name: "bumps".into(), width: 4, height: 4, texels: (0..16).flat_map(texel).collect() }];
    scene.textures = vec![Texture { image: 0, sampler: Sampler::default() }];
    let slot = Some(TextureRef { texture: 0, texcoord: 0, uv_from_texcoord: TextureRef::IDENTITY });
    let mut material = plain(Vec3::new(0.8, 0.6, 0.4), 0.5, 0.4);
    (material.base_color_texture, material.normal_texture, material.occlusion_texture) = (slot, slot, slot);
    material.emissive_factor = Vec3::splat(0.1);
    add(&mut scene, ball, material, Mat4::IDENTITY);
    add(
        &mut scene,
        square(),
        plain(Vec3::splat(0.5), 0.0, 0.0),
        Mat4::from_translation(Vec3::NEG_Y) * floor(3.0),
    );
    let spot = Light::new(LightKind::Spot { intensity_cd: 5.0, inner_cone_rad: 0.2, outer_cone_rad: 0.5 });
    let spot =
        Light { position_world: Vec3::new(1.0, 3.0, 1.0), ..spot }.towards(Vec3::new(-0.3, -1.0, -0.3));
    scene.lights =
        vec![sun(1.0, Vec3::new(-0.4, -1.0, -0.3)), bulb(4.0, Vec3::new(-1.5, 1.0, 1.5), Some(6.0)), spot];
    scene.ambient_nt = Vec3::splat(0.05);
    scene.fog = Some(Fog { color_nt: Vec3::splat(0.3), density_per_m: 0.05, height: None });
    scene.background = Background::Color(Vec3::new(0.1, 0.2, 0.3));
    scene
}

/// What became of one input.
#[derive(Default)]
struct Tally {
    tried: usize,
    refused: usize,
    unsound: usize,
    at: Option<String>,
}

impl Tally {
    /// Draws, and counts the pixels that are no colour.
    fn draw(
        &mut self,
        bench: &Bench,
        scene: &Scene,
        options: Options,
        exposure_ev: f32,
        what: impl Fn() -> String,
    ) -> Result<()> {
        self.tried += 1;
        let mut offscreen = match bench.offscreen(scene, options) {
            Err(Error::Unsupported { .. }) => {
                self.refused += 1;
                return Ok(());
            }
            other => other?,
        };
        offscreen.render(&View { camera: &scene.cameras[0], exposure_ev })?;
        self.count(&light_of(&offscreen.picture())?, what);
        Ok(())
    }

    /// Counts the pixels that are no colour.
    fn count(&mut self, light: &[DVec3], what: impl Fn() -> String) {
        let unsound = light.iter().filter(|light| !light.is_finite() || light.min_element() < 0.0).count();
        if unsound > self.unsound {
            (self.unsound, self.at) = (unsound, Some(what()));
        }
    }

    fn case(self, method: String) -> Case {
        let all_refused = self.refused == self.tried;
        let drawn = format!("{} of {} refused, the rest drawn", self.refused, self.tried);
        Case {
            method,
            worst: if all_refused { f64::NAN } else { self.unsound as f64 },
            at: self.at.unwrap_or(drawn),
            bound: Bound {
                name: "NO_COLOUR",
                unit: "pixels",
                good: 0.0,
                most: 0.0,
                reason: "a pixel that is NaN, infinite or negative is shown by no display and spoils its neighbours in any filter",
            },
            answer: all_refused.then_some(Answer::Refused),
            remedy: if all_refused {
                "refused with a message that names the element".into()
            } else {
                String::new()
            },
        }
    }
}

fn inputs(lab: &Lab<'_>) -> Result<Findings> {
    const ALL: [f32; 6] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 3e38, -3e38, 1e-38];
    let bench = lab.bench()?;
    let mut findings = Findings::default();
    // Curves that divide, the target that overflows, and the way that blends into it.
    let plain = |tonemap, lights| Options { tonemap, lights, ..exact([24, 16]) };
    let ways = [plain(Tonemap::Neutral, LightWay::Fullscreen), plain(Tonemap::Aces, LightWay::Volumes)];
    for (name, changes) in INPUTS_OF_A_SCENE {
        let mut tally = Tally::default();
        for (i, change) in changes.iter().enumerate() {
            for value in lab.pick(&ALL[..4], &ALL[..]) {
                let mut scene = scene();
                change(&mut scene, *value);
                for options in lab.pick(&ways[..1], &ways[..]) {
                    tally.draw(bench, &scene, options.clone(), 0.0, || {
                        format!("{value:e} in input {i} of these")
                    })?;
                }
            }
        }
        findings.cases.push(tally.case((*name).to_owned()));
    }
    findings.cases.push(views(lab)?);
    findings.cases.push(exposures(lab)?);
    findings.cases.push(bright_targets(lab)?);
    findings.cases.push(far_away(lab)?);
    Ok(findings)
}

/// Cameras that come with a frame and not with a scene, which recording cannot refuse: the surfaces vanish, the sky must not be
/// spoilt.
fn views(lab: &Lab<'_>) -> Result<Case> {
    let bench = lab.bench()?;
    let mut tally = Tally::default();
    for background in [Background::Color(Vec3::ONE), Background::Environment] {
        let mut scene = scene();
        scene.background = background;
        let texels = (0..32).map(|i| Vec3::new(1.0, 0.5, 0.2) * i as f32 * 0.1).collect();
        scene.environment = Some(Environment::new("steps", Panorama::new(8, 4, texels)?));
        let mut offscreen =
            bench.offscreen(&scene, Options { tonemap: Tonemap::Neutral, ..exact([24, 16]) })?;
        let cameras =
            INPUTS_OF_A_SCENE.iter().filter(|(name, _)| *name == "cameras").flat_map(|(_, changes)| *changes);
        for (i, change) in cameras.enumerate() {
            for value in [f32::NAN, f32::INFINITY, 3e38, 0.0] {
                let mut scene = scene.clone();
                change(&mut scene, value);
                offscreen.render(&View { camera: &scene.cameras[0], exposure_ev: 0.0 })?;
                tally.tried += 1;
                tally.count(&light_of(&offscreen.picture())?, || {
                    format!("{value:e} in input {i} of a camera")
                });
            }
        }
    }
    Ok(tally.case("cameras of frames".into()))
}

/// Exposures that no scene needs.
fn exposures(lab: &Lab<'_>) -> Result<Case> {
    let mut tally = Tally::default();
    for &tonemap in Tonemap::ALL {
        for exposure_ev in [-200.0, -64.0, 64.0, 127.0, 200.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN] {
            let options = Options { tonemap, ..exact([24, 16]) };
            tally.draw(lab.bench()?, &scene(), options, exposure_ev, || {
                format!("{exposure_ev} EV, {tonemap}")
            })?;
        }
    }
    Ok(tally.case("exposure".into()))
}

/// Highlights that overflow half floats: a mirror under lights of up to 1e9 lx, in every layout, added one by one.
fn bright_targets(lab: &Lab<'_>) -> Result<Case> {
    let mut tally = Tally::default();
    for &layout in crate::plan::Layout::ALL {
        for &tonemap in Tonemap::ALL {
            for lights in [LightWay::Fullscreen, LightWay::Volumes] {
                for brightness in [1e3, 1e6, 1e9] {
                    let mut scene = scene();
                    scene.fog = None;
                    (scene.materials[0].metallic_factor, scene.materials[0].roughness_factor) = (1.0, 0.0);
                    scene.lights.iter_mut().for_each(|light| light.color *= brightness);
                    let options = Options { layout, tonemap, lights, ..exact([24, 16]) };
                    let what = || format!("{brightness:e} lx, {layout}, {tonemap}, {lights}");
                    tally.draw(lab.bench()?, &scene, options, 0.0, what)?;
                }
            }
        }
    }
    Ok(tally.case("highlights above half floats".into()))
}

/// The scene 100 km from the world's origin, and seen from 100 km away, in every layout: positions in half floats end at 65 km.
fn far_away(lab: &Lab<'_>) -> Result<Case> {
    let mut tally = Tally::default();
    for &layout in crate::plan::Layout::ALL {
        for far_camera in [false, true] {
            let mut scene = scene();
            let away = Mat4::from_translation(Vec3::new(1e5, -1e5, 1e5));
            scene.instances.iter_mut().for_each(|i| i.world_from_object = away * i.world_from_object);
            scene.instances[1].world_from_object *= Mat4::from_scale(Vec3::splat(1e4));
            scene
                .lights
                .iter_mut()
                .for_each(|light| light.position_world = away.transform_point3(light.position_world));
            if !far_camera {
                scene.cameras[0].world_from_view = away * scene.cameras[0].world_from_view;
            } else {
                scene.cameras[0] = camera(Vec3::ZERO, Vec3::new(1e5, -1e5, 1e5));
            }
            scene.materials[0].emissive_factor = Vec3::ZERO;
            (scene.ambient_nt, scene.fog) = (Vec3::ZERO, None);
            let options = Options { layout, tonemap: Tonemap::Neutral, ..exact([24, 16]) };
            tally.draw(lab.bench()?, &scene, options, 0.0, || {
                format!("{layout}, camera at the origin: {far_camera}")
            })?;
        }
    }
    Ok(tally.case("100 km from the origin".into()))
}
