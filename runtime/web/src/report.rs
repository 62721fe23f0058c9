//! Reports to JavaScript, as plain objects.

use js_sys::{Array, Object, Reflect};
use pelage_runtime::{Frame, Model};
use wasm_bindgen::JsValue;

pub(crate) fn object<const N: usize>(properties: [(&str, JsValue); N]) -> JsValue {
    let object = Object::new();
    for (name, value) in properties {
        // Setting a property of a new object cannot fail.
        let _ = Reflect::set(&object, &name.into(), &value);
    }
    object.into()
}

fn number_array(values: [f32; 3]) -> JsValue {
    values.into_iter().map(JsValue::from).collect::<Array>().into()
}

/// Returns `PackageInfo` of `npm/index.d.ts`.
pub(crate) fn package(name: &str, bytes: usize, model: &Model, has_ink: bool) -> JsValue {
    let manifest = model.manifest();
    let clip = |clip: &pelage_runtime::formats::Clip| {
        object([("name", clip.name.as_str().into()), ("durationS", clip.duration_s.into())])
    };
    object([
        ("name", name.into()),
        ("model", manifest.model.as_str().into()),
        ("bytes", (bytes as f64).into()),
        ("gpuBytes", (model.gpu_bytes() as f64).into()),
        ("min", number_array(manifest.bounds.min)),
        ("max", number_array(manifest.bounds.max)),
        ("furHeightM", manifest.fur.height_m.into()),
        ("hasInk", has_ink.into()),
        (
            "morphs",
            model.morph_targets().iter().map(|target| JsValue::from(target.name.as_str())).collect::<Array>().into(),
        ),
        ("clips", model.clips().iter().map(clip).collect::<Array>().into()),
    ])
}

/// Returns the report of a frame: names of the passes that ran, memory, resources created, and bytes uploaded.
pub(crate) fn frame(frame: &Frame, gpu_bytes: u64) -> JsValue {
    let report = frame.report();
    let ran = report.passes.iter().filter(|pass| pass.ran).map(|pass| JsValue::from(pass.name));
    let created = report.created;
    let made = created.buffers + created.textures + created.bind_groups + created.pipelines;
    object([
        ("passes", ran.collect::<Array>().into()),
        ("gpuBytes", ((gpu_bytes + report.target_bytes) as f64).into()),
        ("created", made.into()),
        ("uploadedBytes", (report.uploaded_bytes as f64).into()),
    ])
}
