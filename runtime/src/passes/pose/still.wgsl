//! uses surface/geometry
// Stand-in for morphed.wgsl, for models without morph targets or with all targets at rest: returns vertices as stored.

fn morphed(index: u32, v: GeometryVertex) -> GeometryVertex {
    return v;
}
