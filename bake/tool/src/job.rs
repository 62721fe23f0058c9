//! Options of every command for build systems: dependency file, record of the outcome, and cache.

use super::exit::{Exit, Failure};
use super::guard::{DeclaredFiles, OutputFile};
use super::output::{Output, RecordedOutput};
use pelage_bake::cache::{Cache, CacheHit, CachedFile, CommandResult};
use pelage_bake::hexadecimal::hex;
use pelage_bake::io_trace::{self, Digest, IoTrace};
use pelage_bake::{io, io_guard};
use pelage_import::BakeError;
use serde::Serialize;
use serde_json::Value;
use sha2::{Digest as _, Sha256};
use std::ffi::OsString;
use std::fmt::Debug;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Help heading of the options for build systems.
const FARMS: &str = "Builds and farms";

/// Build-system options that every subcommand has.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct JobArgs {
    /// Write a Make rule that lists every file that the command has read, including those named by a model or a scene;
    /// Ninja, Make and CMake read it
    #[arg(long, value_name = "FILE", global = true, help_heading = FARMS, hide_short_help = true)]
    depfile: Option<OutputFile>,
    /// Write the outcome of the command as JSON, also if it fails: command line, exit code, seconds, peak memory, and
    /// result or error
    #[arg(long, value_name = "FILE", global = true, help_heading = FARMS, hide_short_help = true)]
    record: Option<OutputFile>,
    /// Reuse and store results in this cache folder, which may be shared. A result is reused for the same files, tool
    /// and arguments. Applies to bake, render, reference, merge, compare and sky; measurements are never cached
    #[arg(long, value_name = "DIR", global = true, help_heading = FARMS, hide_short_help = true)]
    cache: Option<PathBuf>,
}

impl JobArgs {
    /// Returns the cache folder.
    pub fn cache(&self) -> Option<&Path> {
        self.cache.as_deref()
    }

    fn is_empty(&self) -> bool {
        self.depfile.is_none() && self.record.is_none() && self.cache.is_none()
    }
}

/// Description of a deterministic command, whose outputs can be cached.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Job {
    /// Arguments, except output folders and options that do not affect the outputs.
    arguments: String,
    /// Folders of the output files.
    folders: Vec<PathBuf>,
}

impl Job {
    /// Creates the description of the command named `command`. In `args`, the paths of `outputs` must be reduced to
    /// file names.
    pub fn new(command: &str, args: &impl Debug, outputs: &[&Path]) -> Self {
        let folders = outputs.iter().map(|output| output.parent().unwrap_or(Path::new("")).to_owned()).collect();
        Self { arguments: format!("{command} {args:?}"), folders }
    }

    /// Returns the file name without its folder.
    pub fn name(output: impl AsRef<Path>) -> OutputFile {
        PathBuf::from(output.as_ref().file_name().unwrap_or_default()).into()
    }

    fn key(&self, tool: &Digest) -> Digest {
        Sha256::new().chain_update(tool).chain_update(&self.arguments).finalize().into()
    }

    /// Returns the index of the output folder that contains a file, and the name of the file in it.
    fn place(&self, path: &Path) -> Option<(usize, String)> {
        let folder = self.folders.iter().position(|folder| path.parent() == Some(folder))?;
        Some((folder, path.file_name()?.to_str()?.to_owned()))
    }
}

