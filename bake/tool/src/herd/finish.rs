//! Results of a herd: reads the records, prints a summary and writes the report.

use super::ninja_output::NinjaOutput;
use super::on_disk::{Herd, history_file};
use super::paths::io_error;
use super::result::{HerdFailure, HerdResult, HerdTasks};
use super::saved_state;
use crate::exit::{Exit, Failure};
use crate::job::CommandRecord;
use crate::output::{Output, make_folder};
use image::{DynamicImage, Rgb, RgbImage, imageops};
use pelage_bake::hexadecimal::hex;
use pelage_bake::io;
use pelage_herd::{CommandCost, CommandOutcome, Report, State, Task};
use pelage_import::{BakeError, path_as_uri};
use rayon::prelude::*;
use sha2::{Digest as _, Sha256};
use std::collections::BTreeSet;
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// Longer side of a thumbnail, pixels.
const THUMB: u32 = 224;
/// Number of rows up to which thumbnails are embedded. In larger reports, pictures are loaded as they scroll into view.
const MOST_ROWS: usize = 1000;
/// Background of transparent thumbnails, a grey value 0..=255.
const GREY: u8 = 128;
/// Number of failures that are listed individually.
const TOLD: usize = 20;

fn failures_file(own: &str) -> String {
    format!("{own}/failures.json")
}

/// Returns the file that contains the hash of the report's inputs, in the herd's internal folder.
fn key_file(own: &str) -> String {
    format!("{own}/report.key")
}

/// Marks the report as outdated. It is then rewritten even if this run is interrupted.
pub fn mark_report_outdated(herd: &Herd) -> Result<(), Failure> {
    remove(&herd.path(&key_file(&herd.internal_folder())))
}

fn remove(path: &Path) -> Result<(), Failure> {
    match std::fs::remove_file(path) {
        Err(source) if source.kind() != std::io::ErrorKind::NotFound => Err(io_error(path, "remove", source)),
        _ => Ok(()),
    }
}

/// Returns the record files of the commands that had failed when the report was written.
pub fn failed_before(herd: &Herd) -> Vec<String> {
    saved_state::read(&herd.path(&failures_file(&herd.internal_folder())))
}

/// Removes the records of failed commands, so that no engine considers these commands done.
pub fn forget_failures(herd: &Herd) -> Result<(), Failure> {
    failed_before(herd).iter().try_for_each(|record| remove(&herd.path(record)))
}

fn outcomes(herd: &Herd, ran: &NinjaOutput) -> Result<Vec<Option<CommandOutcome>>, Failure> {
    let read = |record: &str| saved_state::read::<Option<CommandOutcome>>(&herd.path(record));
    let of = |task: &Task| {
        let found = read(&task.record);
        match ran.last_words(task).filter(|_| found.is_none()) {
            Some(last_words) => write_missing_record(herd, task, &last_words).map(|()| read(&task.record)),
            None => Ok(found),
        }
    };
    herd.plan.tasks.par_iter().map(of).collect()
}

/// Writes a record for a command that ended without writing one.
fn write_missing_record(herd: &Herd, task: &Task, last_words: &str) -> Result<(), Failure> {
    let mut why =
        "it ended without a record or a message: probably it was killed, perhaps for lack of memory".to_owned();
    if !last_words.is_empty() {
        why = format!("it ended without a record; its last output was: {last_words}");
    }
    let record = CommandRecord::new(task.command(herd.cache.as_deref()), Exit::FileSystem, Some(why));
    Ok(record.write(&herd.path(&task.record))?)
}

