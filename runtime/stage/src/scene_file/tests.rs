use super::*;
use crate::Look;

/// Reads a scene file that contains `text`. Its packages do not exist.
fn read(text: &str) -> Result<LoadedScene, StageError> {
    let nothing = |path: &str| Err(format!("{path}: cannot read: it does not exist"));
    SceneFile::parse("nowhere/a.toml", text.into())?.load(&nothing)
}

/// Returns a scene file with `before` ahead of its single model, and with `model` in the model's table.
fn scene(before: &str, model: &str) -> String {
    format!("{before}\n[[model]]\npackage = \"no.pelage\"\n{model}\n")
}

#[test]
fn scene_errors_name_line_and_key() {
    let path = |keys: &str| format!("path = [\n{keys}\n]");
    let (camera, go) = ("[camera]\n", "{ time_s = 0, position = [0, 0, 0] },\n");
    for (text, words) in [
        ("", &["model", "found none", "[[model]]"][..]),
        ("[camera\n", &["line 1"]),
        (&scene("colour = 1", ""), &["line 1", "unknown field `colour`", "view"]),
        (&scene("\nlook = 3", ""), &["line 2, look: found integer", "path of a look file", "[look.shadow]"]),
        (&scene("", "plaice = 1"), &["line 4", "model[0]", "unknown field `plaice`", "package"]),
        ("[[model]]\nname = \"a\"\n", &["line 1", "model[0]", "missing field `package`"]),
        (&scene("", "position = [0, nan, 0]"), &["line 4", "model[0].position", "found NaN", "-1000000 to 1000000"]),
        (&scene("", "position = [0, 1]"), &["line 4", "model[0].position", "length 2", "length 3"]),
        (&scene("", "position = \"here\""), &["line 4", "model[0].position", "string", "array"]),
        (&scene("", "heading_deg = inf"), &["line 4", "model[0].heading_deg", "found inf"]),
        (&scene("", "scale = 0"), &["line 4", "model[0].scale", "found 0", "0.0001 to 10000"]),
        (&scene("", &path("")), &["line 4", "model[0].path", "found no keys", "at least one"]),
        (
            &scene(
                "",
                &path(&format!(
                    "{go}{{ time_s = 2, position = [1, 0, 0] }},\n{{ time_s = 1.5, position = [2, 0, 0] }}"
                )),
            ),
            &["line 7", "model[0].path[2].time_s", "found 1.5 after 2"],
        ),
        (
            &scene("", &path(&format!("{go}{{ time_s = nan, position = [1, 0, 0] }}"))),
            &["line 6", "path[1]", "found NaN"],
        ),
        (
            &scene("", &path(&format!("{go}{{ time_s = 1, position = [1, 0, 0], heading_deg = 3 }}"))),
            &["line 5", "model[0].path[0]", "no heading_deg", "in all keys"],
        ),
        (&scene("", &format!("position = [0, 0, 0]\n{}", path(go))), &["line 4", "model[0].position", "beside a path"]),
        (&scene("", "speed = 2"), &["line 4", "model[0].speed", "without a clip"]),
        (&scene("", "root_motion = true"), &["line 4", "model[0].root_motion", "without a clip"]),
        (&scene("", "loop = \"yes\"\nclip = \"a\""), &["line 4", "model[0].loop", "boolean"]),
        (&scene(camera, ""), &["line 1", "camera", "expected eye and target, or a path"]),
        (&scene("[camera]\npath = []", ""), &["line 2", "camera.path", "found no keys"]),
        (&scene("[camera]\neye = [0, 1, 2]\ntarget = [0, 1, 2]", ""), &["line 3", "camera.target", "same point"]),
        (
            &scene("[camera]\neye = [0, 1, 2]\ntarget = [0, 0, 0]\nfov_deg = 171", ""),
            &["line 4", "camera.fov_deg", "found 171", "1 to 170"],
        ),
        (
            &scene("[camera]\nfov_deg = 30\npath = [{ time_s = 0, eye = [0, 0, 1], target = [0, 0, 0] }]", ""),
            &["line 1", "camera", "in the keys of the path"],
        ),
        (&scene("[light]", ""), &["line 1", "light", "found neither"]),
        (&scene("[light]\ndirection = [0, 0, 0]", ""), &["line 2", "light.direction", "direction that is zero"]),
        (
            &scene("[light]\ndirection = [0, 1, 0]\nposition = [0, 1, 0]", ""),
            &["light", "found direction and position"],
        ),
        (&scene("[sequence]\nframes = 0", ""), &["line 2", "sequence.frames", "found 0", "1 to 100000"]),
        (&scene("[sequence]\nfps = 24.5", ""), &["line 2", "sequence.fps", "24.5"]),
        (
            &scene("", "name = \"a\"\n[[model]]\npackage = \"b\"\nname = \"a\""),
            &["line 7", "model[1].name", "model[0]"],
        ),
        (&scene("", ""), &["line 3", "model[0].package", "no.pelage", "cannot read"]),
    ] {
        let error = read(text).err().unwrap();
        assert!(matches!(error, StageError::Input { .. }), "{text}: {error}");
        let message = error.to_string();
        for word in ["a.toml"].iter().chain(words) {
            assert!(message.contains(word), "no {word:?} in {message:?} of\n{text}");
        }
    }
}

