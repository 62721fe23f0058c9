//! Measures how much of an animal's eyes is covered by its hair: `chores eyes-covered MODEL [bake options] [+ MODEL
//! [bake options]]…`.
//!
//! In a copy of each package, the eyes are green and everything else is black. The copy is drawn bare and furred,
//! without shadows. Where green is lost, hair covers the eyes; highlights on hair are white and do not count. Eyes are
//! the bare materials with "eye" in their name. They are seen from the front and the front left, through a long lens,
//! as in pictures of whole animals. Models without such materials give an empty row.

use anyhow::{Context as _, ensure};
use image::RgbImage;
use pelage_stage::Viewpoint;
use pelage_tests::chores::{Baked, ChoreFolder};
use serde_json::{Value, json};

/// Views, each with its name and `--orbit`: azimuth and elevation in degrees, and zoom. The eyes fill about half of the
/// picture.
const VIEWS: [(&str, &str); 2] = [("front", "0,0,0.5"), ("front left", "40,5,0.5")];
const SIZE: &str = "834x424";
/// Distance of the camera, in radii of the model.
const AWAY: f32 = 6.0;
/// Share of a pixel's green below which the pixel counts as covered.
const LEFT: f64 = 0.9;

pub fn run(arguments: &[String]) -> anyhow::Result<()> {
    let workshop = ChoreFolder::default();
    println!("| model | eyes | view | pixels of eyes | covered pixels, % | covered area, % |");
    println!("|---|---|---|---|---|---|");
    for (index, model) in arguments.split(|a| a == "+").filter(|m| !m.is_empty()).enumerate() {
        for row in measure(&workshop, &format!("model_{index}"), model).with_context(|| model[0].clone())? {
            println!("{row}");
        }
    }
    Ok(())
}

fn measure(workshop: &ChoreFolder, name: &str, model: &[String]) -> anyhow::Result<Vec<String>> {
    let baked = workshop.bake(name, model)?;
    let (marked, eyes, radius_m) = with_green_eyes(workshop, &baked, name)?;
    let Some(first) = eyes.first() else { return Ok(vec![format!("| {} | none | | | | |", model[0])]) };
    let mut rows = Vec::new();
    for (view, orbit) in VIEWS {
        let camera = format!("--camera={}", distant_camera(workshop, &marked, first, orbit, AWAY * radius_m)?);
        let draw = |style: &str| {
            workshop.draw(&marked, SIZE, &[&camera, "--style", style, "--self-shadow", "off", "--soft-shadow", "off"])
        };
        let (pixels, covered, area) = covered(&draw("bare")?, &draw("fur")?);
        // In this view, eyes at the sides of the head may be invisible. Their cells are then empty.
        let [covered, area] =
            [covered, area].map(|share| if pixels > 0 { format!("{:.2}", 100.0 * share) } else { String::new() });
        rows.push(format!("| {} | {} | {view} | {pixels} | {covered} | {area} |", model[0], eyes.join(", ")));
    }
    Ok(rows)
}

/// Returns a camera that looks at the eyes from the direction `orbit` and the distance `away_m`. Its field of view
/// shows as much as a camera that frames the eyes.
fn distant_camera(
    workshop: &ChoreFolder,
    marked: &Baked,
    eyes: &str,
    orbit: &str,
    away_m: f32,
) -> anyhow::Result<String> {
    let (package, picture) = (&marked.package, marked.package.with_extension("png"));
    let paths = [package, &picture].map(|path| path.display().to_string());
    let look = ["--style", "bare", "--orbit", orbit, "--look-at", eyes, "--size", SIZE, "--json", "--quiet"];
    let run = workshop.run(&[&["render", &paths[0], "-o", &paths[1]], &look[..]].concat())?;
    let report: Value = serde_json::from_str(&run.stdout)?;
    let near: Viewpoint = report["camera"]
        .as_str()
        .context("the report has no camera")?
        .parse()
        .map_err(|e: String| anyhow::anyhow!(e))?;
    let way = near.eye - near.target;
    let eye = near.target + way.normalize() * away_m;
    let half = (near.fov_deg.to_radians() / 2.0).tan() * way.length() / away_m;
    let fov_deg = 2.0 * half.atan().to_degrees();
    Ok(Viewpoint { eye, target: near.target, fov_deg }.to_string())
}

