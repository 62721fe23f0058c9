//! Reader and writer of `.pelage` packages, and the definition of the format.
//!
//! A package is a checksummed table of sections; `formats/FORMAT.md` specifies it for readers in any language.
//! [`Package::open`] borrows the caller's bytes. Header, table and manifest are read and checked; vertex, index and
//! texture data are returned as slices of the input. The checksum and contents of a section are checked on first use,
//! once for each opened package.
//!
//! ```
//! use pelage_formats::{Limits, Manifest, Package, PackageWriter};
//! let bytes = PackageWriter::new(Manifest::default()).finish()?;
//! let package = Package::open(&bytes, &Limits::default())?;
//! assert_eq!(package.manifest(), &Manifest::default());
//! # Ok::<(), pelage_formats::FormatError>(())
//! ```
//!
//! # Trust
//!
//! No input makes this crate panic, and memory stays proportional to the input and [`Limits`]: counts and lengths in
//! the file are compared with the bytes actually present before anything is allocated.
//!
//! Every byte of a package is covered: by a field with one legal value, by the checksum of header and table, by a
//! section's checksum, or by being zero padding. [`Package::validate`] checks all of them. A checksum detects damage,
//! not malice, so contents are checked as well: indices, counts, ranges, and that numbers are finite.
//!
//! # Errors
//!
//! [`FormatError`] gives the section, the byte offset in the package, what was found and what was expected.
//!
//! This crate uses no GPU, no threads and no file system.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "packages made by tests are never kept"))]

// Vertex data is returned as stored in the file, which is little-endian.
#[cfg(target_endian = "big")]
compile_error!("pelage-formats needs a little-endian target: packages hold vertex data that is uploaded in place");

mod checksum;
mod container;
mod encoding;
mod error;
mod limits;
pub mod meaning;
mod open_validate;
mod package;
mod sampling;
mod sections;
mod tag;
mod writer;

pub use container::{FORMAT_VERSION, MAGIC, Section};
pub use error::FormatError;
pub use limits::Limits;
pub use meaning::{RootOffset, decode_direction, encode_direction};
pub use package::Package;
pub use sampling::{ClipLayer, Pose};
pub use sections::animation::{
    Animation, Channel, Clip, Interpolation, Joint, MorphChannel, MorphMotion, MorphTarget, Node, Property,
};
pub use sections::bare_normals::stored_bare_normals;
pub use sections::contours::{ContourEdge, ContourFace, ContourMark, ContourMesh, ContourView, CreasePoint};
pub use sections::fibres::{FIBRE_LAYERS, FibreInfo, FibreOptics};
pub use sections::fins::{Fin, FinData, FinsView};
pub use sections::gloss::Gloss;
pub use sections::hair::{HairGroup, TrianglePoint};
pub use sections::hair_motion::{BodyCollider, GroupMotion, HairMotion};
pub use sections::ink::{InkData, InkInfo, InkShading, InkTextures, InkVertex, InkView};
pub use sections::manifest::choice::{Choice, ChoiceLimits, Trial};
pub use sections::manifest::data::{
    Bounds, FinInfo, FurInfo, InputRecord, Manifest, Material, Part, QualityFigure, Shading, ShellTextures,
    TextureEntry,
};
pub use sections::manifest::detail::{DetailLevel, FarLayerInfo};
pub use sections::mesh::{AttributeVertex, GeometryVertex, MeshData, MeshView, SkinVertex};
pub use sections::morphs::{MorphDelta, Morphs};
pub use sections::roots::{ROOT_HEIGHTS, RootsInfo};
pub use sections::simplified::{SimplifiedLevel, SimplifiedView};
pub use sections::strands::{
    StoredStrandPoint, StoredStrands, StrandPoint, StrandScale, StrandsData, StrandsView, strand_root,
};
pub use sections::strokes::{PaintStroke, StrokeAnchor, StrokeKind, StrokePoint, StrokePool};
pub use sections::textures::{FurTextures, TextureFormat, TextureView};
pub use sections::visibility::{VisibilityInfo, VisibilityTextures};
pub use tag::Tag;
pub use writer::PackageWriter;
