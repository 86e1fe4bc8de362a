//! What a scene needs of the renderer: the only thing a plan knows about a scene.

use std::collections::BTreeMap;

use serde::Serialize;

use super::decals::{self, DecalNeed};
use super::particles::{self, ParticleNeed};
use super::{Around, EnvironmentNeed, LightmapNeed, LightmapUse, PosedNeed, SceneKinds, ShadowNeeds};
use crate::scene::{
    AlphaMode, Background, Fog, Instance, Light, LightKind, Material, Scene, TextureRef, Transmission,
};
use crate::visible::Reach;

/// The texture slots of a material, in the order of shader slots.
pub const SLOTS: [&str; 5] = ["base colour", "metallic-roughness", "normal", "occlusion", "emissive"];

/// Everything that decides which geometry pipeline draws a mesh.
///
/// A bit set over [`SLOTS`] is a `u8` whose bit `i` is slot `i`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct SurfaceKind {
    /// The base colour is the result; no G-buffer content.
    pub unlit: bool,
    /// Slots that are sampled.
    pub textures: u8,
    /// Sampled slots that use TEXCOORD_1 (else TEXCOORD_0).
    pub second_texcoord: u8,
    /// Sampled slots with a texture transform.
    pub transformed: u8,
    /// COLOR_0 multiplies the base colour.
    pub vertex_color: bool,
    /// Fragments below the cutoff are discarded.
    pub alpha_mask: bool,
    /// Drawn from both sides.
    pub double_sided: bool,
    /// The instance's transform turns the winding round.
    pub mirrored: bool,
    /// Adds emitted light.
    pub emissive: bool,
    /// Adds light from all around.
    pub around: Around,
    /// Whether a lightmap brings its diffuse light.
    pub lightmap: LightmapUse,
    /// Laid over what is behind, after lighting.
    pub blend: bool,
    /// Beside that, what is behind goes through it and is absorbed.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub transmits: bool,
}

impl SurfaceKind {
    /// What drawing an instance of the scene needs.
    pub fn new(kinds: &SceneKinds, instance: &Instance) -> Self {
        let mesh = &kinds.scene.meshes[instance.mesh];
        let material = &kinds.scene.materials[mesh.material];
        let lit = !material.unlit;
        let emissive = lit && material.emissive_factor != glam::Vec3::ZERO;
        let is_painted = lit && kinds.is_painted && material.alpha_mode != AlphaMode::Blend;
        let around = if lit && !is_painted { kinds.around } else { Around::Nothing };
        let mut kind = Self {
            unlit: material.unlit,
            vertex_color: !mesh.colors.is_empty(),
            alpha_mask: matches!(material.alpha_mode, AlphaMode::Mask { .. }),
            double_sided: material.double_sided,
            mirrored: instance.is_mirrored(),
            emissive,
            around,
            lightmap: kinds.lightmap_of(instance),
            blend: material.shows_behind(),
            transmits: material.transmits().is_some(),
            ..Self::default()
        };
        let wanted = [
            true,
            lit,
            lit && !mesh.tangents.is_empty(),
            (around.any() || is_painted) && material.occlusion_strength != 0.0,
            emissive,
        ];
        for (slot, (texture, wanted)) in Self::textures_of(material).into_iter().zip(wanted).enumerate() {
            let Some(texture) = texture.filter(|t| wanted && !mesh.texcoords[t.texcoord].is_empty()) else {
                continue;
            };
            let bit = 1 << slot;
            kind.textures |= bit;
            kind.second_texcoord |= if texture.texcoord == 1 { bit } else { 0 };
            kind.transformed |= if texture.uv_from_texcoord == TextureRef::IDENTITY { 0 } else { bit };
        }
        kind
    }

    /// That of a decal as far as its material goes: these slots, on texture coordinates of its own.
    pub(super) fn of_decal(textures: u8, transformed: u8) -> Self {
        Self { textures, transformed, ..Self::default() }
    }

    /// What drawing its depth alone takes: which sides are drawn, and all of a kind that a mask cuts.
    pub fn depth(&self) -> Self {
        match self.alpha_mask {
            true => *self,
            false => Self { double_sided: self.double_sided, mirrored: self.mirrored, ..Self::default() },
        }
    }

    /// The material's textures in slot order.
    pub fn textures_of(m: &Material) -> [Option<TextureRef>; 5] {
        [
            m.base_color_texture,
            m.metallic_roughness_texture,
            m.normal_texture,
            m.occlusion_texture,
            m.emissive_texture,
        ]
    }

