//! Output of `render`: one file, numbered files, or a video.

use super::exit::Failure;
use super::journal::{Entry, Journal, Key};
use super::output::{Output, make_folder, require_parent};
use super::picture_series::{Picture, PictureSeries, write_png};
use super::view_args::Frames;
use pelage_bake::hexadecimal::hex;
use pelage_bake::io::{write_atomic, write_atomic_with};
use pelage_bake::y4m::Y4m;
use pelage_bake::{io_guard, io_trace, picture};
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::io::{self, BufWriter, IsTerminal as _, Write};
use std::path::{Path, PathBuf};

/// Background of videos whose look has none, because Y4M has no transparency.
const WHITE: [u8; 3] = [255; 3];

/// Destination of the drawn pictures.
#[derive(Clone, Debug, PartialEq)]
pub enum Sink {
    /// Single picture.
    Picture(PathBuf),
    /// Vector picture of a painting, SVG.
    Curves(PathBuf),
    /// Numbered pictures, with the journal of an interrupted run beside them.
    Numbered {
        /// Number of the first picture.
        first: usize,
        names: Vec<PathBuf>,
        journal: PathBuf,
    },
    /// Y4M file.
    Video(PathBuf),
    /// Y4M on stdout.
    Stdout,
}

/// Result of [`Sink::fill`].
#[derive(Debug)]
pub struct DrawnPictures {
    /// Measurements of each picture.
    pub pictures: Vec<Picture>,
    /// Number of pictures kept from an earlier run.
    pub skipped: usize,
}

impl Sink {
    /// Chooses the destination from the output name `-o`.
    ///
    /// * `frames`: value of `--frames`
    /// * `sequence`: number of pictures in the scene file's sequence; applies to numbered pictures and videos
    pub fn new(output: &Path, frames: Option<Frames>, sequence: Option<u32>) -> Result<Self, Failure> {
        let video = output == Path::new("-") || is_video(output);
        if video && frames.is_some_and(|frames| frames.count().is_none()) {
            let expected = "expected a name with %04d for a range of --frames";
            return Err(Failure::Usage(format!("-o {}: a video holds all pictures, {expected}", output.display())));
        }
        if output == Path::new("-") {
            return Ok(Self::Stdout);
        }
        if is_video(output) {
            require_parent(output)?;
            return Ok(Self::Video(output.to_owned()));
        }
        if output.extension().is_some_and(|e| e.eq_ignore_ascii_case("svg")) {
            if frames.is_some() {
                let text = "is one picture, expected a name that ends in .png or .y4m for --frames";
                return Err(Failure::Usage(format!("-o {}: {text}", output.display())));
            }
            require_parent(output)?;
            return Ok(Self::Curves(output.to_owned()));
        }
        // Pictures are always PNG; programs could not open them with another extension.
        if let Some(other) = output.extension().filter(|e| !e.eq_ignore_ascii_case("png")) {
            let other = other.to_string_lossy();
            return Err(Failure::Usage(format!(
                "-o {}: .{other} is not supported, expected a name that ends in .png, .svg or .y4m",
                output.display()
            )));
        }
        let pattern = output.to_string_lossy().contains('%');
        let Some(frames) = frames.or(sequence.filter(|_| pattern).map(Frames::all)) else {
            require_parent(output)?;
            return Ok(Self::Picture(output.to_owned()));
        };
        let names = names(output, frames)?;
        let mut journal = output.as_os_str().to_owned();
        // Several machines may draw ranges of a sequence into the same folder, so each range has its own journal.
        if frames.count().is_none() {
            journal.push(format!(".{}-{}", frames.first, frames.end));
        }
        journal.push(".pictures.jsonl");
        Ok(Self::Numbered { first: frames.first as usize, names, journal: journal.into() })
    }

    /// Returns true for numbered pictures and videos.
    pub fn is_sequence(&self) -> bool {
        !matches!(self, Self::Picture(_) | Self::Curves(_))
    }

    /// Returns the names of the files that will be written.
    pub fn files(&self) -> Vec<String> {
        let display = |path: &PathBuf| path.display().to_string();
        match self {
            Self::Picture(path) | Self::Curves(path) | Self::Video(path) => vec![display(path)],
            Self::Numbered { names, .. } => names.iter().map(display).collect(),
            Self::Stdout => Vec::new(),
        }
    }

