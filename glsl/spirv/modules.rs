// Written by tools/shaders.
embed![
]
