// Written by tools/shaders.
embed![
    "base.frag",
    "bloom.frag",
    "forward.frag",
    "fullscreen.vert",
    "geometry.frag",
    "geometry.vert",
    "light.frag",
    "light_volume.vert",
    "lighting.frag",
    "mask.frag",
    "shadow.vert",
    "shadow_compose.frag",
    "sky.frag",
    "tonemap.frag",
    "unlit.frag",
]
