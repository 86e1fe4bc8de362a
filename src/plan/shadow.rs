//! The shadow map: one depth image in tiles, of which each light gets as many as its shadow needs.

use std::ops::Range;

use serde::Serialize;

use super::needs::element;
use super::{Format, Limits, Options, SceneKinds, ShadowFormat, SurfaceKind};
use crate::scene::{AlphaMode, Instance, Light, LightKind, Material, Scene, Shadow};
use crate::visible::{MOST_CASCADES, Reach, ShadowShape, TileSize};

/// A light that casts shadows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShadowNeed {
    /// Index into `Scene::lights`.
    pub light: usize,
    /// The light's name.
    pub name: String,
    /// What views its shadow takes.
    pub shape: ShadowShape,
    /// Texels that the map must have beyond what a view shows, for filters at its edge.
    pub guard_texels: u32,
    /// The light may move: nothing is kept for it.
    pub dynamic: bool,
    /// Whether it asks for a volume or for the map; `None` if it leaves that to the options.
    pub volume: Option<bool>,
    /// It is a point light.
    pub is_point: bool,
    /// It shines through a globe map.
    pub has_globe_map: bool,
    /// Why its shadow cannot be a volume; `None` if it can.
    pub no_volume: Option<&'static str>,
}

/// A kind of surface as the shadow map sees it; one pipeline each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct CasterKind {
    /// What cuts holes; `None` for solid surfaces, of which positions are all that is read.
    pub mask: Option<CasterMask>,
    /// Back faces cast shadows too.
    pub double_sided: bool,
    /// The instance's transform turns triangles round.
    pub mirrored: bool,
}

/// Where an alpha mask's values come from, beside the material's factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct CasterMask {
    /// The base colour texture is sampled.
    pub textured: bool,
    /// At TEXCOORD_1.
    pub second_texcoord: bool,
    /// At coordinates that the material transforms.
    pub transformed: bool,
    /// The mesh's stream of texture coordinates holds both sets.
    pub both_texcoords: bool,
    /// Vertex colours have an alpha.
    pub vertex_color: bool,
}

impl CasterKind {
    /// Of a surface; `None` if a mask cuts all of it, or it is blended over what is behind it.
    pub fn new(kind: &SurfaceKind, material: &Material) -> Option<Self> {
        let mask = CasterMask {
            textured: kind.samples(0),
            second_texcoord: kind.second_texcoord & 1 != 0,
            transformed: kind.transformed & 1 != 0,
            both_texcoords: kind.texcoord_sets()[1],
            vertex_color: kind.vertex_color,
        };
        let mask = match material.alpha_mode {
            AlphaMode::Mask { .. } if mask.textured || mask.vertex_color => Some(mask),
            AlphaMode::Mask { cutoff } if material.base_color_factor.w < cutoff => return None,
            _ if material.shows_behind() => return None,
            _ => None,
        };
        Some(Self { mask, double_sided: kind.double_sided, mirrored: kind.mirrored })
    }
}

impl std::fmt::Display for CasterKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.mask {
            None => write!(f, "solid")?,
            Some(mask) => {
                write!(f, "alpha mask")?;
                if mask.textured {
                    write!(f, " of a texture")?;
                }
                if mask.vertex_color {
                    write!(f, " of vertex colours")?;
                }
            }
        }
        let flags = [(self.double_sided, "double-sided"), (self.mirrored, "mirrored")];
        flags.iter().filter(|(on, _)| *on).try_for_each(|(_, name)| write!(f, " +{name}"))
    }
}

/// What a scene needs for shadows; empty if it has none.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ShadowNeeds {
    /// The most important first.
    pub lights: Vec<ShadowNeed>,
    /// Kinds of casters, in pipeline order.
    pub casters: Vec<CasterKind>,
    /// Some casters may move, and others do not.
    pub mixed: bool,
}

