//! Speed against accuracy: tables of configurations, their Pareto front, and plots of both.
//!
//! A topic is a module that lists configurations ([`cost`], [`environment`], [`environment_fit`], [`multiple`],
//! [`scattering`], [`surface`], [`textures`], [`verlet`], `detail`, `ink`, `lighting`, `opacity_shadow`, `self_shadow`,
//! `soft_shadow`), and a command that measures them. All topics share the code for table, Pareto front, CSV and SVG.
//! Each row of figures includes the command that reproduces it.

mod axis;
pub mod cost;
pub mod detail;
pub mod environment;
pub mod environment_fit;
mod errors;
mod hair_texels;
pub mod ink;
mod labels;
pub mod light_maps;
pub mod lighting;
pub mod multiple;
pub mod opacity_shadow;
pub mod scattering;
pub mod self_shadow;
pub mod self_shadow_forms;
pub mod shells;
pub mod skies;
pub mod soft_shadow;
pub mod strands;
pub mod surface;
mod svg;
pub mod textures;
pub mod verlet;

pub use errors::{Errors, OFF};
pub use svg::svg;

/// Value of a configuration in one column.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Number in the unit of its column.
    Number(f64),
    /// Word.
    Text(String),
    /// Not applicable.
    Empty,
}

impl Cell {
    /// Returns the number, if there is one and it is finite.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(x) if x.is_finite() => Some(*x),
            _ => None,
        }
    }

    /// Formats the cell for CSV and JSON. Numbers have six significant digits, more than any measurement here is
    /// accurate to.
    pub fn text(&self) -> String {
        match self {
            Self::Number(x) => format!("{x:.5e}").parse::<f64>().unwrap_or(*x).to_string(),
            Self::Text(text) => text.clone(),
            Self::Empty => String::new(),
        }
    }
}

/// Configuration and its results.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Name of the varied setting; rows of one series share a colour.
    pub series: String,
    /// Short value of the varied setting, shown beside its mark in the plot; empty for none.
    pub label: String,
    /// Cells, one per [`Chart::columns`].
    pub cells: Vec<Cell>,
    /// Whether this is the default configuration.
    pub default: bool,
    /// Command that reproduces the row.
    pub command: String,
}

/// Plot of two columns against each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Panel {
    /// Column of the cost, on the horizontal axis.
    pub cost: &'static str,
    /// Label of the cost axis, with unit.
    pub cost_label: &'static str,
    /// Column of the error, on the vertical axis.
    pub error: &'static str,
    /// Label of the error axis, with unit.
    pub error_label: &'static str,
    /// Column and value that select the rows to draw, if each panel shows only some of the chart's rows. `None` draws
    /// all rows.
    pub only: Option<(&'static str, &'static str)>,
}

/// Measured topic.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Word after `pelage chart`.
    pub topic: &'static str,
    /// Title of the chart: what was measured, and on which glTF model.
    pub title: String,
    /// Adapter or device of the measurements.
    pub adapter: String,
    /// Names of the parameters, errors and costs.
    pub columns: Vec<&'static str>,
    /// Configurations, in the order of measurement.
    pub rows: Vec<Row>,
    /// Panels to draw, two per row of the picture; the first one determines the column `on_front`.
    pub panels: Vec<Panel>,
}

impl Chart {
    /// Returns cost and error of each row in `panel`; `None` if either is missing or the panel does not draw the row.
    pub fn points(&self, panel: &Panel) -> Vec<Option<(f64, f64)>> {
        let column = |name: &str| self.columns.iter().position(|c| *c == name);
        let (cost, error) = (column(panel.cost), column(panel.error));
        let of = |row: &Row, column: Option<usize>| column.and_then(|c| row.cells.get(c)).and_then(Cell::number);
        let drawn = |row: &Row| {
            panel.only.is_none_or(|(name, word)| {
                column(name).and_then(|c| row.cells.get(c)).is_some_and(|cell| cell.text() == word)
            })
        };
        let point = |row: &Row| Some((of(row, cost)?, of(row, error)?)).filter(|_| drawn(row));
        self.rows.iter().map(point).collect()
    }

    /// Returns whether each row is on the Pareto front of `panel`.
    pub fn on_front(&self, panel: &Panel) -> Vec<bool> {
        front(&self.points(panel))
    }

