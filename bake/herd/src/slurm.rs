//! Slurm jobs of a plan. The plan is divided into stages, and each stage into shards. A stage is an array job, in which
//! each task runs Ninja on the commands of one shard.
//!
//! Starting a Slurm task takes about a second, often as long as a command, so a shard contains several commands. Ninja
//! knows which commands of a shard are done, even after a node failure. No two shards write the same file, and each has
//! its own log.

use super::kind::Kind;
use super::ninja::{STATUS, THREADS};
use super::plan::Plan;
use super::shell::shell_word;
use std::collections::BTreeMap;

/// Stage of a plan. Its shards may run concurrently; the next stage starts when they have finished.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stage {
    /// Name of the stage.
    pub name: &'static str,
    /// Shards, in the order of their numbers.
    pub shards: Vec<Shard>,
}

/// Commands that are run by one task of an array job.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shard {
    /// Number within the stage.
    pub number: usize,
    /// Indices of its tasks in the plan.
    pub tasks: Vec<usize>,
}

/// Shard number of each task in an earlier run, by task name. Ninja's state is kept per shard.
pub type ShardsByTask = BTreeMap<String, usize>;

/// Resources that are requested from Slurm for each shard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Demand {
    /// Memory, MiB: that of the largest command plus half of it, plus 256.
    pub mebibytes: u64,
    /// Time limit, minutes: three times the duration of all commands in sequence, plus five for a slow start.
    pub minutes: u64,
}

/// Names of the stages, in order: models and pictures; parts of divided jobs; results assembled from the parts;
/// benchmarks, each alone on a node.
const STAGES: [&str; 4] = ["models", "parts", "wholes", TIMED];

/// Name of the stage that needs exclusive nodes.
pub const TIMED: &str = "timed";

/// Divides a plan into stages, and each stage into shards of about `seconds` seconds. All commands of a model in a
/// stage are in one shard. A command that is listed in `known` stays in its shard.
pub fn stages(plan: &Plan, seconds: f64, known: &ShardsByTask) -> Vec<Stage> {
    let makers = plan.makers();
    let mut stage_of = vec![0_usize; plan.tasks.len()];
    for (i, task) in plan.tasks.iter().enumerate() {
        let before = task.inputs.iter().filter_map(|input| makers.get(input.as_str()));
        let before = before.map(|maker| stage_of[*maker]).max().unwrap_or(0);
        stage_of[i] = match task.kind {
            Kind::Bench => 3,
            _ if task.part => 1,
            // A result that is assembled from parts belongs to the stage after them.
            _ if before == 1 => 2,
            _ => before,
        };
    }
    let stage = |(number, name): (usize, &'static str)| {
        let mut of_row: BTreeMap<Option<usize>, Vec<usize>> = BTreeMap::new();
        for (i, task) in plan.tasks.iter().enumerate().filter(|(i, _)| stage_of[*i] == number) {
            // Parts of one job go to different shards, so that they run in parallel.
            let row = if number == 1 { Some(plan.rows.len() + i) } else { task.row };
            of_row.entry(row).or_default().push(i);
        }
        let shard_of = |tasks: &[usize]| tasks.iter().find_map(|i| known.get(&plan.tasks[*i].name).copied());
        let mut next = of_row.values().filter_map(|tasks| shard_of(tasks)).max().map_or(0, |last| last + 1);
        let mut shards: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        let mut filled: Option<f64> = None;
        for tasks in of_row.into_values() {
            let shard = shard_of(&tasks).unwrap_or_else(|| {
                let needs: f64 = tasks.iter().map(|i| plan.tasks[*i].expected.seconds).sum();
                if let Some(sum) = filled.filter(|sum| sum + needs <= seconds) {
                    filled = Some(sum + needs);
                } else {
                    (filled, next) = (Some(needs), next + 1);
                }
                next - 1
            });
            shards.entry(shard).or_default().extend(tasks);
        }
        let shards = shards.into_iter().map(|(number, tasks)| Shard { number, tasks });
        Stage { name, shards: shards.collect() }
    };
    STAGES.into_iter().enumerate().map(stage).filter(|stage| !stage.shards.is_empty()).collect()
}

