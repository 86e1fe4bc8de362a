//! The elements of a scene that pipelines exist for.

use crate::plan::{
    CasterKind, KindNeed, Pipeline, Plan, PostPass, SceneKinds, SurfaceKind, VolumeShape, element,
};
use crate::scene::{Light, LightKind, Scene};
use crate::visible::Reach;

/// A scene and what was planned for it.
pub(super) struct Elements<'a> {
    pub(super) scene: &'a Scene,
    pub(super) plan: &'a Plan,
}

impl<'a> Elements<'a> {
    pub(super) fn new(scene: &'a Scene, plan: &'a Plan) -> Self {
        Self { scene, plan }
    }

    /// The pass after the frame's own that the n-th pipeline is of.
    fn of_post(&self, index: usize) -> Option<&PostPass> {
        let casters = self.plan.shadow_map.iter().map(|map| map.casters.len()).sum::<usize>();
        let before = self.plan.pipelines.len() + casters;
        index.checked_sub(before).and_then(|n| self.plan.post.kinds().nth(n))
    }

    /// The element that the n-th pipeline exists for, casters' after the plan's, those of passes after the frame's own last, and
    /// what else it takes for it to exist.
    pub(super) fn of_pipeline(&self, index: usize) -> (String, Option<String>) {
        let plan = self.plan;
        if let Some(pass) = self.of_post(index) {
            return (pass.why.into(), None);
        }
        match plan.pipelines.get(index) {
            Some((_, Pipeline::Depth(_))) => {
                let why = "the option depth_prepass draws depth first";
                (self.element(index), Some(why.into()))
            }
            Some((_, Pipeline::Light(_))) => {
                (self.element(index), Some(format!("lit by {}", self.light(|_| true))))
            }
            Some(_) => (self.element(index), None),
            None => (self.element(index), Some(self.shadow_lights())),
        }
    }

    fn element(&self, index: usize) -> String {
        let plan = self.plan;
        let Some((stage, pipeline)) = plan.pipelines.get(index) else {
            let casters = plan.shadow_map.iter().flat_map(|map| &map.casters);
            return casters
                .skip(index - plan.pipelines.len())
                .map(|kind| self.caster(kind))
                .next()
                .unwrap_or_default();
        };
        match &pipeline.per_pixel() {
            Pipeline::Surface(kind) | Pipeline::Absorb(kind) => self.need(|need| need.kind == *kind),
            Pipeline::Depth(kind) => self.need(|need| need.kind.depth() == *kind),
            Pipeline::Light(kind) => self.need(|need| need.kind == *kind),
            Pipeline::Sky => format!("the background is environment '{}'", self.environment()),
            Pipeline::LightMask(shape) => {
                format!("{}, where its volume holds a surface", self.of_shape(*shape))
            }
            Pipeline::LightVolume(shape) => self.of_shape(*shape),
            Pipeline::Lighting if plan.light_way.is_one_by_one() => {
                self.light(|light| !is_local(light)) + " shines everywhere"
            }
            Pipeline::Lighting => {
                let lit = plan.needs.lit_opaque.as_deref().unwrap_or_default();
                format!("{lit} is lit by {}", self.light(|_| true))
            }
            Pipeline::ShadowNearEnds | Pipeline::ShadowVolume => {
                format!("{} shadow volumes", self.volume_lights())
            }
            Pipeline::ShadowedLight => format!("{} a shadow volume", self.volume_lights()),
            Pipeline::Decal(kind) => {
                let need = plan.needs.decals.iter().find(|need| need.kind == *kind);
                need.map_or_else(String::new, |need| need.why.clone())
            }
            Pipeline::Peel { kind, .. } => self.need(|need| need.kind.blend && need.kind.depth() == *kind),
            Pipeline::Particles(kind) => {
                let need = plan.needs.particles.iter().find(|need| need.kind == *kind);
                need.map_or_else(String::new, |need| need.why.clone())
            }
            Pipeline::Composite | Pipeline::Backdrop => plan.subpass(*stage).2.why.clone(),
            Pipeline::Overlay => "the options ask for an overlay".into(),
            Pipeline::Show | Pipeline::ShowEdges => plan.subpass(*stage).2.why.clone(),
            Pipeline::Edges => {
                format!("{} samples a pixel: those of edges are lit one by one", plan.options.samples)
            }
            Pipeline::EdgeLighting | Pipeline::EdgeVolume(_) => String::new(),
            Pipeline::Fog => {
                let over = plan.needs.over_light().map(String::as_str).unwrap_or_default();
                let lies = if plan.needs.blended.is_some() { "is blended over" } else { "add to" };
                format!("the scene has fog, and {over} {lies} what is in it")
            }
            Pipeline::Tonemap => plan.subpass(*stage).2.why.clone(),
        }
    }

