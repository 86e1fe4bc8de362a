use super::*;

fn rgba8(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [u8; 4]) -> Picture {
    let channels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).flat_map(|(x, y)| pixel(x, y));
    Picture { width, height, pixels: Pixels::Rgba8(channels.collect()) }
}

fn rgba32f(pixels: &[[f32; 4]]) -> Picture {
    Picture { width: pixels.len() as u32, height: 1, pixels: Pixels::Rgba32F(pixels.concat()) }
}

/// A picture with structure in every window: a lattice on a slope.
fn textured(x: u32, y: u32) -> [u8; 4] {
    let lattice = if (x / 2 + y / 3).is_multiple_of(2) { 40 } else { 0 };
    [(60 + 3 * x + lattice) as u8, (60 + 2 * y + lattice) as u8, (90 + x + y) as u8, 255]
}

#[test]
fn eight_bit_figures_match_hand_numbers() {
    let a = rgba8(2, 2, |_, _| [10, 20, 30, 255]);
    let b = rgba8(2, 2, |x, y| match (x, y) {
        (0, 0) => [14, 20, 30, 255],
        (1, 0) => [10, 20, 28, 255],
        (0, 1) => [10, 20, 30, 250],
        _ => [10, 20, 30, 255],
    });
    let c = compare(&a, &b, None).unwrap();
    assert_eq!((c.compared_pixels, c.differing_pixels, c.non_finite_pixels), (4, 3, 0));
    assert_eq!(
        c.channels.each_ref().map(|e| (e.max, e.mean)),
        [(4.0, 1.0), (0.0, 0.0), (2.0, 0.5), (5.0, 1.25)]
    );
    // Twelve colour values: 4 and 2 differ.
    assert_eq!((c.color.max, c.color.mean, c.mse), (4.0, 0.5, 20.0 / 12.0));
    // 10 log10(65025 / (20 / 12)) = 45.9123 dB.
    assert!((c.psnr_db.unwrap() - 45.9123).abs() < 5e-5, "{c:?}");
    assert_eq!((c.unit, c.peak, c.relative_error_p95, c.identical), (Unit::Steps8Bit, 255.0, None, false));
}

#[test]
fn equal_pictures_are_identical() {
    // 19 and 13 leave partial windows at both edges.
    let a = rgba8(19, 13, textured);
    let c = compare(&a, &a.clone(), None).unwrap();
    assert!(c.identical);
    assert_eq!((c.differing_pixels, c.mse, c.psnr_db, c.ssim), (0, 0.0, None, 1.0));
    assert!(c.to_string().contains("identical"), "{c}");
    assert!(serde_json::to_value(&c).unwrap()["psnr_db"].is_null());
}

#[test]
fn alpha_alone_is_a_difference_with_infinite_psnr() {
    let a = rgba8(2, 1, |_, _| [1, 2, 3, 255]);
    let b = rgba8(2, 1, |_, _| [1, 2, 3, 0]);
    let c = compare(&a, &b, None).unwrap();
    assert_eq!((c.identical, c.differing_pixels, c.psnr_db, c.channels[3].max), (false, 2, None, 255.0));
    assert!(c.to_string().contains("infinite"), "{c}");
}

#[test]
fn float_figures_match_hand_numbers() {
    let a = rgba32f(&[[4.0, 2.0, 1.0, 99.0], [0.5, 0.0, 8.0, 1.0]]);
    let b = rgba32f(&[[3.0, 2.0, 1.5, 99.0], [0.5, 0.0, 6.0, 1.0]]);
    let c = compare(&a, &b, None).unwrap();
    assert_eq!((c.unit, c.peak, c.differing_pixels), (Unit::Linear, 8.0, 2));
    // Differences 0.5, 1, 2 of six values.
    assert_eq!((c.color.max, c.color.mean, c.mse), (2.0, 3.5 / 6.0, 5.25 / 6.0));
    // 10 log10(64 * 6 / 5.25) = 18.6417 dB.
    assert!((c.psnr_db.unwrap() - 18.6417).abs() < 5e-5, "{c:?}");
    // Relative: 0.25, 0, 0.5, 0, 0, 0.25; the 95th percentile of six is the largest.
    assert_eq!(c.relative_error_p95, Some(0.5));
}

