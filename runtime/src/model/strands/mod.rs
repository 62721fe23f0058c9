//! The strands of a package: those of its coat, and groups of hair.

mod coat;
mod groups;
mod set;

pub(crate) use set::{CORNER_BYTES, Growth, Guided, HairRoot, Stand, Strand, StrandConstants, Strands};

use super::upload::Uploader;
use crate::error::RuntimeError;
use pelage_formats::{MeshView, Package};

/// Plants the coat's and lets groups of hair grow; without the coat's where there would be over `most_of_coat`, or a buffer of the device cannot
/// hold them.
pub(super) fn load(
    uploader: &Uploader<'_>,
    package: &Package<'_>,
    mesh: &MeshView<'_>,
    most_of_coat: u32,
) -> Result<Vec<Strands>, RuntimeError> {
    let mut sets: Vec<Strands> = coat::load(uploader, package, mesh, most_of_coat)?.into_iter().collect();
    sets.extend(groups::load(uploader, package, mesh)?);
    Ok(sets)
}
