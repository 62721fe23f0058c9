//! Topic `strands`: single strands beside layers, at sizes from a close-up to a few pixels, against the true picture.
//!
//! Each size is drawn in several ways with one sample a pixel and with four: what the runtime chooses, layers, and
//! strands of some numbers of pieces. Ways of a size and number of samples are timed in turns, so that what else the
//! machine does falls on all of them.

use super::{Cell, Panel};
use pelage_stage::{LookDetail, LookHair, LookStrandEdges, Viewpoint};
use pelage_tool::shell_judge::Measured;

/// A picture to draw: its size, of the recipe's `[judge]`, and how near.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    /// The word in the table.
    pub word: &'static str,
    /// What the recipe's width and height are multiplied by, and divided by.
    ratio: (u32, u32),
    /// What the angle of the view is divided by.
    nearer: f32,
}

impl Size {
    /// The close-up, then from the largest to the smallest, each half of the one before.
    pub const ALL: [Self; 6] = [
        Self { word: "close", ratio: (1, 1), nearer: 3.0 },
        Self { word: "double", ratio: (2, 1), nearer: 1.0 },
        Self { word: "whole", ratio: (1, 1), nearer: 1.0 },
        Self { word: "half", ratio: (1, 2), nearer: 1.0 },
        Self { word: "quarter", ratio: (1, 4), nearer: 1.0 },
        Self { word: "eighth", ratio: (1, 8), nearer: 1.0 },
    ];

    /// Width and height of the picture, pixels, at least 1, where the recipe has so many.
    pub fn pixels(self, (width, height): (u32, u32)) -> (u32, u32) {
        let (times, over) = self.ratio;
        let of = |pixels: u32| (pixels * times / over).max(1);
        (of(width), of(height))
    }

    /// The camera of the picture, where the whole of the model is seen from `camera`.
    pub fn camera(self, camera: Viewpoint) -> Viewpoint {
        Viewpoint { fov_deg: camera.fov_deg / self.nearer, ..camera }
    }
}

/// Samples a pixel.
pub const SAMPLES: [u32; 2] = [1, 4];

/// How hair is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// What is varied.
    pub series: String,
    /// Strands, layers, or what the runtime chooses.
    pub hair: LookHair,
    /// How pixels are made of strands.
    pub edges: LookStrandEdges,
    /// How much of the layers.
    pub detail: LookDetail,
    /// Most pieces of a strand; `None` as the runtime chooses.
    pub pieces: Option<u32>,
}

impl Way {
    /// All ways for strands of so many pieces, what the runtime chooses first: then layers, where there is a `coat`,
    /// strands of all pieces, half as many and so on; last with blended edges what the runtime chooses, all pieces and
    /// half as many.
    pub fn all(pieces: u32, coat: bool) -> Vec<Self> {
        let way = |series: &str, hair, detail| Self {
            series: series.to_owned(),
            hair,
            edges: LookStrandEdges::Samples,
            detail,
            pieces: None,
        };
        let mut all = vec![way("auto", LookHair::Auto, LookDetail::Auto)];
        if coat {
            all.push(way("layers, as the size asks for", LookHair::Shells, LookDetail::Auto));
            all.push(way("layers, all", LookHair::Shells, LookDetail::Full));
        }
        let strands = |pieces: u32| Self {
            pieces: Some(pieces),
            ..way(&format!("strands of {pieces} pieces"), LookHair::Strands, LookDetail::Auto)
        };
        let halved = std::iter::successors(Some(pieces), |p| p.is_multiple_of(2).then_some(p / 2));
        all.extend(halved.take_while(|p| *p > 1).take(if coat { 3 } else { 4 }).map(strands));
        let in_strands =
            all.iter().filter(|way| way.hair != LookHair::Shells && way.pieces.is_none_or(|p| 2 * p >= pieces));
        let blended = |way: &Self| Self {
            series: format!("{}, blended", way.series),
            edges: LookStrandEdges::Blended,
            ..way.clone()
        };
        let blended: Vec<_> = in_strands.map(blended).collect();
        [all, blended].concat()
    }

    /// Whether a package without strands is drawn so as well.
    pub fn needs_no_strands(&self) -> bool {
        self.hair == LookHair::Shells
    }
}

/// A row: a way of drawing a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Configuration {
    /// Index into [`Size::ALL`].
    pub size: usize,
    /// Samples a pixel.
    pub samples: u32,
    /// Index into the list of ways.
    pub way: usize,
}

impl Configuration {
    /// Whether it is what a user gets without asking.
    pub fn is_default(&self) -> bool {
        self.way == 0 && self.samples == SAMPLES[0]
    }
}

/// Every one of so many ways in every size, at each number of samples.
pub fn configurations(ways: usize) -> Vec<Configuration> {
    let groups = (0..Size::ALL.len()).flat_map(|size| SAMPLES.map(|samples| (size, samples)));
    groups.flat_map(|(size, samples)| (0..ways).map(move |way| Configuration { size, samples, way })).collect()
}

