//! HTML report of a herd's results, on one page.

use super::kind::Kind;
use super::plan::{Plan, Row, Task};
use pelage_import::BakeError;
use rayon::prelude::*;
use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// Template of the page, with placeholders for its data.
const PAGE: &str = include_str!("report.html");

/// Outcome of a command, read from its record.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct CommandOutcome {
    /// Exit code.
    pub exit_code: u8,
    /// Wall-clock time, seconds.
    pub seconds: f64,
    /// Peak memory, bytes; `None` where the system does not report it.
    pub peak_bytes: Option<u64>,
    /// Whether the result is a cache hit.
    #[serde(default)]
    pub cached: bool,
    /// JSON result of the command.
    #[serde(default)]
    pub result: Value,
    /// Error message if the command failed.
    pub error: Option<String>,
}

/// Exit code of a comparison that exceeds its limit.
const DIFFERENT: u8 = 7;

/// State of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// The command succeeded.
    Done,
    /// The comparison exceeded its limit.
    Differs,
    /// The command failed.
    Failed,
    /// The command was not run, because a task that it depends on failed.
    Missing,
}

/// Outcomes of all tasks of a plan.
#[derive(Clone, Debug)]
pub struct Report<'a> {
    plan: &'a Plan,
    became: &'a [Option<CommandOutcome>],
    /// State of each task, in the order of the plan.
    pub states: Vec<State>,
}

impl<'a> Report<'a> {
    /// Computes the states of all tasks from `became`: outcomes in the order of the plan, `None` for a task without a
    /// record.
    pub fn new(plan: &'a Plan, became: &'a [Option<CommandOutcome>]) -> Self {
        let mut broken: BTreeSet<&str> = BTreeSet::new();
        let mut states = Vec::new();
        for (task, became) in plan.tasks.iter().zip(became) {
            let state = match became {
                // Outputs of a task with missing inputs are left over from an earlier run.
                _ if task.inputs.iter().any(|input| broken.contains(input.as_str())) => State::Missing,
                None => State::Missing,
                Some(CommandOutcome { exit_code: 0, .. }) => State::Done,
                Some(CommandOutcome { exit_code: DIFFERENT, .. }) => State::Differs,
                Some(_) => State::Failed,
            };
            if matches!(state, State::Failed | State::Missing) {
                broken.extend(task.outputs.iter().map(String::as_str));
            }
            states.push(state);
        }
        Self { plan, became, states }
    }

    /// Returns the number of tasks in a state.
    pub fn count(&self, state: State) -> usize {
        self.states.iter().filter(|found| **found == state).count()
    }

    /// Returns the index, exit code and reason of each failed task, then of each comparison that exceeded its limit.
    pub fn failures(&self) -> Vec<(usize, u8, String)> {
        let of = |state: State| {
            let tasks = self.states.iter().enumerate().filter(move |(_, found)| **found == state);
            tasks.map(|(i, _)| {
                let became = self.became[i].as_ref();
                (i, became.map_or(0, |became| became.exit_code), failure_reason(&self.plan.tasks[i], became))
            })
        };
        of(State::Failed).chain(of(State::Differs)).collect()
    }

    /// Returns the HTML page.
    ///
    /// * `title`: title of the report
    /// * `tool`: name and version of the tool
    /// * `picture`: returns a thumbnail as a data URL, `data:image/jpeg;base64,…`; `None` if the picture does not exist
    ///
    /// Fails with [`BakeError::Internal`] if the data cannot be serialized.
    pub fn page(
        &self,
        title: &str,
        tool: &str,
        picture: &(dyn Fn(&str) -> Option<String> + Sync),
    ) -> Result<String, BakeError> {
        let mut of_row: Vec<Vec<usize>> = vec![Vec::new(); self.plan.rows.len()];
        for (i, task) in self.plan.tasks.iter().enumerate() {
            if let Some(row) = task.row {
                of_row[row].push(i);
            }
        }
        let mut failures: Vec<Vec<(usize, u8, String)>> = vec![Vec::new(); self.plan.rows.len()];
        for failure in self.failures() {
            if let Some(row) = self.plan.tasks[failure.0].row {
                failures[row].push(failure);
            }
        }
        let rows = self.plan.rows.par_iter().zip(&of_row).zip(&failures);
        let rows: Vec<Value> =
            rows.map(|((row, tasks), failures)| RowData { report: self, tasks, failures, picture }.row(row)).collect();
        let mut views: Vec<&str> = Vec::new();
        for task in self.plan.tasks.iter().filter(|task| task.kind == Kind::Render) {
            views.extend(task.view.as_deref().filter(|view| !views.contains(view)));
        }
        let adapter = self.became.iter().flatten().find_map(|became| became.result["adapter"].as_str());
        let data = json!({
            "title": title,
            "tool": tool,
            "adapter": adapter,
            "tasks": {
                "done": self.count(State::Done),
                "failed": self.count(State::Failed),
                "differ": self.count(State::Differs),
                "missing": self.count(State::Missing),
            },
            "views": views,
            "rows": rows,
            "charts": self.charts(),
            "sequences": self.sequences(picture),
        });
        let data = serde_json::to_string(&data).map_err(|error| BakeError::Internal(error.to_string()))?;
        // Escapes `<`: a `</script>` in the data would end the script element.
        let page = PAGE.replace("__HERD_TITLE__", &escape_html(title));
        Ok(page.replace("__HERD_DATA__", &data.replace('<', "\\u003c")))
    }

