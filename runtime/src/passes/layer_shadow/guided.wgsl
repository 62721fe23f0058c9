//! uses shared/deep_opacity
// Map of the key light's transmittance through all guided hair in front of the mesh surface (formulas 4.10).

@group(0) @binding(0) var<storage, read> deep: array<u32>;
@group(0) @binding(1) var<uniform> deep_opacity: DeepOpacity;

// Width and height of the target map, texels.
override MAP_SIZE: u32 = 1u;

// Full-screen triangle.
@vertex
fn vs_guided(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

// Returns the transmittance of all guided hair at a texel of the deep opacity map.
fn guided_transmittance(at: vec2<i32>) -> f32 {
    let size = deep_opacity.size;
    let texel = vec2<u32>(clamp(at, vec2(0), vec2(i32(size) - 1)));
    let all = deep[size * size * (1u + deep_opacity.slabs) + texel.y * size + texel.x];
    return exp(-deep_opacity.density * OPACITY_STEP * f32(all));
}

@fragment
fn fs_guided(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let at = position.xy * (f32(deep_opacity.size) / f32(MAP_SIZE)) - 0.5;
    let low = vec2<i32>(floor(at));
    let share = at - floor(at);
    let x = mix(guided_transmittance(low), guided_transmittance(low + vec2(1, 0)), share.x);
    let y = mix(guided_transmittance(low + vec2(0, 1)), guided_transmittance(low + vec2(1, 1)), share.x);
    return vec4(mix(x, y, share.y));
}