impl ShadowNeeds {
    /// Of a scene whose surfaces are of these kinds, in the order of its drawn instances.
    pub(super) fn new(scene: &Scene, kinds: impl Iterator<Item = (SurfaceKind, usize)>) -> Self {
        let mut casters = std::collections::BTreeSet::new();
        let mut lit = false;
        for (kind, material) in kinds {
            lit |= !kind.unlit;
            casters.extend(CasterKind::new(&kind, &scene.materials[material]));
        }
        let material = |instance: &Instance| &scene.materials[scene.meshes[instance.mesh].material];
        let casts = |instance: &Instance| !material(instance).shows_behind();
        let either = scene.triangles_of(|instance| casts(instance) || !material(instance).unlit);
        // A single triangle has nothing to cast its shadow on.
        if !lit || casters.is_empty() || either < 2 {
            return Self::default();
        }
        let bounds = scene.bounds_world();
        let mut lights: Vec<_> = (0..scene.lights.len())
            .filter(|&light| !scene.lights[light].is_dark())
            .filter_map(|light| Some((light, ShadowShape::of(&scene.lights[light])?)))
            .collect();
        lights.sort_by(|(a, _), (b, _)| {
            let [a, b] = [a, b].map(|&i| &scene.lights[i]);
            let light = |l: &crate::scene::Light| l.contribution_lm(bounds);
            b.priority.total_cmp(&a.priority).then(light(b).total_cmp(&light(a)))
        });
        let lights: Vec<_> = lights
            .into_iter()
            .map(|(light, shape)| ShadowNeed {
                light,
                name: scene.lights[light].name.clone(),
                shape,
                guard_texels: scene.lights[light].shadow.map_or(0, guard_texels),
                dynamic: scene.lights[light].dynamic,
                volume: scene.lights[light].shadow.and_then(|shadow| shadow.volume),
                is_point: matches!(scene.lights[light].kind, LightKind::Point { .. }),
                has_globe_map: scene.lights[light].shown_globe_map().is_some(),
                no_volume: no_volume(scene, &scene.lights[light]),
            })
            .collect();
        match lights.is_empty() {
            true => Self::default(),
            false => {
                let any = |dynamic| scene.drawn_instances().any(|instance| instance.dynamic == dynamic);
                Self { lights, casters: casters.into_iter().collect(), mixed: any(true) && any(false) }
            }
        }
    }
}

/// Why a light's shadow cannot be a volume.
fn no_volume(scene: &Scene, light: &Light) -> Option<&'static str> {
    if matches!(light.kind, LightKind::Box { .. }) {
        return Some("its light begins at a face of its box, and what is outside casts no shadow");
    }
    if light.has_back() {
        return Some("its light from behind has no shadow");
    }
    let reach = Reach::of(light);
    let kinds = SceneKinds::new(scene);
    let is_masked = |instance: &&Instance| {
        let material = &scene.materials[scene.meshes[instance.mesh].material];
        CasterKind::new(&SurfaceKind::new(&kinds, instance), material).is_some_and(|kind| kind.mask.is_some())
    };
    let is_reached = |instance: &Instance| {
        let bounds = scene.meshes[instance.mesh].bounds();
        bounds.is_some_and(|b| !reach.misses_aabb(&b.transformed(&instance.world_from_object)))
    };
    let masked = scene.drawn_instances().filter(is_masked).any(is_reached);
    masked.then_some("an alpha mask cuts something in its reach, and volumes have no holes")
}

impl ShadowNeeds {
    /// What is left for the map when these lights have volumes.
    pub(super) fn without(&self, volumes: &[usize]) -> Self {
        let lights: Vec<_> = self.lights.iter().filter(|l| !volumes.contains(&l.light)).cloned().collect();
        if lights.is_empty() { Self::default() } else { Self { lights, ..self.clone() } }
    }
}

/// A light's part of the shadow map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShadowLight {
    /// Index into `Scene::lights`.
    pub light: usize,
    /// The light's name.
    pub name: String,
    /// What views its shadow takes.
    pub shape: ShadowShape,
    /// Its tiles, one a view: a part of [`ShadowMap::tiles`].
    pub tiles: Range<usize>,
    /// Their size.
    pub size: TileSize,
    /// Whether the static map has a part for it: something moves in its light, and it does not.
    pub keeps_static: bool,
}

/// A square part of the shadow map, texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Tile {
    /// From the left.
    pub x: u32,
    /// From the top.
    pub y: u32,
    /// Its side.
    pub texels: u32,
}

/// One image for the shadows of all lights.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShadowMap {
    /// How a depth is stored.
    pub format: Format,
    /// Width and height in texels.
    pub size: [u32; 2],
    /// The lights that have a part of it, most important first.
    pub lights: Vec<ShadowLight>,
    /// Light by light.
    pub tiles: Vec<Tile>,
    /// What is drawn into it; one pipeline each.
    pub casters: Vec<CasterKind>,
    /// Whether there is a static map: a second image of the same size that holds what stands still, so that only what moves
    /// is drawn again.
    pub has_static_map: bool,
}

