// False colours in the place of light: of which geometry a fragment is, or how many lie over each other.

// What fragments show: 0 their light, 1 which geometry they are of, 2 one step each.
override SHOW_AS: u32 = 0u;

// Skin, far coat, shells, fins, single strands; as the documents name them: grey, violet, green, yellow, red.
fn geometry_color(geometry: u32) -> vec3<f32> {
    switch geometry {
        case 0u: { return vec3(0.5); }
        case 1u: { return vec3(0.5, 0.25, 0.9); }
        case 2u: { return vec3(0.1, 0.7, 0.15); }
        case 3u: { return vec3(0.95, 0.75, 0.1); }
        default: { return vec3(0.9, 0.2, 0.12); }
    }
}

// color: premultiplied. Of geometries the light stays as shades, so that forms are seen. In steps what blends adds up, and what is opaque is one step
// in front of nothing.
fn shown_as(color: vec4<f32>, tint: vec3<f32>, is_opaque: bool) -> vec4<f32> {
    if SHOW_AS == 1u {
        let light = dot(color.rgb, vec3(0.2126, 0.7152, 0.0722)) / max(color.a, 1e-3);
        return vec4(tint * (0.35 + 0.65 * min(light, 1.0)) * color.a, color.a);
    }
    if SHOW_AS == 2u {
        return vec4(0.06, 0.025, 0.01, select(0.0, 1.0, is_opaque));
    }
    return color;
}

// What a fragment shows of its geometry (0 skin, 1 far coat, 2 shells, 3 fins), or on the way from it to the next.
fn shown(color: vec4<f32>, geometry: u32, share: f32) -> vec4<f32> {
    return shown_as(color, mix(geometry_color(geometry), geometry_color(geometry + 1u), share), geometry < 2u);
}
