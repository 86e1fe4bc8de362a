//! The scene's lights as they stand, and what of them a view sees, in the order in which shaders go through them.

use super::convert;
use super::shared::LightData;
use crate::plan::ShadowMap;
use crate::scene::{GlobePicture, Light, LightKind};
use crate::visible::{Frustum, Reach};
use crate::{Error, Result};

/// How many kinds of lights there are in buffers.
const LISTED: usize = 4;
/// How many kinds of lights there are: hemispheres become one, which is in no buffer.
const KINDS: usize = LISTED + 1;

/// All lights, in the scene's order.
pub(super) struct Lights {
    placed: Vec<Placed>,
    /// Indices into `placed`, by kind.
    order: Vec<usize>,
    /// The kinds that shaders were specialised for: those of which a light was not dark at first.
    planned: [bool; KINDS],
    /// Whether shaders were specialised for light from behind.
    planned_back: bool,
    /// Lights with shadow volumes that the frame written last sees.
    volumes: Vec<VolumeLight>,
}

/// A light whose shadow is counted in the stencil.
#[derive(Clone, Copy, Debug)]
pub(super) struct VolumeLight {
    /// Its number among the frame's lights.
    pub(super) index: u32,
    /// As in [`VolumePush`](super::shared::VolumePush).
    pub(super) light: [f32; 4],
    pub(super) reach: Reach,
}

/// What `LightData::shadow` is of those: `SHADOW_BY_VOLUME` in `glsl/light/direct.glsl`.
const BY_VOLUME: u32 = u32::MAX;

struct Placed {
    kind: usize,
    data: LightData,
    /// `None` of a dark light.
    reach: Option<Reach>,
    maps: Maps,
}

/// What a light has of the scene's maps.
#[derive(Clone, Copy, Default)]
struct Maps {
    /// Its part of the shadow map, as shaders know it; 0: none.
    shadow_tiles: u32,
    /// The picture that it shines through, and the first layer of that.
    globe: Option<(GlobePicture, u32)>,
}

impl Placed {
    fn new(light: &Light, maps: Maps) -> Self {
        let reach = (!light.is_dark()).then(|| Reach::of(light));
        let shadow = if light.shadow.is_some() { maps.shadow_tiles } else { 0 };
        let shown = light.shown_globe_map().and(maps.globe);
        let data = LightData { shadow, ..convert::light(light, shown.map(|(_, layer)| layer)) };
        Self { kind: kind_index(&light.kind), data, reach, maps }
    }

    /// Whether it needs shaders that light surfaces from behind.
    fn has_back(&self) -> bool {
        self.kind != LISTED && self.data.back_intensity != [0.0; 3]
    }
}

/// Which of [`KINDS`] it is; lights of a kind follow each other in the buffer, in this order.
fn kind_index(kind: &LightKind) -> usize {
    match kind {
        LightKind::Directional { .. } => 0,
        LightKind::Point { .. } => 1,
        LightKind::Spot { .. } => 2,
        LightKind::Box { .. } => 3,
        LightKind::Hemisphere { .. } => LISTED,
    }
}

impl Lights {
    /// `globe_layers` holds the first layer of each light's globe map, if the scene has any.
    pub(super) fn new(
        lights: &[Light],
        shadow_map: Option<&ShadowMap>,
        globe_layers: Option<&[Option<u32>]>,
        volume_lights: &[usize],
    ) -> Self {
        let placed = |(i, light): (usize, &Light)| {
            let layer = globe_layers.and_then(|layers| layers[i]);
            let maps = Maps {
                shadow_tiles: match volume_lights.contains(&i) {
                    true => BY_VOLUME,
                    false => shadow_map.map_or(0, |map| map.reference(i)),
                },
                globe: light.shown_globe_map().map(|map| map.picture).zip(layer),
            };
            Placed::new(light, maps)
        };
        let placed: Vec<_> = lights.iter().enumerate().map(placed).collect();
        let mut planned = [false; KINDS];
        placed.iter().filter(|l| l.reach.is_some()).for_each(|l| planned[l.kind] = true);
        let mut order: Vec<_> = (0..placed.len()).filter(|&i| planned[placed[i].kind]).collect();
        order.sort_by_key(|&i| placed[i].kind);
        let planned_back = placed.iter().any(|l| l.reach.is_some() && l.has_back());
        let volumes = Vec::with_capacity(volume_lights.len());
        Self { placed, order, planned, planned_back, volumes }
    }

