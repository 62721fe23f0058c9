//! Bodies of the fuzz targets. `formats/tests/formats/smoke.rs` includes this file and runs it on stable.

use pelage_formats::*;

/// Corrects the checksums of an input whose section table can be read, so that mutations reach the code behind the
/// checksum checks.
pub fn reseal(bytes: &mut [u8]) {
    let u64_at = |bytes: &[u8], at: usize| {
        let field = bytes.get(at..)?.first_chunk()?;
        usize::try_from(u64::from_le_bytes(*field)).ok()
    };
    let Some(count) = bytes.get(12..).and_then(|b| b.first_chunk()).map(|b| u32::from_le_bytes(*b) as usize) else {
        return;
    };
    let Some(head_bytes) = count.checked_mul(32).and_then(|n| n.checked_add(32)) else { return };
    if bytes.len() < head_bytes {
        return;
    }
    for at in (32..head_bytes).step_by(32) {
        let (offset, length) = (u64_at(bytes, at + 8), u64_at(bytes, at + 16));
        let section = offset.zip(length).and_then(|(offset, length)| bytes.get(offset..)?.get(..length));
        if let Some(checksum) = section.map(crc32fast::hash) {
            bytes[at + 24..at + 28].copy_from_slice(&checksum.to_le_bytes());
        }
    }
    let mut head = crc32fast::Hasher::new();
    head.update(&bytes[..24]);
    head.update(&bytes[28..head_bytes]);
    bytes[24..28].copy_from_slice(&head.finalize().to_le_bytes());
}

/// Returns small limits, so that the fuzzer's memory limit exposes allocations beyond them.
pub fn limits() -> Limits {
    Limits {
        manifest_bytes: 1 << 20,
        animation_bytes: 1 << 20,
        vertices: 1 << 16,
        indices: 1 << 18,
        fins: 1 << 17,
        ..Limits::default()
    }
}

/// Opens and validates the input, and reads all of its contents. Returns whether it is a valid package.
pub fn open(bytes: &[u8]) -> bool {
    let faults = Package::validate(bytes, &limits());
    for fault in &faults {
        assert!(!fault.to_string().is_empty() && fault.section().is_some());
    }
    let Ok(package) = Package::open(bytes, &limits()) else {
        assert!(!faults.is_empty());
        return false;
    };
    for index in 0..=package.sections().len() {
        let _ = package.section_bytes(index);
    }
    if let Ok(Some(mesh)) = package.mesh() {
        assert!(mesh.indices().all(|index| index < mesh.vertex_count));
        assert!(mesh.geometry().all(|v| v.position.iter().all(|x| x.is_finite())));
    }
    if let Ok(Some(fins)) = package.fins() {
        let vertices = package.mesh().ok().flatten().map_or(0, |mesh| mesh.vertex_count);
        assert!(fins.fins().all(|fin| fin.a < vertices && fin.b < vertices && fin.length.is_finite()));
    }
    if let Ok(Some(animation)) = package.animation() {
        let mut pose = Pose::default();
        for clip in 0..=animation.clips.len() {
            for time_s in [-1.0, 0.0, 0.3, 1e9, f32::NAN] {
                pose.sample(&animation, Some(clip), time_s);
                assert_eq!(pose.joints.len(), animation.joints.len());
                assert!(pose.joints.iter().all(|joint| joint.to_cols_array().iter().all(|x| x.is_finite())));
            }
        }
    }
    if let (Ok(Some(morphs)), Ok(Some(mesh))) = (package.morphs(), package.mesh()) {
        let targets = morphs.motion.targets.len();
        let deltas = (0..mesh.vertex_count as usize).flat_map(|v| morphs.of_vertex(v));
        assert!(deltas.clone().all(|delta| (delta.target as usize) < targets));
        assert_eq!(deltas.count(), morphs.deltas.len());
    }
    for index in 0..=package.manifest().textures.len() as u32 {
        if let Ok(texture) = package.texture(index) {
            for level in 0..=texture.levels {
                let expected = if level < texture.levels { texture.level_bytes(level) } else { 0 };
                assert_eq!(texture.level(level).len() as u64, expected);
            }
        }
    }
    let _ = (package.fur_textures(), package.wet_textures(), package.fin_textures());
    for material in 0..=package.manifest().materials.len() {
        let _ = (package.base_color_texture(material), package.groom_texture(material));
    }
    faults.is_empty()
}

/// Decodes a valid package into values, writes it again and asserts identical bytes. Returns whether it is valid.
pub fn round_trip(bytes: &[u8]) -> bool {
    if !Package::validate(bytes, &limits()).is_empty() {
        return false;
    }
    let rewritten = rewrite(bytes).expect("a package that validates is read and written again");
    assert!(rewritten == bytes, "written again, the package differs");
    true
}

fn rewrite(bytes: &[u8]) -> Result<Vec<u8>, FormatError> {
    let package = Package::open(bytes, &limits())?;
    let mut writer = PackageWriter::new(package.manifest().clone()).version(package.version());
    for (index, section) in package.sections().iter().enumerate().skip(1) {
        writer = match (section.tag, package.mesh()?, package.animation()?, package.fins()?) {
            (Tag::MESH, Some(mesh), ..) => writer.mesh(&mesh.to_data()),
            (Tag::ANIMATION, _, Some(animation), _) => writer.animation(&animation),
            (Tag::MORPHS, ..) => match package.morphs()? {
                Some(morphs) => writer.morphs(&morphs),
                None => writer,
            },
            (Tag::FINS, _, _, Some(fins)) => writer.fins(&fins.to_data()),
            (Tag::TEXTURE, ..) => writer.texture(package.section_bytes(index)?),
            _ => writer.section(section.tag, package.section_bytes(index)?),
        };
    }
    writer.finish()
}
