//! Charts of error over cost on logarithmic axes, as SVG and as PNG.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::output::{HeaderValue, Picture};

use super::canvas::{Brush, Canvas};
use super::decades::Decades;
use super::error::StudyError;

/// A value with the ends of its error bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Value {
    pub at: f64,
    pub ends: [f64; 2],
}

pub(super) struct Series {
    /// Its colour and its mark: the place in [`Chart::names`].
    pub name: usize,
    /// (x, y); those that are not above 0 are left out.
    pub points: Vec<(Value, Value)>,
}

pub(super) struct Panel {
    pub title: String,
    pub x_name: &'static str,
    pub y_name: &'static str,
    pub series: Vec<Series>,
    /// Below this the reference's own error rules.
    pub floor: Option<f64>,
    /// From the first point on, what grows as x does.
    pub linear: bool,
    /// Lines of its own legend, with the places of the marks that they explain.
    pub legend: Vec<(usize, String)>,
    /// Joins the points that no other beats in both directions, instead of those of a series.
    pub front: bool,
}

pub(super) struct Chart {
    pub title: String,
    pub columns: usize,
    /// The legend of all panels; none where each has its own.
    pub names: Vec<String>,
    pub panels: Vec<Panel>,
}

const PANEL: [u32; 2] = [480, 380];
const TITLE: u32 = 44;
/// Pixels between the rows of the legend, and of a letter of the widest font.
const LEGEND_ROW: i32 = 24;
const LETTER: usize = 12;
/// The same within a panel.
const PANEL_ROW: i32 = 20;
/// Room for growth that there always is: what hardly grows shall not look steep.
const LEAST_GROWTH: f64 = 10.0;
/// Radius of a mark.
const MARK: i32 = 5;
const GREY: RGBColor = RGBColor(130, 130, 130);
/// Colours that stay apart for colour-blind readers: Okabe & Ito 2008, without the yellow.
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(0, 0, 0),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
];

impl Value {
    pub(super) fn exact(at: f64) -> Self {
        Self { at, ends: [at; 2] }
    }

    /// The mean of some values, with the least and the greatest as its ends.
    pub(super) fn mean_of(values: &[f64]) -> Self {
        let ends = values.iter().fold([f64::INFINITY, 0.0], |[a, b]: [f64; 2], &v| [a.min(v), b.max(v)]);
        Self { at: values.iter().sum::<f64>() / values.len() as f64, ends }
    }
}

impl Chart {
    fn size(&self) -> (u32, u32) {
        let rows = self.panels.len().div_ceil(self.columns) as u32;
        (self.columns as u32 * PANEL[0] + self.legend_width(), TITLE + rows * PANEL[1])
    }

    fn legend_width(&self) -> u32 {
        if self.names.is_empty() {
            return 0;
        }
        let longest = self.names.iter().map(|name| name.chars().count()).max().unwrap_or(0);
        (longest * LETTER) as u32 + 60
    }

    /// # Errors
    /// What the drawing library says.
    pub(super) fn svg(&self) -> Result<String, StudyError> {
        let mut svg = String::new();
        self.draw(SVGBackend::with_string(&mut svg, self.size()))?;
        Ok(svg)
    }

    /// # Errors
    /// What the drawing library says.
    pub(super) fn png(&self) -> Result<Picture, StudyError> {
        let (width, height) = self.size();
        let mut canvas = Canvas::new([width as usize, height as usize]);
        self.draw(Brush(&mut canvas))?;
        Ok(canvas.into_picture(vec![("chart".to_owned(), HeaderValue::Text(self.title.clone()))]))
    }

    fn draw<DB: DrawingBackend>(&self, backend: DB) -> Result<(), StudyError> {
        let paper = backend.into_drawing_area();
        paper.fill(&WHITE).map_err(StudyError::drawing)?;
        let (head, body) = paper.split_vertically(TITLE);
        head.draw(&Text::new(self.title.as_str(), (16, 14), ("sans-serif", 18))).map_err(StudyError::drawing)?;
        let (grid, margin) = body.split_horizontally(self.columns as u32 * PANEL[0]);
        let rows = self.panels.len().div_ceil(self.columns);
        for (area, panel) in grid.split_evenly((rows, self.columns)).iter().zip(&self.panels) {
            panel.draw(area)?;
        }
        for (row, name) in self.names.iter().enumerate() {
            let y = 40 + LEGEND_ROW * row as i32;
            margin.draw(&Circle::new((20, y), MARK, mark(row))).map_err(StudyError::drawing)?;
            let style = TextStyle::from(("sans-serif", 15)).pos(Pos::new(HPos::Left, VPos::Center));
            margin.draw(&Text::new(name.as_str(), (36, y), style)).map_err(StudyError::drawing)?;
        }
        paper.present().map_err(StudyError::drawing)
    }
}

