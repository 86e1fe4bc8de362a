use super::*;
use crate::plan::{Layout, Normals, Options};
use crate::reference::testing::{camera_at, direction, perspective};
use crate::reference::texture::srgb_from_linear;
use glam::Vec3;

fn view() -> View {
    View::new(&camera_at(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, perspective(0.8, 0.1, Some(100.0))), [64, 64])
}

fn gbuffer(layout: Layout) -> GBuffer {
    GBuffer::new(&Options { layout, ..Options::default() }).unwrap()
}

fn surface(view: &View, pixel: [u32; 2]) -> Attributes {
    Attributes {
        lit: true,
        depth: view.depth_from_distance(4.2),
        position_world: view.ray_through_pixel(pixel).at(4.2),
        normal_world: direction(0.7, 1.1),
        roughness: 0.333,
        base_color: DVec3::new(0.01, 0.25, 0.9),
        metallic: 0.6,
        reflectance: None,
        prelit: DVec3::new(0.1, 0.2, 0.05),
    }
}

fn angle_degrees(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b)).to_degrees()
}

#[test]
fn metallic128_errs_by_half_a_step_at_most() {
    let (view, pixel) = (view(), [10, 50]);
    let exact = surface(&view, pixel);
    let stored = quantise(&gbuffer(Layout::Metallic128), &exact, &view, pixel, 1.0);
    assert!((stored.roughness - exact.roughness).abs() <= 0.5 / 255.0);
    assert!((stored.metallic - exact.metallic).abs() <= 0.5 / 255.0);
    assert!((stored.prelit - exact.prelit).abs().max_element() <= 0.5 / 1023.0);
    for k in 0..3 {
        let encoded = |c: DVec3| srgb_from_linear(c[k]);
        assert!((encoded(stored.base_color) - encoded(exact.base_color)).abs() <= 0.5 / 255.0 + 1e-12);
    }
    // Each axis is off by at most a step of 2/255, halved; the angle by at most 0.39 degrees.
    let degrees = angle_degrees(stored.normal_world, exact.normal_world);
    assert!(degrees > 1e-3 && degrees < 0.39, "{degrees}");
    // Reversed f32 depth: a relative step of 2^-24 in depth is one in distance where the far plane is far.
    let off = (stored.position_world - exact.position_world).length();
    assert!(off > 0.0 && off < 4.2 * 2.0_f64.powi(-23), "{off}");
}

#[test]
fn exact_errs_by_a_float_step() {
    let (view, pixel) = (view(), [33, 3]);
    let exact = surface(&view, pixel);
    let stored = quantise(&GBuffer::exact(), &exact, &view, pixel, 4.0);
    let step = 2.0_f64.powi(-23);
    assert!((stored.normal_world - exact.normal_world).length() < step);
    assert!((stored.base_color - exact.base_color).length() < step);
    assert!((stored.prelit - exact.prelit).length() < step);
    assert_ne!(stored.roughness, exact.roughness);
    assert!((stored.roughness - exact.roughness).abs() < step);
}

/// What each layout may lose at most: of the normal in degrees, of diffuse albedo and reflectance, of roughness, of the position in
/// metres (five metres from the viewer), of light as a share.
const MOST_LOST: [(Layout, [f64; 5]); 13] = [
    // 8 bits of xyz; sRGB steps are at most 0.0045 near white, halved; 1 / 510; f32 depth; half of 1 / 1023 of 0.05.
    (Layout::Metallic128, [0.39, 0.0045, 0.002, 1e-6, 0.01]),
    (Layout::Specular160, [0.39, 0.0025, 0.002, 1e-6, 0.01]),
    // Half floats: 2^-11 of each component; 2^-7 and 2^-6 of colours; 2^-11 of light.
    (Layout::Metallic256, [0.04, 0.009, 2.5e-4, 1e-6, 5e-4]),
    // b10g11r11 of normal / 2 + 1/2: 2^-8 and 2^-7.
    (Layout::Specular256, [0.9, 0.009, 2.5e-4, 1e-6, 5e-4]),
    // Half-float positions: 2^-11 of 5 m.
    (Layout::Thibieroz128, [0.1, 0.0045, 2.5e-4, 5e-3, 0.01]),
    // No roughness, no metallicness.
    (Layout::Thibieroz96, [0.39, f64::INFINITY, f64::INFINITY, 5e-3, 0.01]),
    // x and y in 8 bits; z amplifies their error as the normal turns from the viewer (n.z = 0.7: by 1.4).
    (Layout::Rasa128, [0.5, 0.0025, 0.002, 1e-6, 0.01]),
    (Layout::Dissertation192, [0.04, 5e-4, 2.5e-4, 5e-3, 5e-4]),
    (Layout::Ontile128, [0.06, 0.0045, 0.002, 1e-6, 5e-4]),
    (Layout::Ontile96, [0.06, 0.0045, 0.002, 1e-6, 0.016]),
    (Layout::Ontile64, [0.06, 0.0045, 0.002, 1e-6, f64::INFINITY]),
    // Metallicness in 6 bits is off by 1 / 126, times 0.9 of colour; light by half of 2^-9 of 0.25, of which 0.05 is a fifth.
    (Layout::Packed128, [0.12, 0.01, 0.001, 1e-6, 0.005]),
    (Layout::Exact, [1e-4, 1e-6, 1e-6, 1e-6, 1e-6]),
];

