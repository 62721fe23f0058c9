//! Tests of input and output files: paths that models name, and output that is either complete or absent.
#![allow(clippy::unwrap_used, reason = "tests")]

use crate::import::support::*;
use pelage_bake::io::{Reach, read_file, read_model, write_all_atomic, write_atomic};
use pelage_import::BakeError;
use pelage_import::ImportOptions;
use serde_json::json;
use std::path::Path;

fn names(folder: &Path) -> Vec<String> {
    let mut out: Vec<_> =
        std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    out.sort();
    out
}

/// Returns a model whose buffer is the external file `uri`, and the contents of that file.
fn external(uri: &str) -> (Vec<u8>, Vec<u8>) {
    let mut doc = Doc::new();
    let position = doc.triangle();
    doc.show(json!({"attributes": {"POSITION": position}}));
    doc.json["buffers"] = json!([{"byteLength": 36, "uri": uri}]);
    (serde_json::to_vec(&doc.json).unwrap(), doc.bin)
}

#[test]
fn buffers_are_found_beside_the_model_by_decoded_name() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("bin")).unwrap();
    let (text, bin) = external("bin/fuzzy%20h%C3%A5re.bin");
    let model = folder.path().join("hare.gltf");
    std::fs::write(&model, text).unwrap();
    std::fs::write(folder.path().join("bin/fuzzy håre.bin"), bin).unwrap();
    let read = read_model(&model, &ImportOptions::default(), Reach::OwnFolder).unwrap();
    let records: Vec<_> = read.inputs.iter().map(|i| (i.role.as_str(), i.name.as_str(), i.bytes)).collect();
    assert_eq!(records[0].1, "hare.gltf");
    assert_eq!(records[1], ("buffer", "fuzzy håre.bin", 36));
    use sha2::Digest as _;
    assert_eq!(read.inputs[1].sha256, <[u8; 32]>::from(sha2::Sha256::digest(external("x").1)));
}

#[test]
fn uris_outside_the_model_folder_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("m.gltf");
    for (uri, reason) in [
        ("/etc/hostname", "absolute path"),
        ("%2Fetc%2Fhostname", "absolute path"),
        ("\\\\server\\share", "absolute path"),
        ("C:\\fur.bin", "the scheme `C` (or a drive)"),
        ("https://example.org/fur.bin", "the scheme `https`"),
        ("file:///etc/hostname", "the scheme `file`"),
        ("a%00b", "NUL byte"),
        ("%ff", "not UTF-8"),
        ("", "empty"),
        ("missing.bin", "it does not exist; put it where the model looks for it"),
        (".", "it is a folder"),
    ] {
        std::fs::write(&model, external(uri).0).unwrap();
        let (place, found) = fault(read_model(&model, &ImportOptions::default(), Reach::OwnFolder));
        assert_eq!(place, "/buffers/0/uri", "{uri}");
        assert!(found.contains(reason), "{uri}: {found}");
    }
}

#[test]
fn unreadable_files_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let text = read_file(folder.path()).unwrap_err().to_string();
    assert!(text.contains("cannot read: it is a folder, expected a file"), "{text}");
    let missing = folder.path().join("none.glb");
    let error = read_model(&missing, &ImportOptions::default(), Reach::OwnFolder).unwrap_err();
    assert!(matches!(&error, BakeError::Io { path, action: "read", .. } if *path == missing), "{error}");
}

#[test]
fn atomic_writes_replace_files_and_leave_no_temporary_ones() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.pelage");
    write_atomic(&path, b"first").unwrap();
    write_atomic(&path, b"second").unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), b"second");
    assert_eq!(names(folder.path()), ["out.pelage"]);
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    let error = write_atomic(&folder.path().join("sub"), b"x").unwrap_err().to_string();
    assert!(error.contains("it is a folder, expected a file name"), "{error}");
    let error = write_atomic(&folder.path().join("none/out.pelage"), b"x").unwrap_err().to_string();
    assert!(error.contains("none: cannot create a file in"), "{error}");
    assert!(write_atomic(&folder.path().join(".."), b"x").is_err());
    assert_eq!(names(folder.path()), ["out.pelage", "sub"]);
}

#[cfg(unix)]
#[test]
fn several_files_are_written_all_or_none() {
    let folder = tempfile::tempdir().unwrap();
    let [one, two, sub] = ["one", "two", "sub"].map(|name| folder.path().join(name));
    std::fs::create_dir(&sub).unwrap();
    write_atomic(&one, b"before").unwrap();
    let error = write_all_atomic(&[(&one, b"1"), (&two, b"2"), (&sub, b"3")]).unwrap_err().to_string();
    assert!(error.contains("sub: cannot write"), "{error}");
    assert_eq!(
        (names(folder.path()), std::fs::read(&one).unwrap()),
        (vec!["one".into(), "sub".into()], b"before".into())
    );
    write_all_atomic(&[(&one, b"1"), (&two, b"2")]).unwrap();
    assert_eq!([one, two].map(|path| std::fs::read(path).unwrap()), [b"1", b"2"]);
    assert_eq!(names(folder.path()), ["one", "sub", "two"]);
}

