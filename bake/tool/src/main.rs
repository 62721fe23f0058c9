//! The `pelage` command. `bake/docs/scripts.md` lists what users and scripts can rely on.

fn main() -> std::process::ExitCode {
    pelage_tool::run::<pelage_tool::Command>()
}
