//! The wedge box's manoeuvre as a matrix of small drawings: one row per scheme, one column per instant.
//!
//! A camera follows the box, so that the drawings stay large; the ledge and its ramp pass through the view. Jumps of
//! millimetres are invisible at this size, so a magnifier below each drawing shows each wedge's tip, with its height in numbers.

use super::clip::Rect;
use super::drawing::{Anchor, Color, Drawing, Stroke, Text};
use super::figure::fits;
use super::ticks::signed;
use super::wedge_box::{self, View};
pub use super::wedge_box::{ContactForce, Pose, WedgeBoxGeometry};
use rimbench_core::error::Result;

const MARGIN: f64 = 8.0;
const HEADER: f64 = 18.0;
const ROW_LABEL: f64 = 20.0;
const BETWEEN: f64 = 8.0;
const LEGEND: f64 = 26.0;

impl Default for WedgeBoxGeometry {
    /// The canonical wedge box at its start position: box at world x = 0, ground pin level with the attachment.
    fn default() -> Self {
        WedgeBoxGeometry {
            box_width_m: 1.0,
            box_height_m: 0.6,
            wedge_tips: [(0.4, -0.4), (-0.4, -0.4)],
            disc_radius_m: 0.2,
            disc_pin: (-0.8, -0.19),
            ledge_height_m: 0.06,
            ledge_corner_x_m: -0.707,
            ramp_slope: 0.15,
            attachment: (-0.5, 0.3),
            ground_pin: (-3.0, 0.737),
        }
    }
}

impl Pose {
    /// Finds the world position of a point of the box.
    pub fn world(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let (sin, cos) = self.box_angle_rad.sin_cos();
        (self.box_x_m + cos * x - sin * y, self.box_y_m + sin * x + cos * y)
    }
}

/// One scheme's poses.
#[derive(Debug, Clone, PartialEq)]
pub struct ManoeuvreRow {
    /// Scheme.
    pub scheme: String,
    /// Its colour.
    pub color: Color,
    /// Poses at the instants common to all rows.
    pub poses: Vec<Pose>,
}

/// The whole matrix.
#[derive(Debug, Clone, PartialEq)]
pub struct Manoeuvre {
    /// Width, px; the height follows from the number of rows.
    pub width: f64,
    /// Lengths.
    pub geometry: WedgeBoxGeometry,
    /// A contact force of this size is an arrow of 0.3 m; one beyond 2.5 times it is cut and gets two heads.
    pub arrow_force_n: f64,
    /// Rows from the top.
    pub rows: Vec<ManoeuvreRow>,
}

impl Manoeuvre {
    /// Draws the matrix if its cells have room in it.
    ///
    /// # Errors
    /// [`Error::Incompatible`](rimbench_core::error::Error::Incompatible) if not.
    pub fn draw_if_it_fits(&self) -> Result<Drawing> {
        fits(&[("width", self.width, self.cell_width())]).map(|()| self.draw())
    }

    /// Instants, side by side.
    fn columns(&self) -> usize {
        self.rows.iter().map(|row| row.poses.len()).max().unwrap_or(0).max(1)
    }

    fn cell_width(&self) -> f64 {
        let columns = self.columns();
        let inner = self.width - 2.0 * MARGIN - BETWEEN * (columns - 1) as f64;
        (inner / columns as f64).floor()
    }

    /// Draws the matrix.
    pub fn draw(&self) -> Drawing {
        let (columns, cell_width) = (self.columns(), self.cell_width());
        let cell_height = (cell_width * View::ASPECT).round();
        let row_height = ROW_LABEL + cell_height + wedge_box::STRIP + BETWEEN;
        let height = 2.0 * MARGIN + HEADER + self.rows.len() as f64 * row_height + LEGEND - BETWEEN;
        let mut drawing = Drawing::new(self.width, height);
        drawing.title = "Manoeuvre of the wedge box".to_owned();

        let left_of = |column: usize| MARGIN + column as f64 * (cell_width + BETWEEN);
        let instants = self.rows.iter().max_by_key(|row| row.poses.len());
        for (column, pose) in instants.iter().flat_map(|row| &row.poses).enumerate() {
            let at = (left_of(column) + 0.5 * cell_width, MARGIN + 10.0);
            drawing.text(Text::new(format!("t = {:.3} s", pose.time_s), at, 10.6).bold().anchored(Anchor::Middle));
        }
        for (index, row) in self.rows.iter().enumerate() {
            let top = MARGIN + HEADER + index as f64 * row_height;
            let label = Text::new(&row.scheme, (MARGIN, top + 0.5 * ROW_LABEL), 10.6).bold();
            let rule_from = MARGIN + label.width() + 10.0;
            let rule = Stroke::solid(row.color.mix(Color::WHITE, 0.55), 1.0);
            drawing.text(label.colored(row.color.mix(Color::INK, 0.15)).centred());
            let rule_y = (top + 0.5 * ROW_LABEL).floor() + 0.5;
            drawing.line(vec![(rule_from, rule_y), (left_of(columns - 1) + cell_width, rule_y)], rule);
            for (column, pose) in row.poses.iter().enumerate() {
                let (left, top) = (left_of(column) + 0.5, top + ROW_LABEL + 0.5);
                let frame = Rect { left, top, right: left + cell_width - 1.0, bottom: top + cell_height - 1.0 };
                let view = View::following(pose, frame, self.arrow_force_n);
                wedge_box::draw(&mut drawing, &view, &self.geometry, pose, row.color);
            }
        }
        self.legend(&mut drawing, height - MARGIN - 10.0, cell_width);
        drawing
    }

