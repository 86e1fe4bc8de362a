//! Pictures and G-buffers from the device at hand, under the validation layer.

use ontile::environment::TexelFormat;
use ontile::glam::DVec3;
use ontile::gpu::{Headless, HeadlessOptions, Offscreen, PipelineCache, RendererConfig, View};
use ontile::measure::stored;
use ontile::picture::{Picture, Pixels};
use ontile::plan::{
    Brdf, DepthStore, Gamma, Layout, LightFormat, LightWay, Needs, Normals, Options, OutputFormat, Path,
    Plan, Refraction, Show, Tonemap, Translucency,
};
use ontile::reference::around::Method;
use ontile::reference::{Behind, Settings, Stored};
use ontile::scene::{Camera, Scene};

use crate::SIZE;
use crate::common::ignored_unless_required;

/// A device with validation.
pub struct Gpu {
    host: Headless,
    cache: PipelineCache,
}

/// A frame and what is needed to compute the same one.
pub struct Rendered {
    pub picture: Picture,
    /// The reference's settings for this frame, without a layout.
    pub settings: Settings,
}

/// What is asked of either side.
#[derive(Clone, Copy, Debug)]
pub struct Ask {
    pub layout: Layout,
    pub normals: Option<Normals>,
    pub gamma: Option<Gamma>,
    pub light_target: Option<LightFormat>,
    pub depth: Option<DepthStore>,
    pub brdf: Brdf,
    pub path: Path,
    pub tonemap: Tonemap,
    pub exposure_ev: f32,
    pub output: OutputFormat,
    pub lightmap: TexelFormat,
    pub translucency: Translucency,
    pub refraction: Refraction,
    pub lights: LightWay,
}

impl Ask {
    /// Linear light in floats: nothing but arithmetic between the scene and the picture.
    pub const EXACT: Self = Self {
        layout: Layout::Exact,
        normals: None,
        gamma: None,
        light_target: None,
        depth: None,
        brdf: Brdf::Exact,
        path: Path::Deferred,
        tonemap: Tonemap::Linear,
        exposure_ev: 0.0,
        output: OutputFormat::Rgba32Float,
        lightmap: TexelFormat::E5B9G9R9,
        translucency: Translucency::Sorted,
        refraction: Refraction::None,
        lights: LightWay::Auto,
    };

    pub fn options(&self) -> Options {
        Options {
            size: SIZE,
            layout: self.layout,
            normals: self.normals,
            gamma: self.gamma,
            light_target: self.light_target,
            depth: self.depth,
            brdf: self.brdf,
            path: self.path,
            tonemap: self.tonemap,
            output: self.output,
            lightmap_format: self.lightmap,
            translucency: self.translucency,
            refraction: self.refraction,
            lights: self.lights,
            ..Options::default()
        }
    }
}

impl Gpu {
    /// Says "ignored" and returns `None` where there is no device.
    pub fn open() -> Option<Self> {
        let options =
            HeadlessOptions { validate: true, application_name: "physics".into(), ..Default::default() };
        match Headless::new(&options) {
            Ok(host) => {
                let cache = PipelineCache::new(host.device(), &[]).expect("an empty cache can be made");
                Some(Self { host, cache })
            }
            Err(error) => {
                ignored_unless_required(&format!("no Vulkan device with validation: {error}"));
                None
            }
        }
    }

    /// Renders one frame.
    pub fn render(&self, scene: &Scene, camera: &Camera, ask: Ask) -> Rendered {
        let (offscreen, settings) = self.frame(scene, camera, ask, ask.options());
        Rendered { picture: offscreen.picture(), settings }
    }

    /// Renders one frame and keeps its G-buffer, as the lighting stage reads it. [`Stored::light`] is what geometry
    /// wrote: it is read from a frame of the same scene without its lights.
    pub fn render_with_gbuffer(&self, scene: &Scene, camera: &Camera, ask: Ask) -> (Rendered, Vec<Stored>) {
        self.try_with_gbuffer(scene, camera, ask).expect("the scene can be planned")
    }

