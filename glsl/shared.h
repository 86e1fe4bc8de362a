// Numbers that GLSL and Rust share: each line is `#define NAME NUMBER`, read by the compiler and by
// src/gpu/shader. A name is `<what>_<which>`.

// Descriptor sets. Sets 1 have different layouts in geometry (materials) and in later subpasses (inputs).
#define SET_FRAME 0
#define SET_MATERIAL 1
#define SET_INPUTS 1
#define SET_DECAL_MATERIAL 2
#define SET_LAYERS 2

// Bindings of SET_FRAME and SET_MATERIAL.
#define BINDING_FRAME 0
#define BINDING_INSTANCES 1
#define BINDING_LIGHTS 2
#define BINDING_CLUSTERS 3
#define BINDING_SHADOW_VIEWS 6
#define BINDING_SHADOW_MAP 7
#define BINDING_GLOBE_MAPS 12
#define BINDING_SPLIT_SUM 8
#define BINDING_ENVIRONMENT 9
#define BINDING_RADIANCE 10
#define BINDING_RADIANCES 10
#define BINDING_LIGHTMAPS 11
#define BINDING_LIGHTMAP 13
#define BINDING_PROBES 14
#define BINDING_VOLUMES 4
#define BINDING_DECALS 20
#define BINDING_CASTERS 21
#define BINDING_CASTER_INSTANCES 22
#define BINDING_PARTICLES 23
// Beside input attachments: scattered light that the tone curve mixes in.
#define BINDING_BLOOM 24
// What meshes that bend are posed from, and what is written of them.
#define BINDING_REST 25
#define BINDING_POSES 26
#define BINDING_POSED 27
#define BINDING_MATERIAL 0
#define BINDING_TEXTURES 1
#define BINDING_MEDIUM 2
// Beside input attachments: what is opaque, for media that bend its way.
#define BINDING_BEHIND_LIGHT 28
#define BINDING_BEHIND_DEPTH 29

// Input attachments, by the name of what they hold. A pipeline has those that its subpass reads: when it is made, their indices
// and bindings in SET_INPUTS become their places in the subpass.
#define INPUT_DEPTH 0
#define INPUT_POSITION 1
#define INPUT_POSITION_Z 2
#define INPUT_NORMAL_ROUGHNESS 3
#define INPUT_NORMAL 4
#define INPUT_NORMAL_XY 5
#define INPUT_BASE_METALLIC 6
#define INPUT_SPECULAR 7
#define INPUT_WORDS 8
#define INPUT_MORE_WORDS 9
#define INPUT_LIGHT_WORD 10
#define INPUT_LIGHT 11
#define INPUT_REFRACTED_LIGHT 11
#define INPUT_SPECULAR_LIGHT 12
#define INPUT_EDGE 20
#define INPUT_OCCLUSION 21
#define INPUT_LAYER_0 24
#define INPUT_LAYER_1 25
#define INPUT_LAYER_2 26
#define INPUT_LAYER_3 27
#define INPUT_WEIGHTED_LIGHT 28
#define INPUT_WEIGHTS 29
#define INPUT_DEPTH_TEST 30
#define INPUT_DEPTH_STENCIL_TEST 30
#define INPUT_REFRACTED_DEPTH 30
#define INPUT_PEEL_A 30
#define INPUT_PEEL_B 30

// Vertex attribute locations.
#define ATTRIBUTE_POSITION 0
#define ATTRIBUTE_NORMAL 1
#define ATTRIBUTE_TEXCOORD 2
#define ATTRIBUTE_TANGENT 3
#define ATTRIBUTE_COLOR 4

// Locations between vertex and fragment stages.
#define VARYING_NORMAL 0
#define VARYING_TEXCOORD 1
#define VARYING_TANGENT 2
#define VARYING_COLOR 3
#define VARYING_LIGHT 4
#define VARYING_LIGHTMAP 5
#define VARYING_DECAL 8
#define VARYING_PARTICLE 9

