// Light packed into 32 bits: nine bits per channel and a shared five-bit exponent. The value of a channel is its nine
// bits times 2^(exponent - PACKED_OFFSET).

// Bias of the packed exponent.
const PACKED_OFFSET: i32 = 24;
// Largest representable channel value: 511 * 2^(31 - 24).
const MOST_PACKED: f32 = 65408.0;
// Biased exponent of a float below which the packed exponent is 0.
const FLOAT_OFFSET: i32 = 111;
// Smallest value whose rounding needs ten bits.
const TEN_BITS: f32 = 511.5;

// Returns an integer power of two, built from the bits of a float.
fn power_of_two(exponent: i32) -> f32 {
    return bitcast<f32>(u32(exponent + 127) << 23u);
}

// Packs light, linear RGB; larger values are clamped to MOST_PACKED.
fn packed_light(light: vec3<f32>) -> u32 {
    let c = clamp(light, vec3(0.0), vec3(MOST_PACKED));
    let most = max(max(c.r, c.g), max(c.b, 6e-8));
    // Choose the exponent so that the largest of the three channels uses its top bit.
    var exponent = max(i32(bitcast<u32>(most) >> 23u) - FLOAT_OFFSET, 0);
    // A value that rounds up to ten bits needs the next exponent.
    if most * power_of_two(PACKED_OFFSET - exponent) >= TEN_BITS {
        exponent += 1;
    }
    let bits = vec3<u32>(c * power_of_two(PACKED_OFFSET - exponent) + 0.5);
    return bits.r | (bits.g << 9u) | (bits.b << 18u) | (u32(exponent) << 27u);
}

// Unpacks light, linear RGB.
fn unpacked_light(bits: u32) -> vec3<f32> {
    let channels = vec3(bits & 511u, (bits >> 9u) & 511u, (bits >> 18u) & 511u);
    return vec3<f32>(channels) * power_of_two(i32(bits >> 27u) - PACKED_OFFSET);
}
