//! On output of Mesa 26.1.6's Turnip, captured from a deferred frame of six attachments: light rgb10a2, depth r32f, two
//! rgba8, a D32 depth buffer, and an sRGB output; 5 + 1 + 1 draws.

use super::*;

const MERGED: &str = include_str!("../../tests/tiler_traces/merged.txt");
const NOT_BY_REGION: &str = include_str!("../../tests/tiler_traces/not_by_region.txt");
const SEPARATE: &str = include_str!("../../tests/tiler_traces/separate.txt");

/// The output image: 8 bits of each of red, green, blue and alpha.
const OUTPUT_BYTES_PER_PIXEL: u32 = 4;

fn parse(text: &str) -> Result<TilerTrace> {
    TilerTrace::parse(Path::new("captured.txt"), text)
}

fn counts(list: &[(&str, u32)]) -> BTreeMap<String, u32> {
    list.iter().map(|&(format, count)| (format.to_owned(), count)).collect()
}

fn off_tile_reasons(trace: &TilerTrace) -> Vec<String> {
    match trace.verdict(OUTPUT_BYTES_PER_PIXEL) {
        Verdict::OffTile(reasons) => reasons,
        Verdict::OnTile => Vec::new(),
    }
}

#[test]
fn a_merged_frame_is_read_in_full_and_stays_on_the_tile() {
    let trace = parse(MERGED).unwrap();
    let expected = TilerPass {
        width_px: 640,
        height_px: 360,
        attachments: 6,
        clear_bytes_per_pixel: 4 + 4 + 4 + 4 + 4,
        load_bytes_per_pixel: 0,
        store_bytes_per_pixel: 4,
        bins: 4,
        bin_width_px: 192,
        bin_height_px: 368,
        tiled: true,
        reason: "TU_DEBUG(GMEM)".to_owned(),
        draws: 7,
        loads: counts(&[]),
        // Four bins and the binning pass.
        stores: counts(&[("r8g8b8a8_srgb", 5)]),
    };
    assert_eq!(trace.passes, [expected]);
    assert_eq!(trace.warnings, [""; 0]);
    assert_eq!(trace.verdict(OUTPUT_BYTES_PER_PIXEL), Verdict::OnTile);
}

#[test]
fn a_dependency_that_is_not_by_region_is_caught_although_its_bytes_look_right() {
    let trace = parse(NOT_BY_REGION).unwrap();
    assert_eq!((trace.passes.len(), trace.passes[0].store_bytes_per_pixel), (1, OUTPUT_BYTES_PER_PIXEL));
    assert_eq!(trace.warnings, ["TU: warning: Disabling gmem rendering due to invalid subpass dependency"]);
    assert_eq!(
        off_tile_reasons(&trace),
        [
            "pass 0: not tiled: Can't fit attachments into gmem",
            "pass 0: 1 bin of 65535x65535 pixels instead of several",
            "TU: warning: Disabling gmem rendering due to invalid subpass dependency",
        ]
    );
}

#[test]
fn separate_passes_are_caught_with_what_each_moves() {
    let trace = parse(SEPARATE).unwrap();
    let bytes: Vec<_> = trace
        .passes
        .iter()
        .map(|pass| {
            (pass.clear_bytes_per_pixel, pass.load_bytes_per_pixel, pass.store_bytes_per_pixel, pass.draws)
        })
        .collect();
    // Geometry stores four colour targets; lighting blends into the light target; tonemap writes the output.
    assert_eq!(bytes, [(20, 0, 16, 5), (0, 4, 4, 1), (0, 0, 4, 1)]);
    assert!(trace.passes.iter().all(|pass| pass.tiled));
    // Two bins, and no binning pass for so few.
    let light_events = 2;
    assert_eq!(trace.passes[1].loads, counts(&[("r10g10b10a2_unorm", light_events)]));
    assert_eq!(trace.passes[1].stores, counts(&[("r10g10b10a2_unorm", light_events)]));
    let reasons = off_tile_reasons(&trace);
    assert_eq!(reasons[0], "3 render passes instead of 1");
    assert_eq!(
        reasons[1],
        "pass 0: stores 16 bytes per pixel instead of 4 (r10g10b10a2_unorm, r32_float, r8g8b8a8_unorm)"
    );
    assert!(reasons.contains(&"pass 1: loads 4 bytes per pixel instead of 0".to_owned()), "{reasons:?}");
}