    /// Draws all pictures and writes them.
    ///
    /// * `key`: hash of everything that the pictures depend on, for numbered pictures
    /// * `restart`: redraws pictures that an earlier run has left
    pub fn fill(
        &self,
        shoot: &mut PictureSeries,
        key: Key,
        restart: bool,
        output: &mut Output,
    ) -> Result<DrawnPictures, Failure> {
        let pictures = match self {
            Self::Picture(path) => {
                vec![shoot.picture(0, output).and_then(|(p, pixels)| write_png(path, &pixels).and(Ok(p)))?]
            }
            Self::Curves(path) => {
                let (picture, text) = shoot.curves(output)?;
                write_atomic(path, text.as_bytes())?;
                vec![picture]
            }
            Self::Numbered { first, names, journal } => {
                return numbered((*first, names), journal, shoot, key, restart, output);
            }
            Self::Video(path) => video(path, shoot, output)?,
            Self::Stdout => {
                if io::stdout().is_terminal() {
                    let expected = "expected a pipe, such as | ffmpeg -i - walk.mp4";
                    return Err(Failure::Usage(format!("-o -: standard output is a terminal; {expected}")));
                }
                film(&mut BufWriter::new(io::stdout().lock()), shoot, output)?
            }
        };
        Ok(DrawnPictures { pictures, skipped: 0 })
    }
}

/// Entry of the journal for a picture of a numbered sequence.
#[derive(Debug, Serialize, Deserialize)]
struct JournalEntry {
    picture: usize,
    /// SHA-256 of the file, hexadecimal. The picture is redrawn if its file has changed.
    sha256: String,
    #[serde(flatten)]
    drawn: Picture,
}

impl Entry for JournalEntry {
    fn number(&self) -> usize {
        self.picture
    }
}

fn is_video(output: &Path) -> bool {
    output.extension().is_some_and(|e| e.eq_ignore_ascii_case("y4m"))
}

fn numbered(
    (first, names): (usize, &[PathBuf]),
    journal: &Path,
    shoot: &mut PictureSeries,
    key: Key,
    restart: bool,
    output: &mut Output,
) -> Result<DrawnPictures, Failure> {
    // The pattern may name one folder for all pictures, or a folder per picture.
    for folder in names.iter().chain([&journal.to_owned()]).filter_map(|name| name.parent()) {
        if !folder.as_os_str().is_empty() && !folder.is_dir() {
            make_folder(folder)?;
        }
    }
    names.iter().try_for_each(|name| io_guard::check_write(name))?;
    let mut journal = Journal::<JournalEntry>::open(journal.to_owned(), &key.finish(), restart)?;
    if journal.others() > 0 {
        let what = "scene, view, tool or adapter have changed";
        output.note(&format!("pictures to draw again: {}, because {what}", journal.others()));
    }
    let digest = |bytes: &[u8]| hex(&Sha256::digest(bytes));
    // Old pictures are read without the I/O trace, because it must contain only the inputs.
    let there = |noted: &JournalEntry| {
        std::fs::read(&names[noted.picture - first]).is_ok_and(|bytes| digest(&bytes) == noted.sha256)
    };
    let numbers: Vec<usize> = (first..first + names.len()).collect();
    let known: Vec<Option<Picture>> = numbers
        .iter()
        .copied()
        .map(|i| journal.get(i).filter(|noted| there(noted)).map(|noted| noted.drawn.clone()))
        .collect();
    let skipped = known.iter().flatten().count();
    if skipped > 0 {
        io_trace::mark_incomplete();
        output.note(&format!(
            "{skipped} of {} pictures exist from an earlier run; --restart draws them again",
            names.len()
        ));
    }
    let mut pictures = Vec::new();
    for ((index, name), known) in numbers.iter().copied().zip(names).zip(known) {
        pictures.push(match known {
            Some(picture) => picture,
            None => {
                let (picture, pixels) = shoot.picture(index, output)?;
                let bytes = write_png(name, &pixels)?;
                journal.add(JournalEntry { picture: index, sha256: digest(&bytes), drawn: picture.clone() })?;
                picture
            }
        });
    }
    journal.finish(&numbers)?;
    Ok(DrawnPictures { pictures, skipped })
}

fn video(path: &Path, shoot: &mut PictureSeries, output: &mut Output) -> Result<Vec<Picture>, Failure> {
    let mut result = Ok(Vec::new());
    let written = write_atomic_with(path, |out| {
        // Errors of drawing are returned unchanged; only errors of the file get its path.
        match film(out, shoot, output) {
            Err(Failure::Stdout(error)) => Err(error),
            other => {
                let failed = other.is_err();
                result = other;
                if failed { Err(io::Error::other("a picture could not be drawn")) } else { Ok(()) }
            }
        }
    });
    let pictures = result?;
    written?;
    Ok(pictures)
}

