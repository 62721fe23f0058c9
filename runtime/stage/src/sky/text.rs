//! Environment maps as TOML.

use crate::StageError;
use crate::toml_text::TomlText;
use pelage_formats::meaning::environment::{Environment, LightLobe, Sun};
use pelage_params::Raw;

/// Parses an environment map that was written by [`environment_to_toml`] or by hand.
///
/// * `name`: file name for messages
///
/// # Errors
///
/// [`StageError::Input`] with line and key of the fault.
pub fn environment_from_toml(name: &str, text: &str) -> Result<Environment, StageError> {
    let source = TomlText::new(name, text);
    let mut environment = Environment::default();
    for (key, value) in source.table()? {
        match (key.as_str(), &value) {
            ("even", value) => environment.even = three(&source, "even", value)?,
            ("sun", Raw::Table(entries)) => {
                let [towards, color] = fields(&source, "sun", entries, ["towards", "color"])?;
                environment.sun = Some(Sun {
                    towards: three(&source, "sun.towards", towards)?,
                    color: three(&source, "sun.color", color)?,
                });
            }
            ("lobe", Raw::Array(lobes)) => {
                let lobes = lobes.iter().enumerate();
                environment.lobes = lobes.map(|(i, value)| lobe(&source, i, value)).collect::<Result<_, _>>()?;
            }
            ("sun", other) => return Err(source.fault("sun", other.unexpected("a table"))),
            ("lobe", other) => return Err(source.fault("lobe", other.unexpected("tables, each [[lobe]]"))),
            (other, _) => return Err(unknown(&source, other, &["even", "sun", "lobe"])),
        }
    }
    match environment.fault() {
        Some((key, reason)) => Err(source.fault(&key, reason)),
        None => Ok(environment),
    }
}

// This is parsed without serde. Web pages load this code, and serde's code for three tables would be 5 % of their
// download.

fn lobe(source: &TomlText<'_>, number: usize, value: &Raw) -> Result<LightLobe, StageError> {
    let at = format!("lobe[{number}]");
    let Raw::Table(entries) = value else { return Err(source.fault(&at, value.unexpected("a table"))) };
    let [towards, width, radiance] = fields(source, &at, entries, ["towards", "width_deg", "radiance"])?;
    let key = |name: &str| format!("{at}.{name}");
    Ok(LightLobe {
        towards: three(source, &key("towards"), towards)?,
        width_deg: number_of(source, &key("width_deg"), width)?,
        radiance: three(source, &key("radiance"), radiance)?,
    })
}

/// Returns the values of a table's fields. All of them are required; others are an error.
fn fields<'r, const N: usize>(
    source: &TomlText<'_>,
    at: &str,
    entries: &'r [(String, Raw)],
    names: [&str; N],
) -> Result<[&'r Raw; N], StageError> {
    if let Some((other, _)) = entries.iter().find(|(key, _)| !names.contains(&key.as_str())) {
        return Err(unknown(source, &format!("{at}.{other}"), &names));
    }
    let mut found = [const { &Raw::Bool(false) }; N];
    for (slot, name) in found.iter_mut().zip(names) {
        let value = entries.iter().find(|(key, _)| key == name).map(|(_, value)| value);
        *slot = value.ok_or_else(|| source.fault(at, format!("missing field `{name}`")))?;
    }
    Ok(found)
}

fn unknown(source: &TomlText<'_>, key: &str, names: &[&str]) -> StageError {
    let name = key.rsplit('.').next().unwrap_or(key);
    source.fault(key, format!("unknown field `{name}`, expected one of {}", names.join(", ")))
}

fn number_of(source: &TomlText<'_>, key: &str, value: &Raw) -> Result<f32, StageError> {
    value.number().map(|x| x as f32).ok_or_else(|| source.fault(key, value.unexpected("a number")))
}

fn three(source: &TomlText<'_>, key: &str, value: &Raw) -> Result<[f32; 3], StageError> {
    match value {
        Raw::Array(items) if items.len() == 3 => {
            let mut out = [0.0; 3];
            for (slot, item) in out.iter_mut().zip(items) {
                *slot = number_of(source, key, item)?;
            }
            Ok(out)
        }
        other => Err(source.fault(key, other.unexpected("three numbers"))),
    }
}

/// Writes an environment map as TOML. Reading the text gives an equal map.
pub fn environment_to_toml(environment: &Environment) -> String {
    let list = |numbers: [f32; 3]| {
        let [x, y, z] = numbers.map(|x| format!("{x:?}"));
        format!("[{x}, {y}, {z}]")
    };
    let mut text = format!("# Radiance from everywhere, linear RGB.\neven = {}\n", list(environment.even));
    if let Some(sun) = environment.sun {
        text += "\n# Light from a single direction; colour 1 gives an irradiance of pi.\n[sun]\n";
        text += &format!("towards = {}\ncolor = {}\n", list(sun.towards), list(sun.color));
    }
    if !environment.lobes.is_empty() {
        text += "\n# Lights spread around a direction (+y is up): standard deviation, and radiance at the centre.\n";
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
