//! A .ktx2 file, decoded with the `ktx2` crate and restricted to what the runtime can upload unchanged.

use super::format::TextureFormat;
use crate::error::FormatError;
use crate::limits::Limits;
use crate::tag::Tag;
use std::fmt;

/// Texture of an opened package. Its levels are slices of the package's bytes.
#[derive(Clone, Copy)]
pub struct TextureView<'a> {
    /// Texel format.
    pub format: TextureFormat,
    /// Width of level 0, texels.
    pub width: u32,
    /// Height of level 0, texels.
    pub height: u32,
    /// Number of array layers, at least 1.
    pub layers: u32,
    /// Number of mip levels, at least 1.
    pub levels: u32,
    /// Complete .ktx2 file.
    pub ktx2: &'a [u8],
}

impl fmt::Debug for TextureView<'_> {
    /// Formats the header only.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { format, width, height, layers, levels, ktx2 } = self;
        let bytes = ktx2.len();
        write!(f, "TextureView({} {width}x{height}, {layers} layers, {levels} levels, {bytes} bytes)", format.name())
    }
}

/// Size of an entry of the level index, which follows the header, bytes.
const LEVEL_ENTRY: usize = ktx2::LevelIndex::LENGTH;

/// Position of a .ktx2 file in the package, for error messages.
#[derive(Clone, Copy)]
struct FileOffset(u64);

impl FileOffset {
    fn fail(self, at: u64, reason: String) -> FormatError {
        FormatError::Content { tag: Tag::TEXTURE, offset: self.0.saturating_add(at), reason }
    }
}

/// Checked contents of a texture's header.
#[derive(Clone, Copy)]
pub(super) struct TextureHeader {
    format: TextureFormat,
    width: u32,
    height: u32,
    layers: u32,
    levels: u32,
}

impl<'a> TextureView<'a> {
    pub(super) fn of(ktx2: &'a [u8], shape: TextureHeader) -> Self {
        let TextureHeader { format, width, height, layers, levels } = shape;
        Self { format, width, height, layers, levels, ktx2 }
    }

    pub(super) fn shape(&self) -> TextureHeader {
        let Self { format, width, height, layers, levels, .. } = *self;
        TextureHeader { format, width, height, layers, levels }
    }

    /// Reads a .ktx2 file. `offset` is its position in the package and only used in errors: 0 for a file on its own.
    ///
    /// Accepts 2D textures and 2D arrays in a [`TextureFormat`], without supercompression. Their levels must be laid
    /// out as KTX 2.0 requires (smallest first, aligned, none overlapping), and their data format descriptor must agree
    /// with the format. Block-compressed textures must have whole blocks at level 0, as WebGPU requires. Key/value data
    /// is ignored.
    ///
    /// Fails with [`FormatError::Limit`] for sizes above `limits`, [`FormatError::Content`] for everything else.
    pub fn parse(ktx2: &'a [u8], offset: u64, limits: &Limits) -> Result<Self, FormatError> {
        // From the `ktx2` crate, use only the types of header and level index. The crate's `Reader` panics on a
        // descriptor with block dimension 255, and its errors have no position.
        let place = FileOffset(offset);
        let header: &[u8; ktx2::Header::LENGTH] = ktx2.first_chunk().ok_or_else(|| {
            place.fail(0, format!("{} bytes, expected a KTX2 header of {}", ktx2.len(), ktx2::Header::LENGTH))
        })?;
        let header = ktx2::Header::from_bytes(header)
            .map_err(|e| place.fail(0, format!("{e}, expected the header of a KTX2 file")))?;
        let format = header.format.and_then(TextureFormat::from_ktx2).ok_or_else(|| {
            let names: Vec<_> = TextureFormat::ALL.iter().map(|f| f.name()).collect();
            let found = header.format.map_or_else(|| "undefined".to_owned(), name_of);
            place.fail(12, format!("texel format is {found}, expected one of {}", names.join(", ")))
        })?;
        if let Some(scheme) = header.supercompression_scheme {
            return Err(place.fail(44, format!("supercompressed with {scheme:?}, expected data ready to upload")));
        }
        if header.type_size != format.type_size() {
            let (found, expected) = (header.type_size, format.type_size());
            return Err(place.fail(16, format!("type size is {found}, expected {expected} for this format")));
        }
        let (depth, faces) = (header.pixel_depth, header.face_count);
        if depth != 0 || faces != 1 || header.pixel_height == 0 {
            let found = format!("height {}, depth {depth} and {faces} faces", header.pixel_height);
            return Err(place.fail(24, format!("{found}, expected a 2D texture or 2D array")));
        }
        let view = Self {
            format,
            width: header.pixel_width,
            height: header.pixel_height,
            layers: header.layer_count.max(1),
            levels: header.level_count.max(1),
            ktx2,
        };
        for (what, at, found, limit) in [
            ("texture width", 20, view.width, limits.texture_size),
            ("texture height", 24, view.height, limits.texture_size),
            ("texture layers", 32, view.layers, limits.texture_layers),
        ] {
            if found > limit {
                let (tag, offset, found, limit) = (Tag::TEXTURE, offset.saturating_add(at), found.into(), limit.into());
                return Err(FormatError::Limit { tag, what, offset, found, limit });
            }
        }
        let block = format.block_size();
        if !view.width.is_multiple_of(block) || !view.height.is_multiple_of(block) {
            let (w, h) = (view.width, view.height);
            return Err(place.fail(20, format!("{w}x{h} texels, expected multiples of {block} for {}", format.name())));
        }
        let full_chain = 32 - view.width.max(view.height).leading_zeros();
        // 0 levels would mean that the reader generates the mips.
        if header.level_count == 0 || header.level_count > full_chain {
            return Err(place.fail(40, format!("{} mip levels, expected 1 to {full_chain}", header.level_count)));
        }
        let meta_end = view.check_metadata(place, &header.index)?;
        view.check_levels(place, meta_end)?;
        Ok(view)
    }