// Colour outputs, likewise: locations become places in the subpass.
#define TARGET_DEPTH 0
#define TARGET_POSITION 1
#define TARGET_POSITION_Z 2
#define TARGET_NORMAL_ROUGHNESS 3
#define TARGET_NORMAL 4
#define TARGET_NORMAL_XY 5
#define TARGET_BASE_METALLIC 6
#define TARGET_SPECULAR 7
#define TARGET_WORDS 8
#define TARGET_MORE_WORDS 9
#define TARGET_LIGHT_WORD 10
#define TARGET_LIGHT 11
#define TARGET_REFRACTED_LIGHT 11
#define TARGET_SPECULAR_LIGHT 12
#define TARGET_OUTPUT 13
#define TARGET_EDGE 20
#define TARGET_OCCLUSION 21
#define TARGET_BLOOM_LIGHT 14
#define TARGET_LAYER_0 24
#define TARGET_LAYER_1 25
#define TARGET_LAYER_2 26
#define TARGET_LAYER_3 27
#define TARGET_WEIGHTED_LIGHT 28
#define TARGET_WEIGHTS 29

// Specialisation constant ids.
#define ID_TEXTURE_COUNT 0
#define ID_SLOT_BASE_COLOR 1
#define ID_SLOT_METALLIC_ROUGHNESS 2
#define ID_SLOT_NORMAL 3
#define ID_SLOT_OCCLUSION 4
#define ID_SLOT_EMISSIVE 5
#define ID_TEXCOORD_BITS 6
#define ID_TRANSFORM_BITS 7
#define ID_ALPHA_MASK 8
#define ID_DOUBLE_SIDED 9
#define ID_UNLIT 10
#define ID_VERTEX_COLOR 11
#define ID_EMISSIVE 12
#define ID_HAS_DIRECTIONAL 14
#define ID_HAS_POINT 15
#define ID_HAS_SPOT 16
#define ID_FOLD 17
#define ID_TONEMAP 18
#define ID_DITHER 19
#define ID_HAS_BOX 20
#define ID_HAS_HEMISPHERE 21
#define ID_HAS_BACK 22
#define ID_VOLUME_SHAPE 23
#define ID_BACKGROUND 24
#define ID_BACKGROUND_RED 25
#define ID_BACKGROUND_GREEN 26
#define ID_BACKGROUND_BLUE 27
#define ID_FOG 28
#define ID_FOG_RED 29
#define ID_FOG_GREEN 30
#define ID_FOG_BLUE 31
#define ID_FOG_DENSITY 32
#define ID_FOG_BASE 33
#define ID_FOG_INVERSE_HEIGHT 34
#define ID_LIGHTMAP_UNIT 35
#define ID_LIGHTMAP_RGBM 36
#define ID_RGBM 40
#define ID_HAS_ENVIRONMENT 41
#define ID_SHADOW_FILTER 48
#define ID_LIGHT_TARGET 49
#define ID_AMBIENT 50
#define ID_ENVIRONMENT 51
#define ID_CLUSTERS 52
#define ID_ONE_LIGHT 53
#define ID_SHADOWS 54
#define ID_GLOBE_MAPS 55
#define ID_LIGHTMAP 56
#define ID_PROBES 57
#define ID_FORM 58
#define ID_DEPTH_TARGET 59
#define ID_NORMALS 60
#define ID_GAMMA 61
#define ID_LIGHT_READ 62
#define ID_LIGHT_ALPHA 63
#define ID_GBUFFER 64
#define ID_BRDF 65
#define ID_LIGHT_ADDED 66
#define ID_SAMPLE_COUNT 67
#define ID_PER_SAMPLE 68
#define ID_SAMPLE_DEPTH 69
#define ID_RESOLVE_PLAIN 70
#define ID_FLOAT_OUTPUT 71
#define ID_EDGE_TARGET 72
#define ID_EDGE_MASKS 73
#define ID_BLOOM 80
#define ID_BLOOM_STORED 81
#define ID_BLOOM_STEP 82
#define ID_BLOOM_DISPLAYED 83
#define ID_DEPTH_STEP 84
#define ID_SHADOW_VOLUMES 85
#define ID_BLEND 90
#define ID_TRANSLUCENCY 91
#define ID_COLLECTED 92
#define ID_LAYER_COUNT 93
#define ID_LAYER_PAIRS 94
#define ID_BEHIND_OPAQUE 95
#define ID_HAS_BEHIND 96
#define ID_ABSORBS 97
#define ID_REFRACTS 98
#define ID_DECAL_BASE_COLOR 100
#define ID_DECAL_NORMAL 101
#define ID_DECAL_ROUGHNESS 102
#define ID_DECAL_METALLIC 103
#define ID_DECAL_TARGETS 104
#define ID_DECAL_BLENDED 105
#define ID_OCCLUSION_TARGET 110
#define ID_SHOW 111
#define ID_SHOW_STRIPS 112
#define ID_SHOW_STRIP_COUNT 113
#define ID_SHOW_EDGE 114

