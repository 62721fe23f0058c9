//! uses hair/hair, shared/opacity, surface/place
// Baseline for measuring the cost of shells: draws the same layers and fragments, but with one texture read and no
// lighting.

struct YardstickVarying {
    @invariant @builtin(position) position: vec4<f32>,
    @location(0) tile_uv: vec2<f32>,
    @location(1) @interpolate(flat, either) layer: u32,
}

@vertex
fn vs_yardstick(v: Vertex, @builtin(instance_index) index: u32) -> YardstickVarying {
    let layer = drawn_layer(index);
    let position = hair_position(v, tile_frame_of(v, normal_ws(v)), height_of(layer));
    let baked = baked_layer(layer, instance.baked_layers, instance.drawn_layers);
    return YardstickVarying(frame.clip_from_world * vec4(position, 1.0), v.tile_uv, baked);
}

@fragment
fn fs_yardstick(in: YardstickVarying) -> @location(0) vec4<f32> {
    return textureSample(shell_colors, shell_sampler, in.tile_uv, in.layer);
}
