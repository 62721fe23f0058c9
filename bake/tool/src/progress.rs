//! Progress and remaining time of the current work. Without a terminal, they are printed as occasional lines.

use pelage_bake::progress::{StageProgress, StepCount};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Delay before the first line. Most commands finish earlier.
const FIRST_LINE: Duration = Duration::from_secs(5);
/// Time between two lines.
const NEXT_LINE: Duration = Duration::from_secs(15);

/// Remaining time below which no estimate is shown, seconds. It would be rounded to 0.
const LEAST_LEFT_S: f64 = 0.5;

/// Current work.
#[derive(Debug)]
pub struct Work {
    /// Start of the command.
    since: Instant,
    doing: String,
    /// Start of the current work.
    begun: Instant,
    /// Steps already finished at the start (by an earlier run), finished steps, and total number of steps.
    counted: Option<(u64, u64, u64)>,
    /// Step counters of the stages themselves; used if `counted` is `None`.
    steps: Arc<StageProgress>,
    /// Counter with the most steps left at the start of the current work.
    earlier: Option<StepCount>,
}

impl Work {
    /// Creates the state before any work; `steps` is the step counter that stages increment.
    pub fn new(steps: Arc<StageProgress>) -> Self {
        let now = Instant::now();
        Self { since: now, doing: String::new(), begun: now, counted: None, steps, earlier: None }
    }

    /// Begins work described by `doing`. Its length is unknown until steps are counted.
    pub fn begin(&mut self, doing: &str) {
        (self.doing, self.begun, self.counted) = (doing.to_owned(), Instant::now(), None);
        self.earlier = self.steps.get();
    }

    /// Records that `done` of `total` steps are finished.
    pub fn count(&mut self, done: u64, total: u64, doing: &str) {
        match &mut self.counted {
            Some((_, now, all)) if *all == total => *now = done,
            _ => (self.begun, self.counted) = (Instant::now(), Some((done, done, total))),
        }
        self.doing = doing.to_owned();
    }

    /// Formats the remaining work, such as `, 12 of 64, about 8 s left`; empty without a step count. The time is
    /// omitted until a step is finished, and when less than [`LEAST_LEFT_S`] is left: work that goes on then takes
    /// longer than estimated.
    pub fn left(&self, now: Instant) -> String {
        let Some((first, done, total)) = self.counted.or_else(|| self.stage_count()) else { return String::new() };
        let own = done.saturating_sub(first);
        if own == 0 {
            return format!(", {done} of {total}");
        }
        let rest =
            now.saturating_duration_since(self.begun).as_secs_f64() / own as f64 * (total - done.min(total)) as f64;
        if rest < LEAST_LEFT_S {
            return format!(", {done} of {total}");
        }
        format!(", {done} of {total}, about {} left", span(rest))
    }

    /// Returns the count of the stage that has the most steps left, like `counted`.
    fn stage_count(&self) -> Option<(u64, u64, u64)> {
        let StepCount { stage, done, total } = self.steps.get()?;
        Some((self.earlier.filter(|earlier| earlier.stage == stage).map_or(0, |earlier| earlier.done), done, total))
    }

    /// Formats the progress line, which begins with the time since the start of the command: `20 s: slice, 12 of 64,
    /// about 8 s left`.
    pub fn line(&self, now: Instant) -> String {
        let spent = now.saturating_duration_since(self.since).as_secs_f64();
        format!("{}: {}{}", span(spent), self.doing, self.left(now))
    }
}

/// Formats a duration, such as `8 s` or `12 min`.
pub fn span(seconds: f64) -> String {
    if seconds < 120.0 { format!("{seconds:.0} s") } else { format!("{:.0} min", seconds / 60.0) }
}

/// Thread that prints the progress line after [`FIRST_LINE`] and then every [`NEXT_LINE`]. It ends when this is
/// dropped.
#[derive(Debug)]
pub struct ProgressPrinter {
    /// Sender whose drop ends the thread; it is dropped before the thread is joined.
    end: Option<mpsc::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl ProgressPrinter {
    /// Starts to print the progress lines of `work` with `write`. If the thread cannot be started, nothing is printed.
    pub fn new(work: Arc<Mutex<Work>>, write: fn(&str)) -> Self {
        let (end, ended) = mpsc::channel();
        let tell = move || {
            let mut wait = FIRST_LINE;
            while ended.recv_timeout(wait) == Err(RecvTimeoutError::Timeout) {
                let line = work.lock().unwrap_or_else(PoisonError::into_inner).line(Instant::now());
                write(&format!("{line}\n"));
                wait = NEXT_LINE;
            }
        };
        Self { end: Some(end), thread: std::thread::Builder::new().spawn(tell).ok() }
    }
}

impl Drop for ProgressPrinter {
    fn drop(&mut self) {
        drop(self.end.take());
        if let Some(thread) = self.thread.take() {
            // The thread only prints progress, so a panic in it is ignored.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_line_shows_position_and_remaining_time() {
        let steps = Arc::new(StageProgress::new());
        let mut work = Work::new(steps.clone());
        work.begin("slice");
        work.since = work.begun - Duration::from_secs(3);
        let after = |work: &Work, seconds: u64| work.line(work.begun + Duration::from_secs(seconds));
        assert_eq!(after(&work, 7), "10 s: slice");
        steps.add("slice", 64);
        assert_eq!(after(&work, 7), "10 s: slice, 0 of 64");
        (0..16).for_each(|_| steps.step("slice"));
        assert_eq!(after(&work, 20), "23 s: slice, 16 of 64, about 60 s left");
        assert_eq!(after(&work, 200), "3 min: slice, 16 of 64, about 10 min left");
        (0..47).for_each(|_| steps.step("slice"));
        assert_eq!(after(&work, 30), "33 s: slice, 63 of 64", "less than a second of the estimate is left");
        assert_eq!(after(&work, 300), "5 min: slice, 63 of 64, about 5 s left");
        work.begin("slice, groom");
        assert_eq!(after(&work, 1), "4 s: slice, groom, 63 of 64", "the pace of the step that is left is unknown");
        steps.step("slice");
        assert_eq!(after(&work, 500), "8 min: slice, groom", "the stage goes on after its last step");
        steps.add("ink", 4);
        steps.step("ink");
        assert_eq!(after(&work, 6), "9 s: slice, groom, 1 of 4, about 18 s left", "another stage counts");
    }

    #[test]
    fn resumed_steps_do_not_count_towards_the_estimate() {
        let mut work = Work::new(Arc::new(StageProgress::new()));
        work.count(10, 20, "row 11");
        let after = |work: &Work, seconds: u64| work.left(work.begun + Duration::from_secs(seconds));
        assert_eq!(after(&work, 4), ", 10 of 20");
        work.count(12, 20, "row 13");
        assert_eq!(after(&work, 4), ", 12 of 20, about 16 s left");
    }
}
