//! Lines of a mesh from a viewpoint, found on the mesh. They are the truth for ink lines, which are found in a picture
//! of normals.
//!
//! A line is one of three kinds of edge: between a face towards the eye and one away from it (a contour), between faces
//! at a large angle (a crease), or an open edge (a border). Each edge is sampled finely, and rays from the eye remove
//! samples behind other parts of the surface. Nothing here is filtered, thresholded in pixels or rasterised, and no
//! code is shared with the renderer.
//!
//! # Edges or normals
//!
//! On a mesh that approximates a smooth surface, contours may also be defined by the shading normals, as zeros of N·E
//! ([`ContourForm::Interpolated`]). The truth here is [`ContourForm::Edges`]: the visible part of a mesh ends exactly
//! at its edges, both in its outline and where it hides itself. No tolerance is needed. The zeros of the interpolated
//! N·E are up to an edge's length inside or outside of that outline, where nothing in the picture ends. They also break
//! off where normals are split, and do not exist on flat faces. With small triangles, both definitions agree; a test
//! compares them on a sphere.
//!
//! The need for such lines comes from Fang et al. 2006, §2, which draws outline and feature lines. Edges between front
//! and back faces are the classic object-space silhouette (Markosian et al. 1997, §2.1).

mod line;
mod smooth;
mod topology;
mod visible;

use crate::mask::Mask;
use pelage_bake::strands::PosedMesh;
use pelage_import::BakeError;
use pelage_truth::{SurfaceVisibility, TrueCamera};
use rayon::prelude::*;
use topology::Topology;

pub use line::{ContourForm, LineKind, LineParams, LineSegment};

/// Posed mesh surface, prepared for finding its lines from any viewpoint.
pub struct TrueLines {
    sight: SurfaceVisibility,
    topology: Topology,
}

/// Lines of a mesh surface from one viewpoint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VisibleLines {
    /// Width of the picture, pixels.
    pub width: u32,
    /// Height of the picture, pixels.
    pub height: u32,
    /// Visible segments, in the order of the mesh's edges.
    pub segments: Vec<LineSegment>,
}

impl TrueLines {
    /// Finds the edges of a mesh surface, and builds the acceleration tree for its rays. Vertices at the same position
    /// are merged, so that seams of patches, parts and normals do not count as borders.
    ///
    /// # Errors
    ///
    /// [`BakeError::Internal`] for positions that are not finite.
    pub fn new(skin: PosedMesh) -> Result<Self, BakeError> {
        let topology = Topology::new(&skin);
        Ok(Self { sight: SurfaceVisibility::new(skin)?, topology })
    }

    /// Returns the mesh surface prepared for visibility rays.
    pub fn sight(&self) -> &SurfaceVisibility {
        &self.sight
    }

    /// Returns the lines visible to a camera in a picture of `size` pixels. The result does not depend on the number of
    /// threads.
    ///
    /// # Errors
    ///
    /// [`BakeError::Params`] for an angle outside 0..=180.
    pub fn visible_from(
        &self,
        camera: &TrueCamera,
        size: (u32, u32),
        params: &LineParams,
    ) -> Result<VisibleLines, BakeError> {
        if !(0.0..=180.0).contains(&params.crease_deg) {
            let reason = format!("is {}, expected 0..=180", params.crease_deg);
            return Err(BakeError::Params { what: "crease_deg", reason });
        }
        let look = self.sight.view(camera, size);
        let mut pieces = self.topology.pieces(&self.sight, &look, params);
        if params.contour == ContourForm::Interpolated {
            pieces.extend(smooth::contours(&self.sight, &look));
        }
        let near_m = NEAR * self.sight.radius_m();
        let segments = pieces.par_iter().map(|piece| visible::visible_parts(piece, &look, near_m)).flatten().collect();
        Ok(VisibleLines { width: size.0, height: size.1, segments })
    }
}

/// Smallest distance from the eye at which a line is visible, as a fraction of the mesh surface's radius.
const NEAR: f64 = 1e-6;

impl VisibleLines {
    /// Returns the mask of pixels that lines of the given kinds cross.
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

    /// Returns the total length of all lines of a kind, pixels.
    pub fn length_px(&self, kind: LineKind) -> f64 {
        self.segments.iter().filter(|s| s.kind == kind).map(LineSegment::length_px).sum()
    }
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
