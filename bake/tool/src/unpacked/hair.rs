//! Converts guided hair (section `HAIR`) to one `.hair` file per group and a JSON file, and back.
//!
//! The `.hair` files contain the guides on the mesh at rest, metres in world space, y up; `hair.json` contains all
//! other data of a group. An unedited guide is packed to exactly the integers it was unpacked from. Integers that
//! cannot be recovered from a `.hair` file are stored in `exact`, and are used as long as the guide still matches them.

use super::json::{File, deserialize, json_value, known_keys, shorten_floats, to_rows};
use glam::{Vec2, Vec3};
use pelage_bake::stages::hair_groups::{GuidesAtRest, RestMesh};
use pelage_bake::strands::export::write_hair;
use pelage_bake::strands::{CurvePoint, Curves};
use pelage_formats::HairGroup;
use pelage_formats::meaning::hair_groups::hair_radius;
use pelage_formats::meaning::srgb_to_linear;
use pelage_import::BakeError;
use pelage_import::guides::read::HairFile;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// Name of the JSON file.
pub const JSON: &str = "hair.json";
/// Key of a group that the JSON file omits, because the `.hair` file replaces it.
const OFFSETS: &str = "guide_offsets";
/// Key that the JSON file adds to a group: its list of [`ExactGuide`].
const EXACT: &str = "exact";

/// Stored integers of a guide that cannot be recovered from the `.hair` file.
#[derive(Serialize, Deserialize)]
struct ExactGuide {
    guide: usize,
    offsets: Vec<[i16; 3]>,
}

fn name_of(number: usize, group: &HairGroup) -> String {
    let plain = group.name.chars().take(40).map(|c| if c.is_ascii_alphanumeric() { c } else { '_' });
    format!("hair_{number}_{}.hair", plain.collect::<String>())
}

fn failed(error: impl std::fmt::Display) -> BakeError {
    BakeError::Internal(format!("writing {JSON}: {error}"))
}

/// Converts a group to JSON, without the data that its `.hair` file contains.
fn described(group: &HairGroup, exact: &[ExactGuide]) -> Result<Value, BakeError> {
    let mut value = serde_json::to_value(group).map_err(failed)?;
    if let Some(object) = value.as_object_mut() {
        object.remove(OFFSETS);
        object.insert(EXACT.into(), serde_json::to_value(exact).map_err(failed)?);
    }
    shorten_floats(&mut value);
    Ok(value)
}

/// Returns the names and contents of all files, the JSON file first. Returns `None` if reading them back would not give
/// the same groups.
pub fn write(groups: &[HairGroup], skin: &RestMesh) -> Result<Option<Vec<File>>, BakeError> {
    let at_rest = GuidesAtRest(skin);
    let (mut list, mut files) = (Vec::new(), Vec::new());
    for (number, group) in groups.iter().enumerate() {
        let offsets: Vec<&[[i16; 3]]> = group.guide_offsets.chunks(group.guide_points as usize - 1).collect();
        let guides: Vec<Vec<Vec3>> =
            group.roots().zip(&offsets).map(|(root, offsets)| at_rest.points(&root, offsets, group.reach_m)).collect();
        let mut back = group.clone();
        let led = at_rest.set(&mut back, &guides, &vec![None; guides.len()]).is_ok();
        let same = |guide: usize| {
            led && back.guide_offsets.chunks(group.guide_points as usize - 1).nth(guide) == Some(offsets[guide])
        };
        let exact: Vec<ExactGuide> = (0..offsets.len())
            .filter(|guide| !same(*guide))
            .map(|guide| ExactGuide { guide, offsets: offsets[guide].to_vec() })
            .collect();
        list.push(described(group, &exact)?);
        files.push((name_of(number, group), shown(group, &guides)?));
    }
    let json = (JSON.to_owned(), to_rows(&Value::Array(list)).into_bytes());
    let same = read(&json, &files, skin).is_ok_and(|back| back == groups);
    files.insert(0, json);
    Ok(same.then_some(files))
}