#[test]
fn each_condition_of_the_verdict_is_needed() {
    let good = parse(MERGED).unwrap();
    type Fault = fn(&mut TilerTrace);
    let faults: [(&str, Fault); 8] = [
        ("0 render passes", |trace| trace.passes.clear()),
        ("2 render passes", |trace| trace.passes.push(trace.passes[0].clone())),
        ("not tiled", |trace| trace.passes[0].tiled = false),
        ("1 bin ", |trace| trace.passes[0].bins = 1),
        ("loads 8 bytes", |trace| trace.passes[0].load_bytes_per_pixel = 8),
        ("loads z32_float", |trace| trace.passes[0].loads = counts(&[("z32_float", 3)])),
        ("stores 8 bytes", |trace| trace.passes[0].store_bytes_per_pixel = 8),
        ("Disabling gmem", |trace| trace.warnings.push("Disabling gmem rendering: too small".to_owned())),
    ];
    for (symptom, break_it) in faults {
        let mut trace = good.clone();
        break_it(&mut trace);
        let reasons = off_tile_reasons(&trace);
        assert!(reasons.len() == 1 && reasons[0].contains(symptom), "{symptom}: {reasons:?}");
    }
}

#[test]
fn output_of_the_program_around_and_between_is_skipped() {
    let mixed: String = MERGED
        .lines()
        .flat_map(|line| {
            [line, "0123456789abcdef rendering: 50 %", "{ \"passes\": 1 }", "é".repeat(16).leak()]
        })
        .flat_map(|line| [line, "\r\n"])
        .collect();
    assert_eq!(parse(&mixed).unwrap(), parse(MERGED).unwrap());
}

#[test]
fn a_reason_may_hold_commas_and_equal_signs() {
    let text = MERGED.replace("=TU_DEBUG(GMEM)", "=too many draws, or a == b, who knows");
    assert_eq!(parse(&text).unwrap().passes[0].reason, "too many draws, or a == b, who knows");
}

#[test]
fn malformed_text_is_refused_with_its_line() {
    let begin = MERGED.find("start_render_pass").unwrap();
    let begin_line = MERGED[..begin].lines().count();
    let end = MERGED.find("end_render_pass").unwrap();
    let end_line = MERGED[..end].lines().count();
    let without =
        |what: &str| MERGED.lines().filter(|line| !line.contains(what)).collect::<Vec<_>>().join("\n");
    let cases = [
        (
            "cut off",
            MERGED[..end - 30].to_owned(),
            format!("line {begin_line}: this render pass does not end"),
        ),
        ("never began", without("start_render_pass"), "a render pass ends that never began".to_owned()),
        ("nested", format!("{}\n{MERGED}", &MERGED[..end - 30]), "begins inside the one of line".to_owned()),
        (
            "no width",
            MERGED.replace(" width=640,", ""),
            format!("line {begin_line}: start_render_pass has no width"),
        ),
        (
            "not a number",
            MERGED.replace("loadCPP=0", "loadCPP=-1"),
            format!("line {begin_line}: start_render_pass: loadCPP is `-1`, not a count"),
        ),
        (
            "not a flag",
            MERGED.replace("tiledRender=true", "tiledRender=maybe"),
            format!("line {end_line}: end_render_pass: tiledRender is `maybe`"),
        ),
        (
            "no format",
            MERGED.replace("start_gmem_store: format=", "start_gmem_store: "),
            "has no format".to_owned(),
        ),
        ("no trace", "device llvmpipe\ndone\n".to_owned(), "holds no driver trace".to_owned()),
        ("empty", String::new(), "holds no driver trace".to_owned()),
    ];
    for (name, text, expected) in cases {
        let message = parse(&text).expect_err(name).to_string();
        assert!(message.starts_with("captured.txt: ") && message.contains(&expected), "{name}: {message}");
    }
}

#[test]
fn any_cut_of_real_output_is_read_or_refused_without_panic() {
    for (index, _) in SEPARATE.char_indices().step_by(7) {
        let _ = parse(&SEPARATE[..index]);
        let _ = parse(&SEPARATE[index..]);
    }
}
