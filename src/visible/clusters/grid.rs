//! How a view is cut into cells.

use crate::scene::{Camera, Projection};

/// Cells of a view: tiles of the image, cut by distance along the view axis.
///
/// Cells are counted along a row of tiles, then by rows, then by slices.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Grid {
    /// Tiles are squares of 2 to this power pixels.
    pub tile_shift: u32,
    /// Tiles across the image.
    pub columns: u32,
    /// Tiles down the image.
    pub rows: u32,
    /// Cuts by distance.
    pub slices: u32,
    /// Whether slices are equal steps of log2 of the distance in metres (perspective) or of the distance itself.
    pub logarithmic: bool,
    /// The slice of a measure m (see `logarithmic`) is `m * slice_scale + slice_bias`, rounded down and held within
    /// the slices: the first and the last have no end.
    pub slice_scale: f32,
    /// See `slice_scale`.
    pub slice_bias: f32,
}

/// Tiles are of 32 pixels, unless the image has more than this many of them: 32 for 1280x720, 64 for 1920x1080.
const MOST_TILES: u32 = 1024;
const LEAST_TILE_SHIFT: u32 = 5;
const MOST_SLICES: u32 = 24;
/// Slices in front of this share of the farthest light's distance would be thinner than tiles are wide.
const LEAST_NEAR_SHARE: f32 = 1.0 / 64.0;

impl Grid {
    /// The number of cells of any grid is at most this.
    pub const MOST_CELLS: usize = (MOST_TILES * MOST_SLICES) as usize;

    /// For a view of an image of this size in pixels, whose lights are so far away (nearest and farthest, metres).
    pub(super) fn new(camera: &Camera, size: [u32; 2], [nearest, farthest]: [f32; 2]) -> Self {
        let (logarithmic, near, far, half) = match camera.projection {
            Projection::Perspective { yfov_rad, znear_m, zfar_m } => {
                (true, znear_m, zfar_m.unwrap_or(f32::INFINITY), (yfov_rad * 0.5).tan())
            }
            Projection::Orthographic { ymag_m, znear_m, zfar_m, .. } => (false, znear_m, zfar_m, ymag_m),
        };
        let mut grid = Self { tile_shift: LEAST_TILE_SHIFT, slices: 1, logarithmic, ..Self::default() };
        grid.cut_tiles(size);
        while grid.columns * grid.rows > MOST_TILES {
            grid.tile_shift += 1;
            grid.cut_tiles(size);
        }
        let far = far.min(farthest);
        let near = near.max(nearest).max(if logarithmic { far * LEAST_NEAR_SHARE } else { near });
        let [first, last] = [near, far].map(|d| if logarithmic { d.log2() } else { d });
        if last > first {
            // Slices at least as thick as tiles are high.
            let tile = 2.0 * half * (1 << grid.tile_shift) as f32 / size[1] as f32;
            let least = if logarithmic { tile.ln_1p() / std::f32::consts::LN_2 } else { tile };
            grid.slices = (((last - first) / least) as u32).clamp(1, MOST_SLICES);
            grid.slice_scale = grid.slices as f32 / (last - first);
            grid.slice_bias = -first * grid.slice_scale;
        }
        grid
    }

    fn cut_tiles(&mut self, size: [u32; 2]) {
        [self.columns, self.rows] = size.map(|pixels| pixels.div_ceil(1 << self.tile_shift));
    }

    /// Twice as large in every direction.
    pub(super) fn coarsen(&mut self, size: [u32; 2]) {
        self.tile_shift += 1;
        self.cut_tiles(size);
        let slices = self.slices.div_ceil(2);
        let ratio = slices as f32 / self.slices as f32;
        self.slices = slices;
        self.slice_scale *= ratio;
        self.slice_bias *= ratio;
    }

    /// The number of cells.
    pub fn cell_count(&self) -> usize {
        (self.columns * self.rows * self.slices) as usize
    }

    /// The slice at a distance along the view axis, in metres.
    pub fn slice(&self, distance: f32) -> u32 {
        let measure = if self.logarithmic { distance.max(f32::MIN_POSITIVE).log2() } else { distance };
        // A conversion from float saturates.
        ((measure * self.slice_scale + self.slice_bias) as u32).min(self.slices - 1)
    }