/// Writes the `.hair` file of a group. Radii and colours are included for display; only the points are read back.
fn shown(group: &HairGroup, guides: &[Vec<Vec3>]) -> Result<Vec<u8>, BakeError> {
    let [root, tip] = [group.root_color, group.tip_color].map(|c| Vec3::from(c.map(srgb_to_linear)));
    let mut curves = Curves::default();
    curves.begin_group(&group.name);
    for guide in guides {
        let last = (guide.len().max(2) - 1) as f32;
        let point = |(k, position_ws): (usize, &Vec3)| {
            let share = k as f32 / last;
            CurvePoint {
                position_ws: *position_ws,
                radius_m: hair_radius(group, share),
                color: root.lerp(tip, share),
                ..CurvePoint::default()
            }
        };
        curves.push(&guide.iter().enumerate().map(point).collect::<Vec<_>>(), false, Vec2::ZERO);
    }
    let mut bytes = Vec::new();
    write_hair(&curves, &mut bytes).map_err(failed)?;
    Ok(bytes)
}

/// Reads the groups; file names are for messages.
pub fn read((json_file, json): &File, files: &[File], skin: &RestMesh) -> Result<Vec<HairGroup>, BakeError> {
    let value = json_value(json_file, json)?;
    let list = value.as_array().ok_or_else(|| {
        let reason = "expected a list of groups".to_owned();
        BakeError::Input { file: json_file.clone(), place: "whole file".into(), reason }
    })?;
    if list.len() != files.len() {
        let reason = format!("found {} groups, expected {}, one for each .hair file", list.len(), files.len());
        return Err(BakeError::Input { file: json_file.clone(), place: "whole file".into(), reason });
    }
    let groups = list.iter().zip(files).enumerate();
    groups.map(|(number, (value, file))| group(json_file, number, value, file, skin)).collect()
}

fn group(
    json_file: &str,
    number: usize,
    value: &Value,
    (file, bytes): &File,
    skin: &RestMesh,
) -> Result<HairGroup, BakeError> {
    let fault = |file: &str, place: String, reason: String| BakeError::Input { file: file.to_owned(), place, reason };
    let in_json = |key: String, reason: String| fault(json_file, format!("/{number}{key}"), reason);
    let mut full = value.clone();
    let object =
        full.as_object_mut().ok_or_else(|| in_json(String::new(), format!("found {value}, expected a group")))?;
    let exact = object.remove(EXACT).ok_or_else(|| in_json(format!("/{EXACT}"), "missing".into()))?;
    object.insert(OFFSETS.into(), json!([]));
    let mut group: HairGroup = deserialize(json_file, &format!("/{number}"), full)?;
    let exact: Vec<ExactGuide> = deserialize(json_file, &format!("/{number}/{EXACT}"), exact)?;
    known_keys(json_file, &format!("/{number}"), value, &described(&group, &exact)?)?;
    let scalp = group.scalp.iter().map(|(triangle, _)| ("scalp", *triangle));
    let roots = group.guide_roots.iter().map(|(triangle, _)| ("guide_roots", *triangle));
    if let Some((key, found)) = scalp.chain(roots).find(|(_, found)| *found as usize >= skin.triangle_count()) {
        let reason = format!("triangle {found}, expected less than the mesh's {}", skin.triangle_count());
        return Err(in_json(format!("/{key}"), reason));
    }
    let hair = HairFile::read(file, bytes)?;
    let (found, expected) = (hair.strands.len(), group.guide_roots.len());
    if found != expected {
        let reason =
            format!("found {found} strands, expected {expected}, the length of /{number}/guide_roots in {JSON}");
        return Err(fault(file, "byte 4".into(), reason));
    }
    if let Some(odd) = hair.strands.iter().position(|points| *points != group.guide_points) {
        let reason = format!(
            "found {} points, expected {}, as in /{number}/guide_points of {JSON}",
            hair.strands[odd], group.guide_points
        );
        return Err(fault(file, format!("strand {odd}"), reason));
    }
    let guides: Vec<Vec<Vec3>> = hair.ranges().map(|range| hair.points[range].to_vec()).collect();
    let each = (group.guide_points as usize).saturating_sub(1);
    let mut kept = vec![None; expected];
    for (k, ExactGuide { guide, offsets }) in exact.iter().enumerate() {
        if *guide >= expected || offsets.len() != each {
            let found = offsets.len();
            let reason = format!(
                "found guide {guide} with {found} offsets, expected a guide below {expected} with {each} offsets"
            );
            return Err(in_json(format!("/{EXACT}/{k}"), reason));
        }
        kept[*guide] = Some(&offsets[..]);
    }
    let set = GuidesAtRest(skin).set(&mut group, &guides, &kept);
    set.map_err(|(guide, reason)| fault(file, format!("strand {guide}"), reason))?;
    Ok(group)
}