/// Smaller tiles are not worth their draw calls.
pub(super) const LEAST_TEXELS: u32 = 128;

/// A map of this side is a GiB of 32 bits: nobody means more.
pub(super) const MOST_TEXELS: u32 = 16384;

/// Without a choice of the user's, tiles have at most this side: larger ones cost more than they show.
const MOST_DEFAULT_TEXELS: u32 = 2048;

impl ShadowMap {
    /// Filters read this much beyond their radius: the texel that holds a sample's place, and one for rounding.
    pub const FILTER_MARGIN: u32 = 2;

    /// Gives each light its tiles; `None` if no light casts shadows. Second is what that leaves out.
    ///
    /// A map as large as allowed that is still too small is shared out by importance: sides are halved, those of the least
    /// important lights first, each light's once before any light's twice; when all are as small as can be, the least
    /// important lights go without.
    pub(super) fn new(
        needs: &ShadowNeeds,
        options: &Options,
        limits: &Limits,
    ) -> (Option<Self>, ShadowsTold) {
        let most = floor_power_of_two(options.shadows.most_texels.min(limits.max_image_size));
        let wanted: Vec<Ask> = needs.lights.iter().map(|need| Ask::new(need, options, most)).collect();
        let mut granted = wanted.clone();
        let area = |asks: &[Ask]| asks.iter().map(Ask::area).sum::<u64>();
        while area(&granted) > u64::from(most).pow(2) {
            let halvings = |i: usize| (wanted[i].texels / granted[i].texels).ilog2();
            let large =
                (0..granted.len()).filter(|&i| granted[i].texels > LEAST_TEXELS && granted[i].views > 0);
            match large.min_by_key(|&i| (halvings(i), std::cmp::Reverse(i))) {
                Some(light) => granted[light].texels /= 2,
                None => granted.iter_mut().rfind(|ask| ask.views > 0).expect("the area is not 0").views = 0,
            }
        }
        let (mut warnings, mut notes) = (Vec::new(), Vec::new());
        for (need, (wanted, granted)) in needs.lights.iter().zip(wanted.iter().zip(&granted)) {
            let map = format!("the shadow map of {most}x{most} texels is full");
            if granted.views == 0 {
                warnings.push(format!("{map}: {} casts no shadow", element("light", &need.name, need.light)));
            } else if granted.texels < wanted.texels {
                notes.push(format!(
                    "{map}: {} has tiles of {} texels instead of {}",
                    element("light", &need.name, need.light),
                    granted.texels,
                    wanted.texels
                ));
            }
        }
        let told = ShadowsTold { warnings, notes };
        if granted.iter().all(|ask| ask.views == 0) {
            return (None, told);
        }
        (Some(Self::place(needs, options, &granted)), told)
    }

    /// Tiles of powers of two in order of size along a Z curve leave no gap between them.
    fn place(needs: &ShadowNeeds, options: &Options, granted: &[Ask]) -> Self {
        let kept = || needs.lights.iter().zip(granted).filter(|(_, ask)| ask.views > 0);
        let side = kept().map(|(_, ask)| ask.texels).max().expect("some light has tiles");
        let area: u64 = kept().map(|(_, ask)| ask.area()).sum();
        let mut size = [u64::from(side); 2];
        while size[0] * size[1] < area {
            let shorter = if size[0] <= size[1] { 0 } else { 1 };
            size[shorter] *= 2;
        }
        let mut lights = Vec::new();
        let mut tiles = Vec::new();
        for (need, ask) in kept() {
            let first = tiles.len();
            tiles.extend((0..ask.views).map(|_| Tile { x: 0, y: 0, texels: ask.texels }));
            lights.push(ShadowLight {
                light: need.light,
                name: need.name.clone(),
                shape: need.shape,
                tiles: first..tiles.len(),
                size: TileSize { texels: ask.texels, guard: need.guard_texels.min(ask.texels / 5) },
                keeps_static: needs.mixed && !need.dynamic,
            });
        }
        let mut order: Vec<_> = (0..tiles.len()).collect();
        order.sort_by_key(|&i| std::cmp::Reverse(tiles[i].texels));
        let mut used = 0;
        for index in order {
            let tile = &mut tiles[index];
            let square = size[1] * size[1];
            let [x, y] = z_curve(used % square);
            (tile.x, tile.y) = (x + (used / square * size[1]) as u32, y);
            used += u64::from(tile.texels).pow(2);
        }
        Self {
            format: match options.shadows.format {
                ShadowFormat::Auto if lights.iter().all(|light| light.shape.is_parallel()) => {
                    Format::D16Unorm
                }
                ShadowFormat::Auto | ShadowFormat::D32 => Format::D32Float,
                ShadowFormat::D16 => Format::D16Unorm,
            },
            size: size.map(|s| s as u32),
            has_static_map: lights.iter().any(|light| light.keeps_static),
            lights,
            tiles,
            casters: needs.casters.clone(),
        }
    }

