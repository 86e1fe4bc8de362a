//! Which lights can reach which part of a view: clustered shading (Olsson, Billeter and Assarsson 2012, "Clustered
//! Deferred and Forward Shading").
//!
//! The view volume is cut into cells: tiles of the image, each cut again by distance. A pixel looks only at the lights
//! of its own cell.

mod assign;
mod grid;
#[cfg(test)]
mod tests;

use std::ops::Range;

use assign::Placed;
pub use grid::Grid;
use grid::Planes;

use super::Reach;
use crate::scene::Camera;

/// Light lists take this many entries a light at most before the grid is made coarser.
const ENTRIES_PER_LIGHT: usize = 256;
/// In all at least so many, 64 KiB, since few lights may be large; and at most so many, 4 MiB, so that memory stays
/// bounded, but always one a light, which is what the coarsest grid takes.
const LEAST_ENTRIES: usize = 1 << 14;
const MOST_ENTRIES: usize = 1 << 20;

/// Lists of lights, one a cell; built anew for each frame without allocating.
#[derive(Debug)]
pub struct Clusters {
    grid: Grid,
    planes: Planes,
    lights: Vec<Placed>,
    spans: Vec<Span>,
    words: Vec<u32>,
    most_entries: usize,
}

/// Neighbouring cells of a row that a light may reach.
#[derive(Clone, Copy, Debug)]
struct Span {
    light: u32,
    first_cell: u32,
    end_cell: u32,
}

impl Clusters {
    /// With room for so many lights; no grid yet, so no light in any list.
    pub fn new(most_lights: usize) -> Self {
        let most_entries = Self::most_entries(most_lights);
        Self {
            grid: Grid::default(),
            planes: Planes::with_room(),
            lights: Vec::with_capacity(most_lights),
            spans: Vec::with_capacity(most_entries),
            words: Vec::with_capacity(Self::most_words(most_lights)),
            most_entries,
        }
    }

    fn most_entries(lights: usize) -> usize {
        (lights * ENTRIES_PER_LIGHT).clamp(LEAST_ENTRIES, MOST_ENTRIES).max(lights)
    }

    /// The greatest length that [`Self::words`] can have for so many lights.
    pub fn most_words(lights: usize) -> usize {
        Grid::MOST_CELLS + 2 + Self::most_entries(lights)
    }

    /// Lists the lights for a view of an image of this size in pixels. The n-th light goes by the number
    /// `first_light + n`. There may be fewer than [`Self::new`] made room for; those beyond are left out.
    ///
    /// Every list is in rising order and has at least the lights that reach a point of its cell, as shaders compute
    /// them. Where lists would grow too long, the grid is coarser; one of a single cell always does.
    pub fn build(&mut self, camera: &Camera, size: [u32; 2], first_light: u32, lights: &[Reach]) {
        self.lights.clear();
        let room = self.lights.capacity();
        let view = assign::View::new(camera);
        let placed = lights.iter().take(room).zip(first_light..);
        self.lights.extend(placed.filter_map(|(reach, index)| view.place(reach, index)));
        self.grid = Grid::new(camera, size, assign::distances(&self.lights));
        while !self.try_build(camera, size) {
            self.grid.coarsen(size);
        }
    }

    fn try_build(&mut self, camera: &Camera, size: [u32; 2]) -> bool {
        self.planes.set(&self.grid, camera, size);
        self.spans.clear();
        let cells = self.grid.cell_count();
        self.words.clear();
        self.words.resize(cells + 2, 0);
        let (spans, words) = (&mut self.spans, &mut self.words);
        let mut entries = 0;
        for light in &self.lights {
            light.cells(&self.grid, &self.planes, &mut |cells: Range<u32>| {
                entries += cells.len();
                if entries <= self.most_entries {
                    spans.push(Span { light: light.index, first_cell: cells.start, end_cell: cells.end });
                    // By how much a cell has more entries than the one before it.
                    let more = &mut words[cells.start as usize + 1];
                    *more = more.wrapping_add(1);
                    let fewer = &mut words[cells.end as usize + 1];
                    *fewer = fewer.wrapping_sub(1);
                }
            });
            if entries > self.most_entries {
                return false;
            }
        }
        // From differences to beginnings: word c + 1 is where cell c's next entry goes, and so in the end where c + 1
        // begins.
        let (mut count, mut begin) = (0_u32, cells as u32 + 1);
        words[0] = begin;
        for word in &mut words[1..=cells] {
            count = count.wrapping_add(*word);
            *word = begin;
            begin += count;
        }
        words.resize(cells + 1 + entries, 0);
        let (begins, entries) = words.split_at_mut(cells + 1);
        for span in spans {
            for next in &mut begins[span.first_cell as usize + 1..span.end_cell as usize + 1] {
                entries[*next as usize - (cells + 1)] = span.light;
                *next += 1;
            }
        }
        true
    }

    /// How the view is cut.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Where each cell's list begins, where the last one ends, and then the lists. Beginnings count from the first word,
    /// and a list ends where the next one begins.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// The numbers of the lights in a cell's list.
    pub fn lights_of(&self, cell: usize) -> &[u32] {
        &self.words[self.words[cell] as usize..self.words[cell + 1] as usize]
    }
}
