//! What a case looks like: shapes fixed to frames, frames moved by columns of its trace.
//!
//! ```text
//! frame     x, y, angle: each a number or gain · column + offset; in another frame, if it has one
//! point     [x, y] of a frame, or of the ground
//! ```
//! Lengths in m, angles in rad. From a drawing come the pictures of the page that simulates.

use crate::parameter::{ParameterSet, Parameters};
use std::sync::Arc;

/// Says what a case looks like with these parameters; none where nothing can be drawn.
pub type DrawCase = Arc<dyn Fn(&Parameters) -> Option<Drawing> + Send + Sync>;

/// Draws a case from its own parameters.
pub(super) fn drawn<P: ParameterSet>(drawing: impl Fn(&P) -> Option<Drawing> + Send + Sync + 'static) -> DrawCase {
    Arc::new(move |parameters| drawing(&P::read(parameters)))
}

/// The macro steps of a page that simulates, in ms where that of the case is some of them; in µs where it is a few.
const STEPS: [f64; 25] = [
    0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.5, 15.0, 20.0,
    25.0, 30.0, 40.0, 50.0,
];

/// Lists the macro steps, ms, that a page offers of a case that usually takes this one, s.
pub fn offered_steps_ms(usual_s: f64) -> Vec<f64> {
    // A quotient of decimal numbers is the one that would be written.
    let parts = if 1e3 * usual_s < STEPS[0] { 1e3 } else { 1.0 };
    STEPS.map(|step| step / parts).to_vec()
}

/// A number, or a column of the trace scaled and shifted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Channel {
    /// Stays as it is.
    Fixed(f64),
    /// `gain · column + offset`.
    Column(&'static str, f64, f64),
    /// A coordinate of the mechanics, for bodies that no column names; see
    /// [`coordinate_column`](super::coordinate_column).
    Coordinate(usize),
}

impl From<f64> for Channel {
    fn from(value: f64) -> Self {
        Channel::Fixed(value)
    }
}

impl From<&'static str> for Channel {
    fn from(column: &'static str) -> Self {
        Channel::Column(column, 1.0, 0.0)
    }
}

/// A frame that moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Name, by which points are fixed to it.
    pub name: &'static str,
    /// The frame it is fixed to, one above it in the list.
    pub parent: Option<&'static str>,
    /// Origin x, y and angle.
    pub pose: [Channel; 3],
}

/// A point: coordinates, and the frame they are of.
pub type Point = ([f64; 2], Option<&'static str>);

/// With what a shape is filled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fill {
    /// The colour of the scheme.
    Scheme,
    /// Another body.
    Metal,
    /// What does not move.
    Ground,
}

/// A shape.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A closed outline.
    Polygon(Vec<Point>, Fill),
    /// A circle; with a spoke it is seen to roll.
    Disc {
        /// Centre.
        at: Point,
        /// Radius.
        radius: f64,
        /// Whether a spoke shows its angle.
        spoke: bool,
        /// Filling.
        fill: Fill,
    },
    /// Circles of this radius about bodies that no frame names.
    Discs(Vec<[Channel; 2]>, f64, Fill),
    /// Straight lines from point to point.
    Line(Vec<Point>),
    /// A coil spring between two points, of this width.
    Spring(Point, Point, f64),
    /// A cylinder fixed at the first point, its rod's end at the second.
    Cylinder {
        /// Fixed end.
        from: Point,
        /// End of the rod.
        to: Point,
        /// Length of the barrel.
        barrel: f64,
        /// Width of the barrel.
        width: f64,
    },
    /// The force of a contact.
    Arrow {
        /// Its column, N.
        column: &'static str,
        /// Where it acts.
        at: Point,
        /// Its direction, a unit vector of the ground.
        along: [f64; 2],
        /// Length per force, m/N.
        scale: f64,
    },
    /// Bodies in space as [`camera`] sees them, the nearest last, with their shadows on the floor z = 0 straight below.
    Scene(Vec<Solid>),
}

