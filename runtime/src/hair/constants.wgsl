// Constants shared by all strands of a part.

// Size: 32 bytes.
struct StrandConstants {
    // Points per strand.
    points: u32,
    // Strands of the model, including those that pad workgroups.
    count: u32,
    // Points of all dry strands of the tile; the wet ones follow them.
    dry_points: u32,
    // Radius in metres of the largest stored number.
    radius: f32,
    // Range of strands of the part.
    first: u32,
    end: u32,
    // Share of the strands that is drawn.
    share: f32,
    // Stride between the points that are used.
    step: u32,
}

// Vectors of the surface frame before the posed points of each strand: normal and wetness; tangent and handedness.
const POSED_BEFORE: u32 = 2u;
