//! uses surface/geometry
// Replacement for morphed.wgsl if a model has no morph targets or all are at rest: returns vertices as stored.

// Returns the vertex unchanged.
fn morphed(index: u32, v: GeometryVertex) -> GeometryVertex {
    return v;
}