#[test]
fn positions_and_cameras_match_the_file() {
    let text = scene(
        "[camera]\npath = [\n\
         { time_s = 0, eye = [0, 1, 5], target = [0, 0, 0] },\n\
         { time_s = 2, eye = [4, 1, 5], target = [4, 0, 0], fov_deg = 40 }]",
        "path = [{ time_s = 1, position = [0, 0, 0] }, { time_s = 3, position = [2, 0, 0] }]\nscale = 2",
    );
    let source = TomlText { name: "a.toml", text: &text };
    let words: Scene = source.parse().unwrap();
    let shot = shot(&source, words.camera.as_ref().unwrap()).unwrap();
    let at = |time_s| (shot.at(time_s).eye, shot.at(time_s).target, shot.at(time_s).fov_deg);
    assert_eq!(at(0.0), (Vec3::new(0.0, 1.0, 5.0), Vec3::ZERO, FOV_DEG));
    assert_eq!(at(1.0), (Vec3::new(2.0, 1.0, 5.0), Vec3::new(2.0, 0.0, 0.0), (FOV_DEG + 40.0) / 2.0));
    let place = place(&source, 0, &words.models[0]).unwrap();
    let moved = place.transform(2.0);
    assert!(moved.transform_point3(Vec3::ZERO).distance(Vec3::X) < 1e-6);
    // The nose, baked along +z, points in the direction of movement.
    assert!(moved.transform_vector3(Vec3::Z).distance(2.0 * Vec3::X) < 1e-6);
    assert_eq!(names(&source, &words.models).unwrap(), ["no"]);
}

/// Returns a package with one joint and two clips. One moves the joint by 2 m along +z in a second; the other does not
/// move it.
fn sliding() -> Vec<u8> {
    let node = pelage_formats::Node {
        name: "root".into(),
        parent: None,
        translation: [0.0; 3],
        rotation: [0.0, 0.0, 0.0, 1.0],
        scale: [1.0; 3],
    };
    let channel = |way: f32| pelage_formats::Channel {
        node: 0,
        property: pelage_formats::Property::Translation,
        interpolation: pelage_formats::Interpolation::Linear,
        times: vec![0.0, 1.0],
        values: vec![0.0, 0.0, 0.0, 0.0, 0.0, way],
    };
    let clip = |(name, way): (&str, f32)| pelage_formats::Clip {
        name: name.into(),
        duration_s: 1.0,
        channels: vec![channel(way)],
    };
    let animation = Animation {
        nodes: vec![node],
        joints: vec![pelage_formats::Joint { node: 0, inverse_bind: glam::Mat4::IDENTITY.to_cols_array() }],
        clips: [("Slide", 2.0), ("Stay", 0.0)].map(clip).to_vec(),
        ..Animation::default()
    };
    pelage_formats::PackageWriter::new(pelage_formats::Manifest::default()).animation(&animation).finish().unwrap()
}

#[test]
fn root_motion_moves_the_model() {
    let load = |model: &str| {
        let source = |path: &str| Ok(NamedPackage::new(path, sliding()));
        SceneFile::parse("a.toml", scene("", model).into()).unwrap().load(&source)
    };
    let model = "heading_deg = 90\nscale = 2\nroot_motion = true\n";
    let actor = load(&format!("clip = \"Slide\"\n{model}")).unwrap().actors.remove(0);
    // Position of the root: the clip moves it within a cycle, the model moves it between cycles.
    for time_s in [0.0, 0.25, 0.999, 1.5, 7.75, -0.5] {
        let within = 2.0 * actor.clip.unwrap().moment(time_s);
        let root = actor.transform(time_s).transform_point3(Vec3::Z * within);
        assert!(root.distance(Vec3::X * 4.0 * time_s) < 1e-4, "{root} at {time_s}");
    }
    assert!(actor.moves());
    let once = load(&format!("clip = \"Slide\"\nloop = false\n{model}")).unwrap().actors.remove(0);
    assert_eq!(once.transform(7.0).w_axis.truncate(), Vec3::ZERO);
    let fault = load(&format!("clip = \"Stay\"\n{model}")).err().unwrap().to_string();
    assert!(fault.contains("root_motion") && fault.contains("\"Stay\" ends where it began"), "{fault}");
}

