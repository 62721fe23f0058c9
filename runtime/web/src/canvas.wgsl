// Copies a stage's picture to the page's canvas. `linear_of` is in the runtime's shared/srgb.wgsl.

// The texture holds encoded bytes, with colour premultiplied by coverage in linear light.
@group(0) @binding(0) var picture: texture_2d<f32>;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    // Triangle that covers the canvas.
    return vec4<f32>(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

// Returns the sRGB encoding of linear light (formulas 1.2).
fn encoded(linear: vec3<f32>) -> vec3<f32> {
    return select(1.055 * pow(linear, vec3<f32>(1.0 / 2.4)) - 0.055, linear * 12.92, linear <= vec3<f32>(0.0031308));
}

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = textureLoad(picture, vec2<i32>(position.xy), 0);
    // Fully transparent and opaque pixels keep their bytes.
    if (pixel.a <= 0.0 || pixel.a >= 1.0) {
        return pixel;
    }
    let straight = min(linear_of(pixel.rgb) / pixel.a, vec3<f32>(1.0));
    return vec4<f32>(encoded(straight) * pixel.a, pixel.a);
}
