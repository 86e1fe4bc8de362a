//! The bandwidth of deferred shading with multiple render targets: Thibieroz, "Deferred Shading with Multiple Render
//! Targets", ShaderX2, 2004; tables 1 and 2, equations 4 to 7.

use std::ops::{Add, Mul};

use serde::Serialize;

use crate::{Error, Result};

/// Bytes that are read from and written to memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Traffic {
    /// Read.
    pub read: f64,
    /// Written.
    pub written: f64,
}

impl Traffic {
    /// Both ways together.
    pub fn total(self) -> f64 {
        self.read + self.written
    }
}

impl Add for Traffic {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { read: self.read + other.read, written: self.written + other.written }
    }
}

impl Mul<f64> for Traffic {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self { read: self.read * factor, written: self.written * factor }
    }
}

impl std::iter::Sum for Traffic {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), Add::add)
    }
}

/// The variables of the paper's table 1, by its names. Depths of pixels and texels are in bits, as the table has them; the
/// equations count bytes.
///
/// The model assumes a GPU without tiles that tests depth before it shades, takes one texel for a texture lookup however it
/// is filtered, and has no caches. The building pass is drawn into all render targets; each shading pass covers the whole
/// screen, reads them, and is added to the back buffer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Thibieroz {
    /// `W` and `H`: pixels.
    pub size: [u32; 2],
    /// `Z_BPP`: bits of depth and stencil a pixel.
    pub z_bpp: f64,
    /// `BB_BPP`: bits of the back buffer a pixel.
    pub bb_bpp: f64,
    /// `Overdraw`: fragments a pixel that reach the depth test in the building pass.
    pub overdraw: f64,
    /// `Sorting`: fragments a pixel that pass it. As many as `overdraw` where all is drawn from back to front, and 1 where
    /// all is drawn from front to back and covers the screen.
    pub sorting: f64,
    /// `T_BPP`: bits of a texel, on average.
    pub t_bpp: f64,
    /// `T_B`: texture lookups of a fragment in the building pass, on average.
    pub t_b: f64,
    /// `T_S`: texture lookups of a pixel in a shading pass, on average.
    pub t_s: f64,
    /// `n`: full-screen shading passes.
    pub n: f64,
    /// `n_MRT`: render targets.
    pub n_mrt: f64,
    /// `MRT_BPP`: bits of a render target a pixel; where they differ, the mean.
    pub mrt_bpp: f64,
    /// `C_Geometry`: bytes of vertices and indices read a frame.
    pub c_geometry: f64,
    /// Frames a second; 60 in the paper.
    pub fps: f64,
}

impl Default for Thibieroz {
    /// The values of table 1 and of the practical example, with the 128 bits of G-buffer that the paper's implementation
    /// has: four targets of 32 bits.
    fn default() -> Self {
        Self {
            size: [1024, 768],
            z_bpp: 32.0,
            bb_bpp: 32.0,
            overdraw: 3.0,
            sorting: 1.5,
            t_bpp: 24.0,
            t_b: 2.0,
            t_s: 4.0,
            n: 8.0,
            n_mrt: 4.0,
            mrt_bpp: 32.0,
            c_geometry: 16e6,
            fps: 60.0,
        }
    }
}

impl Thibieroz {
    /// Refuses what no frame can have.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for a number that is negative or not finite, for an empty picture, and for more fragments
    /// that pass the depth test than reach it.
    pub fn check(&self) -> Result<()> {
        let numbers = [
            ("Z_BPP", self.z_bpp),
            ("BB_BPP", self.bb_bpp),
            ("Overdraw", self.overdraw),
            ("Sorting", self.sorting),
            ("T_BPP", self.t_bpp),
            ("T_B", self.t_b),
            ("T_S", self.t_s),
            ("n", self.n),
            ("n_MRT", self.n_mrt),
            ("MRT_BPP", self.mrt_bpp),
            ("C_Geometry", self.c_geometry),
            ("frames a second", self.fps),
        ];
        if let Some((name, value)) = numbers.iter().find(|(_, v)| !(v.is_finite() && *v >= 0.0)) {
            return Err(Error::unsupported(format!("{name} is {value}"), "give a finite number, 0 or more"));
        }
        if self.size.contains(&0) {
            let [width, height] = self.size;
            return Err(Error::unsupported(format!("a picture of {width}x{height}"), "give a size above 0"));
        }
        if self.sorting > self.overdraw {
            return Err(Error::unsupported(
                format!("Sorting ({}) is above Overdraw ({})", self.sorting, self.overdraw),
                "fragments that pass the depth test are among those that reach it: Sorting is at most Overdraw",
            ));
        }
        Ok(())
    }

