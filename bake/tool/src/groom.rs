//! `pelage groom`: writes groom maps as images to paint on.

use super::bake::RecipeArgs;
use super::exit::{Exit, Failure};
use super::guard::OutputFile;
use super::output::{Output, require_parent};
use super::paint_mesh::{self, MeshFormat};
use super::threads;
use pelage_bake::groom_map::{GroomMap, Quantity, groom_map};
use pelage_bake::io;
use pelage_bake::picture::encode_png;
use pelage_bake::pipeline::BakeInput;
use pelage_bake::recipe::GroomCoordinates;
use pelage_import::ImportOptions;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Write a groom map, such as the hair length over a model, as an image to paint on
///
/// The image holds the values that a bake of the same recipe would use. It is read back with --set
/// groom.length=map.png, or by a recipe with that key. It uses the model's own texture coordinates. Where those are
/// missing it uses an atlas that depends only on the model, and is read back with groom.coordinates=atlas. Paint it in
/// Krita or any other program, or in Blender on the mesh of --mesh, to change the hair there.
#[derive(Clone, Debug, clap::Args)]
pub struct GroomArgs {
    /// Model: .glb, .gltf or .obj
    #[arg(value_name = "MODEL")]
    model: PathBuf,
    /// Key of `[groom]` to write
    #[arg(long, value_name = "KEY", value_parser = quantity_words())]
    map: String,
    /// Image to write, .png
    #[arg(long, short, value_name = "PNG")]
    output: OutputFile,
    #[command(flatten)]
    recipe: RecipeArgs,
    /// Texture coordinates of the image: the model's own or the atlas [default: as in the recipe; the atlas if a part
    /// with hair has no coordinates]
    #[arg(long, value_name = "WHAT", value_parser = ["model", "atlas"])]
    coordinates: Option<String>,
    /// Width and height of the image, texels
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(16..=8192))]
    texels: u32,
    /// Write the mesh to paint on: .obj, or .glb with the image as its texture
    #[arg(long, value_name = "FILE")]
    mesh: Option<OutputFile>,
    /// Threads to use; does not change the image [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

/// A groom map that was written.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct GroomResult {
    /// Paths of the image, and of the mesh of `--mesh`.
    files: Vec<String>,
    /// Key of `[groom]`.
    map: &'static str,
    /// Texture coordinates of the image.
    #[cfg_attr(feature = "schema", schemars(extend("enum" = ["model", "atlas"])))]
    coordinates: &'static str,
    texels: u32,
    /// Largest difference between a vertex's value and the image before rounding to bytes, 0 to 1.
    misses_by: f32,
    /// Recipe lines that read the image back; they are for a recipe in the image's folder.
    recipe: Vec<String>,
    warnings: Vec<String>,
}

fn quantity_words() -> clap::builder::PossibleValuesParser {
    Quantity::ALL.map(Quantity::key).into()
}

/// Difference above which the image is reported as too coarse for its mesh, relative to the map's range.
const COARSE: f32 = 1.0 / 255.0;

/// Runs the subcommand.
pub fn run(args: &GroomArgs, output: &mut Output) -> Result<Exit, Failure> {
    let has_extension =
        |path: &Path, extension: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension));
    if !has_extension(&args.output, "png") {
        return Err(Failure::Usage(format!("-o {}: expected a name that ends in .png", args.output.display())));
    }
    let mesh = args.mesh.as_deref().map(|path| Ok::<_, Failure>((path, MeshFormat::of(path)?))).transpose()?;
    for path in [Some(&*args.output), args.mesh.as_deref()].into_iter().flatten() {
        require_parent(path)?;
    }
    let quantity = Quantity::of_key(&args.map).ok_or_else(|| Failure::Usage(format!("--map {}: unknown", args.map)))?;
    let pool = threads::pool(args.threads)?;
    let (map, materials) = pool.install(|| evaluate(args, quantity, output))?;
    let pixels = image::RgbaImage::from_raw(map.image.width, map.image.height, map.image.rgba.clone());
    let png = encode_png(&pixels.unwrap_or_default())?;
    io::write_atomic(&args.output, &png)?;
    let mut files = vec![args.output.display().to_string()];
    if let Some((path, format)) = mesh {
        let bytes = paint_mesh::write(format, &map, &materials, &png)?;
        io::write_atomic(path, &bytes)?;
        files.push(path.display().to_string());
    }
    map.warnings.iter().for_each(|warning| output.note(&format!("warning: {warning}")));
    if map.misses_by > COARSE {
        output.note(&format!(
            "note: {} texels are too few to separate all vertices: the worst one is read back with an error of \
             {:.3} of the range; --texels {} or --coordinates atlas separates more",
            args.texels,
            map.misses_by,
            2 * args.texels
        ));
    }
    let key = quantity.key();
    let name = args.output.file_name().unwrap_or_default().to_string_lossy();
    let mut lines = vec![format!("groom.{key} = {name:?}")];
    if map.coordinates == GroomCoordinates::Atlas {
        lines.push("groom.coordinates = \"atlas\"".to_owned());
    }
    let text = format!("{}\nread back with: {}", files.join("\n"), lines.join(", "));
    let result = GroomResult {
        files,
        map: key,
        coordinates: map.coordinates.word(),
        texels: map.image.width,
        misses_by: map.misses_by,
        recipe: lines,
        warnings: map.warnings,
    };
    output.result(&text, &result)?;
    Ok(Exit::Done)
}

/// Evaluates the groom map, and returns it with the names of the model's materials.
fn evaluate(args: &GroomArgs, quantity: Quantity, output: &mut Output) -> Result<(GroomMap, Vec<String>), Failure> {
    let (recipe, _) = args.recipe.read()?;
    output.progress("import");
    let images = args.recipe.images(&recipe)?;
    let model = io::read_model(&args.model, &ImportOptions { unit_m: recipe.model.unit_m }, args.recipe.file_access())?;
    let file = args.model.display().to_string();
    let coordinates = args
        .coordinates
        .as_deref()
        .map(|word| if word == "atlas" { GroomCoordinates::Atlas } else { GroomCoordinates::Model });
    output.progress("groom");
    let told = BakeInput::new(&file, "groom", &recipe, &images);
    let map = groom_map(&told, &model, quantity, coordinates, args.texels);
    let map = map.map_err(|error| args.recipe.with_source(&file, error))?;
    Ok((map, model.materials.into_iter().map(|material| material.name).collect()))
}
