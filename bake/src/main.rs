//! The `pelage` command. What people and scripts can rely on stands in the README; one file per subcommand in `cli/`.

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