/// Runs a command, with the cache, dependency file and record that `args` requests.
///
/// * `files`: files on the command line; a command that would overwrite one of its inputs does not run
pub fn run(
    args: &JobArgs,
    files: &DeclaredFiles,
    job: Option<&Job>,
    command: impl FnOnce(&mut Output) -> Result<Exit, Failure>,
    output: &mut Output,
) -> Result<Exit, Failure> {
    let guarded = files.guard().map_err(Failure::from);
    if args.is_empty() {
        return guarded.and_then(|()| command(output));
    }
    let began = Instant::now();
    output.start_recording();
    if let Some(record) = args.record.as_deref().filter(|record| is_record(record)) {
        // The old record is removed first, so that a killed command leaves none. If removal fails, writing the record
        // fails too and reports the error.
        let _ = std::fs::remove_file(record);
    }
    // A depfile or record that cannot be written must not leave a command with its outputs but as a failure.
    let files = [args.depfile.as_deref(), args.record.as_deref()];
    let writable = |()| Ok(files.into_iter().flatten().try_for_each(io::require_writable)?);
    let (mut result, cached) = match guarded.and_then(writable) {
        Ok(()) => run_with_depfile(args, job, command, output),
        Err(failure) => (Err(failure), false),
    };
    if let Some(path) = args.record.as_deref() {
        let recorded = CommandRecord::of(&result, output.said(), began.elapsed().as_secs_f64(), cached).write(path);
        // The command's own error takes precedence over an error of writing the record.
        result = result.and_then(|exit| recorded.map(|()| exit).map_err(Into::into));
    }
    result
}

/// Runs a command, with the cache and dependency file that `args` requests. Also returns whether it was a cache hit.
fn run_with_depfile(
    args: &JobArgs,
    job: Option<&Job>,
    command: impl FnOnce(&mut Output) -> Result<Exit, Failure>,
    output: &mut Output,
) -> (Result<Exit, Failure>, bool) {
    let cache = args.cache.as_deref().zip(job).and_then(|(folder, job)| CacheSession::open(folder, job, output));
    let found = cache.as_ref().and_then(CacheSession::find);
    let cached = found.is_some();
    let (mut result, mut read, written): (_, Vec<PathBuf>, Vec<PathBuf>) = match found {
        Some((CacheHit { kept, read }, files)) => {
            let served = replay(&kept, &files, output);
            (served, read, files.into_iter().map(|(path, _)| path).collect())
        }
        None => {
            io_trace::start();
            let result = command(output);
            let traffic = io_trace::take();
            if let (Some(cache), Ok(exit)) = (&cache, &result) {
                cache.keep(&traffic, *exit, output);
            }
            let read = traffic.files_read().into_iter().map(Path::to_owned).collect();
            (result, read, traffic.written.into_iter().map(|written| written.path).collect())
        }
    };
    if let (Some(path), Ok(_)) = (&args.depfile, &result) {
        // A command does not depend on its own outputs, even if it reads them back.
        read.retain(|path| !written.contains(path));
        // A Make rule needs a target. For a command without outputs, this is the record, or else the depfile itself.
        let targets =
            if written.is_empty() { vec![args.record.as_ref().unwrap_or(path).to_path_buf()] } else { written };
        let rule = make_rule(&targets, &read).map_err(|reason| depfile_error(path, reason));
        if let Err(error) = rule.and_then(|rule| io::write_atomic(path, &rule)) {
            // Without the depfile the outputs would count as up to date for ever.
            targets.iter().for_each(|target| drop(std::fs::remove_file(target)));
            result = Err(error.into());
        }
    }
    (result, cached)
}

/// Maximum size of a record, bytes.
const RECORD_BYTES: u64 = 64 << 20;

/// Whether a file is the record of an earlier command.
fn is_record(path: &Path) -> bool {
    let mut text = Vec::new();
    let read = |file: std::fs::File| file.take(RECORD_BYTES).read_to_end(&mut text);
    let value: Value = match path.is_file().then(|| std::fs::File::open(path).and_then(read)) {
        Some(Ok(_)) => serde_json::from_slice(&text).unwrap_or_default(),
        _ => Value::Null,
    };
    value.get("command").is_some() && value.get("exit_code").is_some()
}

type Files = Vec<(PathBuf, Vec<u8>)>;

/// Access to the cache for one command.
struct CacheSession<'a> {
    cache: Cache,
    job: &'a Job,
    key: Digest,
}