#[test]
fn dark_references_are_measured_against_the_floor() {
    let a = rgba32f(&[[0.0, 0.0, 0.0, 1.0]]);
    let b = rgba32f(&[[1.0, 1.0, 1.0, 1.0]]);
    let c = compare(&a, &b, None).unwrap();
    assert!((c.relative_error_p95.unwrap() - 255.0 * 12.92).abs() < 1e-6, "{c:?}");
    assert_eq!(c.psnr_db, None);
    assert!(c.to_string().contains("undefined"), "{c}");
}

#[test]
fn non_finite_pixels_are_counted_and_left_out() {
    let a = rgba32f(&[[1.0, 1.0, 1.0, 1.0], [f32::NAN, 9.0, 0.0, 1.0], [f32::INFINITY, 0.0, 0.0, 1.0]]);
    let b = rgba32f(&[[1.0, 1.0, 1.0, 1.0], [1.0, 1.0, 0.0, 1.0], [f32::INFINITY, 0.0, 0.0, 1.0]]);
    let c = compare(&a, &b, None).unwrap();
    assert_eq!((c.compared_pixels, c.differing_pixels, c.non_finite_pixels), (3, 1, 1));
    assert_eq!((c.color.max, c.peak, c.psnr_db), (0.0, 1.0, None));
    assert!(!c.identical && c.to_string().contains("non-finite"), "{c}");
}

#[test]
fn a_mask_takes_the_background_out() {
    let a = rgba8(16, 8, |_, _| [100, 100, 100, 255]);
    let b = rgba8(16, 8, |x, _| if x < 8 { [110, 100, 100, 255] } else { [100, 100, 100, 255] });
    let object = rgba8(16, 8, |x, _| if x < 8 { [0, 1, 0, 255] } else { [0, 0, 0, 255] });
    let background = rgba8(16, 8, |x, _| if x < 8 { [0, 0, 0, 255] } else { [9, 9, 9, 0] });
    let all = compare(&a, &b, None).unwrap();
    let masked = compare(&a, &b, Some(&object)).unwrap();
    assert_eq!((masked.compared_pixels, masked.differing_pixels), (64, 64));
    assert_eq!((all.mse, masked.mse), (100.0 / 6.0, 100.0 / 3.0));
    // Half the pixels, twice the error: 10 log10(2) = 3.0103 dB.
    assert!((all.psnr_db.unwrap() - masked.psnr_db.unwrap() - 3.0103).abs() < 5e-5);
    // One window differs and the other is equal.
    assert!((all.ssim - (masked.ssim + 1.0) / 2.0).abs() < 1e-12, "{} {}", all.ssim, masked.ssim);
    assert!(masked.ssim < 0.999);
    let untouched = compare(&a, &b, Some(&background)).unwrap();
    assert!(untouched.identical && untouched.ssim == 1.0);
}

#[test]
fn ssim_of_flat_windows_matches_the_formula() {
    // Flat pictures have no variance: (2 m n + C1) / (m² + n² + C1), C1 = (0.01 * 255)² = 6.5025.
    let a = rgba8(8, 8, |_, _| [0, 50, 200, 255]);
    let b = rgba8(8, 8, |_, _| [5, 50, 200, 255]);
    let c = compare(&a, &b, None).unwrap();
    assert!((c.ssim - 6.5025 / (25.0 + 6.5025)).abs() < 1e-12, "{}", c.ssim);
}

