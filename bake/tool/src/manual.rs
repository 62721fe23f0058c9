//! `pelage manual` (hidden): writes man pages and shell completions, which packages of the tool install.

use super::exit::{Exit, Failure};
use super::output::{Output, make_folder};
use clap_complete::{Shell, generate};
use pelage_bake::io::write_atomic;
use pelage_import::BakeError;
use serde_json::json;
use std::path::PathBuf;

/// Write man pages and shell completions into a folder, laid out as in /usr/share
#[derive(Clone, Debug, clap::Args)]
#[command(hide = true)]
pub struct ManualArgs {
    /// Folder for man1, bash-completion, zsh and fish
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Path of each shell's completion file, below `share`.
const COMPLETIONS: [(Shell, &str); 3] = [
    (Shell::Bash, "bash-completion/completions/pelage"),
    (Shell::Zsh, "zsh/site-functions/_pelage"),
    (Shell::Fish, "fish/vendor_completions.d/pelage.fish"),
];

/// Runs the subcommand; `command` is the clap definition to document.
pub fn run(args: &ManualArgs, mut command: clap::Command, output: &mut Output) -> Result<Exit, Failure> {
    let pages = args.folder.join("man/man1");
    make_folder(&pages)?;
    let fail = |source| BakeError::Io { path: pages.clone(), action: "write", source };
    clap_mangen::generate_to(command.clone(), &pages).map_err(fail)?;
    for (shell, name) in COMPLETIONS {
        let path = args.folder.join(name);
        if let Some(folder) = path.parent() {
            make_folder(folder)?;
        }
        let mut text = Vec::new();
        generate(shell, &mut command, "pelage", &mut text);
        write_atomic(&path, &text)?;
    }
    let folder = args.folder.display().to_string();
    output.result(&folder, &json!({ "folder": folder }))?;
    Ok(Exit::Done)
}
