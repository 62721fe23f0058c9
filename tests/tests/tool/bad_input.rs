//! Tests of bad input with the real binary: exit code, message, and no files left behind.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use crate::tool::common::random::Random;
use crate::tool::common::sample_package;
use pelage_formats::{Limits, Package};
use pelage_tests::binary::{Run, Sandbox};
use pelage_tests::schema;
use serde_json::{Value, json};

/// Runs the binary. Asserts the exit code, that stderr contains `words`, and that the list of files is unchanged.
#[track_caller]
fn assert_refused(sandbox: &Sandbox, args: &[&str], code: i32, words: &[&str]) -> Run {
    let before = sandbox.files();
    let run = sandbox.run(args);
    assert_eq!(run.code, Some(code), "{args:?}: {run:?}");
    for word in words {
        assert!(run.stderr.contains(word), "{args:?}: no {word:?} in {}", run.stderr);
    }
    assert_eq!(sandbox.files(), before, "{args:?} left something behind");
    run
}

fn with_u32(bytes: &[u8], at: usize, value: u32) -> Vec<u8> {
    let mut out = bytes.to_vec();
    out[at..at + 4].copy_from_slice(&value.to_le_bytes());
    out
}

#[test]
fn usage_errors_exit_with_1() {
    let sandbox = Sandbox::new();
    for (args, words) in [
        (&[][..], &["Usage"][..]),
        (&["brush"], &["unrecognized subcommand", "brush"]),
        (&["inspect"], &["required", "<PKG>"]),
        (&["inspect", "a", "b"], &["unexpected argument"]),
        (&["inspect", "--fast", "a"], &["--fast"]),
        (&["pack", "a"], &["<PKG>"]),
    ] {
        assert_refused(&sandbox, args, 1, words);
    }
    let run = assert_refused(&sandbox, &["inspect", "--json"], 1, &[]);
    let object = schema::parse_answer(&run, "error");
    assert_eq!(object["error"]["exit_code"], 1);
}

#[test]
fn bad_packages_are_refused() {
    let sandbox = Sandbox::new();
    let good = sample_package();
    let sections = Package::open(&good, &Limits::default()).unwrap().sections().to_vec();
    std::fs::create_dir(sandbox.path().join("folder.pelage")).unwrap();
    sandbox.write("empty.pelage", "");
    sandbox.write("other.pelage", "glTF, or something else");
    sandbox.write("short.pelage", &good[..5]);
    sandbox.write("cut.pelage", &good[..good.len() / 2]);
    sandbox.write("header.pelage", &good[..20]);
    sandbox.write("future.pelage", with_u32(&good, 8, 4));
    sandbox.write("sections.pelage", with_u32(&good, 12, u32::MAX));
    // The length field of the second section is set to 4 GiB.
    sandbox.write("long.pelage", with_u32(&with_u32(&good, 32 + 32 + 16, 0), 32 + 32 + 20, 1));
    sandbox.write("model.pelage", b"glTF\x02\0\0\0");
    sandbox.write("trailing.pelage", [&good[..], b"more"].concat());
    let mut flipped = good.clone();
    flipped[sections[1].offset as usize + 100] ^= 16;
    sandbox.write("flipped.pelage", &flipped);

    // Columns: file, exit code of every reader, exit code of `validate`, words that the message must contain.
    let table: &[(&str, i32, i32, &[&str])] = &[
        ("missing.pelage", 2, 2, &["missing.pelage: cannot read"]),
        ("folder.pelage", 2, 2, &["folder.pelage: cannot read", "folder"]),
        ("empty.pelage", 3, 3, &["empty.pelage: not a pelage package", "byte 0"]),
        ("other.pelage", 3, 3, &["other.pelage: not a pelage package", "byte 0"]),
        ("model.pelage", 3, 3, &["model.pelage: not a pelage package", "a glTF model, which `pelage bake` turns into"]),
        ("short.pelage", 3, 3, &["short.pelage", "cut short", "byte 0"]),
        ("future.pelage", 3, 3, &["future.pelage", "version 4 at byte 8 is newer", "update pelage"]),
        ("header.pelage", 3, 7, &["header.pelage", "cut short", "at byte 0 needs 32 bytes, 20 are left"]),
        ("cut.pelage", 3, 7, &["cut.pelage", "cut short"]),
        ("sections.pelage", 3, 7, &["section count at byte 12 is 4294967295", "limit"]),
        ("long.pelage", 3, 7, &["long.pelage", "head at byte 0 is damaged"]),
        ("trailing.pelage", 3, 7, &["4 trailing bytes at byte"]),
        ("flipped.pelage", 3, 7, &["section MESH at byte", "is damaged"]),
    ];
    println!("{:<18} inspect validate  message", "package");
    for (file, code, validate, words) in table {
        let run = assert_refused(&sandbox, &["inspect", file], *code, words);
        println!("{file:<18} {code:<7} {validate:<9} {}", run.stderr.trim());
        assert_refused(&sandbox, &["unpack", file, "out"], *code, words);
        let run = assert_refused(&sandbox, &["validate", file], *validate, if *validate == 7 { &[] } else { words });
        if *validate == 7 {
            assert!(words.iter().all(|w| run.stdout.contains(w)) && run.stdout.contains("byte"), "{run:?}");
        }
        let run = sandbox.run(&["inspect", file, "--json"]);
        let object = schema::parse_answer(&run, "error");
        assert_eq!(object["error"]["exit_code"], *code, "{file}");
    }
}

