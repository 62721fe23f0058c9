//! uses hair/hair, surface/place
// Strands as placed on the mesh by the runtime. A pass that includes this file declares groom_texture,
// base_color_sampler, GROOM_VERTICES and GROOM_TEXTURE.

// Size: 32 bytes.
struct Strand {
    base_uv: vec2<f32>,
    // Vertex colour, unorm.
    color: u32,
    // Bareness and wetness, unorm; then the packed openness of the body at the strand.
    groom: u32,
    // Index of the strand in the tile.
    of_tile: u32,
    // Selection number, random in 0..1. The strand is drawn if the number is below the share of strands that are drawn.
    // The number of a strand that does not grow is 1.
    selection: f32,
    lean: f32,
    fur_height: f32,
}

// Returns the groom of a strand: share of the hair around it that grows, and wetness, both 0..=1.
fn strand_groom(strand: Strand) -> vec2<f32> {
    var groom = vec2(1.0, 0.0);
    if GROOM_VERTICES {
        let at_vertex = unpack4x8unorm(strand.groom);
        groom = vec2(1.0 - at_vertex.x, at_vertex.y);
    }
    if GROOM_TEXTURE {
        let texel = textureSampleLevel(groom_texture, base_color_sampler, strand.base_uv, 0.0);
        groom = vec2(groom.x * texel.x, min(groom.y + texel.y, 1.0));
    }
    return groom;
}