/// Columns of the chart.
///
/// * `size` of the picture, `whole` as in the recipe's `[judge]`, its `width` and `height`, pixels; `close` is `whole`
///   with a third of the angle.
/// * `samples` a pixel; `true_samples`, rays a pixel of the true picture; `strand_px`, mean width of the strands at the
///   median of the skin's distances.
/// * `layers`, `strands`, `pieces`: layers that are drawn, share of the strands, and pieces of each.
///   `strand_triangles`: of all strands that are drawn, seen or not. `triangles`: of the mesh.
/// * `flip`, `flip_covered`, `rmse`, `coverage_error` against the true picture; `fragments` where the adapter counts
///   them.
/// * `flicker`: mean change of grey, 0..=1, of the skin's points and of what stands on them, from one picture to the
///   next, while the camera turns a quarter of a degree and all else stands still; `true_flicker`: that of the true
///   pictures, whose hairs move before the skin as well.
/// * `frame_milliseconds`: a frame whose light and pose stand still. `anew_milliseconds`: the passes of one whose pose
///   and maps are made anew.
/// * `over_cheapest`: of what the runtime chooses without being asked for blended edges, the former over that of the
///   cheapest way of the same size and samples whose FLIP is at most [`AS_TRUE`] as large.
/// * `package_bytes`: of a package with strands, or without where none are drawn; `gpu_bytes`: model, copy, maps and
///   lists.
pub const COLUMNS: [&str; 24] = [
    "size",
    "width",
    "height",
    "samples",
    "true_samples",
    "strand_px",
    "layers",
    "strands",
    "pieces",
    "strand_triangles",
    "triangles",
    "flip",
    "flip_covered",
    "rmse",
    "coverage_error",
    "flicker",
    "true_flicker",
    "fragments",
    "frame_milliseconds",
    "anew_milliseconds",
    "over_cheapest",
    "package_bytes",
    "gpu_bytes",
    "timing",
];

/// Panels of the chart, one for each size.
pub fn panels() -> Vec<Panel> {
    let labels = [
        "mean FLIP, a third of the angle",
        "mean FLIP at twice the judge's size",
        "mean FLIP at the judge's size",
        "mean FLIP at half the judge's size",
        "mean FLIP at a quarter of the judge's size",
        "mean FLIP at an eighth of the judge's size",
    ];
    let panel = |(size, error_label): (Size, _)| Panel {
        cost: "frame_milliseconds",
        cost_label: "frame, milliseconds",
        error: "flip",
        error_label,
        only: Some(("size", size.word)),
    };
    Size::ALL.into_iter().zip(labels).map(panel).collect()
}

/// What was found of a way.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Found {
    /// Errors and costs.
    pub measured: Measured,
    /// A frame whose pose and maps are made anew.
    pub anew_ms: f64,
    /// Mean change of grey while the camera turns a little; `None` where no skin is seen.
    pub flicker: Option<f64>,
    /// Share of the strands that is drawn.
    pub strands: f32,
    /// Pieces of each.
    pub pieces: u32,
    /// Edges are blended, which only who asks for it gets.
    pub blended: bool,
}

/// What all ways of a size have in common.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seen {
    /// Width and height of the picture.
    pub pixels: (u32, u32),
    /// Rays a pixel of the true picture.
    pub true_samples: u32,
    /// Mean change of grey of the true picture while the camera turns a little; `None` where no skin is seen.
    pub true_flicker: Option<f64>,
    /// Mean width of the strands, pixels.
    pub strand_px: f64,
    /// Strands of the model.
    pub strands: usize,
}

/// How much larger the FLIP of a way may be that counts as true as another: less is within the noise of the true
/// picture.
pub const AS_TRUE: f64 = 1.02;

/// Cost of the first of some ways over that of the cheapest which is as true.
pub fn over_cheapest(ways: &[Found]) -> Option<f64> {
    let own = ways.first()?.measured;
    let as_true = ways.iter().filter(|way| !way.blended && way.measured.flip <= AS_TRUE * own.flip);
    let cheapest = as_true.map(|way| way.measured.frame_ms).fold(f64::INFINITY, f64::min);
    Some(own.frame_ms / cheapest).filter(|ratio| ratio.is_finite())
}