    /// How many may be lit: the length of a buffer that can hold all of them.
    pub(super) fn count(&self) -> usize {
        self.order.len()
    }

    /// How many are not dark, hemispheres aside.
    pub(super) fn lit(&self) -> usize {
        self.placed.iter().filter(|l| l.reach.is_some() && l.kind < LISTED).count()
    }

    /// Changes an element of `Scene::lights`.
    pub(super) fn set(&mut self, index: usize, light: &Light) -> Result<()> {
        let lights = self.placed.len();
        let placed = self.placed.get_mut(index).ok_or_else(|| {
            Error::unsupported(
                format!("there is no light {index} to change"),
                format!("use an index below {lights}, the number of the scene's lights"),
            )
        })?;
        let changed = Placed::new(light, placed.maps);
        let picture = light.shown_globe_map().map(|map| map.picture);
        if !light.is_sound() {
            return Err(Error::unsupported(
                format!(
                    "light {index} ('{}') has numbers that are not finite, or shines darkness",
                    light.name
                ),
                "give finite numbers, and colour and intensity that are not negative",
            ));
        }
        let known = self.planned[changed.kind]
            && (self.planned_back || !changed.has_back())
            && picture.is_none_or(|picture| placed.maps.globe.is_some_and(|(known, _)| known == picture));
        if changed.kind != placed.kind || (changed.reach.is_some() && !known) {
            return Err(Error::unsupported(
                format!("light {index} ('{}') changes into one that the plan does not know", light.name),
                "make a plan and a renderer of the scene with the new light",
            ));
        }
        *placed = changed;
        Ok(())
    }

    /// Writes, as far as there is room, those that reach something that the view sees (all of them without a view) and are not dark, and returns
    /// how many they are of each kind: directional, point, spot, box. `reaches` gets the reach of each, in their order.
    pub(super) fn write_visible(
        &mut self,
        view: Option<&Frustum>,
        out: &mut [LightData],
        reaches: &mut Vec<Reach>,
    ) -> [u32; LISTED] {
        reaches.clear();
        let Self { order, placed, volumes, .. } = self;
        volumes.clear();
        let mut counts = [0; LISTED];
        for light in order.iter().map(|&i| &placed[i]).filter(|l| l.kind < LISTED) {
            let Some(reach) = light.reach else { continue };
            if !view.is_some_and(|view| view.misses(&reach)) {
                if let Some(out) = out.get_mut(reaches.len()) {
                    *out = light.data;
                }
                if light.data.shadow == BY_VOLUME {
                    let [x, y, z, _] = light.data.place;
                    let [dx, dy, dz] = light.data.direction_world.map(|c| -c);
                    let at = if light.kind == 0 { [dx, dy, dz, 0.0] } else { [x, y, z, 1.0] };
                    volumes.push(VolumeLight { index: reaches.len() as u32, light: at, reach });
                }
                reaches.push(reach);
                counts[light.kind] += 1;
            }
        }
        counts
    }

    /// Lights with shadow volumes that the frame written last sees.
    pub(super) fn volumes(&self) -> &[VolumeLight] {
        &self.volumes
    }

    /// All hemisphere lights that are not dark as one: [`FrameUniforms::hemispheres`](super::shared::FrameUniforms).
    pub(super) fn hemispheres(&self) -> [[f32; 4]; 3] {
        let lights = self.placed.iter().filter(|l| l.kind == LISTED && l.reach.is_some());
        convert::hemispheres(lights.map(|l| &l.data))
    }
}
