//! Options shared by `render`, `bench` and `reference`: look, camera, clip and time.

use super::camera_args::CameraArgs;
use super::look_args::LookArgs;
use pelage_stage::MAX_COPIES;
use std::str::FromStr;

/// Help heading of the options for sequences of pictures.
pub const SEQUENCES: &str = "Sequences";
/// Help heading of the options for the model's pose, and for its copies.
const MODEL: &str = "Model";
/// End of the short help of commands with many options.
pub const ALL_OPTIONS: &str =
    "More options with --help: pose, camera, sequences, light, fur, shadows, motion and ink, in groups.";
/// End of the long help of the same commands.
pub const COMMON_OPTIONS: &str = "-h prints the common options only.";

/// Options of `render`, `bench` and `reference`.
#[derive(Clone, Debug, clap::Args)]
pub struct ViewArgs {
    #[command(flatten)]
    pub camera: CameraArgs,
    /// Time in the clip, seconds
    #[arg(long, value_name = "S", default_value_t = 0.0, value_parser = parse_seconds, allow_hyphen_values = true,
        display_order = 10)]
    pub time: f32,
    /// Animation clip, by name [default: the rest pose]
    #[arg(long, value_name = "NAME", display_order = 9)]
    pub clip: Option<String>,
    /// Second clip and the amount to blend to it, from --clip or the rest pose, 0 to 1
    #[arg(long, value_name = "NAME:SHARE", help_heading = MODEL, hide_short_help = true)]
    pub blend: Option<Blend>,
    /// Weight of a morph target, overriding the clips; may be repeated
    #[arg(long, value_name = "NAME:WEIGHT", allow_hyphen_values = true, help_heading = MODEL, hide_short_help = true)]
    pub morph: Vec<MorphWeight>,
    /// Copies of the model, side by side on a grid
    #[arg(long, value_name = "N", default_value_t = 1,
        value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_COPIES)),
        help_heading = MODEL, hide_short_help = true)]
    pub crowd: u32,
    /// Frames: numbered pictures of `render`, timed frames of `bench`. A..B draws only pictures A to B - 1 of a
    /// sequence of B, and A..B/N of a sequence of N, to share a sequence among machines. A scene's own length takes
    /// precedence over B
    #[arg(long, value_name = "N|A..B[/N]", help_heading = SEQUENCES, hide_short_help = true)]
    pub frames: Option<Frames>,
    #[command(flatten)]
    pub look: LookArgs,
}

/// Range of pictures of a sequence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frames {
    /// Index of the first picture.
    pub first: u32,
    /// End of the range, exclusive.
    pub end: u32,
    /// Number of pictures in the whole sequence, if given.
    pub of: Option<u32>,
}

impl Frames {
    /// Maximum number of pictures in a sequence.
    const MOST: u32 = 100_000;

    /// Returns the range of a whole sequence of `count` pictures.
    pub fn all(count: u32) -> Self {
        Self { first: 0, end: count, of: Some(count) }
    }

    /// Returns the number of pictures if the range covers the whole sequence, else `None`.
    pub fn count(self) -> Option<u32> {
        (self.of == Some(self.end) && self.first == 0).then_some(self.end)
    }
}

impl FromStr for Frames {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |word: &str| word.trim().parse::<u32>().ok().filter(|n| *n <= Self::MOST);
        let expected = || {
            let most = Self::MOST;
            format!("expected a number of 1 to {most}, or a range of pictures such as 0..24 or 24..48/96")
        };
        let Some((first, rest)) = text.split_once("..") else {
            return number(text).filter(|n| *n > 0).map(Self::all).ok_or_else(expected);
        };
        let (end, of) = match rest.split_once('/') {
            Some((end, of)) => (end, Some(number(of).ok_or_else(expected)?)),
            None => (rest, None),
        };
        let (first, end) = number(first).zip(number(end)).ok_or_else(expected)?;
        if first >= end || of.is_some_and(|of| end > of) {
            return Err(format!("found the range {first}..{end}, which is empty or too long; {}", expected()));
        }
        Ok(Self { first, end, of })
    }
}

/// Clip to blend to.
#[derive(Clone, Debug, PartialEq)]
pub struct Blend {
    /// Name of the clip.
    pub clip: String,
    /// Amount, 0..=1.
    pub share: f32,
}

impl FromStr for Blend {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.rsplit_once(':').filter(|(clip, _)| !clip.is_empty());
        let share = parts.and_then(|(_, share)| share.parse().ok()).filter(|share| (0.0..=1.0).contains(share));
        let both = parts.zip(share).map(|((clip, _), share)| Self { clip: clip.into(), share });
        both.ok_or("expected the name of a clip and a share of 0 to 1, such as Walk:0.3".into())
    }
}

/// Morph target and its weight.
#[derive(Clone, Debug, PartialEq)]
pub struct MorphWeight {
    /// Name of the target.
    pub target: String,
    /// Weight, a finite number.
    pub weight: f32,
}

