//! What views the lights' shadows take.

use std::f32::consts::SQRT_2;

use glam::{DMat4, DVec3, DVec4};

use super::super::shared::ShadowViewData;
use crate::plan::{ShadowFilter, ShadowLight, ShadowMap, ShadowOptions, Tile, bias_texels, spread_texels};
use crate::scene::{Aabb, Camera, Light, Scene};
use crate::visible::{Cascades, MOST_CASCADES, ShadowShape, ShadowView};

/// How far receivers are moved towards the light, texels: less than what is seen, more than what rounding does to places.
const LIFT_TEXELS: f32 = 0.05;

/// How far casters are pushed beyond the filter's radius, texels: a texel holds the depth at its centre, and places half a
/// texel away in x and in y fall into it too.
const SLOPE_TEXELS: f32 = 1.0;

/// A light with its part of the shadow map.
pub(super) struct LightViews {
    light: Light,
    place: ShadowLight,
    spread_texels: f32,
    offset_texels: f32,
    slope_texels: f32,
    stable: bool,
}

impl LightViews {
    /// Those of the map, in its order.
    pub(super) fn of(scene: &Scene, options: &ShadowOptions, map: &ShadowMap) -> Vec<Self> {
        let views = map.lights.iter().map(|place| Self::new(&scene.lights[place.light], options, place));
        views.collect()
    }

    fn new(light: &Light, options: &ShadowOptions, place: &ShadowLight) -> Self {
        let mut views = Self {
            light: light.clone(),
            place: place.clone(),
            spread_texels: 0.0,
            offset_texels: 0.0,
            slope_texels: 0.0,
            stable: options.stable,
        };
        views.set(light, options);
        views
    }

    /// Changes the light, but for its name; its tiles stay the same. No allocation.
    pub(super) fn set(&mut self, light: &Light, options: &ShadowOptions) {
        let place = &self.place;
        let shadow = light.shadow.unwrap_or_default();
        let bias = bias_texels(shadow);
        // The guard is for the filter and for receivers that their offset, reach and bias, takes out of the view.
        let room = place.size.guard.saturating_sub(ShadowMap::FILTER_MARGIN) as f32;
        let wanted = spread_texels(shadow).min(((room - bias) / (1.0 + SQRT_2)).max(0.0));
        // And the distance to the farthest sample: a corner of a square, or a point on a circle.
        let (spread_texels, reach) = match options.filter {
            ShadowFilter::Hardware => (0.0, 0.0),
            ShadowFilter::Grid3 | ShadowFilter::Grid5 => (wanted, wanted * SQRT_2),
            ShadowFilter::Jittered => (wanted, wanted),
        };
        self.offset_texels = reach + bias;
        self.spread_texels = spread_texels;
        self.slope_texels = spread_texels + SLOPE_TEXELS;
        self.light = light.renamed(std::mem::take(&mut self.light.name));
    }

    /// Index into `Scene::lights`.
    pub(super) fn index(&self) -> usize {
        self.place.light
    }

    /// What views its shadow takes.
    pub(super) fn shape(&self) -> ShadowShape {
        self.place.shape
    }

    /// Calls `want` with what each of the light's tiles should show; `None` where it has no use for one.
    pub(super) fn views(
        &self,
        camera: &Camera,
        aspect: f64,
        bounds_world: &Aabb,
        mut want: impl FnMut(usize, Option<ShadowView>),
    ) {
        let Self { light, place, slope_texels, .. } = self;
        let mut want = |tile, view: Option<ShadowView>| {
            want(tile, view.map(|view| ShadowView { slope_texels: *slope_texels, ..view }));
        };
        if light.shadow.is_none() || light.is_dark() {
            place.tiles.clone().for_each(|tile| want(tile, None));
            return;
        }
        match place.shape {
            ShadowShape::Cascades => {
                let cascades =
                    Cascades::new(camera, aspect, bounds_world, place.tiles.len().min(MOST_CASCADES));
                let direction = light.direction_world.as_dvec3();
                for (i, tile) in place.tiles.clone().enumerate() {
                    let view = |s| ShadowView::cascade(direction, s, bounds_world, place.size, self.stable);
                    want(tile, cascades.spheres().get(i).map(view));
                }
            }
            ShadowShape::Slab => want(place.tiles.start, Some(ShadowView::slab(light, place.size))),
            ShadowShape::Cone => want(place.tiles.start, Some(ShadowView::cone(light, place.size))),
            ShadowShape::Cube => {
                for (face, tile) in place.tiles.clone().enumerate() {
                    want(tile, Some(ShadowView::face(light, face, place.size)));
                }
            }
        }
    }

    /// The light's tiles.
    pub(super) fn tiles(&self) -> std::ops::Range<usize> {
        self.place.tiles.clone()
    }

    /// What shaders need to look up a tile that shows `view`.
    pub(super) fn data(&self, view: &ShadowView, tile: &Tile, map: &ShadowMap) -> ShadowViewData {
        let size = DVec3::new(f64::from(map.size[0]), f64::from(map.size[1]), 1.0);
        let [x, y, side] = [tile.x, tile.y, tile.texels].map(f64::from);
        // From the tile's clip space to the map's texture coordinates.
        let scale = DVec3::new(side * 0.5, side * 0.5, 1.0) / size;
        let offset = DVec3::new(x + side * 0.5, y + side * 0.5, 0.0) / size;
        let map_from_clip =
            DMat4::from_cols(DVec4::X * scale.x, DVec4::Y * scale.y, DVec4::Z, offset.extend(1.0));
        let least = [(x + 0.5) / size.x, (y + 0.5) / size.y];
        let greatest = [(x + side - 0.5) / size.x, (y + side - 0.5) / size.y];
        ShadowViewData {
            map_from_world: (map_from_clip * view.clip_from_world.as_dmat4()).as_mat4().to_cols_array_2d(),
            tile: [least[0], least[1], greatest[0], greatest[1]].map(|n| n as f32),
            texel_m: view.texel_m,
            spread_texels: self.spread_texels,
            offset_texels: self.offset_texels,
            lift_texels: LIFT_TEXELS,
        }
    }
}
