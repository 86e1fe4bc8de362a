//! Environments: files that hold no radiance, and extras that name them wrongly.

use std::path::PathBuf;

use ontile::Error;
use ontile::environment::{Panorama, Prefiltered, TexelFormat};
use ontile::glam::Vec3;
use ontile::scene::Environment;
use serde_json::{Value, json};

use crate::expect_input_error;
use crate::gltf_build::{Gltf, png, write};

/// A Radiance file of this size, all one grey.
fn hdr(width: usize, height: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    let texels = vec![image::Rgb([0.5, 0.5, 0.5]); width * height];
    image::codecs::hdr::HdrEncoder::new(&mut bytes).encode(&texels, width, height).unwrap();
    bytes
}

/// An OpenEXR file of 8 x 4 texels, one of them with this red.
fn exr(red: f32) -> Vec<u8> {
    let mut texels = vec![0.25_f32; 8 * 4 * 3];
    texels[3 * (2 * 8 + 5)] = red;
    let picture = image::Rgb32FImage::from_raw(8, 4, texels).unwrap();
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::OpenExr).unwrap();
    bytes.into_inner()
}

/// An OpenEXR file whose channels are B, G and Y.
fn without_red() -> Vec<u8> {
    let mut bytes = exr(1.0);
    let list = bytes.windows(7).position(|w| w == b"chlist\0").unwrap() + 7 + 4;
    // Each entry is a name with its end and 16 bytes.
    assert_eq!(&bytes[list + 36..list + 38], b"R\0");
    bytes[list + 36] = b'Y';
    bytes
}

fn ktx2() -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("e.ktx2");
    let white = Panorama::new(8, 4, vec![Vec3::ONE; 32]).unwrap();
    Prefiltered::new(&white, 16, TexelFormat::Rgba16F).write(&path).unwrap();
    std::fs::read(path).unwrap()
}

#[test]
fn files_that_hold_no_radiance() {
    let folder = tempfile::tempdir().unwrap();
    let mut cut = hdr(64, 32);
    cut.truncate(cut.len() / 2);
    let mut damaged = ktx2();
    let last = damaged.len() - 3;
    damaged[last] ^= 1;
    let mut foreign = ktx2();
    let at = foreign.windows(13).position(|w| w == b"ontileVersion").unwrap();
    foreign[at] = b'a';
    let bomb = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1073741823 +X 2147483646\n".to_vec();
    let cases: Vec<(&str, Vec<u8>, &str, &str)> = vec![
        ("sky.png", png(4, 2, &[0; 32]), "environment", "Png, whose channels cannot hold radiance"),
        ("text.hdr", b"no picture".to_vec(), "environment", "no picture"),
        ("empty.exr", Vec::new(), "environment", "no picture"),
        ("cut.hdr", cut, "environment", "cannot be decoded"),
        ("square.hdr", hdr(16, 16), "size", "16 x 16 texels, but an equirectangular"),
        ("small.hdr", hdr(2, 1), "size", "4 to 8192 columns"),
        ("bomb.hdr", bomb, "size", "4 to 8192 columns"),
        ("nan.exr", exr(f32::NAN), "texel 5, 2", "NaN"),
        ("infinite.exr", exr(f32::INFINITY), "texel 5, 2", "inf"),
        ("negative.exr", exr(-0.5), "texel 5, 2", "not negative"),
        ("damaged.ktx2", damaged, "environment", "checksum"),
        ("cut.ktx2", ktx2()[..500].to_vec(), "environment", "damaged KTX"),
        ("foreign.ktx2", foreign, "environment", "without the entry ontile"),
    ];
    let radiance = |head: &str| [b"#?RADIANCE\n", head.as_bytes(), &[128; 32]].concat();
    let rgbe = "FORMAT=32-bit_rle_rgbe\n\n";
    let refused: Vec<(&str, Vec<u8>, &str, &str)> = vec![
        ("flip.hdr", radiance(&format!("{rgbe}+Y 2 +X 4\n")), "+Y 2 +X 4", "rows from the top"),
        ("words.hdr", radiance(&format!("{rgbe}-Y two +X four\n")), "-Y two +X four", "export"),
        ("xyz.hdr", radiance("FORMAT=32-bit_rle_xyze\n\n-Y 2 +X 4\n"), "xyze", "in RGB"),
        ("head.hdr", b"#?RADIANCE\nFORMAT=32".to_vec(), "cut off", "complete"),
        ("zero.hdr", radiance(&format!("{rgbe}-Y 0 +X 0\n")), "no picture", "export"),
        ("one.hdr", hdr(2, 1), "4 to 8192", "larger"),
        ("wide.hdr", radiance(&format!("{rgbe}-Y 8192 +X 16384\n")), "4 to 8192", "scale the picture down"),
        ("huge.hdr", radiance(&format!("{rgbe}-Y 4294967295 +X 8589934590\n")), "4 to 8192", "down"),
        ("cut.hdr", hdr(64, 32)[..300].to_vec(), "cannot be decoded", "complete"),
        ("grey.exr", without_red(), "rgb channels", "R, G and B"),
        ("3e38.exr", exr(3e38), "at most 1e12 cd/m²", "clamp"),
    ];
    for (name, bytes, problem, remedy) in refused {
        let message = Environment::load(&write(folder.path(), name, &bytes)).unwrap_err().to_string();
        let (said, advice) = message.rsplit_once("; ").unwrap();
        assert!(said.contains(problem) && advice.contains(remedy), "{name}: {message}");
    }
    for (name, bytes, element, problem) in cases {
        let path = write(folder.path(), name, &bytes);
        let error = Environment::load(&path).expect_err(name);
        let message = error.to_string();
        let Error::Input { path: named, element: found, problem: why, remedy } = error else {
            panic!("{name}: {message}")
        };
        assert_eq!((named, found.as_str()), (path, element), "{message}");
        assert!(why.contains(problem) && remedy.len() > 5, "{message}");
    }
    assert!(Environment::load(&write(folder.path(), "good.exr", &exr(3.0))).is_ok());
    assert!(Environment::load(&write(folder.path(), "good.ktx2", &ktx2())).is_ok());

    for (path, part) in
        [(folder.path().join("absent.hdr"), "cannot read"), (PathBuf::from("/dev/zero"), "regular")]
    {
        let message = Environment::load(&path).unwrap_err().to_string();
        assert!(message.contains(part) && message.contains(path.to_str().unwrap()), "{message}");
    }
}

