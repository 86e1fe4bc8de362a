//! The numbers as a table for spreadsheets: one line a cell.

use std::fmt::Write;

use super::data::{Outcome, Report};

/// RFC 4180, with line feeds.
pub fn csv(report: &Report) -> String {
    let mut csv = String::from(
        "device,driver,clock,table,row,x,width,height,way,frame_ms,first_quartile_ms,third_quartile_ms,rounds,\
         record_ms,first_draws,draws,state_changes,objects,lights,plan,refused\n",
    );
    for (run, table, row, cell) in report.cells() {
        let clock = serde_json::to_string(&run.clock).unwrap_or_default();
        let [width, height] = row.size;
        for field in [&run.device, &run.driver, clock.trim_matches('"'), &table.name.name(), &row.label] {
            csv += &quoted(field);
            csv.push(',');
        }
        let _ = write!(csv, "{},{width},{height},{},", row.x, quoted(&cell.way));
        match &cell.outcome {
            Outcome::Measured(m) => {
                let of = |value: Option<f64>| value.map_or(String::new(), |v| format!("{v:.4}"));
                let frame = m.frame();
                for value in [
                    frame.map(|f| f.median),
                    frame.map(|f| f.first_quartile),
                    frame.map(|f| f.third_quartile),
                ] {
                    csv += &of(value);
                    csv.push(',');
                }
                let _ = writeln!(
                    csv,
                    "{},{:.4},{},{},{},{},{},{},",
                    m.frame_ms.len(),
                    m.record_ms,
                    m.first_draws,
                    m.draws,
                    m.state_changes,
                    m.objects,
                    m.lights,
                    quoted(&m.plan)
                );
            }
            Outcome::Refused(reason) => {
                let _ = writeln!(csv, "{}{}", ",".repeat(11), quoted(reason));
            }
        }
    }
    csv
}

fn quoted(field: &str) -> String {
    let special = |c| matches!(c, ',' | '"' | '\n' | '\r');
    if field.contains(special) { format!("\"{}\"", field.replace('"', "\"\"")) } else { field.to_owned() }
}
