//! `pelage sky`: fits a small set of lights to an environment map.

use super::exit::{Exit, Failure};
use super::guard::OutputFile;
use super::job::Job;
use super::output::{Output, require_parent};
use pelage_bake::environment_file::EnvironmentFile;
use pelage_bake::io::write_atomic;
use pelage_stage::Look;
use pelage_stage::sky::{Environment, FitParams, FitResult, environment_to_toml};
use serde::Serialize;
use std::path::PathBuf;
use std::time::Instant;

/// Fit a small set of lights to an environment map, as `--environment` does, and write them as a file. Applications can
/// ship, edit, turn and blend such a file
///
/// The lights are a constant ambient term, lobes around directions, and a sun if one dominates.
#[derive(Clone, Debug, clap::Args)]
pub struct SkyArgs {
    /// Environment map, equirectangular in linear radiance (.hdr, .exr), or lights to validate and rewrite (.toml)
    #[arg(value_name = "SKY")]
    input: PathBuf,
    /// Lights to write, in TOML
    #[arg(long, short, value_name = "TOML")]
    output: OutputFile,
    /// Maximum number of lobes
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=32))]
    lobes: u32,
    /// sRGB colour of a level ground that reflects the light from above; replaces everything below the horizon
    #[arg(long, value_name = "COLOR", value_parser = parse_ground)]
    ground: Option<[f32; 3]>,
    /// Minimum share of the total light above which a sun becomes a separate light, 0 to 1; 1 keeps it among the lobes
    #[arg(long, value_name = "SHARE", default_value_t = FitParams::default().sun, value_parser = parse_share)]
    sun: f64,
}

/// Lights that were written, and the error of the fit.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SkyResult {
    output: String,
    /// Width and height of the panorama, pixels; null for lights in TOML.
    size: Option<[u32; 2]>,
    lobes: usize,
    sun: Option<SkySun>,
    /// Relative error of the fitted total light, compared with the sky without its sun. Maximum of the three colour
    /// channels.
    energy: f64,
    /// RMSE of the fitted lights, compared with the sky without its sun and relative to it.
    error: f64,
    /// Number of pixels that were repaired because their radiance was invalid.
    mended: u32,
    seconds: f64,
}

/// Sun that became a separate light.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct SkySun {
    towards: [f32; 3],
    /// Linear colour, in units in which 1 gives an irradiance of π.
    color: [f32; 3],
    share: f64,
}

impl SkyArgs {
    /// Returns the description of the fit for the cache.
    pub fn job(&self) -> Option<Job> {
        let args = Self { output: Job::name(&self.output), ..self.clone() };
        Some(Job::new("sky", &args, &[&self.output]))
    }
}

fn parse_share(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|share| (0.0..=1.0).contains(share)).ok_or("expected a share from 0 to 1".into())
}

fn parse_ground(text: &str) -> Result<[f32; 3], String> {
    let mut look = Look::default();
    look.set(&format!("environment.ground={text}")).map_err(|error| error.to_string())?;
    look.environment.ground_color().ok_or_else(|| "expected a colour".into())
}

/// Runs the subcommand.
pub fn run(args: &SkyArgs, output: &mut Output) -> Result<Exit, Failure> {
    require_parent(&args.output)?;
    let sky = EnvironmentFile::read(&args.input)?;
    output.progress("fitting");
    let began = Instant::now();
    let sky = sky.over_ground(args.ground, args.lobes as usize)?;
    let (fitted, size) = match sky {
        EnvironmentFile::Panorama(panorama) => {
            let sun = if args.sun < 1.0 { args.sun } else { f64::INFINITY };
            (panorama.fit(FitParams { lobes: args.lobes as usize, sun }), Some(panorama.size()))
        }
        EnvironmentFile::Lights(environment) => {
            let most = args.lobes as usize;
            let environment = environment.with_fewer(most);
            (FitResult { environment, sun_share: 0.0, energy: 0.0, error: 0.0, repaired_pixels: 0 }, None)
        }
    };
    let seconds = began.elapsed().as_secs_f64();
    let text = environment_to_toml(&fitted.environment);
    write_atomic(&args.output, text.as_bytes())?;
    report(args, &fitted, size, seconds, output)
}

fn report(
    args: &SkyArgs,
    fitted: &FitResult,
    size: Option<(u32, u32)>,
    seconds: f64,
    output: &mut Output,
) -> Result<Exit, Failure> {
    let Environment { lobes, sun, .. } = &fitted.environment;
    if fitted.repaired_pixels > 0 {
        let name = args.input.display();
        output.note(&format!(
            "note: {name}: {} pixels were invalid (negative, infinite or not a number) and have been replaced",
            fitted.repaired_pixels
        ));
    }
    let name = args.output.display().to_string();
    let with_sun = if sun.is_some() {
        format!(", and a sun with {:.0} % of the light", 100.0 * fitted.sun_share)
    } else {
        String::new()
    };
    let near = match size {
        Some(_) => format!(
            "; radiance off by {:.1} %, total light off by {:.2} %",
            100.0 * fitted.error,
            100.0 * fitted.energy
        ),
        None => String::new(),
    };
    let text = format!("{name}: {} lobes{with_sun}{near}", lobes.len());
    let result = SkyResult {
        output: name,
        size: size.map(|(width, height)| [width, height]),
        lobes: lobes.len(),
        sun: sun.map(|sun| SkySun { towards: sun.towards, color: sun.color, share: fitted.sun_share }),
        energy: fitted.energy,
        error: fitted.error,
        mended: fitted.repaired_pixels,
        seconds,
    };
    output.result(&text, &result)?;
    Ok(Exit::Done)
}
