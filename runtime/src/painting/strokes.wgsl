// Strokes of a model, as stored and as posed for a frame.

struct PoolStroke {
    // 0 pale wash, 1 middle wash, 2 dark, 3 bone, 4 spot, 5 eye, 6 tuft, 7 lock of hair, 8 wash on the ground.
    kind: u32,
    rank: f32,
    seed: u32,
    // Pigment, sRGB, eight bits each; then 255 if there is one.
    pigment: u32,
}

// Size: 32 bytes.
struct BrushPoint {
    // Pixel position, distance from the eye plane, and half width, pixels.
    place: vec4<f32>,
    // Density of the ink, dryness, distance along the stroke in pixels, and load of the brush's sides, -1..=1.
    brush: vec4<f32>,
}

// Uniform block, one per instance.
struct PaintedModel {
    // Point of the ground below the model.
    ground_ws: vec3<f32>,
    // Size of the model, metres.
    size: f32,
    // Number of strokes, of dark ones and of tufts.
    count: u32,
    darks: f32,
    tufts: f32,
    // Half length of the wash on the ground, metres.
    reach: f32,
}

// Number of points of a stroke.
const STROKE_POINTS: u32 = 24u;

const PALE: u32 = 0u;
const MIDDLE: u32 = 1u;
const DARK: u32 = 2u;
const BONE: u32 = 3u;
const SPOT: u32 = 4u;
const EYE: u32 = 5u;
const TUFT: u32 = 6u;
const LOCK: u32 = 7u;
const GROUND: u32 = 8u;
