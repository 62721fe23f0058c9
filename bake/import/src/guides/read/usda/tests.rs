use crate::guides::Guides;
use crate::guides::read::GuideFormat;
use glam::Vec3;

fn read(text: &str) -> Guides {
    GuideFormat::Usda.read("a.usda", text.as_bytes()).unwrap()
}

/// Returns a layer in metres, y up, with these prims.
fn layer(prims: &str) -> String {
    format!("#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n{prims}")
}

/// Returns a prim with one curve along x, from 0 to 3.
fn curve(properties: &str) -> String {
    format!(
        "def BasisCurves \"hair\"\n{{\n    int[] curveVertexCounts = [4]\n    point3f[] points = [(0, 0, 0), (1, 0, \
         0), (2, 0, 0), (3, 0, 0)]\n{properties}\n}}\n"
    )
}

const LINEAR: &str = "uniform token type = \"linear\"";

#[test]
fn unit_and_axis_of_the_layer_apply() {
    let linear = curve(LINEAR);
    let z_up = linear.replace("(3, 0, 0)", "(3, 5, 7)");
    let guides = read(&format!("#usda 1.0\n(upAxis = \"Z\"; metersPerUnit = 0.5)\n{z_up}"));
    assert_eq!((guides.strand(0)[3], guides.warnings.len()), (Vec3::new(1.5, 3.5, -2.5), 0));
    let guides = read(&format!("#usda 1.0\n{linear}"));
    assert_eq!(guides.strand(0)[3], Vec3::X * 3.0 * 0.01, "centimetres are the default of USD");
    assert!(guides.warnings[0].contains("no metersPerUnit"), "{:?}", guides.warnings);
}

#[test]
fn transforms_of_all_parents_apply() {
    let within = |properties: &str, inner: &str| {
        layer(&format!("def Xform \"a\" {{\n{properties}\ndef Xform \"b\" {{\n{inner}\n{}}}\n}}", curve(LINEAR)))
    };
    let tip = |properties: &str, inner: &str| read(&within(properties, inner)).strand(0)[3];
    let near = |found: Vec3, expected: [f32; 3]| {
        assert!(found.distance(expected.into()) < 1e-5, "{found}, expected {expected:?}");
    };
    let moved = "double3 xformOp:translate = (0, 10, 0)\nuniform token[] xformOpOrder = [\"xformOp:translate\"]";
    near(tip(moved, ""), [3.0, 10.0, 0.0]);
    // The rotation about x comes first, then those about y and z: x becomes -z, and stays there.
    let turned = "float3 xformOp:rotateXYZ = (90, 90, 0); float3 xformOp:scale = (2, 2, 2)\n\
                  uniform token[] xformOpOrder = [\"xformOp:rotateXYZ\", \"xformOp:scale\"]";
    near(tip(moved, turned), [0.0, 10.0, -6.0]);
    near(tip(turned, moved), [20.0, 0.0, -6.0]);
    let matrix = "matrix4d xformOp:transform = ( (0, 1, 0, 0), (-1, 0, 0, 0), (0, 0, 1, 0), (7, 0, 0, 1) )\n\
                  uniform token[] xformOpOrder = [\"xformOp:transform\"]";
    near(tip(matrix, ""), [7.0, 3.0, 0.0]);
    let pivot = "quatf xformOp:orient = (0.70710678, 0, 0, 0.70710678)\nfloat3 xformOp:translate:pivot = (3, 0, 0)\n\
                 uniform token[] xformOpOrder = [\"xformOp:translate:pivot\", \"xformOp:orient\", \
                 \"!invert!xformOp:translate:pivot\"]";
    near(tip(pivot, ""), [3.0, 0.0, 0.0]);
    let reset = moved.replace("[\"xform", "[\"!resetXformStack!\", \"xform").replace("10", "2");
    near(tip(moved, &reset), [3.0, 2.0, 0.0]);
    let animated = moved.replace(" = (0, 10, 0)", ".timeSamples = {\n1: (0, 4, 0),\n2 : (0, 5, 0),\n}");
    near(tip(&animated, ""), [3.0, 4.0, 0.0]);
    near(tip("double3 xformOp:translate = (0, 10, 0)", ""), [3.0, 0.0, 0.0]);
    // Properties may follow the children.
    let late = layer(&format!("def Xform \"a\" {{\n{}\n{moved}\n}}", curve(LINEAR)));
    near(read(&late).strand(0)[3], [3.0, 10.0, 0.0]);
}

