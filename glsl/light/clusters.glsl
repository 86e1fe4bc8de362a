// Light lists, one for each cell of the view: src/visible/clusters makes them.

// Mirrors ClusterGrid in src/gpu/shared.rs.
struct ClusterGrid {
    uint tile_shift;   // log2 of pixels
    uint columns;
    uint rows;
    uint slices;
    float slice_scale; // slice = measure * scale + bias; the measure is log2(metres), orthographic: metres
    float slice_bias;
};

layout(set = SET_FRAME, binding = BINDING_CLUSTERS, std430) readonly buffer Clusters {
    ClusterGrid grid;
    uint words[]; // where each cell's list begins and the last one ends, then the lists
} clusters;

// Where the list of this pixel's cell begins and ends in `clusters.words`.
uvec2 cluster_list(vec3 position_world) {
    float distance = dot(position_world - frame.camera_position_world.xyz, frame.forward_world.xyz);
    const float least = 1e-30;
    float measure = frame.camera_position_world.w == 0.0 ? distance : log2(max(distance, least));
    ClusterGrid grid = clusters.grid;
    float last = float(grid.slices - 1u);
    uint slice = uint(clamp(measure * grid.slice_scale + grid.slice_bias, 0.0, last));
    uvec2 tile = uvec2(gl_FragCoord.xy) >> grid.tile_shift;
    uint cell = (slice * grid.rows + tile.y) * grid.columns + tile.x;
    return uvec2(clusters.words[cell], clusters.words[cell + 1u]);
}
