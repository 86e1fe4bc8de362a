// Written by tools/shaders.
embed![
    "base.frag",
    "forward.frag",
    "fullscreen.vert",
    "geometry.vert",
    "geometry_exact.frag",
    "geometry_metallic128.frag",
    "light.frag",
    "light_volume.vert",
    "lighting_exact.frag",
    "lighting_metallic128.frag",
    "mask.frag",
    "shadow.vert",
    "shadow_compose.frag",
    "tonemap.frag",
    "unlit.frag",
]
