//! Look of a scene's picture. The table `[look]` has look keys; `[view]` has command-line flags.

use super::SceneFile;
use super::text::SceneLook;
use crate::{Look, SAMPLES, SHORT_FORMS, ShortForm, StageError};
use pelage_params::{ParamError, unknown_key};
use std::path::Path;

/// Keys that are invalid in `[view]`, with the table to which they belong, if any.
const KEYS_OF_OTHER_TABLES: [(&str, &str); 9] = [
    ("camera", "in [camera]"),
    ("light", "in [light]"),
    ("point_light", "as position in [light]"),
    ("frames", "in [sequence]"),
    ("fps", "in [sequence]"),
    ("clip", "in a [[model]]"),
    ("crowd", "as several [[model]]"),
    ("time", "on the command line"),
    ("output", "on the command line"),
];

impl SceneFile {
    /// Returns the look of the scene. `[light]` overrides `look`, and `look` overrides `[view]`.
    ///
    /// `file` is called with the path of a look file, relative to the scene file's folder. It returns the file's name
    /// for messages and its text, or an error message. Relative file paths in the returned look are relative to the
    /// scene file's folder ([`Look::resolve_files`]).
    ///
    /// Fails with [`StageError::Input`] with line and key of the fault.
    pub fn look(&self, file: impl FnOnce(&str) -> Result<(String, String), String>) -> Result<Look, StageError> {
        let mut look = Look::of_picture();
        for (name, value) in &self.scene.view {
            self.view(&mut look, name, value).map_err(|reason| self.fault(&format!("view.{name}"), reason))?;
        }
        match &self.scene.look {
            None => {}
            Some(SceneLook::Tables(tables)) => {
                let read = pelage_params::read_table(&mut look, tables);
                read.map_err(|error| self.fault(&format!("look.{}", error.key), error.reason))?;
            }
            Some(SceneLook::File(path)) => {
                let folder = Path::new(path).parent().unwrap_or(Path::new(""));
                let (file, text) = file(path).map_err(|reason| self.fault("look", reason))?;
                let fault =
                    |error: ParamError| StageError::Input { file, place: error.location(), reason: error.reason };
                look.read_in(folder, &text).map_err(fault)?;
            }
        }
        if let Some(light) = &self.scene.light {
            super::check_light(&self.source(), Some(light))?;
            if let Some(towards) = light.direction {
                look.set_light_direction(towards.0);
            }
            look.light.position_m = light.position.map(|position| position.0.to_array());
        }
        Ok(look)
    }

    /// Applies one key of `[view]`.
    fn view(&self, look: &mut Look, name: &str, value: &toml::Value) -> Result<(), String> {
        if let Some((_, place)) = KEYS_OF_OTHER_TABLES.iter().find(|(key, _)| *key == name) {
            return Err(format!("expected this key {place}"));
        }
        let short = short_form(name)?;
        let values = match value {
            toml::Value::Array(values) if short.repeats => values.as_slice(),
            one => std::slice::from_ref(one),
        };
        for value in values {
            let word = match value {
                toml::Value::String(text) => text.clone(),
                toml::Value::Boolean(on) => if *on { "on" } else { "off" }.to_owned(),
                toml::Value::Integer(_) | toml::Value::Float(_) => value.to_string(),
                other => return Err(format!("found {}, expected a word or a number", other.type_str())),
            };
            short.apply(look, &word).map_err(|error| error.reason)?;
        }
        Ok(())
    }
}

/// Returns the flag of that name. The name may have `_` instead of `-`.
fn short_form(name: &str) -> Result<&'static ShortForm, String> {
    let all = || SHORT_FORMS.iter().chain([&SAMPLES]);
    all().find(|short| short.flag.replace('-', "_") == name).ok_or_else(|| {
        let flags: Vec<String> = all().map(|short| short.flag.replace('-', "_")).collect();
        unknown_key(name, &flags.iter().map(String::as_str).collect::<Vec<_>>())
    })
}