impl<'a> CacheSession<'a> {
    /// Opens the cache. Returns `None` if the tool cannot be identified, because problems of the cache must not make a
    /// command fail.
    fn open(folder: &Path, job: &'a Job, output: &Output) -> Option<Self> {
        let cache = Cache::new(folder);
        let tool = std::env::current_exe().map_err(|error| error.to_string());
        match tool.and_then(|program| cache.tool_hash(&program).map_err(|error| error.to_string())) {
            Ok(tool) => Some(Self { cache, job, key: job.key(&tool) }),
            Err(error) => {
                output.note(&format!("note: --cache: {error}; the cache is not used"));
                None
            }
        }
    }

    /// Looks up the command; returns its cached result, with the paths and contents of the output files.
    fn find(&self) -> Option<(CacheHit, Files)> {
        let found = self.cache.lookup(&self.key, &mut machine_property)?;
        let file =
            |file: &CachedFile| Some((self.job.folders.get(file.folder)?.join(&file.name), self.cache.read(file)?));
        let files = found.kept.files.iter().map(file).collect::<Option<Vec<_>>>()?;
        Some((found, files))
    }

    /// Stores the result and outputs of a command.
    fn keep(&self, traffic: &IoTrace, exit: Exit, output: &Output) {
        let RecordedOutput { result: Some((text, json)), notes } = output.said() else { return };
        let file = |written: &io_trace::TracedOutput| {
            let (folder, name) = self.job.place(&written.path)?;
            Some(CachedFile { folder, name, shown: shown(&written.path), sha256: hex(&written.digest) })
        };
        // Files outside the output folders could not be restored, so such a command is not cached.
        let Some(files) = traffic.written.iter().map(file).collect::<Option<Vec<_>>>() else { return };
        if traffic.in_part {
            return;
        }
        let kept = CommandResult { files, exit: exit as u8, text, json, notes };
        let paths: Vec<&Path> = traffic.written.iter().map(|written| written.path.as_path()).collect();
        if let Err(error) = self.cache.store(&self.key, traffic, &kept, &paths) {
            output.note(&format!("note: --cache: {error}; the result is not cached"));
        }
    }
}

/// Returns a property of this machine, by name, on which a cached result depends.
fn machine_property(what: &str) -> Option<String> {
    match what {
        ADAPTER => pelage_stage::Gpu::describe_adapter().ok(),
        _ => None,
    }
}

/// Name of the property that identifies the graphics adapter.
pub const ADAPTER: &str = "adapter";

fn shown(path: &Path) -> String {
    path.display().to_string()
}

/// Restores a cached result: writes its files, and prints its notes and result.
fn replay(kept: &CommandResult, files: &[(PathBuf, Vec<u8>)], output: &mut Output) -> Result<Exit, Failure> {
    let whole: Vec<(&Path, &[u8])> = files.iter().map(|(path, bytes)| (path.as_path(), bytes.as_slice())).collect();
    io::write_all_atomic(&whole)?;
    kept.notes.iter().for_each(|note| output.note(note));
    let (mut text, mut json) = (kept.text.clone(), kept.json.clone());
    for (file, (path, _)) in kept.files.iter().zip(files) {
        let now = shown(path);
        if now != file.shown {
            text = text.replace(&file.shown, &now);
            rename(&mut json, &file.shown, &now);
        }
    }
    output.result(&text, &json)?;
    Ok(Exit::of(kept.exit).unwrap_or(Exit::Done))
}

fn rename(value: &mut Value, old: &str, new: &str) {
    match value {
        Value::String(text) if text == old => new.clone_into(text),
        Value::Array(values) => values.iter_mut().for_each(|value| rename(value, old, new)),
        Value::Object(fields) => fields.values_mut().for_each(|value| rename(value, old, new)),
        _ => {}
    }
}

/// Record of a command. Every subcommand writes it with `--record`, even if it fails.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CommandRecord {
    command: Vec<String>,
    version: &'static str,
    exit_code: u8,
    seconds: f64,
    /// Peak memory, bytes; null if the system does not report it.
    peak_bytes: Option<u64>,
    /// Whether the result is a cache hit. Its figures are then those of the run that was cached.
    cached: bool,
    /// Result as printed with `--json`; null if the command failed.
    #[cfg_attr(feature = "schema", schemars(with = "Option<serde_json::Map<String, Value>>"))]
    result: Option<Value>,
    error: Option<String>,
    /// Notes printed to stderr.
    notes: Vec<String>,
}