#[test]
fn cubic_curves_are_evaluated() {
    let of = |properties: &str, points: &str, count: usize| {
        let text = format!(
            "def BasisCurves \"hair\" {{\nint[] curveVertexCounts = [{count}]\npoint3f[] points = {points}\n\
             {properties}}}"
        );
        read(&layer(&text)).strand(0).to_vec()
    };
    // Basis and type have their defaults: cubic Bézier.
    let arc = of("", "[(0, 0, 0), (0, 3, 0), (3, 3, 0), (3, 0, 0)]", 4);
    assert_eq!(
        arc,
        [[0.0, 0.0], [0.46875, 1.6875], [1.5, 2.25], [2.53125, 1.6875], [3.0, 0.0]]
            .map(|[x, y]| { Vec3::new(x, y, 0.0) })
    );
    let line = "[(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)]";
    let ends = |properties: &str| {
        let points = of(properties, line, 4);
        (points.len(), points[0].x, points[points.len() - 1].x)
    };
    let basis =
        |basis: &str, wrap: &str| format!("uniform token basis = \"{basis}\"\nuniform token wrap = \"{wrap}\"\n");
    assert_eq!(ends(&basis("bspline", "nonperiodic")), (5, 1.0, 2.0));
    assert_eq!(ends(&basis("catmullRom", "nonperiodic")), (5, 1.0, 2.0));
    for name in ["bspline", "catmullRom"] {
        let (count, root, tip) = ends(&basis(name, "pinned"));
        assert!(count == 13 && root.abs() < 1e-6 && (tip - 3.0).abs() < 1e-6, "{name}: {count}, {root}..{tip}");
    }
    // Four points are no whole number of segments of two Bézier curves.
    let guides = read(&layer(&curve("").replace("[4]", "[2, 2]")));
    assert_eq!((guides.len(), guides.strand(1)), (2, &[Vec3::X * 2.0, Vec3::X * 3.0][..]));
    assert!(guides.warnings[0].contains("2 curves have numbers of points that do not suit"), "{:?}", guides.warnings);
}

#[test]
fn widths_are_spread_over_the_points() {
    let radii = |widths: &str| read(&layer(&curve(&format!("{LINEAR}\nfloat[] widths = {widths}")))).radii;
    assert_eq!(radii("[2]"), [1.0; 4]);
    assert_eq!(radii("[8, 6, 4, 2] (\n interpolation = \"vertex\"\n)"), [4.0, 3.0, 2.0, 1.0]);
    assert!(radii("[1, 2]").is_empty() && radii("[1, 2, 3, nan]").is_empty());
    let cubic = read(&layer(&curve(
        "float[] widths = [2, 4] (interpolation = \"varying\")\ncolor3f[] \
                                    primvars:displayColor = [(0.5, 1, 0)]",
    )));
    assert_eq!((cubic.radii, cubic.colors), (vec![1.0, 1.25, 1.5, 1.75, 2.0], vec![Vec3::new(0.5, 1.0, 0.0); 5]));
}

