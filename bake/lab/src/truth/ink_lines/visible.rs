//! Visible parts of a line, found by testing samples along it with a ray each.

use super::line::{LineKind, LineSegment};
use glam::{DVec2, DVec3};
use pelage_truth::SurfaceView;

/// Largest distance between samples along a line, pixels.
pub(super) const STEP_PX: f64 = 0.5;
/// Distance beyond a contour at which a ray tests whether there is a surface behind it, pixels.
const BEYOND_PX: f64 = 1.0;

/// Straight line on the mesh, whether hidden or not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MeshLine {
    /// Ends in world space, metres.
    pub(super) from: DVec3,
    pub(super) to: DVec3,
    pub(super) family: Family,
    /// Point beside the line on the visible mesh surface.
    pub(super) inside: DVec3,
    /// Depth tolerance of the visibility test, metres. A surface hides the line only if it is nearer to the eye by more
    /// than this.
    pub(super) slack_m: f64,
}

/// Kind of a line before the surface behind it is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Family {
    Contour,
    Crease,
    Border,
}

/// Returns the parts of a line that are visible in the picture.
///
/// * `near_m`: distance from the eye below which everything is ignored, metres
pub(super) fn visible_parts(piece: &MeshLine, look: &SurfaceView<'_>, near_m: f64) -> Vec<LineSegment> {
    let Some(line) = Line::new(piece, look, near_m) else { return Vec::new() };
    let Some((begin, end)) = line.inside(look.rays().size()) else { return Vec::new() };
    let steps = ((end - begin) * line.from_px.distance(line.to_px) / STEP_PX).ceil().max(1.0) as u32;
    let share = |i: u32| begin + (end - begin) * f64::from(i) / f64::from(steps);
    let mut out: Vec<LineSegment> = Vec::new();
    let mut last = None;
    for i in 0..steps {
        // Each sample represents the interval around it.
        let (from_px, to_px) = (line.at(share(i)), line.at(share(i + 1)));
        let kind = line.visible_kind(0.5 * (share(i) + share(i + 1)), piece, look);
        if let Some(kind) = kind {
            match out.last_mut().filter(|_| last == Some(kind)) {
                Some(segment) => segment.to_px = to_px,
                None => out.push(LineSegment { from_px, to_px, kind }),
            }
        }
        last = kind;
    }
    out
}

/// Line in the picture, clipped to the part in front of the eye.
struct Line {
    from: DVec3,
    to: DVec3,
    from_px: DVec2,
    to_px: DVec2,
    /// Depths of the ends, metres; both 1 for parallel rays.
    depths: (f64, f64),
}

impl Line {
    fn new(piece: &MeshLine, look: &SurfaceView<'_>, near_m: f64) -> Option<Self> {
        let rays = look.rays();
        let (mut from, mut to) = (piece.from, piece.to);
        let (a, b) = (rays.depth(from), rays.depth(to));
        if a.max(b) <= near_m {
            return None;
        }
        let cut = |near: DVec3, far: DVec3, (n, f): (f64, f64)| near.lerp(far, (near_m - n) / (f - n));
        if a < near_m {
            from = cut(from, to, (a, b));
        } else if b < near_m {
            to = cut(to, from, (b, a));
        }
        let ((from_px, a), (to_px, b)) = (rays.project(from)?, rays.project(to)?);
        let depths = if rays.is_parallel() { (1.0, 1.0) } else { (a, b) };
        Some(Self { from, to, from_px, to_px, depths })
    }

    /// Returns the interval of line parameters (0..=1) that is inside the picture (Liang and Barsky 1984).
    fn inside(&self, size: DVec2) -> Option<(f64, f64)> {
        let (mut begin, mut end) = (0.0f64, 1.0f64);
        let way = self.to_px - self.from_px;
        for (start, way, most) in [(self.from_px.x, way.x, size.x), (self.from_px.y, way.y, size.y)] {
            if way == 0.0 {
                if !(0.0..most).contains(&start) {
                    return None;
                }
                continue;
            }
            let (enter, leave) = (-start / way, (most - start) / way);
            begin = begin.max(enter.min(leave));
            end = end.min(enter.max(leave));
        }
        (begin < end).then_some((begin, end))
    }

    /// Returns the point of the line at parameter `share`, pixels.
    fn at(&self, share: f64) -> DVec2 {
        self.from_px.lerp(self.to_px, share)
    }

    /// Returns the point of the line at parameter `share` in world space. With perspective, parameter 0.5 is the middle
    /// in the picture; in space, that point is nearer to the eye than the middle of the line.
    fn at_ws(&self, share: f64) -> DVec3 {
        let (near, far) = ((1.0 - share) / self.depths.0, share / self.depths.1);
        self.from.lerp(self.to, far / (near + far))
    }

    /// Returns the kind of line at a point, or `None` if the line is hidden there.
    fn visible_kind(&self, share: f64, piece: &MeshLine, look: &SurfaceView<'_>) -> Option<LineKind> {
        let at = self.at_ws(share);
        if !look.is_visible(at, piece.slack_m) {
            return None;
        }
        Some(match piece.family {
            Family::Crease => LineKind::Crease,
            Family::Border => LineKind::Border,
            Family::Contour => {
                let across = (self.to_px - self.from_px).perp().normalize_or_zero();
                let at_px = self.at(share);
                let inwards = look.project_px(piece.inside).map_or(0.0, |inside| (inside - at_px).dot(across));
                let outwards = if inwards > 0.0 { -across } else { across };
                match look.at(at_px + outwards * BEYOND_PX) {
                    Some(_) => LineKind::Contour,
                    None => LineKind::Silhouette,
                }
            }
        })
    }
}
