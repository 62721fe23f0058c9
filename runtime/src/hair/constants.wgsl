// What the strands of a part have in common.

// 32 bytes.
struct StrandConstants {
    // Points of each.
    points: u32,
    // Of the model, with those that fill up workgroups.
    count: u32,
    // Points of all dry strands of the tile: the wet ones stand behind them.
    dry_points: u32,
    // Metres, of the largest number.
    radius: f32,
    // Those of the part.
    first: u32,
    end: u32,
    // Of them that is drawn.
    share: f32,
    // Every how many points is looked at.
    step: u32,
}

// Vectors of the skin's frame before the posed points of each: normal and wetness; tangent and handedness.
const POSED_BEFORE: u32 = 2u;
