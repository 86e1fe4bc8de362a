//! Flags that several commands share, and the types of their values.

use std::fmt::Display;
use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use clap::builder::{PathBufValueParser, PossibleValuesParser, TypedValueParser};
use ontile::environment::TexelFormat;
use ontile::glam::Vec3;
use ontile::measure::ErrorMetric;
use ontile::picture::FileFormat;
use ontile::plan::{
    BloomWay, Brdf, DecalWay, DepthStore, Edges, Gamma, Layout, LightFormat, LightWay, Normals, Options,
    OutputFormat, Path, Refraction, ResolveWay, ShadowFilter, ShadowFormat, ShadowOptions, Show, Strategy,
    Tonemap, Translucency,
};
use ontile::scene::{Background, FogHeight, Scene};

use super::wanted_layout::WantedLayout;

/// What is looked at.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Scene")]
pub struct SceneArgs {
    /// The scene: a glTF 2.0 file, .gltf or .glb
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
    /// The camera, by its number in the file (from 0) or its name [default: 0; a scene without cameras gets one
    /// that frames it]
    #[arg(long, value_name = "N|NAME", allow_negative_numbers = true)]
    pub camera: Option<String>,
    /// What the file's animations move is where they have it at this time, seconds from their begin; what comes after the last key is as
    /// there [default: as the file is without animations, and nothing exists for them]
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub time: Option<f64>,
    /// The animation that --time is of, by its number in the file (from 0) or its name; all: all of them at once
    #[arg(
        long,
        value_name = "N|NAME|all",
        default_value = "0",
        requires = "time",
        allow_negative_numbers = true
    )]
    pub animation: String,
    /// Light from every direction alike, in cd/m² [default: the scene's own]
    #[arg(long, value_name = "RADIANCE", value_parser = radiance, allow_negative_numbers = true)]
    pub ambient: Option<f32>,
    /// What is seen where there is no surface: the environment, or a colour in sRGB, which neither exposure nor tone curve
    /// change [default: the scene's own, else black]
    #[arg(long, value_name = "environment|#RRGGBB", value_parser = background)]
    pub background: Option<Background>,
    /// Fog: the share of light that is lost per metre; 0 is none [default: the scene's own]
    #[arg(long, value_name = "DENSITY", value_parser = fog_density, allow_negative_numbers = true)]
    pub fog: Option<f32>,
    /// The fog's radiance in cd/m² [default: the scene's own, else 0.5,0.6,0.7]
    #[arg(long, value_name = "R,G,B", value_parser = fog_color, allow_hyphen_values = true)]
    pub fog_color: Option<Vec3>,
    /// World height in metres at which --fog is meant, and metres upwards over which fog gets thinner by a factor e [default: the
    /// scene's own, else fog is alike at all heights]
    #[arg(long, value_name = "BASE,SCALE", value_parser = fog_height, allow_hyphen_values = true)]
    pub fog_height: Option<FogHeight>,
    #[command(flatten)]
    pub far: FarArgs,
    /// Lights at most; the least important are left out: first by the priority that the scene gives them, then by the
    /// light that they bring [default: all]
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    pub max_lights: Option<usize>,
    /// Lights with shadows at most; the least important cast none
    #[arg(long, value_name = "N", default_value_t = Scene::DEFAULT_SHADOWS, value_parser = count, allow_negative_numbers = true)]
    pub max_shadows: usize,
    /// No light casts a shadow
    #[arg(long, conflicts_with = "max_shadows")]
    pub no_shadows: bool,
}

/// Light from far away.
#[derive(Args, Clone, Debug)]
pub struct FarArgs {
    /// Light from far away: an equirectangular .hdr or .exr picture of radiance in cd/m², at most 8192 columns wide, or what 'ontile bake environment' made
    /// of one [default: the scene's own, else none]
    #[arg(long, value_name = "FILE")]
    pub environment: Option<PathBuf>,
    /// How far the environment is turned about +Y: at 0 the picture's centre lies towards +Z and its right half towards -X
    /// [default: the scene's own, else 0]
    #[arg(long, value_name = "DEGREES", value_parser = degrees, allow_negative_numbers = true)]
    pub environment_rotation: Option<f32>,
    /// Multiplies the environment's radiance [default: the scene's own, else 1]
    #[arg(long, value_name = "FACTOR", value_parser = intensity, allow_negative_numbers = true)]
    pub environment_intensity: Option<f32>,
}

