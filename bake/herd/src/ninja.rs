//! Ninja build files of a plan.

use super::kind::Kind;
use super::plan::{Plan, Task};
use super::shell::{shell_line, shell_word};
use std::fmt::Write as _;

/// Environment variables that set the number of threads of a command, besides its options. The value is one, because
/// several commands run at once and software rendering would use all cores otherwise.
pub const THREADS: [&str; 2] = ["RAYON_NUM_THREADS", "LP_NUM_THREADS"];

/// Prefix of Ninja's status lines (`NINJA_STATUS`): finished and total commands.
pub const STATUS: &str = "[%f/%t] ";

/// Concurrency limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ConcurrencyLimits {
    /// Number of concurrent commands, at least 1.
    pub jobs: u32,
    /// Number of concurrent commands that need more memory than [`Self::light_bytes`], at least 1.
    pub heavy: u32,
    /// Largest memory of a command that is not heavy, bytes.
    pub light_bytes: u64,
    /// Memory of the largest command if it exceeds the total, bytes; 0 if all fit.
    pub too_large: u64,
}

impl ConcurrencyLimits {
    /// Computes the limits that cores and memory allow. Half of the memory is shared by light commands, the other half
    /// by heavy ones.
    ///
    /// * `jobs`: maximum number of concurrent commands
    /// * `memory_bytes`: total memory
    pub fn of(tasks: &[&Task], jobs: u32, memory_bytes: u64) -> Self {
        let jobs = jobs.max(1);
        let light_bytes = memory_bytes / 2 / u64::from(jobs);
        let largest = tasks.iter().map(|task| task.expected.peak_bytes).max().unwrap_or(0);
        let heavy = (memory_bytes / 2).checked_div(largest.saturating_sub(light_bytes)).unwrap_or(u64::from(jobs));
        let heavy = heavy.clamp(1, u64::from(jobs)) as u32;
        let too_large = if largest > memory_bytes { largest } else { 0 };
        Self { jobs, heavy, light_bytes, too_large }
    }

    fn is_heavy(&self, task: &Task) -> bool {
        task.expected.peak_bytes > self.light_bytes
    }
}

/// Settings of a build file besides the plan.
#[derive(Clone, Copy, Debug)]
pub struct Settings<'a> {
    /// Absolute path of the program.
    pub tool: &'a str,
    /// Cache folder.
    pub cache: Option<&'a str>,
    /// Folder of Ninja's own files.
    pub own: &'a str,
    /// Concurrency limits.
    pub room: ConcurrencyLimits,
}

/// Returns the build file of `tasks`. Inputs that none of the tasks makes must exist. The file has no target for all
/// tasks: Ninja would check all of that target's inputs whenever one of them is made.
pub fn build_file(tasks: &[&Task], settings: &Settings<'_>) -> String {
    let Settings { tool, cache, own, room } = settings;
    let mut text = format!(
        "# Written by `pelage herd`, which writes it anew.\n\
         ninja_required_version = 1.10\n\
         builddir = {}\n\
         tool = {}\n\n\
         pool heavy\n  depth = {}\n\n\
         rule run\n  command = $tool $words\n  description = $task\n  restat = 1\n\n\
         # Such a command names all files that it has read.\n\
         rule read\n  command = $tool $words\n  description = $task\n  restat = 1\n  depfile = $depfile\n  deps = gcc\n\n",
        path(own),
        value(&shell_word(tool)),
        room.heavy,
    );
    for task in tasks {
        let (files, aside) = if task.outputs.is_empty() {
            (vec![path(&task.record)], String::new())
        } else {
            (task.outputs.iter().map(|output| path(output)).collect(), format!(" | {}", path(&task.record)))
        };
        let rule = if task.depfile.is_some() { "read" } else { "run" };
        let inputs: String = task.inputs.iter().map(|input| format!(" {}", path(input))).collect();
        let _ = writeln!(text, "build {}{aside}: {rule}{inputs} | {}", files.join(" "), path(tool));
        // The first word is the tool's name, which the rule supplies.
        let words = task.command(*cache);
        let _ = writeln!(text, "  words = {}\n  task = {}", value(&shell_line(&words[1..])), value(&task.name));
        let _ = task.depfile.iter().try_for_each(|depfile| writeln!(text, "  depfile = {}", value(depfile)));
        if room.is_heavy(task) {
            text += "  pool = heavy\n";
        }
    }
    text
}

/// Returns the tasks of a plan that may run concurrently: all but benchmarks, which need an idle machine.
pub fn untimed(plan: &Plan) -> Vec<&Task> {
    plan.tasks.iter().filter(|task| task.kind != Kind::Bench).collect()
}

/// Escapes a path for a build line.
fn path(path: &str) -> String {
    let mut word = String::new();
    for letter in path.chars() {
        if matches!(letter, '$' | ' ' | ':' | '|') {
            word.push('$');
        }
        word.push(letter);
    }
    word
}

/// Escapes the value of a variable.
fn value(text: &str) -> String {
    text.replace('$', "$$").replace('\n', "$\n")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::super::estimate::CommandCost;
    use super::*;

    fn task(peak_bytes: u64) -> Task {
        Task { expected: CommandCost { seconds: 1.0, peak_bytes }, ..Task::default() }
    }

    #[test]
    fn pools_never_exceed_available_memory() {
        for (jobs, memory, peaks) in [
            (2, 1000, vec![10, 20]),
            (8, 1000, vec![50, 62, 63, 500]),
            (4, 1000, vec![400]),
            (16, 1000, vec![900, 10]),
            (1, 100, vec![100]),
            (64, 24 << 30, vec![3 << 30, 200 << 20]),
        ] {
            let tasks: Vec<Task> = peaks.iter().map(|peak| task(*peak)).collect();
            let room = ConcurrencyLimits::of(&tasks.iter().collect::<Vec<_>>(), jobs, memory);
            let largest = *peaks.iter().max().unwrap();
            let heavy = if largest > room.light_bytes { u64::from(room.heavy) } else { 0 };
            let used = heavy * largest + (u64::from(room.jobs) - heavy) * room.light_bytes;
            let fits = used <= memory || room.heavy == 1;
            assert!(fits && room.jobs == jobs && room.too_large == 0, "{room:?} uses {used} of {memory}");
        }
        assert_eq!(ConcurrencyLimits::of(&[&task(2000)], 2, 1000).too_large, 2000);
    }

    #[test]
    fn paths_and_words_are_escaped_for_ninja() {
        let task = Task {
            name: "bake my fox".into(),
            words: ["bake", "my fox$1:.glb", "-o", "out/my fox.pelage"].map(str::to_owned).into(),
            inputs: vec!["my fox$1:.glb".into()],
            outputs: vec!["out/my fox.pelage".into()],
            record: "r.json".into(),
            depfile: Some("d.d".into()),
            ..Task::default()
        };
        let room = ConcurrencyLimits::of(&[&task], 2, 1 << 30);
        let settings = Settings { tool: "/opt/my tools/pelage", cache: None, own: "out/.herd", room };
        let text = build_file(&[&task], &settings);
        for line in [
            "tool = '/opt/my tools/pelage'",
            "build out/my$ fox.pelage | r.json: read my$ fox$$1$:.glb | /opt/my$ tools/pelage",
            "  words = bake 'my fox$$1:.glb' -o 'out/my fox.pelage' --quiet --depfile d.d --record r.json",
        ] {
            assert!(text.lines().any(|found| found == line), "{line}\n{text}");
        }
    }
}
