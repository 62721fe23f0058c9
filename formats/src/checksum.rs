//! Checksum of sections and of the package header.

/// CRC-32 of the concatenated parts, as in PNG and zlib.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) fn crc32(parts: &[&[u8]]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    parts.iter().for_each(|part| hasher.update(part));
    hasher.finalize()
}

#[cfg(target_arch = "wasm32")]
pub(crate) use crc32_single_table as crc32;

/// CRC-32 with a single table, which keeps the download small on WebAssembly.
#[cfg(any(test, target_arch = "wasm32"))]
pub(crate) fn crc32_single_table(parts: &[&[u8]]) -> u32 {
    static CRC: crc::Crc<u32, crc::Table<1>> = crc::Crc::<u32, crc::Table<1>>::new(&crc::CRC_32_ISO_HDLC);
    let mut digest = CRC.digest();
    parts.iter().for_each(|part| digest.update(part));
    digest.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_table_checksum_equals_the_native_one() {
        let bytes: Vec<u8> = (0..1000u32).map(|i| ((i * i) >> 3) as u8).collect();
        assert_eq!(crc32(&[b"123456789"]), 0xcbf4_3926);
        for cut in [0, 1, 24, 999, 1000] {
            let (first, second) = bytes.split_at(cut);
            assert_eq!(crc32_single_table(&[first, second]), crc32(&[&bytes]), "cut at {cut}");
        }
    }
}
