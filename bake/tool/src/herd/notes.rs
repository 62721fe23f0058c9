//! What a herd notes down for its next run: JSON that nobody else reads.

use crate::exit::Failure;
use pelage_bake::io;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::json;
use std::path::Path;

/// What was noted down; nothing where that cannot be read, which costs no more than time.
pub fn read<T: DeserializeOwned + Default>(path: &Path) -> T {
    serde_json::from_slice(&std::fs::read(path).unwrap_or_default()).unwrap_or_default()
}

/// Notes something down.
pub fn write(path: &Path, value: &impl Serialize) -> Result<(), Failure> {
    io::write_atomic(path, format!("{}\n", json!(value)).as_bytes())?;
    Ok(())
}
