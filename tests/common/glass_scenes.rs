//! Scenes in which surfaces are blended over what is behind them.

use super::*;

/// All of them.
pub fn all() -> Vec<Scene> {
    vec![glass(), glass_in_fog(), glass_before_sky(), glass_unlit(), glass_alone()]
}

/// [`lights_only`] behind and between panes: one-sided, two-sided, unlit, glowing, thinned out by vertex colours, wholly clear
/// and wholly opaque; two balls. No two cross each other.
pub fn glass() -> Scene {
    with_panes("glass", lights_only())
}

/// [`foggy`] likewise, before a background colour.
pub fn glass_in_fog() -> Scene {
    with_panes("glass_in_fog", foggy())
}

/// [`before_sky`] likewise.
pub fn glass_before_sky() -> Scene {
    with_panes("glass_before_sky", before_sky())
}

/// [`wholly_unlit`], where half of the materials are blended.
pub fn glass_unlit() -> Scene {
    let mut scene = Scene { name: "glass_unlit".into(), ..wholly_unlit() };
    for material in scene.materials.iter_mut().skip(1).step_by(2) {
        material.alpha_mode = AlphaMode::Blend;
        material.base_color_factor.w *= 0.6;
    }
    scene
}

/// Panes alone, before a background colour.
pub fn glass_alone() -> Scene {
    let background = Background::Color(Vec3::new(0.3, 0.15, 0.05));
    let dark = Scene { cameras: vec![camera()], lights: lights(), background, ..Scene::default() };
    with_panes("glass_alone", dark)
}

/// Panes that cross each other in one line, before [`lights_only`]: no order of objects is right.
pub fn crossing() -> Scene {
    let mut scene = Scene { name: "crossing".into(), ..lights_only() };
    let colors = [Vec3::new(0.9, 0.1, 0.1), Vec3::new(0.1, 0.8, 0.1), Vec3::new(0.1, 0.2, 0.9)];
    for (i, color) in colors.into_iter().enumerate() {
        let name = ["red", "green", "blue"][i];
        let pane = Material { double_sided: true, ..tinted(name, color, 0.6) };
        let turn = Mat4::from_rotation_y(0.5 + i as f32 * PI / 3.0);
        add(&mut scene, self::pane(), pane, &[at(0.0, 0.7, 1.0) * turn * Mat4::from_scale(Vec3::splat(0.6))]);
    }
    scene
}

/// Seven panes behind each other.
pub fn stacked() -> Scene {
    let mut scene = Scene { name: "stacked".into(), ..lights_only() };
    for i in 0..7_u8 {
        let t = f32::from(i) / 6.0;
        let color = Vec3::new(t, 0.5 - 0.4 * t, 1.0 - t);
        let name = format!("sheet {i}");
        let place = at(0.1 * t - 0.2, 0.7, 0.4 + 1.4 * t) * Mat4::from_scale(Vec3::splat(0.6 - 0.2 * t));
        add(&mut scene, pane(), tinted(&name, color, 0.3), &[place]);
    }
    scene
}

/// A blended material.
pub fn tinted(name: &str, base_color: Vec3, alpha: f32) -> Material {
    Material {
        base_color_factor: base_color.extend(alpha),
        alpha_mode: AlphaMode::Blend,
        roughness_factor: 0.4,
        ..rough(name, base_color)
    }
}

/// [`square`] in four pieces: drivers warn of tiny draws.
pub fn pane() -> Mesh {
    let mut mesh = Mesh::default();
    for (row, column) in (0..3_u32).flat_map(|row| (0..3).map(move |column| (row, column))) {
        mesh.positions.push(Vec3::new(column as f32 - 1.0, 1.0 - row as f32, 0.0));
        if row < 2 && column < 2 {
            let a = row * 3 + column;
            mesh.indices.extend([a, a + 3, a + 1, a + 1, a + 3, a + 4]);
        }
    }
    mesh.normals = vec![Vec3::Z; 9];
    mesh
}

/// A scene behind and between panes.
pub fn with_panes(name: &str, mut scene: Scene) -> Scene {
    scene.name = name.into();
    let placed = |x: f32, y: f32, z: f32, turn: f32, half: f32| {
        at(x, y, z) * Mat4::from_rotation_y(turn) * Mat4::from_scale(Vec3::splat(half))
    };
    let red = tinted("red", Vec3::new(0.9, 0.15, 0.1), 0.5);
    add(&mut scene, pane(), red, &[placed(-0.7, 0.7, 0.8, 0.2, 0.4), placed(-0.3, 0.8, 1.3, -0.1, 0.3)]);
    let green = Material { double_sided: true, ..tinted("green", Vec3::new(0.1, 0.7, 0.2), 0.35) };
    add(&mut scene, pane(), green, &[placed(0.3, 0.6, 1.0, PI - 0.3, 0.4)]);
    let glow =
        Material { emissive_factor: Vec3::new(0.1, 0.3, 0.9), ..tinted("glow", Vec3::splat(0.2), 0.6) };
    add(&mut scene, pane(), glow, &[placed(1.05, 0.9, 1.0, 0.0, 0.25)]);
    let plain = Material { unlit: true, ..tinted("plain", Vec3::new(0.8, 0.7, 0.2), 0.4) };
    add(&mut scene, pane(), plain, &[placed(0.0, 0.4, 1.6, 0.0, 0.25)]);
    let mut thinned = pane();
    let thin = |p: &Vec3| Vec4::new(1.0, 0.9, 0.8, 0.5 + 0.25 * (p.x + p.y));
    thinned.colors = thinned.positions.iter().map(thin).collect();
    add(
        &mut scene,
        thinned,
        tinted("thinned", Vec3::new(0.4, 0.5, 0.9), 1.0),
        &[placed(-1.1, 0.5, 1.2, 0.4, 0.3)],
    );
    add(&mut scene, pane(), tinted("clear", Vec3::ONE, 0.0), &[placed(0.4, 1.1, 0.9, 0.0, 0.2)]);
    add(
        &mut scene,
        pane(),
        tinted("solid", Vec3::new(0.6, 0.6, 0.5), 1.0),
        &[placed(-0.2, 1.25, 0.2, 0.0, 0.15)],
    );
    let ball = tinted("ball", Vec3::new(0.7, 0.8, 0.9), 0.3);
    add(&mut scene, sphere(), ball, &[placed(0.1, 0.3, 0.5, 0.0, 0.25), placed(1.4, 0.3, 1.0, 0.0, -0.2)]);
    scene
}
