//! Errors for JavaScript: an `Error` with a `kind` that gives the cause.

use pelage_stage::StageError;
use wasm_bindgen::JsValue;

/// Creates an `Error` of that kind; `npm/index.d.ts` lists the kinds.
pub(crate) fn pelage_error(kind: &str, message: &str) -> JsValue {
    let error = js_sys::Error::new(message);
    error.set_name("PelageError");
    // Setting a property of a new object cannot fail.
    let _ = js_sys::Reflect::set(&error, &"kind".into(), &kind.into());
    error.into()
}

pub(crate) fn stage_error(error: StageError) -> JsValue {
    let kind = match &error {
        StageError::Package { .. } | StageError::Input { .. } => "package",
        StageError::Request { .. } | StageError::Params(_) => "asked",
        StageError::NoAdapter(_) => "no-adapter",
        StageError::Device(_) => "device",
        _ => "internal",
    };
    pelage_error(kind, &error.to_string())
}

pub(crate) fn invalid_argument(error: impl std::fmt::Display) -> JsValue {
    pelage_error("asked", &error.to_string())
}