#[test]
fn flipped_bits_and_truncations_are_bad_input() {
    let sandbox = Sandbox::new();
    let good = sample_package();
    let mut random = Random(7);
    for _ in 0..40 {
        let mut bad = good.clone();
        let at = random.below(bad.len());
        bad[at] ^= 1 << random.below(8);
        sandbox.write("bad.pelage", &bad);
        let run = sandbox.run(&["unpack", "bad.pelage", "out"]);
        assert_eq!(run.code, Some(3), "bit flipped in byte {at}: {run:?}");
        sandbox.write("bad.pelage", &good[..at]);
        let run = sandbox.run(&["unpack", "bad.pelage", "out"]);
        assert_eq!(run.code, Some(3), "cut at byte {at}: {run:?}");
        assert_eq!(sandbox.files(), ["bad.pelage"]);
    }
}

#[test]
fn unwritable_outputs_are_reported() {
    let sandbox = Sandbox::new();
    sandbox.write("a.pelage", sample_package());
    assert_eq!(sandbox.run(&["unpack", "a.pelage", "in"]).code, Some(0));
    let missing = &["nowhere: cannot write into", "create it first"];
    assert_refused(&sandbox, &["pack", "in", "nowhere/b.pelage"], 2, missing);
    assert_refused(&sandbox, &["unpack", "a.pelage", "nowhere/out"], 2, missing);
    assert_refused(&sandbox, &["pack", "in", "in"], 2, &["in: cannot write", "folder"]);
    assert_refused(
        &sandbox,
        &["unpack", "a.pelage", "a.pelage"],
        2,
        &["a.pelage: cannot write into", "expected a folder"],
    );
    assert_refused(&sandbox, &["pack", "nowhere", "b.pelage"], 2, &["nowhere: cannot read", "no such folder"]);
    assert_refused(&sandbox, &["pack", "a.pelage", "b.pelage"], 2, &["a.pelage: cannot read", "found a file"]);
}

/// Returns a sandbox with an unpacked sample package. Tests then damage the package.
fn unpacked() -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.write("a.pelage", sample_package());
    assert_eq!(sandbox.run(&["unpack", "a.pelage", "in"]).code, Some(0));
    sandbox
}

