//! The lines that a mesh shows from one place, found on the mesh: the truth that ink lines, which are found in a
//! picture of normals, are held against.
//!
//! A line is an edge whose one face looks at the eye and whose other looks away (a contour), an edge between faces at a
//! large angle (a crease), or the end of the mesh (a border). Each is sampled finely, and what lies behind other skin
//! is taken out by a ray from the eye to the sample. Nothing here is filtered, thresholded in pixels or drawn, and no
//! code is shared with what draws.
//!
//! # Edges or normals
//!
//! Of a mesh that stands for something smooth one may also ask where N·E, with the normals that light is computed with,
//! passes through zero ([`ContourForm::Interpolated`]). The truth here is [`ContourForm::Edges`]: what is seen of a
//! mesh ends at its edges, to the last digit and without a tolerance, in its outline as where it hides itself. The
//! zeros of the interpolated N·E run up to an edge's length inside or outside of that outline, where nothing in the
//! picture ends, break off where normals are split, and say nothing of flat faces. With small triangles both agree; a
//! test holds them together on a sphere.
//!
//! Source of the question: Fang et al. 2006, §2, which draws outline and feature lines; of the answer: edges between
//! front and back faces are the classic object-space silhouette (Markosian et al. 1997, §2.1).

mod line;
mod smooth;
mod topology;
mod visible;

use pelage_bake::mask::Mask;
use pelage_bake::strands::Skin;
use pelage_import::BakeError;
use pelage_truth::{Sight, TrueCamera};
use rayon::prelude::*;
use topology::Topology;

pub use line::{ContourForm, LineKind, LineParams, LineSegment};

/// A posed skin whose lines can be asked for from any side.
pub struct TrueLines {
    sight: Sight,
    topology: Topology,
}

/// The lines of a skin from one side.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VisibleLines {
    /// Picture, pixels.
    pub width: u32,
    /// Picture, pixels.
    pub height: u32,
    /// What is seen, in the order of the mesh's edges.
    pub segments: Vec<LineSegment>,
}

impl TrueLines {
    /// Finds the edges of a skin, and builds the tree for its rays. Vertices at one place are one, so that seams of
    /// patches, parts and normals are no borders.
    ///
    /// # Errors
    ///
    /// [`BakeError::Internal`] for places that are not finite.
    pub fn new(skin: Skin) -> Result<Self, BakeError> {
        let topology = Topology::new(&skin);
        Ok(Self { sight: Sight::new(skin)?, topology })
    }

    /// The skin with its rays.
    pub fn sight(&self) -> &Sight {
        &self.sight
    }

    /// The lines that a camera sees in a picture of `size` pixels. The same on any number of threads.
    ///
    /// # Errors
    ///
    /// [`BakeError::Params`] for an angle outside 0..=180.
    pub fn seen(&self, camera: &TrueCamera, size: (u32, u32), params: &LineParams) -> Result<VisibleLines, BakeError> {
        if !(0.0..=180.0).contains(&params.crease_deg) {
            let reason = format!("is {}, expected 0..=180", params.crease_deg);
            return Err(BakeError::Params { what: "crease_deg", reason });
        }
        let look = self.sight.from(camera, size);
        let mut pieces = self.topology.pieces(&self.sight, &look, params);
        if params.contour == ContourForm::Interpolated {
            pieces.extend(smooth::contours(&self.sight, &look));
        }
        let near_m = NEAR * self.sight.radius_m();
        let segments = pieces.par_iter().map(|piece| visible::parts(piece, &look, near_m)).flatten().collect();
        Ok(VisibleLines { width: size.0, height: size.1, segments })
    }
}

/// How far before the eye a line must be to be seen, radii of the skin.
const NEAR: f64 = 1e-6;

impl VisibleLines {
    /// The pixels that lines of some kinds run through.
    pub fn mask(&self, kinds: &[LineKind]) -> Mask {
        let mut mask = Mask::empty(self.width, self.height);
        for segment in self.segments.iter().filter(|s| kinds.contains(&s.kind)) {
            let steps = (segment.length_px() / visible::STEP_PX).ceil().max(1.0) as u32;
            for i in 0..=steps {
                let at = segment.from_px.lerp(segment.to_px, f64::from(i) / f64::from(steps));
                mask.insert(at.x.floor() as i64, at.y.floor() as i64);
            }
        }
        mask
    }

    /// Length of all lines of a kind, pixels.
    pub fn length_px(&self, kind: LineKind) -> f64 {
        self.segments.iter().filter(|s| s.kind == kind).map(LineSegment::length_px).sum()
    }
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
