// Soft shadows from a shadow-width map (Kirsch and Doellner 2003; Yang 2006, sec. 4; formulas 4.4).
//
// The map is seen from the light. Depths are 0..=1 over its range. It is sampled with a linear filter; its channels
// are:
// * x: blurred occlusion: 0 if no texel within the blur is in shadow, 1 deep in shadow, 1/2 at the edge
// * y: blurred depth of the occluder, times x
// * z: depth of the surface nearest to the light
// * w: transmittance of the hair above that surface, blurred except beside deeper surfaces

struct SoftShadow {
    // Distance between depth 0 and depth 1, metres.
    range_m: f32,
    // Width of the penumbra divided by the distance from the occluder: 1 / C_scale of Yang 2006, sec. 5.
    penumbra: f32,
    // Half the width of the map's blur, metres; for a point light, at a distance of 1 m.
    blur: f32,
    // Width of a texel, in the unit of blur.
    texel: f32,
}

// Returns Attenu_Shadow in the paper's form but with a clamped width (formulas 4.4): the penumbra is inside the hard
// edge. `sd`: distance behind the occluder, metres; `sw`: distance from the edge into the shadow, metres; `blur`:
// maximum measurable `sw`.
fn inner_attenuation(sd: f32, sw: f32, penumbra: f32, blur: f32) -> f32 {
    // Clamp the penumbra to the measurable width; otherwise its middle would stay lit.
    let width = clamp(sd * penumbra, 1e-6, blur);
    return select(clamp(1.0 - sw / width, 0.0, 1.0), 1.0, sd <= 0.0);
}

// Returns Attenu_Shadow with the penumbra on both sides of the hard edge, as for a round light (formulas 4.4). `edge`:
// signed distance from the edge, metres, positive in the shadow.
fn centred_attenuation(sd: f32, edge: f32, penumbra: f32, blur: f32) -> f32 {
    let width = clamp(sd * penumbra, 1e-6, 2.0 * blur);
    return select(clamp(0.5 - edge / width, 0.0, 1.0), 1.0, sd <= 0.0);
}

// Returns the depth bias, metres (formulas 4.4). A surface that is behind the surface nearest to the light by at most
// this distance counts as the same surface. Within a texel, a surface covers a range of depths, which grows with its
// inclination.
fn depth_bias(distance: f32, path: f32, s: SoftShadow) -> f32 {
    return s.texel * distance * (0.5 + path);
}

// Returns Attenu_Shadow of eq. (3) at a receiver (formulas 4.4): 1 lit, 0 dark. `z`: depth of the receiver, 0..=1;
// `distance`: distance from a point light, metres, 1 for a distant light; `path`: slanted_path at the receiver.
fn soft_shadow(texel: vec4<f32>, z: f32, distance: f32, path: f32, s: SoftShadow, centred: bool) -> f32 {
    let blur = s.blur * distance;
    let bias = depth_bias(distance, path, s);
    let behind_first = (z - texel.z) * s.range_m - bias;
    let edge = (2.0 * texel.x - 1.0) * blur;
    if !centred {
        return inner_attenuation(behind_first, max(edge, 0.0), s.penumbra, blur);
    }
    let sd = max((z - texel.y / max(texel.x, 1e-3)) * s.range_m, behind_first);
    // The surface nearest to the light, if beside a shadow, is in its outer penumbra only if it is clearly below the
    // occluder. If it is nearer, it may be the occluder itself, whose blurred depth includes slanted neighbours.
    let slack = bias + blur * path;
    let outside = clamp(sd / slack - 1.0, 0.0, 1.0);
    let share = select(outside, 1.0, behind_first > 0.0);
    return mix(1.0, centred_attenuation(sd, edge, s.penumbra, blur), share);
}