/// Returns the shard number of each task, by task name.
pub fn shards_by_task(plan: &Plan, stages: &[Stage]) -> ShardsByTask {
    let shards = stages.iter().flat_map(|stage| &stage.shards);
    let tasks = shards.flat_map(|shard| shard.tasks.iter().map(|task| (*task, shard.number)));
    tasks.map(|(task, shard)| (plan.tasks[task].name.clone(), shard)).collect()
}

/// Returns the resources for each shard of a stage. They are equal, because all tasks of an array job request the same.
pub fn demand(plan: &Plan, stage: &Stage) -> Demand {
    let expected = |shard: &'_ Shard| shard.tasks.iter().map(|i| plan.tasks[*i].expected).collect::<Vec<_>>();
    let shards: Vec<_> = stage.shards.iter().map(expected).collect();
    let peak = shards.iter().flatten().map(|known| known.peak_bytes).max().unwrap_or(0);
    let seconds = shards.iter().map(|all| all.iter().map(|known| known.seconds).sum()).fold(0.0, f64::max);
    // The margin is needed because many clusters count the page cache as memory.
    Demand { mebibytes: ((peak + peak / 2) >> 20) + 256, minutes: (3.0 * seconds / 60.0).ceil() as u64 + 5 }
}

/// Parameters of a stage's job script.
#[derive(Clone, Copy, Debug)]
pub struct Script<'a> {
    /// Name of the stage.
    pub stage: &'a str,
    /// Absolute working directory of the commands.
    pub folder: &'a str,
    /// Folder of the stage's build files, relative to `folder`. They have names such as `models-0.ninja`.
    pub files: &'a str,
    /// Number of times that failed commands are retried.
    pub retries: u32,
    /// Additional options of `sbatch`.
    pub options: &'a [String],
    /// Resources to request for each task.
    pub demand: Demand,
    /// Whether the stage needs exclusive nodes.
    pub exclusive: bool,
}