impl CommandRecord {
    /// Creates the record of a command that ended without writing one.
    pub fn new(command: Vec<String>, exit: Exit, error: Option<String>) -> Self {
        Self {
            command,
            version: env!("CARGO_PKG_VERSION"),
            exit_code: exit as u8,
            seconds: 0.0,
            peak_bytes: None,
            cached: false,
            result: None,
            error,
            notes: Vec::new(),
        }
    }

    fn of(result: &Result<Exit, Failure>, said: RecordedOutput, seconds: f64, cached: bool) -> Self {
        let (exit, error) = match result {
            Ok(exit) => (*exit, None),
            Err(failure) => (failure.exit(), Some(failure.to_string())),
        };
        let result = said.result.map(|(_, json)| json);
        Self { seconds, peak_bytes: peak_bytes(), cached, result, notes: said.notes, ..Self::new(words(), exit, error) }
    }

    /// Writes the record to a file, unless the command has read that file.
    pub fn write(&self, path: &Path) -> Result<(), BakeError> {
        let text = serde_json::to_value(self).map_err(|error| BakeError::Internal(error.to_string()))?;
        // Other outputs may be the reason why the command failed, so they are not checked.
        io_guard::check_write_alone(path)?;
        io::rewrite_atomic(path, format!("{text:#}\n").as_bytes())
    }
}

/// Writes a record for a rejected command line, if it contains `--record`. A rejected command line does not say which
/// files are inputs, so no file but an earlier record is replaced.
pub fn record_refusal(why: &str) -> Result<(), BakeError> {
    match record_asked(std::env::args_os()).filter(|path| !path.is_file() || is_record(path)) {
        Some(path) => CommandRecord::new(words(), Exit::Usage, Some(why.to_owned())).write(&path),
        None => Ok(()),
    }
}

/// Returns the arguments of this process.
fn words() -> Vec<String> {
    std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect()
}

/// Returns the value of `--record` in a command line that cannot be parsed. As in clap, a word that looks like an
/// option is not a value.
fn record_asked(words: impl Iterator<Item = OsString>) -> Option<PathBuf> {
    let mut words = words.take_while(|word| word != "--");
    while let Some(word) = words.next() {
        if word == "--record" {
            return words.next().filter(|file| !file.to_string_lossy().starts_with('-')).map(PathBuf::from);
        }
        if let Some(file) = word.to_str().and_then(|word| word.strip_prefix("--record=")) {
            return Some(PathBuf::from(file)).filter(|file| !file.as_os_str().is_empty());
        }
    }
    None
}

/// Returns the peak memory of this process, bytes; `None` if the system does not report it.
fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? << 10)
}

/// Formats a Make rule: the written files depend on the files that were read. Each of the latter also gets an empty
/// rule.
///
/// Fails with the path that cannot be written in a rule.
fn make_rule(written: &[PathBuf], read: &[PathBuf]) -> Result<Vec<u8>, String> {
    let words = |paths: &[PathBuf]| paths.iter().map(|path| make_word(path)).collect::<Result<Vec<_>, _>>();
    let (targets, sources) = (words(written)?, words(read)?);
    let rule = [&targets.join(&b" "[..])[..], b": \\\n  ", &sources.join(&b" \\\n  "[..]), b"\n"].concat();
    // With an empty rule, Make does not fail if the file is deleted, but runs the command again.
    let empty = sources.iter().flat_map(|source| [b"\n", &source[..], b":\n"]).collect::<Vec<_>>().concat();
    Ok([rule, empty].concat())
}