    fn row_name(&self, task: &Task) -> Option<String> {
        task.row.map(|row| row_title(&self.plan.rows[row]))
    }

    fn charts(&self) -> Vec<Value> {
        let charts = self.plan.tasks.iter().zip(&self.states);
        let charts = charts.filter(|(task, state)| task.kind == Kind::Chart && **state == State::Done);
        let of = |(task, _): (&Task, &State)| {
            let file = |extension: &str| task.outputs.iter().find(|output| output.ends_with(extension));
            let place = |extension: &str| file(extension).map(|output| self.plan.inside(output));
            json!({ "name": task.view, "model": self.row_name(task), "file": place(".svg"), "table": place(".csv") })
        };
        charts.map(of).collect()
    }

    fn sequences(&self, picture: &(dyn Fn(&str) -> Option<String> + Sync)) -> Vec<Value> {
        let mut all: Vec<(String, Value, u64)> = Vec::new();
        for (task, state) in self.plan.tasks.iter().zip(&self.states) {
            if task.kind != Kind::Sequence || *state != State::Done {
                continue;
            }
            let Some(first) = task.outputs.first() else { continue };
            let folder = first.rsplit_once('/').map_or("", |(folder, _)| folder);
            let pattern = self.plan.inside(&format!("{folder}/%04d.png")).to_owned();
            let count = task.outputs.len() as u64;
            if let Some((_, _, pictures)) = all.iter_mut().find(|(known, ..)| *known == pattern) {
                *pictures += count;
                continue;
            }
            let thumb = picture(first).map(|src| json!({ "src": src, "file": self.plan.inside(first) }));
            let data = json!({ "name": task.view, "model": self.row_name(task), "first": thumb, "pattern": pattern });
            all.push((pattern, data, count));
        }
        let counted = |(_, mut data, pictures): (String, Value, u64)| {
            data["pictures"] = pictures.into();
            data
        };
        all.into_iter().map(counted).collect()
    }
}

/// Returns the model's name and, if any, its variant, separated by a dot.
fn row_title(row: &Row) -> String {
    row.variant.as_ref().map_or_else(|| row.name.clone(), |variant| format!("{}.{variant}", row.name))
}

fn failure_reason(task: &Task, became: Option<&CommandOutcome>) -> String {
    let Some(became) = became else { return "the command left no record".into() };
    if let Some(error) = &became.error {
        return error.clone();
    }
    let limits = became.result["limits"].as_array().into_iter().flatten().filter(|limit| limit["exceeded"] == true);
    let limits: Vec<String> = limits
        .map(|limit| {
            let figure = |key: &str| limit[key].as_f64().map_or_else(|| "none".into(), |x| format!("{x:.5}"));
            format!("found {}, {} {}", figure("found"), limit["option"].as_str().unwrap_or("limit"), figure("bound"))
        })
        .collect();
    if limits.is_empty() {
        format!("{} ended with exit code {}", task.name, became.exit_code)
    } else {
        limits.join("; ")
    }
}