/// Returns a copy of a package in which the eyes are green and everything else is black. Also returns the names of the
/// eyes, and the radius of the model in metres.
fn with_green_eyes(workshop: &ChoreFolder, baked: &Baked, name: &str) -> anyhow::Result<(Baked, Vec<String>, f32)> {
    let folder = baked.package.with_file_name(format!("{name}_unpacked"));
    let package = baked.package.with_file_name(format!("{name}_marked.pelage"));
    let words = [&baked.package, &folder, &package].map(|path| path.display().to_string());
    workshop.run(&["unpack", &words[0], &words[1], "--quiet"])?;
    let path = folder.join("manifest.json");
    let mut manifest: Value = serde_json::from_str(&std::fs::read_to_string(&path)?)?;
    let radius_m = manifest["manifest"]["bounds"]["radius"].as_f64().context("the manifest has no radius")? as f32;
    let mut eyes = Vec::new();
    for material in manifest["manifest"]["materials"].as_array_mut().context("the manifest has no materials")? {
        let name = material["name"].as_str().unwrap_or_default().to_owned();
        let is_eye = name.to_lowercase().contains("eye") && material["furred"] == false;
        ensure!(material["base_color"].is_array(), "{name:?} has no colour");
        material["base_color"] = if is_eye { json!([0.0, 1.0, 0.0, 1.0]) } else { json!([0.0, 0.0, 0.0, 1.0]) };
        if is_eye {
            eyes.push(name);
        }
    }
    std::fs::write(&path, manifest.to_string())?;
    workshop.run(&["pack", &words[1], &words[2], "--quiet"])?;
    Ok((Baked { package, report: Value::Null }, eyes, radius_m))
}

/// Returns the number of eye pixels in the bare picture, the share of them that lose more than a tenth of their green,
/// and the lost share of all green.
fn covered(bare: &RgbImage, fur: &RgbImage) -> (usize, f64, f64) {
    let green = |pixel: &image::Rgb<u8>| {
        let linear = |byte: u8| (f64::from(byte) / 255.0).powf(2.2);
        (linear(pixel.0[1]) - linear(pixel.0[0])).max(0.0)
    };
    // Requires a clear excess of green, because the background is slightly greener than red.
    let eyes: Vec<(f64, f64)> = bare
        .pixels()
        .zip(fur.pixels())
        .filter(|(bare, _)| u16::from(bare.0[1]) > 2 * u16::from(bare.0[0].max(8)))
        .map(|(bare, fur)| (green(bare), green(fur)))
        .collect();
    let lost = eyes.iter().filter(|(bare, fur)| *fur < LEFT * bare).count();
    let (all, left) = eyes.iter().fold((0.0, 0.0), |(all, left), (bare, fur)| (all + bare, left + fur.min(*bare)));
    let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
    (eyes.len(), share(lost as f64, eyes.len() as f64), share(all - left, all))
}

#[cfg(test)]
mod tests {
    use super::covered;
    use image::{Rgb, RgbImage};

    #[test]
    fn hidden_eye_pixels_count_as_covered_and_highlights_do_not() {
        let picture = |pixels: [[u8; 3]; 4]| RgbImage::from_fn(4, 1, |x, _| Rgb(pixels[x as usize]));
        let bare = picture([[0, 200, 0], [0, 200, 0], [204, 209, 217], [0, 0, 0]]);
        assert_eq!(covered(&bare, &bare), (2, 0.0, 0.0));
        let (pixels, lost, area) = covered(&bare, &picture([[0, 0, 0], [0, 200, 0], [0, 0, 0], [0, 200, 0]]));
        assert_eq!((pixels, lost), (2, 0.5));
        assert!((area - 0.5).abs() < 1e-9, "{area}");
        let white_hair = picture([[200, 200, 200], [0, 200, 0], [0, 0, 0], [0, 0, 0]]);
        assert_eq!(covered(&bare, &white_hair).1, 0.5, "light hair must count as cover");
    }
}
