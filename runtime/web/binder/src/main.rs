//! Writes the JavaScript and TypeScript declarations for a WebAssembly module: `bind-web MODULE.wasm FOLDER`.
//!
//! Replaces the command `wasm-bindgen`, whose own build needs a web server and a TLS library. It also removes parts
//! that a page need not load: names of functions, and comments and indentation of shaders. Those of shaders are a
//! twentieth of a compressed module.

mod shaders;

use std::path::Path;
use std::process::ExitCode;
use wasm_bindgen_cli_support::Bindgen;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [module, folder] = arguments.as_slice() else {
        eprintln!("found {} arguments, expected two: MODULE.wasm FOLDER", arguments.len());
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
        output.emit(Path::new(folder))
    });
    match bound {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{module}: {error:#}");
            ExitCode::FAILURE
        }
    }
}
