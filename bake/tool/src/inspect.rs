//! `pelage inspect`: shows the contents of a package.

use super::anatomy::Anatomy;
use super::exit::{Exit, Failure};
use super::output::{Output, human_bytes};
use super::package_file;
use pelage_bake::hexadecimal::hex;
use pelage_formats::{Choice, DetailLevel, FarLayerInfo, FormatError, InkInfo, Package, QualityFigure};
use serde::Serialize;
use serde_json::Value;
use std::fmt::Write as _;
use std::path::PathBuf;

/// Show the contents of a package: sections, textures, counts, memory, recipe, quality figures
#[derive(Debug, clap::Args)]
pub struct InspectArgs {
    /// Package to inspect
    #[arg(value_name = "PKG")]
    package: PathBuf,
}

/// Runs the subcommand.
pub fn run(args: &InspectArgs, output: &mut Output) -> Result<Exit, Failure> {
    let file = package_file::read(&args.package)?;
    let package = file.open()?;
    let result = InspectResult::of(&package).map_err(|e| file.fault(e))?;
    output.result(&table(&file.name, &result), &result)?;
    Ok(Exit::Done)
}

/// Contents of a package.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct InspectResult<'a> {
    /// Version of the format.
    version: u32,
    bytes: usize,
    generator: &'a str,
    model: &'a str,
    sections: Vec<SectionSize>,
    textures: Vec<TextureShape<'a>>,
    triangles: u32,
    vertices: u32,
    patches: u32,
    /// Shell layers; 0 without fur.
    layers: u32,
    /// Number of fin quads on the edges of the mesh; 0 without fins.
    fins: u32,
    strands: u32,
    /// Strands of the tile that are stored individually; 0 if there are none.
    single_strands: u32,
    hair: Vec<HairSize>,
    tile_texels: u32,
    tile_size_m: f32,
    height_m: f32,
    joints: usize,
    #[serde(flatten)]
    anatomy: Anatomy,
    /// GPU memory of textures, vertices and indices, bytes.
    gpu_bytes: u64,
    /// Far layer, which replaces the fur at a distance; null if the package has none.
    coat: Option<FarLayerInfo>,
    /// Levels of detail, finest first.
    detail: &'a [DetailLevel],
    /// Settings chosen by a bake with limits; null for a bake without limits.
    choice: Option<&'a Choice>,
    /// Textures and constants of the ink style; null without it.
    ink: Option<InkInfo>,
    quality: &'a [QualityFigure],
    warnings: &'a [String],
    inputs: Vec<InputFile<'a>>,
    /// Recipe in TOML, with the used value of every key.
    recipe: &'a str,
}

/// A section of a package.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct SectionSize {
    tag: String,
    bytes: u64,
}

/// A texture of a package.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct TextureShape<'a> {
    name: &'a str,
    /// Texel format, by its WebGPU name.
    format: &'static str,
    width: u32,
    height: u32,
    layers: u32,
    levels: u32,
    /// GPU memory of all mipmap levels and array layers, bytes.
    bytes: u64,
}

/// A group of hair that follows guides.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct HairSize {
    name: String,
    hairs: u32,
    points: u32,
    guides: usize,
}

/// A file that a package was baked from.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct InputFile<'a> {
    role: &'a str,
    name: &'a str,
    bytes: u64,
    /// SHA-256 of the contents, hexadecimal.
    sha256: String,
}

impl<'a> InspectResult<'a> {
    fn of(package: &'a Package<'a>) -> Result<Self, FormatError> {
        let manifest = package.manifest();
        let mut textures = Vec::new();
        for (index, entry) in manifest.textures.iter().enumerate() {
            let view = package.texture(index as u32)?;
            textures.push(TextureShape {
                name: &entry.name,
                format: view.format.name(),
                width: view.width,
                height: view.height,
                layers: view.layers,
                levels: view.levels,
                bytes: view.gpu_bytes(),
            });
        }
        let (mesh, fins, ink) = (package.mesh()?, package.fins()?, package.ink()?);
        let gpu_bytes = textures.iter().map(|texture| texture.bytes).sum::<u64>()
            + mesh.map_or(0, |m| m.bytes())
            + fins.map_or(0, |f| f.fins.len() as u64)
            + ink.as_ref().map_or(0, |ink| ink.vertices.len() as u64);
        let groups = package.hair_groups()?;
        let inputs = manifest.inputs.iter();
        let anatomy = Anatomy::of(package)?;
        Ok(Self {
            version: package.version(),
            bytes: package.bytes().len(),
            generator: &manifest.generator,
            model: &manifest.model,
            sections: package
                .sections()
                .iter()
                .map(|s| SectionSize { tag: s.tag.to_string(), bytes: s.length })
                .collect(),
            textures,
            triangles: mesh.map_or(0, |m| m.index_count / 3),
            vertices: mesh.map_or(0, |m| m.vertex_count),
            patches: manifest.fur.patches,
            layers: manifest.fur.layers,
            fins: fins.map_or(0, |f| f.count),
            strands: manifest.fur.strands,
            single_strands: package.strands()?.map_or(0, |view| view.strand_count()),
            hair: groups
                .iter()
                .map(|g| HairSize {
                    name: g.name.clone(),
                    hairs: g.hair_count(),
                    points: g.points,
                    guides: g.guide_roots.len(),
                })
                .collect(),
            tile_texels: manifest.fur.tile_texels,
            tile_size_m: manifest.fur.tile_size_m,
            height_m: manifest.fur.height_m,
            joints: anatomy.joint_names.len(),
            anatomy,
            gpu_bytes,
            coat: manifest.coat,
            detail: &manifest.detail,
            choice: manifest.choice.as_ref(),
            ink: ink.map(|ink| ink.info),
            quality: &manifest.quality,
            warnings: &manifest.warnings,
            inputs: inputs
                .map(|i| InputFile { role: &i.role, name: &i.name, bytes: i.bytes, sha256: hex(&i.sha256) })
                .collect(),
            recipe: &manifest.recipe,
        })
    }
}