    /// Checks the positions of descriptor, key/value data and global data, and the contents of the descriptor. Returns
    /// the end of these data.
    fn check_metadata(&self, place: FileOffset, index: &ktx2::Index) -> Result<u64, FormatError> {
        let index_end = (ktx2::Header::LENGTH + LEVEL_ENTRY * self.levels as usize) as u64;
        let mut end = index_end;
        for (what, at, offset, length) in [
            ("data format descriptor", 48, u64::from(index.dfd_byte_offset), u64::from(index.dfd_byte_length)),
            ("key/value data", 56, index.kvd_byte_offset.into(), index.kvd_byte_length.into()),
        ] {
            if length == 0 && offset == 0 {
                continue;
            }
            // Both numbers are u32 in the file, so the sum cannot overflow.
            if length == 0 || offset < end || offset + length > self.ktx2.len() as u64 {
                let file = self.ktx2.len();
                let reason = format!(
                    "{what} has {length} bytes at byte {offset}, expected it between byte {end} and \
                     the end of the file at {file}"
                );
                return Err(place.fail(at, reason));
            }
            end = offset + length;
        }
        if (index.sgd_byte_offset, index.sgd_byte_length) != (0, 0) {
            let (offset, length) = (index.sgd_byte_offset, index.sgd_byte_length);
            let reason = format!(
                "global data has {length} bytes at byte {offset}, expected none without \
                 supercompression"
            );
            return Err(place.fail(64, reason));
        }
        self.check_descriptor(place, index.dfd_byte_offset, index.dfd_byte_length)?;
        Ok(end)
    }

    /// Checks that the descriptor, which repeats the format, agrees with it. Otherwise, tools would disagree about the
    /// colours.
    fn check_descriptor(&self, place: FileOffset, offset: u32, length: u32) -> Result<(), FormatError> {
        let (expected, _) = ktx2::dfd::Basic::from_format(self.format.ktx2())
            .map_err(|e| place.fail(12, format!("no data format descriptor for {}: {e}", self.format.name())))?;
        let mut expected = ktx2::dfd::Block::Basic(expected).to_vec();
        let mut whole = (expected.len() as u32 + 4).to_le_bytes().to_vec();
        whole.append(&mut expected);
        let found = (self.ktx2.get(offset as usize..)).and_then(|rest| rest.get(..length as usize)).unwrap_or(&[]);
        if found.len() < whole.len() {
            let reason = format!("data format descriptor has {} bytes, expected {}", found.len(), whole.len());
            return Err(place.fail(52, reason));
        }
        for (at, (found, expected)) in found.iter().zip(&whole).enumerate() {
            if !DESCRIPTOR_FREE.contains(&at) && found != expected {
                let reason = format!(
                    "byte {at} of the data format descriptor is {found:#04x}, expected {expected:#04x} for {}",
                    self.format.name()
                );
                return Err(place.fail(u64::from(offset) + at as u64, reason));
            }
        }
        if found.len() > whole.len() {
            let reason = format!("data format descriptor has {} bytes, expected {}", found.len(), whole.len());
            return Err(place.fail(52, reason));
        }
        Ok(())
    }