    /// What a light's `shadow` is on the GPU: its first tile + 1 and, 16 bits up, their number; 0 if it has none.
    pub fn reference(&self, light: usize) -> u32 {
        let lights = self.lights.iter().find(|l| l.light == light);
        lights.map_or(0, |l| (l.tiles.start as u32 + 1) | (l.tiles.len() as u32) << 16)
    }

    /// Bytes of the image, and of the static map.
    pub fn bytes(&self) -> u64 {
        let texels = self.size.iter().map(|&s| u64::from(s)).product::<u64>();
        texels * u64::from(self.format.bytes()) * if self.has_static_map { 2 } else { 1 }
    }

    /// Bytes that drawing a tile stores.
    pub fn tile_bytes(&self, tile: usize) -> u64 {
        u64::from(self.tiles[tile].texels).pow(2) * u64::from(self.format.bytes())
    }
}

/// What a reader should know of a map that is too small.
pub(super) struct ShadowsTold {
    /// Lights that cast no shadow.
    pub(super) warnings: Vec<String>,
    /// Lights that got less than they asked for.
    pub(super) notes: Vec<String>,
}

/// What a light asks for.
#[derive(Clone, Copy)]
struct Ask {
    views: u32,
    texels: u32,
}

impl Ask {
    fn new(need: &ShadowNeed, options: &Options, most: u32) -> Self {
        let [width, height] = options.size;
        // A texel a pixel, if the map fills the picture.
        let shown = floor_power_of_two(width.max(height)).clamp(LEAST_TEXELS, MOST_DEFAULT_TEXELS);
        let texels =
            floor_power_of_two(options.shadows.tile_texels.unwrap_or(shown)).clamp(LEAST_TEXELS, most);
        match need.shape {
            ShadowShape::Cascades => {
                Self { views: options.shadows.cascades.clamp(1, MOST_CASCADES as u32), texels }
            }
            ShadowShape::Slab | ShadowShape::Cone => Self { views: 1, texels },
            // A face shows a quarter of what is around a light's equator.
            ShadowShape::Cube => {
                Self { views: ShadowShape::FACES as u32, texels: (texels / 2).max(LEAST_TEXELS) }
            }
        }
    }

    fn area(&self) -> u64 {
        u64::from(self.views) * u64::from(self.texels).pow(2)
    }
}

fn floor_power_of_two(n: u32) -> u32 {
    n.checked_ilog2().map_or(0, |log| 1 << log)
}

/// The place of the n-th texel along a Z curve: its even bits are x, its odd ones y (Morton 1966).
fn z_curve(n: u64) -> [u32; 2] {
    let gather = |n: u64| (0..32).fold(0, |all, bit| all | ((n >> (2 * bit) & 1) as u32) << bit);
    [gather(n), gather(n >> 1)]
}

/// The filter's radius, and how far receivers are moved: by the distance to the radius' corner, and the bias. They leave a view
/// by no more: at most sin(theta) * (sin(theta) + cos(theta)) of that, with theta up to 45 degrees at the edge of a cube's face.
fn guard_texels(shadow: Shadow) -> u32 {
    let spread = spread_texels(shadow);
    let reach = spread + spread * std::f32::consts::SQRT_2 + bias_texels(shadow);
    reach.ceil() as u32 + ShadowMap::FILTER_MARGIN
}

/// Texels by which a light's shadow is moved, beside its filter's.
pub fn bias_texels(shadow: Shadow) -> f32 {
    shadow.bias_texels.clamp(0.0, Shadow::MOST_BIAS_TEXELS)
}

/// Texels over which a light's filter reaches.
pub fn spread_texels(shadow: Shadow) -> f32 {
    shadow.spread_texels.clamp(0.0, Shadow::MOST_SPREAD_TEXELS)
}
