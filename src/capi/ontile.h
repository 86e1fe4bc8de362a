/* ontile: deferred shading that never leaves the tile. Generated from src/capi by cbindgen.
 *
 * Objects are used by one thread at a time; several renderers on one device may be used by several threads. Functions that return an
 * OntileResult leave their results untouched when they fail, and ontile_last_error says why. src/embedding.md has the whole of it.
 */

#ifndef ONTILE_H
#define ONTILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <vulkan/vulkan.h>

/// Rises with every change that programs compiled against an older header would notice.
#define ONTILE_ABI_VERSION 1

/// VK_EXT_debug_utils is enabled on the instance: objects get names.
#define ONTILE_FEATURE_DEBUG_UTILS (1 << 0)

/// pipelineStatisticsQuery.
#define ONTILE_FEATURE_PIPELINE_STATISTICS (1 << 1)

/// imageCubeArray: worlds with probes want it.
#define ONTILE_FEATURE_IMAGE_CUBE_ARRAY (1 << 2)

/// occlusionQueryPrecise.
#define ONTILE_FEATURE_OCCLUSION_PRECISE (1 << 3)

/// rasterizationOrderColorAttachmentAccess of VK_EXT_rasterization_order_attachment_access: some layouts, decals and ways of
/// translucency want it.
#define ONTILE_FEATURE_ORDERED_ATTACHMENT_ACCESS (1 << 4)

/// dynamicRenderingLocalRead, dynamicRendering and independentBlend: the strategy local-read wants them.
#define ONTILE_FEATURE_LOCAL_READ (1 << 5)

/// subpassMergeFeedback of VK_EXT_subpass_merge_feedback.
#define ONTILE_FEATURE_SUBPASS_MERGE_FEEDBACK (1 << 6)

/// sampleRateShading: several samples a pixel want it.
#define ONTILE_FEATURE_SAMPLE_RATE_SHADING (1 << 7)

/// depthClamp and shaderClipDistance: shadow volumes want both.
#define ONTILE_FEATURE_DEPTH_CLAMP (1 << 8)

/// `samplerAnisotropy`: samplers that ask for it do without otherwise.
#define ONTILE_FEATURE_SAMPLER_ANISOTROPY (1 << 9)

/// `textureCompressionBC`. Compressed pictures of a kind that is not enabled are decoded when they are uploaded.
#define ONTILE_FEATURE_TEXTURE_COMPRESSION_BC (1 << 10)

/// `textureCompressionETC2`.
#define ONTILE_FEATURE_TEXTURE_COMPRESSION_ETC2 (1 << 11)

/// `textureCompressionASTC_LDR`.
#define ONTILE_FEATURE_TEXTURE_COMPRESSION_ASTC (1 << 12)

/// What came of a call.
typedef enum OntileResult {
  /// It was done.
  ONTILE_RESULT_OK = 0,
  /// An argument is null, or no text, or not of the values that its type names.
  ONTILE_RESULT_ERROR_ARGUMENT = 1,
  /// A file's content cannot be used.
  ONTILE_RESULT_ERROR_INPUT = 2,
  /// A file cannot be read or written.
  ONTILE_RESULT_ERROR_IO = 3,
  /// The plan, the device or the world cannot do what was asked for; the message says what would do.
  ONTILE_RESULT_ERROR_UNSUPPORTED = 4,
  /// A Vulkan call failed: ontile_last_vulkan_result says how.
  ONTILE_RESULT_ERROR_VULKAN = 5,
  /// A defect of ontile. The objects that the call was given must only be destroyed.
  ONTILE_RESULT_ERROR_INTERNAL = 6,
} OntileResult;

/// What alpha does.
typedef enum OntileAlphaMode {
  /// Nothing.
  ONTILE_ALPHA_MODE_OPAQUE = 0,
  /// What is below the cutoff is not there.
  ONTILE_ALPHA_MODE_MASK = 1,
  /// It is laid over what is behind.
  ONTILE_ALPHA_MODE_BLEND = 2,
} OntileAlphaMode;

