//! What each tile of the shadow map holds, and which are drawn again.

use crate::visible::ShadowView;

/// The map's tiles, in the plan's order: those of important lights first.
pub(super) struct Tiles {
    tiles: Vec<Tile>,
    /// Tiles to draw, this frame; kept so that choosing allocates nothing.
    chosen: Vec<usize>,
}

/// What a tile shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Content {
    pub(super) view: ShadowView,
    /// `Casters::signature` of what is in it.
    pub(super) casters: u64,
}

#[derive(Clone, Copy, Default)]
struct Tile {
    /// What it should show; `None` if this frame has no use for it.
    wanted: Option<Content>,
    /// `Casters::moves` when that was found out.
    moves: u64,
    /// What it shows.
    drawn: Option<Content>,
    /// For how many frames the two have differed.
    waiting: u32,
}

impl Tiles {
    pub(super) fn new(count: usize) -> Self {
        Self { tiles: vec![Tile::default(); count], chosen: Vec::with_capacity(count) }
    }

    /// Says what a tile should show in the next frame. `moves` is how often casters were moved so far, `signature` says
    /// which are in a view; it is asked only if either has changed.
    pub(super) fn want(
        &mut self,
        tile: usize,
        view: Option<ShadowView>,
        moves: u64,
        signature: impl Fn(&ShadowView) -> u64,
    ) {
        let tile = &mut self.tiles[tile];
        let known = tile.wanted.filter(|wanted| Some(wanted.view) == view && tile.moves == moves);
        tile.wanted = known.or_else(|| view.map(|view| Content { view, casters: signature(&view) }));
        tile.moves = moves;
    }

    /// What a tile shows, if it is of use in this frame.
    pub(super) fn shown(&self, tile: usize) -> Option<&ShadowView> {
        let tile = &self.tiles[tile];
        tile.drawn.as_ref().filter(|_| tile.wanted.is_some()).map(|content| &content.view)
    }

    /// Decides which tiles to draw, and counts them as drawn: all that never were, and `most` of those that show something
    /// else than they should. Those that have waited longest come first, of these the most important ones. Returns how many
    /// have to wait.
    pub(super) fn choose(&mut self, most: usize) -> usize {
        let Self { tiles, chosen } = self;
        chosen.clear();
        let stale = |tile: &Tile| tile.wanted.is_some() && tile.wanted != tile.drawn;
        chosen.extend((0..tiles.len()).filter(|&i| stale(&tiles[i])));
        let new = |i: usize| tiles[i].drawn.is_none();
        // Keys are distinct, so that a sort that allocates nothing, and is not stable, will do.
        chosen.sort_unstable_by_key(|&i| (!new(i), std::cmp::Reverse(tiles[i].waiting), i));
        let draw = chosen.iter().filter(|&&i| new(i)).count().max(most).min(chosen.len());
        for &i in &chosen[draw..] {
            tiles[i].waiting += 1;
        }
        let waiting = chosen.len() - draw;
        chosen.truncate(draw);
        for &i in chosen.iter() {
            tiles[i] = Tile { drawn: tiles[i].wanted, waiting: 0, ..tiles[i] };
        }
        waiting
    }

    /// The tiles that [`Self::choose`] decided on.
    pub(super) fn chosen(&self) -> &[usize] {
        &self.chosen
    }

    /// Counts all tiles as never drawn.
    pub(super) fn forget(&mut self) {
        self.tiles.iter_mut().for_each(|tile| tile.drawn = None);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Aabb;
    use crate::visible::{Sphere, TileSize};
    use glam::{DVec3, Vec3};

    fn view(x: f64) -> Option<ShadowView> {
        let bounds = Aabb { min: Vec3::splat(-1.0), max: Vec3::ONE };
        let sphere = Sphere { center: DVec3::X * x, radius_m: 1.0 };
        Some(ShadowView::cascade(DVec3::NEG_Y, &sphere, &bounds, TileSize { texels: 64, guard: 3 }))
    }

    fn frame(tiles: &mut Tiles, wanted: [Option<ShadowView>; 3], most: usize) -> (Vec<usize>, usize) {
        wanted.into_iter().enumerate().for_each(|(i, view)| tiles.want(i, view, 0, |_| 0));
        let waiting = tiles.choose(most);
        (tiles.chosen().to_vec(), waiting)
    }

    #[test]
    fn tiles_are_drawn_once_and_then_kept() {
        let mut tiles = Tiles::new(3);
        // The limit is for tiles that have something to show meanwhile.
        assert_eq!(frame(&mut tiles, [view(0.0), view(5.0), None], 1), (vec![0, 1], 0));
        assert_eq!(frame(&mut tiles, [view(0.0), view(5.0), None], 1), (vec![], 0));
        assert_eq!(tiles.shown(1), view(5.0).as_ref());
        assert_eq!(tiles.shown(2), None);
        // Out of use, and back.
        assert_eq!(frame(&mut tiles, [None, view(5.0), view(9.0)], 1), (vec![2], 0));
        assert_eq!(tiles.shown(0), None);
        assert_eq!(frame(&mut tiles, [view(0.0), view(5.0), view(9.0)], 1), (vec![], 0));
        tiles.forget();
        assert_eq!(frame(&mut tiles, [view(0.0), view(5.0), view(9.0)], 1), (vec![0, 1, 2], 0));
    }

    #[test]
    fn who_waits_longest_is_next() {
        let mut tiles = Tiles::new(3);
        frame(&mut tiles, [0.0; 3].map(view), 0);
        // Everything changes in every frame, and one tile a frame is drawn.
        let drawn = [1.0, 2.0, 3.0, 4.0].map(|x| frame(&mut tiles, [view(x); 3], 1));
        assert_eq!(drawn, [0, 1, 2, 0].map(|i| (vec![i], 2)));
        assert_eq!([0, 1, 2].map(|i| *tiles.shown(i).unwrap()), [4.0, 2.0, 3.0].map(|x| view(x).unwrap()));
        assert_eq!(frame(&mut tiles, [view(4.0); 3], 9), (vec![1, 2], 0));
    }

    #[test]
    fn what_moves_is_drawn_again_where_it_is_seen() {
        let mut tiles = Tiles::new(2);
        let mut frame = |moves, signature: u64| {
            // Tile 0 sees what moves, tile 1 does not.
            tiles.want(0, view(0.0), moves, |_| signature);
            tiles.want(1, view(5.0), moves, |_| 7);
            tiles.choose(9);
            tiles.chosen().to_vec()
        };
        assert_eq!(frame(0, 1), [0, 1]);
        // Without a move nothing is asked, and nothing can have changed.
        assert_eq!(frame(0, 2), [0; 0]);
        assert_eq!(frame(1, 2), [0]);
        assert_eq!(frame(2, 2), [0; 0]);
    }
}
