//! What passes over strands have in common: which strands they run over, and what they bind of them.

use super::recording::Recording;
use super::seen::{Seen, StrandSet};
use crate::gpu::{Bound, in_compute, storage_in, uniform};
use crate::hair::DrawnSet;
use crate::model::{Strand, StrandConstants};
use std::ops::Range;

/// The sets of strands that are drawn, of all instances.
pub(crate) fn strand_sets(instances: &[Seen]) -> impl Iterator<Item = (&Seen, StrandSet<'_>)> {
    instances.iter().flat_map(|seen| seen.strands().map(move |set| (seen, set)))
}

/// What passes read posed strands from, as `hair/posed.wgsl` declares it.
pub(crate) fn posed_layout() -> [wgpu::BindGroupLayoutEntry; 4] {
    [
        storage_in::<[f32; 4]>(0),
        storage_in::<Strand>(1),
        storage_in::<[u32; 4]>(2),
        in_compute(uniform::<StrandConstants>(3, false)),
    ]
}

impl Recording<'_> {
    /// What [`posed_layout`] binds of the strands of a part, of which so much is looked at.
    pub(crate) fn posed_strands(
        &mut self,
        set: &StrandSet<'_>,
        of_part: &Range<u32>,
        drawn: &DrawnSet,
    ) -> [(u32, Bound); 4] {
        [
            (0, Bound::all(&set.posed.buffer)),
            (1, Bound::all(&set.strands.strands)),
            (2, Bound::all(&set.strands.tile)),
            (3, self.strand_constants(set, of_part, drawn)),
        ]
    }

    /// A block of what the strands of a part have in common.
    pub(crate) fn strand_constants(&mut self, set: &StrandSet<'_>, of_part: &Range<u32>, drawn: &DrawnSet) -> Bound {
        let place =
            self.uniforms.put(self.gpu, &[set.strands.constants(of_part, [drawn.share, drawn.widened], drawn.step)]);
        Bound::block::<StrandConstants>(&place.buffer, place.offset)
    }
}
