//! What each tile of the shadow map holds, and which are drawn again.

use crate::visible::{ShadowView, TexelArea};

/// The map's tiles, in the plan's order: those of important lights first.
pub(super) struct Tiles {
    tiles: Vec<Tile>,
    /// Tiles to draw, this frame; kept so that choosing allocates nothing.
    chosen: Vec<Chosen>,
}

/// What a tile shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Content {
    pub(super) view: ShadowView,
    /// What is in it.
    pub(super) casters: Signature,
}

/// Which casters a view sees, and where they were.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Signature {
    /// Of what stands still.
    pub(super) fixed: u64,
    /// Of what is said to move; `None` if there is nothing of that kind.
    pub(super) dynamic: Option<u64>,
}

/// How often casters were moved so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Moves {
    pub(super) fixed: u64,
    pub(super) dynamic: u64,
}

/// A tile to be drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Chosen {
    pub(super) tile: usize,
    pub(super) how: How,
}

/// Where a tile's content comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum How {
    /// All casters are drawn into it.
    Whole,
    /// What stands still is copied from the map of it, and what moves is drawn over that.
    Composed {
        /// Whether the former has to be drawn first.
        fixed: bool,
        /// Whether that is all that has changed, so that the rest of the tile can stay.
        rest_stays: bool,
    },
}

#[derive(Clone, Copy, Default)]
struct Tile {
    /// What it should show; `None` if this frame has no use for it.
    wanted: Option<Content>,
    /// Casters' moves when that was found out.
    moves: Moves,
    /// What it shows.
    drawn: Option<Content>,
    /// What the map of what stands still shows.
    fixed_drawn: Option<(ShadowView, u64)>,
    /// Where dynamic casters are in it.
    dynamic: TexelArea,
    /// For how many frames what it shows has not been what it should.
    waiting: u32,
}

impl Tile {
    /// How to draw what is wanted, if what stands still may be kept apart.
    fn how(&self, wanted: &Content, may_compose: bool) -> How {
        let fixed = (wanted.view, wanted.casters.fixed);
        let kept = self.fixed_drawn == Some(fixed);
        // What has changed itself is not kept apart before it has stood still for a frame: it would be drawn twice.
        let stands = self.drawn.is_some_and(|drawn| (drawn.view, drawn.casters.fixed) == fixed);
        match may_compose && (kept || stands) {
            true => How::Composed { fixed: !kept, rest_stays: stands },
            false => How::Whole,
        }
    }
}

impl Tiles {
    pub(super) fn new(count: usize) -> Self {
        Self { tiles: vec![Tile::default(); count], chosen: Vec::with_capacity(count) }
    }

