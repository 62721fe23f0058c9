//! `pelage chart` through the real binary.
#![allow(clippy::unwrap_used, reason = "in tests a panic is the report")]

use pelage_tests::binary::{Run, Sandbox, workspace};
use pelage_tests::schema;
use serde_json::Value;

#[track_caller]
fn json_of(run: &Run) -> Value {
    assert_eq!(run.code, Some(0), "{run:?}");
    let value: Value = serde_json::from_str(&run.stdout).unwrap_or_else(|e| panic!("{e}: {run:?}"));
    let text = std::fs::read(workspace().join("bake/src/cli/schema/chart.json")).unwrap();
    schema::check(&serde_json::from_slice(&text).unwrap(), &value).unwrap();
    value
}

/// Fields of a CSV text, line by line.
fn csv(text: &str) -> Vec<Vec<String>> {
    let (mut rows, mut row, mut field, mut quoted) = (Vec::new(), Vec::new(), String::new(), false);
    let mut chars = text.chars().peekable();
    while let Some(c) = chars.next() {
        match c {
            '"' if quoted && chars.peek() == Some(&'"') => field.push(chars.next().unwrap()),
            '"' => quoted = !quoted,
            ',' if !quoted => row.push(std::mem::take(&mut field)),
            '\n' if !quoted => {
                row.push(std::mem::take(&mut field).trim_end_matches('\r').to_owned());
                rows.push(std::mem::take(&mut row));
            }
            _ => field.push(c),
        }
    }
    assert!(!quoted && field.is_empty() && row.is_empty(), "the table ends within a line");
    rows
}

/// A coarse torus as OBJ, with texture coordinates.
fn torus(sandbox: &Sandbox) {
    let (long, short) = (24, 10);
    let mut text = String::new();
    for i in 0..=long {
        for j in 0..=short {
            let (u, v) = (i as f32 / long as f32, j as f32 / short as f32);
            let (a, b) = ((u * std::f32::consts::TAU).sin_cos(), (v * std::f32::consts::TAU).sin_cos());
            let r = 1.0 + 0.4 * b.1;
            text += &format!("v {} {} {}\nvt {u} {v}\n", r * a.1, 0.4 * b.0, r * a.0);
        }
    }
    for i in 0..long {
        for j in 0..short {
            let at = |i: usize, j: usize| i * (short + 1) + j + 1;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            text += &format!("f {a}/{a} {b}/{b} {c}/{c} {d}/{d}\n");
        }
    }
    sandbox.write("my torus.obj", text);
}

/// Splits a command as a shell does that knows single quotes.
fn words(command: &str) -> Vec<String> {
    let (mut out, mut word, mut quoted) = (Vec::new(), String::new(), false);
    for c in command.chars() {
        match c {
            '\'' => quoted = !quoted,
            ' ' if !quoted => out.push(std::mem::take(&mut word)),
            _ => word.push(c),
        }
    }
    out.push(word);
    out
}