// Values of the constant FORM: what a G-buffer consists of, and the file in glsl/gbuffer that writes and reads it.
#define FORM_METALLIC 0
#define FORM_SPECULAR 1
#define FORM_THIBIEROZ128 2
#define FORM_THIBIEROZ96 3
#define FORM_RASA128 4
#define FORM_DISSERTATION192 5
#define FORM_METALLIC256 6
#define FORM_SPECULAR256 7
#define FORM_PACKED128 8

// Values of the constant COLLECTED: how what is blended is collected before it is laid over the light.
#define COLLECTED_NOT 0
#define COLLECTED_LAYERS 1
#define COLLECTED_SUM 2

// Values of the constant NORMALS.
#define NORMALS_FLOAT 0
#define NORMALS_XYZ 1
#define NORMALS_OCTAHEDRAL_8 2
#define NORMALS_OCTAHEDRAL_10 3
#define NORMALS_OCTAHEDRAL_12 4
#define NORMALS_OCTAHEDRAL_16 5
#define NORMALS_SPHEREMAP_12 6
#define NORMALS_VIEW_12 7

// Values of the constant GAMMA.
#define GAMMA_BY_FORMAT 0
#define GAMMA_2_2 1
#define GAMMA_2_0 2

// Values of the constant BRDF.
#define BRDF_EXACT 0
#define BRDF_FITTED 1
#define BRDF_MEDIUMP 2

// Kinds of material texture: bit numbers of TEXCOORD_BITS and TRANSFORM_BITS, indices of Material.uv_rows.
#define KIND_BASE_COLOR 0
#define KIND_METALLIC_ROUGHNESS 1
#define KIND_NORMAL 2
#define KIND_OCCLUSION 3
#define KIND_EMISSIVE 4
#define KIND_COUNT 5

// Values of the constant SHADOW_FILTER.
#define SHADOW_FILTER_HARDWARE 0
#define SHADOW_FILTER_GRID3 1
#define SHADOW_FILTER_GRID5 2
#define SHADOW_FILTER_JITTERED 3

// Passes after the frame's own: the only set of those that spread light, and where the picture is sampled.
#define SET_POST 0
#define BINDING_POST_COLOR 25
#define BINDING_POST_OWN 26
#define BINDING_EDGE_COLOR 27

// Values of the constant BLOOM_STEP.
#define BLOOM_STEP_FIRST 0
#define BLOOM_STEP_DOWN 1
#define BLOOM_STEP_UP 2

// Values of the constant TONEMAP.
#define TONEMAP_NEUTRAL 0
#define TONEMAP_ACES 1
#define TONEMAP_REINHARD 2
#define TONEMAP_LINEAR 3

// Values of the constant VOLUME_SHAPE.
#define VOLUME_SCREEN 0
#define VOLUME_SPHERE 1
#define VOLUME_CONE 2
#define VOLUME_BOX 3
// As the screen, for the light that the instance says.
#define VOLUME_OF_INSTANCE 4

// Bits of the stencil: pixels that are lit sample by sample, and what counts volumes' sides, from 0 and back to it.
#define STENCIL_EDGE 128
#define STENCIL_COUNT 127

// Values of the constant SHOW; those of the G-buffer's quantities are bits of SHOW_STRIPS too, in the order of strips.
#define SHOW_BASE_COLOR 0
#define SHOW_METALLIC 1
#define SHOW_DIFFUSE 2
#define SHOW_REFLECTANCE 3
#define SHOW_NORMAL 4
#define SHOW_ROUGHNESS 5
#define SHOW_DEPTH 6
#define SHOW_OCCLUSION 7
#define SHOW_LIGHT 8
#define SHOW_CHANNELS 16
#define SHOW_LIGHTS 17
#define SHOW_EDGES 18

// The legend of lights ends at 2^n - 1 of them.
#define SHOW_HEAT_DOUBLINGS 6
