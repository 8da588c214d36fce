//! The wedge box at a row of instants, one row per scheme.

use super::keys::*;
use super::trace_figure::trace_path;
use crate::animation::{Animation, Curve, Moving, Page, Timing};
use crate::drawing::Drawing;
use crate::manoeuvre::{ContactForce, Manoeuvre, ManoeuvreRow, Pose, WedgeBoxGeometry};
use crate::style::Styles;
use rimbench_core::error::Result;
use rimbench_results::results_table::{ResultsTable, read_table};
use std::path::Path;

keys! {
    /// Options of a manoeuvre figure.
    pub struct ManoeuvreFigure {
        width: f64 = WIDTH,
        schemes: Vec<String> = key(Takes::Labels, Needed, "scheme rows, one row of drawings each"),
        instants_s: Vec<f64> =
            key(Takes::Numbers, Needed, "instants, s; the communication point nearest to each is drawn"),
        arrow_force_n: f64 =
            key(Takes::Positive, Usual("2000"), "contact force of the arrow in the legend, N"),
        animated_s: Option<[f64; 2]> = key(
            Takes::Interval,
            Then("stills only"),
            "part of the run, s, that is shown in motion as well: two images that loop, for light and for dark pages, `<id>-moving-light.svg` and `<id>-moving-dark.svg`"
        ),
        slow_s: Option<[f64; 2]> = key(Takes::Interval, Like("animated_s"), "the part of it that plays slowly, s"),
    }
}

impl ManoeuvreFigure {
    /// Draws the figure from `parameters.csv` and the traces.
    ///
    /// # Errors
    /// [`Error::File`](rimbench_core::error::Error::File) for what is not there.
    pub(super) fn draw(&self, folder: &Path, styles: &Styles) -> Result<Drawing> {
        let mut rows = Vec::new();
        let mut geometry = geometry(folder)?;
        for label in &self.schemes {
            let trace = read_table(&trace_path(folder, label)?)?;
            geometry = placed(geometry, folder, &trace)?;
            let poses: Result<Vec<Pose>> = self.instants_s.iter().map(|&t| pose(&trace, &geometry, t)).collect();
            let color = styles.of_label(label).color;
            rows.push(ManoeuvreRow { scheme: styles.shown_name(label), color, poses: poses? });
        }
        Manoeuvre { width: self.width, geometry, arrow_force_n: self.arrow_force_n, rows }.draw_if_it_fits()
    }

    /// The first two schemes in motion, with the force below: ends of file names, and what stands in the files. Nothing where no
    /// motion is asked for.
    ///
    /// # Errors
    /// Those of [`draw`](Self::draw).
    pub(super) fn animations(&self, folder: &Path, styles: &Styles) -> Result<Vec<(String, String)>> {
        let Some(shown_s) = self.animated_s else { return Ok(Vec::new()) };
        let mut geometry = geometry(folder)?;
        let (mut schemes, mut curves) = (Vec::new(), Vec::new());
        let reference = read_table(&trace_path(folder, "reference")?)?;
        curves.push(Curve { color: None, points: reference.pairs("time_s", FORCE)? });
        for label in self.schemes.iter().take(2) {
            let trace = read_table(&trace_path(folder, label)?)?;
            geometry = placed(geometry, folder, &trace)?;
            let time = trace.column("time_s")?;
            let instants = (0..trace.len()).map(|row| trace.number(row, time));
            let shown = instants.filter(|t| (shown_s[0] - 1e-9..=shown_s[1] + 1e-9).contains(t));
            let poses: Vec<Pose> = shown.map(|t| pose(&trace, &geometry, t)).collect::<Result<_>>()?;
            let color = styles.of_label(label).color;
            curves.push(Curve { color: Some(color), points: trace.pairs("time_s", FORCE)? });
            schemes.push(Moving { label: styles.shown_name(label), verdict: verdict(folder, label)?, color, poses });
        }
        let still_s = self.instants_s.last().copied().unwrap_or(shown_s[0]);
        let names: Vec<&str> = schemes.iter().map(|scheme| scheme.label.as_str()).collect();
        let animation = Animation {
            title: format!("The wedge box touching down, with {}", names.join(" and with ")),
            geometry,
            timing: Timing { shown_s, slow_s: self.slow_s.unwrap_or(shown_s), still_s },
            schemes,
            curves,
            force_n: [-4000.0, 4000.0],
        };
        Ok([Page::Light, Page::Dark].map(|page| (page.name().to_owned(), animation.svg(page))).into())
    }
}

