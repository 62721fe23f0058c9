//! The checksum of sections and of the package's head.

/// CRC-32 as PNG and zlib have it, of parts one after another.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) fn crc32(parts: &[&[u8]]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    parts.iter().for_each(|part| hasher.update(part));
    hasher.finalize()
}

/// The same for a page, which loads the tables of a checksum before it computes any.
#[cfg(target_arch = "wasm32")]
pub(crate) fn crc32(parts: &[&[u8]]) -> u32 {
    static CRC: crc::Crc<u32, crc::Table<1>> = crc::Crc::<u32, crc::Table<1>>::new(&crc::CRC_32_ISO_HDLC);
    let mut digest = CRC.digest();
    parts.iter().for_each(|part| digest.update(part));
    digest.finalize()
}
