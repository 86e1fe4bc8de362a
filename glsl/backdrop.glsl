// The picture of what is opaque, which an earlier pass has stored. Wants SET_BEHIND.

#ifdef MULTISAMPLED
#define behindTexture texture2DMS
#define own_sample gl_SampleID
#define fetch_behind(behind, pixel) texelFetch(behind, pixel, own_sample)
#define size_behind(behind) textureSize(behind)
#else
#define behindTexture texture2D
#define own_sample 0
#define fetch_behind(behind, pixel) texelFetch(behind, pixel, 0)
#define size_behind(behind) textureSize(behind, 0)
#endif

layout(set = SET_BEHIND, binding = BINDING_BEHIND_LIGHT) uniform behindTexture behind_light; // as in the light target
layout(set = SET_BEHIND, binding = BINDING_BEHIND_DEPTH) uniform behindTexture behind_depth;

// Where in each pixel it shows what is there.
vec2 place_in_pixel() {
    return fract(gl_FragCoord.xy);
}
