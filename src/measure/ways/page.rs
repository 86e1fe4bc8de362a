//! A table of all points, a page, and a chart for each series of a scene.

use std::fmt::Write;
use std::path::Path;

use super::{Figures, Point, Report, Series};
use crate::measure::canvas::{Drawing, short};
use crate::measure::chart::{Field, Point as Mark, Scatter, pareto};
use crate::{Error, Result, file};

impl Series {
    const ALL: [Self; 5] = [Self::Samples, Self::Decals, Self::Shadows, Self::Translucency, Self::Refraction];

    fn title(self) -> &'static str {
        match self {
            Self::Samples => "Samples a pixel",
            Self::Decals => "Decals",
            Self::Shadows => "Shadows",
            Self::Translucency => "Translucency",
            Self::Refraction => "Refraction",
        }
    }

    fn about(self) -> &'static str {
        match self {
            Self::Samples => {
                "Against 64 samples a pixel. `all` lights every sample, `compare` and `coverage` those of edges, whose share of the \
                 pixels is counted; what is equal to `all` has lost nothing."
            }
            Self::Decals => {
                "Against the same paint in f64, where no edge of a surface is. Ways of one layout that have the same error paint the \
                 same picture."
            }
            Self::Translucency => {
                "Against 16 layers that were peeled off over surfaces that nothing rounds: what `peeled` is off by is the G-buffer's."
            }
            Self::Refraction => {
                "Against rays that are bent at surfaces, 16 a pixel, where no edge of a surface is. `none` bends nothing and stays on the \
                 tile; `pass` looks for what is behind in what it stores of it. Textures are filtered in another way than theirs."
            }
            Self::Shadows => {
                "Against rays, where no edge of a surface is, edges of shadows included. Maps that stand still are kept: their bytes are \
                 of a frame that draws all of them, their time is of frames that draw none."
            }
        }
    }

    /// What of memory the ways differ in, bytes a pixel.
    fn bytes(self, point: &Point, figures: &Figures) -> (f64, &'static str) {
        match self {
            Self::Refraction => (figures.moved.into(), "bytes a pixel loaded and stored (planned)"),
            Self::Samples | Self::Decals | Self::Translucency => {
                (figures.on_tile.into(), "bytes a pixel on the tile (planned)")
            }
            Self::Shadows => {
                let pixels = f64::from(point.size[0]) * f64::from(point.size[1]);
                let bytes = f64::from(figures.moved) + figures.shadow_bytes as f64 / pixels;
                (bytes, "bytes a pixel loaded and stored, all shadow maps drawn (planned)")
            }
        }
    }
}

/// Writes `ways.json`, a page (`README.md`) and its charts.
///
/// # Errors
/// [`Error::Io`]; [`Error::Unsupported`] if no scene has anything to chart.
pub fn write(report: &Report, folder: &Path) -> Result<()> {
    if !report.points.iter().any(|point| point.outcome.is_ok()) {
        let remedy = "give scenes with lit surfaces, decals or shadows, and a device that draws them";
        return Err(Error::unsupported("no scene has ways that could be measured", remedy));
    }
    let path = folder.join(Report::FILE);
    let json = serde_json::to_string_pretty(report).map_err(|e| Error::io(&path, "write", e.into()))?;
    file::write_whole(&path, format!("{json}\n").as_bytes())?;
    let mut page = String::from("# Ways of a frame: speed against accuracy\n\n");
    const TEXTURES: &str = "Where surfaces have textures, whose filters are the driver's own, decals and shadows are compared\n\
                            with what the reference makes of the surfaces that the layout `exact` stored.";
    let _ = writeln!(
        page,
        "Written by `ontile chart --ways`, drawn on {} ({}), {}. Errors are roots of mean squares of display light, of\n\
         which 1 is white; times are medians, drawn in turns. {TEXTURES}",
        report.device,
        report.driver,
        report.clock.describe()
    );
    for series in Series::ALL {
        let points: Vec<_> = report.points.iter().filter(|point| point.series == series).collect();
        if points.is_empty() {
            continue;
        }
        let _ = writeln!(page, "\n## {}\n\n{}\n", series.title(), series.about());
        table(&mut page, &points);
        let mut scenes: Vec<(&str, [u32; 2])> = Vec::new();
        for point in &points {
            if !scenes.contains(&(&point.scene, point.size)) {
                scenes.push((&point.scene, point.size));
            }
        }
        for (scene, size) in scenes {
            let of_scene: Vec<_> =
                points.iter().copied().filter(|p| p.scene == scene && p.size == size).collect();
            let Some(chart) = scatter(series, &of_scene) else { continue };
            let name = format!("{}-{scene}-{}x{}", series.title(), size[0], size[1]);
            let name: String = name
                .chars()
                .map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' })
                .collect();
            chart.write(&folder.join(&name))?;
            let _ = writeln!(page, "\n![{}: {scene}]({name}.svg)", series.title());
        }
    }
    file::write_whole(&folder.join("README.md"), page.as_bytes())
}