#[test]
fn extras_that_name_them_wrongly() {
    let cases: Vec<(Value, &str, &str)> = vec![
        (json!({"sky": 1}), ".sky", "not a name"),
        (json!({"environment": "sky.hdr"}), ".environment", "an object"),
        (json!({"environment": {}}), ".environment", "no file"),
        (json!({"environment": {"file": 7}}), ".environment.file", "a text"),
        (json!({"environment": {"file": "/dev/zero"}}), ".environment.file", "relative"),
        (json!({"environment": {"file": "https://a/b.hdr"}}), ".environment.file", "nothing is fetched"),
        (json!({"environment": {"file": "a", "turn": 1}}), ".environment.turn", "not a name"),
        (json!({"environment": {"file": "a", "rotation": "90"}}), ".environment.rotation", "degrees"),
        (json!({"environment": {"file": "a", "intensity": -1}}), ".environment.intensity", "at least 0"),
        (json!({"environment": {"file": "a", "intensity": 1e39}}), ".environment.intensity", "a number"),
    ];
    for (extras, element, problem) in cases {
        let mut file = Gltf::triangle();
        let name = extras.to_string();
        *file.at("/scenes/0/extras") = json!({"ontile": extras});
        expect_input_error(&name, file.load(), &format!("scenes[0].extras.ontile{element}"), problem);
    }
}

#[test]
fn a_missing_file_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = Gltf::triangle();
    *file.at("/scenes/0/extras") = json!({"ontile": {"environment": {"file": "no%20sky.hdr"}}});
    let load = |file: &Gltf| ontile::scene::Scene::load(&file.write_beside(folder.path(), "a.gltf"));
    let place = "scenes[0].extras.ontile.environment";
    expect_input_error("absent", load(&file), &format!("{place}.file"), "no sky.hdr: No such file");
    write(folder.path(), "no sky.hdr", b"text");
    expect_input_error(
        "text",
        load(&file),
        &format!("{place}.file"),
        "no sky.hdr: environment: is no picture",
    );
    write(folder.path(), "no sky.hdr", &exr(3.0));
    assert!(load(&file).is_ok());
    *file.at("/scenes/0/extras/ontile/environment/intensity") = json!(1e38);
    expect_input_error("bright", load(&file), &format!("{place}.intensity"), "at most 1e12 cd/m²");
}

#[test]
fn files_outside_the_folder_are_not_opened() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "sky.exr", &exr(1.0));
    std::fs::create_dir(folder.path().join("scenes")).unwrap();
    let load = |name: &str| {
        let mut file = Gltf::triangle();
        *file.at("/scenes/0/extras") = json!({"ontile": {"environment": {"file": name}}});
        ontile::scene::Scene::load(&file.write_beside(&folder.path().join("scenes"), "a.gltf"))
    };
    for name in ["../sky.exr", "./a/../../sky.exr", "%2e%2e/sky.exr", "../scenes/../sky.exr"] {
        let place = "scenes[0].extras.ontile.environment.file";
        expect_input_error(name, load(name), place, "leaves the folder");
    }
    write(&folder.path().join("scenes"), "sky.exr", &exr(1.0));
    load("./a/../sky.exr").expect_err("there is no folder a");
    load("./sky.exr").unwrap();
}
