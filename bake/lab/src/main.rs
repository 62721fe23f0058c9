//! The command `pelage-lab`: every subcommand of `pelage`, and `chart`.

use clap::Subcommand;
use pelage_lab::command::{self, ChartArgs};
use pelage_tool::errand::Errand;
use pelage_tool::exit::{Exit, Failure};
use pelage_tool::output::Output;
use pelage_tool::{Commands, Invocation, ResultSchema};

#[derive(Debug, Subcommand)]
enum Command {
    #[command(flatten)]
    Tool(pelage_tool::Command),
    Chart(ChartArgs),
}

impl Commands for Command {
    fn run(&self, invocation: &Invocation<'_>, output: &mut Output) -> Result<Exit, Failure> {
        match self {
            Self::Tool(command) => command.run(invocation, output),
            Self::Chart(args) => command::run(args, output),
        }
    }

    fn errand(&self) -> Option<Errand> {
        match self {
            Self::Tool(command) => command.errand(),
            Self::Chart(_) => None,
        }
    }

    fn results() -> Vec<ResultSchema> {
        [pelage_tool::Command::results(), vec![("chart", command::result_schema)]].concat()
    }
}

fn main() -> std::process::ExitCode {
    pelage_tool::run::<Command>()
}