/// Prints the results of a herd, and rewrites its report if anything changed.
pub fn finish(herd: &Herd, ran: &NinjaOutput, output: &mut Output) -> Result<Exit, Failure> {
    let page = herd.path(&format!("{}/report.html", herd.plan.out));
    let own = herd.internal_folder();
    let plan = plan_key(herd)?;
    let key_file = herd.path(&key_file(&own));
    let known = page.is_file() && std::fs::read_to_string(&key_file).is_ok_and(|key| key == plan);
    if ran.tasks.is_empty() && known && failed_before(herd).is_empty() {
        // Reading the records of a large herd takes long, and is unnecessary here: all report success.
        let all = herd.plan.tasks.len();
        let counts = HerdTasks { all, done: all, ..HerdTasks::default() };
        return print_summary(herd, counts, &[], (0, 0), &page, output);
    }
    output.progress("writing the report");
    let became = outcomes(herd, ran)?;
    let report = Report::new(&herd.plan, &became);
    let failures = report.failures();
    let thumbs = Thumbs::new(herd)?;
    let tool = format!("pelage {}", env!("CARGO_PKG_VERSION"));
    let text = report.page(&herd.title, &tool, &|file| thumbs.source(file))?;
    io::write_atomic(&page, text.as_bytes())?;
    thumbs.tidy();
    let mut history = herd.history.clone();
    for (task, became) in herd.plan.tasks.iter().zip(&became) {
        // The time of a cache hit is not the cost of the command.
        if let Some(became) = became.as_ref().filter(|became| became.exit_code == 0 && !became.cached) {
            let peak_bytes = became.peak_bytes.unwrap_or(task.expected.peak_bytes);
            history.insert(task.name.clone(), CommandCost { seconds: became.seconds, peak_bytes });
        }
    }
    let names: BTreeSet<&str> = herd.plan.tasks.iter().map(|task| task.name.as_str()).collect();
    history.retain(|name, _| names.contains(name.as_str()));
    saved_state::write(&herd.path(&history_file(&own)), &history)?;
    let records: Vec<&str> = failures.iter().map(|(i, ..)| herd.plan.tasks[*i].record.as_str()).collect();
    saved_state::write(&herd.path(&failures_file(&own)), &records)?;
    io::write_atomic(&key_file, plan.as_bytes())?;
    let count = |state| report.count(state);
    let counts = HerdTasks {
        all: herd.plan.tasks.len(),
        done: count(State::Done),
        failed: count(State::Failed),
        differ: count(State::Differs),
        missing: count(State::Missing),
    };
    let tasks = herd.plan.tasks.iter().zip(&became);
    let from_cache = |(task, became): &(&Task, &Option<CommandOutcome>)| {
        became.as_ref().is_some_and(|became| became.cached) && ran.tasks.contains(&task.name)
    };
    let ran = (ran.tasks.len(), tasks.filter(from_cache).count());
    print_summary(herd, counts, &failures, ran, &page, output)
}

/// Returns a hash of the parts of the plan that the report shows.
fn plan_key(herd: &Herd) -> Result<String, Failure> {
    let shown: Vec<_> = herd.plan.tasks.iter().map(|task| (&task.name, &task.words)).collect();
    let text = serde_json::to_vec(&(&herd.title, &herd.plan.rows, shown, &herd.tool));
    Ok(hex(&Sha256::digest(text.map_err(|error| BakeError::Internal(error.to_string()))?)))
}

