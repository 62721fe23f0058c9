// Constants shared by all strands of a part.

// Size: 32 bytes.
struct StrandConstants {
    // Number of points per strand.
    points: u32,
    // Number of strands of the model, including those that pad workgroups.
    count: u32,
    // Number of points of all dry strands of the tile; the wet ones follow them.
    dry_points: u32,
    // Radius that the largest stored value represents, metres.
    radius: f32,
    // First strand of the part.
    first: u32,
    // End of the part's strand range.
    end: u32,
    // Share of the strands that are drawn.
    share: f32,
    // Stride between the points that are used.
    step: u32,
}

// Number of surface-frame vectors stored before the posed points of each strand: normal with wetness, tangent with
// handedness. The handedness is 0 if the surface at the root is hidden.
const POSED_BEFORE: u32 = 2u;
