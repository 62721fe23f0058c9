//! Test of `FORMAT.md`: `c/read_pelage.c`, written from the specification alone, must give the same description of a
//! package as the Rust reader.

use pelage_formats::*;
use pelage_needs::{Need, log_available, log_missing};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Compiles the C reader. Without a C compiler, reports this for the test `test` and returns `None`.
fn compile(folder: &Path, test: &str) -> Option<PathBuf> {
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".into());
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/c/read_pelage.c");
    let program = folder.join(if cfg!(windows) { "read_pelage.exe" } else { "read_pelage" });
    let warnings = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror"];
    match Command::new(&compiler).args(warnings).arg("-o").arg(&program).arg(&source).output() {
        Ok(output) => {
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            log_available(Need::Compiler, test, &compiler);
            Some(program)
        }
        Err(error) => {
            log_missing(
                Need::Compiler,
                test,
                &format!("no C compiler {compiler:?}: {error}; FORMAT.md was not proven"),
            );
            None
        }
    }
}

/// Returns the expected output of the C program.
fn describe(bytes: &[u8]) -> String {
    let package = Package::open(bytes, &Limits::default()).unwrap();
    let manifest = package.manifest();
    let mut out =
        format!("version {} sections {} bytes {}\n", package.version(), package.sections().len(), bytes.len());
    let mut texture = 0;
    for section in package.sections() {
        writeln!(out, "section {} offset {} length {}", section.tag, section.offset, section.length).unwrap();
        match section.tag {
            Tag::MANIFEST => {
                writeln!(out, "generator {}\nmodel {}", manifest.generator, manifest.model).unwrap();
                writeln!(out, "fur layers {} texels {}", manifest.fur.layers, manifest.fur.tile_texels).unwrap();
                if let Some(wet) = &manifest.fur.wet {
                    writeln!(out, "wet color {} direction {}", wet.color_texture, wet.direction_texture).unwrap();
                }
                if let Some(fins) = &manifest.fur.fins {
                    writeln!(out, "fin texels {} by {} slabs {}", fins.width, fins.height, fins.slabs).unwrap();
                }
                for material in &manifest.materials {
                    writeln!(out, "material {}", material.name).unwrap();
                    material.groom_texture.iter().for_each(|t| writeln!(out, "groom texture {t}").unwrap());
                }
                for part in &manifest.parts {
                    let (material, first, count) = (part.material, part.first_index, part.index_count);
                    writeln!(out, "part material {material} first {first} count {count}").unwrap();
                }
                manifest.textures.iter().for_each(|t| writeln!(out, "texture {}", t.name).unwrap());
                manifest.warnings.iter().for_each(|w| writeln!(out, "warning {w}").unwrap());
                if let Some(coat) = &manifest.coat {
                    writeln!(out, "coat height bits {}", coat.height.to_bits()).unwrap();
                }
                for level in &manifest.detail {
                    writeln!(out, "detail step {} full bits {}", level.step, level.full_px.to_bits()).unwrap();
                }
                if let Some(choice) = &manifest.choice {
                    writeln!(out, "choice binding {}", choice.binding).unwrap();
                    writeln!(out, "choice of {} by {}", choice.width, choice.height).unwrap();
                    choice.views.iter().for_each(|v| writeln!(out, "view {v}").unwrap());
                    for trial in &choice.trials {
                        trial.settings.iter().for_each(|s| writeln!(out, "setting {s}").unwrap());
                        writeln!(out, "trial bytes {} predicted {}", trial.bytes, u32::from(trial.predicted)).unwrap();
                    }
                    writeln!(out, "chosen {}", choice.chosen).unwrap();
                }
            }
            Tag::MESH => {
                let mesh = package.mesh().unwrap().unwrap();
                let (vertices, indices, skin) = (mesh.vertex_count, mesh.index_count, !mesh.skin.is_empty());
                writeln!(out, "mesh vertices {vertices} indices {indices} skin {}", u32::from(skin)).unwrap();
            }
            Tag::FINS => {
                let fins = package.fins().unwrap().unwrap();
                writeln!(out, "fins {}", fins.count).unwrap();
                fins.part_counts().for_each(|n| writeln!(out, "part fins {n}").unwrap());
                for fin in fins.fins() {
                    writeln!(out, "fin {} {} slab {}", fin.a, fin.b, fin.slab).unwrap();
                }
            }
            Tag::TEXTURE => {
                let view = package.texture(texture).unwrap();
                texture += 1;
                let (format, width, height) = (view.format.ktx2().value(), view.width, view.height);
                let (layers, levels) = (view.layers, view.levels);
                writeln!(out, "ktx2 format {format} width {width} height {height} layers {layers} levels {levels}")
                    .unwrap();
            }
            _ => {}
        }
    }
    out
}

#[test]
fn a_reader_written_from_the_specification_agrees() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("spec-reader-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let Some(program) = compile(&folder, "a_reader_written_from_the_specification_agrees") else { return };
    let file = folder.join("package.pelage");
    let run = |bytes: &[u8]| {
        std::fs::write(&file, bytes).unwrap();
        Command::new(&program).arg(&file).output().unwrap()
    };

    let golden = include_bytes!("../golden/v3.pelage");
    let old = [&include_bytes!("../golden/v1.pelage")[..], include_bytes!("../golden/v2.pelage")];
    let bald = PackageWriter::new(Manifest::default()).section(Tag(*b"NONE"), Vec::new()).finish().unwrap();
    for bytes in [&golden[..], old[0], old[1], &bald] {
        let output = run(bytes);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(String::from_utf8(output.stdout).unwrap(), describe(bytes));
    }

    // The C reader also rejects what the Rust reader rejects: damage anywhere, truncated files and extended files.
    for at in (0..golden.len()).step_by(7) {
        let mut bytes = golden.to_vec();
        bytes[at] ^= 0x10;
        assert_eq!(run(&bytes).status.code(), Some(1), "byte {at} is damaged");
        assert_eq!(run(&golden[..at]).status.code(), Some(1), "{at} bytes are left");
    }
    assert_eq!(run(&[&golden[..], &[0]].concat()).status.code(), Some(1), "one byte more");
    std::fs::remove_dir_all(&folder).unwrap();
}