    /// Whether this slot is sampled.
    pub fn samples(&self, slot: usize) -> bool {
        self.textures & (1 << slot) != 0
    }

    /// The index of this slot's texture among the sampled ones.
    pub fn texture_index(&self, slot: usize) -> Option<usize> {
        self.samples(slot).then(|| (self.textures & ((1 << slot) - 1)).count_ones() as usize)
    }

    /// Whether this slot holds sRGB-encoded colour.
    pub const fn is_srgb(slot: usize) -> bool {
        matches!(slot, 0 | 4)
    }

    /// Whether normal mapping needs a tangent per vertex.
    pub fn needs_tangents(&self) -> bool {
        self.samples(2)
    }

    /// Texture coordinate sets that the mesh's vertices carry: those that are read, or that other instances of the mesh
    /// read.
    pub fn texcoord_sets(&self) -> [bool; 2] {
        let by_lightmap = self.lightmap != LightmapUse::Nowhere;
        [self.textures & !self.second_texcoord != 0, self.second_texcoord != 0 || by_lightmap]
    }

    /// Whether a lightmap is sampled.
    pub fn has_lightmap(&self) -> bool {
        self.lightmap == LightmapUse::Here
    }

    /// Whether texture coordinates are read.
    pub fn reads_texcoords(&self) -> bool {
        self.textures != 0 || self.has_lightmap()
    }
}

impl std::fmt::Display for SurfaceKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", if self.unlit { "unlit" } else { "lit" })?;
        for (slot, name) in SLOTS.iter().enumerate().filter(|(slot, _)| self.samples(*slot)) {
            write!(f, " +{name}")?;
            if self.second_texcoord & (1 << slot) != 0 {
                write!(f, " (TEXCOORD_1)")?;
            }
            if self.transformed & (1 << slot) != 0 {
                write!(f, " (transformed)")?;
            }
        }
        let flags = [
            (self.vertex_color, "vertex colour"),
            (self.alpha_mask, "alpha mask"),
            (self.double_sided, "double-sided"),
            (self.mirrored, "mirrored"),
            (self.emissive, "emissive"),
            (self.around == Around::Ambient, "ambient"),
            (self.around == Around::Environment, "environment"),
            (self.has_lightmap(), "lightmap"),
            (self.lightmap == LightmapUse::Elsewhere, "vertices of lightmapped instances"),
            (self.around == Around::Probes, "probes"),
            (self.transmits, "transmission"),
        ];
        flags.iter().filter(|(on, _)| *on).try_for_each(|(_, name)| write!(f, " +{name}"))
    }
}

/// One kind of surface, and the scene elements that need it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KindNeed {
    /// What the pipeline must do.
    pub kind: SurfaceKind,
    /// How many instances are drawn with it.
    pub instances: usize,
    /// The first material that needs it.
    pub why: String,
}

/// What a scene needs.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Needs {
    /// Kinds of surfaces, in pipeline order.
    pub kinds: Vec<KindNeed>,
    /// The first lit material, if any: lights exist for it.
    pub lit: Option<String>,
    /// The first lit material that is not blended, if any: G-buffer and lighting exist for it.
    pub lit_opaque: Option<String>,
    /// The first material that light goes through, if any: the stage that absorbs it and the light target exist for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transmits: Option<String>,
    /// The most that a texture's sampler asks for; up to 1 is none.
    #[serde(skip_serializing_if = "is_isotropic")]
    pub anisotropy: u8,
    /// The first of these that bends light: it has an index of refraction above 1, and is thicker than a pane.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refracts: Option<String>,
    /// The first blended material, if any: translucency and the light target under it exist for it.
    pub blended: Option<String>,
    /// Why light must be summed before lighting (emission, ambient light, unlit surfaces beside lit ones);
    /// empty if nothing asks for a light target.
    pub prelit: Vec<String>,
    /// Directional lights that are not dark.
    pub directional_lights: usize,
    /// Point lights that are not dark.
    pub point_lights: usize,
    /// Spot lights that are not dark.
    pub spot_lights: usize,
    /// Box lights that are not dark.
    pub box_lights: usize,
    /// Hemisphere lights that are not dark.
    pub hemisphere_lights: usize,
    /// Directional and box lights that light surfaces from behind too.
    pub back_colors: usize,
    /// Lights that are not dark and have a place, but no end: each reaches every pixel.
    pub endless_lights: usize,
    /// How many of the listed lights reach a point of the scene on average: the sum of the shares of its ground that the boxes
    /// around them cover.
    pub lights_at_a_point: f32,
    /// Point, spot and box lights that shine through a globe map.
    pub globe_maps: usize,
    /// How many lights that have a place may be lit: dark ones too, if one of their kind is not dark, since a host may
    /// light them up.
    pub most_local_lights: usize,
    /// The environment, if anything receives its light.
    pub environment: Option<EnvironmentNeed>,
    /// Lights that cast shadows, and what casts them.
    pub shadows: ShadowNeeds,
    /// Probes, if anything receives their light.
    pub probes: Vec<EnvironmentNeed>,
    /// Triangles drawn; a single one needs no depth test.
    pub triangles: usize,
    /// How many of these are blended: they hide nothing.
    pub blended_triangles: usize,
    /// The background, as linear display light, if it is a colour.
    pub background: Option<[f32; 3]>,
    /// Whether the environment is the background.
    pub sky: bool,
    /// The lightmap, if a surface has a part of it.
    pub lightmap: Option<LightmapNeed>,
    /// Fog, if it changes anything.
    pub fog: Option<Fog>,
    /// Kinds of decals, in pipeline order; empty where nothing that is not blended is lit.
    pub decals: Vec<DecalNeed>,
    /// What surfaces of the G-buffer receive from all around in lighting, once decals have painted them: what they reflect of it
    /// is then no light that exists before.
    pub painted_around: Around,
    /// The first material whose occlusion lighting needs for that.
    pub occlusion: Option<String>,
    /// Kinds of particles, in pipeline order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub particles: Vec<ParticleNeed>,
    /// What bends.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub posed: Option<PosedNeed>,
}