    /// Equation 4: bytes that building the G-buffer moves, a frame.
    pub fn building_pass(&self) -> Traffic {
        let depth = Traffic { read: self.overdraw, written: self.sorting } * bytes(self.z_bpp);
        let textures = read(self.t_b * self.sorting * bytes(self.t_bpp));
        let targets = written(self.n_mrt * self.sorting * bytes(self.mrt_bpp));
        (depth + textures + targets) * self.pixels() + read(self.c_geometry)
    }

    /// Equation 5: bytes that all shading passes move, a frame.
    pub fn shading_passes(&self) -> Traffic {
        let back_buffer = Traffic { read: 1.0, written: 1.0 } * bytes(self.bb_bpp);
        let textures = read(self.t_s * bytes(self.t_bpp));
        let targets = read(self.n_mrt * bytes(self.mrt_bpp));
        (back_buffer + textures + targets) * (self.n * self.pixels())
    }

    /// Bytes that both move, a frame.
    pub fn frame(&self) -> Traffic {
        self.building_pass() + self.shading_passes()
    }

    /// Equation 6: bytes a second.
    pub fn bandwidth(&self) -> Traffic {
        self.frame() * self.fps
    }

    /// Equation 7, which the paper calls a gross approximation of equation 6: bytes a second. It knows the G-buffer's size
    /// alone; everything else is as in table 1.
    pub fn bandwidth_approximated(&self) -> f64 {
        (self.n_mrt * bytes(self.mrt_bpp) / 2.0 + 10.0) * GIGA
    }

    fn pixels(&self) -> f64 {
        f64::from(self.size[0]) * f64::from(self.size[1])
    }
}

/// One entry of table 2.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Table2 {
    /// Render targets.
    pub n_mrt: u32,
    /// Bits of each a pixel.
    pub mrt_bpp: u32,
    /// What the table says, which is equation 7: GB/s, of 10⁹ bytes.
    pub printed_gb_s: f64,
    /// What equation 6, which it approximates, gives with the values of table 1: GB/s.
    pub equation_6_gb_s: f64,
    /// The same as the paper's practical example has it, which counts 8 bytes for `Z_BPP` where table 1 says 32 bits: GB/s.
    pub practical_example_gb_s: f64,
}

/// Table 2, row by row: the bandwidth of two to four render targets of 32, 64 and 128 bits, all else as in table 1.
pub fn table_2() -> Vec<Table2> {
    let sizes = [2, 3, 4].into_iter().flat_map(|n| [32, 64, 128].map(|bits| (n, bits)));
    let entry = |(n_mrt, mrt_bpp): (u32, u32)| {
        let model = Thibieroz { n_mrt: n_mrt.into(), mrt_bpp: mrt_bpp.into(), ..Thibieroz::default() };
        let example = Thibieroz { z_bpp: 64.0, ..model };
        Table2 {
            n_mrt,
            mrt_bpp,
            printed_gb_s: model.bandwidth_approximated() / GIGA,
            equation_6_gb_s: model.bandwidth().total() / GIGA,
            practical_example_gb_s: example.bandwidth().total() / GIGA,
        }
    };
    sizes.map(entry).collect()
}

/// The paper's GByte: it takes 60 times 16·10⁶ bytes for 1.
const GIGA: f64 = 1e9;

fn bytes(bits: f64) -> f64 {
    bits / 8.0
}

fn read(bytes: f64) -> Traffic {
    Traffic { read: bytes, written: 0.0 }
}