/// Says by how many whole millimetres a contact opens that is closed in the reference; nothing where the run has no such height.
fn verdict(folder: &Path, label: &str) -> Result<String> {
    let runs = read_table(&folder.join("runs.csv"))?;
    let rows = runs.rows_where(runs.column("label")?, label);
    let height = runs.column("lift_off_height_m")?;
    let millimetres = rows.first().map_or(f64::NAN, |&row| 1e3 * runs.number(row, height)).round();
    Ok(match millimetres {
        _ if !millimetres.is_finite() => String::new(),
        0.0 => "stays down".to_owned(),
        _ => format!("lifts off {millimetres:.0} mm"),
    })
}

/// Column of the actuator's force.
const FORCE: &str = "actuator_force_n";

/// The ledge's corner and the ground pin are given relative to the start pose.
fn placed(geometry: WedgeBoxGeometry, folder: &Path, trace: &ResultsTable) -> Result<WedgeBoxGeometry> {
    let start = pose(trace, &geometry, 0.0)?;
    let lead = parameter(folder, "ledge_lead_m")?;
    let ground_pin = (geometry.ground_pin.0, start.world(geometry.attachment).1);
    Ok(WedgeBoxGeometry { ledge_corner_x_m: start.world(geometry.disc_pin).0 + lead, ground_pin, ..geometry })
}

/// A parameter of the case as it was run.
fn parameter(folder: &Path, name: &str) -> Result<f64> {
    let table = read_table(&folder.join("parameters.csv"))?;
    let rows = table.rows_where(table.column("parameter")?, name);
    let value = table.column("value")?;
    Ok(rows.first().map_or(f64::NAN, |&row| table.number(row, value)))
}

fn geometry(folder: &Path) -> Result<WedgeBoxGeometry> {
    let get = |name| parameter(folder, name);
    let (tip_x, tip_y) = (get("wedge_tip_x_m")?, get("wedge_tip_y_m")?);
    Ok(WedgeBoxGeometry {
        box_width_m: get("box_width_m")?,
        box_height_m: get("box_height_m")?,
        wedge_tips: [(tip_x, tip_y), (-tip_x, tip_y)],
        disc_radius_m: get("disc_radius_m")?,
        disc_pin: (get("disc_pin_x_m")?, get("disc_pin_y_m")?),
        ledge_height_m: get("ledge_height_m")?,
        ledge_corner_x_m: f64::NAN,
        ramp_slope: get("ramp_slope")?,
        attachment: (get("attachment_x_m")?, get("attachment_y_m")?),
        ground_pin: (get("ground_pin_x_m")?, f64::NAN),
    })
}

/// The pose at the communication point nearest to `t`; all NaN where the run had ended before.
fn pose(trace: &ResultsTable, geometry: &WedgeBoxGeometry, t: f64) -> Result<Pose> {
    let time = trace.column("time_s")?;
    let nearest = (0..trace.len())
        .min_by(|&a, &b| (trace.number(a, time) - t).abs().total_cmp(&(trace.number(b, time) - t).abs()));
    let ended = trace.len() > 1 && t > 2.0 * trace.number(trace.len() - 1, time) - trace.number(trace.len() - 2, time);
    let get = |name: &str| -> Result<f64> {
        let column = trace.column(name)?;
        Ok(nearest.filter(|_| !ended).map_or(f64::NAN, |row| trace.number(row, column)))
    };
    let mut pose = Pose {
        time_s: t,
        box_x_m: get("box_x_m")?,
        box_y_m: get("box_y_m")?,
        box_angle_rad: get("box_angle_rad")?,
        // Nothing turns a disc without friction.
        disc_angle_rad: 0.0,
        contact_forces: Vec::new(),
        actuator_force_n: get("actuator_force_n")?,
    };
    let disc = pose.world(geometry.disc_pin);
    let radius = geometry.disc_radius_m;
    let (sin, cos) = get("disc_ledge_normal_rad")?.sin_cos();
    let contacts = [
        ("contact_force_right_wedge_n", pose.world(geometry.wedge_tips[0]), (0.0, 1.0)),
        ("contact_force_left_wedge_n", pose.world(geometry.wedge_tips[1]), (0.0, 1.0)),
        ("contact_force_disc_ledge_n", (disc.0 - radius * cos, disc.1 - radius * sin), (cos, sin)),
        ("contact_force_disc_floor_n", (disc.0, disc.1 - radius), (0.0, 1.0)),
    ];
    for (column, (x_m, y_m), normal) in contacts {
        // An open contact has no force, and stays in its place.
        let force = get(column)?.max(0.0);
        pose.contact_forces.push(ContactForce { x_m, y_m, fx_n: force * normal.0, fy_n: force * normal.1 });
    }
    Ok(pose)
}
