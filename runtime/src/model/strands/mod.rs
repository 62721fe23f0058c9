//! Strands of a package: fur strands and hair groups.

mod fur;
mod groups;
mod set;

pub(crate) use set::{CORNER_BYTES, Guided, HairRoot, Strand, StrandConstants, StrandSet, StrandSource, SurfacePoint};

use super::upload::Uploader;
use crate::error::RuntimeError;
use pelage_formats::{MeshView, Package};

/// Places the fur strands and generates the hair groups. Fur strands are omitted if there would be more than
/// `most_of_coat`, or if a buffer of the device cannot hold them.
pub(super) fn load(
    uploader: &Uploader<'_>,
    package: &Package<'_>,
    mesh: &MeshView<'_>,
    most_of_coat: u32,
) -> Result<Vec<StrandSet>, RuntimeError> {
    let mut sets: Vec<StrandSet> = fur::load(uploader, package, mesh, most_of_coat)?.into_iter().collect();
    sets.extend(groups::load(uploader, package, mesh)?);
    Ok(sets)
}
