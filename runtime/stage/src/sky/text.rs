//! Skies as TOML.

use crate::StageError;
use crate::toml_text::Source;
use pelage_formats::meaning::environment::Environment;

/// Reads an environment that [`environment_to_toml`] or a person wrote; `name` is the file's, for messages.
///
/// # Errors
///
/// [`StageError::Input`] with line and key of what is wrong.
pub fn environment_from_toml(name: &str, text: &str) -> Result<Environment, StageError> {
    let source = Source { name, text: text.strip_prefix('\u{feff}').unwrap_or(text) };
    let environment: Environment = source.parse()?;
    match environment.fault() {
        Some((key, reason)) => Err(source.fault(&key, reason)),
        None => Ok(environment),
    }
}

/// An environment as TOML. Reading it gives an equal one.
pub fn environment_to_toml(environment: &Environment) -> String {
    let list = |numbers: [f32; 3]| {
        let [x, y, z] = numbers.map(|x| format!("{x:?}"));
        format!("[{x}, {y}, {z}]")
    };
    let mut text = format!("# Radiance from everywhere, linear RGB.\neven = {}\n", list(environment.even));
    if let Some(sun) = environment.sun {
        text += "\n# A light as small as to be one direction; colour 1 brings an irradiance of pi.\n[sun]\n";
        text += &format!("towards = {}\ncolor = {}\n", list(sun.towards), list(sun.color));
    }
    if !environment.lobes.is_empty() {
        text += "\n# Lights spread about a direction (+y is up): standard deviation, and radiance of the middle.\n";
    }
    for lobe in &environment.lobes {
        text += &format!(
            "[[lobe]]\ntowards = {}\nwidth_deg = {:?}\nradiance = {}\n",
            list(lobe.towards),
            lobe.width_deg,
            list(lobe.radiance)
        );
    }
    text
}
