//! `pelage inspect`: what is inside a package.

use super::anatomy::{self, anatomy};
use super::exit::{Exit, Failure};
use super::output::{Output, human_bytes};
use super::package_file;
use pelage_bake::hexadecimal::hex;
use pelage_formats::Package;
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Show what is inside a package: sections, textures, counts, memory, recipe, quality figures
#[derive(Debug, clap::Args)]
pub struct InspectArgs {
    /// The package
    #[arg(value_name = "PKG")]
    package: PathBuf,
}

/// Runs the subcommand.
pub fn run(args: &InspectArgs, output: &mut Output) -> Result<Exit, Failure> {
    let file = package_file::read(&args.package)?;
    let package = file.open()?;
    let object = describe(&package).map_err(|e| file.fault(e))?;
    output.result(&table(&file.name, &object), &object)?;
    Ok(Exit::Done)
}

fn describe(package: &Package<'_>) -> Result<Value, pelage_formats::FormatError> {
    let manifest = package.manifest();
    let sections: Vec<_> =
        package.sections().iter().map(|s| json!({ "tag": s.tag.to_string(), "bytes": s.length })).collect();
    let mut gpu_bytes = 0;
    let mut textures = Vec::new();
    for (index, entry) in manifest.textures.iter().enumerate() {
        let view = package.texture(index as u32)?;
        gpu_bytes += view.gpu_bytes();
        textures.push(json!({
            "name": entry.name,
            "format": view.format.name(),
            "width": view.width,
            "height": view.height,
            "layers": view.layers,
            "levels": view.levels,
            "bytes": view.gpu_bytes(),
        }));
    }
    let mesh = package.mesh()?;
    gpu_bytes += mesh.map_or(0, |m| m.bytes());
    let fins = package.fins()?;
    gpu_bytes += fins.map_or(0, |f| f.fins.len() as u64);
    let single = package.strands()?;
    let hair: Vec<_> = package
        .hair_groups()?
        .iter()
        .map(|g| json!({ "name": g.name, "hairs": g.hair_count(), "points": g.points, "guides": g.guide_roots.len() }))
        .collect();
    let ink = package.ink()?;
    gpu_bytes += ink.as_ref().map_or(0, |ink| ink.vertices.len() as u64);
    let mut anatomy = anatomy(package)?;
    let quality: Vec<_> =
        manifest.quality.iter().map(|q| json!({ "name": q.name, "value": q.value, "unit": q.unit })).collect();
    let inputs: Vec<_> = manifest
        .inputs
        .iter()
        .map(|i| json!({ "role": i.role, "name": i.name, "bytes": i.bytes, "sha256": hex(&i.sha256) }))
        .collect();
    Ok(json!({
        "version": package.version(),
        "bytes": package.bytes().len(),
        "generator": manifest.generator,
        "model": manifest.model,
        "sections": sections,
        "textures": textures,
        "triangles": mesh.map_or(0, |m| m.index_count / 3),
        "vertices": mesh.map_or(0, |m| m.vertex_count),
        "patches": manifest.fur.patches,
        "layers": manifest.fur.layers,
        "fins": fins.map_or(0, |f| f.count),
        "strands": manifest.fur.strands,
        "single_strands": single.map_or(0, |view| view.strand_count()),
        "hair": hair,
        "tile_texels": manifest.fur.tile_texels,
        "tile_size_m": manifest.fur.tile_size_m,
        "height_m": manifest.fur.height_m,
        "size_m": anatomy["size_m"].take(),
        "joints": anatomy["joint_names"].as_array().map_or(0, Vec::len),
        "joint_names": anatomy["joint_names"].take(),
        "clips": anatomy["clips"].take(),
        "morphs": anatomy["morphs"].take(),
        "materials": anatomy["materials"].take(),
        "gpu_bytes": gpu_bytes,
        "coat": manifest.coat,
        "detail": manifest.detail,
        "choice": manifest.choice,
        "ink": ink.map(|ink| ink.info),
        "quality": quality,
        "warnings": manifest.warnings,
        "inputs": inputs,
        "recipe": manifest.recipe,
    }))
}