    /// The first light of a kind that is not dark, by name.
    pub(super) fn light(&self, wanted: impl Fn(&Light) -> bool) -> String {
        let mut lights = self.scene.lights.iter().enumerate();
        let light = lights.find(|(_, light)| !light.is_dark() && wanted(light));
        light.map_or_else(|| "(no light)".into(), |(i, light)| element("light", &light.name, i))
    }

    /// The lights that have shadow volumes.
    pub(super) fn volume_lights(&self) -> String {
        let lights = &self.plan.volume_lights;
        let first = lights.first().map(|&i| element("light", &self.scene.lights[i].name, i));
        match lights.len() {
            0 | 1 => format!("{} has", first.unwrap_or_default()),
            n => format!("{} and {} more have", first.unwrap_or_default(), n - 1),
        }
    }

    /// The lights that have a part of the shadow map.
    pub(super) fn shadow_lights(&self) -> String {
        let lights = self.plan.shadow_map.iter().flat_map(|map| &map.lights);
        let lights: Vec<_> = lights.map(|light| element("light", &light.name, light.light)).collect();
        match &lights[..] {
            [] => "(no light)".into(),
            [only] => format!("{only} casts shadows"),
            [first, ..] => format!("{first} and {} more cast shadows", lights.len() - 1),
        }
    }

    pub(super) fn environment(&self) -> &str {
        self.plan.needs.environment.as_ref().map_or("", |environment| &environment.name)
    }

    /// What surfaces receive from all around comes of.
    pub(super) fn around(&self) -> String {
        let needs = &self.plan.needs;
        let environment = needs.environment.iter().map(|e| format!("environment '{}'", e.name));
        let probes = needs.probes.iter().map(|probe| format!("probe '{}'", probe.name));
        let all: Vec<_> = environment.chain(probes).collect();
        if all.is_empty() { "the scene's ambient light".into() } else { all.join(", ") }
    }

    /// The first material of what is drawn by a pipeline of surfaces.
    fn need(&self, wanted: impl Fn(&KindNeed) -> bool) -> String {
        self.plan.needs.kinds.iter().find(|n| wanted(n)).map_or_else(String::new, |need| need.why.clone())
    }

    fn caster(&self, wanted: &CasterKind) -> String {
        let kinds = SceneKinds::new(self.scene);
        let caster = self.scene.drawn_instances().find_map(|instance| {
            let index = self.scene.meshes[instance.mesh].material;
            let material = &self.scene.materials[index];
            let kind = CasterKind::new(&SurfaceKind::new(&kinds, instance), material)?;
            (kind == *wanted).then(|| element("material", &material.name, index))
        });
        caster.unwrap_or_default()
    }

    fn of_shape(&self, shape: VolumeShape) -> String {
        let has_shape = |light: &Light| is_local(light) && VolumeShape::of(&Reach::of(light)) == shape;
        match self.scene.lights.iter().any(|light| !light.is_dark() && has_shape(light)) {
            true => self.light(has_shape),
            false => self.light(is_local) + ", when the far plane cuts its volume or a host changes it",
        }
    }
}

/// Whether the light has a place.
pub(super) fn is_local(light: &Light) -> bool {
    !matches!(light.kind, LightKind::Directional { .. } | LightKind::Hemisphere { .. })
}
