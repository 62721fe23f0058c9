//! Parser of Ninja's output.

use pelage_herd::Task;
use std::collections::{BTreeMap, BTreeSet};

/// Commands that Ninja ran and their failures, parsed from its output.
#[derive(Clone, Debug, Default)]
pub struct NinjaOutput {
    /// Names of the commands that were run.
    pub tasks: BTreeSet<String>,
    /// Last lines that each failed command printed. The key is the list of its output files, as Ninja prints it.
    failed: BTreeMap<String, Vec<String>>,
    /// Output files of the failed command whose lines are being read.
    open: Option<String>,
}

impl NinjaOutput {
    /// Number of last lines kept for each failed command.
    const LINES: usize = 3;

    /// Parses Ninja's output.
    pub fn of(lines: &[u8]) -> Self {
        let mut ran = Self::default();
        ran.parse(lines);
        ran
    }

    /// Parses complete lines.
    pub fn parse(&mut self, lines: &[u8]) {
        for line in String::from_utf8_lossy(lines).lines() {
            self.parse_line(line);
        }
    }

    /// Parses a line. For a status line, returns the number of finished commands, the total and the command's name. For
    /// a failed command, Ninja prints its output files, then the command line, then what it printed.
    pub fn parse_line<'a>(&mut self, line: &'a str) -> Option<(usize, usize, &'a str)> {
        let said = status(line);
        if let Some((.., task)) = said {
            self.tasks.insert(task.to_owned());
            self.open = None;
        } else if let Some(files) = line.strip_prefix("FAILED: ") {
            // Later versions of Ninja print the exit code before the files.
            let code = files.strip_prefix("[code=").and_then(|rest| rest.split_once("] "));
            let files = code.map_or(files, |(_, files)| files).trim();
            self.failed.insert(files.to_owned(), Vec::new());
            self.open = Some(files.to_owned());
        } else if line.starts_with("ninja: ") {
            self.open = None;
        } else if let Some(lines) = self.open.as_ref().and_then(|files| self.failed.get_mut(files))
            && !line.trim().is_empty()
        {
            if lines.len() > Self::LINES {
                lines.remove(1);
            }
            lines.push(line.trim().to_owned());
        }
        said
    }

    /// Returns only the failures, without the names of the commands that were run.
    pub fn failures_alone(self) -> Self {
        Self { tasks: BTreeSet::new(), ..self }
    }

    /// Returns the last lines that a failed command printed, possibly empty; `None` if the command did not fail.
    pub fn last_words(&self, task: &Task) -> Option<String> {
        let files: Vec<&str> = task.outputs.iter().chain([&task.record]).map(String::as_str).collect();
        Some(self.failed.get(&files.join(" "))?.get(1..).unwrap_or_default().join("; "))
    }
}

/// Parses a status line such as `[3/10] bake fox`: finished commands, total, and name.
fn status(line: &str) -> Option<(usize, usize, &str)> {
    let (count, task) = line.strip_prefix('[')?.split_once("] ")?;
    let (done, total) = count.split_once('/')?;
    Some((done.parse().ok()?, total.parse().ok()?, task))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failures_are_parsed_from_ninja_output() {
        let mut ran = NinjaOutput::default();
        let lines = [
            "[1/3] bake a",
            "FAILED: a.pelage r/a.json ",
            "pelage bake a",
            "FAILED: [code=137] b b.pelage r/b.json ",
            "pelage bake b",
            "one",
            "two",
            "",
            "three",
            "four",
            "[2/3] bake c",
            "of c",
            "FAILED: r/d.json ",
            "ninja: build stopped: subcommands failed.",
            "of none",
        ];
        for line in lines {
            ran.parse_line(line);
        }
        let last_words = |output: &[&str], record: &str| {
            let outputs = output.iter().map(|output| (*output).to_owned()).collect();
            ran.last_words(&Task { outputs, record: record.to_owned(), ..Task::default() })
        };
        assert_eq!(last_words(&["a.pelage"], "r/a.json").as_deref(), Some(""));
        assert_eq!(last_words(&["b b.pelage"], "r/b.json").as_deref(), Some("two; three; four"));
        assert_eq!(last_words(&[], "r/d.json").as_deref(), Some(""));
        assert_eq!(last_words(&["c.pelage"], "r/c.json"), None);
        assert_eq!(ran.tasks.iter().collect::<Vec<_>>(), ["bake a", "bake c"]);
    }

    #[test]
    fn ninja_status_lines_are_parsed() {
        assert_eq!(status("[3/10] bake a] b"), Some((3, 10, "bake a] b")));
        assert!(["FAILED: a", "[x/2] a", "ninja: no work to do.", ""].iter().all(|line| status(line).is_none()));
    }
}
