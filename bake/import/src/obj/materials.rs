//! Material files (.mtl): diffuse colours and textures. Any mistake in one causes only a warning, because the shape
//! does not depend on it.

use super::statements::{Statement, Statements, decode};
use crate::image_file::ImageList;
use crate::json::shorten;
use crate::material::emission_as_base_color;
use crate::mesh::Material;
use crate::notes::Notes;
use crate::source::{self, Resolve};
use std::collections::{BTreeMap, btree_map};

/// Materials of all material files, and the list of those that faces use.
#[derive(Debug, Default)]
pub(super) struct Library {
    /// Used materials, in the order of first use.
    pub used: Vec<Material>,
    /// Decoded images of the used materials.
    pub images: ImageList,
    known: BTreeMap<String, Entry>,
    /// Index in `used`, by the material's name.
    numbers: BTreeMap<String, usize>,
    /// Index in `images` by path; `None` for an image that cannot be read.
    image_numbers: BTreeMap<String, Option<usize>>,
    any_file: bool,
}

/// A material as described in a material file.
#[derive(Clone, Debug, Default)]
struct Entry {
    diffuse: Option<[f32; 3]>,
    /// Path of the texture, relative to the model's folder. The second text is the material file and line that name it.
    texture: Option<(String, String)>,
    /// Emission: colour and texture, as above.
    emission: Option<[f32; 3]>,
    emission_texture: Option<(String, String)>,
}

impl Library {
    /// Reads all material files; `names` are the arguments of `mtllib`.
    pub fn read(names: &[(usize, String)], resolve: &mut Resolve<'_>, notes: &mut Notes) -> Self {
        let mut library = Self::default();
        for (line, argument) in names {
            // Names with spaces are common and lists of names are rare, so the whole argument is tried as one name
            // first.
            let whole = fetch(argument, resolve, notes).map(|bytes| vec![(argument.as_str(), bytes)]);
            let found = whole.or_else(|error| {
                let words: Vec<&str> = argument.split_whitespace().collect();
                if words.len() < 2 {
                    return Err(error);
                }
                words.into_iter().map(|word| fetch(word, resolve, notes).map(|bytes| (word, bytes))).collect()
            });
            match found {
                Ok(files) => {
                    for (name, bytes) in files {
                        notes.record("material", name, &bytes);
                        library.add(name, &bytes, notes);
                    }
                }
                Err(reason) => notes.warn(format!(
                    "line {line} names the material file \"{}\": {reason}; its materials are white",
                    shorten(argument)
                )),
            }
        }
        library
    }

    fn add(&mut self, file: &str, bytes: &[u8], notes: &mut Notes) {
        let text = match decode(file, bytes) {
            Ok(text) => text,
            Err(error) => return notes.warn(error.to_string()),
        };
        self.any_file = true;
        let mut entry: Option<(String, Entry)> = None;
        for statement in Statements::new(&text) {
            let s = &statement;
            match (s.keyword(), &mut entry) {
                ("newmtl", _) => {
                    let next = (s.name().to_owned(), Entry::default());
                    self.keep(file, entry.replace(next), notes);
                }
                (key @ ("Kd" | "Ke"), Some((_, entry))) => match color(file, s) {
                    Ok(color) => *(if key == "Kd" { &mut entry.diffuse } else { &mut entry.emission }) = Some(color),
                    Err(reason) => notes.warn(format!("{reason}; left out")),
                },
                (key @ ("map_Kd" | "map_Ke"), Some((_, entry))) => match texture_name(s) {
                    Some(name) => {
                        let texture = Some((sibling_path(file, &name), format!("{file}: line {}", s.line)));
                        *(if key == "map_Kd" { &mut entry.texture } else { &mut entry.emission_texture }) = texture;
                    }
                    None => notes.warn(format!("{file}: line {}: `{key}` names no file; left out", s.line)),
                },
                _ => {}
            }
        }
        self.keep(file, entry, notes);
    }

    fn keep(&mut self, file: &str, entry: Option<(String, Entry)>, notes: &mut Notes) {
        let Some((name, entry)) = entry else { return };
        match self.known.entry(name) {
            btree_map::Entry::Vacant(place) => drop(place.insert(entry)),
            btree_map::Entry::Occupied(place) => {
                notes.warn(format!(
                    "{file}: material \"{}\" is defined twice; the first definition is used",
                    shorten(place.key())
                ));
            }
        }
    }

    /// Returns the index in [`Self::used`] of the material `name`, as used by faces.
    pub fn material(&mut self, name: &str, resolve: &mut Resolve<'_>, notes: &mut Notes) -> usize {
        if let Some(number) = self.numbers.get(name) {
            return *number;
        }
        let mut entry = self.known.get(name).cloned().unwrap_or_default();
        // If no material file was read, a warning about that exists already, or none is needed.
        if self.any_file && !name.is_empty() && !self.known.contains_key(name) {
            notes.warn(format!("material \"{}\" is not in any material file; it is white", shorten(name)));
        }
        if entry.texture.is_none() && entry.diffuse == Some([0.0; 3]) && entry.emission.is_some_and(|e| e != [0.0; 3]) {
            notes.warn(emission_as_base_color(name));
            (entry.diffuse, entry.texture) = (entry.emission, entry.emission_texture.take());
        }
        let base_color_image = entry.texture.as_ref().and_then(|(path, at)| self.image(path, at, resolve, notes));
        let mut diffuse = entry.diffuse.unwrap_or([1.0; 3]);
        if base_color_image.is_some() && diffuse == [0.0; 3] {
            notes.warn(format!("material \"{}\" has a black Kd and a texture; read as white", shorten(name)));
            diffuse = [1.0; 3];
        }
        let [r, g, b] = diffuse;
        self.used.push(Material {
            name: name.to_owned(),
            base_color: [r, g, b, 1.0],
            base_color_image,
            ..Material::default()
        });
        self.numbers.insert(name.to_owned(), self.used.len() - 1);
        self.used.len() - 1
    }

