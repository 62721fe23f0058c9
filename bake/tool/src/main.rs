//! The `pelage` command. `bake/docs/scripts.md` lists the behaviour that users and scripts can rely on.

fn main() -> std::process::ExitCode {
    pelage_tool::run::<pelage_tool::Command>()
}
