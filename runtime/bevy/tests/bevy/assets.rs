//! Tests of packages as assets: loading, rejection, and reloading of files that change.

use crate::support::{TestApp, ball_package, gpu};
use bevy_app::App;
use bevy_asset::{AssetServer, Assets, Handle, LoadState};
use bevy_camera::primitives::Aabb;
use bevy_math::Vec3;
use bevy_pelage::{Pelage, PelageModel, PelagePlugin};
use bevy_render::view::Msaa;
use bevy_transform::components::Transform;
use std::fs;
use std::path::{Path, PathBuf};

fn create_folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Loads a file as an application does, and waits for it. Returns the handle, and the error if any.
fn load(test_app: &mut TestApp, file: &Path) -> (Handle<PelageModel>, Option<String>) {
    let server = test_app.world().resource::<AssetServer>().clone();
    let handle: Handle<PelageModel> = server.load(file.to_str().unwrap().to_owned());
    for _ in 0..2000 {
        test_app.app.update();
        match server.load_state(&handle) {
            LoadState::Loaded => return (handle, None),
            LoadState::Failed(error) => return (handle, Some(error.to_string())),
            _ => std::thread::sleep(std::time::Duration::from_millis(1)),
        }
    }
    panic!("{} was neither loaded nor rejected", file.display());
}

#[test]
fn damaged_packages_are_errors_and_the_app_lives_on() {
    let Some(mut test_app) = gpu("damaged_packages_are_errors_and_the_app_lives_on") else { return };
    let (folder, sound) = (create_folder("damaged"), ball_package());
    let flipped = |at: usize| {
        let mut bytes = sound.clone();
        bytes[at] ^= 0x20;
        bytes
    };
    let camera = test_app.spawn_camera([32, 24], Msaa::Off, Transform::from_xyz(0.0, 0.0, 0.7));
    test_app.spawn_sun(Vec3::new(-1.0, 1.0, 1.0), false);
    for (name, bytes, place) in [
        ("empty.pelage", Vec::new(), "byte 0"),
        ("cut.pelage", sound[..sound.len() / 2].to_vec(), ""),
        ("header.pelage", flipped(3), ""),
        ("body.pelage", flipped(sound.len() / 2), "CRC-32"),
        ("last.pelage", flipped(sound.len() - 1), ""),
        ("text.pelage", b"no package at all".to_vec(), ""),
    ] {
        let file = folder.join(name);
        fs::write(&file, bytes).unwrap();
        let (handle, error) = load(&mut test_app, &file);
        let error = error.unwrap_or_else(|| panic!("{name} was loaded"));
        assert!(error.contains(name) && error.contains(place), "{error}");
        test_app.world().spawn(Pelage::fur(handle));
        test_app.app.update();
    }
    let file = folder.join("sound.pelage");
    fs::write(&file, &sound).unwrap();
    let (handle, error) = load(&mut test_app, &file);
    assert_eq!(error, None);
    let ball = test_app.world().spawn(Pelage::fur(handle)).id();
    assert!(test_app.picture(&camera).pixel(16, 12)[..3] != [0; 3], "the intact package is drawn");
    let bounds = test_app.world().get::<Aabb>(ball).unwrap().half_extents;
    assert!((bounds.x - 0.125).abs() < 1e-3, "skin and fur: {bounds}");
}

#[test]
#[should_panic(expected = "add DefaultPlugins (or AssetPlugin) before it")]
fn plugin_before_the_asset_plugin_names_the_order() {
    App::new().add_plugins(PelagePlugin::default());
}

#[test]
fn changed_files_are_reloaded() {
    let Some(mut test_app) = gpu("changed_files_are_reloaded") else { return };
    let file = create_folder("changed").join("ball.pelage");
    fs::write(&file, ball_package()).unwrap();
    let (handle, _) = load(&mut test_app, &file);
    let camera = test_app.spawn_camera([32, 24], Msaa::Off, Transform::from_xyz(0.0, 0.0, 0.7));
    test_app.spawn_sun(Vec3::new(-1.0, 1.0, 1.0), false);
    test_app.world().spawn(Pelage::fur(handle.clone()));
    let plain = test_app.picture(&camera);
    let other = crate::sphere::package(&crate::sphere::SphereParams { stripes: true, ..Default::default() });
    fs::write(&file, other).unwrap();
    // Triggers the same reload as Bevy's file watcher.
    let server = test_app.world().resource::<AssetServer>().clone();
    server.reload(file.to_str().unwrap().to_owned());
    let before = test_app.world().resource::<Assets<PelageModel>>().get(&handle).unwrap().clips().len();
    assert_eq!(before, 1, "the ball bends");
    for _ in 0..2000 {
        test_app.app.update();
        if test_app.world().resource::<Assets<PelageModel>>().get(&handle).is_some_and(|m| m.clips().len() == 0) {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let striped = test_app.picture(&camera);
    assert!(striped.differences(&plain).0 > 3.0, "{:?}", striped.differences(&plain));
    // If the file is damaged, the loaded model stays.
    fs::write(&file, b"half a file").unwrap();
    server.reload(file.to_str().unwrap().to_owned());
    (0..200).for_each(|_| {
        test_app.app.update();
        std::thread::sleep(std::time::Duration::from_millis(1));
    });
    assert_eq!(test_app.picture(&camera), striped);
}

fn collect_files(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { collect_files(&path, files) } else { files.push(path) }
    }
}

#[test]
fn files_other_than_packages_are_refused_by_name() {
    let Some(data) = pelage_needs::data("files_other_than_packages_are_refused_by_name") else { return };
    let mut files = Vec::new();
    collect_files(&data, &mut files);
    assert!(files.len() > 100, "{} files", files.len());
    for file in files {
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        let error = PelageModel::from_bytes(&name, fs::read(&file).unwrap()).err();
        let error = error.unwrap_or_else(|| panic!("{name} was accepted as a package")).to_string();
        assert!(error.starts_with(&name), "{error}");
    }
}