    fn check_levels(&self, place: FileOffset, mut end: u64) -> Result<(), FormatError> {
        // Least common multiple of the block size and 4, in bytes: 4 for sizes 2 and 4, 8 for 8, 16 for 16.
        let alignment = u64::from(self.format.block_bytes().max(4));
        for level in (0..self.levels).rev() {
            let at = (ktx2::Header::LENGTH + LEVEL_ENTRY * level as usize) as u64;
            let Some(entry) = self.level_entry(level) else {
                let (levels, file) = (self.levels, self.ktx2.len());
                return Err(place.fail(at, format!("the file has {file} bytes, expected an index of {levels} levels")));
            };
            let expected = self.level_bytes(level);
            for (field, found) in [(8, entry.byte_length), (16, entry.uncompressed_byte_length)] {
                if found != expected {
                    return Err(place.fail(at + field, format!("level {level} has {found} bytes, expected {expected}")));
                }
            }
            let start = end.next_multiple_of(alignment);
            if entry.byte_offset != start {
                let found = entry.byte_offset;
                return Err(place.fail(at, format!("level {level} begins at {found}, expected {start}")));
            }
            if entry.byte_length > (self.ktx2.len() as u64).saturating_sub(start) {
                let file = self.ktx2.len();
                let reason = format!(
                    "level {level} needs {expected} bytes from byte {start} on, but the file has \
                     {file} bytes"
                );
                return Err(place.fail(at, reason));
            }
            end = start + entry.byte_length;
        }
        match self.ktx2.len() as u64 - end {
            0 => Ok(()),
            rest => Err(place.fail(end, format!("{rest} bytes follow level 0, expected none"))),
        }
    }

    fn level_entry(&self, level: u32) -> Option<ktx2::LevelIndex> {
        let at = ktx2::Header::LENGTH.checked_add(LEVEL_ENTRY.checked_mul(level as usize)?)?;
        Some(ktx2::LevelIndex::from_bytes(self.ktx2.get(at..)?.first_chunk()?))
    }

    /// Returns width and height of a level, texels.
    pub fn level_size(&self, level: u32) -> (u32, u32) {
        let size = |texels: u32| texels.checked_shr(level).unwrap_or(0).max(1);
        (size(self.width), size(self.height))
    }

    /// Returns the size of a mip level with all its layers, bytes; `u64::MAX` if larger.
    pub fn level_bytes(&self, level: u32) -> u64 {
        let (width, height) = self.level_size(level);
        self.format.layer_bytes(width, height).saturating_mul(self.layers.into())
    }

    /// Returns the size of all levels, bytes: the memory of the texture on the GPU.
    pub fn gpu_bytes(&self) -> u64 {
        self.gpu_bytes_as(self.format)
    }

    /// Returns [`Self::gpu_bytes`] for the same texels in another format.
    pub fn gpu_bytes_as(&self, format: TextureFormat) -> u64 {
        let level = |level| {
            let (width, height) = self.level_size(level);
            format.layer_bytes(width, height).saturating_mul(self.layers.into())
        };
        (0..self.levels.min(32)).map(level).fold(0, u64::saturating_add)
    }

    /// Returns the data of a level: layer after layer, rows of blocks without padding. Empty for a level that does not
    /// exist.
    pub fn level(&self, level: u32) -> &'a [u8] {
        let find = || {
            let entry = self.level_entry(level)?;
            let from = usize::try_from(entry.byte_offset).ok()?;
            self.ktx2.get(from..)?.get(..usize::try_from(entry.byte_length).ok()?)
        };
        // `parse` has checked the bounds of every level that exists.
        if level < self.levels { find().unwrap_or(&[]) } else { &[] }
    }
}

/// Bytes of the descriptor that a writer may choose: the colour primaries and the flags (premultiplied alpha).
const DESCRIPTOR_FREE: [usize; 2] = [13, 15];

/// Returns the name of a format. On WebAssembly, it is only the number in `VkFormat`, because the names of all formats
/// would be a hundredth of the download.
fn name_of(format: ktx2::Format) -> String {
    if cfg!(target_family = "wasm") { format!("VkFormat {}", format.value()) } else { format!("{format:?}") }
}