    /// The cell of a pixel whose surface is at this distance along the view axis, in metres.
    pub fn cell(&self, [x, y]: [u32; 2], distance: f32) -> usize {
        let [column, row] = [x, y].map(|p| p >> self.tile_shift);
        ((self.slice(distance) * self.rows + row) * self.columns + column) as usize
    }

    /// The cell of a tile and a slice.
    #[cfg(feature = "view")]
    pub(crate) fn cell_at(&self, [column, row]: [u32; 2], slice: u32) -> usize {
        ((slice * self.rows + row) * self.columns + column) as usize
    }

    /// The distance at which a slice begins, by the formula: of the first slice too.
    pub(crate) fn begin(&self, slice: u32) -> f32 {
        let measure = (slice as f32 - self.slice_bias) / self.slice_scale;
        if self.logarithmic { measure.exp2() } else { measure }
    }
}

/// What separates cells, in the frame of the view: x to the right, y down, z along the view axis.
#[derive(Debug)]
pub(super) struct Planes {
    pub(super) columns: Vec<Plane>,
    pub(super) rows: Vec<Plane>,
    /// Where slices begin and the last one ends, metres.
    pub(super) slices: Vec<f32>,
}

/// A plane through the camera (perspective) or along the view axis, between two columns or rows. `across` is x for
/// columns and y for rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    /// Where it is, across, at a distance of 0.
    offset: f32,
    /// By how much that grows a metre of distance.
    slope: f32,
    /// 1 / length of the normal (1, -slope).
    inverse_length: f32,
}

impl Plane {
    /// How far beyond the plane a point is, across.
    pub(super) fn distance(&self, across: f32, z: f32) -> f32 {
        (across - self.at(z)) * self.inverse_length
    }

    /// Where the plane is at a distance.
    pub(super) fn at(&self, z: f32) -> f32 {
        self.offset + self.slope * z
    }

    /// The point of the plane nearest to one at this signed distance from it: z.
    pub(super) fn z_of_nearest(&self, z: f32, distance: f32) -> f32 {
        z + distance * self.slope * self.inverse_length
    }
}

/// Shaders round distances and logarithms: slices are taken as this much longer at both ends, relatively.
const ROUNDING: f32 = 1e-5;

impl Planes {
    pub(super) fn with_room() -> Self {
        let most = MOST_TILES as usize + 1;
        Self {
            columns: Vec::with_capacity(most),
            rows: Vec::with_capacity(most),
            slices: Vec::with_capacity(MOST_SLICES as usize + 1),
        }
    }

    pub(super) fn set(&mut self, grid: &Grid, camera: &Camera, size: [u32; 2]) {
        let [width, height] = size.map(|pixels| pixels as f32);
        let (half_height, perspective, near, far) = match camera.projection {
            Projection::Perspective { yfov_rad, znear_m, zfar_m } => {
                ((yfov_rad * 0.5).tan(), true, znear_m, zfar_m.unwrap_or(f32::INFINITY))
            }
            Projection::Orthographic { ymag_m, znear_m, zfar_m, .. } => (ymag_m, false, znear_m, zfar_m),
        };
        let plane = |index: u32, half: f32, pixels: f32| {
            let tile = (1_u64 << grid.tile_shift) as f32;
            let across = (index as f32 * tile * 2.0 / pixels - 1.0) * half;
            let [offset, slope] = if perspective { [0.0, across] } else { [across, 0.0] };
            Plane { offset, slope, inverse_length: (1.0 + slope * slope).sqrt().recip() }
        };
        self.columns.clear();
        let half_width = half_height * width / height;
        self.columns.extend((0..=grid.columns).map(|i| plane(i, half_width, width)));
        self.rows.clear();
        self.rows.extend((0..=grid.rows).map(|i| plane(i, half_height, height)));
        self.slices.clear();
        self.slices.push(near);
        self.slices.extend((1..grid.slices).map(|s| grid.begin(s).max(near)));
        self.slices.push(far);
    }

    /// Nearest and farthest distance of a slice.
    pub(super) fn slice(&self, slice: u32) -> [f32; 2] {
        let [near, far] = [self.slices[slice as usize], self.slices[slice as usize + 1]];
        [near - near.abs() * ROUNDING, far + far.abs() * ROUNDING]
    }
}
