// Vertex layout, stored or posed, for shaders that read vertices from storage buffers.

// 48 bytes.
struct GeometryVertex {
    position: vec3<f32>,
    fur_height: f32,
    normal: vec3<f32>,
    lean: f32,
    tangent: vec4<f32>,
}
