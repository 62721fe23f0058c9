//! What a scene file says in words of the command line.

use super::exit::Failure;
use super::view_args::{Direction, Position, ViewArgs};
use pelage_stage::{SceneFile, SceneLight, StageError};

/// Options that have another place in a scene, or none.
const ELSEWHERE: [(&str, &str); 9] = [
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

/// `[view]` as words of the command line.
/// `check`: says in words what is wrong with an option.
pub fn options(file: &SceneFile, check: fn(&str) -> Result<(), String>) -> Result<Vec<String>, StageError> {
    let mut options = Vec::new();
    for (name, value) in &file.scene.view {
        let fail = |reason: String| file.fault(&format!("view.{name}"), reason);
        if let Some((_, place)) = ELSEWHERE.iter().find(|(key, _)| key == name) {
            return Err(fail(format!("expected it {place}")));
        }
        let values = value.as_array().map_or(std::slice::from_ref(value), Vec::as_slice);
        for value in values {
            let value = match value {
                toml::Value::String(text) => text.clone(),
                toml::Value::Boolean(on) => if *on { "on" } else { "off" }.to_owned(),
                toml::Value::Integer(_) | toml::Value::Float(_) => value.to_string(),
                other => return Err(fail(format!("found {}, expected a word or a number", other.type_str()))),
            };
            let option = format!("--{}={value}", name.replace('_', "-"));
            check(&option).map_err(fail)?;
            options.push(option);
        }
    }
    Ok(options)
}

/// The arguments, which [`options`] are among, and where they are silent the file's light.
///
/// # Errors
///
/// [`Failure::Usage`] for arguments that make no sense with a scene.
pub fn complete(file: &str, light: Option<SceneLight>, args: &ViewArgs) -> Result<ViewArgs, Failure> {
    for (name, given) in [("--clip", args.clip.is_some()), ("--crowd", args.crowd != 1)] {
        if given {
            let text = format!("{name}: {file} says what stands in the picture, expected it to be left out");
            return Err(Failure::Usage(text));
        }
    }
    let mut args = args.clone();
    if let (Some(light), None, None) = (light, args.light, args.point_light) {
        args.light = light.direction.map(|towards| Direction(towards.0.normalize()));
        args.point_light = light.position.map(|position| Position(position.0));
    }
    Ok(args)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;
    use crate::cli::render_option;

    fn read(before: &str) -> Result<Vec<String>, StageError> {
        let text = format!("{before}\n[[model]]\npackage = \"no.pelage\"\n");
        options(&SceneFile::parse("a.toml", text.into()).unwrap(), render_option)
    }

    #[test]
    fn what_is_wrong_is_said_with_line_and_key() {
        for (text, words) in [
            ("[view]\nsize = \"9x\"", &["line 2", "view.size", "'9x'", "WIDTHxHEIGHT"][..]),
            ("[view]\nstyle = \"fluffy\"", &["line 2", "view.style", "'fluffy'", "fur, ink, bare"]),
            ("[view]\nink_widht = 3", &["line 2", "view.ink_widht", "'--ink-widht'", "--ink-width"]),
            ("[view]\nself_shadow = [[1]]", &["line 2", "view.self_shadow", "found array", "a word or a number"]),
            ("[view]\nrestart = true", &["line 2", "view.restart", "'--restart'"]),
            ("[view]\nframes = 3", &["line 2", "view.frames", "expected it in [sequence]"]),
        ] {
            let message = read(text).unwrap_err().to_string();
            for word in ["a.toml"].iter().chain(words) {
                assert!(message.contains(word), "no {word:?} in {message:?} of\n{text}");
            }
        }
    }

    #[test]
    fn options_are_words_of_the_command_line() {
        let text =
            "[view]\nsize = \"64x32\"\nself_shadow = false\npenumbra = 0.5\nfill_light = [\"0,1,0\", \"1,0,0/0.5\"]";
        let expected =
            ["--size=64x32", "--self-shadow=off", "--penumbra=0.5", "--fill-light=0,1,0", "--fill-light=1,0,0/0.5"];
        assert_eq!(read(text).unwrap(), expected);
    }
}