/// Passes the limits of a bake, its trials and the chosen settings to `row`.
fn choice_rows(choice: &Choice, row: &mut dyn FnMut(&str, String)) {
    let limits = [
        ("max_error", choice.limits.max_error.map(Value::from)),
        ("max_frame_ms", choice.limits.max_frame_ms.map(Value::from)),
        ("max_bytes", choice.limits.max_bytes.map(Value::from)),
    ];
    let limits: Vec<_> = limits.into_iter().filter_map(|(name, limit)| Some(format!("{name} {}", limit?))).collect();
    let binding = if choice.binding.is_empty() { "none" } else { &choice.binding };
    row("limits", format!("{}; binding limit: {binding}", limits.join(", ")));
    let marks =
        [(Some(choice.chosen), "chosen"), (choice.next_better, "next better"), (choice.next_cheaper, "next cheaper")];
    for (i, trial) in (0..).zip(&choice.trials) {
        let mut figures = vec![human_bytes(trial.bytes)];
        figures.extend(trial.error.map(|e| format!("error {e:.4}")));
        figures.extend(trial.frame_ms.map(|ms| format!("{ms:.2} ms")));
        if trial.predicted {
            figures.push("predicted".into());
        }
        figures.extend(marks.iter().filter(|(index, _)| *index == Some(i)).map(|(_, mark)| (*mark).to_owned()));
        row("trial", format!("{}: {}", trial.settings.join(" "), figures.join(", ")));
    }
}

/// Formats the result as text.
fn table(name: &str, r: &InspectResult<'_>) -> String {
    let mut out = String::new();
    let mut row = |key: &str, value: String| {
        let _ = writeln!(out, "{key:<14} {value}");
    };
    row("package", format!("{name}, version {}, {}", r.version, human_bytes(r.bytes as u64)));
    row("model", format!("{}, baked by {}", r.model, r.generator));
    row("mesh", format!("{} triangles, {} vertices", r.triangles, r.vertices));
    let mm = |metres: f32| f64::from(metres) * 1000.0;
    row(
        "fur",
        format!(
            "{} layers of {n}x{n} texels, {} strands, tile {:.1} mm, height {:.1} mm, patches: {}, fins: {}",
            r.layers,
            r.strands,
            mm(r.tile_size_m),
            mm(r.height_m),
            r.patches,
            r.fins,
            n = r.tile_texels
        ),
    );
    if r.single_strands != 0 {
        row("strands", format!("{} in the tile, drawn one by one", r.single_strands));
    }
    for h in &r.hair {
        row("hair", format!("{:?}, {} hairs of {} points, {} guides", h.name, h.hairs, h.points, h.guides));
    }
    r.anatomy.rows(&mut row);
    for t in &r.textures {
        let size = format!("{}x{}x{}, {} levels", t.width, t.height, t.layers, t.levels);
        row("texture", format!("{}: {}, {size}, {}", t.name, t.format, human_bytes(t.bytes)));
    }
    for s in &r.sections {
        row("section", format!("{}, {}", s.tag, human_bytes(s.bytes)));
    }
    if let Some(FarLayerInfo { height, light_straight, .. }) = r.coat {
        row(
            "far layer",
            format!("drawn at {height:.2} of the fur height, {light_straight:.2} of the key light reaches it"),
        );
    }
    for level in r.detail {
        let drawn = match level.step {
            0 => "the far layer alone".to_owned(),
            1 => "every layer".to_owned(),
            step => format!("1 layer in {step}"),
        };
        let range = format!("full from {:.2} px of fur height, gone at {:.2} px", level.full_px, level.gone_px);
        row("detail", format!("{drawn}, {:.0} % of the fins, {range}", 100.0 * f64::from(level.fins)));
    }
    if let Some(ink) = &r.ink {
        let (shading, grain_mm) = (&ink.shading, 1000.0 * f64::from(ink.grain_size_m));
        let fur = if ink.fur_texture.is_none() { "no fur" } else { "fur strokes" };
        let wash =
            format!("wash: grey {:.2} at the centre, slope {:.2} per radius", shading.wash_range, shading.wash_speed);
        row("ink", format!("{wash}, grain every {grain_mm:.1} mm, {fur}"));
    }
    if let Some(choice) = r.choice {
        choice_rows(choice, &mut row);
    }
    row("GPU memory", human_bytes(r.gpu_bytes));
    for q in r.quality {
        let unit = if q.unit == "1" { String::new() } else { format!(" {}", q.unit) };
        row("quality", format!("{} {:.4}{unit}", q.name, q.value));
    }
    for warning in r.warnings {
        row("warning", warning.clone());
    }
    for input in &r.inputs {
        row("input", format!("{} {:?}, sha256 {}", input.role, input.name, input.sha256));
    }
    for line in r.recipe.lines() {
        row("recipe", line.to_owned());
    }
    out
}