/// The kinds of elements.
typedef enum OntileKind {
  /// OntileMesh.
  ONTILE_KIND_MESH = 0,
  /// OntileMaterial.
  ONTILE_KIND_MATERIAL = 1,
  /// OntileTexture.
  ONTILE_KIND_TEXTURE = 2,
  /// OntileImage.
  ONTILE_KIND_IMAGE = 3,
  /// OntileInstance.
  ONTILE_KIND_INSTANCE = 4,
  /// OntileLight.
  ONTILE_KIND_LIGHT = 5,
  /// OntileDecal.
  ONTILE_KIND_DECAL = 6,
  /// A camera of a file: ontile_world_camera reads it.
  ONTILE_KIND_CAMERA = 7,
  /// OntileParticles.
  ONTILE_KIND_PARTICLES = 8,
} OntileKind;

/// What a light is.
typedef enum OntileLightKind {
  /// Infinitely far; intensity in lux.
  ONTILE_LIGHT_KIND_DIRECTIONAL = 0,
  /// Alike in all directions; intensity in candela.
  ONTILE_LIGHT_KIND_POINT = 1,
  /// Within a cone; intensity in candela.
  ONTILE_LIGHT_KIND_SPOT = 2,
  /// Directional, within a box; intensity in lux.
  ONTILE_LIGHT_KIND_BOX = 3,
  /// From all around, above another than below; intensity in lux.
  ONTILE_LIGHT_KIND_HEMISPHERE = 4,
} OntileLightKind;

/// How mip levels are used.
typedef enum OntileMips {
  /// Level 0 alone.
  ONTILE_MIPS_NONE = 0,
  /// The nearest.
  ONTILE_MIPS_NEAREST = 1,
  /// Two are blended.
  ONTILE_MIPS_LINEAR = 2,
} OntileMips;

/// How view space becomes an image.
typedef enum OntileProjection {
  /// Pinhole.
  ONTILE_PROJECTION_PERSPECTIVE = 0,
  /// Parallel.
  ONTILE_PROJECTION_ORTHOGRAPHIC = 1,
} OntileProjection;

/// How a light casts shadows.
typedef enum OntileShadow {
  /// Not at all.
  ONTILE_SHADOW_NONE = 0,
  /// As the options say.
  ONTILE_SHADOW_DEFAULT = 1,
  /// By its part of the shadow map.
  ONTILE_SHADOW_MAP = 2,
  /// By counting volumes in the stencil, where that can be.
  ONTILE_SHADOW_VOLUME = 3,
} OntileShadow;

/// What lies beyond a picture's edges.
typedef enum OntileWrap {
  /// The picture again.
  ONTILE_WRAP_REPEAT = 0,
  /// The picture again, every other time mirrored.
  ONTILE_WRAP_MIRRORED_REPEAT = 1,
  /// Its edge.
  ONTILE_WRAP_CLAMP_TO_EDGE = 2,
} OntileWrap;

/// A host's device as ontile knows it.
typedef struct OntileDevice OntileDevice;

/// Choices about frames, by name.
typedef struct OntileOptions OntileOptions;

/// Compiled pipelines, kept for the next run.
typedef struct OntilePipelineCache OntilePipelineCache;

/// Draws one world by one plan.
typedef struct OntileRenderer OntileRenderer;

/// What a renderer draws to: the host's images of one size, and the attachments that exist only while a frame is drawn.
typedef struct OntileTarget OntileTarget;

/// What is to be drawn, and what was done to it since renderers looked.
typedef struct OntileWorld OntileWorld;

/// Bytes of device memory, as sums of contents: a device adds what it aligns and rounds to.
typedef struct OntileBudget {
  /// Of a renderer, whatever it draws to.
  uint64_t renderer_bytes;
  /// Of a target of the size asked for, without the host's images.
  uint64_t target_bytes;
  /// The same on a device with lazily allocated memory that stays on the tile.
  uint64_t lazy_target_bytes;
} OntileBudget;

/// What a host's image must be like, and what it is after a frame.
typedef struct OntileOutput {
  /// Its format.
  VkFormat format;
  /// Its usage, at least.
  VkImageUsageFlags usage;
  /// Its layout after a frame; before it, layout and content do not matter.
  VkImageLayout layout;
} OntileOutput;

/// What ontile_renderer_update did.
typedef struct OntileUpdated {
  /// Targets must be created anew; those of frames on the GPU are kept until these have finished.
  bool new_targets;
  /// Pipelines were made.
  bool new_pipelines;
  /// Buffers were made, and copies recorded.
  bool new_objects;
} OntileUpdated;