/// Draws a video and writes it to `out`. Write errors are returned as [`Failure::Stdout`].
fn film(out: &mut dyn Write, shoot: &mut PictureSeries, output: &mut Output) -> Result<Vec<Picture>, Failure> {
    let (width, height) = shoot.size();
    let background = shoot.background().unwrap_or(WHITE);
    let mut video = Y4m::new(out, width, height, shoot.fps).map_err(Failure::Stdout)?;
    let mut pictures = Vec::new();
    for index in 0..shoot.count {
        let (picture, pixels) = shoot.picture(index, output)?;
        video.frame(&picture::Picture::from(&pixels).composite_over(background)).map_err(Failure::Stdout)?;
        pictures.push(picture);
    }
    video.flush().map_err(Failure::Stdout)?;
    Ok(pictures)
}

/// Returns the file names of numbered pictures.
fn names(output: &Path, Frames { first, end, .. }: Frames) -> Result<Vec<PathBuf>, Failure> {
    let text = output.to_str().ok_or_else(|| Failure::Usage(format!("-o {}: not UTF-8", output.display())))?;
    let pattern = match text.split_once('%') {
        Some((head, tail)) => {
            // A %d without digits means a width of one.
            let digits = |d: &str| if d.is_empty() { Some(1) } else { d.parse::<usize>().ok() };
            let digits = tail.split_once('d').and_then(|(d, rest)| Some((digits(d)?, rest)));
            let Some((width @ 1..=9, rest)) = digits else {
                let expected = "expected a number pattern such as %04d after the first %";
                return Err(Failure::Usage(format!("-o {text}: {expected}")));
            };
            if rest.contains('%') {
                let expected = "expected one number pattern; a picture has one number";
                return Err(Failure::Usage(format!("-o {text}: found another % after %{width:02}d, {expected}")));
            }
            (head.to_owned(), width, rest.to_owned())
        }
        None => {
            let extension = output.extension().map_or(String::new(), |e| format!(".{}", e.to_string_lossy()));
            (format!("{}_", text.strip_suffix(&extension).unwrap_or(text)), 4, extension)
        }
    };
    let (head, width, tail) = pattern;
    Ok((first..end).map(|i| PathBuf::from(format!("{head}{i:0width$}{tail}"))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_numbered() {
        let list = |o: &str, n: Option<u32>, sequence| {
            Sink::new(Path::new(o), n.map(Frames::all), sequence).map(|sink| sink.files())
        };
        assert_eq!(list("a.png", None, None).ok(), Some(vec!["a.png".to_owned()]));
        assert_eq!(list("%04d.png", Some(2), None).ok(), Some(vec!["0000.png".to_owned(), "0001.png".to_owned()]));
        assert_eq!(list("walk.png", Some(1), None).ok(), Some(vec!["walk_0000.png".to_owned()]));
        assert!(list("a%s.png", Some(1), None).is_err());
        // Checks that a scene's sequence applies to numbered names, while a plain name is one picture.
        assert_eq!(list("%1d.png", None, Some(2)).ok(), Some(vec!["0.png".to_owned(), "1.png".to_owned()]));
        assert_eq!(list("%d.png", Some(1), Some(2)).ok(), Some(vec!["0.png".to_owned()]));
        // Checks that a name has at most one number and the extension of PNG.
        let error = list("%04d/%04d.png", Some(1), None).unwrap_err().to_string();
        assert!(error.contains("found another % after %04d, expected one number pattern"), "{error}");
        for name in ["a.jpg", "a.PNG.exr", "b/%04d.webp"] {
            let error = list(name, Some(1), None).unwrap_err().to_string();
            assert!(error.contains("is not supported, expected a name that ends in .png, .svg or .y4m"), "{error}");
        }
        assert!(list("no-such-folder/%04d.png", Some(1), None).is_ok(), "its folder will be made");
        assert!(list("%0s.png", Some(1), None).is_err() && list("%10d.png", Some(1), None).is_err());
        assert_eq!(list("a.png", None, Some(2)).ok(), Some(vec!["a.png".to_owned()]));
    }

    #[test]
    fn frame_ranges_keep_their_numbers() {
        let sink = |o: &str, frames: &str| Sink::new(Path::new(o), frames.parse().ok(), None);
        let Ok(Sink::Numbered { first, names, journal }) = sink("a/%02d.png", "7..9/24") else { panic!("numbered") };
        assert_eq!((first, names), (7, vec!["a/07.png".into(), "a/08.png".into()]));
        assert_eq!(journal, PathBuf::from("a/%02d.png.7-9.pictures.jsonl"));
        assert!(sink("a.y4m", "7..9").is_err() && sink("-", "7..9").is_err());
        assert!(sink("-", "9").is_ok());
    }

    #[test]
    fn videos_are_recognised_by_extension() {
        let sink = |o: &str| Sink::new(Path::new(o), None, None).ok();
        assert_eq!(sink("-"), Some(Sink::Stdout));
        assert_eq!(sink("a.Y4M"), Some(Sink::Video("a.Y4M".into())));
        assert_eq!(sink("./-"), Some(Sink::Picture("./-".into())));
    }
}