#[test]
fn atomic_writes_keep_permissions_and_symbolic_links() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::tempdir().unwrap();
    let (path, plain) = (folder.path().join("a"), folder.path().join("b"));
    write_atomic(&path, b"x").unwrap();
    std::fs::write(&plain, b"x").unwrap();
    let mode = |p: &Path| std::fs::metadata(p).unwrap().permissions().mode();
    assert_eq!(mode(&path), mode(&plain), "permissions must be those of any new file");
    let link = folder.path().join("link");
    std::os::unix::fs::symlink(&path, &link).unwrap();
    write_atomic(&link, b"through").unwrap();
    assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(std::fs::read(&path).unwrap(), b"through");
    // Checks that a device is written to and not replaced.
    write_atomic(Path::new("/dev/null"), b"gone").unwrap();
    assert!(!std::fs::metadata("/dev/null").unwrap().is_file());
}

#[test]
fn files_outside_the_model_folder_need_permission() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir_all(folder.path().join("fox/bin")).unwrap();
    let bin = external("x").1;
    std::fs::write(folder.path().join("outside.bin"), &bin).unwrap();
    std::fs::write(folder.path().join("fox/bin/inside.bin"), &bin).unwrap();
    let model = folder.path().join("fox/fox.gltf");
    let read = |uri: &str, reach| {
        std::fs::write(&model, external(uri).0).unwrap();
        read_model(&model, &ImportOptions::default(), reach)
    };
    let mut outside = vec!["../outside.bin", "%2e%2e/outside.bin", "..%2foutside.bin", "bin/../../outside.bin"];
    if cfg!(unix) {
        #[cfg(unix)]
        std::os::unix::fs::symlink("../outside.bin", folder.path().join("fox/link.bin")).unwrap();
        outside.push("link.bin");
    }
    for uri in outside {
        let (place, reason) = fault(read(uri, Reach::OwnFolder));
        assert_eq!(place, "/buffers/0/uri", "{uri}");
        assert!(
            reason.contains("leads out of the model's folder") && reason.contains("--allow-outside"),
            "{uri}: {reason}"
        );
        assert!(read(uri, Reach::Anywhere).is_ok(), "{uri}");
    }
    // The error for a missing file is the same, so that a model cannot find out which files exist.
    let (_, reason) = fault(read("../no-such-file.bin", Reach::OwnFolder));
    assert!(reason.contains("leads out of the model's folder"), "{reason}");
    for uri in ["bin/inside.bin", "./bin/inside.bin", "bin/../bin/inside.bin"] {
        assert!(read(uri, Reach::OwnFolder).is_ok(), "{uri}");
    }
}

#[cfg(unix)]
#[test]
fn only_regular_files_are_read_and_only_to_their_declared_length() {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("m.gltf");
    let pipe = folder.path().join("pipe");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    std::os::unix::fs::symlink("/dev/zero", folder.path().join("zero")).unwrap();
    for (uri, what) in
        [("pipe", "it is a pipe, expected a file"), ("zero", "it is a device or a socket, expected a file")]
    {
        std::fs::write(&model, external(uri).0).unwrap();
        let (place, reason) = fault(read_model(&model, &ImportOptions::default(), Reach::Anywhere));
        assert_eq!(place, "/buffers/0/uri");
        assert!(reason.contains(what), "{reason}");
        // Checks that a missing image of an OBJ file only causes a warning.
        let obj = folder.path().join("m.obj");
        std::fs::write(&obj, "mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        std::fs::write(folder.path().join("m.mtl"), format!("newmtl a\nmap_Kd {uri}\n")).unwrap();
        let found = read_model(&obj, &ImportOptions::default(), Reach::Anywhere).unwrap();
        assert!(found.warnings.iter().any(|w| w.contains(what)), "{:?}", found.warnings);
    }
    // The file is a terabyte long, of which the model declares only 36 bytes.
    let bin = external("x").1;
    let large = std::fs::File::create(folder.path().join("large.bin")).unwrap();
    std::io::Write::write_all(&mut &large, &bin).unwrap();
    large.set_len(1 << 40).unwrap();
    std::fs::write(&model, external("large.bin").0).unwrap();
    let read = read_model(&model, &ImportOptions::default(), Reach::OwnFolder).unwrap();
    assert_eq!((read.inputs[1].bytes, read.mesh.triangles.len()), (36, 1));
    // Here the model itself declares that its buffer is a terabyte long.
    let mut doc = Doc::new();
    let position = doc.triangle();
    doc.show(json!({"attributes": {"POSITION": position}}));
    doc.json["buffers"] = json!([{"byteLength": 1_u64 << 40, "uri": "large.bin"}]);
    std::fs::write(&model, serde_json::to_vec(&doc.json).unwrap()).unwrap();
    let (_, reason) = fault(read_model(&model, &ImportOptions::default(), Reach::OwnFolder));
    assert!(reason.contains("declares 1099511627776 bytes"), "{reason}");
    let error = read_file(&folder.path().join("large.bin")).unwrap_err().to_string();
    assert!(error.contains("larger than 2147483648 bytes"), "{error}");
}