/// A host's image.
typedef struct OntileOutputImage {
  /// Of the target's size, one sample, one level.
  VkImage image;
  /// 2D, identity swizzle.
  VkImageView view;
} OntileOutputImage;

/// A view point.
typedef struct OntileCamera {
  /// Rigid, column by column: it looks along its -Z, +Y is up.
  float world_from_view[16];
  /// An OntileProjection.
  uint32_t projection;
  /// Perspective: vertical field of view, radians. Orthographic: half the height, metres.
  float vertical;
  /// Metres.
  float z_near;
  /// Metres; of a perspective 0 is infinite.
  float z_far;
} OntileCamera;

/// What a host lends. It was created for Vulkan 1.1 or later and stays the host's: it must live until all objects of ontile that were
/// made with it are destroyed, and is not destroyed by ontile.
typedef struct OntileHost {
  /// The loader's vkGetInstanceProcAddr.
  PFN_vkGetInstanceProcAddr get_instance_proc_addr;
  /// The instance.
  VkInstance instance;
  /// Of the instance.
  VkPhysicalDevice physical_device;
  /// Created from the physical device.
  VkDevice device;
  /// A family with graphics support, which command buffers come from.
  uint32_t queue_family_index;
  /// A queue of it. Nothing is submitted to it by the functions of this interface.
  VkQueue queue;
  /// Null, or what every call that makes or destroys an object gets.
  const VkAllocationCallbacks *allocation_callbacks;
  /// Sum of ONTILE_FEATURE_*: what is enabled on the device.
  uint32_t features;
} OntileHost;

/// A corner of a triangle that is drawn over the picture.
typedef struct OntileOverlayVertex {
  /// From the left upper corner of the picture, points.
  float position[2];
  /// Where in the overlay's image: 0 to 1.
  float texcoord[2];
  /// RGBA that the image's is multiplied by: encoded as sRGB and multiplied by alpha after that.
  uint8_t color[4];
} OntileOverlayVertex;

/// Triangles that one draw draws.
typedef struct OntileOverlayPart {
  /// What of the picture they may cover: left, top, right and bottom, pixels.
  uint32_t clip_px[4];
  /// Their first index.
  uint32_t first_index;
  /// Three a triangle.
  uint32_t index_count;
} OntileOverlayPart;

/// A box, and what glossy surfaces inside it reflect: the radiance that was captured at its centre.
typedef struct OntileProbe {
  /// For messages.
  const char *name;
  /// The box's centre, metres.
  float position[3];
  /// A quaternion (x, y, z, w) of unit length: turns the box's axes, which are also those of the picture, into the world's.
  float rotation[4];
  /// Half the box's size along its axes, metres, above 0.
  float half_size[3];
  /// How far inside each face the probe's weight reaches 1, metres, at least 0.
  float falloff;
  /// A picture of all directions (.hdr; twice as wide as high).
  const char *path;
} OntileProbe;

/// The name of an element of a world; 0 is none.
typedef uint64_t OntileId;

/// Indexed triangles in object space, metres, with one material. Lists that are null are left out.
typedef struct OntileMesh {
  /// For messages; may be null.
  const char *name;
  /// How many vertices there are.
  size_t vertex_count;
  /// x, y, z of each vertex.
  const float *positions;
  /// x, y, z of each vertex, of unit length; lit materials want them.
  const float *normals;
  /// x, y, z, and the bitangent's sign, of each vertex; normal textures want them.
  const float *tangents;
  /// u, v of each vertex: TEXCOORD_0.
  const float *texcoords_0;
  /// u, v of each vertex: TEXCOORD_1.
  const float *texcoords_1;
  /// r, g, b, a of each vertex, linear.
  const float *colors;
  /// Three a triangle.
  size_t index_count;
  /// Each below vertex_count.
  const uint32_t *indices;
  /// Of a material.
  OntileId material;
} OntileMesh;

/// A texture as a slot of a material uses it.
typedef struct OntileTextureRef {
  /// Of a texture; 0 leaves the slot empty, and the rest of this is ignored then.
  OntileId texture;
  /// 0 or 1: which of the mesh's texture coordinates.
  uint32_t texcoord;
  /// Two rows: uv = (row 0 . (u, v, 1), row 1 . (u, v, 1)). All zero counts as no transform.
  float uv_from_texcoord[2][3];
} OntileTextureRef;