fn escape_html(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// Builder of the JSON data of a row.
struct RowData<'a, 'r> {
    report: &'r Report<'a>,
    tasks: &'r [usize],
    failures: &'r [(usize, u8, String)],
    picture: &'r (dyn Fn(&str) -> Option<String> + Sync),
}

impl RowData<'_, '_> {
    fn of(&self, kind: Kind, view: Option<&str>) -> Option<(&Task, &CommandOutcome)> {
        let report = self.report;
        let tasks = self.tasks.iter().map(|i| (&report.plan.tasks[*i], report.states[*i], &report.became[*i]));
        let mut tasks = tasks.filter(|(task, state, _)| {
            task.kind == kind && task.view.as_deref() == view && matches!(state, State::Done | State::Differs)
        });
        tasks.next().and_then(|(task, _, became)| Some((task, became.as_ref()?)))
    }

    fn thumb(&self, task: Option<&Task>) -> Value {
        let file = task.and_then(|task| task.outputs.first());
        let thumb = file.and_then(|file| Some((file, (self.picture)(file)?)));
        thumb.map_or(Value::Null, |(file, src)| json!({ "src": src, "file": self.report.plan.inside(file) }))
    }

    fn row(&self, row: &Row) -> Value {
        let report = self.report;
        let states = || self.tasks.iter().map(|i| report.states[*i]);
        let bake = self.of(Kind::Bake, None).map(|(_, became)| became);
        let inspect = self.of(Kind::Inspect, None).map(|(_, became)| &became.result);
        let warnings = bake.map_or(Value::Null, |bake| bake.result["warnings"].clone());
        let warned = warnings.as_array().is_some_and(|warnings| !warnings.is_empty());
        let state = if states().any(|state| state == State::Failed) {
            "failed"
        } else if states().any(|state| state == State::Differs) {
            "differs"
        } else if warned {
            "warned"
        } else {
            "done"
        };
        let failures = self.failures.iter();
        let failures: Vec<Value> = failures
            .map(|(i, exit, message)| {
                let task = &report.plan.tasks[*i];
                json!({
                    "task": task.name,
                    "command": super::shell::shell_line(&task.command(None)),
                    "exit": exit,
                    "message": message,
                })
            })
            .collect();
        let package = bake.map(|bake| {
            let figure = |key: &str| inspect.map_or(Value::Null, |inspect| inspect[key].clone());
            json!({
                "file": report.plan.inside(&row.package),
                "bytes": bake.result["bytes"],
                "gpu_bytes": figure("gpu_bytes"),
                "triangles": figure("triangles"),
                "layers": figure("layers"),
                "seconds": bake.seconds,
                "peak_bytes": bake.peak_bytes,
            })
        });
        json!({
            "name": row.name,
            "variant": row.variant,
            "model": row.model,
            "recipe": row.recipe,
            "state": state,
            "failures": failures,
            "warnings": if warned { warnings } else { json!([]) },
            "package": package,
            "views": self.views(),
            "levels": inspect.map_or_else(Vec::new, levels),
        })
    }

    fn views(&self) -> Vec<Value> {
        let names = self.tasks.iter().map(|i| &self.report.plan.tasks[*i]).filter(|task| task.kind == Kind::Render);
        let of = |task: &Task| {
            let view = task.view.as_deref();
            let traced = self.of(Kind::Truth, view).or_else(|| self.of(Kind::Merge, view));
            let compared = self.of(Kind::Compare, view);
            let found = compared.map(|(_, became)| &became.result);
            let limit = found.and_then(|found| found["limits"].get(0)).map(|limit| limit["bound"].clone());
            let timed = self.of(Kind::Bench, view).map(|(_, became)| became.result["frame_ms"]["median"].clone());
            json!({
                "view": view,
                "picture": self.thumb(self.of(Kind::Render, view).map(|(task, _)| task)),
                "truth": self.thumb(traced.map(|(task, _)| task)),
                "difference": self.thumb(compared.map(|(task, _)| task)),
                "flip": found.map(|found| found["flip"]["mean"].clone()),
                "limit": limit,
                "milliseconds": timed,
                "truth_seconds": traced.map(|_| self.truth_seconds(view)),
            })
        };
        names.map(of).collect()
    }

    /// Returns the time to trace a reference image, the sum over its parts, seconds.
    fn truth_seconds(&self, view: Option<&str>) -> f64 {
        let tasks = self.tasks.iter().filter(|i| {
            let task = &self.report.plan.tasks[**i];
            matches!(task.kind, Kind::Truth | Kind::Part | Kind::Merge) && task.view.as_deref() == view
        });
        tasks.filter_map(|i| self.report.became[*i].as_ref()).map(|became| became.seconds).sum()
    }
}

fn levels(inspect: &Value) -> Vec<Value> {
    let what = |level: &Value| match level["step"].as_u64().unwrap_or(0) {
        0 => "the far layer alone".to_owned(),
        1 => "every layer".to_owned(),
        step => format!("one layer in {step}"),
    };
    let levels = inspect["detail"].as_array().into_iter().flatten();
    let of = |level: &Value| {
        json!({
            "what": what(level),
            "full_px": level["full_px"],
            "gone_px": level["gone_px"],
            "fins": level["fins"],
        })
    };
    levels.map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn became(exit_code: u8, result: Value) -> Option<CommandOutcome> {
        let error = (exit_code == 3).then(|| "fox.glb: byte 0: </script> is no model".to_owned());
        Some(CommandOutcome { exit_code, seconds: 1.5, result, error, ..CommandOutcome::default() })
    }

    fn plan() -> Plan {
        let mut plan = Plan { out: "out".into(), ..Plan::default() };
        for (row, name) in ["fox", "wolf"].into_iter().enumerate() {
            let of = |name: &str| vec![format!("out/{name}{row}")];
            let task = |kind, inputs: Vec<String>, outputs: Vec<String>| Task {
                kind,
                name: format!("{kind:?} {name}"),
                row: Some(row),
                view: (kind != Kind::Bake).then(|| "front".to_owned()),
                inputs,
                outputs,
                ..Task::default()
            };
            plan.tasks.push(task(Kind::Bake, Vec::new(), of("package")));
            plan.tasks.push(task(Kind::Render, of("package"), of("picture")));
            plan.tasks.push(task(Kind::Truth, of("package"), of("truth")));
            plan.tasks.push(task(Kind::Compare, [of("picture"), of("truth")].concat(), of("map")));
            plan.rows.push(Row { name: name.into(), package: format!("out/package{row}"), ..Row::default() });
        }
        plan
    }

    #[test]
    fn failures_are_reported_and_their_dependents_are_missing() {
        let plan = plan();
        let flip = json!({
            "flip": { "mean": 0.25 },
            "limits": [{ "option": "--max-flip", "bound": 0.1, "found": 0.25, "exceeded": true }],
        });
        let baked = json!({ "bytes": 7, "warnings": ["odd"] });
        let fox = [became(0, baked), became(0, json!({ "adapter": "a" })), became(0, json!({})), became(7, flip)];
        // The bake of the wolf failed, so the records of its pictures are left over from an earlier run.
        let wolf = [became(3, Value::Null), became(0, json!({})), became(0, json!({})), None];
        let all: Vec<_> = fox.into_iter().chain(wolf).collect();
        let report = Report::new(&plan, &all);
        use State::{Differs, Done, Failed, Missing};
        assert_eq!(report.states, [Done, Done, Done, Differs, Failed, Missing, Missing, Missing]);
        let told = report.failures();
        assert_eq!(told[0], (4, 3, "fox.glb: byte 0: </script> is no model".into()));
        assert_eq!(told[1], (3, 7, "found 0.25000, --max-flip 0.10000".into()));
        let page = report.page("a <herd>", "pelage", &|file| Some(format!("data:{file}"))).unwrap();
        assert!(page.contains("<title>a &lt;herd&gt;") && !page.contains("__HERD"));
        assert!(!page.contains("</script> is no model"), "an error message must not end the script element");
        let data = page.split("id=\"data\">").nth(1).and_then(|rest| rest.split("</script>").next()).unwrap();
        let data: Value = serde_json::from_str(data).unwrap();
        let states: Vec<_> = data["rows"].as_array().unwrap().iter().map(|row| row["state"].clone()).collect();
        assert_eq!(states, ["differs", "failed"]);
        let view = &data["rows"][0]["views"][0];
        assert_eq!((&view["flip"], &view["limit"]), (&json!(0.25), &json!(0.1)));
        assert_eq!(view["picture"], json!({ "src": "data:out/picture0", "file": "picture0" }));
        assert_eq!(data["rows"][1]["views"][0]["picture"], Value::Null, "pictures of an earlier run are not shown");
        assert_eq!((&data["adapter"], &data["tasks"]["missing"]), (&json!("a"), &json!(3)));
    }
}
