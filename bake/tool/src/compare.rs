//! `pelage compare`: measures the difference of two pictures.

use super::exit::{Exit, Failure};
use super::guard::OutputFile;
use super::job::Job;
use super::output::{Output, require_parent};
use pelage_bake::io;
use pelage_import::BakeError;
use pelage_truth::compare::{CompareParams, Comparison, compare_pictures};
use serde::Serialize;
use std::path::PathBuf;
use std::str::FromStr;

/// Compare two pictures of the same size: FLIP, RMSE, PSNR and difference of coverage
///
/// Exits with 7 if a limit is given and exceeded, otherwise with 0.
#[derive(Clone, Debug, clap::Args)]
pub struct CompareArgs {
    /// Picture: PNG of 8 or 16 bits, or EXR
    #[arg(value_name = "A")]
    a: PathBuf,
    /// Second picture, of the same size
    #[arg(value_name = "B")]
    b: PathBuf,
    /// Write the FLIP of each pixel as a PNG, from black for 0 to yellow for 1
    #[arg(long, short, value_name = "PNG")]
    output: Option<OutputFile>,
    /// Background behind transparent pixels for FLIP: sRGB red,green,blue, 0 to 255 each
    #[arg(long, value_name = "R,G,B", default_value = "128,128,128")]
    over: Rgb,
    /// Pixels per degree of the field of view, for FLIP; 67 is a 4K screen 0.7 m wide, viewed from 0.7 m
    #[arg(
        long,
        value_name = "N",
        default_value_t = CompareParams::default().pixels_per_degree,
        value_parser = parse_pixels_per_degree
    )]
    pixels_per_degree: f32,
    /// Fail (exit code 7) if the mean FLIP exceeds this
    #[arg(long, value_name = "E", value_parser = parse_limit)]
    max_flip: Option<f64>,
    /// Fail (exit code 7) if the RMSE in linear light exceeds this
    #[arg(long, value_name = "E", value_parser = parse_limit)]
    max_rmse: Option<f64>,
    /// Fail (exit code 7) if the mean difference of alpha exceeds this
    #[arg(long, value_name = "E", value_parser = parse_limit)]
    max_coverage: Option<f64>,
    /// Fail (exit code 7) if the peak signal-to-noise ratio is below this, decibels
    #[arg(long, value_name = "DB", value_parser = parse_limit)]
    min_psnr: Option<f64>,
}

impl CompareArgs {
    /// Returns the description of the comparison for the cache.
    pub fn job(&self) -> Option<Job> {
        let args = Self { output: self.output.as_deref().map(Job::name), ..self.clone() };
        Some(Job::new("compare", &args, &self.output.as_deref().into_iter().collect::<Vec<_>>()))
    }
}

/// Colour on the command line: sRGB-encoded red, green, blue, 0 to 255 each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rgb(pub [u8; 3]);

impl FromStr for Rgb {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Option<Vec<u8>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
        let rgb = numbers.and_then(|n| <[u8; 3]>::try_from(n).ok());
        rgb.map(Self).ok_or("expected red,green,blue, each from 0 to 255".into())
    }
}

fn parse_limit(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|x: &f64| x.is_finite() && *x >= 0.0);
    number.ok_or("expected a number of 0 or more".into())
}

fn parse_pixels_per_degree(text: &str) -> Result<f32, String> {
    // Outside this range, the filters of FLIP are wider than any picture, or narrower than a pixel.
    let number = text.parse().ok().filter(|x: &f32| (1.0..=1000.0).contains(x));
    number.ok_or("expected a number from 1 to 1000".into())
}

/// Difference of two pictures. Exit code 7 if a limit is exceeded, else 0.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CompareResult {
    a: String,
    b: String,
    width: u32,
    height: u32,
    /// Background behind transparent pixels for FLIP: sRGB-encoded red, green and blue.
    over: [u8; 3],
    pixels_per_degree: f32,
    #[serde(flatten)]
    comparison: Comparison,
    limits: Vec<Limit>,
    different: bool,
    /// Path of the FLIP picture; null without `--output`.
    output: Option<String>,
}

/// Limit of a comparison, and the measured value.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct Limit {
    #[cfg_attr(
        feature = "schema",
        schemars(extend("enum" = ["--max-flip", "--max-rmse", "--max-coverage", "--min-psnr"]))
    )]
    option: &'static str,
    bound: f64,
    /// Measured value; null for the infinite PSNR of equal pictures.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    found: f64,
    exceeded: bool,
}

fn limits(args: &CompareArgs, c: &Comparison) -> Vec<Limit> {
    let most = [
        ("--max-flip", args.max_flip, c.flip.mean),
        ("--max-rmse", args.max_rmse, c.rmse),
        ("--max-coverage", args.max_coverage, c.coverage),
    ];
    let most =
        most.map(|(option, bound, found)| bound.map(|bound| Limit { option, bound, found, exceeded: found > bound }));
    let found = c.psnr_db;
    let least = args.min_psnr.map(|bound| Limit { option: "--min-psnr", bound, found, exceeded: found < bound });
    most.into_iter().chain([least]).flatten().collect()
}

/// Runs the subcommand.
pub fn run(args: &CompareArgs, output: &mut Output) -> Result<Exit, Failure> {
    if let Some(file) = &args.output {
        require_parent(file)?;
    }
    output.progress("comparing");
    let (a, b) = (io::read_picture(&args.a)?, io::read_picture(&args.b)?);
    if (a.width, a.height) != (b.width, b.height) {
        let reason = format!(
            "{}x{} pixels, expected {}x{}, the size of {}",
            b.width,
            b.height,
            a.width,
            a.height,
            args.a.display()
        );
        return Err(BakeError::Input { file: args.b.display().to_string(), place: "size".into(), reason }.into());
    }
    let params = CompareParams { over: args.over.0, pixels_per_degree: args.pixels_per_degree };
    let (comparison, map) = compare_pictures(&a, &b, &params)?;
    if let Some(file) = &args.output {
        io::write_atomic(file, &map.png()?)?;
    }
    let limits = limits(args, &comparison);
    let text = text(args, &comparison, &limits);
    let different = limits.iter().any(|limit| limit.exceeded);
    let result = CompareResult {
        a: args.a.display().to_string(),
        b: args.b.display().to_string(),
        width: a.width,
        height: a.height,
        over: args.over.0,
        pixels_per_degree: args.pixels_per_degree,
        comparison,
        limits,
        different,
        output: args.output.as_ref().map(|file| file.display().to_string()),
    };
    output.result(&text, &result)?;
    Ok(if different { Exit::Differences } else { Exit::Done })
}

fn text(args: &CompareArgs, c: &Comparison, limits: &[Limit]) -> String {
    let f = &c.flip;
    let mut lines = vec![
        format!(
            "FLIP      mean {:.5}, mean of covered pixels {:.5}, weighted median {:.5}, max {:.5}",
            f.mean, f.covered, f.weighted_median, f.max
        ),
        format!("RMSE      {:.6} of linear light", c.rmse),
        if c.psnr_db.is_finite() {
            format!("PSNR      {:.3} dB", c.psnr_db)
        } else {
            "PSNR      infinite: the pictures are equal".into()
        },
        format!("coverage  {:.6} mean difference of alpha", c.coverage),
    ];
    for limit in limits {
        let word = if limit.exceeded { "DIFFERENT" } else { "held" };
        lines.push(format!("{} {}: {word}", limit.option, limit.bound));
    }
    lines.extend(args.output.as_ref().map(|file| file.display().to_string()));
    lines.join("\n")
}
