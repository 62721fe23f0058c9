//! `pelage export`: writes strands and mesh to files for other programs.

use super::exit::{Exit, Failure};
use super::guard::OutputFile;
use super::output::{Output, require_parent};
use super::package_file;
use super::reference::CameraResult;
use super::truth::ReferenceTracer;
use super::view::PictureView;
use super::view_args::parse_seconds;
use glam::DVec3;
use pelage_bake::io::write_atomic_with;
use pelage_bake::io_guard;
use pelage_bake::strands::export::{StrandFormat, write_mtl, write_obj};
use pelage_bake::strands::{CurveGroup, CurvePoint, Curves, GroomReport};
use pelage_formats::meaning::scattering::colour;
use pelage_stage::Size;
use pelage_truth::TrueScattering;
use serde::Serialize;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Export a package's strands and mesh for other programs
#[derive(Clone, Debug, clap::Args)]
pub struct ExportArgs {
    /// Package to export
    #[arg(value_name = "PKG")]
    package: PathBuf,
    /// Strands to write: .txt (a line x y z radius per point, a blank line between strands), .pbrt, .glb, .hair or
    /// .usda (curves that Blender opens as hair). All but .txt name the groups of strands, and so does --json
    #[arg(long, value_name = "FILE", required_unless_present = "mesh")]
    strands: Option<OutputFile>,
    /// Posed mesh to write: .obj; its materials go into a .mtl file beside it
    #[arg(long, value_name = "OBJ")]
    mesh: Option<OutputFile>,
    /// Write only the strands of this group, such as coat; may be repeated
    #[arg(long = "group", value_name = "NAME")]
    groups: Vec<String>,
    /// Write only every N-th strand
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    every: u32,
    /// Write at most this many strands, spread evenly over the mesh surface
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    max_strands: Option<u32>,
    /// Animation clip, by name [default: the rest pose]
    #[arg(long, value_name = "NAME")]
    clip: Option<String>,
    /// Time in the clip, seconds
    #[arg(long, value_name = "S", default_value_t = 0.0, value_parser = parse_seconds, allow_hyphen_values = true)]
    time: f32,
    /// Size of the picture for the camera in the --json result, pixels
    #[arg(long, value_name = "WxH", default_value = "834x424")]
    size: Size,
}

/// Files written, and the strands and mesh in them.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ExportResult<'a> {
    files: &'a [String],
    strands: usize,
    /// Named groups of strands, in file order. Every strand is in one group, and no group is empty.
    groups: Vec<StrandGroup<'a>>,
    /// Number of straight segments of the strands after simplification.
    segments: usize,
    /// Number of strands on the whole mesh surface, of which those in the file are a selection.
    of_strands: u64,
    groom: GroomReport,
    vertices: usize,
    triangles: usize,
    camera: CameraResult,
    /// Width of the picture that `camera` applies to, pixels.
    width: u32,
    /// Height of the picture that `camera` applies to, pixels.
    height: u32,
}

/// A named group of strands.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct StrandGroup<'a> {
    /// Name of the group; `coat` for the strands of the repeating tile.
    name: &'a str,
    /// Index of the first strand in the file.
    first: u32,
    /// Number of consecutive strands.
    strands: usize,
    /// Fibre parameters of the group; absent if the package has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    fibre: Option<GroupFibre>,
}

/// Fibre parameters as pbrt-4 and Mitsuba 3 define them. Both tilt lobes by twice the scale angle.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct GroupFibre {
    index_of_refraction: f64,
    longitudinal_roughness: f64,
    azimuthal_roughness: f64,
    scale_tilt_deg: f64,
    /// Absorption along one radius, for red, green and blue; mean over the group.
    absorption_per_radius: [f64; 3],
}

