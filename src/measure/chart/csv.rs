//! The numbers as a table for spreadsheets: one line a cell.

use super::data::{Errors, Outcome, Report};

/// RFC 4180, with line feeds.
pub(super) fn csv(report: &Report) -> String {
    let mut csv = String::from(
        "device,driver,program,scene,camera,width,height,strategy,tonemap,exposure_ev,gbuffer,clock,frame_ms,\
         first_quartile_ms,third_quartile_ms,rounds,ratio_to_base,bytes_on_tile,color_bits,bytes_moved,\
         bytes_moved_separate,truth,left_out,psnr_db,flip,ciede2000_p95,relative_max,relative_p95,exact_psnr_db,\
         exact_flip,exact_ciede2000_p95,exact_relative_max,exact_relative_p95,refused\n",
    );
    for cell in &report.cells {
        let place = &cell.place;
        let [width, height] = place.size;
        let mut fields: Vec<String> =
            [&place.device, &place.driver, &place.program, &place.scene, &place.camera]
                .map(|field| quoted(field))
                .into();
        fields.extend([
            width.to_string(),
            height.to_string(),
            place.strategy.to_string(),
            place.tonemap.to_string(),
        ]);
        fields.extend([place.exposure_ev.to_string(), quoted(&cell.choice.to_string())]);
        match &cell.outcome {
            Outcome::Measured(m) => {
                fields.push(format!("{:?}", m.clock).to_lowercase());
                let (frame, bytes) = (m.frame_ms, m.bytes);
                let times = [frame.median, frame.first_quartile, frame.third_quartile];
                fields.extend(times.map(|ms| format!("{ms:.4}")));
                fields.extend([frame.count.to_string(), format!("{:.4}", m.ratio.median)]);
                let bytes = [bytes.on_tile, bytes.color_bits, bytes.moved, bytes.moved_separate];
                fields.extend(bytes.map(|n| n.to_string()));
                fields.extend([format!("{:?}", m.truth).to_lowercase(), format!("{:.4}", m.left_out)]);
                fields.extend([m.against_reference, m.against_exact].into_iter().flat_map(errors));
                fields.push(String::new());
            }
            Outcome::Refused(reason) => {
                fields.extend(std::iter::repeat_n(String::new(), 22));
                fields.push(quoted(reason));
            }
        }
        csv += &fields.join(",");
        csv.push('\n');
    }
    csv
}

fn errors(e: Errors) -> [String; 5] {
    let psnr = e.psnr_db.map_or(String::new(), |db| db.to_string());
    let [flip, ciede, max, p95] =
        [e.flip, e.ciede2000_p95, e.relative_max, e.relative_p95].map(|x| x.to_string());
    [psnr, flip, ciede, max, p95]
}

fn quoted(field: &str) -> String {
    let special = |c| matches!(c, ',' | '"' | '\n' | '\r');
    if field.contains(special) { format!("\"{}\"", field.replace('"', "\"\"")) } else { field.to_owned() }
}