fn written(bytes: f64) -> Traffic {
    Traffic { read: 0.0, written: bytes }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As printed: rows of 2, 3 and 4 targets, columns of 32, 64 and 128 bits.
    const PRINTED_GB_S: [f64; 9] = [14.0, 18.0, 26.0, 16.0, 22.0, 34.0, 18.0, 26.0, 42.0];

    /// By hand: 60 * (1024 * 768 * (9.5 * bytes of G-buffer + 205) + 16e6), as the practical example has it.
    const PRACTICAL_EXAMPLE_B_S: [u64; 9] = [
        14_219_243_520,
        17_805_373_440,
        24_977_633_280,
        16_012_308_480,
        21_391_503_360,
        32_149_893_120,
        17_805_373_440,
        24_977_633_280,
        39_322_152_960,
    ];

    /// The example's 205 bytes have 8 * (3 + 1.5) of depth; with the 32 bits of table 1 it is half of them.
    const DEPTH_SURPLUS_B_S: u64 = 60 * 1024 * 768 * 18;

    #[test]
    fn table_2_is_equation_7_to_the_digit() {
        let table = table_2();
        let bytes = |gb_s: f64| (gb_s * GIGA).round() as u64;
        assert_eq!(table.iter().map(|e| e.printed_gb_s).collect::<Vec<_>>(), PRINTED_GB_S);
        let example: Vec<_> = table.iter().map(|e| bytes(e.practical_example_gb_s)).collect();
        assert_eq!(example, PRACTICAL_EXAMPLE_B_S);
        let exact: Vec<_> = table.iter().map(|e| bytes(e.equation_6_gb_s) + DEPTH_SURPLUS_B_S).collect();
        assert_eq!(exact, PRACTICAL_EXAMPLE_B_S);
        // Rounding what equation 7 approximates does not give the table, which is up to 7 % above the example.
        let rounded: Vec<_> = table.iter().map(|e| e.practical_example_gb_s.round()).collect();
        assert_eq!(rounded, [14.0, 18.0, 25.0, 16.0, 21.0, 32.0, 18.0, 25.0, 39.0]);
        let over = |e: &Table2| e.printed_gb_s / e.practical_example_gb_s - 1.0;
        let most = table.iter().map(over).fold(0.0, f64::max);
        assert!((0.06..0.07).contains(&most), "{most}");
    }

    /// Each term of equations 4 and 5 by itself, in bytes of a frame of one pixel.
    #[test]
    fn terms_go_the_right_way() {
        let model = Thibieroz {
            size: [1, 1],
            z_bpp: 8.0 * 2.0,
            bb_bpp: 8.0 * 3.0,
            overdraw: 100.0,
            sorting: 10.0,
            t_bpp: 8.0 * 5.0,
            t_b: 7.0,
            t_s: 11.0,
            n: 1000.0,
            n_mrt: 13.0,
            mrt_bpp: 8.0 * 17.0,
            c_geometry: 0.5,
            fps: 2.0,
        };
        let building =
            Traffic { read: 2.0 * 100.0 + 5.0 * 7.0 * 10.0 + 0.5, written: 2.0 * 10.0 + 13.0 * 17.0 * 10.0 };
        let shading = Traffic { read: 1000.0 * (3.0 + 11.0 * 5.0 + 13.0 * 17.0), written: 1000.0 * 3.0 };
        assert_eq!(model.building_pass(), building);
        assert_eq!(model.shading_passes(), shading);
        assert_eq!(model.bandwidth(), (building + shading) * 2.0);
    }

    #[test]
    fn impossible_frames_are_refused() {
        let good = Thibieroz::default();
        good.check().unwrap();
        // Most of the screen empty: less than one fragment a pixel.
        Thibieroz { overdraw: 0.25, sorting: 0.125, ..good }.check().unwrap();
        for (bad, named) in [
            (Thibieroz { sorting: 3.5, ..good }, "Sorting"),
            (Thibieroz { t_bpp: f64::NAN, ..good }, "T_BPP"),
            (Thibieroz { n: f64::INFINITY, ..good }, "n is"),
            (Thibieroz { c_geometry: -1.0, ..good }, "C_Geometry"),
            (Thibieroz { size: [0, 768], ..good }, "0x768"),
        ] {
            let message = bad.check().unwrap_err().to_string();
            assert!(message.contains(named), "{message}");
        }
    }
}
