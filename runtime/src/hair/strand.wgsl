// Strands as the runtime plants them. A pass that includes this declares groom_texture,
// base_color_sampler, GROOM_VERTICES and GROOM_TEXTURE.

// 32 bytes.
struct Strand {
    base_uv: vec2<f32>,
    // Of the vertices, unorm.
    color: u32,
    // Bareness, wetness, unorm; what the body leaves open to it, packed.
    groom: u32,
    // Which of the tile's it is.
    of_tile: u32,
    // 0..1, for what is true of a share of all strands; 1 of none that grows.
    chance: f32,
    lean: f32,
    fur_height: f32,
}

// What the groom says of a strand: share of the hair around it that grows, and wetness, both 0..=1.
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