    fn legend(&self, drawing: &mut Drawing, y: f64, cell_width: f64) {
        let pixels_per_m = View::pixels_per_m(cell_width);
        let limit = wedge_box::LONGEST_ARROW * self.arrow_force_n;
        let cut = self.rows.iter().flat_map(|row| &row.poses).flat_map(|pose| &pose.contact_forces);
        let cut = cut.into_iter().any(|force| force.fx_n.hypot(force.fy_n) > limit);
        let length = wedge_box::ARROW_M * pixels_per_m;
        wedge_box::arrow(drawing, (MARGIN, y), (MARGIN + length, y), 1);
        let kilo = |newtons: f64| signed(format!("{}", (newtons / 100.0).round() / 10.0));
        let mut text = format!("contact force of {} kN", kilo(self.arrow_force_n));
        if cut {
            text += &format!(" (double head: more than {} kN, cut)", kilo(limit));
        }
        let text = Text::new(text, (MARGIN + length + 7.0, y), 9.8).centred();
        let next = text.at.0 + text.width() + 22.0;
        drawing.text(text);
        let heights =
            format!("in the circles: each wedge's tip above the floor, {} times larger", wedge_box::MAGNIFIED);
        drawing.text(Text::new(heights, (next, y), 9.8).centred());
    }
}

#[cfg(test)]
mod tests {
    use super::super::drawing::Shape;
    use super::*;

    #[test]
    fn a_run_that_diverged_says_so_and_one_that_flew_away_stays_in_its_frame() {
        let pose = |box_y_m| Pose {
            time_s: 1.0,
            box_x_m: 0.0,
            box_y_m,
            box_angle_rad: 2.0,
            disc_angle_rad: 0.0,
            contact_forces: vec![ContactForce { x_m: 0.0, y_m: 0.0, fx_n: 1e9, fy_n: 1e9 }],
            actuator_force_n: f64::INFINITY,
        };
        let row = ManoeuvreRow {
            scheme: "zero-order-hold".to_owned(),
            color: Color(0, 0, 0),
            poses: vec![pose(f64::NAN), pose(1e7)],
        };
        let geometry = WedgeBoxGeometry::default();
        let drawing = Manoeuvre { width: 600.0, geometry, arrow_force_n: 2000.0, rows: vec![row] }.draw();
        let mut texts = Vec::new();
        for shape in &drawing.shapes {
            let points = match shape {
                Shape::Text(text) => {
                    texts.push(text.content.as_str());
                    vec![text.at]
                }
                Shape::Path { points, .. } => points.clone(),
                Shape::Disc { centre, .. } => vec![*centre],
                Shape::Open(_) | Shape::Close => continue,
            };
            let inside = |p: &(f64, f64)| (0.0..=600.0).contains(&p.0) && (0.0..=drawing.height).contains(&p.1);
            assert!(points.iter().all(inside), "{shape:?}");
        }
        assert!(texts.contains(&"diverged"));
    }

    #[test]
    fn a_point_of_the_box_turns_counter_clockwise() {
        let pose = Pose {
            time_s: 0.0,
            box_x_m: 2.0,
            box_y_m: 1.0,
            box_angle_rad: std::f64::consts::FRAC_PI_2,
            disc_angle_rad: 0.0,
            contact_forces: Vec::new(),
            actuator_force_n: 0.0,
        };
        let (x, y) = pose.world((0.5, 0.0));
        assert!((x - 2.0).abs() < 1e-12 && (y - 1.5).abs() < 1e-12);
    }
}
