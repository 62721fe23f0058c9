//! What counts as a line, and a piece of one that is seen.

use glam::DVec2;

/// What counts as a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineParams {
    /// Angle between the normals of two faces from which on their edge is a crease, degrees, 0..=180 (default 50). 0
    /// makes every edge a line, 180 none.
    pub crease_deg: f64,
    /// How contours are found.
    pub contour: ContourForm,
}

impl Default for LineParams {
    fn default() -> Self {
        Self { crease_deg: 50.0, contour: ContourForm::default() }
    }
}

/// How contours are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ContourForm {
    /// Edges between a face that looks at the eye and one that looks away: exactly where what is drawn ends.
    #[default]
    Edges,
    /// Zeros of N·E within triangles, with the vertices' normals interpolated: where the smooth surface that the mesh
    /// stands for would end. Hidden parts are found with a slack of a triangle's size, because these lines lie on the
    /// wrong side of the mesh's own outline half of the time.
    Interpolated,
}

/// What a line is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineKind {
    /// A contour with nothing behind.
    Silhouette,
    /// A contour before other skin.
    Contour,
    /// An edge between faces at a large angle, both of which are seen.
    Crease,
    /// The end of the mesh.
    Border,
}

impl LineKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Silhouette, Self::Contour, Self::Crease, Self::Border];
}

/// A straight piece of a line that is seen whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineSegment {
    /// One end, pixels from the picture's upper left corner.
    pub from_px: DVec2,
    /// The other end.
    pub to_px: DVec2,
    /// What it is.
    pub kind: LineKind,
}

impl LineSegment {
    /// Length, pixels.
    pub fn length_px(&self) -> f64 {
        self.from_px.distance(self.to_px)
    }
}