#[test]
fn the_surface_chart() {
    let sandbox = Sandbox::new();
    torus(&sandbox);
    let set = "surface.comb_smoothing=0.25";
    let run = sandbox.run(&["chart", "surface", "my torus.obj", "-o", "out", "--set", set, "--json"]);
    let object = json_of(&run);
    assert_eq!(sandbox.files(), ["my torus.obj", "out/", "out/surface.csv", "out/surface.svg"]);
    let rows = object["rows"].as_array().unwrap();
    assert!(rows.len() > 20);

    // The table holds the same.
    let table = csv(&std::fs::read_to_string(sandbox.path().join("out/surface.csv")).unwrap());
    assert_eq!(table.len(), rows.len() + 1);
    assert!(table.iter().all(|line| line.len() == table[0].len()));
    let column = |name: &str| table[0].iter().position(|c| c == name).unwrap_or_else(|| panic!("no column {name}"));
    for name in
        ["series", "adapter", "default", "on_front", "on_front_seconds", "command", "surface.patch_size", "seconds"]
    {
        column(name);
    }
    let figures = |name: &str| -> Vec<f64> {
        let c = column(name);
        table[1..].iter().map(|line| line[c].parse().unwrap()).collect()
    };
    let (seams, angles) = (figures("seam_length_ratio"), figures("angle_distortion"));
    assert!(figures("flipped_triangles").iter().all(|n| *n == 0.0));
    assert!(figures("seconds").iter().all(|s| *s > 0.0));
    // The front, found again: nothing on it is beaten, everything else is.
    let beaten = |i: usize| {
        (0..rows.len())
            .any(|j| seams[j] <= seams[i] && angles[j] <= angles[i] && (seams[j] < seams[i] || angles[j] < angles[i]))
    };
    for (i, row) in rows.iter().enumerate() {
        assert_eq!(row["on_front"].as_bool().unwrap(), !beaten(i), "{row}");
    }
    assert_eq!(rows.iter().filter(|r| r["default"] == true).count(), 1);
    // More seams, less distortion: that is what the chart is about.
    let (most, least) = (seams.iter().copied().fold(0.0, f64::max), seams.iter().copied().fold(f64::MAX, f64::min));
    assert!(most > 1.5 * least, "seams from {least} to {most}");

    let svg = std::fs::read_to_string(sandbox.path().join("out/surface.svg")).unwrap();
    assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"));
    for text in
        ["torus", "length of seams", "surface stage, seconds", "angle distortion", "patch size", "default", "front"]
    {
        assert!(svg.contains(text), "no {text:?} in the picture");
    }

    // A row's command gives the row's figures again.
    let row = rows.iter().find(|r| r["surface.patch_turn_deg"] == 10.0).unwrap();
    let command = row["command"].as_str().unwrap();
    assert!(command.starts_with("pelage bake 'my torus.obj'") && command.contains(set), "{command}");
    let baked = sandbox.run(&words(command)[1..]);
    let baked: Value = serde_json::from_str(&baked.stdout).unwrap_or_else(|e| panic!("{e}: {baked:?}"));
    for name in ["angle_distortion", "seam_length_ratio", "patches", "stretch_l2"] {
        assert_eq!(row[name].as_f64(), baked[name].as_f64(), "{name}");
    }
}

#[test]
fn the_stability_table() {
    let sandbox = Sandbox::new();
    let object = json_of(&sandbox.run(&["chart", "stability", "--json", "-o", "out"]));
    let rows = object["rows"].as_array().unwrap();
    assert!(rows.len() >= 10);
    for row in rows {
        assert_eq!(row["holds"], true, "{row}");
        let (safe, bound) = (row["safe"].as_f64().unwrap(), row["bound"].as_f64().unwrap());
        assert!(safe <= bound && row["naive"].as_f64().is_none_or(|naive| naive > bound), "{row}");
    }
    let table = csv(&std::fs::read_to_string(sandbox.path().join("out/stability.csv")).unwrap());
    assert_eq!(table.len(), rows.len() + 1);
    assert_eq!(sandbox.files(), ["out/", "out/stability.csv"]);
    let run = sandbox.run(&["chart", "stability"]);
    assert_eq!(run.code, Some(0), "{run:?}");
    for row in rows {
        assert!(run.stdout.contains(row["case"].as_str().unwrap()), "{row} is not in {}", run.stdout);
    }
    assert!(!run.stdout.contains("BROKEN"));
}

#[test]
fn what_cannot_be_charted() {
    let sandbox = Sandbox::new();
    torus(&sandbox);
    sandbox.write("a.pelage", b"PELAGE\0\0");
    let before = sandbox.files();
    for (args, code, words) in [
        (&["chart"][..], 1, &["TOPIC"][..]),
        (&["chart", "weather", "-o", "out"], 1, &["weather", "surface", "stability"]),
        (&["chart", "surface"], 1, &["-o DIR"]),
        (&["chart", "stability", "my torus.obj"], 1, &["neither model nor recipe"]),
        (&["chart", "surface", "no.glb", "-o", "out"], 2, &["no.glb: cannot read"]),
        (&["chart", "surface", "a.pelage", "-o", "out"], 3, &["a.pelage", "a pelage package"]),
        (&["chart", "surface", "my torus.obj", "-o", "a.pelage"], 2, &["a.pelage: cannot create"]),
        (&["chart", "surface", "-o", "out", "--recipe", "r.toml"], 1, &["--recipe needs a MODEL"]),
        (&["chart", "surface", "-o", "out", "--set", "surface.patch_sise=2"], 3, &["surface.patch_size"]),
    ] {
        let run = sandbox.run(args);
        assert_eq!(run.code, Some(code), "{args:?}: {run:?}");
        assert!(words.iter().all(|w| run.stderr.contains(w)), "{args:?}: {}", run.stderr);
        assert_eq!(sandbox.files(), before, "{args:?} left something behind");
    }
}