#[test]
fn scene_can_be_edited_between_parsing_and_loading() {
    let mut file = SceneFile::parse("a.toml", scene("[sequence]\nframes = 3", "").into()).unwrap();
    assert_eq!((file.frames(), file.fps()), (Some(3), None));
    file.scene.models[0].position = Some(Point(Vec3::new(0.0, 0.0, 7.0)));
    let mut second = file.scene.models[0].clone();
    (second.name, second.heading_deg) = (Some("back".into()), Some(Number(180.0)));
    file.scene.models.push(second);
    let asked = std::cell::RefCell::new(Vec::new());
    let empty = pelage_formats::PackageWriter::new(pelage_formats::Manifest::default()).finish().unwrap();
    let source = |path: &str| {
        asked.borrow_mut().push(path.to_owned());
        Ok(NamedPackage::new(path, empty.clone()))
    };
    let loaded = file.load(&source).unwrap();
    assert_eq!(*asked.borrow(), ["no.pelage"], "one package of two models is read once");
    assert_eq!(loaded.names, ["no", "back"]);
    assert_eq!(loaded.actors[0].place.transform(0.0).w_axis.z, 7.0);
    let cast = loaded.cast(None, 2.0, &crate::Framing::default()).unwrap();
    assert_eq!((cast.packages.len(), cast.actors.len()), (1, 2));
    file.scene.models.clear();
    assert!(file.load(&source).unwrap_err().to_string().contains("found none"));
}

fn look(text: &str) -> Result<Look, StageError> {
    SceneFile::parse("a.toml", scene(text, "").into()).unwrap().look(|path| match path {
        "shared.toml" => Ok((path.into(), "[light]\nposition_m = [1, 2, 3]\n[picture]\nsize = \"10x20\"\n".to_owned())),
        "faulty.toml" => Ok((format!("scenes/{path}"), "\n[ink]\ntone = 3\n".to_owned())),
        _ => Err("cannot read".to_owned()),
    })
}

fn after(words: &[&str]) -> Look {
    let mut look = Look::of_picture();
    words.iter().for_each(|word| look.set(word).unwrap());
    look
}

#[test]
fn scene_file_sets_the_look() {
    assert_eq!(look("").unwrap(), Look::of_picture());
    let view = "[view]\nsize = \"64x32\"\nself_shadow = false\npenumbra = \"0.5\"\n\
                samples = 4\nfill_light = [\"0,1,0\", \"1,0,0/0.5\"]\n";
    let words = [
        "picture.size=64x32",
        "shadow.self_shadow=off",
        "shadow.penumbra=0.5",
        "picture.samples=4",
        "light.fill=[\"0,1,0\", \"1,0,0/0.5\"]",
    ];
    assert_eq!(look(view).unwrap(), after(&words));
    let tables = look(&format!("{view}[look.shadow]\npenumbra = 1\n[look.picture]\nstyle = \"ink\"\n")).unwrap();
    assert_eq!(tables, after(&[words.as_slice(), &["shadow.penumbra=1", "picture.style=ink"]].concat()));
    let shared = look("look = \"shared.toml\"\n").unwrap();
    assert_eq!(shared, after(&["light.position_m=1,2,3", "picture.size=10x20"]));
    let lit = look("look = \"shared.toml\"\n[light]\ndirection = [0, 1, 0]\n").unwrap();
    assert_eq!(lit, after(&["light.direction=0,1,0", "picture.size=10x20"]));
    let lamp = look("[light]\nposition = [4, 5, 6]\n").unwrap();
    assert_eq!(lamp, after(&["light.position_m=4,5,6"]));
}

#[test]
fn errors_in_a_scene_look_name_line_and_key() {
    for (text, words) in [
        ("[view]\nsize = \"9x\"", &["a.toml: line 2, view.size", "\"9x\"", "WIDTHxHEIGHT"][..]),
        ("[view]\nstyle = \"fluffy\"", &["line 2, view.style", "\"fluffy\"", "\"fur\", \"ink\", \"bare\""]),
        ("[view]\nink_widht = 3", &["line 2, view.ink_widht", "did you mean ink_width?"]),
        ("[view]\nself_shadow = [[1]]", &["line 2, view.self_shadow", "found array", "a word or a number"]),
        ("[view]\nrestart = true", &["line 2, view.restart", "unknown key"]),
        ("[view]\nframes = 3", &["line 2, view.frames", "expected this key in [sequence]"]),
        ("[look.ink]\ntone = 3", &["a.toml: line 2, look.ink.tone: found 3, expected a number 0..=1"]),
        ("[look.ink]\ntoen = 3", &["line 2, look.ink.toen: unknown key; did you mean ink.tone?"]),
        ("look = \"faulty.toml\"", &["scenes/faulty.toml: line 3, ink.tone: found 3"]),
        ("look = \"none.toml\"", &["a.toml: line 1, look: cannot read"]),
    ] {
        let message = look(text).unwrap_err().to_string();
        for word in words {
            assert!(message.contains(word), "no {word:?} in {message:?} of\n{text}");
        }
    }
}
