// Single-colour fill of the whole picture.

@group(0) @binding(0) var<uniform> color: vec4<f32>;

@vertex
fn vs_probe(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.5, 1.0);
}

@fragment
fn fs_probe() -> @location(0) vec4<f32> {
    return color;
}
