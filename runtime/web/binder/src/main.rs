//! Writes the JavaScript and TypeScript declarations for a WebAssembly module: `bind-web MODULE.wasm FOLDER VERSION`.
//! Both files get the same build identifier: the version, and a hash of the module. The package compares the two.
//!
//! Replaces the command `wasm-bindgen`, whose own build needs a web server and a TLS library. It also removes parts
//! that a page need not load: names of functions, and comments and indentation of shaders. Those of shaders are a
//! twentieth of a compressed module.

mod shaders;

use std::fs;
use std::hash::{DefaultHasher, Hasher as _};
use std::path::Path;
use std::process::ExitCode;
use wasm_bindgen_cli_support::Bindgen;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [module, folder, version] = arguments.as_slice() else {
        eprintln!("found {} arguments, expected three: MODULE.wasm FOLDER VERSION", arguments.len());
        return ExitCode::FAILURE;
    };
    let mut bindgen = Bindgen::new();
    bindgen.input_path(module).typescript(true).remove_name_section(true).remove_producers_section(true);
    let bound = bindgen.web(true).and_then(|bindgen| bindgen.generate_output()).and_then(|mut output| {
        let segments = &mut output.wasm_mut().data;
        let ids: Vec<_> = segments.iter().map(|segment| segment.id()).collect();
        for id in ids {
            let data = &mut segments.get_mut(id).value;
            shaders::blank_comments(data);
            shaders::remove_indentation(data);
        }
        output.emit(Path::new(folder))?;
        Ok(mark_build(&Path::new(folder).join(Path::new(module).file_stem().unwrap_or_default()), version)?)
    });
    match bound {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{module}: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Adds the build identifier to `STEM_bg.wasm`, as the custom section `pelage_build`, and to `STEM.js`, as the constant
/// `BUILD`.
fn mark_build(stem: &Path, version: &str) -> std::io::Result<()> {
    let stem = stem.display();
    let (module, script) = (format!("{stem}_bg.wasm"), format!("{stem}.js"));
    let mut bytes = fs::read(&module)?;
    let mut hasher = DefaultHasher::new();
    hasher.write(&bytes);
    let build = format!("{version}-{:08x}", hasher.finish() as u32);
    bytes.extend(custom_section("pelage_build", &build));
    fs::write(module, bytes)?;
    let text = fs::read_to_string(&script)?;
    fs::write(script, format!("{text}\nexport const BUILD = \"{build}\";\n"))
}

/// Returns the bytes of a custom section; name and text together have at most 126 bytes.
fn custom_section(name: &str, text: &str) -> Vec<u8> {
    assert!(name.len() + text.len() < 127, "{text} is too long");
    [&[0, (1 + name.len() + text.len()) as u8, name.len() as u8], name.as_bytes(), text.as_bytes()].concat()
}
