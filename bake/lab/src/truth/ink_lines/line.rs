//! Definition of a line, and of its visible segments.

use glam::DVec2;

/// Parameters that define which edges are lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineParams {
    /// Smallest angle between the normals of two faces at which their edge is a crease, degrees, 0..=180 (default 50).
    /// With 0, every edge is a line; with 180, none is.
    pub crease_deg: f64,
    /// Method of finding contours.
    pub contour: ContourForm,
}

impl Default for LineParams {
    fn default() -> Self {
        Self { crease_deg: 50.0, contour: ContourForm::default() }
    }
}

/// Method of finding contours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ContourForm {
    /// Edges between a face towards the eye and one away from it. The rendered mesh ends exactly there.
    #[default]
    Edges,
    /// Zeros of N·E within triangles, with interpolated vertex normals. The smooth surface that the mesh approximates
    /// would end there. Visibility is tested with a tolerance of a triangle's size, because half of these lines are on
    /// the hidden side of the mesh's own outline.
    Interpolated,
}

/// Kind of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineKind {
    /// Contour with nothing behind it.
    Silhouette,
    /// Contour in front of other mesh surface.
    Contour,
    /// Edge between faces at a large angle, both of which are visible.
    Crease,
    /// Open edge of the mesh.
    Border,
}

impl LineKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Silhouette, Self::Contour, Self::Crease, Self::Border];
}

/// Straight segment of a line that is entirely visible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineSegment {
    /// First end, pixels from the upper left corner of the picture.
    pub from_px: DVec2,
    /// Second end, pixels from the upper left corner of the picture.
    pub to_px: DVec2,
    /// Kind of the line.
    pub kind: LineKind,
}

impl LineSegment {
    /// Returns the length, pixels.
    pub fn length_px(&self) -> f64 {
        self.from_px.distance(self.to_px)
    }
}
