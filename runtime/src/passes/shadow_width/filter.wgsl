// From depth maps to the shadow-width map (Yang 2006, sec. 4): occlusion, shrunk and stretched again, so that its grey tells how far an
// edge is. Texels as in shared/soft_shadow.wgsl.

struct Filter {
    // Of the light's projection; near is 0 for a distant light, whose depth is linear.
    near: f32,
    far: f32,
    // Texels of a side of the block that becomes one.
    shrink: i32,
    // What the depths of two surfaces must differ by, 0..=1.
    least_gap: f32,
}

@group(0) @binding(0) var<uniform> params: Filter;
@group(0) @binding(1) var nearest: texture_depth_2d;
@group(0) @binding(2) var farthest: texture_depth_2d;
// Transmittance of all hair.
@group(0) @binding(3) var hair: texture_2d<f32>;
@group(0) @binding(4) var shrunk: texture_2d<f32>;
@group(0) @binding(5) var linear_sampler: sampler;

// A triangle over the whole target.
@vertex
fn vs_filter(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

// Depth 0..=1 that grows evenly with distance.
fn even_depth(z: f32) -> f32 {
    if params.near == 0.0 {
        return z;
    }
    let distance = params.near * params.far / (params.far - z * (params.far - params.near));
    return (distance - params.near) / (params.far - params.near);
}

// A texel is in shadow where the farthest surface that faces the light is not the nearest one.
@fragment
fn fs_shrink(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let size = vec2<i32>(textureDimensions(nearest));
    let corner = vec2<i32>(position.xy) * params.shrink;
    var sum = vec4(0.0);
    for (var y = 0; y < params.shrink; y++) {
        for (var x = 0; x < params.shrink; x++) {
            let at = min(corner + vec2(x, y), size - 1);
            let near = even_depth(textureLoad(nearest, at, 0));
            let gap = even_depth(textureLoad(farthest, at, 0)) - near;
            let light = textureLoad(hair, min(at, vec2<i32>(textureDimensions(hair)) - 1), 0).r;
            sum += vec4(select(vec2(0.0), vec2(1.0, near), gap > params.least_gap), 0.0, light);
        }
    }
    return sum / f32(params.shrink * params.shrink);
}

@fragment
fn fs_stretch(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let blurred = textureSampleLevel(shrunk, linear_sampler, position.xy / vec2<f32>(textureDimensions(nearest)), 0.0);
    let first = even_depth(textureLoad(nearest, vec2<i32>(position.xy), 0));
    return vec4(blurred.xy, first, blurred.w);
}