/// A convex body in space.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    /// Origin x, y, z, and its turns about z, the new y and the new x.
    pub pose: [Channel; 6],
    /// What it is.
    pub form: Form,
    /// Filling.
    pub fill: Fill,
    /// Column of its gap, m: what is off the floor has the colour of forces.
    pub gap: Option<&'static str>,
}

/// The form of a body in space, in its own axes.
#[derive(Debug, Clone, PartialEq)]
pub enum Form {
    /// Corners, and the corners of each face.
    Hull(Vec<[f64; 3]>, Vec<Vec<usize>>),
    /// A ball about the origin, of this radius.
    Ball(f64),
    /// A rod from a point of the ground to one of the body, of this width.
    Rod([f64; 3], [f64; 3], f64),
}

/// Directions of the picture in space: to the right, upwards, and towards the eye. Parallel lines stay parallel.
pub fn camera() -> [[f64; 3]; 3] {
    let ((sin, cos), (down, level)) = (libm::sincos(-50_f64.to_radians()), libm::sincos(22_f64.to_radians()));
    [[-sin, cos, 0.0], [-cos * down, -sin * down, level], [cos * level, sin * level, down]]
}

/// Where a point in space is in the picture, m.
fn seen(point: [f64; 3]) -> [f64; 2] {
    let [across, up, _] = camera();
    [across, up].map(|axis| (0..3).map(|k| axis[k] * point[k]).sum())
}

impl Shape {
    /// Lists the points that it is fixed to.
    pub fn points(&self) -> Vec<Point> {
        match self {
            Shape::Polygon(points, _) | Shape::Line(points) => points.clone(),
            Shape::Spring(from, to, _) | Shape::Cylinder { from, to, .. } => vec![*from, *to],
            Shape::Disc { at, .. } | Shape::Arrow { at, .. } => vec![*at],
            Shape::Discs(..) | Shape::Scene(_) => Vec::new(),
        }
    }
}

