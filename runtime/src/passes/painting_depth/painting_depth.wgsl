//! uses surface/place
// Depth of all surfaces, by which strokes are hidden.

struct DepthVarying {
    @builtin(position) position: vec4<f32>,
    @location(0) tint: vec4<f32>,
    @location(1) base_uv: vec2<f32>,
}

@vertex
fn vs_painting_depth(v: Vertex) -> DepthVarying {
    return DepthVarying(frame.clip_from_world * vec4(position_ws(v), 1.0), v.color * material.base_color, v.base_uv);
}

@fragment
fn fs_painting_depth(in: DepthVarying) {
    if is_cut(base_color(in.tint, in.base_uv).a) {
        discard;
    }
}