impl FromStr for MorphWeight {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.rsplit_once(':').filter(|(target, _)| !target.is_empty());
        let weight = parts.and_then(|(_, weight)| weight.parse().ok()).filter(|weight: &f32| weight.is_finite());
        let both = parts.zip(weight).map(|((target, _), weight)| Self { target: target.into(), weight });
        both.ok_or("expected the name of a morph target and a weight, such as smile:0.7".into())
    }
}

/// Parses a finite number of seconds.
pub fn parse_seconds(text: &str) -> Result<f32, String> {
    text.parse().ok().filter(|s: &f32| s.is_finite()).ok_or("expected a number of seconds".into())
}

#[cfg(test)]
mod tests {
    use super::super::view::PictureView;
    use super::*;
    use clap::Parser;
    use glam::Vec3;
    use pelage_stage::{Look, Orbit, Viewpoint};

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        view: ViewArgs,
    }

    fn parse(line: &str) -> Result<ViewArgs, String> {
        let words = ["pelage"].into_iter().chain(line.split_whitespace());
        Line::try_parse_from(words).map(|l| l.view).map_err(|e| e.to_string())
    }

    #[test]
    fn view_defaults_match_the_library() {
        let view = parse("").unwrap();
        assert_eq!(PictureView::new(&view, Look::default()).unwrap(), PictureView::default());
        assert_eq!(view.frames, None);
    }

    #[test]
    fn every_view_option_is_parsed() {
        let args = parse(
            "--camera -1,2,3.5/0,0,-1/45 --time 0.25 --clip Walk --blend A|Run:0.3 --morph a:b:-0.5 \
             --morph smile:2 --crowd 100 --frames 3 --layers 8",
        )
        .unwrap();
        let view = PictureView::new(&args, Look::default()).unwrap();
        let (eye, target) = (Vec3::new(-1.0, 2.0, 3.5), Vec3::new(0.0, 0.0, -1.0));
        assert_eq!(view.camera, Some(Viewpoint { eye, target, fov_deg: 45.0 }));
        assert_eq!(
            (view.time_s, view.clip.as_deref(), view.crowd, args.frames),
            (0.25, Some("Walk"), 100, Some(Frames::all(3)))
        );
        let range = |first, end, of| Some(Frames { first, end, of });
        assert_eq!(parse("--frames 4..8").unwrap().frames, range(4, 8, None));
        assert_eq!(parse("--frames 4..8/96").unwrap().frames, range(4, 8, Some(96)));
        assert_eq!(view.blend, Some(Blend { clip: "A|Run".into(), share: 0.3 }));
        let morph = |target: &str, weight| MorphWeight { target: target.into(), weight };
        assert_eq!(view.morphs, [morph("a:b", -0.5), morph("smile", 2.0)]);
        assert_eq!(view.look.fur.layers, Some(8));
        let view = PictureView::new(&parse("--orbit -90,20.5,2 --look-at Ey*").unwrap(), Look::default()).unwrap();
        let orbit = Orbit { azimuth_deg: -90.0, elevation_deg: 20.5, zoom: 2.0 };
        assert_eq!((view.framing.orbit, view.framing.look_at.as_deref()), (Some(orbit), Some("Ey*")));
    }

    #[test]
    fn view_option_errors_are_reported() {
        for (line, message) in [
            ("--camera 0,0,0/0,0,0/40", "same point"),
            ("--camera 0,0,1/0,0,0", "ex,ey,ez/tx,ty,tz/fov_deg"),
            ("--camera 0,0/0,0,0/40", "eye: expected three numbers"),
            ("--camera 0,0,1/0,0,0/180", "1 to 170 degrees"),
            ("--camera 0,0,1/0,0,0/40 --orbit 1,2", "cannot be used with"),
            ("--camera 0,0,1/0,0,0/40 --look-at Head", "cannot be used with"),
            ("--orbit 1", "azimuth and elevation in degrees"),
            ("--orbit 1,2,3,4", "such as 45,20,1.5"),
            ("--orbit 1,nan", "azimuth and elevation"),
            ("--orbit 0,91", "elevation: found 91, expected -90 to 90 degrees"),
            ("--orbit 0,0,0", "zoom: found 0, expected 0.01 to 100"),
            ("--frames 0", "expected a number of 1 to 100000"),
            ("--frames 100001", "expected a number of 1 to 100000"),
            ("--frames 4..4", "found the range 4..4"),
            ("--frames 4..8/7", "found the range 4..8"),
            ("--frames 4..x", "such as 0..24 or 24..48/96"),
            ("--time inf", "number of seconds"),
            ("--blend Run", "such as Walk:0.3"),
            ("--blend :0.3", "such as Walk:0.3"),
            ("--blend Run:1.5", "a share of 0 to 1"),
            ("--morph smile", "such as smile:0.7"),
            ("--morph smile:nan", "such as smile:0.7"),
            ("--crowd 0", "0 is not in 1..=10000"),
        ] {
            let error = parse(line).unwrap_err();
            assert!(error.contains(message), "{line}: {error}");
        }
    }
}