/// What a case looks like.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    /// What is seen: least and largest x, y.
    pub view: [[f64; 2]; 2],
    /// The column that the view goes along with in x.
    pub follow: Option<&'static str>,
    /// Frames, parents first.
    pub frames: Vec<Frame>,
    /// Shapes, from behind to the front.
    pub shapes: Vec<Shape>,
    /// Title of the case, and the sentence about it.
    pub title: [&'static str; 2],
    /// What the force across the first row of the interface is called.
    pub force: &'static str,
    /// Whether it is told in kN.
    pub in_kilonewtons: bool,
    /// What is said of contacts that open although the reference keeps them closed, and of those that do not.
    pub contact: Option<[&'static str; 2]>,
    /// The two schemes it is first shown with.
    pub schemes: [&'static str; 2],
}

impl Default for Drawing {
    fn default() -> Self {
        Drawing {
            view: [[0.0, 1.0]; 2],
            follow: None,
            frames: Vec::new(),
            shapes: Vec::new(),
            title: ["", ""],
            force: "spring force",
            in_kilonewtons: false,
            contact: None,
            schemes: ["zero-order-hold", "rim-nonsmooth"],
        }
    }
}

/// What a case is first shown with on which no coupling goes beyond the mechanics' own step: a model, and both sides in
/// one.
pub(super) const LIMITED_BY_ITS_STEP: [&str; 2] = ["rim-nonsmooth", "monolithic"];

impl Drawing {
    /// A title and a sentence about it, and what is seen of frames and shapes.
    pub(super) fn of(title: [&'static str; 2], view: [[f64; 2]; 2], frames: Vec<Frame>, shapes: Vec<Shape>) -> Self {
        Drawing { title, view, frames, shapes, ..Drawing::default() }
    }

    /// The same, first shown with other schemes.
    pub(super) fn with(self, schemes: [&'static str; 2]) -> Self {
        Drawing { schemes, ..self }
    }

    /// Lists the columns that it reads.
    pub fn columns(&self) -> Vec<&'static str> {
        let solids = || {
            self.shapes.iter().flat_map(|shape| match shape {
                Shape::Scene(solids) => &solids[..],
                _ => &[],
            })
        };
        let poses = self.frames.iter().flat_map(|frame| frame.pose).chain(solids().flat_map(|solid| solid.pose));
        let channels = poses.filter_map(|channel| match channel {
            Channel::Column(column, _, _) => Some(column),
            Channel::Fixed(_) | Channel::Coordinate(_) => None,
        });
        let gaps = solids().filter_map(|solid| solid.gap);
        let arrows = self.shapes.iter().filter_map(|shape| match shape {
            Shape::Arrow { column, .. } => Some(*column),
            _ => None,
        });
        channels.chain(arrows).chain(gaps).chain(self.follow).collect()
    }

    /// Lists the coordinates of the mechanics that it reads.
    pub fn coordinates(&self) -> Vec<usize> {
        let centres = self.shapes.iter().flat_map(|shape| match shape {
            Shape::Discs(centres, ..) => &centres[..],
            _ => &[],
        });
        let channels = self.frames.iter().flat_map(|frame| frame.pose).chain(centres.flatten().copied());
        let coordinate = |channel| if let Channel::Coordinate(index) = channel { Some(index) } else { None };
        channels.filter_map(coordinate).collect()
    }
}

/// A frame of the ground, at columns or numbers.
pub(super) fn frame(
    name: &'static str,
    x: impl Into<Channel>,
    y: impl Into<Channel>,
    angle: impl Into<Channel>,
) -> Frame {
    Frame { name, parent: None, pose: [x.into(), y.into(), angle.into()] }
}

/// A frame in another one.
pub(super) fn within(parent: &'static str, frame: Frame) -> Frame {
    Frame { parent: Some(parent), ..frame }
}

/// Points of a frame.
pub(super) fn points<const N: usize>(frame: &'static str, points: [[f64; 2]; N]) -> Vec<Point> {
    points.map(|point| (point, Some(frame))).to_vec()
}

/// A rectangle about a point of a frame.
pub(super) fn rectangle(frame: &'static str, [x, y]: [f64; 2], [width, height]: [f64; 2]) -> Vec<Point> {
    let (w, h) = (width / 2.0, height / 2.0);
    points(frame, [[x - w, y - h], [x + w, y - h], [x + w, y + h], [x - w, y + h]])
}

/// A rectangle that does not move, from x, y to x, y.
pub(super) fn wall([left, low]: [f64; 2], [right, high]: [f64; 2]) -> Shape {
    let corners = [[left, low], [right, low], [right, high], [left, high]];
    Shape::Polygon(corners.map(|point| (point, None)).to_vec(), Fill::Ground)
}

/// A disc of a frame, or of the ground.
pub(super) fn disc(at: Point, radius: f64, fill: Fill) -> Shape {
    Shape::Disc { at, radius, spoke: false, fill }
}

/// A disc that is seen to roll, about the origin of a frame.
pub(super) fn wheel(frame: &'static str, radius: f64) -> Shape {
    Shape::Disc { at: ([0.0, 0.0], Some(frame)), radius, spoke: true, fill: Fill::Metal }
}

/// What does not move, below a line from the left to the right.
pub(super) fn ground(line: &[[f64; 2]]) -> Shape {
    let depth = line.iter().fold(f64::INFINITY, |least, point| least.min(point[1])) - 9.0;
    let corners = [line.last(), line.first()].into_iter().flatten().map(|corner| [corner[0], depth]);
    Shape::Polygon(line.iter().copied().chain(corners).map(|point| (point, None)).collect(), Fill::Ground)
}

/// The pose of the body of a [`SpatialBody`](crate::models::SpatialBody).
pub(super) fn body_in_space() -> [Channel; 6] {
    ["body_x_m", "body_y_m", "body_z_m", "yaw_rad", "pitch_rad", "roll_rad"].map(Channel::from)
}

/// A prism of a profile over x and z, from one y to another.
pub(super) fn prism(profile: &[[f64; 2]], [from, to]: [f64; 2]) -> Form {
    let n = profile.len();
    let corners = [from, to].iter().flat_map(|y| profile.iter().map(move |[x, z]| [*x, *y, *z])).collect();
    let sides = (0..n).map(|k| vec![k, (k + 1) % n, n + (k + 1) % n, n + k]);
    Form::Hull(corners, sides.chain([(0..n).collect(), (n..2 * n).collect()]).collect())
}

/// A machine in space: its box of this size, its feet, pyramids whose tips are here, and what else there is, over a
/// floor from x, y to x, y.
pub(super) fn machine_in_space(size: [f64; 3], feet: &[[f64; 3]], more: Vec<Solid>, floor: [[f64; 2]; 2]) -> Drawing {
    const GAPS: [&str; 4] = ["gap_foot_1_m", "gap_foot_2_m", "gap_foot_3_m", "gap_foot_4_m"];
    let [[left, near], [right, far]] = floor;
    let line = |from: [f64; 2], to: [f64; 2]| Shape::Line([from, to].map(|[x, y]| (seen([x, y, 0.0]), None)).to_vec());
    let corners = [[left, near], [right, near], [right, far], [left, far]].map(|[x, y]| seen([x, y, 0.0]));
    let mut shapes = vec![Shape::Polygon(corners.map(|point| (point, None)).to_vec(), Fill::Ground)];
    let steps =
        |from: f64, to: f64| (1..).map(move |k| from + 0.5 * f64::from(k)).take_while(move |at| *at < to - 0.01);
    shapes.extend(steps(left, right).map(|x| line([x, near], [x, far])));
    shapes.extend(steps(near, far).map(|y| line([left, y], [right, y])));
    let [x, y, z] = size.map(|size| 0.5 * size);
    let form = prism(&[[-x, -z], [x, -z], [x, z], [-x, z]], [-y, y]);
    let mut solids = vec![Solid { pose: body_in_space(), form, fill: Fill::Scheme, gap: None }];
    solids.extend(feet.iter().zip(GAPS).map(|(&[x, y, tip], gap)| {
        let base = [[-0.06, -0.06], [0.06, -0.06], [0.06, 0.06], [-0.06, 0.06]].map(|[a, b]| [x + a, y + b, -z]);
        let faces = (0..4).map(|k| vec![k, (k + 1) % 4, 4]).collect();
        let form = Form::Hull([&base[..], &[[x, y, tip]]].concat(), faces);
        Solid { pose: body_in_space(), form, fill: Fill::Metal, gap: Some(gap) }
    }));
    let ends =
        more.iter().filter_map(|solid| if let Form::Rod(from, ..) = solid.form { Some(seen(from)) } else { None });
    let ends: Vec<[f64; 2]> = ends.collect();
    solids.extend(more);
    shapes.push(Shape::Scene(solids));
    let high = 2.0 * z - feet.iter().fold(0.0, |least: f64, foot| least.min(foot[2] + z));
    let roof = [[-x, -y], [x, -y], [x, y], [-x, y]].map(|[x, y]| seen([1.2 * x, 1.2 * y, high]));
    let bounds = |axis: usize| {
        let all = corners.iter().chain(&roof).chain(&ends).map(|corner| corner[axis]);
        let least = all.clone().fold(f64::INFINITY, f64::min);
        [least - 0.1, all.fold(f64::NEG_INFINITY, f64::max) + 0.1]
    };
    Drawing {
        view: [bounds(0), bounds(1)],
        // By which the page sees how far two runs are apart.
        frames: vec![frame("body", "body_x_m", "body_y_m", "yaw_rad")],
        shapes,
        in_kilonewtons: true,
        contact: Some(["lifts off", "stays down"]),
        schemes: ["zero-order-hold", "rim-nonsmooth-gap"],
        ..Drawing::default()
    }
}

/// The centres of so many bodies whose x and y are coordinates of the mechanics one after the other, from this one on.
pub(super) fn centres(count: usize, first: usize) -> Vec<[Channel; 2]> {
    (0..count).map(|body| [first + 2 * body, first + 2 * body + 1].map(Channel::Coordinate)).collect()
}

/// The force of a contact, upwards.
pub(super) fn upward(column: &'static str, at: Point, scale: f64) -> Shape {
    Shape::Arrow { column, at, along: [0.0, 1.0], scale }
}