/// Runs the subcommand.
pub fn run(args: &ExportArgs, output: &mut Output) -> Result<Exit, Failure> {
    let strands = args.strands.as_deref().map(|path| Ok::<_, Failure>((path, strand_format(path)?))).transpose()?;
    let mesh = args.mesh.as_deref().map(|path| Ok::<_, Failure>((path, beside(path)?))).transpose()?;
    for path in [args.strands.as_deref(), args.mesh.as_deref()].into_iter().flatten() {
        require_parent(path)?;
    }
    let file = package_file::read(&args.package)?;
    let size = (args.size.width, args.size.height);
    let view = PictureView { clip: args.clip.clone(), time_s: args.time, ..PictureView::sized(size) };
    output.progress("growing strands");
    let truth = ReferenceTracer::new(&file, &view)?;
    if let Some((_, materials)) = &mesh {
        io_guard::check_write(materials)?;
    }
    let mut files = Vec::new();
    let chosen = args.chosen(truth.scene.curves())?;
    let curves = args.thinned(&chosen);
    if let Some((path, format)) = strands {
        output.progress("writing strands");
        let points = curves.points.len();
        if points > MANY_POINTS {
            output.note(&format!(
                "note: {} strands of {points} points make a large file; --max-strands {} writes fewer",
                curves.len(),
                curves.len().div_ceil(10)
            ));
        }
        write_atomic_with(path, |out| format.write(&curves, out))?;
        files.push(path.to_owned());
    }
    if let Some((path, materials)) = mesh {
        output.progress("writing the mesh");
        let name = materials.file_name().unwrap_or_default().to_string_lossy().into_owned();
        write_atomic_with(&materials, |out| write_mtl(truth.scene.skin(), out))?;
        write_atomic_with(path, |out| write_obj(truth.scene.skin(), &name, out))?;
        files.extend([path.to_owned(), materials]);
    }
    let names: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
    let result = ExportResult {
        files: &names,
        strands: curves.len(),
        groups: curves.groups().iter().map(|group| StrandGroup::new(group, &curves, truth.scattering())).collect(),
        segments: curves.segments(),
        of_strands: truth.report.strands,
        groom: truth.report,
        vertices: truth.scene.skin().vertices.len(),
        triangles: truth.scene.skin().triangles.len(),
        camera: (&truth.camera(&view)).into(),
        width: args.size.width,
        height: args.size.height,
    };
    let of = if (curves.len() as u64) < truth.report.strands {
        format!(" of {}", truth.report.strands)
    } else {
        String::new()
    };
    let mut count = format!("{}{of} strands in {} segments", curves.len(), curves.segments());
    if let groups @ [_, _, ..] = curves.groups() {
        let each: Vec<String> = groups.iter().map(|group| format!("{} {}", group.name, group.strands.len())).collect();
        count += &format!(": {}", each.join(", "));
    }
    output.result(&format!("{}\n{count}", names.join("\n")), &result)?;
    Ok(Exit::Done)
}

/// Number of points above which a note is printed, because a text file exceeds 100 MB.
const MANY_POINTS: usize = 2_000_000;

impl<'a> StrandGroup<'a> {
    fn new(group: &'a CurveGroup, curves: &Curves, scattering: Option<&TrueScattering>) -> Self {
        let fibre = scattering.map(|scattering| {
            let (fibre, scale) = scattering.of_group(&group.name);
            let points = curves.points_of(group);
            let absorbed = |sum: DVec3, point: &CurvePoint| {
                sum + DVec3::from(colour::absorption(point.color.as_dvec3().to_array(), scale))
            };
            let mean = points.iter().fold(DVec3::ZERO, absorbed) / points.len().max(1) as f64;
            GroupFibre {
                index_of_refraction: fibre.eta,
                longitudinal_roughness: colour::roughness_along(2.0 * fibre.along),
                azimuthal_roughness: colour::roughness(scale),
                scale_tilt_deg: fibre.tilt.to_degrees(),
                absorption_per_radius: mean.to_array(),
            }
        });
        Self { name: &group.name, first: group.strands.start, strands: group.strands.len(), fibre }
    }
}

impl ExportArgs {
    /// Returns the strands of the requested groups.
    fn chosen<'a>(&self, curves: &'a Curves) -> Result<Cow<'a, Curves>, Failure> {
        if self.groups.is_empty() {
            return Ok(Cow::Borrowed(curves));
        }
        let known: BTreeSet<&str> = curves.groups().iter().map(|group| group.name.as_str()).collect();
        let names: Vec<&str> = self.groups.iter().map(String::as_str).collect();
        if let Some(unknown) = names.iter().find(|name| !known.contains(*name)) {
            let known = known.into_iter().collect::<Vec<_>>().join(", ");
            let expected = if known.is_empty() { "no --group, because there are no strands".into() } else { known };
            return Err(Failure::Usage(format!(
                "--group {unknown}: no such group of strands in {}, expected {expected}",
                self.package.display()
            )));
        }
        Ok(Cow::Owned(curves.only_groups(&names)))
    }

    /// Returns the strands that remain with `--every` and `--max-strands`.
    fn thinned<'a>(&self, curves: &'a Curves) -> Cow<'a, Curves> {
        let every = self.every as usize;
        let kept = curves.len().div_ceil(every);
        let more = self.max_strands.map_or(1, |most| kept.div_ceil(most as usize).max(1));
        if every * more == 1 { Cow::Borrowed(curves) } else { Cow::Owned(curves.every_nth(every * more)) }
    }
}

fn strand_format(path: &Path) -> Result<StrandFormat, Failure> {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    StrandFormat::of_extension(&extension).ok_or_else(|| {
        let known: Vec<String> = StrandFormat::EXTENSIONS.iter().map(|(e, _)| format!(".{e}")).collect();
        Failure::Usage(format!("--strands {}: expected a name that ends in {}", path.display(), known.join(", ")))
    })
}

/// Returns the path of the .mtl file beside an .obj file.
fn beside(path: &Path) -> Result<PathBuf, Failure> {
    match path.extension() {
        Some(extension) if extension.eq_ignore_ascii_case("obj") => Ok(path.with_extension("mtl")),
        _ => Err(Failure::Usage(format!("--mesh {}: expected a name that ends in .obj", path.display()))),
    }
}
