//! Errors as JavaScript catches them: an `Error` with a `kind` by who is at fault.

use pelage_stage::StageError;
use wasm_bindgen::JsValue;

/// An `Error` of that kind; `npm/index.d.ts` lists the kinds.
pub(crate) fn thrown(kind: &str, message: &str) -> JsValue {
    let error = js_sys::Error::new(message);
    error.set_name("PelageError");
    // A new object takes any property.
    let _ = js_sys::Reflect::set(&error, &"kind".into(), &kind.into());
    error.into()
}

/// What stopped the stage.
pub(crate) fn fault(error: StageError) -> JsValue {
    let kind = match &error {
        StageError::Package { .. } | StageError::Input { .. } => "package",
        StageError::Asked { .. } | StageError::Params(_) => "asked",
        StageError::NoAdapter(_) => "no-adapter",
        StageError::Device(_) => "device",
        _ => "internal",
    };
    thrown(kind, &error.to_string())
}

/// A value that was asked for and is out of its range, in words.
pub(crate) fn asked(error: impl std::fmt::Display) -> JsValue {
    thrown("asked", &error.to_string())
}
