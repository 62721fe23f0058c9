//! Import of model files: glTF 2.0, as `.gltf` or `.glb`, and Wavefront OBJ.
//!
//! [`import`] reads bytes and accesses no file. A callback provides the buffers, images and material files that the
//! model names. From an OBJ it reads the shape at rest, with base colours (`obj`). From a glTF it reads, in this order:
//! the container, required extensions, the node tree, the meshes of the scene with their materials, skins and clips.
//! The result is a [`Model`].
//!
//! * If a mesh of the scene has a skin, or a clip moves a mesh, every vertex is bound to joints and stays in mesh
//!   space. The only joint of a rigid part is its node. Otherwise all vertices are in world space, without animation.
//! * If a glTF part has no normals, they are flat, as glTF requires. They are smooth where that looks the same, and in
//!   an OBJ. The stage `surface` joins the normals of hair at edges.
//! * Areas and lengths are those at rest. Nodes hidden at rest by a scale of zero, or below 2% of their largest, have
//!   the largest scale of their clips instead ([`crate::mesh::RestPose::pose`]). Surface that morph targets hide at
//!   rest is placed where a clip shows it ([`crate::mesh::RowDelta::hidden_at`]).
//! * VRM 0.x models are turned by 180° about y, so that they look along +z.
//! * Vertices of a skin without any weight follow the first joint that they name. Of more than four weights, the
//!   largest four are kept.
//! * Nodes hidden by `KHR_node_visibility` are left out with their descendants.
//! * Parts are flipped if the scene or the rest pose mirrors them, or if they face against their normals.
//! * Lines of nodes and meshes whose name begins with `comb`, and empty nodes named `comb` or `comb_…`, define the comb
//!   direction ([`crate::mesh::CombLine`]). Other lines are ignored.
//! * Morph targets are applied at their default weights. The remaining deltas are kept ([`crate::mesh::MorphRows`]),
//!   and then every vertex has joints. In a document without nodes morph targets do not move.
//!
//! Repairs, omissions and guesses are reported in [`Model::warnings`]. Faults in parts that a picture can do without
//! leave the part out: materials, images, clips, morph targets, node transforms, normals, texture coordinates, colours.
//!
//! Other invalid input is an error with its position (byte offset, JSON pointer or line), the value found and the value
//! expected. Every number of a file is checked against the available bytes, or against [`pelage_formats::Limits`],
//! before it is used.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "packages made by tests are never kept"))]

mod accessor;
pub mod angle;
mod assemble;
mod clips;
mod comb_lines;
mod compressed;
mod container;
mod elements;
pub mod error;
mod extensions;
pub mod guides;
mod hidden;
pub mod image_file;
mod json;
mod lines;
mod material;
mod memory;
pub mod mesh;
mod meshopt;
mod morphs;
mod normals;
mod notes;
mod obj;
mod options;
mod orient;
mod per_vertex;
mod primitive;
mod reduce;
mod scene;
mod skin;
mod source;
mod unfold;
pub mod union_find;
mod views;
mod weights;

use crate::guides::Guides;
use crate::mesh::Model;
use container::ModelFile;
use json::JsonNode;
use notes::Notes;
use pelage_formats::InputRecord;
use serde_json::Value;
use source::Source;

pub use error::BakeError;
pub use notes::input_record;
pub use options::ImportOptions;
pub use source::{Resolve, path_as_uri};

/// Reads a glTF 2.0 or OBJ model from `bytes`. The format is detected from the contents, or from the file name if the
/// contents are ambiguous.
///
/// `file` is the name for messages. `resolve` fetches the contents of a relative URI, percent-encoded as in a glTF. Its
/// second argument is the maximum number of bytes, at which it cuts off longer contents. If it fails with
/// [`std::io::ErrorKind::NotFound`], it is called again with other spellings of the name.
///
/// Fails with [`BakeError::Input`] with byte offset, JSON pointer or line for any fault in the model or in a file that
/// it names. [`BakeError::Params`] for options outside their range.
pub fn import<'r>(
    file: &str,
    bytes: &[u8],
    resolve: &'r mut Resolve<'r>,
    options: &ImportOptions,
) -> Result<Model, BakeError> {
    options.validate()?;
    let mut notes = Notes::default();
    let kind = container::detect(file, bytes, &mut notes)?;
    notes.record("model", file, bytes);
    let model = match kind {
        ModelFile::Gltf(container) => {
            let document = json::parse(file, container.json, container.json_offset, &mut notes)?;
            let mut source = open_document(file, &document, container.bin, resolve, notes)?;
            let mut model = assemble::model(&mut source, options)?;
            (model.warnings, model.inputs) = source.notes.finish();
            model
        }
        ModelFile::Obj => obj::read(file, bytes, resolve, options, notes)?,
    };
    Ok(model)
}

/// Reads the line segments of a glTF 2.0 scene as strands. Also returns the records of all files that were read.
/// Segments that share vertices form one strand, which has the direction of most of its segments.
///
/// The arguments are those of [`import`]. Positions are in world space and in the file's unit. The attributes `_RADIUS`
/// and `COLOR_0` are read if all line primitives have them.
///
/// Fails with [`BakeError::Input`] as for [`import`], and also for a scene without lines, an odd number of line ends,
/// or lines that are all left out.
pub fn import_strands<'r>(
    file: &str,
    bytes: &[u8],
    resolve: &'r mut Resolve<'r>,
) -> Result<(Guides, Vec<InputRecord>), BakeError> {
    let mut notes = Notes::default();
    let ModelFile::Gltf(container) = container::detect(file, bytes, &mut notes)? else {
        let reason = "this is an OBJ, expected glTF 2.0 with lines".to_owned();
        return Err(BakeError::Input { file: file.to_owned(), place: "byte 0".into(), reason });
    };
    notes.record("strands", file, bytes);
    let document = json::parse(file, container.json, container.json_offset, &mut notes)?;
    let mut source = open_document(file, &document, container.bin, resolve, notes)?;
    let mut guides = lines::strands(&mut source)?;
    let (warnings, inputs) = source.notes.finish();
    guides.warnings = warnings;
    Ok((guides.checked(file)?, inputs))
}

/// Opens a parsed document; checks its version and required extensions.
fn open_document<'a, 'r>(
    file: &'a str,
    document: &'a Value,
    bin: Option<&'a [u8]>,
    resolve: &'r mut Resolve<'r>,
    notes: Notes,
) -> Result<Source<'a, 'r>, BakeError> {
    let mut source = Source::new(JsonNode::root(file, document), bin, resolve, notes);
    check_version(&source)?;
    source.check_extensions()?;
    Ok(source)
}

fn check_version(source: &Source<'_, '_>) -> Result<(), BakeError> {
    let asset = source.root.require("asset")?;
    let version_at = asset.require("version")?;
    let major = |at: &JsonNode<'_>| at.string().map(|v| v.split('.').next().and_then(|m| m.parse::<u32>().ok()));
    match major(&version_at)? {
        Some(2) => {}
        Some(1) => {
            return Err(version_at.unexpected("2.x; convert glTF 1.0 with `gltf-pipeline -i in.gltf -o out.gltf`"));
        }
        _ => return Err(version_at.unexpected("2.x")),
    }
    match asset.get("minVersion") {
        Some(at) if at.string()? != "2.0" => Err(at.unexpected("2.0, the newest version that pelage reads")),
        _ => Ok(()),
    }
}