fn print_summary(
    herd: &Herd,
    tasks: HerdTasks,
    failures: &[(usize, u8, String)],
    (ran, cached): (usize, usize),
    page: &Path,
    output: &mut Output,
) -> Result<Exit, Failure> {
    let HerdTasks { all, done, failed, differ, missing } = tasks;
    let mut lines = Vec::new();
    for (i, _, why) in failures.iter().take(TOLD) {
        lines.push(format!("{}: {why}", herd.plan.tasks[*i].name));
    }
    if failures.len() > TOLD {
        lines.push(format!("and {} more, listed in the report", failures.len() - TOLD));
    }
    let mut told = vec![format!("{ran} of {all} commands were run")];
    if cached > 0 {
        told.push(format!("{cached} of them from the cache"));
    }
    told.push(format!("{done} are done"));
    for (number, what) in [(failed, "failed"), (differ, "differ by more than their limit"), (missing, "could not run")]
    {
        if number > 0 {
            told.push(format!("{number} {what}"));
        }
    }
    lines.push(told.join(", "));
    let report = page.display().to_string();
    lines.push(report.clone());
    let failure = |(i, exit, why): &(usize, u8, String)| HerdFailure {
        task: herd.plan.tasks[*i].name.clone(),
        exit_code: *exit,
        message: why.clone(),
    };
    let failures_told = failures.iter().map(failure).collect();
    let models = herd.plan.rows.len();
    let result = HerdResult::Run { report, models, ran, cached, tasks, failures: failures_told };
    output.result(&lines.join("\n"), &result)?;
    // The exit code is that of the first failure. A comparison over its limit counts only if nothing failed.
    let code = failures.first().map_or(if missing > 0 { Exit::FileSystem as u8 } else { 0 }, |(_, exit, _)| *exit);
    Ok(Exit::of(code).unwrap_or(Exit::Internal))
}

/// Thumbnail cache: each picture's thumbnail is made once.
struct Thumbs<'a> {
    herd: &'a Herd,
    folder: PathBuf,
    used: std::sync::Mutex<BTreeSet<String>>,
}

impl<'a> Thumbs<'a> {
    fn new(herd: &'a Herd) -> Result<Self, Failure> {
        let folder = herd.path(&format!("{}/thumbs", herd.internal_folder()));
        make_folder(&folder)?;
        Ok(Self { herd, folder, used: std::sync::Mutex::default() })
    }

    /// Returns the data URL of a thumbnail; `None` if the picture does not exist.
    fn source(&self, file: &str) -> Option<String> {
        let path = self.herd.path(file);
        let found = std::fs::metadata(&path).ok()?;
        if self.herd.plan.rows.len() > MOST_ROWS {
            let inside = self.herd.plan.inside(file);
            return Some(path_as_uri(inside));
        }
        let name = Sha256::digest(format!("{file} {} {:?}", found.len(), found.modified().ok()));
        let name = format!("{}.jpg", &hex(&name)[..32]);
        let kept = self.folder.join(&name);
        let bytes = std::fs::read(&kept).ok().or_else(|| {
            let bytes = small(&path)?;
            // If the thumbnail cannot be stored, it is made again next time.
            let _ = io::write_atomic(&kept, &bytes);
            Some(bytes)
        })?;
        self.used.lock().unwrap_or_else(std::sync::PoisonError::into_inner).insert(name);
        use base64::Engine as _;
        Some(format!("data:image/jpeg;base64,{}", base64::engine::general_purpose::STANDARD.encode(bytes)))
    }

    /// Removes thumbnails of pictures that no longer exist.
    fn tidy(&self) {
        let used = self.used.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        for entry in std::fs::read_dir(&self.folder).into_iter().flatten().flatten() {
            if !used.contains(&*entry.file_name().to_string_lossy()) {
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }
}

/// Returns a picture as a small JPEG, composited over grey.
fn small(path: &Path) -> Option<Vec<u8>> {
    let picture = image::open(path).ok()?;
    let picture = if picture.width().max(picture.height()) > THUMB {
        picture.resize(THUMB, THUMB, imageops::FilterType::Triangle)
    } else {
        picture
    };
    let pixels = picture.to_rgba8();
    let flat = RgbImage::from_fn(pixels.width(), pixels.height(), |x, y| {
        let [r, g, b, alpha] = pixels.get_pixel(x, y).0.map(u32::from);
        let over = |color: u32| ((color * alpha + u32::from(GREY) * (255 - alpha) + 127) / 255) as u8;
        Rgb([over(r), over(g), over(b)])
    });
    let mut bytes = Cursor::new(Vec::new());
    let jpeg = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, 80);
    DynamicImage::ImageRgb8(flat).write_with_encoder(jpeg).ok()?;
    Some(bytes.into_inner())
}