impl Panel {
    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), StudyError> {
        let points = || self.series.iter().flat_map(|series| &series.points).filter(is_shown);
        let xs = Decades::around(points().map(|(x, _)| x.at));
        let first = points().map(|(x, y)| (x.at, y.at)).min_by(|a, b| a.0.total_cmp(&b.0)).filter(|_| self.linear);
        let least = first.map(|(_, y)| LEAST_GROWTH * y);
        let ys = Decades::around(points().map(|(_, y)| y.at).chain(self.floor).chain(least));
        let ([left, right], [_, top]) = (xs.ends(), ys.ends());
        area.draw(&Text::new(self.title.as_str(), (112, 6), ("sans-serif", 15))).map_err(StudyError::drawing)?;
        for (row, (name, text)) in self.legend.iter().enumerate() {
            let y = 36 + PANEL_ROW * row as i32;
            area.draw(&Circle::new((98, y), MARK, mark(*name))).map_err(StudyError::drawing)?;
            let style = TextStyle::from(("sans-serif", 14)).pos(Pos::new(HPos::Left, VPos::Center));
            area.draw(&Text::new(text.as_str(), (112, y), style)).map_err(StudyError::drawing)?;
        }
        // A little more than its lines: the uppermost number of the axis stands half above it.
        let legend_height = if self.legend.is_empty() { 0 } else { 8 + PANEL_ROW * self.legend.len() as i32 };
        let mut axes = ChartBuilder::on(area)
            .margin(12)
            .margin_top(30 + legend_height)
            .x_label_area_size(50)
            .y_label_area_size(100)
            .build_cartesian_2d(xs, ys)
            .map_err(StudyError::drawing)?;
        let mut mesh = axes.configure_mesh();
        mesh.x_desc(self.x_name).y_desc(self.y_name).label_style(("sans-serif", 14));
        mesh.axis_desc_style(("sans-serif", 15)).bold_line_style(BLACK.mix(0.15)).light_line_style(TRANSPARENT);
        mesh.draw().map_err(StudyError::drawing)?;

        if let Some(floor) = self.floor.filter(|&floor| floor > 0.0) {
            let line = DashedLineSeries::new([(left, floor), (right, floor)], 8, 6, GREY.stroke_width(2));
            axes.draw_series(line).map_err(StudyError::drawing)?;
            let style = TextStyle::from(("sans-serif", 13)).color(&GREY).pos(Pos::new(HPos::Right, VPos::Bottom));
            axes.draw_series([Text::new("error of the reference", (right, floor), style)])
                .map_err(StudyError::drawing)?;
        }
        if let Some((x, y)) = first {
            let end = right.min(top / y * x);
            let line = DashedLineSeries::new([(x, y), (end, end / x * y)], 8, 6, GREY.stroke_width(2));
            axes.draw_series(line).map_err(StudyError::drawing)?;
        }
        if self.front {
            let all: Vec<(f64, f64)> = points().map(|(x, y)| (x.at, y.at)).collect();
            let steps = LineSeries::new(staircase(&pareto_front(&all)), GREY.stroke_width(2));
            axes.draw_series(steps).map_err(StudyError::drawing)?;
        }
        for series in &self.series {
            let color = COLOURS[series.name % COLOURS.len()];
            let shown: Vec<&(Value, Value)> = series.points.iter().filter(is_shown).collect();
            if !self.front {
                let line = LineSeries::new(shown.iter().map(|(x, y)| (x.at, y.at)), color.stroke_width(2));
                axes.draw_series(line).map_err(StudyError::drawing)?;
            }
            for (x, y) in shown {
                let across = x.ends.map(|end| (end, y.at));
                let up = y.ends.map(|end| (x.at, end));
                let bars = [across, up].map(|bar| PathElement::new(bar, color.stroke_width(1)));
                axes.draw_series(bars).map_err(StudyError::drawing)?;
                let point = Circle::new((x.at, y.at), MARK, mark(series.name));
                axes.draw_series([point]).map_err(StudyError::drawing)?;
            }
        }
        Ok(())
    }
}

/// Filled for the first seven names, hollow for the next.
fn mark(name: usize) -> ShapeStyle {
    let color = COLOURS[name % COLOURS.len()];
    if name < COLOURS.len() { color.filled() } else { color.stroke_width(2) }
}

fn is_shown((x, y): &&(Value, Value)) -> bool {
    x.at > 0.0 && y.at > 0.0 && x.at.is_finite() && y.at.is_finite()
}

/// The points that no other beats in both directions, by growing x.
pub(super) fn pareto_front(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut front: Vec<(f64, f64)> = Vec::new();
    for point in sorted {
        if front.last().is_none_or(|best| point.1 < best.1) {
            front.push(point);
        }
    }
    front
}

/// What is reached at every x: level until the next point takes over.
fn staircase(front: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let corners = front.windows(2).flat_map(|pair| [pair[0], (pair[1].0, pair[0].1)]);
    corners.chain(front.last().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let points = [(2.0, 5.0), (1.0, 9.0), (3.0, 5.0), (4.0, 1.0), (4.0, 2.0), (5.0, 1.5)];
        let front = pareto_front(&points);
        assert_eq!(front, [(1.0, 9.0), (2.0, 5.0), (4.0, 1.0)]);
        assert_eq!(staircase(&front), [(1.0, 9.0), (2.0, 9.0), (2.0, 5.0), (4.0, 5.0), (4.0, 1.0)]);
    }

    #[test]
    fn svg_and_png_show_the_same_chart() {
        let value = Value::exact;
        let series = Series { name: 0, points: vec![(value(1.0), value(0.1)), (value(10.0), value(0.0))] };
        let panel = Panel {
            title: "A".into(),
            x_name: "x",
            y_name: "y",
            series: vec![series],
            floor: Some(0.01),
            linear: false,
            legend: Vec::new(),
            front: false,
        };
        let chart = Chart { title: "Both".into(), columns: 1, names: vec!["only".into()], panels: vec![panel] };
        let (svg, png) = (chart.svg().unwrap(), chart.png().unwrap());
        assert!(svg.contains("Both") && svg.contains("only") && svg.contains("error of the reference"));
        // One mark in the chart and one in the legend: what is 0 has no place on the axis.
        assert_eq!(svg.matches("<circle").count(), 2);
        assert_eq!((png.width, png.height), chart.size());
        assert!(png.rgba.iter().any(|pixel| pixel[2] > pixel[0] + 0.2), "the first colour is blue");
    }
}