#[test]
fn files_of_other_programs_are_read() {
    // The notation of Blender, with everything that hair does not need.
    let text = r#"#usda 1.0
(
    defaultPrim = "root"
    doc = """Blender v4.2 "quoted"
{ not a prim"""
    metersPerUnit = 1
    upAxis = "Y"
)

def Xform "root" (
    customData = {
        dictionary Blender = {
            bool generated = 1
        }
    }
)
{
    /* a comment with a } */
    def Xform "Hair"
    {
        custom string userProperties:blender:object_name = "Hair; {x}"
        token visibility.timeSamples = { 1: "inherited" }

        def BasisCurves "Curves" (
            active = true
            prepend apiSchemas = ["MaterialBindingAPI"]
        )
        {
            uniform token basis = "catmullRom"
            int[] curveVertexCounts = [2, 3]
            float3[] extent = [(-1, 0, 0), (1, 1, 0)]
            rel material:binding = </root/_materials/Hair>
            point3f[] points.timeSamples = {
                1: [(0, 0, 0), (0, 1, 0), (1, 0, 0), (1, 1, 0), (1, 1, 1)],
                2: [(0, 0, 0), (0, 9, 0), (1, 0, 0), (1, 9, 0), (1, 9, 1)],
            }
            uniform token type = "linear"
            float[] widths = [0.02, 0.01, 0.02, 0.02, 0.01] (
                interpolation = "vertex"
            )
            uniform token wrap = "pinned"
        }
        def BasisCurves "Off" { token visibility = "invisible"; int[] curveVertexCounts = [2] }
    }
    def Mesh "Body" { point3f[] points = [(0, 0, 0)]; token outputs:surface.connect = </a.b> }
    over "Body" { def BasisCurves "Undefined" { } }
    def Scope "_materials"
    {
        def Material "Hair" { asset inputs:file = @./a{b.png@ ( colorSpace = "raw" ) }
    }
}
"#;
    let guides = read(text);
    assert_eq!((guides.len(), guides.strand(1)), (2, &[Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::ONE][..]));
    assert_eq!(guides.radii, [0.01, 0.005, 0.01, 0.01, 0.005]);
    assert_eq!(guides.warnings, ["2 prims with curves are invisible, inactive or not defined, and left out"]);
}

#[test]
fn single_bad_curves_are_left_out() {
    let points: Vec<String> = (0..9).map(|i| format!("({i}, 0, 0), ({i}, 1, 0), ({i}, 2, 0)")).collect();
    let all = layer(&format!(
        "def BasisCurves \"hair\" {{\n{LINEAR}\nint[] curveVertexCounts = [{}]\npoint3f[] points = [{}]\n}}",
        ["3"; 9].join(", "),
        points.join(", ")
    ));
    let broken = all.replace("(3, 1, 0)", "(nan, 1, 0)").replace("(5, 2, 0)", "(5, -inf, 0)");
    let guides = read(&broken);
    assert_eq!((guides.len(), guides.left_out.not_finite), (7, 2));
}

#[test]
fn errors_of_damaged_layers_name_the_line() {
    let refused = |text: &str, expected: &str| {
        let error = GuideFormat::Usda.read("a.usda", text.as_bytes()).expect_err(expected).to_string();
        assert!(error.starts_with("a.usda: ") && error.contains(expected), "expected {expected:?} in: {error}");
    };
    let good = layer(&curve(LINEAR));
    refused("PXR-USDC\0\0", "byte 0: binary USD, expected USD as text");
    refused("", "line 1: \"\", expected \"#usda 1.0\"");
    refused(&layer("def Mesh \"a\" { }"), "whole file: the file has no strands, expected a visible prim of type Bas");
    refused(
        &layer("def \"a\" ( references = @b.usda@ ) { }"),
        "1 references to other prims or files, or sets of variants, are not read",
    );
    refused(&good.replace("[4]", "[5]"), "prim \"hair\": 4 points, expected 5, the sum of curveVertexCounts");
    refused(&good.replace("[4]", "[-4]"), "line 8: found \"-4\", expected a number");
    refused(&good.replace("(2, 0, 0)", "(2, 0)"), "line 9: found 2 numbers in brackets, expected 3");
    refused(&good.replace("(2, 0, 0)", "(2, 0, zero)"), "line 9: found \"zero\", expected a number");
    refused(&good.replace("\"linear\"", "\"linear"), "found no end of what begins here, expected \"");
    refused(&good[..good.len() - 3], "the file ends within prim \"hair\"");
    refused(&good.replace("(3, 0, 0)]", "(3, 0, 0)"), "line 10: found \"uniform\", expected a number");
    refused(&format!("{good}}}"), "line 12: found '}', expected a prim or a property");
    refused(&layer(&"def Xform \"a\" {\n".repeat(300)), "line 262: prims are nested deeper than 256 levels");
    refused(
        &layer(&format!("def Mesh \"a\" {{ int[] b = {}", "[".repeat(1 << 20))),
        "the file ends within 1048576 open",
    );
    refused(
        &layer("def Xform \"a\" { double xformOp:scale = [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0] }"),
        "at most 16",
    );
    // Truncated files and changed characters must not cause a panic; errors are allowed.
    let bytes = good.as_bytes();
    (0..bytes.len()).for_each(|length| drop(GuideFormat::Usda.read("a", &bytes[..length])));
    for (at, mark) in (0..bytes.len()).flat_map(|at| b"({[\"]})=\\<\n-".iter().map(move |mark| (at, *mark))) {
        let mut changed = bytes.to_vec();
        changed[at] = mark;
        drop(GuideFormat::Usda.read("a", &changed));
    }
}