/// Escapes a path for Make and Ninja, which read bytes. Fails for a path that neither can read.
fn make_word(path: &Path) -> Result<Vec<u8>, String> {
    let bytes = path.as_os_str().as_encoded_bytes();
    let unreadable = |byte: &u8| byte.is_ascii_control() || b";|".contains(byte);
    if bytes.iter().any(unreadable) || bytes.ends_with(b"\\") {
        return Err(format!("Make and Ninja cannot read the name {path:?}; expected a name without \\n, \\t, ; and |"));
    }
    let mut word = Vec::new();
    for (at, byte) in bytes.iter().enumerate() {
        match byte {
            // Backslashes before a space are doubled, those before other characters are kept.
            b' ' => {
                let before = bytes[..at].iter().rev().take_while(|byte| **byte == b'\\').count();
                word.extend(std::iter::repeat_n(b'\\', before + 1));
            }
            // A drive of Windows keeps its colon.
            b':' if cfg!(windows) && at == 1 => {}
            b'#' | b':' => word.push(b'\\'),
            b'$' => word.push(b'$'),
            _ => {}
        }
        word.push(*byte);
    }
    Ok(word)
}

fn depfile_error(path: &Path, reason: String) -> BakeError {
    let source = std::io::Error::new(std::io::ErrorKind::InvalidFilename, reason);
    BakeError::Io { path: path.to_owned(), action: "write", source }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn depfile_rule_names_the_inputs() {
        let paths = |names: &[&str]| names.iter().map(PathBuf::from).collect::<Vec<_>>();
        let text = make_rule(&paths(&["out/a b.pelage"]), &paths(&["fox.glb", "skins/$1#.png"])).unwrap();
        let expected = "out/a\\ b.pelage: \\\n  fox.glb \\\n  skins/$$1\\#.png\n\nfox.glb:\n\nskins/$$1\\#.png:\n";
        assert_eq!(String::from_utf8(text).unwrap(), expected);
        for (name, word) in [("a:b", "a\\:b"), ("50%", "50%"), ("a\\ b", "a\\\\\\ b"), ("a\\b", "a\\b")] {
            assert_eq!(make_word(Path::new(name)).unwrap(), word.as_bytes());
        }
        for name in ["a\nb", "a\tb", "a;b", "a|b", "a\\"] {
            assert!(make_word(Path::new(name)).unwrap_err().contains(&format!("{name:?}")));
        }
    }

    #[test]
    fn cache_key_ignores_output_paths() {
        let job = |folder: &str, n: u8| Job::new("bake", &n, &[&PathBuf::from(folder).join("a.pelage")]);
        let key = |job: &Job, tool: u8| job.key(&[tool; 32]);
        let (here, there, other) = (job("here", 1), job("there", 1), job("here", 2));
        assert_eq!(key(&here, 1), key(&there, 1));
        assert_ne!(key(&here, 1), key(&other, 1));
        assert_ne!(key(&here, 1), key(&here, 2));
        assert_eq!(here.place(Path::new("here/b.png")), Some((0, "b.png".into())));
        assert_eq!(here.place(Path::new("there/b.png")), None);
    }

    #[test]
    fn cached_results_are_printed_with_current_paths() {
        let mut value = json!({ "output": "a/x.png", "all": ["a/x.png", "a/x.png2"], "n": 1 });
        rename(&mut value, "a/x.png", "b/x.png");
        assert_eq!(value, json!({ "output": "b/x.png", "all": ["b/x.png", "a/x.png2"], "n": 1 }));
    }

    #[test]
    fn record_option_is_found_in_invalid_command_lines() {
        let asked = |line: &str| record_asked(line.split(' ').map(OsString::from));
        for line in ["pelage bake --record r.json --odd", "pelage --record=r.json", "pelage x y --record r.json"] {
            assert_eq!(asked(line).as_deref(), Some(Path::new("r.json")), "{line}");
        }
        for line in [
            "pelage",
            "pelage --records r.json",
            "pelage bake --record",
            "pelage -- --record r.json",
            "pelage --record=",
            "pelage bake --record --json",
        ] {
            assert_eq!(asked(line), None, "{line}");
        }
    }

    #[test]
    fn peak_memory_of_the_process_is_known() {
        assert!(!cfg!(target_os = "linux") || peak_bytes().is_some_and(|bytes| bytes > 1 << 20));
    }
}