impl Needs {
    /// Lights that are not dark and have a place, so that they may be far from a pixel.
    pub fn local_lights(&self) -> usize {
        self.point_lights + self.spot_lights + self.box_lights
    }

    /// Lights that are not dark and that shaders go through one by one: all but hemispheres.
    pub fn listed_lights(&self) -> usize {
        self.directional_lights + self.local_lights()
    }

    /// Lights that are not dark and shine everywhere alike.
    pub fn global_lights(&self) -> usize {
        self.directional_lights + self.hemisphere_lights
    }

    /// Reads them off a scene.
    pub fn of(scene: &Scene) -> Self {
        let of_scene = SceneKinds::new(scene);
        let mut kinds: BTreeMap<SurfaceKind, KindNeed> = BTreeMap::new();
        for instance in scene.drawn_instances() {
            let material = scene.meshes[instance.mesh].material;
            let kind = SurfaceKind::new(&of_scene, instance);
            kinds
                .entry(kind)
                .or_insert_with(|| KindNeed {
                    kind,
                    instances: 0,
                    why: element("material", &scene.materials[material].name, material),
                })
                .instances += 1;
        }
        let surfaces =
            scene.drawn_instances().map(|i| (SurfaceKind::new(&of_scene, i), scene.meshes[i.mesh].material));
        let shadows = ShadowNeeds::new(scene, surfaces);
        let kinds: Vec<_> = kinds.into_values().collect();
        let first = |wanted: fn(&SurfaceKind) -> bool| kinds.iter().find(|n| wanted(&n.kind));
        let lit = first(|k| !k.unlit).map(|n| n.why.clone());
        let lit_opaque = first(|k| !k.unlit && !k.blend).map(|n| n.why.clone());
        let environment = scene.environment.as_ref().filter(|e| !e.is_dark());
        let sky = scene.background == Background::Environment && environment.is_some();
        let environment = environment.filter(|_| lit.is_some() || sky);
        let mut prelit = Vec::new();
        if lit_opaque.is_some() {
            let mut ask = |wanted: fn(&SurfaceKind) -> bool, what| {
                let first = kinds.iter().find(|n| !n.kind.blend && wanted(&n.kind));
                prelit.extend(first.map(|n| format!("{} {what}", n.why)));
            };
            ask(|k| k.emissive, "is emissive");
            ask(|k| k.unlit, "is unlit");
            ask(|k| k.around == Around::Ambient, "receives ambient light");
            ask(|k| k.around == Around::Environment, "receives light of the environment");
            ask(|k| k.has_lightmap(), "has a lightmap");
            ask(|k| k.around == Around::Probes, "receives light of probes");
            prelit.extend(sky.then(|| "the environment is seen behind surfaces".to_owned()));
        }
        let painted_around =
            if of_scene.is_painted && lit_opaque.is_some() { of_scene.around } else { Around::Nothing };
        let occlusion = first(|k| !k.unlit && !k.blend && k.samples(3)).map(|n| n.why.clone());
        // Where nothing is lit, lights are nothing.
        let lights = || scene.lights.iter().filter(|l| lit.is_some() && !l.is_dark());
        let count = |wanted: fn(&LightKind) -> bool| lights().filter(|l| wanted(&l.kind)).count();
        Self {
            prelit,
            directional_lights: count(|k| matches!(k, LightKind::Directional { .. })),
            point_lights: count(|k| matches!(k, LightKind::Point { .. })),
            spot_lights: count(|k| matches!(k, LightKind::Spot { .. })),
            box_lights: count(|k| matches!(k, LightKind::Box { .. })),
            hemisphere_lights: count(|k| matches!(k, LightKind::Hemisphere { .. })),
            back_colors: lights()
                .filter(|l| l.has_back() && !matches!(l.kind, LightKind::Hemisphere { .. }))
                .count(),
            endless_lights: lights().filter(|l| is_local(l) && Reach::of(l) == Reach::Everywhere).count(),
            lights_at_a_point: lights_at_a_point(scene),
            globe_maps: lights().filter(|l| l.shown_globe_map().is_some()).count(),
            most_local_lights: most_local_lights(scene),
            environment: environment.map(EnvironmentNeed::new),
            probes: scene
                .probes
                .iter()
                .filter(|_| lit.is_some())
                .map(|probe| EnvironmentNeed {
                    name: probe.name.clone(),
                    ..EnvironmentNeed::new(&probe.environment)
                })
                .collect(),
            sky,
            lightmap: first(|k| k.has_lightmap()).and_then(|_| LightmapNeed::of(scene)),
            shadows,
            triangles: scene.triangle_count(),
            blended: first(|k| k.blend && !k.transmits).map(|n| n.why.clone()),
            transmits: first(|k| k.transmits).map(|n| n.why.clone()),
            anisotropy: scene.textures.iter().map(|t| t.sampler.max_anisotropy).max().unwrap_or(1),
            refracts: refracts(scene),
            blended_triangles: scene.triangles_of(|instance| scene.is_blended(instance)),
            background: match scene.background {
                Background::Color(color) => Some(color.to_array()),
                Background::Black | Background::Environment => None,
            },
            fog: scene.fog.filter(|fog| fog.density_per_m > 0.0 && !kinds.is_empty()),
            painted_around,
            occlusion: occlusion.filter(|_| painted_around.any()),
            decals: if lit_opaque.is_some() { decals::of(scene) } else { Vec::new() },
            particles: particles::of(scene),
            posed: PosedNeed::of(scene),
            lit,
            lit_opaque,
            kinds,
        }
    }