fn table(page: &mut String, points: &[&Point]) {
    *page += "| scene | way | milliseconds | bytes a pixel on the tile | moved | shadow maps, MB | lit by sample | error |\n\
              |---|---|---|---|---|---|---|---|\n";
    for point in points {
        let Point { scene, size: [width, height], way, .. } = point;
        let _ = match &point.outcome {
            Ok(f) => {
                let share = f.lit_by_sample.map_or(String::new(), |share| format!("{:.1} %", 100.0 * share));
                let megabytes = match f.shadow_bytes {
                    0 => String::new(),
                    bytes => format!("{:.1}", bytes as f64 * 1e-6),
                };
                writeln!(
                    page,
                    "| `{scene}` {width} x {height} | {way} | {:.2} ({:.2} to {:.2}) | {} | {} | {megabytes} | {share} | {:.5} |",
                    f.frame_ms.median,
                    f.frame_ms.first_quartile,
                    f.frame_ms.third_quartile,
                    f.on_tile,
                    f.moved,
                    f.error
                )
            }
            Err(why) => writeln!(page, "| `{scene}` {width} x {height} | {way} | refused: {why} | | | | | |"),
        };
    }
}

/// Where a point is across, and how far it spreads to either side.
type Across<'a> = dyn Fn(&Point, &Figures) -> (f64, Option<[f64; 2]>) + 'a;

fn scatter(series: Series, points: &[&Point]) -> Option<Scatter> {
    let measured: Vec<_> =
        points.iter().filter_map(|point| Some((*point, point.outcome.as_ref().ok()?))).collect();
    let (first, figures) = measured.first()?;
    let field = |x_label: &str, x: &Across<'_>| {
        let mark = |(color, (point, figures)): (usize, &(&Point, &Figures))| {
            let (x, spread) = x(point, figures);
            let error = figures.error.max(1e-9);
            Mark { name: point.way.clone(), x, spread, y: error, is_plain: true, color }
        };
        let marks: Vec<Mark> = measured.iter().enumerate().map(mark).collect();
        Field {
            x_label: x_label.into(),
            y_label: "root of the mean squared error".into(),
            logarithmic: true,
            front: pareto(&marks.iter().map(|mark| [mark.x, mark.y]).collect::<Vec<_>>()),
            points: marks,
        }
    };
    let quartiles = |f: &Figures| Some([f.frame_ms.first_quartile, f.frame_ms.third_quartile]);
    let time = field("milliseconds a frame", &|_, f| (f.frame_ms.median, quartiles(f)));
    let bytes = field(series.bytes(first, figures).1, &|point, f| (series.bytes(point, f).0, None));
    let Point { scene, size: [width, height], .. } = first;
    Some(Scatter {
        title: format!("{}: {scene} at {width} x {height}", series.title()),
        note:
            "Ringed, joined by the line: nothing beats them. Bars: quartiles of the times. The best error is "
                .to_owned()
                + &short(measured.iter().map(|(_, f)| f.error).fold(f64::MAX, f64::min))
                + ".",
        fields: vec![time, bytes],
    })
}
