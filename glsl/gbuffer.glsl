// The G-buffer layout that this module is compiled for.

#if defined(LAYOUT_METALLIC128)
#include "gbuffer/metallic128.glsl"
#elif defined(LAYOUT_EXACT)
#include "gbuffer/exact.glsl"
#else
#error "define LAYOUT_METALLIC128 or LAYOUT_EXACT"
#endif
