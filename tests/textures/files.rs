//! What files say, without a device.

use super::ktx::File;
use super::{BASIS, blocks, halved, ktx_format, read, stored};
use ktx2::Format;
use ontile::scene::{AstcBlock, Texels, TextureFormat};

#[test]
fn basis_universal_is_decoded_as_its_authors_do() {
    for (name, file, expected, levels) in BASIS {
        let image = read(name, file);
        let stored = stored(&image);
        assert_eq!(([image.width, image.height], stored.levels()), ([60, 28], levels), "{name}");
        let expected = image::load_from_memory(expected).unwrap().into_rgba8();
        let mut row = 0;
        for level in 0..levels {
            let [width, height] = halved([60, 28], level);
            let wanted = image::imageops::crop_imm(&expected, 0, row, width, height).to_image();
            let decoded = stored.level(level, TextureFormat::Rgba8);
            assert!(decoded[..] == wanted.as_raw()[..], "{name}: level {level}");
            row += height;
        }
        assert_eq!(image.rgba8(), &stored.level(0, TextureFormat::Rgba8)[..], "{name}");
    }
}

/// EAC's values are a base and multiples of its tables' entries, ETC1S' a base and entries of other tables: a fit.
const MOST_STEPS_OF_ALPHA: u8 = 4;

/// Colours of ETC1S are a subset of ETC1's and UASTC is one of ASTC, so nothing is lost on GPUs that have these. ASTC's 16-bit
/// results become bytes in two ways, which differ by a step (Khronos Data Format 1.3, 23.19); alpha of ETC1S is fitted by EAC.
#[test]
fn what_loses_least_loses_nothing() {
    for (name, file, ..) in BASIS {
        let image = read(name, file);
        let stored = stored(&image);
        let best = stored.formats()[0];
        let [of_color, of_alpha] = match best {
            TextureFormat::Astc(_) => [1, 1],
            _ => [0, MOST_STEPS_OF_ALPHA],
        };
        for level in 0..stored.levels() {
            let [truth, content] = [TextureFormat::Rgba8, best].map(|format| stored.level(level, format));
            let ready = File::new(ktx_format(best), halved([60, 28], level), vec![content.into_owned()]);
            let ready = read("ready", &ready.bytes());
            for (i, (a, b)) in truth.iter().zip(ready.rgba8()).enumerate() {
                let most = if i % 4 == 3 { of_alpha } else { of_color };
                assert!(a.abs_diff(*b) <= most, "{name}, level {level}, {best:?}, channel {i}: {b} for {a}");
            }
        }
        assert_eq!(*stored.formats().last().unwrap(), TextureFormat::Rgba8);
    }
}

#[test]
fn ready_made_levels_stay_as_they_are() {
    for format in TextureFormat::COMPRESSED {
        for zstandard in [false, true] {
            let size = [23, 10];
            let levels: Vec<Vec<u8>> =
                (0..3).map(|level| blocks(format, halved(size, level.into()), level)).collect();
            let file = File { zstandard, ..File::new(ktx_format(format), size, levels.clone()) };
            let image = read("ready", &file.bytes());
            let stored = stored(&image);
            assert_eq!(stored.formats(), [format, TextureFormat::Rgba8]);
            assert_eq!(stored.levels(), 3);
            for (level, content) in (0..).zip(&levels) {
                assert_eq!(stored.level(level, format)[..], content[..], "{format:?}");
            }
            assert_eq!(image.rgba8().len(), 23 * 10 * 4);
        }
    }
}

#[test]
fn plain_texels_of_one_level_are_as_from_a_png() {
    let texels: Vec<u8> = (0..6 * 5 * 4).collect();
    let image = read("plain", &File::new(Format::R8G8B8A8_SRGB, [6, 5], vec![texels.clone()]).bytes());
    assert!(matches!(&image.texels, Texels::Rgba8(found) if *found == texels));
    let levels = vec![texels, (0..3 * 2 * 4).collect()];
    let image = read("plain", &File::new(Format::R8G8B8A8_UNORM, [6, 5], levels).bytes());
    assert_eq!(stored(&image).levels(), 2, "levels of the file are kept");
}

/// Whatever the footprint, a block of one colour is that colour.
#[test]
fn blocks_of_every_footprint_are_decoded() {
    let all = TextureFormat::COMPRESSED.into_iter().filter(|format| matches!(format, TextureFormat::Astc(_)));
    for format in all {
        let file = File::new(ktx_format(format), [13, 7], vec![blocks(format, [13, 7], 0)]);
        let image = read("even", &file.bytes());
        let texels = image.rgba8().as_chunks::<4>().0;
        assert!(texels.iter().all(|texel| *texel == [0xcc, 0x40, 0x80, 0xff]), "{format:?}: {:?}", texels[0]);
    }
    assert_eq!(AstcBlock::B12x10.size(), [12, 10]);
}
