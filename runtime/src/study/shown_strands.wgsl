override SHOW_AS: u32 = 1u;

// Single strands in false colours.
@fragment
fn fs_shown(in: StrandVarying) -> @location(0) vec4<f32> {
    return shown_as(SHOW_AS, vec4(in.light, 1.0), geometry_color(4u), true);
}
