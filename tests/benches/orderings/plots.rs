//! The two plots: residuals against sweeps and against synchronisations, and modelled speed against workers.

use crate::measure::{Curve, Measured, Ordered};
use plotters::coord::Shift;
use plotters::prelude::*;
use std::path::{Path, PathBuf};

/// A panel's size, pixels.
const PANEL: (u32, u32) = (580, 320);
/// Width of a panel's legend, pixels.
const LEGEND: u32 = 110;
/// Panels next to each other.
const COLUMNS: usize = 2;
/// End of the horizontal axes: sweeps, synchronisations or workers.
const MOST: f64 = 128.0;
/// Colours of the lines, in the order of the tables: told apart also by those who do not see red and green (Okabe,
/// Ito).
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 0, 0),
    RGBColor(153, 153, 153),
    RGBColor(230, 159, 0),
    RGBColor(213, 94, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
];
/// Numbers of workers in the plot.
const WORKERS: [usize; 8] = [1, 2, 4, 8, 16, 32, 64, 128];

type Panel<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), Box<dyn std::error::Error>>;

/// A named line.
struct Series {
    name: &'static str,
    points: Vec<(f64, f64)>,
}

/// Draws both; returns where they are.
pub fn write(all: &[Measured]) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("orderings");
    std::fs::create_dir_all(&folder).expect("the target folder can be written");
    let paths = ["residual.svg", "speed.svg"].map(|name| folder.join(name));
    residuals(&paths[0], all).expect("the plot can be drawn");
    speeds(&paths[1], all).expect("the plot can be drawn");
    paths.to_vec()
}

fn residuals(path: &Path, all: &[Measured]) -> Drawn {
    let scenes: Vec<&Measured> = all.iter().filter(|scene| !scene.curves.is_empty()).collect();
    let against = |scene: &Measured, x: &dyn Fn(&Curve, u32) -> f64| -> Vec<Series> {
        let series = |curve: &Curve| {
            let points = curve.points.iter().map(|&(sweeps, residual)| (x(curve, sweeps), residual));
            Series { name: curve.name, points: points.filter(|&(_, y)| y > 0.0).collect() }
        };
        scene.curves.iter().map(series).collect()
    };
    sheet(path, 2 * scenes.len(), |place, panel| {
        let scene = scenes[place / 2];
        let (what, series) = if place % 2 == 0 {
            ("sweeps", against(scene, &|_, sweeps| f64::from(sweeps)))
        } else {
            ("synchronisations", against(scene, &|curve, sweeps| f64::from(curve.syncs * sweeps)))
        };
        let kept = |(x, _): &(f64, f64)| *x <= MOST;
        let kept: Vec<Series> = series
            .into_iter()
            .map(|line| Series { points: line.points.into_iter().filter(kept).collect(), ..line })
            .collect();
        draw(panel, (&scene.name, what, "residual"), &kept)
    })
}

fn speeds(path: &Path, all: &[Measured]) -> Drawn {
    sheet(path, all.len(), |place, panel| {
        let scene = &all[place];
        let speed = |own: &Ordered| Series {
            name: own.name(),
            points: WORKERS.iter().map(|&count| (count as f64, own.profile.speed_up(count))).collect(),
        };
        let series: Vec<Series> = scene.orderings.iter().map(speed).collect();
        draw(panel, (&scene.name, "workers", "modelled speed"), &series)
    })
}

/// Panels in rows.
fn sheet(path: &Path, count: usize, draw: impl Fn(usize, &Panel<'_>) -> Drawn) -> Drawn {
    let rows = count.div_ceil(COLUMNS).max(1);
    let root = SVGBackend::new(path, (PANEL.0 * COLUMNS as u32, PANEL.1 * rows as u32)).into_drawing_area();
    root.fill(&WHITE)?;
    for (place, panel) in root.split_evenly((rows, COLUMNS)).iter().take(count).enumerate() {
        draw(place, panel)?;
    }
    root.present()?;
    Ok(())
}

/// One panel with both axes logarithmic.
fn draw(panel: &Panel<'_>, (title, x, y): (&str, &str, &str), series: &[Series]) -> Drawn {
    let values = || series.iter().flat_map(|line| &line.points).map(|point| point.1);
    let low = values().fold(1.0, f64::min) * 0.8;
    let high = values().fold(1.0, f64::max) * 1.25;
    let (area, legend) = panel.split_horizontally(PANEL.0 - LEGEND);
    let mut chart = ChartBuilder::on(&area)
        .caption(title, ("sans-serif", 16))
        .margin(8)
        .x_label_area_size(34)
        .y_label_area_size(58)
        .build_cartesian_2d((1.0..MOST).log_scale(), (low..high).log_scale())?;
    let number = |value: &f64| if *value >= 0.01 { format!("{value}") } else { format!("{value:.0e}") };
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .x_desc(x)
        .y_desc(y)
        .x_label_formatter(&number)
        .y_label_formatter(&number)
        .draw()?;
    for (line, colour) in series.iter().zip(COLOURS) {
        chart.draw_series(LineSeries::new(line.points.iter().copied(), colour.stroke_width(2)))?;
    }
    for (place, (line, colour)) in series.iter().zip(COLOURS).enumerate() {
        let y = 44 + 18 * place as i32;
        legend.draw(&PathElement::new([(0, y), (18, y)], colour.stroke_width(2)))?;
        legend.draw(&Text::new(line.name, (24, y - 6), ("sans-serif", 12)))?;
    }
    Ok(())
}
