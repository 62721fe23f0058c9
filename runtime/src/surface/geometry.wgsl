// Vertex layout, for both stored and posed vertices, for shaders that read them from storage buffers.

// Size: 48 bytes.
struct GeometryVertex {
    position: vec3<f32>,
    fur_height: f32,
    normal: vec3<f32>,
    lean: f32,
    tangent: vec4<f32>,
}