    /// The same; `None` if the scene cannot be drawn with this layout.
    pub fn try_with_gbuffer(
        &self,
        scene: &Scene,
        camera: &Camera,
        ask: Ask,
    ) -> Option<(Rendered, Vec<Stored>)> {
        let options = Options { keep_gbuffer: true, ..ask.options() };
        let limits = self.host.device().limits();
        Plan::new(Needs::of(scene), options.clone(), &limits).ok()?;
        let (offscreen, settings) = self.frame(scene, camera, ask, options.clone());
        let dark = settings.light_target.then(|| {
            let dark = Scene { lights: Vec::new(), ..scene.clone() };
            let (offscreen, dark_settings) = self.frame(&dark, camera, ask, options);
            assert!(dark_settings.light_target, "what needs the light target is not the lights");
            offscreen
        });
        let stored = stored(&offscreen, dark.as_ref()).expect("the G-buffer is kept");
        Some((Rendered { picture: offscreen.picture(), settings }, stored))
    }

    /// Renders what `show` asks for in place of the picture; `None` if the layout does not hold it.
    pub fn shown(&self, scene: &Scene, camera: &Camera, ask: Ask, show: Show) -> Option<Vec<DVec3>> {
        let options = Options { show, ..ask.options() };
        Plan::new(Needs::of(scene), options.clone(), &self.host.device().limits()).ok()?;
        let (offscreen, settings) = self.frame(scene, camera, ask, options);
        Some(Rendered { picture: offscreen.picture(), settings }.light())
    }

    /// The same as bytes.
    pub fn shown_codes(&self, scene: &Scene, camera: &Camera, ask: Ask, show: Show) -> Vec<[u8; 3]> {
        let output = OutputFormat::Rgba8Srgb;
        let (offscreen, settings) = self.frame(scene, camera, ask, Options { show, output, ..ask.options() });
        Rendered { picture: offscreen.picture(), settings }.codes()
    }

    fn frame(&self, scene: &Scene, camera: &Camera, ask: Ask, options: Options) -> (Offscreen, Settings) {
        let device = self.host.device();
        let plan = Plan::new(Needs::of(scene), options, &device.limits()).expect("the scene can be planned");
        let light_target = plan.has_light_target();
        let settings = Settings {
            size: SIZE,
            exposure_ev: f64::from(ask.exposure_ev),
            tonemap: ask.tonemap,
            gbuffer: None,
            light_target,
            light_scale: f64::from(plan.light_scale()),
            around: Method::Prefiltered(plan.options.environment_format),
            brdf: ask.brdf,
            lightmap: Some(plan.options.lightmap_format),
            behind: Behind::of(&plan),
            ..Settings::default()
        };
        let mut offscreen = Offscreen::new(device, scene, plan, RendererConfig::default(), &self.cache)
            .expect("a renderer can be made");
        offscreen.render(&View { camera, exposure_ev: ask.exposure_ev }).expect("a frame can be rendered");
        (offscreen, settings)
    }

    /// Closes the device.
    ///
    /// # Panics
    /// If the validation layer said anything.
    pub fn finish(self) {
        let Self { host, cache } = self;
        drop(cache);
        assert_eq!(host.finish(), Vec::<String>::new());
    }
}

impl Rendered {
    /// Red, green and blue of each pixel of a float picture.
    pub fn light(&self) -> Vec<DVec3> {
        let Pixels::Rgba32F(values) = &self.picture.pixels else { panic!("a float picture was asked for") };
        values
            .chunks_exact(4)
            .map(|p| DVec3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2])))
            .collect()
    }

    /// Red, green and blue codes of each pixel of an 8-bit picture.
    pub fn codes(&self) -> Vec<[u8; 3]> {
        let Pixels::Rgba8(values) = &self.picture.pixels else { panic!("an 8-bit picture was asked for") };
        values.chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect()
    }
}