/// A surface as glTF 2.0 section 3.9 describes it. ontile_material_default gives one that is white and rough.
typedef struct OntileMaterial {
  /// For messages; may be null.
  const char *name;
  /// Linear Rec.709 and alpha.
  float base_color_factor[4];
  /// sRGB-encoded, linear alpha.
  struct OntileTextureRef base_color_texture;
  /// 0 dielectric to 1 metal.
  float metallic_factor;
  /// Perceptual.
  float roughness_factor;
  /// Green roughness, blue metallicness.
  struct OntileTextureRef metallic_roughness_texture;
  /// In tangent space.
  struct OntileTextureRef normal_texture;
  /// Of x and y of the normal texture.
  float normal_scale;
  /// Red.
  struct OntileTextureRef occlusion_texture;
  /// 0 to 1.
  float occlusion_strength;
  /// Linear Rec.709, cd/m2.
  float emissive_factor[3];
  /// sRGB-encoded.
  struct OntileTextureRef emissive_texture;
  /// An OntileAlphaMode.
  uint32_t alpha_mode;
  /// Of ONTILE_ALPHA_MODE_MASK.
  float alpha_cutoff;
  /// Drawn from both sides.
  bool double_sided;
  /// Shown as its base colour.
  bool unlit;
  /// The share of light that goes through, 0 to 1; at 0 nothing below counts (KHR_materials_transmission, _ior, _volume).
  float transmission_factor;
  /// Index of refraction, at least 1.
  float ior;
  /// The longest way through, metres; 0 is a thin pane.
  float thickness;
  /// What is left of white light after attenuation_distance: linear Rec.709.
  float attenuation_color[3];
  /// Metres; 0 counts as infinite.
  float attenuation_distance;
} OntileMaterial;

/// A picture and how it is sampled.
typedef struct OntileTexture {
  /// Of an image.
  OntileId image;
  /// Linear, else nearest.
  bool mag_linear;
  /// Likewise.
  bool min_linear;
  /// An OntileMips.
  uint32_t mips;
  /// An OntileWrap, along u.
  uint32_t wrap_u;
  /// An OntileWrap, along v.
  uint32_t wrap_v;
  /// Samples where a pixel covers a long, narrow part of the picture: 16 at most; 0 and 1 are none.
  uint8_t max_anisotropy;
} OntileTexture;

/// A picture, 8 bits a channel, rows from the top.
typedef struct OntileImage {
  /// For messages; may be null.
  const char *name;
  /// Texels.
  uint32_t width;
  /// Texels.
  uint32_t height;
  /// width * height * 4 bytes: red, green, blue, alpha.
  const uint8_t *rgba8;
  /// Null, or a KTX 2.0 file in memory, which is taken instead of all but the name.
  const uint8_t *ktx2;
  /// Bytes of that file.
  size_t ktx2_bytes;
} OntileImage;

/// A placement of a mesh.
typedef struct OntileInstance {
  /// Of a mesh.
  OntileId mesh;
  /// Affine, column by column.
  float world_from_object[16];
  /// It will move: nothing that depends on its place is kept.
  bool dynamic;
  /// As if it were not there.
  bool hidden;
} OntileInstance;

/// A light. ontile_light_default gives a white one of no intensity.
typedef struct OntileLight {
  /// For messages; may be null.
  const char *name;
  /// An OntileLightKind.
  uint32_t kind;
  /// Linear Rec.709.
  float color[3];
  /// What surfaces get that face away; a hemisphere's ground.
  float back_color[3];
  /// Lux or candela, as the kind says.
  float intensity;
  /// World space, metres.
  float position[3];
  /// World space: the way the light travels.
  float direction[3];
  /// Metres; 0 has no end.
  float range;
  /// Radians from a spot's axis: full intensity within.
  float inner_cone;
  /// Radians from a spot's axis: dark outside.
  float outer_cone;
  /// A box's extent along the light's X, Y and Z, metres.
  float box_size[3];
  /// A box's light fades over this distance inside each face, metres.
  float box_falloff;
  /// An OntileShadow.
  uint32_t shadow;
  /// It may change from frame to frame: nothing of it is kept.
  bool dynamic;
  /// Those of higher priority get their shadows first.
  float priority;
} OntileLight;