/// How the frame is built.
#[derive(Args, Debug)]
#[command(next_help_heading = "Frame")]
pub struct PlanArgs {
    /// Width and height of the picture, in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    pub size: Size,
    /// How stages become render passes: subpasses of one pass that stays on the tile; separate passes that store and load every
    /// attachment; or, with the same picture as subpasses, stages of one dynamic rendering with local reads, which some drivers
    /// keep on the tile instead; auto: what is known to stay there with the driver at hand
    #[arg(long, default_value_t = Strategy::Subpasses, value_parser = named(Strategy::ALL, Strategy::name))]
    pub strategy: Strategy,
    /// The G-buffer's layout; auto: what has the fewest bytes and keeps --max-error for this scene and device
    #[arg(long, value_name = "NAME", default_value_t = WantedLayout::Named(Layout::Metallic128), value_parser = WantedLayout::parser())]
    pub layout: WantedLayout,
    /// With --layout auto: how far the picture may be from the true one; at most this much of flip or ciede, at least so many
    /// dB of psnr [default: 0.02 of flip]
    #[arg(long, value_name = "E", value_parser = error_limit, requires = "layout", allow_negative_numbers = true)]
    pub max_error: Option<f64>,
    /// What --max-error is measured by: FLIP, the mean over the picture; PSNR, dB; or CIEDE2000 for 95 % of the pixels
    #[arg(long, value_name = "NAME", default_value_t = ErrorMetric::Flip, value_parser = named(ErrorMetric::ALL, ErrorMetric::name), requires = "max_error")]
    pub metric: ErrorMetric,
    /// How normals are stored, where the layout leaves the choice [default: the layout's way]
    #[arg(long, value_name = "NAME", value_parser = named(Normals::ALL, Normals::name))]
    pub normals: Option<Normals>,
    /// How colours are stored: encoded as sRGB, by a power of 2.2 or 2.0, or not at all [default: the layout's way]
    #[arg(long, value_name = "NAME", value_parser = named(Gamma::ALL, Gamma::name))]
    pub gamma: Option<Gamma>,
    /// What light is summed in before the tone curve [default: the layout's format]
    #[arg(long, value_name = "NAME", value_parser = named(LightFormat::ALL, LightFormat::name))]
    pub light_target: Option<LightFormat>,
    /// Where lighting reads depth: from a colour target of floats, or from a depth attachment of so many bits [default: the
    /// layout's way]
    #[arg(long, value_name = "NAME", value_parser = named(DepthStore::ALL, DepthStore::name))]
    pub depth: Option<DepthStore>,
    /// How reflection is evaluated: exact is glTF's own formulas; fitted has no square roots in the visibility term and no table
    /// for light from all around; mediump is exact in half floats, emulated to show their error, not their speed
    #[arg(long, default_value_t = Brdf::Exact, value_parser = named(Brdf::ALL, Brdf::name))]
    pub brdf: Brdf,
    /// When surfaces are lit: after all are known, or as each is drawn; forward-multipass adds up the light of surfaces that
    /// coincide
    #[arg(long, default_value_t = Path::Deferred, value_parser = named(Path::ALL, Path::name))]
    pub path: Path,
    /// Draw the depth of all surfaces first, so that no pixel is shaded twice; of surfaces that coincide the last drawn is seen,
    /// not the first [default: off]
    #[arg(long)]
    pub depth_prepass: bool,
    /// On the path forward-multipass, draw all objects for each light, not only those that it reaches [default: draw
    /// those]
    #[arg(long)]
    pub no_illumination_sets: bool,
    /// How an environment's radiance is stored, unless the file says so: rgbm, b10g11r11 and e5b9g9r9 take 4 bytes a texel,
    /// rgba16f 8 [default: e5b9g9r9]
    #[arg(long, value_name = "NAME", value_parser = named(TexelFormat::ALL, TexelFormat::name))]
    pub environment_format: Option<TexelFormat>,
    /// How a lightmap's light is stored, in the same bytes; rgbm is as files have it, and less accurate between texels
    /// [default: e5b9g9r9]
    #[arg(long, value_name = "NAME", value_parser = named(TexelFormat::ALL, TexelFormat::name))]
    pub lightmap_format: Option<TexelFormat>,
    /// How lights reach pixels
    #[arg(long, value_name = "WAY", default_value_t = LightWay::Auto, value_parser = named(LightWay::ALL, LightWay::name))]
    pub lights: LightWay,
    /// How blended materials come over each other: objects from far to near; layers sorted in each pixel; a mean by weight; or
    /// each pixel's layers one after the other, exact and slow
    #[arg(long, value_name = "WAY", default_value_t = Translucency::Sorted, value_parser = named(Translucency::ALL, Translucency::name))]
    pub translucency: Translucency,
    /// Layers of a pixel that oit keeps (1 to 4) or peeled draws (1 to 16) [default: 4, 8]
    #[arg(long, value_name = "N")]
    pub translucency_layers: Option<u32>,
    /// How many texels of the shadow map a pixel compares with: the nearest four; 3x3 or 5x5 samples over each light's
    /// spread; or a dozen on a disc that is turned by another angle in each pixel
    #[arg(long, value_name = "NAME", default_value_t = ShadowFilter::Grid3, value_parser = named(ShadowFilter::ALL, ShadowFilter::name))]
    pub shadow_filter: ShadowFilter,
    /// How the shadow map stores depth; auto: in 16 bits where all light is parallel, in 32 where lamps cast shadows
    #[arg(long, value_name = "NAME", default_value_t = ShadowFormat::Auto, value_parser = named(ShadowFormat::ALL, ShadowFormat::name))]
    pub shadow_format: ShadowFormat,
    /// Side of the shadow map at most, 128 to 16384 texels; lights that do not fit get less of it, the least important first
    #[arg(long, value_name = "TEXELS", default_value_t = 4096)]
    pub shadow_map: u32,
    /// Side of a light's part of it, from 128 texels; a point light has six of half the side [default: a texel a pixel]
    #[arg(long, value_name = "TEXELS")]
    pub shadow_tile: Option<u32>,
    /// Cascades of a directional light at most
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=4))]
    pub cascades: u32,
    /// The curve from scene light to display light; linear is none
    #[arg(long, default_value_t = Tonemap::Neutral, value_parser = named(Tonemap::ALL, Tonemap::name))]
    pub tonemap: Tonemap,
    /// Exposure in EV (stops): multiplies light by 2^EV before the tone curve
    #[arg(long, value_name = "EV", default_value_t = 0.0, value_parser = exposure, allow_negative_numbers = true)]
    pub exposure: f32,
    /// Add half a step of ordered noise before rounding to 8 bits [default: off]
    #[arg(long)]
    pub dither: bool,
    /// Samples a pixel, as the device allows: 1, 2, 4 or 8
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub samples: u32,
    /// Which pixels of several samples are lit sample by sample: all; those whose samples differ in what lighting reads; or those that
    /// triangles or alpha masks cover in part
    #[arg(long, value_name = "WAY", default_value_t = Edges::Auto, value_parser = named(Edges::ALL, Edges::name))]
    pub edges: Edges,
    /// How samples become one: the tone curve and then the mean, or the mean of light and then the tone curve
    #[arg(long, value_name = "WAY", default_value_t = ResolveWay::Tonemapped, value_parser = named(ResolveWay::ALL, ResolveWay::name))]
    pub resolve: ResolveWay,
    /// Give every attachment its own memory, even where lifetimes do not overlap [default: share]
    #[arg(long)]
    pub no_recycle: bool,
    /// Keep lighting and tonemap apart, even where nothing needs the light target [default: merge them]
    #[arg(long)]
    pub no_fold: bool,
    /// How decals that overlap are painted one after the other: by rasterization-order attachment access, with barriers in
    /// between, or by fixed-function blending, where the layout allows
    #[arg(long, value_name = "WAY", default_value_t = DecalWay::Auto, value_parser = named(DecalWay::ALL, DecalWay::name))]
    pub decals: DecalWay,
    /// Light that lens and eye scatter around bright places; the frame's pass stays whole: from the previous frame's picture, which
    /// the tone curve has cut, or from its light, which is stored beside the picture
    #[arg(long, value_name = "WAY", default_value_t = BloomWay::Off, value_parser = named(BloomWay::ALL, BloomWay::name))]
    pub bloom: BloomWay,
    /// The share of light that bloom scatters, 0 to 1
    #[arg(long, value_name = "SHARE", default_value_t = 0.05, allow_negative_numbers = true)]
    pub bloom_strength: f32,
    /// How far bloom reaches, as a share of the picture's shorter side, above 0 to 1
    #[arg(long, value_name = "SHARE", default_value_t = 0.1, allow_negative_numbers = true)]
    pub bloom_radius: f32,
    /// Smooth edges that neighbours' depth and normals show, which are stored for a pass after the frame's own [default: off]
    #[arg(long)]
    pub edge_filter: bool,
    /// Hard shadows, exact to the pixel, by counting the spaces behind what faces a light in the stencil, on the tile, in place of
    /// shadow maps: for directional, point and spot lights without alpha masks in their reach [default: off]
    #[arg(long)]
    pub shadow_volumes: bool,
    /// Whether water and glass bend what is behind them: none, or in a second pass, for which that is stored with its depth
    #[arg(long, value_name = "NAME", default_value_t = Refraction::None, value_parser = named(Refraction::ALL, Refraction::name))]
    pub refraction: Refraction,
    /// What is written in place of the picture, in the same pass: what the G-buffer holds, how many lights are evaluated, or which
    /// pixels are lit sample by sample
    #[arg(long, value_name = "WHAT", default_value_t = Show::Picture, value_parser = named(Show::ALL, Show::name))]
    pub show: Show,
}

