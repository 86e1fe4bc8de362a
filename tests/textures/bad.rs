//! Files that are damaged, or no pictures.

use super::ktx::File;
use super::{BASIS, blocks, random, read};
use ktx2::Format;
use ontile::scene::{Image, TextureFormat};

fn problem(file: &[u8]) -> String {
    Image::from_ktx2("file", file).map(|_| ()).expect_err("the file is bad")
}

fn bc7() -> File {
    File::new(Format::BC7_SRGB_BLOCK, [8, 8], vec![blocks(TextureFormat::Bc7, [8, 8], 1)])
}

#[test]
fn what_cannot_be_read_is_named() {
    let cases = [
        (File { layers: 2, ..bc7() }, "not of one picture"),
        (File { metadata: vec![("KTXorientation", b"ru\0")], ..bc7() }, "KTXorientation"),
        (File { metadata: vec![("KTXswizzle", b"bgra\0")], ..bc7() }, "KTXswizzle"),
        (File { format: Format::BC6H_UFLOAT_BLOCK, ..bc7() }, "BC6H_UFLOAT_BLOCK"),
        (File { format: Format::BC5_UNORM_BLOCK, ..bc7() }, "Basis Universal, BC1"),
        (File { size: [8, 12], ..bc7() }, "has 64 bytes in level 0, not 96"),
        (File { zstandard: true, size: [4, 4], ..bc7() }, "has 17 bytes in level 0, not 16"),
        (File { levels: vec![vec![0; 16]; 3], size: [2, 2], ..bc7() }, "has 3 levels"),
    ];
    for (file, expected) in cases {
        let found = problem(&file.bytes());
        assert!(found.contains(expected), "'{found}' does not say '{expected}'");
    }
    let usual = File { metadata: vec![("KTXorientation", b"rd\0"), ("KTXswizzle", b"rgba\0")], ..bc7() };
    read("usual", &usual.bytes());
}

/// A file that was cut off, or some of whose bytes are others, is read or refused; nothing panics.
#[test]
fn damage_is_no_panic() {
    let ready: Vec<Vec<u8>> = TextureFormat::COMPRESSED
        .into_iter()
        .map(|format| {
            let level = blocks(format, [16, 12], 3);
            File { zstandard: true, ..File::new(super::ktx_format(format), [16, 12], vec![level]) }.bytes()
        })
        .collect();
    let files = BASIS.iter().map(|(_, file, ..)| file.to_vec()).chain(ready);
    let (mut refused, mut read) = (0, 0);
    let mut attempt = |file: &[u8]| match Image::from_ktx2("damaged", file) {
        Ok(image) if image.width <= 64 && image.height <= 64 => {
            assert_eq!(image.rgba8().len() as u32, image.width * image.height * 4);
            read += 1;
        }
        Ok(_) => read += 1,
        Err(_) => refused += 1,
    };
    let mut state = 7;
    for file in files {
        (0..file.len()).step_by(7).for_each(|length| attempt(&file[..length]));
        for _ in 0..150 {
            let mut damaged = file.clone();
            for _ in 0..1 + random(&mut state) % 4 {
                let at = usize::from(random(&mut state)) << 8 | usize::from(random(&mut state));
                let at = at % damaged.len();
                damaged[at] = random(&mut state);
            }
            attempt(&damaged);
        }
    }
    assert!(refused > 1000 && read > 1000, "{refused} refused, {read} read");
}