    fn image(&mut self, path: &str, at: &str, resolve: &mut Resolve<'_>, notes: &mut Notes) -> Option<usize> {
        if let Some(known) = self.image_numbers.get(path) {
            return *known;
        }
        let it = |reason| format!("it {reason}");
        let decoded = self.images.check_limits().map_err(it).and_then(|()| {
            let bytes = fetch(path, resolve, notes)?;
            let name = format!("the image file \"{}\"", shorten(path));
            let number = self.images.add(&bytes, &name, &mut |text| notes.warn(text)).map_err(it)?;
            notes.record("image", path, &bytes);
            Ok(number)
        });
        let number = match decoded {
            Ok(number) => Some(number),
            Err(reason) => {
                notes.warn(format!("{at} names the image file \"{}\": {reason}; only Kd is used", shorten(path)));
                None
            }
        };
        self.image_numbers.insert(path.to_owned(), number);
        number
    }
}

/// Parses a colour: `Kd r g b`, or `Kd r` for a grey. The numbers are linear, as written by Blender and obj2gltf.
fn color(file: &str, s: &Statement<'_>) -> Result<[f32; 3], crate::BakeError> {
    if let Some(other @ ("spectral" | "xyz")) = s.words().next() {
        return Err(crate::BakeError::Input {
            file: file.to_owned(),
            place: format!("line {}", s.line),
            reason: format!("`{}` is `{other}`, expected r g b", s.keyword()),
        });
    }
    let ([r, g, b], count) = s.numbers::<3>(file, 1)?;
    let color = match count {
        1 => [r; 3],
        2 => [r, g, g],
        _ => [r, g, b],
    };
    Ok(color.map(|x| x.clamp(0.0, 1.0)))
}

/// Returns the file name in a texture statement. It follows the options, each of which has a known number of arguments.
/// It may contain spaces.
fn texture_name(s: &Statement<'_>) -> Option<String> {
    let words: Vec<&str> = s.words().collect();
    let mut i = 0;
    while let Some(option) = words.get(i).filter(|w| w.starts_with('-')) {
        i += 1;
        let numbers = match *option {
            "-blendu" | "-blendv" | "-cc" | "-clamp" | "-imfchan" | "-texres" | "-bm" | "-boost" | "-type" => {
                i += 1;
                0
            }
            "-mm" => 2,
            // Options for offset, scale and turbulence: the second and third number may be missing.
            "-o" | "-s" | "-t" => 3,
            _ => 0,
        };
        let given = words.iter().skip(i).take(numbers).take_while(|w| w.parse::<f32>().is_ok()).count();
        i += given;
    }
    let rest = words.get(i..).unwrap_or_default();
    if rest.is_empty() {
        return None;
    }
    // If options precede the name, the exact spaces between its words are lost. In practice, each is a single space.
    Some(if i == 0 { s.name().to_owned() } else { rest.join(" ") })
}

/// Returns the path of the file `name`, relative to the model's folder; `file` is the file that names it.
fn sibling_path(file: &str, name: &str) -> String {
    let (file, name) = (file.replace('\\', "/"), name.replace('\\', "/"));
    match file.rsplit_once('/') {
        Some((folder, _)) if !name.starts_with('/') => format!("{folder}/{name}"),
        _ => name,
    }
}

/// Returns the bytes of a file, or the reason why it cannot be read. Names in OBJ are plain paths, while `resolve`
/// requires URIs.
fn fetch(path: &str, resolve: &mut Resolve<'_>, notes: &mut Notes) -> Result<Vec<u8>, String> {
    let path = path.replace('\\', "/");
    let drive = path.as_bytes().get(1) == Some(&b':') && path.as_bytes()[0].is_ascii_alphabetic();
    if drive || path.starts_with('/') {
        return Err("it is an absolute path; expected a relative one: put the file beside the model".to_owned());
    }
    source::fetch_file(&source::path_as_uri(&path), resolve, notes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texture_options_precede_the_name() {
        for (text, expected) in [
            ("map_Kd a.png", Some("a.png")),
            ("map_Kd  two  words.png ", Some("two  words.png")),
            ("map_Kd -s 1 1 1 -o 0.5 a.png", Some("a.png")),
            ("map_Kd -clamp on -mm 0 1 -bm 1 my coat.png", Some("my coat.png")),
            ("map_Kd -s 1 1 1", None),
            ("map_Kd", None),
        ] {
            let found = Statements::new(text).next().and_then(|s| texture_name(&s));
            assert_eq!(found.as_deref(), expected, "{text}");
        }
        assert_eq!(sibling_path("skins\\a.mtl", "b.png"), "skins/b.png");
        assert_eq!(sibling_path("a.mtl", "maps\\b.png"), "maps/b.png");
    }
}
