//! Describes the hardware of a measurement.

/// Returns the hardware description `what`, with a mark in debug builds, whose times are not representative.
pub fn measured_on(what: &str) -> String {
    let build = if cfg!(debug_assertions) { ", debug build" } else { "" };
    format!("{what}{build}")
}