#[test]
fn every_layout_loses_what_its_formats_say() {
    let bounded = MOST_LOST.map(|(layout, _)| layout);
    assert!(Layout::ALL.iter().all(|layout| bounded.contains(layout)), "{bounded:?}");
    let (view, pixel) = (view(), [10, 50]);
    let exact = surface(&view, pixel);
    for (layout, most) in MOST_LOST {
        let kept = quantise(&gbuffer(layout), &exact, &view, pixel, 1.0);
        assert!(kept.lit, "{layout}");
        let share = (kept.prelit - exact.prelit).abs() / exact.prelit;
        let lost = [
            angle_degrees(kept.normal_world, exact.normal_world),
            (kept.diffuse() - exact.diffuse()).abs().max((kept.f0() - exact.f0()).abs()).max_element(),
            (kept.roughness - exact.roughness).abs(),
            (kept.position_world - exact.position_world).length(),
            share.max_element(),
        ];
        let within = lost.iter().zip(most).all(|(lost, most)| *lost <= most);
        assert!(within, "{layout}: {lost:?}, at most {most:?}");
        assert!((kept.depth / exact.depth - 1.0).abs() < 2e-3, "{layout}");
    }
}

/// The greatest error over directions of the whole sphere, or of the half that faces the viewer, in degrees.
fn greatest_error(normals: Normals, facing: bool) -> f64 {
    let view = view();
    let count = 20_000;
    let spiral = (0..count).map(|i| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
        let angle = f64::from(i) * 2.399_963_229_728_653;
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * angle.cos(), r * angle.sin(), z)
    });
    let axes = [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
    let wanted = spiral.chain(axes).filter(|n| !facing || (world_from_view(&view).transpose() * *n).z > 0.0);
    wanted.fold(0.0, |most: f64, n| {
        let stored = normals::encode(normals, n, 0.5, &view);
        let (back, roughness) = normals::decode(normals, stored, &view).expect("it is lit");
        assert!(
            (roughness - 0.5).abs() <= 0.5 / 255.0 && (back.length() - 1.0).abs() < 1e-6,
            "{normals} {n}"
        );
        most.max(angle_degrees(back, n))
    })
}

#[test]
fn encodings_of_normals_err_by_what_they_are_said_to() {
    // Whole sphere: design figures of 4 million directions with one step more; the axes are exact here.
    for (normals, most) in [
        (Normals::Xyz8, 0.388),
        (Normals::Oct8, 0.96),
        (Normals::Oct10, 0.24),
        (Normals::Oct12, 0.06),
        (Normals::Oct16, 0.0038),
        (Normals::Float, 1e-5),
    ] {
        let found = greatest_error(normals, false);
        assert!(
            found <= most && found > 0.5 * most * f64::from(u8::from(normals != Normals::Float)),
            "{normals}: {found}"
        );
    }
    // Equal-area: at most half a step of 1 / 2047 each way, times 2 sqrt(2) / sqrt(1 - p²) on the half that is seen.
    assert!(greatest_error(Normals::Sphere12, true) < 0.08, "{}", greatest_error(Normals::Sphere12, true));
    // z = sqrt(1 - x² - y²) is steep at the rim: an error of e there is one of sqrt(2 e) in z.
    let rim = greatest_error(Normals::View12, true);
    assert!(rim > 0.2 && rim < 1.6, "{rim}");
    // What faces away is turned to face the viewer: this encoding cannot hold it.
    assert!(greatest_error(Normals::View12, false) > 90.0);
}

#[test]
fn axes_are_exact_in_octahedral_codes() {
    for bits in [8, 10, 12, 16] {
        for n in [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z] {
            assert_eq!(direction_from_octahedral_codes(octahedral_codes(n, bits), bits), n, "{bits}");
        }
    }
}

#[test]
fn what_is_not_lit_reads_back_so() {
    let view = view();
    let unlit = Attributes { lit: false, ..surface(&view, [1, 1]) };
    for &layout in Layout::ALL {
        let gbuffer = gbuffer(layout);
        let stored = encode(&gbuffer, &unlit, &view, 1.0);
        assert_eq!(gbuffer.form.has_depth(), stored.depth > 0.0, "{layout}");
        let read = decode(&gbuffer, &stored, &view, [1, 1], 1.0);
        assert!(!read.lit && read.depth > 0.0, "{layout}");
        let background = encode(&gbuffer, &Attributes::default(), &view, 1.0);
        let read = decode(&gbuffer, &background, &view, [1, 1], 1.0);
        assert!(!read.lit && read.depth == 0.0 && read.prelit == DVec3::ZERO, "{layout}");
    }
}

#[test]
fn words_come_back() {
    for v in
        [DVec3::new(1.0, 0.5, 0.25), DVec3::new(3.1, 0.0, 1e-5), DVec3::new(60000.0, 7.0, 1.0), DVec3::ZERO]
    {
        assert_eq!(from_word(word_of(e5b9g9r9(v))), e5b9g9r9(v));
        assert_eq!(from_b10g11r11_word(b10g11r11_word(v)), b10g11r11(v));
        let pair = halves_in(halves(v.x, -v.y));
        assert_eq!((pair.x, pair.y), (half(v.x), half(-v.y)));
    }
}

#[test]
fn the_light_target_saturates_and_rounds_once() {
    let step = 1.0 / 1023.0;
    let unorm10 = Format::Rgb10a2Unorm;
    let stored = store_light(unorm10, DVec3::splat(10.0 * step));
    // Two additions of 0.4 steps by one blend each are lost; one of 0.8 is not.
    let blend = |s, x: f64| blend_light(unorm10, s, DVec3::splat(x * step));
    assert_eq!(blend(blend(stored, 0.4), 0.4), stored);
    assert_eq!(blend(stored, 0.8), DVec3::splat(unorm(11.0 * step, 10)));
    assert_eq!(blend(stored, 5000.0), DVec3::ONE);
    let floats = Format::Rgba32Float;
    assert_eq!(blend_light(floats, DVec3::splat(0.5), DVec3::splat(5000.0)), DVec3::splat(5000.5));
}