#[test]
fn ssim_falls_as_noise_rises() {
    let a = rgba8(32, 24, textured);
    let noisy = |amplitude: u32| {
        rgba8(32, 24, |x, y| {
            // A small integer hash: alike to noise, equal in every run.
            let noise = (x.wrapping_mul(2_654_435_761) ^ y.wrapping_mul(2_246_822_519)) >> 16;
            textured(x, y).map(|c| c.saturating_add((noise % (amplitude + 1)) as u8))
        })
    };
    let ssim: Vec<f64> = [0, 8, 32, 96].map(|n| compare(&a, &noisy(n), None).unwrap().ssim).to_vec();
    assert_eq!(ssim[0], 1.0);
    assert!(ssim.windows(2).all(|w| w[1] < w[0] - 0.01), "{ssim:?}");
}

#[test]
fn pictures_that_cannot_be_compared_are_errors() {
    let small = rgba8(2, 2, |_, _| [1; 4]);
    let wide = rgba8(4, 1, |_, _| [1; 4]);
    let black = rgba8(2, 2, |_, _| [0, 0, 0, 255]);
    let broken = Picture { width: 2, height: 2, pixels: Pixels::Rgba8(vec![0; 3]) };
    let cases = [
        (compare(&small, &wide, None), "differ in size: 2x2 and 4x1"),
        (compare(&small, &small.to_linear(), None), "linear floats"),
        (compare(&small, &small, Some(&wide)), "the mask is 4x1 pixels and the pictures are 2x2"),
        (compare(&small, &small, Some(&black)), "no pixel is left to compare"),
        (compare(&small, &broken, None), "2x2 pixels holds 3 values"),
    ];
    for (result, expected) in cases {
        let message = result.unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn what_an_eye_sees_is_measured_where_the_mask_says() {
    let a = rgba8(40, 24, textured);
    let b = rgba8(40, 24, |x, y| if x < 20 { textured(x, y) } else { [200, 30, 40, 255] });
    let right = rgba8(40, 24, |x, _| [if x < 20 { 0 } else { 255 }; 4]);
    let left = rgba8(40, 24, |x, _| [if x < 20 { 255 } else { 0 }; 4]);
    let [all, right, left] = [None, Some(&right), Some(&left)].map(|mask| compare(&a, &b, mask).unwrap());
    assert!(right.flip_mean > 0.5 && right.ciede2000_p95 > 20.0, "{right}");
    // FLIP looks at neighbourhoods, so that some of it reaches over the border.
    assert!(left.flip_mean > 0.0 && left.flip_mean < 0.5 * right.flip_mean, "{left}");
    assert_eq!((left.ciede2000_p95, left.ciede2000_max), (0.0, 0.0));
    assert!((all.flip_mean - 0.5 * (left.flip_mean + right.flip_mean)).abs() < 1e-12);
    assert!(all.ciede2000_max == right.ciede2000_max && all.ciede2000_max >= right.ciede2000_p95);
}

#[test]
fn floats_are_seen_as_a_display_shows_them() {
    let a = rgba32f(&[[1.0, 0.5, 0.25, 1.0], [7.0, 1.0, 0.0, 1.0]]);
    let b = rgba32f(&[[1.0, 0.5, 0.25, 1.0], [9.0, 1.0, 0.0, 1.0]]);
    let c = compare(&a, &b, None).unwrap();
    assert_eq!((c.flip_mean, c.ciede2000_max), (0.0, 0.0), "above 1 all is alike");
    assert!((c.relative_error_max.unwrap() - 2.0 / 7.0).abs() < 1e-12, "{c}");
    let nan = rgba32f(&[[f32::NAN, 0.5, 0.25, 1.0], [7.0, 1.0, 0.0, 1.0]]);
    let c = compare(&a, &nan, None).unwrap();
    assert_eq!((c.non_finite_pixels, c.ciede2000_max, c.relative_error_max), (1, 0.0, Some(0.0)));
    assert!(c.flip_mean.is_finite());
}
