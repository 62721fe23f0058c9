//! Description of the hardware that a measurement was made on.

/// Returns a description for measurements without a graphics adapter.
pub fn processor() -> String {
    measured_on(&format!("CPU, {} threads", rayon::current_num_threads()))
}

/// Returns a description of the hardware; marks debug builds, whose times are not representative.
pub fn measured_on(what: &str) -> String {
    let build = if cfg!(debug_assertions) { ", debug build" } else { "" };
    format!("{what}{build}")
}