impl PlanArgs {
    /// The library's options for a final image of this format.
    pub fn options(&self, output: OutputFormat) -> Options {
        let default = Options::default();
        Options {
            size: self.size.0,
            strategy: self.strategy,
            layout: self.layout.named().unwrap_or(default.layout),
            normals: self.normals,
            gamma: self.gamma,
            light_target: self.light_target,
            depth: self.depth,
            brdf: self.brdf,
            path: self.path,
            depth_prepass: self.depth_prepass,
            illumination_sets: !self.no_illumination_sets,
            lights: self.lights,
            translucency: self.translucency,
            translucency_layers: self.translucency_layers,
            shadows: ShadowOptions {
                filter: self.shadow_filter,
                format: self.shadow_format,
                most_texels: self.shadow_map,
                tile_texels: self.shadow_tile,
                cascades: self.cascades,
                ..ShadowOptions::default()
            },
            tonemap: self.tonemap,
            output,
            recycle: !self.no_recycle,
            fold: !self.no_fold,
            bloom: self.bloom,
            bloom_strength: self.bloom_strength,
            bloom_radius: self.bloom_radius,
            edge_filter: self.edge_filter,
            shadow_volumes: self.shadow_volumes,
            refraction: self.refraction,
            show: self.show,
            dither: self.dither,
            samples: self.samples,
            edges: self.edges,
            resolve: self.resolve,
            decals: self.decals,
            environment_format: self.environment_format.unwrap_or(default.environment_format),
            lightmap_format: self.lightmap_format.unwrap_or(default.lightmap_format),
            ..default
        }
    }
}

