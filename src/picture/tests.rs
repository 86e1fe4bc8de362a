use super::*;

fn rgba8(width: u32, height: u32, channels: &[u8]) -> Picture {
    Picture { width, height, pixels: Pixels::Rgba8(channels.to_vec()) }
}

fn rgba32f(width: u32, height: u32, channels: &[f32]) -> Picture {
    Picture { width, height, pixels: Pixels::Rgba32F(channels.to_vec()) }
}

#[test]
fn turned_images_show_upright_pictures() {
    let row = |pixels: &[u8]| -> Vec<u8> { pixels.iter().flat_map(|p| [*p, 0, 0, 255]).collect() };
    // What is above is at the right.
    let image = rgba8(2, 3, &row(&[4, 1, 5, 2, 6, 3]));
    assert_eq!(image.upright(PreRotation::Rotate90), rgba8(3, 2, &row(&[1, 2, 3, 4, 5, 6])));
    let image = rgba8(2, 3, &row(&[3, 6, 2, 5, 1, 4]));
    assert_eq!(image.upright(PreRotation::Rotate270), rgba8(3, 2, &row(&[1, 2, 3, 4, 5, 6])));
    let image = rgba8(2, 2, &row(&[4, 3, 2, 1]));
    assert_eq!(image.upright(PreRotation::Rotate180), rgba8(2, 2, &row(&[1, 2, 3, 4])));
    assert_eq!(image.upright(PreRotation::Identity), image);
}

#[test]
fn png_returns_every_byte() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("all.PNG");
    let channels: Vec<u8> = (0..16 * 16 * 4).map(|i| (i * 7 + i / 256) as u8).collect();
    let picture = rgba8(16, 16, &channels);
    picture.write(&path).unwrap();
    assert_eq!(Picture::read(&path).unwrap(), picture);
}

#[cfg(feature = "cli")]
#[test]
fn exr_returns_every_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wild.exr");
    let channels = [
        [0.0, -0.0, 1.0, 0.25],
        [65504.0, 1e30, f32::MAX, 0.0],
        [-3.5, f32::MIN_POSITIVE, 1e-42, 1.0],
        [f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 2.0],
        [0.1, 1.0 / 3.0, 16777217.0, -1.0],
        [1.0000001, 0.99999994, 123.456, 0.5],
    ]
    .concat();
    rgba32f(3, 2, &channels).write(&path).unwrap();
    let back = Picture::read(&path).unwrap();
    assert_eq!((back.width, back.height), (3, 2));
    let Pixels::Rgba32F(back) = back.pixels else { panic!("floats expected") };
    let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&back), bits(&channels));
}

#[cfg(feature = "cli")]
#[test]
fn exr_without_alpha_is_opaque() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rgb.exr");
    image::Rgb32FImage::from_raw(1, 1, vec![5.5, -2.0, 0.1]).unwrap().save(&path).unwrap();
    assert_eq!(Picture::read(&path).unwrap(), rgba32f(1, 1, &[5.5, -2.0, 0.1, 1.0]));
}

#[test]
fn other_layouts_become_rgba() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);

    image::GrayImage::from_raw(2, 1, vec![7, 200]).unwrap().save(at("grey.png")).unwrap();
    assert_eq!(Picture::read(&at("grey.png")).unwrap(), rgba8(2, 1, &[7, 7, 7, 255, 200, 200, 200, 255]));

    // Encoded 0.5 is linear 0.21404114 (IEC 61966-2-1); 32768 / 65535 is 7.6e-6 above it.
    let deep = image::ImageBuffer::<image::Rgba<u16>, _>::from_raw(1, 1, vec![32768u16, 0, 65535, 65535]);
    deep.unwrap().save(at("deep.png")).unwrap();
    let Pixels::Rgba32F(deep) = Picture::read(&at("deep.png")).unwrap().pixels else { panic!("floats") };
    assert!((deep[0] - 0.214_041_14).abs() < 2e-5, "{deep:?}");
    assert_eq!(deep[1..], [0.0, 1.0, 1.0]);
}

#[test]
fn srgb_transfer_has_the_standards_values() {
    // By hand from IEC 61966-2-1: ((0.5 + 0.055) / 1.055)^2.4, and the linear toe 10 / 255 / 12.92.
    const SINGLE_PRECISION: f32 = 1e-6;
    assert!((linear_from_srgb(0.5) - 0.214_041_14).abs() < SINGLE_PRECISION);
    assert!((linear_from_srgb(10.0 / 255.0) - 0.003_035_27).abs() < SINGLE_PRECISION);
    assert!((srgb_from_linear(0.18) - 0.461_356_1).abs() < SINGLE_PRECISION);
    assert_eq!(linear_from_srgb(1.0), 1.0);
}

#[test]
fn eight_bits_survive_the_way_through_linear() {
    let channels: Vec<u8> = (0..=255u8).flat_map(|v| [v, 255 - v, v / 2, v]).collect();
    let picture = rgba8(16, 16, &channels);
    assert_eq!(picture.to_linear().to_srgb8(), picture);
}

#[test]
fn floats_clamp_and_round_on_the_way_to_eight_bits() {
    let wild = rgba32f(2, 1, &[-1.0, 7.0, f32::NAN, 0.5, f32::INFINITY, f32::NEG_INFINITY, 0.18, 2.0]);
    // Linear 0.18 encodes to 0.46136, times 255 is 117.6; alpha is not encoded: 0.5 is step 127.5.
    assert_eq!(wild.to_srgb8(), rgba8(2, 1, &[0, 255, 0, 128, 255, 0, 118, 255]));
}

#[test]
fn mismatches_are_errors_that_leave_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let bytes = rgba8(1, 1, &[1, 2, 3, 4]);
    let floats = rgba32f(1, 1, &[1.0; 4]);
    let cases = [
        (&floats, "a.png", "PNG holds 8 bits"),
        (&bytes, "a.exr", "OpenEXR holds floats"),
        (&bytes, "a.bmp", "use .png"),
        (&bytes, "a", "use .png"),
        (&rgba8(2, 2, &[0; 15]), "b.png", "2x2 pixels holds 15 values"),
    ];
    let cases_len = cases.len();
    for (picture, name, expected) in cases {
        std::fs::write(at(name), "old").unwrap();
        let message = picture.write(&at(name)).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
        assert_eq!(std::fs::read(at(name)).unwrap(), b"old", "{name}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), cases_len, "only the old files");
}

#[test]
fn unreadable_files_are_errors_that_name_them() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    rgba8(8, 8, &[9; 256]).write(&at("whole.png")).unwrap();
    let mut extensions = vec!["png"];
    if cfg!(feature = "cli") {
        rgba32f(8, 8, &[9.0; 256]).write(&at("whole.exr")).unwrap();
        extensions.push("exr");
    }
    for extension in extensions {
        let whole = std::fs::read(at(&format!("whole.{extension}"))).unwrap();
        let cut = at(&format!("cut.{extension}"));
        for kept in [0, 7, whole.len() / 2, whole.len() - 20] {
            std::fs::write(&cut, &whole[..kept]).unwrap();
            let message = Picture::read(&cut).unwrap_err().to_string();
            assert!(message.contains(&format!("cut.{extension}: picture: ")), "{kept} bytes: {message}");
        }
    }
    let message = Picture::read(&at("absent.png")).unwrap_err().to_string();
    assert!(message.contains("absent.png: cannot read"), "{message}");
}
