//! `ontile model`

use clap::Args;
use ontile::measure::bandwidth::{Table2, Thibieroz, Traffic, table_2};
use serde::Serialize;

use super::args::Size;
use super::print;

/// Show what deferred shading that leaves the chip would move, by a formula of 2004.
///
/// Thibieroz, "Deferred Shading with Multiple Render Targets": a GPU without tiles, one texel a lookup, no caches. The flags
/// have the paper's names and default to the values of its table 1; depths are in bits a pixel (bpp).
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  ontile model
  ontile model --n-mrt 4 --mrt-bpp 32 --n 1 --size 1920x1080
  ontile model --table-2")]
pub struct ModelArgs {
    /// Width and height, in pixels
    #[arg(long, value_name = "WxH", default_value = "1024x768")]
    pub size: Size,
    #[command(flatten)]
    pub inputs: InputArgs,
    /// Print the paper's table 2 instead: what is printed there, equation 6, and the paper's own working of it
    #[arg(long, conflicts_with_all = ["InputArgs", "size"])]
    pub table_2: bool,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// The paper's variables.
#[derive(Args, Debug)]
#[command(next_help_heading = "Model")]
pub struct InputArgs {
    /// Bits of depth and stencil a pixel [default: 32]
    #[arg(long, value_name = "BITS", value_parser = amount, allow_negative_numbers = true)]
    pub z_bpp: Option<f64>,
    /// Bits of the back buffer a pixel [default: 32]
    #[arg(long, value_name = "BITS", value_parser = amount, allow_negative_numbers = true)]
    pub bb_bpp: Option<f64>,
    /// Fragments a pixel that reach the depth test [default: 3]
    #[arg(long, value_name = "N", value_parser = amount, allow_negative_numbers = true)]
    pub overdraw: Option<f64>,
    /// Fragments a pixel that pass the depth test, at most as many [default: 1.5]
    #[arg(long, value_name = "N", value_parser = amount, allow_negative_numbers = true)]
    pub sorting: Option<f64>,
    /// Bits of a texel, on average [default: 24]
    #[arg(long, value_name = "BITS", value_parser = amount, allow_negative_numbers = true)]
    pub t_bpp: Option<f64>,
    /// Texture lookups of a fragment in the building pass [default: 2]
    #[arg(long, value_name = "N", value_parser = amount, allow_negative_numbers = true)]
    pub t_b: Option<f64>,
    /// Texture lookups of a pixel in a shading pass [default: 4]
    #[arg(long, value_name = "N", value_parser = amount, allow_negative_numbers = true)]
    pub t_s: Option<f64>,
    /// Shading passes over the whole screen [default: 8]
    #[arg(long, value_name = "N", value_parser = amount, allow_negative_numbers = true)]
    pub n: Option<f64>,
    /// Render targets of the G-buffer [default: 4]
    #[arg(long, value_name = "N", value_parser = amount, allow_negative_numbers = true)]
    pub n_mrt: Option<f64>,
    /// Bits of a render target a pixel [default: 32]
    #[arg(long, value_name = "BITS", value_parser = amount, allow_negative_numbers = true)]
    pub mrt_bpp: Option<f64>,
    /// Bytes of vertices and indices read a frame [default: 16e6]
    #[arg(long, value_name = "BYTES", value_parser = amount, allow_negative_numbers = true)]
    pub c_geometry: Option<f64>,
    /// Frames a second [default: 60]
    #[arg(long, value_name = "N", value_parser = amount, allow_negative_numbers = true)]
    pub fps: Option<f64>,
}

impl InputArgs {
    /// The variables as typed, and as they are in `otherwise` where they were not.
    fn over(&self, otherwise: Thibieroz) -> Thibieroz {
        let typed = |value: Option<f64>, other: f64| value.unwrap_or(other);
        Thibieroz {
            size: otherwise.size,
            z_bpp: typed(self.z_bpp, otherwise.z_bpp),
            bb_bpp: typed(self.bb_bpp, otherwise.bb_bpp),
            overdraw: typed(self.overdraw, otherwise.overdraw),
            sorting: typed(self.sorting, otherwise.sorting),
            t_bpp: typed(self.t_bpp, otherwise.t_bpp),
            t_b: typed(self.t_b, otherwise.t_b),
            t_s: typed(self.t_s, otherwise.t_s),
            n: typed(self.n, otherwise.n),
            n_mrt: typed(self.n_mrt, otherwise.n_mrt),
            mrt_bpp: typed(self.mrt_bpp, otherwise.mrt_bpp),
            c_geometry: typed(self.c_geometry, otherwise.c_geometry),
            fps: typed(self.fps, otherwise.fps),
        }
    }
}

fn amount(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(amount) if amount >= 0.0 && amount.is_finite() => Ok(amount),
        _ => Err("give a number, 0 or more".into()),
    }
}

