//! The `pelage` command. What people and scripts can rely on stands in `bake/docs/scripts.md`; one file per subcommand in `cli/`.

#[allow(clippy::disallowed_methods, reason = "what it prints and draws, no package")]
mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