    /// Says what a tile should show in the next frame. `signature` says what is in a view; it is asked only if the view is
    /// another, or casters were moved.
    pub(super) fn want(
        &mut self,
        tile: usize,
        view: Option<ShadowView>,
        moves: Moves,
        signature: impl Fn(&ShadowView) -> Signature,
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

    /// Decides which tiles to draw, and how, and counts them as drawn: all that never were, and `most` of those that show
    /// something else than they should. Those that have waited longest come first, of these the most important ones.
    /// `may_compose` says of which tiles what stands still is kept apart. Returns how many have to wait.
    pub(super) fn choose(&mut self, most: usize, may_compose: impl Fn(usize) -> bool) -> usize {
        let Self { tiles, chosen } = self;
        chosen.clear();
        for (tile, state) in tiles.iter().enumerate() {
            if let Some(wanted) = state.wanted.filter(|wanted| state.drawn != Some(*wanted)) {
                chosen.push(Chosen { tile, how: state.how(&wanted, may_compose(tile)) });
            }
        }
        let new = |chosen: &Chosen| tiles[chosen.tile].drawn.is_none();
        // Keys are distinct, so that a sort that allocates nothing, and is not stable, will do.
        chosen.sort_unstable_by_key(|c| (!new(c), std::cmp::Reverse(tiles[c.tile].waiting), c.tile));
        let draw = chosen.iter().filter(|c| new(c)).count().max(most).min(chosen.len());
        for chosen in &chosen[draw..] {
            tiles[chosen.tile].waiting += 1;
        }
        let waiting = chosen.len() - draw;
        chosen.truncate(draw);
        for chosen in chosen.iter() {
            let tile = &mut tiles[chosen.tile];
            if let (How::Composed { fixed: true, .. }, Some(wanted)) = (chosen.how, tile.wanted) {
                tile.fixed_drawn = Some((wanted.view, wanted.casters.fixed));
            }
            *tile = Tile { drawn: tile.wanted, waiting: 0, ..*tile };
        }
        waiting
    }

    /// Says where dynamic casters are in a tile that is being drawn, and returns where they are or were.
    pub(super) fn set_dynamic(&mut self, tile: usize, area: TexelArea) -> TexelArea {
        let before = std::mem::replace(&mut self.tiles[tile].dynamic, area);
        before.union(area)
    }

    /// The tiles that [`Self::choose`] decided on.
    pub(super) fn chosen(&self) -> &[Chosen] {
        &self.chosen
    }

    /// Counts all tiles as never drawn.
    pub(super) fn forget(&mut self) {
        for tile in &mut self.tiles {
            (tile.drawn, tile.fixed_drawn) = (None, None);
        }
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
        Some(ShadowView::cascade(DVec3::NEG_Y, &sphere, &bounds, TileSize { texels: 64, guard: 3 }, true))
    }

    fn numbers(tiles: &Tiles) -> Vec<usize> {
        tiles.chosen().iter().map(|c| c.tile).collect()
    }

    fn frame(tiles: &mut Tiles, wanted: [Option<ShadowView>; 3], most: usize) -> (Vec<usize>, usize) {
        for (i, view) in wanted.into_iter().enumerate() {
            tiles.want(i, view, Moves::default(), |_| Signature::default());
        }
        let waiting = tiles.choose(most, |_| false);
        (numbers(tiles), waiting)
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
        let mut frame = |fixed, seen: u64| {
            let moves = Moves { fixed, dynamic: 0 };
            // Tile 0 sees what moves, tile 1 does not.
            tiles.want(0, view(0.0), moves, |_| Signature { fixed: seen, dynamic: None });
            tiles.want(1, view(5.0), moves, |_| Signature { fixed: 7, dynamic: None });
            tiles.choose(9, |_| true);
            numbers(&tiles)
        };
        assert_eq!(frame(0, 1), [0, 1]);
        // Without a move nothing is asked, and nothing can have changed.
        assert_eq!(frame(0, 2), [0; 0]);
        assert_eq!(frame(1, 2), [0]);
        assert_eq!(frame(2, 2), [0; 0]);
    }

    #[test]
    fn what_stands_still_is_drawn_once_beside_what_moves() {
        let composed = |fixed| How::Composed { fixed, rest_stays: true };
        let mut tiles = Tiles::new(1);
        let mut time = Moves::default();
        let mut frame = |fixed, dynamic, may_compose: bool| {
            time.dynamic += 1;
            tiles.want(0, view(0.0), time, |_| Signature { fixed, dynamic });
            tiles.choose(9, |_| may_compose);
            tiles.chosen().first().map(|c| c.how)
        };
        // Nothing that moves: nothing is kept apart.
        assert_eq!(frame(1, None, true), Some(How::Whole));
        assert_eq!(frame(1, Some(5), true), Some(composed(true)));
        assert_eq!(frame(1, Some(6), true), Some(composed(false)));
        // It stands still for a while, then leaves.
        assert_eq!(frame(1, Some(6), true), None);
        assert_eq!(frame(1, None, true), Some(composed(false)));
        // What stands still was moved.
        assert_eq!(frame(2, None, true), Some(How::Whole));
        assert_eq!(frame(2, Some(7), true), Some(composed(true)));
        assert_eq!(frame(3, Some(7), true), Some(How::Whole));
        let back = How::Composed { fixed: false, rest_stays: false };
        assert_eq!(frame(2, Some(7), true), Some(back));
        // A light that moves, too, has nothing to keep.
        assert_eq!(frame(2, Some(8), false), Some(How::Whole));
    }
}
