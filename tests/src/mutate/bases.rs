//! Valid inputs that the mutation run damages: a small model with every feature, recipes, a scene, a look, and
//! packages.

use super::case::Entry;
use super::hair_files::{self, HAIR};
use crate::binary::{pelage, workspace};
use crate::packages::with_manifest;
use anyhow::{Context as _, ensure};
use image::{DynamicImage, ImageFormat, RgbaImage};
use pelage_formats::{Limits, Package};
use pelage_glb::{Buffer, Component, ViewTarget, bounds, container_of_text};
use serde_json::{Value, json};
use std::path::Path;
use std::process::Command;

/// Bake options for the smallest possible package.
pub const SMALL: [&str; 16] = [
    "--threads",
    "1",
    "--set",
    "slice.tile_texels=16",
    "--set",
    "slice.layers=4",
    "--set",
    "hair.density=20",
    "--set",
    "pack.bc_quality=fast",
    "--set",
    "ink.stroke_texels=32",
    "--set",
    "ink.paper_texels=32",
    "--set",
    "ink.wash_texels=32",
];

/// Recipe that names images, materials and colour marks.
pub const MAPS: &str = concat!(
    r##"# Everything that a recipe can name.
[model]
unit_m = 0.5
bare = ["eyes", "ho*"]

[surface]
tile_size_m = 0.2
comb = "marks"
comb_marks = [{ name = "nose", at = [0, 1, 0.5], direction = [0, 0, -1], length = 0.5, density = 2, lean = 0.1, "##,
    r##"color = "#fff0e0", reach_m = 0.4, mirrored = true }, "##,
    r##"{ name = "tail", at = [0, 1, -0.5], direction = [0, -1, 0] }]

[hair]
style = "curly"
density = 20
length_m = 0.05
clump_count = 5

[groom]
length = "vertex#a"
density = "a.png#r"
lean = 0.25
comb = "a.png#uv"
wetness = "b.jpg#g"
bare = "a.png"
color = "#ffeedd"

[[groom.material]]
name = "ey?s"
length = 0.5
color = "b.jpg"

[color]
root = "#8c7c6c"
tip = [1.0, 0.9, 0.8]
pattern = "a.png"
pattern_projection = "z"
pattern_size_m = 0.5
pattern_texels = 64

[slice]
layers = 4
tile_texels = 16

[fins]
depth = 0.5

[ink]
center = [0, 0, 0]
grain_size_m = 0.1
wash = "vertex#r"
solid = "a.png#g"
stroke_image = "b.jpg"
stroke_texels = 32
wash_image = "a.png"
wash_texels = 32
paper_texels = 32
fur_texels = 32

[[ink.material]]
name = "eyes"
fill = "solid"
amount = 0.8
line = 0.5

[pack]
bc_quality = "fast"
base_color_max = 64
"##
);

/// Scene with two models that use the same package.
pub const SCENE: &str = concat!(
    r##"# Two models, paths, a camera that moves.
[look.picture]
size = "16x16"

[look.shadow]
map_texels = 16

[look.ink]
width = "0.05m"
mist_m = [15, 140]

[camera]
path = [{ time_s = 0.0, eye = [0.3, 1.3, 9.0], target = [0, 0, 0], fov_deg = 34 }, "##,
    r##"{ time_s = 2.0, eye = [0.9, 1.3, 9.0], target = [0.4, 0, 0], fov_deg = 34 }]

[light]
direction = [-1.0, 2.0, 1.5]

[sequence]
frames = 4
fps = 24

[[model]]
package = "a.pelage"
position = [1, 0, 0]
heading_deg = 30
scale = 0.5

[[model]]
name = "second"
package = "a.pelage"
clip = "move"
start_s = 0.3
speed = 0.5
loop = false
path = [{ time_s = 0, position = [0.45, 0, 1.2] }, { time_s = 2, position = [1.65, 0, 1.2], heading_deg = 20 }]
"##
);

/// Look with all its tables.
pub const LOOK: &str = r##"# Every table of a look.
[picture]
size = "16x16"
style = "fur"
samples = 1
background = "#ffffff"

[light]
direction = [-0.25, 0.75, 0.6]
position_m = "none"
fill = [{ direction = [1, 2, 1], strength = 0.5 }, "1,2,1/0.5"]

[shadow]
self_shadow = true
soft_shadow = true
penumbra = 0.15
shrink = 4
map_texels = 16
map_layers = 4
density = 1.0

[fur]
layers = 4
detail = "auto"
fins = true

[ink]
threshold = 0.64
weak_difference = 0.15
width = "auto"
depth_step = 0.01
tone = 0.35
weak_lightness = 0.35
swell = 1.5
pressure = 1.0
dryness = 0.4
roughness_px = 1.2
color = "auto"
paper_grain = 1.0
mist_m = [10, 60]
show = "painting"

[study]
slant = "corrected"
view_slant = "corrected"
penumbra_form = "centred"
lighting = "pixel"
ambient_attenuation = true
back_attenuation = true
ink_rule = "any"
ink_sphere_map = "perpendicular"
ink_template = true
ink_printed_lines = false
ink_anchoring = "surface"
"##;

/// Box in OBJ format with every notation of a face corner, materials and an image.
pub const OBJ: &str = "\
# box
mtllib a.mtl
o box
v 0 0 0
v 1 0 0 1 0.5 0
v 1 1 0
v 0 1 0 1
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
vt 0 0
vt 1 0
vt 1 1
vn 0 0 1
vn 0 0.6 0.8
g side lid
usemtl a
s 1
f 1/1/1 3/2/2 2/3/1
f 1/1 4/3 3/2
usemtl b
f -4 -3 -2 -1
s off
f 1 2 6 5
f 2 3 7 \\
 6
f 3//1 4//1 8//2 7//2
f 4 1 5 8
p 1
l 1 2
";

/// Materials of [`OBJ`].
pub const MTL: &str = "# skins\nnewmtl a\nKd 1 0.5 0\nmap_Kd -s 1 1 -clamp on ./a.png\nnewmtl b\nKd 0.5\nd 0.5\n";

/// Valid inputs that the cases damage.
#[derive(Clone, Debug)]
pub struct Bases {
    /// Packages, each with a name for messages.
    pub packages: Vec<(&'static str, Vec<u8>)>,
    /// Unpacked packages with a valid recipe; their entries are in the folder `in/`.
    pub folders: Vec<(&'static str, Vec<Entry>)>,
    /// glTF document and its buffer, which contains the images.
    pub model: (Value, Vec<u8>),
    /// Compressed models as document and buffer; empty without the test data.
    pub packed: Vec<(&'static str, Value, Vec<u8>)>,
    /// Contents of `a.png`.
    pub png: Vec<u8>,
    /// Contents of `b.jpg`.
    pub jpg: Vec<u8>,
    /// Recipes. Two contain everything that a recipe can name, one for fur and one for guided hair; the third has
    /// all keys, as recorded in a package.
    pub recipes: Vec<(&'static str, String)>,
    /// Files of strands in every format that a recipe can name.
    pub guides: Vec<Entry>,
}

impl Bases {
    /// Creates the valid inputs. Packages are baked with the real binary.
    ///
    /// # Errors
    ///
    /// If a package cannot be baked, or a file cannot be read or written.
    pub fn make() -> anyhow::Result<Self> {
        let (png, jpg) = (picture(ImageFormat::Png)?, picture(ImageFormat::Jpeg)?);
        let model = model(&png, &jpg);
        let folder = tempfile::tempdir()?;
        let files = [
            ("m.glb", glb(&model.0, &model.1)),
            ("a.png", png.clone()),
            ("b.jpg", jpg.clone()),
            ("r.toml", MAPS.into()),
            ("h.toml", HAIR.into()),
        ];
        let guides = hair_files::files()?;
        guides.iter().try_for_each(|entry| entry.write(folder.path()))?;
        for (name, bytes) in files {
            std::fs::write(folder.path().join(name), bytes)?;
        }
        let maps = ["--recipe", "r.toml"];
        let mapped = bake(folder.path(), &maps)?;
        let hairy = bake(folder.path(), &["--recipe", "h.toml"])?;
        let plain = [&SMALL[..], &["--set", "pack.shell_format=rgba8", "--set", "pack.direction_format=rg8"]].concat();
        let plain = bake(folder.path(), &plain)?;
        let golden =
            |name: &str| std::fs::read(workspace().join("formats/tests/golden").join(name)).context(name.to_owned());
        let v3 = golden("v3.pelage")?;
        let all_keys = Package::open(&plain, &Limits::default())?.manifest().recipe.clone();
        let packages = vec![
            ("v1", golden("v1.pelage")?),
            ("v2", golden("v2.pelage")?),
            ("v3", v3.clone()),
            ("v3-ink", golden("v3-ink.pelage")?),
            ("mapped", mapped),
            ("plain", plain),
            ("hairy", hairy),
        ];
        // The recipe is cleared, because that of the golden package contains an unknown key for other tests.
        let v3 = with_manifest(&v3, |manifest| manifest.recipe.clear());
        let mut folders = Vec::new();
        for (name, bytes) in
            [("v3", &v3), ("v3-ink", &packages[3].1), ("mapped", &packages[4].1), ("hairy", &packages[6].1)]
        {
            folders.push((name, unpacked(folder.path(), bytes)?));
        }
        let recipes = vec![("maps", MAPS.to_owned()), ("hair", HAIR.to_owned()), ("all keys", all_keys)];
        Ok(Self { packages, folders, model, packed: compressed()?, png, jpg, recipes, guides })
    }

    /// Returns both images as files.
    pub fn images(&self) -> Vec<Entry> {
        vec![Entry::file("a.png", &*self.png), Entry::file("b.jpg", &*self.jpg)]
    }

    /// Returns the model as the file `m.glb`.
    pub fn glb(&self) -> Entry {
        Entry::File("m.glb".into(), glb(&self.model.0, &self.model.1))
    }

    /// Returns the model as a document with external files, and those files.
    pub fn gltf(&self) -> (Value, Vec<Entry>) {
        let (mut document, bin) = self.model.clone();
        document["buffers"][0]["uri"] = json!("m.bin");
        document["images"] = json!([{ "uri": "a.png" }, { "uri": "b.jpg" }]);
        let mut entries = self.images();
        entries.push(Entry::File("m.bin".into(), bin));
        (document, entries)
    }
}

/// Encodes a complete .glb file.
///
/// # Panics
///
/// If it would exceed 4 GiB.
pub fn glb(document: &Value, bin: &[u8]) -> Vec<u8> {
    glb_of_text(&document.to_string(), bin)
}

/// Encodes a .glb file like [`glb`], but from a text that may be invalid JSON.
///
/// # Panics
///
/// Same as [`glb`].
pub fn glb_of_text(text: &str, bin: &[u8]) -> Vec<u8> {
    container_of_text(text.into(), bin).unwrap_or_else(|e| panic!("a small model must be encodable: {e}"))
}

/// Encodes a picture that has varying colours, and a dark horizontal stroke of the minimum size for a scanned stroke.
fn picture(format: ImageFormat) -> anyhow::Result<Vec<u8>> {
    const SIZE: u32 = 48;
    let texel = |x: u32, y: u32| {
        let grey = if (20..28).contains(&y) { 0 } else { 255 - (x ^ y) as u8 };
        image::Rgba([grey, grey.saturating_sub(x as u8), grey.saturating_sub(y as u8), 255 - (4 * x) as u8])
    };
    let picture = DynamicImage::from(RgbaImage::from_fn(SIZE, SIZE, texel));
    let picture = if format == ImageFormat::Jpeg { picture.to_rgb8().into() } else { picture };
    let mut out = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut out, format)?;
    Ok(out.into_inner())
}

/// Returns a box of twelve triangles with two joints, two clips, two textured materials, vertex colours and a morph
/// target.
fn model(png: &[u8], jpg: &[u8]) -> (Value, Vec<u8>) {
    let mut buffer = Buffer::default();
    let bytes = |numbers: &[f32]| -> Vec<u8> { numbers.iter().flat_map(|x| x.to_le_bytes()).collect() };
    let corners: Vec<[f32; 3]> =
        (0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 0.5 } else { -0.5 })).collect();
    let vertices = Some(ViewTarget::Vertices);
    let mut floats = |numbers: &[f32], kind: &str, width: usize, target| {
        let more = if width == 3 || width == 1 { bounds(numbers, width) } else { json!({}) };
        buffer.push(&bytes(numbers), target, Component::Float, kind, numbers.len() / width, more)
    };
    let positions = floats(&corners.concat(), "VEC3", 3, vertices);
    let normals: Vec<f32> = corners.iter().flatten().map(|x| x * 2.0 / 3.0_f32.sqrt()).collect();
    let normals = floats(&normals, "VEC3", 3, vertices);
    let uvs: Vec<f32> = corners.iter().flat_map(|c| [c[0] + 0.5, 0.5 - 0.8 * c[1] - 0.2 * c[2]]).collect();
    let uvs = floats(&uvs, "VEC2", 2, vertices);
    let weights = floats(&[[0.75, 0.25, 0.0, 0.0]; 8].concat(), "VEC4", 4, vertices);
    let blend = floats(&[[0.0, 0.1, 0.0]; 8].concat(), "VEC3", 3, vertices);
    let identity = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let bind = floats(&[identity, identity].concat(), "MAT4", 16, None);
    let times = floats(&[0.0, 1.0], "SCALAR", 1, None);
    let moves = floats(&[0.0, 0.0, 0.0, 1.0, 0.5, 0.0], "VEC3", 3, None);
    let blends = floats(&[0.0, 1.0], "SCALAR", 1, None);
    let turn = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
    let turns = floats(&[turn, turn].concat(), "VEC4", 4, None);
    let colors: Vec<u8> = (0..8_u8).flat_map(|i| [255, 200 - 10 * i, 128, 255 - 16 * i]).collect();
    let normalized = json!({ "normalized": true });
    let colors = buffer.push(&colors, vertices, Component::UnsignedByte, "VEC4", 8, normalized);
    let joints = [[0_u8, 1, 0, 0]; 8].concat();
    let joints = buffer.push(&joints, vertices, Component::UnsignedByte, "VEC4", 8, json!({}));
    let mut faces = |triangles: &[[u16; 3]]| {
        let bytes: Vec<u8> = triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
        let more = json!({});
        buffer.push(&bytes, Some(ViewTarget::Indices), Component::UnsignedShort, "SCALAR", 3 * triangles.len(), more)
    };
    let body =
        [[0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4], [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2]];
    let (body, eyes) = (faces(&body), faces(&[[1, 3, 7], [1, 7, 5]]));
    let (png, jpg) = (buffer.view(png, None), buffer.view(jpg, None));
    let attributes = json!({ "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs, "COLOR_0": colors,
        "JOINTS_0": joints, "WEIGHTS_0": weights });
    let transform =
        json!({ "KHR_texture_transform": { "offset": [0.5, 0], "rotation": 1, "scale": [2, 2], "texCoord": 0 } });
    let document = json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_texture_transform"],
        "scene": 0,
        "scenes": [{ "nodes": [0, 2] }],
        "nodes": [
            { "name": "root", "children": [1], "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] },
            { "name": "ear", "translation": [0, 0.5, 0], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1] },
            { "mesh": 0, "skin": 0 },
        ],
        "skins": [{ "joints": [0, 1], "inverseBindMatrices": bind, "skeleton": 0 }],
        "meshes": [{
            "primitives": [
                {
                    "attributes": attributes, "indices": body, "material": 0, "mode": 4,
                    "targets": [{ "POSITION": blend }],
                },
                { "attributes": attributes, "indices": eyes, "material": 1, "targets": [{ "POSITION": blend }] },
            ],
            "weights": [0.5],
        }],
        "materials": [
            {
                "name": "fur",
                "pbrMetallicRoughness": {
                    "baseColorFactor": [1, 0.5, 0.25, 1],
                    "baseColorTexture": { "index": 0, "extensions": transform },
                },
            },
            {
                "name": "eyes",
                "alphaMode": "MASK",
                "alphaCutoff": 0.25,
                "doubleSided": true,
                "pbrMetallicRoughness": { "baseColorTexture": { "index": 1, "texCoord": 0 } },
            },
        ],
        "textures": [{ "source": 0, "sampler": 0 }, { "source": 1 }],
        "samplers": [{ "wrapS": 10497, "wrapT": 33071 }],
        "images": [{ "bufferView": png, "mimeType": "image/png" }, { "bufferView": jpg, "mimeType": "image/jpeg" }],
        "animations": [{
            "name": "move",
            "samplers": [
                { "input": times, "output": moves },
                { "input": times, "output": turns, "interpolation": "CUBICSPLINE" },
                { "input": times, "output": blends },
            ],
            "channels": [
                { "sampler": 0, "target": { "node": 1, "path": "translation" } },
                { "sampler": 1, "target": { "node": 0, "path": "rotation" } },
                { "sampler": 2, "target": { "node": 2, "path": "weights" } },
            ],
        }],
        "accessors": buffer.layout.accessors,
        "bufferViews": buffer.layout.views,
        "buffers": [{ "byteLength": buffer.bytes.len() }],
    });
    (document, buffer.bytes)
}

/// Reads the small compressed boxes of the test data.
fn compressed() -> anyhow::Result<Vec<(&'static str, Value, Vec<u8>)>> {
    let folder = pelage_needs::data_folder().join("meshes/compressed");
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let read = |name: &str| std::fs::read(folder.join(name)).with_context(|| folder.join(name).display().to_string());
    let mut draco: Value = serde_json::from_slice(&read("BoxDraco/BoxDraco.gltf")?)?;
    draco["buffers"][0].as_object_mut().context("BoxDraco.gltf: a buffer")?.remove("uri");
    let bytes = read("BoxDraco/0.bin")?;
    let (document, bin) = chunks(&read("BoxMeshopt.glb")?).context("BoxMeshopt.glb: two chunks")?;
    Ok(vec![("draco", draco, bytes), ("meshopt", document, bin)])
}

/// Splits a valid .glb file into document and buffer.
pub fn chunks(glb: &[u8]) -> Option<(Value, Vec<u8>)> {
    let length = u32::from_le_bytes(*glb.get(12..)?.first_chunk()?) as usize;
    let document = serde_json::from_slice(glb.get(20..20 + length)?).ok()?;
    Some((document, glb.get(28 + length..)?.to_vec()))
}

fn bake(folder: &Path, more: &[&str]) -> anyhow::Result<Vec<u8>> {
    pelage_in(folder, &[&["bake", "m.glb", "-o", "m.pelage", "--quiet"], more].concat())?;
    Ok(std::fs::read(folder.join("m.pelage"))?)
}

fn unpacked(folder: &Path, package: &[u8]) -> anyhow::Result<Vec<Entry>> {
    std::fs::write(folder.join("p.pelage"), package)?;
    pelage_in(folder, &["unpack", "p.pelage", "in", "--quiet"])?;
    let mut entries = Vec::new();
    for file in std::fs::read_dir(folder.join("in"))? {
        let file = file?;
        let name = format!("in/{}", file.file_name().to_string_lossy());
        entries.push(Entry::File(name, std::fs::read(file.path())?));
    }
    // The order in which the system lists a folder is undefined.
    entries.sort_by(|a, b| a.name().cmp(b.name()));
    std::fs::remove_dir_all(folder.join("in"))?;
    Ok(entries)
}

fn pelage_in(folder: &Path, args: &[&str]) -> anyhow::Result<()> {
    let output = Command::new(pelage()).args(args).current_dir(folder).output()?;
    ensure!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    Ok(())
}
