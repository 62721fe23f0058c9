//! uses surface/place
// Depth-only pass of the opaque mesh surface as seen from the key light.

struct CasterVarying {
    @invariant @builtin(position) position: vec4<f32>,
    @location(0) tint: vec4<f32>,
    @location(1) base_uv: vec2<f32>,
}

@vertex
fn vs_caster(v: Vertex) -> CasterVarying {
    return CasterVarying(frame.clip_from_world * vec4(position_ws(v), 1.0), v.color * material.base_color, v.base_uv);
}

// Fragment shader for parts with cutout.
@fragment
fn fs_caster(in: CasterVarying) {
    if is_cut(base_color(in.tint, in.base_uv).a) {
        discard;
    }
}