impl Script<'_> {
    /// Returns the script of an array job. The task `$SLURM_ARRAY_TASK_ID` runs the build file of that shard.
    pub fn text(&self) -> String {
        let Self { stage, folder, files, retries, options, demand, exclusive } = self;
        let (folder, files) = (shell_word(folder), shell_word(files));
        let threads = THREADS.map(|name| format!("{name}=1")).join(" ");
        let mut head = format!(
            "#!/bin/sh\n\
             #SBATCH --job-name=pelage-{stage}\n\
             #SBATCH --ntasks=1 --cpus-per-task=1 --mem={}M --time={}\n\
             # The shards of a failed node are requeued; files that they have written are kept.\n\
             #SBATCH --requeue --open-mode=append\n",
            demand.mebibytes, demand.minutes
        );
        if *exclusive {
            head += "#SBATCH --exclusive\n";
        }
        for option in *options {
            head += &format!("#SBATCH {option}\n");
        }
        head + &format!(
            "# Written by `pelage herd`. $1: shard numbers separated by commas, one for each task of this array.\n\
             set -u\n\
             cd {folder} || exit 2\n\
             shard=$(echo \"$1\" | cut -d, -f$((SLURM_ARRAY_TASK_ID + 1)))\n\
             export {threads} NINJA_STATUS='{STATUS}'\n\
             unset CLICOLOR_FORCE\n\
             status=1\n\
             for try in $(seq 0 {retries}); do\n\
             \x20   [ \"$try\" = 0 ] || echo \"retrying failed commands, $try of {retries}\"\n\
             \x20   ninja -f {files}/{stage}-$shard.ninja -j 1 -k 0 && status=0 && break\n\
             done\n\
             echo \"$status\" > {files}/{stage}-$shard.done\n\
             exit \"$status\"\n"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::estimate::CommandCost;
    use super::super::plan::Task;
    use super::*;

    fn plan() -> Plan {
        let mut plan = Plan::default();
        let mut add = |kind, row, name: &str, inputs: &[&str], part| {
            let strings = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
            plan.tasks.push(Task {
                kind,
                row: Some(row),
                outputs: vec![name.into()],
                inputs: strings(inputs),
                part,
                expected: CommandCost { seconds: 10.0, peak_bytes: 100 << 20 },
                ..Task::default()
            });
        };
        for row in 0..3 {
            let of = |name: &str| format!("{name}{row}");
            add(Kind::Bake, row, &of("package"), &["model"], false);
            add(Kind::Render, row, &of("picture"), &[&of("package")], false);
            add(Kind::Part, row, &of("part1"), &[&of("package")], true);
            add(Kind::Part, row, &of("part2"), &[&of("package")], true);
            add(Kind::Merge, row, &of("truth"), &[&of("part1"), &of("part2")], false);
            add(Kind::Compare, row, &of("map"), &[&of("picture"), &of("truth")], false);
            add(Kind::Sequence, row, &of("some"), &[&of("package")], true);
            add(Kind::Sequence, row, &of("all"), &[&of("package")], false);
            add(Kind::Bench, row, &of("bench"), &[&of("package")], false);
        }
        plan
    }

    #[test]
    fn stages_wait_for_their_dependencies() {
        let mut plan = plan();
        plan.tasks.iter_mut().enumerate().for_each(|(i, task)| task.name = i.to_string());
        let stages = stages(&plan, 60.0, &ShardsByTask::new());
        let shape: Vec<_> = stages
            .iter()
            .map(|s| (s.name, s.shards.iter().map(|shard| shard.tasks.len()).collect::<Vec<_>>()))
            .collect();
        assert_eq!(shape, [("models", vec![6, 3]), ("parts", vec![6, 3]), ("wholes", vec![6]), ("timed", vec![3])]);
        let mut all: Vec<usize> =
            stages.iter().flat_map(|stage| &stage.shards).flat_map(|shard| shard.tasks.clone()).collect();
        all.sort_unstable();
        assert_eq!(all, (0..plan.tasks.len()).collect::<Vec<_>>());
        // Known commands stay in their shards even if their cost changes; new commands get new shards.
        let known = shards_by_task(&plan, &stages);
        plan.tasks.iter_mut().for_each(|task| task.expected.seconds = 1.0);
        assert_eq!(super::stages(&plan, 60.0, &known), stages);
        let fewer: ShardsByTask =
            known.into_iter().filter(|(name, _)| name != "0" && name != "1" && name != "7").collect();
        let again = super::stages(&plan, 60.0, &fewer);
        assert!(again[0].shards.iter().any(|shard| shard.number == 2 && shard.tasks == [0, 1, 7]), "{again:?}");
        plan.tasks.iter_mut().for_each(|task| task.expected.seconds = 10.0);
        assert_eq!(demand(&plan, &stages[0]), Demand { mebibytes: 406, minutes: 8 });
    }

    #[test]
    fn script_requests_its_memory_and_time() {
        let script = Script {
            stage: "models",
            folder: "/a b",
            files: "out/.herd/slurm",
            retries: 1,
            options: &["--partition=night".into()],
            demand: Demand { mebibytes: 406, minutes: 8 },
            exclusive: true,
        };
        let text = script.text();
        for line in [
            "#SBATCH --ntasks=1 --cpus-per-task=1 --mem=406M --time=8",
            "#SBATCH --partition=night",
            "#SBATCH --exclusive",
            "cd '/a b' || exit 2",
            "export RAYON_NUM_THREADS=1 LP_NUM_THREADS=1 NINJA_STATUS='[%f/%t] '",
            "    ninja -f out/.herd/slurm/models-$shard.ninja -j 1 -k 0 && status=0 && break",
        ] {
            assert!(text.lines().any(|found| found == line), "{line}\n{text}");
        }
    }
}
