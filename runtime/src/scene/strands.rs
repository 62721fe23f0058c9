//! Helpers for the strand passes: iteration over strand sets, and their bindings.

use super::recording::Recording;
use super::visible_instance::{StrandsToDraw, VisibleInstance};
use crate::gpu::{BindingResource, in_compute, storage_in, uniform};
use crate::hair::StrandSetDrawing;
use crate::model::{Strand, StrandConstants};
use std::ops::Range;

pub(crate) fn strand_sets(
    instances: &[VisibleInstance],
) -> impl Iterator<Item = (&VisibleInstance, StrandsToDraw<'_>)> {
    instances.iter().flat_map(|seen| seen.strands().map(move |set| (seen, set)))
}

/// Returns the layout entries of posed strands, as declared in `hair/posed.wgsl`.
pub(crate) fn posed_layout() -> [wgpu::BindGroupLayoutEntry; 4] {
    [
        storage_in::<[f32; 4]>(0),
        storage_in::<Strand>(1),
        storage_in::<[u32; 4]>(2),
        in_compute(uniform::<StrandConstants>(3, false)),
    ]
}

impl Recording<'_> {
    /// Returns the bindings of [`posed_layout`] for a part's strands. `drawn`: share of strands, width factor and point
    /// step.
    pub(crate) fn posed_strands(
        &mut self,
        set: &StrandsToDraw<'_>,
        of_part: &Range<u32>,
        drawn: &StrandSetDrawing,
    ) -> [(u32, BindingResource); 4] {
        [
            (0, BindingResource::all(&set.posed.buffer)),
            (1, BindingResource::all(&set.strands.strands)),
            (2, BindingResource::all(&set.strands.tile)),
            (3, self.strand_constants(set, of_part, drawn)),
        ]
    }

    /// Returns the uniform block with the constants of a part's strands.
    pub(crate) fn strand_constants(
        &mut self,
        set: &StrandsToDraw<'_>,
        of_part: &Range<u32>,
        drawn: &StrandSetDrawing,
    ) -> BindingResource {
        let place =
            self.uniforms.put(self.gpu, &[set.strands.constants(of_part, [drawn.share, drawn.widened], drawn.step)]);
        BindingResource::block::<StrandConstants>(&place.buffer, place.offset)
    }
}