/// A box that paints a material over what lies in it.
typedef struct OntileDecal {
  /// Of a material.
  OntileId material;
  /// Turns the cube from -0.5 to 0.5 into the box, column by column; it projects along its -Z.
  float world_from_decal[16];
  /// How much is painted of base colour, normal, roughness and metallicness: 0 to 1.
  float channels[4];
  /// Metres inside the faces across X, Y and Z within which it fades.
  float falloff[3];
  /// Those of lower priority are painted first.
  float priority;
} OntileDecal;

/// A square that faces the camera and adds light.
typedef struct OntileParticle {
  /// Its middle, world space, metres.
  float position[3];
  /// Its side, metres.
  float size;
  /// Counter-clockwise on the image, radians.
  float rotation;
  /// Multiplies the material's emission; linear Rec.709.
  float color[3];
} OntileParticle;

/// Particles of one material.
typedef struct OntileParticles {
  /// For messages; may be null.
  const char *name;
  /// Of a material, whose emission is what they add.
  OntileId material;
  /// They fade where something opaque is no farther behind them, metres.
  float soft;
  /// How many there are.
  size_t count;
  /// May be null where there are none.
  const struct OntileParticle *particles;
  /// How many there may be later without anything being made anew; what is less than count counts as count.
  size_t most;
} OntileParticles;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/// The plan that a renderer of this world would have, as ontile_renderer_plan tells it. `options` may be null.
enum OntileResult ontile_plan_text(const struct OntileDevice *device,
                                   const struct OntileWorld *world,
                                   const struct OntileOptions *options,
                                   size_t *size,
                                   char *text);

/// The pipelines of that plan, a line each: the subpass, a space, what is drawn. Sizes and `text` as for ontile_plan_text.
enum OntileResult ontile_plan_pipelines(const struct OntileDevice *device,
                                        const struct OntileWorld *world,
                                        const struct OntileOptions *options,
                                        size_t *size,
                                        char *text);

/// Compiles all pipelines of that plan into a cache, those of shadow maps included, so that making the renderer with it does not. It may take
/// long, and run on any thread, as long as nobody changes the world.
enum OntileResult ontile_pipeline_cache_prepare(const struct OntilePipelineCache *cache,
                                                const struct OntileDevice *device,
                                                const struct OntileWorld *world,
                                                const struct OntileOptions *options);

/// What device memory a renderer of this world, for so many frames in flight, and a target of this size will take. `options` may be null.
enum OntileResult ontile_plan_budget(const struct OntileDevice *device,
                                     const struct OntileWorld *world,
                                     const struct OntileOptions *options,
                                     uint32_t frames_in_flight,
                                     uint32_t width,
                                     uint32_t height,
                                     struct OntileBudget *budget);

/// The ABI version of the library: a program compares it with ONTILE_ABI_VERSION of the header that it was compiled with.
uint32_t ontile_abi_version(void);

/// Why the last call of this thread that failed did so, with what and where, and a remedy. It is valid until the next call that fails;
/// before the first one it is empty.
const char *ontile_last_error(void);

/// The VkResult of the last call that failed, if that was ONTILE_RESULT_ERROR_VULKAN; else 0.
int32_t ontile_last_vulkan_result(void);

/// Makes a renderer of a world as it is now, with all pipelines, and gathers what is to be copied to the device. `options` and `cache`
/// may be null. Afterwards the host calls ontile_world_clear_changes: all that the world is is in the renderer. `frames_in_flight` is how many frames the host may have on the GPU at a time, views counted.
enum OntileResult ontile_renderer_create(const struct OntileDevice *device,
                                         const struct OntileWorld *world,
                                         const struct OntileOptions *options,
                                         uint32_t frames_in_flight,
                                         const struct OntilePipelineCache *cache,
                                         struct OntileRenderer **renderer);

/// Destroys a renderer; null is none.
void ontile_renderer_destroy(struct OntileRenderer *renderer);

/// The plan as a text: passes, subpasses, attachments, what is loaded and stored, and why. With `text` null it writes its size in bytes;
/// else as much as `size` has room for, and how much that was. There is no zero at its end.
enum OntileResult ontile_renderer_plan(const struct OntileRenderer *renderer,
                                       size_t *size,
                                       char *text);

/// What the host's images must be like.
enum OntileResult ontile_renderer_output(const struct OntileRenderer *renderer, struct OntileOutput *output);

