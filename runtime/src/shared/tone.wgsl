// Whether the output is tone-mapped.
override TONE: bool = false;
// Peak value from which light is compressed.
const SHOULDER: f32 = 0.7;
// Strength with which compressed colours fade to white.
const FADE: f32 = 0.15;

// Returns a colour, linear RGB, with its brightest channel compressed below 1. Colours with a peak up to SHOULDER are
// unchanged (formulas 1.4).
fn tone_mapped(color: vec3<f32>) -> vec3<f32> {
    let peak = max(color.r, max(color.g, color.b));
    let room = 1.0 - SHOULDER;
    let shown = 1.0 - room * room / (max(peak, SHOULDER) + 1.0 - 2.0 * SHOULDER);
    let white = 1.0 - 1.0 / (FADE * max(peak - shown, 0.0) + 1.0);
    let compressed = mix(color * (shown / max(peak, SHOULDER)), vec3(shown), white);
    return select(compressed, color, peak <= SHOULDER);
}

// Returns the output of a fragment: its premultiplied colour, tone-mapped if the frame asks for it.
fn displayed(color: vec4<f32>) -> vec4<f32> {
    if TONE {
        return vec4(tone_mapped(color.rgb / max(color.a, 1e-3)) * color.a, color.a);
    }
    return color;
}
