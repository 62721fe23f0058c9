//! What a measurement was made on, in words.

/// What measures that need no graphics adapter run on.
pub fn processor() -> String {
    measured_on(&format!("CPU, {} threads", rayon::current_num_threads()))
}

/// Name of what was measured on. A debug build says so: its seconds mean little.
pub fn measured_on(what: &str) -> String {
    let build = if cfg!(debug_assertions) { ", debug build" } else { "" };
    format!("{what}{build}")
}