/// Records the copies that bring a new renderer's world to the device. The host submits them before the first frame or with it.
enum OntileResult ontile_renderer_record_upload(struct OntileRenderer *renderer,
                                                VkCommandBuffer commands);

/// Frees staging memory once the commands of ontile_renderer_record_upload have finished on the GPU.
enum OntileResult ontile_renderer_finish_upload(struct OntileRenderer *renderer);

/// Whether frames recorded from now on have queries of their own (timestamps, statistics); at first they have. Those that a host counts by
/// VK_KHR_performance_query want none.
enum OntileResult ontile_renderer_set_queries(struct OntileRenderer *renderer,
                                              bool are_recorded);

/// Brings a renderer to the state that its world is in now, for the frames recorded from now on; frames on the GPU go on as they are.
/// Copies are recorded into `commands`, which the host submits before the next frame or with it. Nothing waits. Afterwards, and once
/// the world's other renderers are updated too, the host calls ontile_world_clear_changes. `updated` may be null.
enum OntileResult ontile_renderer_update(struct OntileRenderer *renderer,
                                         const struct OntileWorld *world,
                                         VkCommandBuffer commands,
                                         struct OntileUpdated *updated);

/// Makes the attachments that go with the host's images of a size, e.g. those of a swapchain; again after each resize. The old
/// target may still be in use by the GPU: the host destroys it when it no longer is.
enum OntileResult ontile_target_create(const struct OntileRenderer *renderer,
                                       uint32_t width,
                                       uint32_t height,
                                       const struct OntileOutputImage *images,
                                       size_t count,
                                       struct OntileTarget **target);

/// The same for a renderer with the option "difference" (a number that multiplies it), with a view of the other picture: of this size, one
/// sample, any format of colours. When a frame is recorded that picture was drawn by commands before on the same queue, and its image is
/// in VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, as the option "output-use" with "sample" leaves it.
enum OntileResult ontile_target_create_beside(const struct OntileRenderer *renderer,
                                              uint32_t width,
                                              uint32_t height,
                                              const struct OntileOutputImage *images,
                                              size_t count,
                                              VkImageView other,
                                              struct OntileTarget **target);

/// Has pictures drawn turned from now on, clockwise by 0, 90, 180 or 270 degrees, as a screen that is turned shows the images: the
/// preTransform of their swapchain. Cameras stay those of the upright picture. It costs nothing, where a system that turns images reads
/// and writes each again.
enum OntileResult ontile_target_pre_rotate(struct OntileTarget *target,
                                           uint32_t degrees);

/// Destroys a target; null is none.
void ontile_target_destroy(struct OntileTarget *target);

/// Records a frame: it submits nothing, waits for nothing and allocates nothing. `slot` is below frames_in_flight, and the GPU has
/// finished the frame that was recorded with it before. `image` is an index into the target's images. Light is multiplied by 2 to the
/// power of `exposure_ev`. A swapchain's semaphore is waited for at VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT.
enum OntileResult ontile_renderer_record(struct OntileRenderer *renderer,
                                         VkCommandBuffer commands,
                                         uint32_t slot,
                                         const struct OntileTarget *target,
                                         uint32_t image,
                                         const struct OntileCamera *camera,
                                         float exposure_ev);

/// As ontile_renderer_record, of a part of the picture, upright: left, top, right and bottom, pixels, four numbers. Tiles beyond it are
/// neither drawn nor stored. What is elsewhere in the image is lost, unless the renderer has the option "output-is-kept"; then the image
/// is in the layout that ontile_renderer_output says before too. So two renderers share an image.
enum OntileResult ontile_renderer_record_part(struct OntileRenderer *renderer,
                                              VkCommandBuffer commands,
                                              uint32_t slot,
                                              const struct OntileTarget *target,
                                              uint32_t image,
                                              const struct OntileCamera *camera,
                                              float exposure_ev,
                                              const uint32_t *part_px);

/// Takes note of a host's device.
enum OntileResult ontile_device_create(const struct OntileHost *host,
                                       struct OntileDevice **device);

/// Forgets a device; null is none. The objects made with it go first.
void ontile_device_destroy(struct OntileDevice *device);

/// How many Vulkan objects and bytes of device memory ontile has on a device.
enum OntileResult ontile_device_live(const struct OntileDevice *device, uint64_t *objects, uint64_t *bytes);

