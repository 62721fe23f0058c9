// Nearest hair segments per pixel, in an area of the picture. Each pixel has NEAREST keys, nearest first, followed by
// the optical depth of the segments behind them (formulas 4.11).

// Number of segments that are stored per pixel.
const NEAREST: u32 = 8u;
// Number of words per pixel: the keys, then the optical depth behind them.
const OF_A_PIXEL: u32 = NEAREST + 1u;
// Fixed-point value that represents optical depth 1 in the last word of a pixel.
const OPTICAL_DEPTH: f32 = 256.0;

struct NearestHair {
    // Area of the picture: left, top, width and height in pixels. Width and height are multiples of TILE.
    area: vec4<u32>,
    // Size of the whole picture, pixels.
    size: vec2<f32>,
    // Number of segments per strand.
    pieces: u32,
    // Current round. 0: sorts the keys of the segments; 1: stores their light.
    round: u32,
}

// Pixels along a side of a tile.
const TILE: u32 = 8u;

// Depth is 1 at the near plane and 0 at the far plane.
override REVERSED_DEPTH: bool = false;

// Returns the sort key of a segment, which is larger for nearer segments. The low 8 bits of the key hold the segment's
// coverage of the pixel. A key of 0 marks an empty entry.
fn nearest_key(depth: f32, covered: f32) -> u32 {
    let nearness = select(1.0 - depth, depth, REVERSED_DEPTH);
    return ((bitcast<u32>(nearness) >> 6u) << 8u) | u32(covered * 255.0 + 0.5);
}

// Returns the depth of a key.
fn depth_of(key: u32) -> f32 {
    let nearness = bitcast<f32>((key >> 8u) << 6u);
    return select(1.0 - nearness, nearness, REVERSED_DEPTH);
}

// Returns the share of the pixel, 0..=1, that the segment of a key covers.
fn covered_by(key: u32) -> f32 {
    return f32(key & 255u) / 255.0;
}

// Returns the index of a pixel within the area.
fn pixel_number(at: vec2<u32>) -> u32 {
    return at.y * nearest.area.z + at.x;
}
