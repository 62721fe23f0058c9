//! `import`: reads a model and separates body parts that the groom treats differently.

use crate::stages::groom;
use pelage_import::BakeError;
use pelage_import::mesh::Model;

pub use pelage_import::{ImportOptions, Resolve, import_strands, input_record};

/// Reads a model with [`pelage_import::import`] and gives noses, eyes and claws materials of their own.
///
/// Fails like [`pelage_import::import`].
pub fn import<'r>(
    file: &str,
    bytes: &[u8],
    resolve: &'r mut Resolve<'r>,
    options: &ImportOptions,
) -> Result<Model, BakeError> {
    let mut model = pelage_import::import(file, bytes, resolve, options)?;
    groom::split_features(&mut model);
    Ok(model)
}