/// Makes a cache from what ontile_pipeline_cache_blob gave in an earlier run, or from nothing. Content that is damaged, or of another
/// device or driver, counts as nothing.
enum OntileResult ontile_pipeline_cache_create(const struct OntileDevice *device,
                                               const uint8_t *blob,
                                               size_t size,
                                               struct OntilePipelineCache **cache);

/// The content of a cache. With `blob` null it writes its size; else as much as `size` has room for, and how much that was.
enum OntileResult ontile_pipeline_cache_blob(const struct OntilePipelineCache *cache,
                                             size_t *size,
                                             uint8_t *blob);

/// Destroys a cache; null is none.
void ontile_pipeline_cache_destroy(struct OntilePipelineCache *cache);

/// As ontile_world_load, but what the file's animations move is where ontile_world_animate puts it. A file without animations is loaded
/// as there.
enum OntileResult ontile_world_load_moving(const char *path,
                                           struct OntileWorld **world);

/// The animations of a world, a line each: how many seconds it takes, a space, its name. The n-th line is animation n, from 0. With `lines`
/// null it writes their size in bytes; else as much as `size` has room for, and how much that was. There is no zero at the end.
enum OntileResult ontile_world_animations(const struct OntileWorld *world,
                                          size_t *size,
                                          char *lines);

/// Moves all that the animation moves to where it is after so many seconds; ontile_renderer_update brings renderers there. Nothing repeats:
/// after the last key it stays. Cameras that move are read by ontile_world_camera.
enum OntileResult ontile_world_animate(struct OntileWorld *world,
                                       size_t animation,
                                       double time_s);

/// Makes options that leave everything as it is by default.
enum OntileResult ontile_options_create(struct OntileOptions **options);

/// Sets an option by its name on the command line of the program `ontile`, e.g. "layout" to "packed128", "samples" to "4", "size" to
/// "1280x720". Of the host's images it wants to know "output" ("rgba8_srgb", "bgra8_srgb", "rgba16_float", "rgba32_float"), "output-use"
/// ("copy", "present", "sample", "draw") and "output-is-input-attachment" (whether they have that usage). What is on or off takes "true" or
/// "false"; what may be left open takes "auto". The message of an error lists the names, or the values, that there are. Whether values
/// go together, and with the device, is told by ontile_renderer_create.
enum OntileResult ontile_options_set(struct OntileOptions *options,
                                     const char *name,
                                     const char *value);

/// Destroys options; null is none.
void ontile_options_destroy(struct OntileOptions *options);

/// Sets the image that an overlay's triangles take their colours from: RGBA, encoded as sRGB and multiplied by alpha after that, 4 bytes a
/// texel, row by row from the top. At first it is one white texel. It waits until that is copied, and no frame of the renderer is on the GPU.
enum OntileResult ontile_renderer_set_overlay_image(struct OntileRenderer *renderer,
                                                    uint32_t width,
                                                    uint32_t height,
                                                    const uint8_t *texels,
                                                    size_t size);

/// Sets what is drawn over the frames that are recorded with this slot, in order, in the frame's own pass; the option "overlay" is "true".
/// The GPU has finished the frame that was recorded with the slot before. Vertices are in points, of `pixels_per_point` pixels.
enum OntileResult ontile_renderer_set_overlay(struct OntileRenderer *renderer,
                                              uint32_t slot,
                                              const struct OntileOverlayVertex *vertices,
                                              size_t vertex_count,
                                              const uint32_t *indices,
                                              size_t index_count,
                                              const struct OntileOverlayPart *parts,
                                              size_t part_count,
                                              float pixels_per_point);

/// Puts others in the place of all probes of a world. Each pixel looks at all of them, so they should be few. The device has the feature
/// imageCubeArray.
enum OntileResult ontile_world_set_probes(struct OntileWorld *world,
                                          const struct OntileProbe *probes,
                                          size_t count);

/// Nanoseconds of the GPU from the begin to the end of the frame that was recorded with this slot and has finished; 0 where the device tells no
/// times, the frame had no queries (ontile_renderer_set_queries), or it has not finished.
enum OntileResult ontile_renderer_frame_time(const struct OntileRenderer *renderer,
                                             uint32_t slot,
                                             double *nanoseconds);

/// Makes an empty world.
enum OntileResult ontile_world_create(const char *name, struct OntileWorld **world);

