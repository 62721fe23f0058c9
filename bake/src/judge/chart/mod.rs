//! Speed against accuracy: tables of configurations, their front, and pictures of both.
//!
//! A topic is a module that lists configurations ([`surface`], [`textures`], `ink`, `lighting`, `self_shadow`, `soft_shadow`) and a command that measures them; table, front, CSV and SVG are the same for all.
//! A chart's figures come with the command that reproduces each, so that nobody has to believe it.

mod axis;
mod errors;
#[cfg(feature = "preview")]
mod hair_texels;
#[cfg(feature = "preview")]
pub mod ink;
mod labels;
#[cfg(feature = "preview")]
pub mod light_maps;
#[cfg(feature = "preview")]
pub mod lighting;
#[cfg(feature = "preview")]
pub mod self_shadow;
#[cfg(feature = "preview")]
pub mod self_shadow_forms;
pub mod shells;
#[cfg(feature = "preview")]
pub mod soft_shadow;
pub mod surface;
mod svg;
pub mod textures;

pub use errors::{Errors, OFF};
pub use svg::svg;

/// A figure of a configuration.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A number in the unit of its column.
    Number(f64),
    /// A word.
    Text(String),
    /// Does not apply.
    Empty,
}

impl Cell {
    /// The number, if it is one and finite.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(x) if x.is_finite() => Some(*x),
            _ => None,
        }
    }

    /// For CSV and JSON: numbers with six digits that count, which is more than any measurement here is good for.
    pub fn text(&self) -> String {
        match self {
            Self::Number(x) => format!("{x:.5e}").parse::<f64>().unwrap_or(*x).to_string(),
            Self::Text(text) => text.clone(),
            Self::Empty => String::new(),
        }
    }
}

/// One configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What is varied; rows of one series share a colour.
    pub series: String,
    /// The value of what is varied, short, to stand beside the mark; empty for none.
    pub label: String,
    /// One per [`Chart::columns`].
    pub cells: Vec<Cell>,
    /// Whether it is what a user gets without asking.
    pub default: bool,
    /// The command that reproduces it.
    pub command: String,
}

/// Two columns drawn against each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Panel {
    /// Column of the cost, drawn across.
    pub cost: &'static str,
    /// Label of that axis, with unit.
    pub cost_label: &'static str,
    /// Column of the error, drawn upwards.
    pub error: &'static str,
    /// Label of that axis, with unit.
    pub error_label: &'static str,
}

/// A topic, measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// The word after `pelage chart`.
    pub topic: &'static str,
    /// What is seen, and of which model.
    pub title: String,
    /// What it was measured on.
    pub adapter: String,
    /// Names of the knobs, errors and costs.
    pub columns: Vec<&'static str>,
    /// The configurations, in the order of measuring.
    pub rows: Vec<Row>,
    /// What to draw, two panels in a row; the first decides `on_front`.
    pub panels: Vec<Panel>,
}

impl Chart {
    /// Cost and error of each row in `panel`; `None` where either is missing.
    pub fn points(&self, panel: &Panel) -> Vec<Option<(f64, f64)>> {
        let column = |name: &str| self.columns.iter().position(|c| *c == name);
        let (cost, error) = (column(panel.cost), column(panel.error));
        let of = |row: &Row, column: Option<usize>| column.and_then(|c| row.cells.get(c)).and_then(Cell::number);
        self.rows.iter().map(|row| Some((of(row, cost)?, of(row, error)?))).collect()
    }

    /// Whether each row is on the front of `panel`.
    pub fn on_front(&self, panel: &Panel) -> Vec<bool> {
        front(&self.points(panel))
    }

    /// The table as CSV (RFC 4180): series, all columns, `adapter`, `default`, `on_front` (of the first panel; one more column
    /// for each further one), `command`.
    pub fn csv(&self) -> String {
        let mut header: Vec<String> = vec!["series".into()];
        header.extend(self.columns.iter().map(ToString::to_string));
        header.extend(["adapter".into(), "default".into()]);
        header.extend(self.front_columns());
        header.push("command".into());
        let mut table = vec![header];
        let fronts: Vec<Vec<bool>> = self.panels.iter().map(|p| self.on_front(p)).collect();
        for (i, row) in self.rows.iter().enumerate() {
            let mut fields = vec![row.series.clone()];
            fields.extend(row.cells.iter().map(Cell::text));
            fields.extend([self.adapter.clone(), u8::from(row.default).to_string()]);
            fields.extend(fronts.iter().map(|front| u8::from(front[i]).to_string()));
            fields.push(row.command.clone());
            table.push(fields);
        }
        csv(table)
    }

    /// Names of the columns that say what is on a front.
    pub fn front_columns(&self) -> impl Iterator<Item = String> {
        let name =
            |(i, panel): (usize, &Panel)| if i == 0 { "on_front".into() } else { format!("on_front_{}", panel.cost) };
        self.panels.iter().enumerate().map(name)
    }
}

/// The rows that no other beats: none is at most as costly and at most as wrong, and better in one of the two. Rows without
/// figures are never on it.
pub fn front(points: &[Option<(f64, f64)>]) -> Vec<bool> {
    let beats = |(c, e): (f64, f64), (cost, error): (f64, f64)| c <= cost && e <= error && (c < cost || e < error);
    let unbeaten = |p: &Option<(f64, f64)>| p.is_some_and(|p| !points.iter().flatten().any(|q| beats(*q, p)));
    points.iter().map(unbeaten).collect()
}

/// Lines of fields as CSV (RFC 4180).
pub fn csv(table: impl IntoIterator<Item = Vec<String>>) -> String {
    let quote = |f: &String| {
        if f.contains([',', '"', '\n', '\r']) { format!("\"{}\"", f.replace('"', "\"\"")) } else { f.clone() }
    };
    table.into_iter().map(|fields| fields.iter().map(quote).collect::<Vec<_>>().join(",") + "\r\n").collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points = [(1., 9.), (2., 5.), (2., 6.), (3., 5.), (4., 1.), (5., 1.), (1., 9.)].map(Some);
        assert_eq!(front(&points), [true, true, false, false, true, false, true]);
        assert_eq!(front(&[None, Some((1., 1.))]), [false, true]);
        assert!(front(&[]).is_empty());
    }

    #[test]
    fn csv_quotes_and_rounds() {
        let panel = Panel { cost: "s", cost_label: "s", error: "e", error_label: "e" };
        let cells = vec![Cell::Number(1.0 / 3.0), Cell::Number(f64::NAN), Cell::Empty];
        let row = Row { series: "a, b".into(), label: String::new(), cells, default: true, command: "x \"y\"".into() };
        let chart = Chart {
            topic: "t",
            title: String::new(),
            adapter: "cpu".into(),
            columns: vec!["s", "e", "k"],
            rows: vec![row],
            panels: vec![panel, Panel { cost: "e", ..panel }],
        };
        assert_eq!(
            chart.csv(),
            "series,s,e,k,adapter,default,on_front,on_front_e,command\r\n\"a, b\",0.333333,NaN,,cpu,1,0,0,\"x \"\"y\"\"\"\r\n"
        );
    }
}