/// Width and height in pixels, typed as `1280x720`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size(pub [u32; 2]);

impl Size {
    /// No Vulkan implementation in use has larger images (maxImageDimension2D).
    const MAX_PX: u32 = 32768;
}

impl Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{}", self.0[0], self.0[1])
    }
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let digits = |part: &str| part.bytes().all(|b| b.is_ascii_digit()).then(|| part.parse().ok())?;
        let size = text.split_once('x').and_then(|(w, h)| Some([digits(w)?, digits(h)?]));
        match size {
            Some(size) if size.iter().all(|side| (1..=Self::MAX_PX).contains(side)) => Ok(Self(size)),
            Some(_) => Err(format!("width and height go from 1 to {}", Self::MAX_PX)),
            None => Err("give width and height in pixels, as in 1280x720".into()),
        }
    }
}

/// Where a rendered picture goes; its extension decides the final image's format.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Output {
    pub path: PathBuf,
    pub format: FileFormat,
}

impl Output {
    /// Parses any path, also one that is not Unicode.
    pub fn parser() -> impl TypedValueParser<Value = Self> {
        PathBufValueParser::new().try_map(|path| {
            let format = FileFormat::from_path(&path)?;
            Ok::<_, ontile::Error>(Self { path, format })
        })
    }

    /// The attachment format whose pixels the file can hold.
    pub fn image_format(&self) -> OutputFormat {
        match self.format {
            FileFormat::Png => OutputFormat::Rgba8Srgb,
            FileFormat::Exr => OutputFormat::Rgba32Float,
        }
    }
}

