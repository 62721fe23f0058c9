override SHOW_AS: u32 = 1u;

// The same where their edges are blended.
@fragment
fn fs_shown(in: TileVarying) -> Blended {
    let blended = blended_in(in);
    return Blended(shown_as(SHOW_AS, blended.color, geometry_color(4u), false), blended.depth);
}