/// Loads a world from a glTF file (.gltf or .glb). What had to be left out is in ontile_world_warnings.
enum OntileResult ontile_world_load(const char *path, struct OntileWorld **world);

/// What loading had to leave out or change, a line each. With `lines` null it writes their size in bytes; else as much as `size` has room
/// for, and how much that was. There is no zero at the end.
enum OntileResult ontile_world_warnings(const struct OntileWorld *world,
                                        size_t *size,
                                        char *lines);

/// Destroys a world; null is none. Renderers made of it go on as they are.
void ontile_world_destroy(struct OntileWorld *world);

/// Adds a mesh, or puts it in another's place if `id` holds that one's name.
enum OntileResult ontile_world_set_mesh(struct OntileWorld *world,
                                        OntileId *id,
                                        const struct OntileMesh *mesh);

/// White, rough, opaque, without textures.
struct OntileMaterial ontile_material_default(void);

/// Adds a material, or puts it in another's place if `id` holds that one's name.
enum OntileResult ontile_world_set_material(struct OntileWorld *world,
                                            OntileId *id,
                                            const struct OntileMaterial *material);

/// Adds a texture, or puts it in another's place if `id` holds that one's name.
enum OntileResult ontile_world_set_texture(struct OntileWorld *world,
                                           OntileId *id,
                                           const struct OntileTexture *texture);

/// Adds a picture, or puts it in another's place if `id` holds that one's name.
enum OntileResult ontile_world_set_image(struct OntileWorld *world,
                                         OntileId *id,
                                         const struct OntileImage *image);

/// Adds an instance of a mesh, or puts it in another's place if `id` holds that one's name.
enum OntileResult ontile_world_set_instance(struct OntileWorld *world,
                                            OntileId *id,
                                            const struct OntileInstance *instance);

/// Moves an instance: an affine matrix, column by column.
enum OntileResult ontile_world_place(struct OntileWorld *world,
                                     OntileId instance,
                                     const float *world_from_object);

/// White, directional, along -Z, of no intensity.
struct OntileLight ontile_light_default(void);

/// Adds a light, or puts it in another's place if `id` holds that one's name.
enum OntileResult ontile_world_set_light(struct OntileWorld *world,
                                         OntileId *id,
                                         const struct OntileLight *light);

/// Adds a decal, or puts it in another's place if `id` holds that one's name.
enum OntileResult ontile_world_set_decal(struct OntileWorld *world,
                                         OntileId *id,
                                         const struct OntileDecal *decal);

/// Adds particles, or puts them in others' place if `id` holds those others' name: each frame, as many as `most` allows.
enum OntileResult ontile_world_set_particles(struct OntileWorld *world,
                                             OntileId *id,
                                             const struct OntileParticles *particles);

/// Takes an element out. What others refer to stays: the message names who does.
enum OntileResult ontile_world_remove(struct OntileWorld *world, uint32_t kind, OntileId id);

/// The names of all elements of a kind. With `ids` null it writes their number; else as many as `count` has room for, and how many that
/// were.
enum OntileResult ontile_world_ids(const struct OntileWorld *world,
                                   uint32_t kind,
                                   size_t *count,
                                   OntileId *ids);

/// Reads a camera that a file brought.
enum OntileResult ontile_world_camera(const struct OntileWorld *world,
                                      OntileId id,
                                      struct OntileCamera *camera);

/// Radiance from everywhere alike, cd/m2: three numbers, linear Rec.709.
enum OntileResult ontile_world_set_ambient(struct OntileWorld *world, const float *radiance);

/// What is seen where there is no surface, as linear display light; null is the environment, if there is one, else black.
enum OntileResult ontile_world_set_background(struct OntileWorld *world,
                                              const float *color);

/// Fog of a radiance (cd/m2, three numbers, linear Rec.709) and a density per metre; a density of 0 is none.
enum OntileResult ontile_world_set_fog(struct OntileWorld *world, const float *color, float density);

/// Radiance from far away, from a picture of all directions (.hdr; twice as wide as high); null is none.
enum OntileResult ontile_world_set_environment(struct OntileWorld *world, const char *path);

/// Once every renderer of the world was made or updated: forgets what was done to it.
enum OntileResult ontile_world_clear_changes(struct OntileWorld *world);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* ONTILE_H */
