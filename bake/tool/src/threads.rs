//! Thread pool of a subcommand.

use super::exit::Failure;
use pelage_import::BakeError;

/// Creates a pool of `threads` threads, by default one per core.
pub fn pool(threads: Option<u16>) -> Result<rayon::ThreadPool, Failure> {
    let mut pool = rayon::ThreadPoolBuilder::new();
    if let Some(threads) = threads {
        pool = pool.num_threads(threads.into());
    }
    Ok(pool.build().map_err(|error| BakeError::Internal(format!("starting threads: {error}")))?)
}