/// A parser for one of the library's named enums that lists the names in help and errors.
pub fn named<T>(all: &'static [T], name: fn(T) -> &'static str) -> impl TypedValueParser<Value = T>
where
    T: FromStr<Err = String> + Copy + Send + Sync + 'static,
{
    PossibleValuesParser::new(all.iter().map(|&value| name(value))).try_map(|typed| typed.parse::<T>())
}

fn count(text: &str) -> Result<usize, String> {
    text.parse().map_err(|_| "give a whole number, 0 or more".into())
}

fn error_limit(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(limit) if limit > 0.0 && limit.is_finite() => Ok(limit),
        _ => Err("give a number above 0, as in 0.02".into()),
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse::<f64>().map_err(|e| e.to_string())?;
    if seconds.is_finite() { Ok(seconds) } else { Err("it must be a finite number of seconds".into()) }
}

/// Stops.
pub fn exposure(text: &str) -> Result<f32, String> {
    const MAX_EV: f32 = 64.0;
    match text.parse::<f32>() {
        Ok(ev) if ev.abs() <= MAX_EV => Ok(ev),
        _ => Err(format!("give a number of stops from -{MAX_EV} to {MAX_EV}")),
    }
}

/// A radiance in cd/m².
pub fn radiance(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(nt) if nt >= 0.0 && nt.is_finite() => Ok(nt),
        _ => Err("give a radiance in cd/m², 0 or more".into()),
    }
}

fn background(text: &str) -> Result<Background, String> {
    if text == "environment" {
        return Ok(Background::Environment);
    }
    let message = "give 'environment', or a colour as six hexadecimal digits, as in #87ceeb";
    Background::from_hex(text).ok_or_else(|| message.into())
}

fn fog_density(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(density) if density >= 0.0 && density.is_finite() => Ok(density),
        _ => Err("give a share per metre, 0 or more".into()),
    }
}

fn fog_color(text: &str) -> Result<Vec3, String> {
    match numbers::<3>(text) {
        Some(color) if color.iter().all(|c| *c >= 0.0) => Ok(Vec3::from_array(color)),
        _ => Err("give three radiances in cd/m², 0 or more, as in 0.5,0.6,0.7".into()),
    }
}

fn fog_height(text: &str) -> Result<FogHeight, String> {
    match numbers::<2>(text) {
        Some([base_m, scale_m]) if scale_m > 0.0 => Ok(FogHeight { base_m, scale_m }),
        _ => Err("give two numbers of metres, the second above 0, as in 0,5".into()),
    }
}

/// Finite numbers with commas between.
fn numbers<const N: usize>(text: &str) -> Option<[f32; N]> {
    let parsed: Vec<f32> = text.split(',').map(|part| part.trim().parse().ok()).collect::<Option<_>>()?;
    parsed.try_into().ok().filter(|list: &[f32; N]| list.iter().all(|x| x.is_finite()))
}

fn degrees(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(degrees) if degrees.is_finite() => Ok(degrees),
        _ => Err("give an angle in degrees".into()),
    }
}

fn intensity(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(factor) if factor >= 0.0 && factor.is_finite() => Ok(factor),
        _ => Err("give a factor, 0 or more".into()),
    }
}
