//! Tests of `pelage compare` with the real binary.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use image::{DynamicImage, ImageFormat, Rgba, RgbaImage};
use pelage_tests::binary::{Run, Sandbox};
use pelage_tests::schema;
use serde_json::Value;
use std::io::Cursor;

#[track_caller]
fn json_of(run: &Run, code: i32) -> Value {
    assert_eq!(run.code, Some(code), "{run:?}");
    schema::parse_answer(run, "compare")
}

fn encoded(image: DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// Returns a disc in the colour of hair, on a transparent background. `stripe` is the darkening of every fourth column.
fn disc(stripe: u8) -> RgbaImage {
    RgbaImage::from_fn(48, 32, |x, y| {
        let inside = (x as f32 - 24.0).hypot(y as f32 - 16.0) < 14.0;
        let dark = if x % 4 == 0 { stripe } else { 0 };
        if inside { Rgba([200 - dark, 170 - dark, 130 - dark, 255]) } else { Rgba([0; 4]) }
    })
}

fn pictures() -> Sandbox {
    let sandbox = Sandbox::new();
    sandbox.write("a.png", encoded(disc(0).into(), ImageFormat::Png));
    sandbox.write("same.png", encoded(DynamicImage::ImageRgba8(disc(0)).into_rgba16().into(), ImageFormat::Png));
    sandbox.write("other.png", encoded(disc(60).into(), ImageFormat::Png));
    sandbox.write("small.png", encoded(RgbaImage::new(48, 31).into(), ImageFormat::Png));
    sandbox.write("no.png", b"no picture");
    sandbox
}

#[test]
fn equal_and_different_pictures_are_compared() {
    let sandbox = pictures();
    // The same picture is stored as an 8-bit PNG, a 16-bit PNG, and an EXR with linear premultiplied colours.
    let linear = pelage_bake::picture::Picture::from(&disc(0));
    let float = image::Rgba32FImage::from_fn(48, 32, |x, y| Rgba(linear.pixels[(y * 48 + x) as usize]));
    sandbox.write("same.exr", encoded(float.into(), ImageFormat::OpenExr));
    for other in ["a.png", "same.png", "same.exr"] {
        let strict = ["--max-flip", "0", "--max-rmse", "1e-5", "--max-coverage", "0", "--min-psnr", "100"];
        let object = json_of(&sandbox.run(&[&["compare", "a.png", other, "--json"], &strict[..]].concat()), 0);
        assert_eq!((object["flip"]["max"].as_f64(), object["different"].as_bool()), (Some(0.0), Some(false)));
        assert_eq!(object["limits"].as_array().unwrap().len(), 4);
        assert!(object["psnr_db"].as_f64().is_none_or(|db| db > 100.0), "{object}");
    }
    assert_eq!(json_of(&sandbox.run(&["compare", "a.png", "a.png", "--json"]), 0)["psnr_db"], Value::Null);

    // Without a limit, a difference is reported and is not a failure.
    let object = json_of(&sandbox.run(&["compare", "a.png", "other.png", "--json", "-o", "map.png"]), 0);
    let flip = |name: &str| object["flip"][name].as_f64().unwrap();
    assert!(0.0 < flip("mean") && flip("mean") < flip("covered") && flip("covered") < flip("max"), "{object}");
    let map = image::open(sandbox.path().join("map.png")).unwrap().into_rgb8();
    assert_eq!(map.dimensions(), (48, 32));
    let sum = |x, y| map.get_pixel(x, y).0.iter().map(|c| u32::from(*c)).sum::<u32>();
    assert!(sum(24, 16) > 3 * sum(0, 0), "the stripe must be brighter than empty areas: {} {}", sum(24, 16), sum(0, 0));
    // The map must show the same values: the mean of its colours rises with the error.
    let text = sandbox.run(&["compare", "a.png", "other.png"]);
    assert!(text.code == Some(0) && ["FLIP", "RMSE", "PSNR", "coverage"].iter().all(|w| text.stdout.contains(w)));
}

#[test]
fn each_compare_limit_sets_the_exit_code() {
    let sandbox = pictures();
    // The pixels are more transparent but not darker. Where the colour is black, only coverage differs.
    let faint = RgbaImage::from_fn(48, 32, |x, y| {
        let Rgba([r, g, b, a]) = *disc(0).get_pixel(x, y);
        Rgba([r, g, b, a / 2])
    });
    sandbox.write("faint.png", encoded(faint.into(), ImageFormat::Png));
    for (limit, held, broken) in [
        ("--max-flip", "0.5", "0.001"),
        ("--max-rmse", "0.5", "0.001"),
        ("--max-coverage", "0.5", "0.01"),
        ("--min-psnr", "3", "60"),
    ] {
        let args = |bound| ["compare", "a.png", "faint.png", limit, bound, "--json"];
        assert_eq!(json_of(&sandbox.run(&args(held)), 0)["different"], false, "{limit}");
        let object = json_of(&sandbox.run(&args(broken)), 7);
        assert_eq!((&object["different"], &object["limits"][0]["option"]), (&true.into(), &limit.into()));
        let run = sandbox.run(&args(broken)[..5]);
        assert!(run.code == Some(7) && run.stdout.contains(&format!("{limit} {broken}: DIFFERENT")), "{run:?}");
    }
}

#[test]
fn invalid_comparisons_are_refused() {
    let sandbox = pictures();
    let before = sandbox.files();
    for (args, code, words) in [
        (&["compare", "a.png"][..], 1, &["<B>"][..]),
        (&["compare", "a.png", "a.png", "--max-flip=-1"], 1, &["0 or more"]),
        (&["compare", "a.png", "a.png", "--max-flip=NaN"], 1, &["0 or more"]),
        (&["compare", "a.png", "a.png", "--over", "1,2"], 1, &["red,green,blue"]),
        (&["compare", "a.png", "a.png", "--pixels-per-degree", "0"], 1, &["from 1"]),
        (&["compare", "a.png", "none.png"], 2, &["none.png: cannot read"]),
        (&["compare", "a.png", "a.png", "-o", "none/d.png"], 2, &["none: cannot write into"]),
        (&["compare", "a.png", "no.png"], 3, &["no.png: byte 0: expected a PNG or EXR"]),
        (
            &["compare", "a.png", "small.png", "-o", "d.png"],
            3,
            &["small.png: size: 48x31", "expected 48x32, the size of a.png"],
        ),
    ] {
        let run = sandbox.run(args);
        assert_eq!(run.code, Some(code), "{args:?}: {run:?}");
        assert!(words.iter().all(|w| run.stderr.contains(w)), "{args:?}: {}", run.stderr);
        assert_eq!(sandbox.files(), before, "{args:?} left something behind");
    }
}