/// The model by hand; bytes a frame, and bytes a second where it says so.
#[derive(Serialize)]
struct ByHand {
    model: Thibieroz,
    building_pass: Traffic,
    shading_passes: Traffic,
    frame: Traffic,
    bandwidth_b_s: Traffic,
    /// Equation 7, which holds for table 1 alone.
    approximated_b_s: Option<f64>,
}

impl ByHand {
    fn new(model: Thibieroz) -> Self {
        let of_table_1 =
            model == Thibieroz { n_mrt: model.n_mrt, mrt_bpp: model.mrt_bpp, ..Thibieroz::default() };
        Self {
            model,
            building_pass: model.building_pass(),
            shading_passes: model.shading_passes(),
            frame: model.frame(),
            bandwidth_b_s: model.bandwidth(),
            approximated_b_s: of_table_1.then(|| model.bandwidth_approximated()),
        }
    }
}

impl std::fmt::Display for ByHand {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let m = &self.model;
        let [width, height] = m.size;
        writeln!(f, "Thibieroz 2004, modelled: {width}x{height}, {} targets of {} bpp", m.n_mrt, m.mrt_bpp)?;
        writeln!(
            f,
            "  Z {} bpp, back buffer {} bpp, Overdraw {}, Sorting {}, T {} bpp, T_B {}, T_S {}, n {}, C_Geometry {} bytes\n",
            m.z_bpp, m.bb_bpp, m.overdraw, m.sorting, m.t_bpp, m.t_b, m.t_s, m.n, m.c_geometry
        )?;
        writeln!(f, "  {:<32} {:>10} {:>10} {:>10}", "", "read", "written", "both")?;
        let mut row = |what: &str, traffic: Traffic, unit: f64| {
            let [read, written, both] =
                [traffic.read, traffic.written, traffic.total()].map(|bytes| bytes / unit);
            writeln!(f, "  {what:<32} {read:>10.3} {written:>10.3} {both:>10.3}")
        };
        row("building pass (4), MB a frame", self.building_pass, 1e6)?;
        row("shading passes (5), MB a frame", self.shading_passes, 1e6)?;
        row("both, MB a frame", self.frame, 1e6)?;
        row(&format!("both at {} fps (6), GB/s", m.fps), self.bandwidth_b_s, 1e9)?;
        match self.approximated_b_s {
            Some(bytes) => {
                write!(f, "  {:<32} {:>10} {:>10} {:>10.3}", "approximated (7), GB/s", "", "", bytes / 1e9)
            }
            None => write!(f, "  (7) approximates (6) for the values of table 1 alone"),
        }
    }
}

/// Table 2.
#[derive(Serialize)]
#[serde(transparent)]
struct Table(Vec<Table2>);

impl std::fmt::Display for Table {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "Thibieroz 2004, table 2, modelled, GB/s:\n\n  targets  bpp   printed = (7)     (6)   (6) with 8 bytes of Z"
        )?;
        self.0.iter().try_for_each(|e| {
            write!(
                f,
                "\n  {:>7} {:>4} {:>15} {:>7.2} {:>23.2}",
                e.n_mrt, e.mrt_bpp, e.printed_gb_s, e.equation_6_gb_s, e.practical_example_gb_s
            )
        })
    }
}

/// Prints the model.
pub fn run(args: &ModelArgs) -> ontile::Result<()> {
    if args.table_2 {
        return print::value(&Table(table_2()), args.json);
    }
    let model = args.inputs.over(Thibieroz { size: args.size.0, ..Thibieroz::default() });
    model.check()?;
    print::value(&ByHand::new(model), args.json)
}