#[test]
fn bad_unpacked_folders_are_refused() {
    // Each case damages one file, and lists the words that the message must contain.
    type Spoil = fn(&mut Value);
    let manifests: &[(Spoil, &[&str])] = &[
        (|m| m["pelage_unpacked"] = json!(1), &["/pelage_unpacked", "found 1, expected 3"]),
        (|m| m["manifest"]["generatr"] = json!("x"), &["/manifest/generatr: unknown key", "\"generator\""]),
        (|m| m["manifest"]["fur"]["layer"] = json!(1), &["/manifest/fur/layer: unknown key", "\"layers\""]),
        (|m| m["manifest"]["fur"]["layers"] = json!("two"), &["/manifest/fur/layers", "u32"]),
        (|m| m["manifest"]["fur"]["layers"] = json!(-2), &["/manifest/fur/layers", "-2"]),
        (
            |m| _ = m["manifest"]["materials"][0].as_object_mut().unwrap().remove("alpha_cutoff"),
            &["/manifest/materials/0/alpha_cutoff", "missing"],
        ),
        (|m| _ = m["manifest"].as_object_mut().unwrap().remove("fur"), &["/manifest", "fur"]),
        (|m| m["manifest"]["recipe"] = json!(""), &["/manifest/recipe", "recipe.toml"]),
        (|m| m["manifest"]["inputs"][1]["sha256"] = json!("abc"), &["/manifest/inputs/1/sha256", "64 hexadecimal"]),
        (|m| m["manifest"]["fur"]["color_texture"] = json!(9), &["manifest.json", "fur.color_texture is 9"]),
        (|m| m["manifest"]["parts"][1]["index_count"] = json!(6), &["mesh.glb", "12 indices, expected the 15"]),
        (
            |m| m["manifest"]["textures"][0]["name"] = json!("shell"),
            &["/sections", "\"shell_color.ktx2\", expected shell.ktx2"],
        ),
        (|m| m["sections"][1]["file"] = json!("../mesh.glb"), &["/sections/1/file", "without folders"]),
        (|m| m["sections"][1]["file"] = json!("mess.glb"), &["mess.glb", "missing", "/sections/1/file"]),
        (|m| m["sections"][1]["tag"] = json!("MESHES"), &["/sections/1/tag", "four characters"]),
        (|m| m["sections"] = json!([]), &["section"]),
        (|m| m["sections"] = json!(null), &["/sections", "expected a list"]),
    ];
    for (spoil, words) in manifests {
        let sandbox = unpacked();
        let text = std::fs::read(sandbox.path().join("in/manifest.json")).unwrap();
        let mut manifest = serde_json::from_slice(&text).unwrap();
        spoil(&mut manifest);
        sandbox.write("in/manifest.json", manifest.to_string());
        assert_refused(&sandbox, &["pack", "in", "b.pelage"], 3, words);
    }

    let files: &[(&str, &[u8], &[&str])] = &[
        ("manifest.json", b"{\n  \"a\": }", &["in/manifest.json: line 2, column 8", "broken JSON"]),
        ("manifest.json", b"[]", &["in/manifest.json", "/pelage_unpacked"]),
        ("recipe.toml", b"abc\xff", &["in/recipe.toml: byte 3", "UTF-8"]),
        ("animation.json", b"{\"nodes\": [{\"name\": 3}]}", &["in/animation.json: /nodes/0/name", "string"]),
        ("animation.json", b"{\"nodes\": [], \"joints\": [], \"clips\": []}", &["joint"]),
        ("shell_color.ktx2", b"no texture", &["in/shell_color.ktx2", "byte 0", "10 bytes, expected a KTX2 header"]),
        ("mesh.glb", b"no mesh", &["in/mesh.glb: byte 0", "glTF"]),
        ("mesh.glb", b"glTF\x02\0\0\0\xff\0\0\0", &["in/mesh.glb: byte 8", "length is 255, expected the file's 12"]),
    ];
    for (file, bytes, words) in files {
        let sandbox = unpacked();
        sandbox.write(&format!("in/{file}"), bytes);
        assert_refused(&sandbox, &["pack", "in", "b.pelage"], 3, words);
    }

    for file in ["manifest.json", "recipe.toml", "animation.json", "shell_color.ktx2", "mesh.glb", "section_5_XTRA.bin"]
    {
        let sandbox = unpacked();
        std::fs::remove_file(sandbox.path().join("in").join(file)).unwrap();
        assert_refused(&sandbox, &["pack", "in", "b.pelage"], 3, &[&format!("in/{file}: whole file: missing")]);
    }
}

#[test]
fn badly_edited_meshes_are_refused() {
    type Spoil = fn(&mut Value);
    let cases: &[(Spoil, &[&str])] = &[
        (
            |g| _ = g["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("_TILE_UV"),
            &["/meshes/0/primitives/0/attributes/_TILE_UV", "missing"],
        ),
        (|g| g["meshes"] = json!([]), &["/meshes/0/primitives", "expected a list"]),
        (|g| g["accessors"][0]["count"] = json!(4_000_000_000u32), &["/accessors/0", "4000000000 elements"]),
        (|g| g["accessors"][1]["count"] = json!(4), &["NORMAL", "4 elements, expected the 5"]),
        (|g| g["accessors"][0]["type"] = json!("VEC2"), &["/accessors/0", "expected 5126 and \"VEC3\""]),
        (|g| g["bufferViews"][0]["byteLength"] = json!(u64::MAX), &["/bufferViews/0"]),
        (|g| g["bufferViews"][0]["byteStride"] = json!(0), &["/accessors/0"]),
        (|g| g["meshes"][0]["primitives"][0]["indices"] = json!(0), &["/accessors/0", "expected 5125"]),
        (|g| g["meshes"][0]["primitives"][0]["mode"] = json!(1), &["/meshes/0/primitives/0/mode", "triangles"]),
    ];
    for (spoil, words) in cases {
        let sandbox = unpacked();
        let glb = std::fs::read(sandbox.path().join("in/mesh.glb")).unwrap();
        let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
        let mut document: Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
        spoil(&mut document);
        let mut text = document.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut out = glb[..12].to_vec();
        out.extend_from_slice(&(text.len() as u32).to_le_bytes());
        out.extend_from_slice(b"JSON");
        out.extend_from_slice(&text);
        out.extend_from_slice(&glb[20 + length..]);
        let total = out.len() as u32;
        out[8..12].copy_from_slice(&total.to_le_bytes());
        sandbox.write("in/mesh.glb", out);
        assert_refused(&sandbox, &["pack", "in", "b.pelage"], 3, &[&["in/mesh.glb"][..], words].concat());
    }
}
