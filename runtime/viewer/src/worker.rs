//! Two background threads of the window. One makes the content, and makes it again whenever its files change. The other
//! traces the reference image.

use crate::watch::Watch;
use crate::workshop::{
    Outcome, Progress, ReferencePicture, ReferenceRequest, ReferenceSource, WindowContent, Workshop,
};
use std::ops::ControlFlow;
use std::panic::AssertUnwindSafe;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Message from a thread to the window.
pub enum WorkerMessage {
    /// Content is being made.
    Working(Progress),
    /// Content is ready; includes the time that it took.
    Made(Box<WindowContent>, Duration),
    /// Content cannot be made; includes the reason.
    Failed(String),
    /// Result of writing a recipe.
    Saved(Outcome<PathBuf>),
    /// Progress of the reference image.
    Tracing(Progress),
    /// Reference image with more samples than the previous one.
    Truth(Box<ReferencePicture>),
    /// The reference image cannot be traced; includes the reason.
    NoTruth(String),
}

/// Request of the window to the thread that makes content.
enum MakeRequest {
    Open(PathBuf),
    /// Make the content with these edits of the recipe (`key=value`).
    Make(Vec<String>),
    /// A file of the content has changed.
    Changed,
    Save(Vec<String>),
}

/// Callback that sends a message to the window and wakes it.
pub type SendMessage = Arc<dyn Fn(WorkerMessage) + Send + Sync>;

/// Handles of the threads; dropping them ends the threads.
pub struct Workers {
    make: Sender<MakeRequest>,
    trace: Sender<(u64, ReferenceRequest)>,
    /// Number of the current reference request; tracing with other numbers is cancelled.
    wanted: Arc<AtomicU64>,
}

impl Workers {
    /// Starts both threads. If files cannot be watched, a message says so and everything else works.
    pub fn start(workshop: Box<dyn Workshop>, tell: &SendMessage) -> Self {
        let (make, asked) = channel();
        let (trace, truths) = channel();
        let wanted = Arc::new(AtomicU64::new(0));
        let judge = workshop.reference_source();
        let (changes, tell_made) = (make.clone(), tell.clone());
        std::thread::spawn(move || make_all(workshop, &asked, changes, &tell_made));
        let (tell, number) = (tell.clone(), wanted.clone());
        std::thread::spawn(move || trace_all(judge, &truths, &number, &tell));
        Self { make, trace, wanted }
    }

    /// Opens a file and makes its content.
    pub fn open(&self, path: PathBuf) {
        self.ask(MakeRequest::Open(path));
    }

    /// Makes the opened content with these edits of its recipe. Of several pending requests only the last is processed.
    pub fn make(&self, edits: Vec<String>) {
        self.ask(MakeRequest::Make(edits));
    }

    /// Writes the recipe with these edits.
    pub fn save(&self, edits: Vec<String>) {
        self.ask(MakeRequest::Save(edits));
    }

    /// Traces a reference image, and cancels the previous one.
    pub fn trace(&self, asked: ReferenceRequest) {
        let number = self.wanted.fetch_add(1, Ordering::Relaxed) + 1;
        // If the thread has ended, it has already reported the reason.
        let _ = self.trace.send((number, asked));
    }

    /// Cancels tracing.
    pub fn stop_tracing(&self) {
        self.wanted.fetch_add(1, Ordering::Relaxed);
    }

    fn ask(&self, asked: MakeRequest) {
        // If the thread has ended, it has already reported the reason.
        let _ = self.make.send(asked);
    }
}

impl Drop for Workers {
    fn drop(&mut self) {
        self.stop_tracing();
    }
}

fn make_all(
    mut workshop: Box<dyn Workshop>,
    asked: &Receiver<MakeRequest>,
    changes: Sender<MakeRequest>,
    tell: &SendMessage,
) {
    let changes = Mutex::new(changes);
    let changed = move || drop(changes.lock().unwrap_or_else(PoisonError::into_inner).send(MakeRequest::Changed));
    let mut watch = Watch::new(changed);
    let mut edits = Vec::new();
    while let Ok(first) = asked.recv() {
        let mut make = false;
        // Drains all pending requests, because a dragged slider sends them faster than content can be made.
        for asked in std::iter::once(first).chain(asked.try_iter().collect::<Vec<_>>()) {
            match asked {
                MakeRequest::Open(path) => match workshop.open(&path) {
                    Ok(()) => (edits, make) = (Vec::new(), true),
                    Err(reason) => tell(WorkerMessage::Failed(reason)),
                },
                MakeRequest::Make(changed) => (edits, make) = (changed, true),
                MakeRequest::Changed => make = true,
                MakeRequest::Save(changed) => {
                    let saved = workshop.save_recipe(&changed);
                    if saved.is_ok() {
                        // The file now contains the edits, so they are cleared.
                        (edits, make) = (Vec::new(), true);
                    }
                    tell(WorkerMessage::Saved(saved));
                }
            }
        }
        if !make {
            continue;
        }
        let began = Instant::now();
        let made = caught(|| workshop.make(&edits, &mut |progress| tell(WorkerMessage::Working(progress))));
        watch.set(&workshop.files());
        tell(match made {
            Ok(made) => WorkerMessage::Made(Box::new(made), began.elapsed()),
            Err(reason) => WorkerMessage::Failed(reason),
        });
    }
}

/// Returns the result of `work`. Converts a panic to an error, so that the window continues.
fn caught<T>(work: impl FnOnce() -> Outcome<T>) -> Outcome<T> {
    let failed = |_| Err("internal error in pelage; the terminal has the details".into());
    std::panic::catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(failed)
}

fn trace_all(
    mut judge: Box<dyn ReferenceSource>,
    asked: &Receiver<(u64, ReferenceRequest)>,
    wanted: &AtomicU64,
    tell: &SendMessage,
) {
    while let Ok((number, truth)) = asked.recv() {
        let is_wanted = || wanted.load(Ordering::Relaxed) == number;
        if !is_wanted() {
            continue;
        }
        let mut show = |truth| {
            if is_wanted() {
                tell(WorkerMessage::Truth(Box::new(truth)));
            }
        };
        let mut progress = |progress| {
            if !is_wanted() {
                return ControlFlow::Break(());
            }
            tell(WorkerMessage::Tracing(progress));
            ControlFlow::Continue(())
        };
        if let Err(reason) = caught(|| judge.trace(&truth, &mut show, &mut progress)) {
            tell(WorkerMessage::NoTruth(reason));
        }
    }
}

#[cfg(test)]
#[path = "worker_tests.rs"]
mod tests;