    /// Returns the table as CSV (RFC 4180): series, all columns, `adapter`, `default`, the columns of [`Self::fronts`],
    /// and `command`.
    pub fn csv(&self) -> String {
        let mut header: Vec<String> = vec!["series".into()];
        header.extend(self.columns.iter().map(ToString::to_string));
        header.extend(["adapter".into(), "default".into()]);
        let fronts = self.fronts();
        header.extend(fronts.iter().map(|(name, _)| name.clone()));
        header.push("command".into());
        let mut table = vec![header];
        for (i, row) in self.rows.iter().enumerate() {
            let mut fields = vec![row.series.clone()];
            fields.extend(row.cells.iter().map(Cell::text));
            fields.extend([self.adapter.clone(), u8::from(row.default).to_string()]);
            fields.extend(fronts.iter().map(|(_, front)| u8::from(front[i]).to_string()));
            fields.push(row.command.clone());
            table.push(fields);
        }
        csv(table)
    }

    /// Returns the columns that mark rows on a Pareto front, each with its name. There is one per panel. Panels that
    /// show the same cost and error for different rows share one.
    pub fn fronts(&self) -> Vec<(String, Vec<bool>)> {
        let mut found: Vec<(&Panel, String, Vec<bool>)> = Vec::new();
        for panel in &self.panels {
            let front = self.on_front(panel);
            let parted = |other: &Panel| panel.only.is_some() && (other.cost, other.error) == (panel.cost, panel.error);
            let name = if found.is_empty() { "on_front".into() } else { format!("on_front_{}", panel.cost) };
            match found.iter_mut().find(|(other, ..)| parted(other)) {
                Some((.., known)) => known.iter_mut().zip(front).for_each(|(known, on)| *known |= on),
                None => found.push((panel, name, front)),
            }
        }
        found.into_iter().map(|(_, name, front)| (name, front)).collect()
    }
}

/// Returns which rows are on the Pareto front. A row is on it unless another row is at least as good in cost and error,
/// and better in one of them. Rows without figures are never on it.
pub fn front(points: &[Option<(f64, f64)>]) -> Vec<bool> {
    let beats = |(c, e): (f64, f64), (cost, error): (f64, f64)| c <= cost && e <= error && (c < cost || e < error);
    let unbeaten = |p: &Option<(f64, f64)>| p.is_some_and(|p| !points.iter().flatten().any(|q| beats(*q, p)));
    points.iter().map(unbeaten).collect()
}

/// Formats lines of fields as CSV (RFC 4180).
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
    fn pareto_front_contains_the_undominated_points() {
        let points = [(1., 9.), (2., 5.), (2., 6.), (3., 5.), (4., 1.), (5., 1.), (1., 9.)].map(Some);
        assert_eq!(front(&points), [true, true, false, false, true, false, true]);
        assert_eq!(front(&[None, Some((1., 1.))]), [false, true]);
        assert!(front(&[]).is_empty());
    }

    #[test]
    fn panels_with_disjoint_rows_share_a_front_column() {
        let row = |size: &str, cost: f64, error: f64| Row {
            series: String::new(),
            label: String::new(),
            cells: vec![Cell::Text(size.into()), Cell::Number(cost), Cell::Number(error)],
            default: false,
            command: String::new(),
        };
        let panel = |size| Panel { cost: "c", cost_label: "", error: "e", error_label: "", only: Some(("size", size)) };
        let chart = Chart {
            topic: "t",
            title: String::new(),
            adapter: String::new(),
            columns: vec!["size", "c", "e"],
            // The row of size `small` is cheaper and more accurate than all rows of size `large`. It cannot replace
            // them in the panel for large pictures.
            rows: vec![row("large", 3.0, 3.0), row("large", 4.0, 4.0), row("small", 1.0, 1.0)],
            panels: vec![panel("large"), panel("small"), Panel { only: None, ..panel("") }],
        };
        assert_eq!(chart.points(&panel("large")), [Some((3.0, 3.0)), Some((4.0, 4.0)), None]);
        let fronts = [("on_front", [true, false, true]), ("on_front_c", [false, false, true])]
            .map(|(n, on)| (n.into(), on.into()));
        assert_eq!(chart.fronts(), fronts);
    }

    #[test]
    fn csv_cells_are_quoted_and_rounded() {
        let panel = Panel { cost: "s", cost_label: "s", error: "e", error_label: "e", only: None };
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
            "series,s,e,k,adapter,default,on_front,on_front_e,command\r\n\
             \"a, b\",0.333333,NaN,,cpu,1,0,0,\"x \"\"y\"\"\"\r\n"
        );
    }
}
