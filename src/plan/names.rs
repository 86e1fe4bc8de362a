//! Choices about a frame that have names.

use serde::{Deserialize, Serialize};

/// An enum whose variants have one spelling each, shared by the command line, reports and messages.
macro_rules! named_enum {
    ($(#[$meta:meta])* $name:ident { $($(#[$vmeta:meta])* $variant:ident = $text:literal),+ $(,)? }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        pub enum $name {
            $($(#[$vmeta])* #[serde(rename = $text)] $variant),+
        }

        impl $name {
            /// Every variant, in order of declaration.
            pub const ALL: &'static [Self] = &[$(Self::$variant),+];

            /// The spelling used on the command line and in reports.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $text),+ }
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(self.name())
            }
        }

        impl std::str::FromStr for $name {
            type Err = String;

            fn from_str(s: &str) -> Result<Self, String> {
                Self::ALL.iter().copied().find(|v| v.name() == s).ok_or_else(|| {
                    let known: Vec<_> = Self::ALL.iter().map(|v| v.name()).collect();
                    format!("'{s}' is not one of: {}", known.join(", "))
                })
            }
        }
    };
}

pub(crate) use named_enum;

named_enum! {
    /// How the stages become render passes.
    Strategy {
        /// One render pass; stages are subpasses joined by input attachments.
        Subpasses = "subpasses",
        /// One render pass a stage; attachments are stored and loaded again.
        Separate = "separate",
        /// One dynamic rendering, in which stages read what the ones before have left in each pixel
        /// (VK_KHR_dynamic_rendering_local_read).
        LocalRead = "local-read",
        /// What keeps the frame on the chip with the driver at hand ([`Merging`](super::Merging)).
        Auto = "auto",
    }
}

impl Strategy {
    /// What every Vulkan 1.1 device runs.
    pub const EVERYWHERE: [Self; 2] = [Self::Subpasses, Self::Separate];

    /// Whether the stages of a pass follow each other pixel by pixel, so that nothing between them has to leave the chip.
    pub fn is_merged(self) -> bool {
        self != Self::Separate
    }
}

named_enum! {
    /// A G-buffer layout. Bits are of colour attachments, the light target included.
    Layout {
        /// Smith and Einig 2015, listing 2.2.
        Metallic128 = "metallic128",
        /// Listing 2.1: a colour each for diffuse and specular reflection.
        Specular160 = "specular160",
        /// Listing 2.7: position stored, half floats, light in the same words.
        Metallic256 = "metallic256",
        /// Listing 2.8: likewise for the specular workflow.
        Specular256 = "specular256",
        /// Thibieroz 2004: position, normal and colour; 128 bits and light.
        Thibieroz128 = "thibieroz128",
        /// The same in 96 bits, which have no room for roughness and metallicness.
        Thibieroz96 = "thibieroz96",
        /// Koonce 2007: view-space normals in two channels; 128 bits, and diffuse and specular light apart.
        Rasa128 = "rasa128",
        /// The dissertation's three half-float targets, and light.
        Dissertation192 = "dissertation192",
        /// Octahedral normals and half-float light; depth from the depth attachment.
        Ontile128 = "ontile128",
        /// The same with 32 bits of light.
        Ontile96 = "ontile96",
        /// The same without a light target: for scenes in which all light comes from light sources.
        Ontile64 = "ontile64",
        /// The same surface bits, laid out by search; light is read, not blended: two subpasses.
        Packed128 = "packed128",
        /// Every channel a 32-bit float: separates quantisation error from shader error.
        Exact = "exact",
    }
}

named_enum! {
    /// How a normal is stored, in layouts that leave the choice; roughness is beside it.
    Normals {
        /// World-space x, y and z in 8 bits each: 0.17 degrees off on average, 0.39 at most.
        Xyz8 = "xyz8",
        /// Octahedral, 8 + 8 bits.
        Oct8 = "oct8",
        /// Octahedral, 10 + 10 bits, and roughness in 10.
        Oct10 = "oct10",
        /// Octahedral, 12 + 12 bits.
        Oct12 = "oct12",
        /// Octahedral, 16 + 16 bits, in a target of 64.
        Oct16 = "oct16",
        /// Lambert's equal-area map of view space, 12 + 12 bits.
        Sphere12 = "sphere12",
        /// View-space x and y, 12 + 12 bits; z is taken to be positive.
        View12 = "view12",
        /// Floats.
        Float = "float",
    }
}

named_enum! {
    /// How a colour is stored, in layouts that leave the choice.
    Gamma {
        /// sRGB by the attachment's format, 8 bits.
        Srgb = "srgb",
        /// Power 2.2 in the shader, 8 bits.
        Power22 = "2.2",
        /// Power 2 in the shader, 8 bits (Smith and Einig 2015, listing 2.4).
        Power20 = "2.0",
        /// None, 8 bits: dark colours show steps.
        Linear = "linear",
        /// Floats.
        Float = "float",
    }
}

named_enum! {
    /// What light is summed in before the tone curve.
    LightFormat {
        /// 10 bits a channel, up to twice what the exposure makes white.
        Rgb10a2 = "rgb10a2",
        /// Unsigned floats of 11, 11 and 10 bits.
        B10g11r11 = "b10g11r11",
        /// Half floats.
        Rgba16f = "rgba16f",
        /// Floats.
        Rgba32f = "rgba32f",
    }
}

named_enum! {
    /// Where stages after geometry read depth.
    DepthStore {
        /// From a colour target of floats: for devices that cannot read a depth attachment on the tile.
        R32f = "r32f",
        /// From the depth attachment, 32-bit floats.
        D32 = "d32",
        /// From the depth attachment, 24 bits of fixed point.
        D24 = "d24",
        /// From the depth attachment, 16 bits of fixed point.
        D16 = "d16",
    }
}

named_enum! {
    /// How reflection is evaluated.
    #[derive(Default)]
    Brdf {
        /// glTF 2.0, appendix B; of light from all around, by a table.
        #[default]
        Exact = "exact",
        /// Without square roots in the visibility term (Hammon 2017), and without the table (Karis, "Physically Based Shading
        /// on Mobile", 2014). [`reference::brdf`](crate::reference::brdf) and [`environment::split_sum`](crate::environment::split_sum)
        /// have what either is off by.
        Fitted = "fitted",
        /// The exact formulas in half floats, as phones run `mediump`: emulated by rounding, so that the error is theirs
        /// and the speed is not. Roughness is at least 0.089.
        Mediump = "mediump",
    }
}

named_enum! {
    /// When surfaces are lit.
    Path {
        /// After all surfaces are known: each pixel once, from the G-buffer.
        Deferred = "deferred",
        /// As each surface is drawn, all lights at once.
        Forward = "forward",
        /// The surface without lights, then again for each light that reaches it, added up. Surfaces that coincide (the same
        /// depth, to the bit) are all lit, and their light is added up: such scenes come out too bright.
        ForwardMultipass = "forward-multipass",
        /// Forward where few lights reach a point ([`Needs::lights_at_a_point`](super::Needs::lights_at_a_point)), else
        /// deferred. How many are few depends on whether a G-buffer stays on the chip
        /// ([`Limits::gbuffer_on_chip`](super::Limits::gbuffer_on_chip)); `tools/bench compare` measures it.
        Auto = "auto",
    }
}

named_enum! {
    /// How lights reach pixels.
    LightWay {
        /// Every pixel looks at every light.
        Fullscreen = "fullscreen",
        /// A mesh around each light is drawn, and covers the pixels that it may light.
        Volumes = "volumes",
        /// Volumes that first mark in the stencil which surfaces are inside.
        Stencil = "stencil",
        /// Each pixel looks at the lights of its cluster of the view volume.
        Clusters = "clusters",
        /// Lists where lights have a place and an end, else all.
        Auto = "auto",
    }
}

named_enum! {
    /// From scene-referred to display-referred light.
    Tonemap {
        /// Khronos PBR Neutral.
        Neutral = "neutral",
        /// Stephen Hill's fit of the ACES reference and output transforms.
        Aces = "aces",
        /// Reinhard et al. 2002, equation 3, per channel.
        Reinhard = "reinhard",
        /// No curve.
        Linear = "linear",
    }
}

named_enum! {
    /// The format of the final image.
    OutputFormat {
        /// 8 bits a channel, sRGB-encoded by the attachment.
        Rgba8Srgb = "rgba8_srgb",
        /// The same with red and blue swapped, as many swapchains want it.
        Bgra8Srgb = "bgra8_srgb",
        /// Half floats, linear.
        Rgba16Float = "rgba16_float",
        /// Floats, linear, unclamped.
        Rgba32Float = "rgba32_float",
    }
}

impl OutputFormat {
    /// Whether channels are floats, neither clamped nor rounded to 8 bits.
    pub const fn is_float(self) -> bool {
        matches!(self, Self::Rgba16Float | Self::Rgba32Float)
    }
}

named_enum! {
    /// What happens to the final image after the frame; decides its final layout.
    OutputUse {
        /// Copied by a transfer command.
        Copy = "copy",
        /// Presented by a swapchain.
        Present = "present",
        /// Sampled by a later shader.
        Sample = "sample",
        /// Drawn to by a later render pass.
        Draw = "draw",
    }
}

named_enum! {
    /// Which pixels of several samples are lit sample by sample; the others are lit once.
    #[derive(Default)]
    Edges {
        /// All.
        All = "all",
        /// Those whose samples differ in anything that lighting reads.
        Compare = "compare",
        /// Those of which a triangle covers only some samples, and those that an alpha mask has cut. An attachment of 8 bits a sample
        /// says so. Where two surfaces pass through each other each covers all samples: these pixels are missed.
        Coverage = "coverage",
        /// [`Self::Compare`], where the stencil can hold what is found.
        #[default]
        Auto = "auto",
    }
}

named_enum! {
    /// How the samples of a pixel become one.
    #[derive(Default)]
    ResolveWay {
        /// The tone curve, then the mean: edges are as smooth where one side is brighter than white.
        #[default]
        Tonemapped = "tonemapped",
        /// The mean of light, then the tone curve.
        Plain = "plain",
    }
}

named_enum! {
    /// How many texels of the shadow map a pixel compares with.
    ShadowFilter {
        /// The four around a place, interpolated: one sample, whatever the light's spread.
        Hardware = "hardware",
        /// 3 x 3 samples over a square of the light's spread.
        Grid3 = "grid3",
        /// 5 x 5 samples.
        Grid5 = "grid5",
        /// 12 samples over a disc, turned by another angle in each pixel: noise in place of steps.
        Jittered = "jittered",
    }
}

named_enum! {
    /// How a depth of the shadow map is stored.
    ShadowFormat {
        /// [`Self::D16`] where all light is parallel (directional and box lights), [`Self::D32`] where a lamp is among it.
        Auto = "auto",
        /// 32-bit float.
        D32 = "d32",
        /// 16-bit fixed point: half the memory and traffic. Parallel light has no more wrong pixels with it. What is far from
        /// a lamp has: steps of depth are 2.4 cm at 4 m from it, and grow with the square of the distance. The test
        /// `half_the_bytes_do_where_light_is_parallel` in tests/shadows/rays.rs measures both.
        D16 = "d16",
    }
}

named_enum! {
    /// How decals that overlap are painted one after the other.
    DecalWay {
        /// Each fragment reads what those before it have left, in the order of rasterisation: wants
        /// [`Limits::ordered_attachment_access`](super::Limits::ordered_attachment_access).
        RasterOrder = "raster-order",
        /// The same, with a barrier between decals that overlap on the image: on every device.
        Barrier = "barrier",
        /// Fixed-function blending: base colour alone, in layouts that store it so that it can be blended.
        Fixed = "fixed",
        /// Fixed where that can paint all decals, else in raster order where the device can, else barriers.
        Auto = "auto",
    }
}

named_enum! {
    /// Light that is scattered around bright places, of which neither way breaks the frame's pass.
    BloomWay {
        /// None.
        Off = "off",
        /// From the final image of the frame before: nothing more is stored, and what the tone curve or the display cut off is lost.
        Previous = "previous",
        /// From the light of the frame before, which is stored beside the final image: 4 bytes a pixel more.
        Store = "store",
    }
}

named_enum! {
    /// How surfaces that are blended come over each other.
    #[derive(Default)]
    Translucency {
        /// Objects from far to near.
        #[default]
        Sorted = "sorted",
        /// Each pixel keeps its nearest layers apart until all are drawn, whatever their order: multi-layer alpha blending (Salvi
        /// and Vaidyanathan 2014) in words on the tile, by fragments that read what the one before has left
        /// ([`Limits::ordered_attachment_access`](super::Limits)). Of more layers than fit the two farthest are merged.
        Oit = "oit",
        /// A mean of all layers, each weighted by its depth (McGuire and Bavoil 2013): blending does it, in any order, and none is
        /// in front of another.
        Weighted = "weighted",
        /// Every layer of every pixel in its order, one after the other from the farthest (Everitt 2001, "Interactive
        /// Order-Independent Transparency"): all that is blended is drawn twice for each. Slow and exact.
        Peeled = "peeled",
    }
}

named_enum! {
    /// Whether what is behind water and glass (KHR_materials_transmission with KHR_materials_volume and KHR_materials_ior) is seen where
    /// its light comes from, or straight ahead.
    #[derive(Default)]
    Refraction {
        /// Straight ahead: of the same pixel, which is on the tile.
        #[default]
        None = "none",
        /// Bent, as far as the picture shows it: that takes neighbours, so the light of all that is opaque is stored with its depth,
        /// and a second pass begins with a copy of it.
        Pass = "pass",
    }
}
