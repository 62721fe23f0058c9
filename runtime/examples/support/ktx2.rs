//! Minimal writer of KTX2 files for packages. Supports uncompressed 8-bit array textures; the caller provides the mip
//! levels.

use pelage_runtime::formats::TextureFormat;

/// Writes a .ktx2 file of a 2D array texture.
///
/// * `levels`: mip levels, largest first. Each has `layers * height * width` texels in `format`, with the level's width
///   and height
pub fn write(format: TextureFormat, width: u32, height: u32, layers: u32, levels: &[Vec<u8>]) -> Vec<u8> {
    assert_eq!(format.block_size(), 1, "{} is compressed", format.name());
    let texel = format.block_bytes();
    let descriptor = descriptor(texel, format == TextureFormat::Rgba8Srgb);
    let descriptor_offset = 80 + 24 * levels.len();
    let mut out = b"\xABKTX 20\xBB\r\n\x1A\n".to_vec();
    // Fields of the header: vkFormat, typeSize, extent, layers, faces, levels, supercompression. The offset of the
    // descriptor follows; key-value data is omitted.
    let array_layers = if layers == 1 { 0 } else { layers };
    for field in [format.ktx2().value(), 1, width, height, 0, array_layers, 1, levels.len() as u32, 0] {
        out.extend(field.to_le_bytes());
    }
    for field in [descriptor_offset as u32, descriptor.len() as u32, 0, 0, 0, 0, 0, 0] {
        out.extend(field.to_le_bytes());
    }
    // Levels are stored smallest first, each aligned to four bytes.
    let mut offset = descriptor_offset + descriptor.len();
    let mut index = vec![[0u64; 3]; levels.len()];
    for (entry, level) in index.iter_mut().zip(levels).rev() {
        offset = offset.next_multiple_of(4);
        *entry = [offset as u64, level.len() as u64, level.len() as u64];
        offset += level.len();
    }
    index.iter().flatten().for_each(|field| out.extend(field.to_le_bytes()));
    out.extend(descriptor);
    for (entry, level) in index.iter().zip(levels).rev() {
        out.resize(entry[0] as usize, 0);
        out.extend(level);
    }
    out
}

/// Returns the basic data format descriptor for texels of `channels` unorm bytes.
fn descriptor(channels: u32, srgb: bool) -> Vec<u8> {
    let block_bytes = 24 + 16 * channels;
    let (model_rgb, primaries_bt709, transfer) = (1, 1 << 8, if srgb { 2 << 16 } else { 1 << 16 });
    let mut words =
        vec![4 + block_bytes, 0, 2 + (block_bytes << 16), model_rgb | primaries_bt709 | transfer, 0, channels, 0];
    for (channel, id) in [0, 1, 2, 15].into_iter().enumerate().take(channels as usize) {
        // Alpha is never sRGB-encoded: bit 4 of the qualifiers marks it as linear.
        let linear_alpha = if srgb && id == 15 { 0x10 } else { 0 };
        words.extend([8 * channel as u32 + (7 << 16) + ((id | linear_alpha) << 24), 0, 0, 255]);
    }
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}
