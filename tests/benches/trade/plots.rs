//! Plots of error against cost, both logarithmic: stairs along the frontier of each engine, which are what a budget
//! buys, a small dot for what is not on it, and a ring around each preset.

use crate::engine::ENGINES;
use crate::measure::{Measured, Outcome};
use cellstep_tests::trade::{frontier, stairs};
use plotters::coord::Shift;
use plotters::prelude::*;
use std::path::{Path, PathBuf};

type Panel<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), Box<dyn std::error::Error>>;

/// A panel's size, pixels: alone, and in the overview.
const ALONE: (u32, u32) = (560, 360);
const SMALL: (u32, u32) = (320, 230);
/// Panels next to each other in the overview.
const COLUMNS: usize = 3;
/// Room for the legend above the overview, pixels.
const LEGEND: u32 = 28;
/// Of the engines, in the order of [`ENGINES`]: told apart also by those who do not see red and green (Okabe, Ito).
const COLOURS: [RGBColor; 3] = [RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 158, 115)];

/// Draws one plot for each scene, and one with all of them; returns where they are.
pub fn write(folder: &Path, all: &[Outcome]) -> Vec<PathBuf> {
    let mut paths = Vec::new();
    for outcome in all {
        let path = folder.join(format!("{}.svg", outcome.scene.name));
        alone(&path, outcome).expect("the plot can be drawn");
        paths.push(path);
    }
    if all.len() > 1 {
        let path = folder.join("overview.svg");
        overview(&path, all).expect("the plot can be drawn");
        paths.push(path);
    }
    paths
}

fn alone(path: &Path, outcome: &Outcome) -> Drawn {
    let root = SVGBackend::new(path, (ALONE.0, ALONE.1 + LEGEND)).into_drawing_area();
    root.fill(&WHITE)?;
    let (top, panel) = root.split_vertically(LEGEND);
    legend(&top)?;
    draw(&panel, outcome, Style { title: 13, text: 12, room: (56, 36), has_dots: true })?;
    root.present()?;
    Ok(())
}

fn overview(path: &Path, all: &[Outcome]) -> Drawn {
    let rows = all.len().div_ceil(COLUMNS);
    let size = (SMALL.0 * COLUMNS as u32, SMALL.1 * rows as u32 + LEGEND);
    let root = SVGBackend::new(path, size).into_drawing_area();
    root.fill(&WHITE)?;
    let (top, panels) = root.split_vertically(LEGEND);
    legend(&top)?;
    for (panel, outcome) in panels.split_evenly((rows, COLUMNS)).iter().zip(all) {
        draw(panel, outcome, Style { title: 13, text: 10, room: (46, 30), has_dots: false })?;
    }
    root.present()?;
    Ok(())
}

/// One line: an entry for each engine, and what the marks mean.
fn legend(area: &Panel<'_>) -> Drawn {
    let mut x = 60;
    for (engine, colour) in ENGINES.iter().zip(COLOURS) {
        area.draw(&PathElement::new([(x, 16), (x + 22, 16)], colour.stroke_width(2)))?;
        area.draw(&Text::new(*engine, (x + 28, 10), ("sans-serif", 12)))?;
        x += 110;
    }
    area.draw(&Circle::new((x + 6, 16), 5, COLOURS[0].stroke_width(1)))?;
    area.draw(&Text::new("preset", (x + 16, 10), ("sans-serif", 12)))?;
    Ok(())
}

#[derive(Clone, Copy)]
struct Style {
    title: i32,
    text: i32,
    /// For the labels of the vertical and the horizontal axis, pixels.
    room: (u32, u32),
    /// Whether what is not on a frontier is shown: the overview is to be a small file.
    has_dots: bool,
}

/// What a point of the plot is worth: errors end at the scene's floor, lost runs are left out.
fn place(measured: &Measured, floor: f64) -> Option<(f64, f64)> {
    let point = measured.point();
    (point.cost.is_finite() && point.error.is_finite()).then(|| (point.cost, point.error.max(floor)))
}

fn draw(panel: &Panel<'_>, outcome: &Outcome, style: Style) -> Drawn {
    let floor = outcome.scene.floor;
    let all: Vec<(f64, f64)> = outcome.all.iter().filter_map(|measured| place(measured, floor)).collect();
    let bounds = |value: fn(&(f64, f64)) -> f64| {
        let low = all.iter().map(value).fold(f64::INFINITY, f64::min);
        let high = all.iter().map(value).fold(0.0, f64::max);
        (low * 0.7)..(high * 1.4)
    };
    if all.is_empty() {
        return Ok(());
    }
    let unit = match outcome.unit() {
        "1" => "error".to_string(),
        unit => format!("error, {unit}"),
    };
    let mut chart = ChartBuilder::on(panel)
        .caption(outcome.scene.name, ("sans-serif", style.title))
        .margin(6)
        .x_label_area_size(style.room.1)
        .y_label_area_size(style.room.0)
        .build_cartesian_2d(bounds(|p| p.0).log_scale(), bounds(|p| p.1).log_scale())?;
    let exponent = |value: &f64| format!("{value:.0e}");
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .bold_line_style(RGBColor(225, 225, 225))
        .x_labels(5)
        .y_labels(6)
        .x_desc("ns per body and simulated second")
        .y_desc(unit)
        .label_style(("sans-serif", style.text))
        .axis_desc_style(("sans-serif", style.text))
        .x_label_formatter(&exponent)
        .y_label_formatter(&exponent)
        .draw()?;
    // The first engine is drawn last, on top.
    for (engine, colour) in ENGINES.iter().zip(COLOURS).rev() {
        let own = outcome.of(engine);
        let spots: Vec<Option<(f64, f64)>> = own.iter().map(|measured| place(measured, floor)).collect();
        let best: Vec<(f64, f64)> =
            frontier(&outcome.points(engine)).into_iter().filter_map(|index| spots[index]).collect();
        let faint = colour.mix(0.45).filled();
        if style.has_dots {
            chart.draw_series(spots.iter().flatten().map(|&spot| Circle::new(spot, 2, faint)))?;
        }
        chart.draw_series(LineSeries::new(stairs(&best), colour.stroke_width(2)))?;
        chart.draw_series(best.iter().map(|&spot| Circle::new(spot, 3, colour.filled())))?;
        let presets = own.iter().zip(&spots).filter(|(measured, _)| measured.preset.is_some());
        let rings = presets.filter_map(|(_, spot)| *spot);
        chart.draw_series(rings.map(|spot| Circle::new(spot, 5, colour.stroke_width(1))))?;
    }
    Ok(())
}
