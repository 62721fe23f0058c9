// Strands as the runtime plants them, and what those of a part have in common. A pass that includes this declares groom_texture,
// base_color_sampler, GROOM_VERTICES and GROOM_TEXTURE.

// 32 bytes.
struct Strand {
    base_uv: vec2<f32>,
    // Of the vertices, unorm.
    color: u32,
    // Bareness, wetness, unorm.
    groom: u32,
    // Which of the tile's it is.
    of_tile: u32,
    // 0..1, for what is true of a share of all strands; 1 of none that grows.
    chance: f32,
    lean: f32,
    fur_height: f32,
}

// 32 bytes.
struct StrandConstants {
    // Points of each.
    points: u32,
    // Of the model, with those that fill up workgroups.
    count: u32,
    // Points of all dry strands of the tile: the wet ones stand behind them.
    dry_points: u32,
    // Metres, of the largest number.
    radius: f32,
    // Those of the part.
    first: u32,
    end: u32,
    // Of them that is drawn.
    share: f32,
    reserved: u32,
}

// Vectors of the skin's frame before the posed points of each: normal and wetness; tangent and handedness.
const POSED_BEFORE: u32 = 2u;

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
