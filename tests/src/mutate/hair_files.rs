//! Valid inputs with guided hair: a recipe that names strands in each supported format, and the strand files.

use super::case::Entry;
use anyhow::Context as _;
use glam::{Vec2, Vec3};
use pelage_bake::strands::export::StrandFormat;
use pelage_bake::strands::{CurvePoint, Curves};

/// Recipe with every key of groups and tufts, and with strands for the tile.
pub const HAIR: &str = r##"# Hair that is no coat.
[strands]
enabled = true
points = 5

[[strands.group]]
name = "mane"
material = "fu?"
mask = "vertex#r"
guides = 6
hairs = 40
points = 9
guide_points = 5
length_m = 0.2
style = "messy"
fall = [0, -1, 0.1]
comb = [1, 0, 0]
parting_m = 0.01
rise = 0.7
stiffness = 0.1
lift = 0.05
root_radius_m = 0.001
tip_radius_m = 0.0005
root_color = "#3a2a1c"
tip_color = [0.5, 0.4, 0.3]
color_variation = 0.1
length_variation = 0.2
clump = 0.4
lock_hairs = 5
stray = 0.2
seed = 3

[[strands.group]]
name = "combed"
mask = "a.png"
file = "g.hair"
scale_m = 0.9
turn_deg = [0, 10, 0]
at = [0, 0.1, 0]
loose_m = 10
every = 2
hairs = 20

[[strands.group]]
name = "lines"
file = "g.glb"
loose_m = 10
hairs = 0

[[strands.tuft]]
name = "whiskers"
joint = "ear"
at = [0.1, 0, 0.5]
material = "f*"
mirrored = true
hairs = 3
spread_m = 0.05
length_m = 0.2
direction = [0, 0, 1]
bend = 0.2
fan = 0.5
points = 5

[slice]
layers = 4
tile_texels = 16

[hair]
density = 20

[ink]
enabled = false

[pack]
bc_quality = "fast"
"##;

/// Returns a recipe that uses a single file of guides.
pub fn recipe_of(file: &str) -> String {
    let head = "[strands]\n[[strands.group]]\nname = \"guides\"\nhairs = 12\nloose_m = 10\nscale_m = 1.0\n";
    format!("{head}file = \"{file}\"\n")
}

/// Encodes the same eight strands in each format. They have two to five points, and their roots are side by side above
/// the model.
pub fn files() -> anyhow::Result<Vec<Entry>> {
    let points = |strand: u32| {
        (0..2 + strand % 4).map(move |k| CurvePoint {
            position_ws: Vec3::new(0.1 * strand as f32 - 0.4, 0.5 + 0.1 * k as f32, 0.05 * (strand * k) as f32),
            radius_m: 0.001,
            color: Vec3::splat(0.5),
            ..CurvePoint::default()
        })
    };
    let mut curves = Curves::default();
    for strand in 0..8 {
        curves.begin_group(if strand < 5 { "left" } else { "right" });
        curves.push(&points(strand).collect::<Vec<_>>(), false, Vec2::ZERO);
    }
    let mut out = Vec::new();
    for extension in ["hair", "txt", "usda", "glb"] {
        let mut bytes = Vec::new();
        let format = StrandFormat::of_extension(extension).context("a format that is written")?;
        format.write(&curves, &mut bytes)?;
        out.push(Entry::File(format!("g.{extension}"), bytes));
    }
    out.extend([tfx(3), tfx(4)].into_iter().zip(["g3.tfx", "g4.tfx"]).map(|(bytes, name)| Entry::file(name, bytes)));
    Ok(out)
}

/// Encodes a TressFX file of the given version, with four strands of three points.
fn tfx(version: u32) -> Vec<u8> {
    const STRANDS: u32 = 4;
    const POINTS: u32 = 3;
    let offset = 160;
    let mut bytes = vec![0; offset];
    bytes[..4].copy_from_slice(&(version as f32).to_le_bytes());
    bytes[4..8].copy_from_slice(&STRANDS.to_le_bytes());
    bytes[8..12].copy_from_slice(&POINTS.to_le_bytes());
    let at = if version == 3 { 144 } else { 12 };
    bytes[at..at + 4].copy_from_slice(&(offset as u32).to_le_bytes());
    for (strand, k) in (0..STRANDS).flat_map(|strand| (0..POINTS).map(move |k| (strand, k))) {
        let point = [0.1 * strand as f32, 0.5 + 0.1 * k as f32, 0.0, 1.0];
        let numbers = &point[..if version == 3 { 3 } else { 4 }];
        bytes.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
    }
    bytes
}