    /// The first of what is blended over light, or added to it, once surfaces are lit: there is a light target for it.
    pub fn over_light(&self) -> Option<&String> {
        self.transmits.as_ref().or(self.blended.as_ref()).or(self.particles.first().map(|need| &need.why))
    }

    /// Triangles that hide what is behind them.
    pub fn opaque_triangles(&self) -> usize {
        self.triangles - self.blended_triangles
    }
}

/// An element of a scene as messages name it: by its number if it has no name.
pub(crate) fn element(kind: &str, name: &str, index: usize) -> String {
    if name.is_empty() { format!("{kind} {index}") } else { format!("{kind} '{name}'") }
}

/// The first material drawn that bends light.
fn refracts(scene: &Scene) -> Option<String> {
    let materials = scene.drawn_instances().map(|instance| scene.meshes[instance.mesh].material);
    let bends = |&index: &usize| scene.materials[index].transmits().is_some_and(Transmission::bends);
    let first = materials.filter(bends).min()?;
    Some(element("material", &scene.materials[first].name, first))
}

fn lights_at_a_point(scene: &Scene) -> f32 {
    let listed =
        scene.lights.iter().filter(|l| !l.is_dark() && !matches!(l.kind, LightKind::Hemisphere { .. }));
    let ground = scene.bounds_world();
    ground.map_or(0.0, |ground| listed.fold(0.0, |sum, light| sum + Reach::of(light).share_of(&ground)))
}

/// Whether the light has a place.
fn is_local(light: &Light) -> bool {
    !matches!(light.kind, LightKind::Directional { .. } | LightKind::Hemisphere { .. })
}

fn is_isotropic(anisotropy: &u8) -> bool {
    *anisotropy <= 1
}

/// See [`Needs::most_local_lights`].
fn most_local_lights(scene: &Scene) -> usize {
    let kind = |light: &Light| std::mem::discriminant(&light.kind);
    let lit: Vec<_> = scene.lights.iter().filter(|l| !l.is_dark()).map(kind).collect();
    scene.lights.iter().filter(|l| is_local(l) && lit.contains(&kind(l))).count()
}
