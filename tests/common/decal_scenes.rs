//! What decals are tested with.

use super::*;
use ontile::scene::{Decal, DecalChannels};

/// A box that paints what lies under it.
fn onto_floor(x: f32, z: f32, size: Vec3) -> Mat4 {
    at(x, 0.0, z) * Mat4::from_rotation_x(-PI / 2.0) * Mat4::from_rotation_z(0.3) * Mat4::from_scale(size)
}

/// A texture that is looked up in its own texels alone, whatever its size on the image.
fn plain_texture(scene: &mut Scene, image: Image) -> TextureRef {
    scene.images.push(image);
    let sampler = Sampler { mip_linear: None, ..Sampler::default() };
    scene.textures.push(Texture { image: scene.images.len() - 1, sampler });
    texture(scene.textures.len() - 1)
}

fn material(scene: &mut Scene, material: Material) -> usize {
    scene.materials.push(material);
    scene.materials.len() - 1
}

/// [`decals`] behind and between panes.
pub fn decals_behind_glass() -> Scene {
    glass_scenes::with_panes("decals_behind_glass", decals())
}

/// Colours that are painted over each other on a floor and two balls; nothing that blending could not do.
pub fn color_decals() -> Scene {
    let mut scene = Scene { name: "color_decals".into(), ..lights_only() };
    let tiles = plain_texture(&mut scene, tiles());
    let tiled = Material { base_color_texture: Some(tiles), ..rough("tiled", Vec3::new(0.9, 0.8, 0.7)) };
    let tiled = material(&mut scene, tiled);
    let red = material(&mut scene, rough("red", Vec3::new(0.8, 0.05, 0.03)));
    let color = |name: &str, material, place, base_color| Decal {
        name: name.into(),
        channels: DecalChannels { base_color, ..DecalChannels::NONE },
        ..Decal::new(material, place)
    };
    scene.decals = vec![
        color("tiles", tiled, onto_floor(0.2, 0.6, Vec3::new(1.6, 1.2, 0.4)), 1.0),
        Decal {
            falloff_m: Vec3::new(0.2, 0.1, 0.05),
            ..color("stain", red, onto_floor(-0.3, 0.8, Vec3::new(0.9, 0.9, 0.3)), 0.7)
        },
        // Under the others, by priority.
        Decal { priority: -1.0, ..color("under", red, onto_floor(0.5, 0.4, Vec3::new(1.2, 1.0, 0.3)), 1.0) },
        // From the front, over both balls and the floor between them.
        color("band", tiled, at(0.0, 0.5, 0.3) * Mat4::from_scale(Vec3::new(3.4, 0.3, 2.0)), 0.5),
        // Nothing is left of it.
        color("nothing", red, onto_floor(0.0, 0.0, Vec3::ONE), 0.0),
    ];
    scene
}

/// Every channel and combinations of them, over every kind of surface, in a corner, mirrored, sheared and around the camera.
pub fn decals() -> Scene {
    let mut scene = Scene { name: "decals".into(), ..every_feature() };
    let wall = at(0.0, 1.5, -1.2) * Mat4::from_scale(Vec3::splat(3.0));
    add(&mut scene, square(), rough("wall", Vec3::new(0.5, 0.55, 0.6)), &[wall]);
    let (picture, dents) = (plain_texture(&mut scene, tiles()), plain_texture(&mut scene, bumps()));
    let twice =
        TextureRef { uv_from_texcoord: [Vec3::new(2.0, 0.3, 0.1), Vec3::new(-0.3, 2.0, 0.0)], ..dents };
    let foil = Material {
        metallic_factor: 1.0,
        roughness_factor: 0.25,
        base_color_texture: Some(picture),
        ..rough("foil", Vec3::new(0.95, 0.7, 0.3))
    };
    let foil = material(&mut scene, foil);
    let dented = Material { normal_texture: Some(twice), normal_scale: 0.8, ..rough("dented", Vec3::ONE) };
    let dented = material(&mut scene, dented);
    let worn = Material {
        metallic_roughness_texture: Some(picture),
        base_color_texture: Some(twice),
        normal_texture: Some(dents),
        ..rough("worn", Vec3::new(0.3, 0.5, 0.9))
    };
    let worn = material(&mut scene, worn);
    let only = |channels| move |decal: Decal| Decal { channels, ..decal };
    let none = DecalChannels::NONE;
    let named = |name: &str, material, place| Decal { name: name.into(), ..Decal::new(material, place) };
    let sheared = Mat4::from_cols(
        Vec4::new(1.0, 0.1, 0.0, 0.0),
        Vec4::new(0.3, 0.9, 0.1, 0.0),
        Vec4::new(0.0, -0.2, 1.2, 0.0),
        Vec4::new(0.9, 0.7, -1.0, 1.0),
    );
    let mirror = Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    scene.decals = vec![
        // Into the corner of floor and wall.
        named(
            "foil",
            foil,
            at(-0.7, 0.1, -1.0) * Mat4::from_rotation_x(-0.8) * Mat4::from_scale(Vec3::new(1.1, 1.0, 1.2)),
        ),
        only(DecalChannels { normal: 1.0, ..none })(named(
            "dents",
            dented,
            onto_floor(0.3, 0.7, Vec3::new(1.5, 1.2, 0.4)),
        )),
        only(DecalChannels { normal: 0.6, ..none })(named(
            "mirrored dents",
            dented,
            at(-1.1, 0.5, 0.4) * mirror * Mat4::from_scale(Vec3::new(0.8, 0.8, 1.0)),
        )),
        Decal {
            channels: DecalChannels { roughness: 0.9, ..none },
            falloff_m: Vec3::new(0.4, 0.4, 0.1),
            angle_rad: [0.3, 1.2],
            ..named("wet", worn, onto_floor(-0.2, 1.0, Vec3::new(1.8, 1.0, 0.4)))
        },
        only(DecalChannels { metallic: 0.5, base_color: 0.4, ..none })(named(
            "gilt",
            foil,
            at(1.1, 0.6, 0.4) * Mat4::from_scale(Vec3::new(0.7, 0.6, 0.9)),
        )),
        Decal { priority: 2.0, ..named("worn", worn, sheared) },
        // The camera is in it.
        only(DecalChannels { roughness: 0.3, base_color: 0.2, ..none })(named(
            "all",
            worn,
            at(0.0, 1.0, 1.0) * Mat4::from_rotation_x(-0.6) * Mat4::from_scale(Vec3::new(3.0, 3.0, 8.0)),
        )),
    ];
    scene
}
