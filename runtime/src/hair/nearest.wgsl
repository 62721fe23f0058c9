// The nearest pieces of hair in each pixel of a part of the picture: of each pixel NEAREST keys, the nearest first, and how opaque what is behind those is.

const NEAREST: u32 = 8u;
const OF_A_PIXEL: u32 = NEAREST + 1u;
// Optical depth of 1, as the last number counts it.
const OPTICAL_DEPTH: f32 = 256.0;

struct NearestHair {
    // The part of the picture: left, top, width and height in pixels, the last two multiples of TILE.
    area: vec4<u32>,
    // Of the whole picture, pixels.
    size: vec2<f32>,
    // Of a strand.
    pieces: u32,
    // Of the gathering: 0 sorts keys, 1 leaves light.
    round: u32,
}

// Pixels along a side of a tile.
const TILE: u32 = 8u;

// Near is 1 and far is 0.
override REVERSED_DEPTH: bool = false;

// A key is larger the nearer a piece is, and holds how much of the pixel it covers in its last 8 bits. 0 is none.
fn nearest_key(depth: f32, covered: f32) -> u32 {
    let nearness = select(1.0 - depth, depth, REVERSED_DEPTH);
    return ((bitcast<u32>(nearness) >> 6u) << 8u) | u32(covered * 255.0 + 0.5);
}

fn depth_of(key: u32) -> f32 {
    let nearness = bitcast<f32>((key >> 8u) << 6u);
    return select(1.0 - nearness, nearness, REVERSED_DEPTH);
}

fn covered_by(key: u32) -> f32 {
    return f32(key & 255u) / 255.0;
}

// Which of the pixels of the part of the picture it is.
fn pixel_number(at: vec2<u32>) -> u32 {
    return at.y * nearest.area.z + at.x;
}
