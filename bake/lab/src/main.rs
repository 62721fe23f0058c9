//! The command `pelage-lab`: all subcommands of `pelage`, plus `chart`.

mod commands_page;

use clap::Subcommand;
use commands_page::CommandsPageArgs;
use pelage_lab::command::{self, ChartArgs};
use pelage_tool::exit::{Exit, Failure};
use pelage_tool::job::Job;
use pelage_tool::output::Output;
use pelage_tool::{Commands, Invocation, ResultSchema};

#[derive(Debug, Subcommand)]
enum Command {
    #[command(flatten)]
    Tool(pelage_tool::Command),
    Chart(ChartArgs),
    CommandsPage(CommandsPageArgs),
}

impl Commands for Command {
    fn run(&self, invocation: &Invocation<'_>, output: &mut Output) -> Result<Exit, Failure> {
        match self {
            Self::Tool(command) => command.run(invocation, output),
            Self::Chart(args) => command::run(args, output),
            Self::CommandsPage(_) => commands_page::run((invocation.definition)(), results(), output),
        }
    }

    fn job(&self) -> Option<Job> {
        match self {
            Self::Tool(command) => command.job(),
            Self::Chart(_) | Self::CommandsPage(_) => None,
        }
    }
}

/// Returns the results of all subcommands.
fn results() -> Vec<ResultSchema> {
    [pelage_tool::results(), vec![("chart", command::result_schema)]].concat()
}

fn main() -> std::process::ExitCode {
    pelage_tool::run::<Command>()
}