/// What a bake was told, what it tried, and what it took.
fn choice_rows(choice: &Value, row: &mut dyn FnMut(&str, String)) {
    let Some(trials) = choice["trials"].as_array() else { return };
    let limits = choice["limits"].as_object().into_iter().flatten().filter(|(_, limit)| !limit.is_null());
    let limits: Vec<_> = limits.map(|(name, limit)| format!("{name} {limit}")).collect();
    let binding = choice["binding"].as_str().filter(|b| !b.is_empty()).unwrap_or("none");
    row("limits", format!("{}; {binding} binds", limits.join(", ")));
    let marks = [("chosen", "chosen"), ("next_better", "next better"), ("next_cheaper", "next cheaper")];
    for (i, trial) in trials.iter().enumerate() {
        let settings: Vec<_> = trial["settings"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        let mut figures = vec![human_bytes(trial["bytes"].as_u64().unwrap_or(0))];
        figures.extend(trial["error"].as_f64().map(|e| format!("error {e:.4}")));
        figures.extend(trial["frame_ms"].as_f64().map(|ms| format!("{ms:.2} ms")));
        if trial["predicted"] == true {
            figures.push("predicted".into());
        }
        figures.extend(marks.iter().filter(|(key, _)| choice[*key] == i).map(|(_, mark)| (*mark).to_owned()));
        row("trial", format!("{}: {}", settings.join(" "), figures.join(", ")));
    }
}

/// The same for people. Everything comes from the JSON, so that the two cannot disagree.
fn table(name: &str, object: &Value) -> String {
    let mut out = String::new();
    let number = |v: &Value| v.as_u64().unwrap_or(0);
    let list = |key: &str| object[key].as_array().cloned().unwrap_or_default();
    let text = |v: &Value| v.as_str().unwrap_or_default().to_owned();
    let mut row = |key: &str, value: String| {
        let _ = writeln!(out, "{key:<14} {value}");
    };
    row("package", format!("{name}, version {}, {}", object["version"], human_bytes(number(&object["bytes"]))));
    row("model", format!("{}, baked by {}", text(&object["model"]), text(&object["generator"])));
    row("mesh", format!("{} triangles, {} vertices", object["triangles"], object["vertices"]));
    row("fur", {
        let (layers, texels) = (number(&object["layers"]), number(&object["tile_texels"]));
        let mm = |key: &str| object[key].as_f64().unwrap_or(0.0) * 1000.0;
        format!(
            "{layers} layers of {texels}x{texels} texels, {} strands, tile {:.1} mm, height {:.1} mm, {} patches, {} fins",
            object["strands"],
            mm("tile_size_m"),
            mm("height_m"),
            object["patches"],
            object["fins"]
        )
    });
    if object["single_strands"] != 0 {
        row("strands", format!("{} of the tile, one by one", object["single_strands"]));
    }
    for h in list("hair") {
        let [hairs, points] = ["hairs", "points"].map(|key| number(&h[key]));
        row("hair", format!("{:?}, {hairs} of {points} points, {} guides", text(&h["name"]), number(&h["guides"])));
    }
    anatomy::rows(object, &mut row);
    for t in list("textures") {
        let (name, format, bytes) = (text(&t["name"]), text(&t["format"]), human_bytes(number(&t["bytes"])));
        let size = format!("{}x{}x{}, {} levels", t["width"], t["height"], t["layers"], t["levels"]);
        row("texture", format!("{name}: {format}, {size}, {bytes}"));
    }
    for s in list("sections") {
        row("section", format!("{}, {}", text(&s["tag"]), human_bytes(number(&s["bytes"]))));
    }
    let decimals = |v: &Value, n: usize| format!("{:.n$}", v.as_f64().unwrap_or(0.0));
    if let coat @ Value::Object(_) = &object["coat"] {
        let (height, straight) = (decimals(&coat["height"], 2), decimals(&coat["light_straight"], 2));
        row("coat", format!("at {height} of the height, {straight} of the key light reaches it"));
    }
    for level in list("detail") {
        let drawn = match number(&level["step"]) {
            0 => "the coat alone".to_owned(),
            1 => "every layer".to_owned(),
            step => format!("1 layer in {step}"),
        };
        let (full, gone, fins) = (&level["full_px"], &level["gone_px"], 100.0 * level["fins"].as_f64().unwrap_or(0.0));
        let range = format!("from {} px of fur, gone at {} px", decimals(full, 2), decimals(gone, 2));
        row("detail", format!("{drawn}, {fins:.0} % of the fins, {range}"));
    }
    if let ink @ Value::Object(_) = &object["ink"] {
        let (shading, grain_mm) = (&ink["shading"], 1000.0 * ink["grain_size_m"].as_f64().unwrap_or(0.0));
        let (speed, range) = (decimals(&shading["wash_speed"], 2), decimals(&shading["wash_range"], 2));
        let fur = if ink["fur_texture"].is_null() { "no fur" } else { "strokes of fur" };
        row("ink", format!("wash from {range}, fading by {speed} a radius, grain every {grain_mm:.1} mm, {fur}"));
    }
    choice_rows(&object["choice"], &mut row);
    row("GPU memory", human_bytes(number(&object["gpu_bytes"])));
    for q in list("quality") {
        let unit = text(&q["unit"]);
        let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
        row("quality", format!("{} {:.4}{unit}", text(&q["name"]), q["value"].as_f64().unwrap_or(0.0)));
    }
    for warning in list("warnings") {
        row("warning", text(&warning));
    }
    for input in list("inputs") {
        row("input", format!("{} {:?}, sha256 {}", text(&input["role"]), text(&input["name"]), text(&input["sha256"])));
    }
    for line in text(&object["recipe"]).lines() {
        row("recipe", line.to_owned());
    }
    out
}