/// The cells of a row, in the order of [`COLUMNS`]. `ways`: what was found of all of its size and samples; `timing`:
/// where the milliseconds come from.
pub fn cells(configuration: &Configuration, seen: &Seen, ways: &[Found], timing: &str) -> Vec<Cell> {
    let number = |x: Option<f64>| x.map_or(Cell::Empty, Cell::Number);
    let Configuration { size, samples, way } = *configuration;
    let found = ways.get(way).copied().unwrap_or_default();
    let m = &found.measured;
    let drawn = f64::from(found.strands) * seen.strands as f64;
    vec![
        Cell::Text(Size::ALL[size].word.into()),
        Cell::Number(seen.pixels.0.into()),
        Cell::Number(seen.pixels.1.into()),
        Cell::Number(samples.into()),
        Cell::Number(seen.true_samples.into()),
        Cell::Number(seen.strand_px),
        Cell::Number(m.layers.into()),
        Cell::Number(found.strands.into()),
        Cell::Number(found.pieces.into()),
        Cell::Number((2.0 * drawn * f64::from(found.pieces)).round()),
        Cell::Number(m.triangles.into()),
        Cell::Number(m.flip),
        Cell::Number(m.flip_covered),
        Cell::Number(m.rmse),
        Cell::Number(m.coverage_error),
        number(found.flicker),
        number(seen.true_flicker),
        number(m.fragments.map(|n| n as f64)),
        Cell::Number(m.frame_ms),
        Cell::Number(found.anew_ms),
        number(over_cheapest(ways).filter(|_| way == 0)),
        Cell::Number(m.package_bytes as f64),
        Cell::Number(m.gpu_bytes as f64),
        Cell::Text(timing.into()),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_way_is_drawn_in_every_size() {
        let series = |pieces, coat| Way::all(pieces, coat).into_iter().map(|way| way.series).collect::<Vec<_>>();
        let strands = ["strands of 8 pieces", "strands of 4 pieces", "strands of 2 pieces"];
        let layers = ["auto", "layers, as the size asks for", "layers, all"];
        let blended = ["auto, blended", "strands of 8 pieces, blended", "strands of 4 pieces, blended"];
        assert_eq!(series(8, true), [layers, strands, blended].concat());
        let blended = ["auto, blended", "strands of 16 pieces, blended", "strands of 8 pieces, blended"];
        assert_eq!(series(16, false), [&["auto", "strands of 16 pieces"][..], &strands, &blended].concat());
        let all = ["auto", "strands of 6 pieces", "strands of 3 pieces"];
        assert_eq!(series(6, false), [all, all.map(|series| [series, ", blended"].concat().leak() as &str)].concat());
        let all = configurations(6);
        assert_eq!(all.len(), 6 * 2 * 6);
        for size in 0..Size::ALL.len() {
            let of: Vec<_> = all.iter().filter(|c| c.size == size).collect();
            assert_eq!(of.iter().filter(|c| c.is_default()).count(), 1);
            assert!((0..of.len()).all(|i| !of[i + 1..].contains(&of[i])));
        }
        let pixels = Size::ALL.map(|size| size.pixels((834, 424)));
        assert_eq!(pixels, [(834, 424), (1668, 848), (834, 424), (417, 212), (208, 106), (104, 53)]);
        assert_eq!(panels().len(), Size::ALL.len());
        let near = Size::ALL[0].camera(Viewpoint { eye: glam::Vec3::X, target: glam::Vec3::ZERO, fov_deg: 30.0 });
        assert_eq!((near.eye, near.fov_deg), (glam::Vec3::X, 10.0));
    }

    #[test]
    fn what_is_chosen_is_held_against_the_cheapest_that_is_as_true() {
        let way =
            |frame_ms, flip| Found { measured: Measured { frame_ms, flip, ..Measured::default() }, ..Found::default() };
        // The cheapest is not as true, the next is a little less true, and the last is truer and dearer.
        let blended = Found { blended: true, ..way(2.0, 0.0050) };
        let ways = [way(6.0, 0.0100), way(1.0, 0.0200), way(4.0, 0.0101), way(9.0, 0.0050), blended];
        assert_eq!(over_cheapest(&ways), Some(1.5));
        assert_eq!(over_cheapest(&ways[..2]), Some(1.0));
        assert_eq!(over_cheapest(&[]), None);
        let seen = Seen { pixels: (8, 4), strands: 100, ..Seen::default() };
        for way in 0..ways.len() {
            let cells = cells(&Configuration { size: 2, samples: 4, way }, &seen, &ways, "timestamp-query");
            assert_eq!(cells.len(), COLUMNS.len());
            let cell = |name| &cells[COLUMNS.iter().position(|column| *column == name).expect("a column")];
            assert_eq!((cell("size"), cell("samples")), (&Cell::Text("whole".into()), &Cell::Number(4.0)));
            assert_eq!(cell("over_cheapest").number(), (way == 0).then_some(1.5));
            assert_eq!(cell("flip").number(), Some(ways[way].measured.flip));
        }
        let four = [Found { strands: 0.5, pieces: 4, ..way(1.0, 1.0) }];
        let cells = cells(&Configuration { size: 0, samples: 1, way: 0 }, &seen, &four, "");
        let triangles = COLUMNS.iter().position(|column| *column == "strand_triangles").expect("a column");
        assert_eq!(cells[triangles], Cell::Number(400.0));
    }
}
