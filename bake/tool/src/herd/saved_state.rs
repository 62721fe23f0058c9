//! State that a herd saves for its next run, in private JSON files.

use crate::exit::Failure;
use pelage_bake::io;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::json;
use std::path::Path;

/// Reads saved state. Returns the default if it cannot be read; the only loss is time.
pub fn read<T: DeserializeOwned + Default>(path: &Path) -> T {
    serde_json::from_slice(&std::fs::read(path).unwrap_or_default()).unwrap_or_default()
}

/// Writes saved state.
pub fn write(path: &Path, value: &impl Serialize) -> Result<(), Failure> {
    io::write_atomic(path, format!("{}\n", json!(value)).as_bytes())?;
    Ok(())
}
