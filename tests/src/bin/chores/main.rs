//! Programs that developers run by hand: `cargo run --release -p pelage-tests --bin chores -- CHORE [ARGUMENTS]`.
//!
//! Each chore is a module that documents its arguments.

mod contact_sheet;
mod eyes_covered;
mod key_pictures;
mod light_pictures;
mod likeness_pairs;
mod motion_pictures;
mod mutate;
mod performance_table;
mod same_pictures;
mod shader_table;
mod shadow_table;
mod window_pictures;
mod write_docs;

use std::process::ExitCode;

fn main() -> anyhow::Result<ExitCode> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (chore, arguments) = arguments.split_first().map_or(("", &[][..]), |(chore, more)| (chore.as_str(), more));
    match chore {
        "contact-sheet" => contact_sheet::run(arguments)?,
        "eyes-covered" => eyes_covered::run(arguments)?,
        "key-pictures" => key_pictures::run(arguments)?,
        "light-pictures" => light_pictures::run(arguments)?,
        "likeness-pairs" => likeness_pairs::run(arguments)?,
        "motion-pictures" => motion_pictures::run(arguments)?,
        "mutate" => return mutate::run(arguments),
        "performance-table" => performance_table::run()?,
        "same-pictures" => return same_pictures::run(arguments),
        "shader-table" => shader_table::run()?,
        "shadow-table" => shadow_table::run(arguments)?,
        "window-pictures" => window_pictures::run(arguments)?,
        "write-docs" => write_docs::run()?,
        _ => anyhow::bail!(
            "unknown chore {chore:?}; expected contact-sheet, eyes-covered, key-pictures, light-pictures, \
             likeness-pairs, motion-pictures, mutate, performance-table, same-pictures, shader-table, shadow-table, \
             window-pictures or write-docs"
        ),
    }
    Ok(ExitCode::SUCCESS)
}
