//! uses shared/tone
// False colours instead of lighting: the geometry type of a fragment, or the number of overlapping fragments.

// Output of the fragment shaders. 0: lit colour; 1: false colour of the geometry type; 2: a constant per fragment, to
// count overlap.
override SHOW_AS: u32 = 0u;

// Luminance weights of linear sRGB (ITU-R BT.709).
const LUMINANCE: vec3<f32> = vec3(0.2126, 0.7152, 0.0722);
// Brightness of a false colour without light.
const DARK_SHADE: f32 = 0.35;
// Brightness that full light adds to a false colour.
const SHADE_GAIN: f32 = 0.65;
// Colour that each fragment adds when overlap is counted.
const FRAGMENT_STEP: vec3<f32> = vec3(0.06, 0.025, 0.01);

// Colours as documented: mesh surface grey, far fur layer violet, shells green, fins yellow, strands red.
fn geometry_color(geometry: u32) -> vec3<f32> {
    switch geometry {
        case 0u: { return vec3(0.5); }
        case 1u: { return vec3(0.5, 0.25, 0.9); }
        case 2u: { return vec3(0.1, 0.7, 0.15); }
        case 3u: { return vec3(0.95, 0.75, 0.1); }
        default: { return vec3(0.9, 0.2, 0.12); }
    }
}

// Returns the false colour of a fragment. `color`: premultiplied colour of the lit fragment; `tint`: colour of its
// geometry type.
//
// When geometry types are shown, `tint` is shaded by the brightness of `color`, so that shapes stay visible. When
// overlap is counted, blended fragments add up; an opaque fragment is one step above the background.
fn false_color_with(color: vec4<f32>, tint: vec3<f32>, is_opaque: bool) -> vec4<f32> {
    if SHOW_AS == 1u {
        let light = dot(color.rgb, LUMINANCE) / max(color.a, 1e-3);
        return vec4(tint * (DARK_SHADE + SHADE_GAIN * min(light, 1.0)) * color.a, color.a);
    }
    if SHOW_AS == 2u {
        return vec4(FRAGMENT_STEP, select(0.0, 1.0, is_opaque));
    }
    return displayed(color);
}

// Returns the false colour of a geometry type, mixed with that of the next type by `share`, 0..1. `geometry`: 0 mesh
// surface, 1 far fur layer, 2 shells, 3 fins.
fn false_color(color: vec4<f32>, geometry: u32, share: f32) -> vec4<f32> {
    return false_color_with(color, mix(geometry_color(geometry), geometry_color(geometry + 1u), share), geometry < 2u);
}
