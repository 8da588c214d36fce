//! Draws a case from what it says of itself: for its page in the book, and for figures of its motion.

use super::clip::{self, Rect};
use super::drawing::{Color, Drawing, Point, Stroke};
use rimbench_cases::cases::{
    Case, Channel, Drawing as CaseDrawing, Fill, Form, Point as CasePoint, Shape, Solid, camera, coordinate_column,
};
use rimbench_core::error::Result;
use rimbench_results::results_table::ResultsTable;
use std::collections::BTreeMap;

/// Width of a picture in the book, px.
const WIDTH: f64 = 560.0;
const METAL: Color = Color(0xC9, 0xCE, 0xD4);
const GROUND: Color = Color(0xE4, 0xE7, 0xEA);
const FORCE: Color = Color(0x7A, 0x1F, 0x7A);
const SHADOW: Color = Color(0xC6, 0xCA, 0xCE);
/// Gap from which on a foot is off the floor, m.
const OFF: f64 = 1e-4;
const OUTLINE: Stroke = Stroke { color: Color::INK, width: 1.1, dash: &[] };
/// Longest arrow of a force, as a share of the height of what is seen.
const LONGEST: f64 = 0.35;

/// Draws a case, given the value of each column.
pub fn picture(case: &Case, of: &CaseDrawing, value: &dyn Fn(&str) -> f64) -> Drawing {
    let [x, y] = of.view;
    let height = (WIDTH * (y[1] - y[0]) / (x[1] - x[0])).clamp(90.0, 330.0).round();
    let mut drawing = Drawing::new(WIDTH, height);
    drawing.title = format!("The case {}", case.name);
    drawing.description = format!("{}, as it starts.", case.about);
    let place = Rect { left: 0.0, top: 0.0, right: WIDTH, bottom: height };
    let view = View { place, follow: of.follow.map_or(0.0, value) };
    view.draw(&mut drawing, of, value, Some(Color(0x00, 0x72, 0xB2)));
    drawing
}

/// A run as its case draws it: the columns of the drawing over time, with what differs from the reference enlarged.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Time of each row, s.
    pub times_s: Vec<f64>,
    /// The columns.
    pub columns: BTreeMap<&'static str, Vec<f64>>,
    /// Where the view is: with the reference.
    pub follow: Vec<f64>,
}

impl Motion {
    /// Reads the columns of a drawing from the trace of a run and that of the reference. Forces are as they are.
    ///
    /// # Errors
    /// [`Error::File`](rimbench_core::error::Error::File) for a trace without one of them.
    pub fn read(of: &CaseDrawing, trace: &ResultsTable, reference: &ResultsTable, enlarged: f64) -> Result<Self> {
        let column = |table: &ResultsTable, name: &str| -> Result<Vec<f64>> {
            let column = table.column(name)?;
            Ok((0..table.len()).map(|row| table.number(row, column)).collect())
        };
        Self::of(of, column, [trace, reference], enlarged)
    }

    /// Takes the columns of a drawing from a run and its reference, each read by `column`.
    ///
    /// # Errors
    /// Those of `column`.
    pub fn of<T>(
        of: &CaseDrawing,
        column: impl Fn(&T, &str) -> Result<Vec<f64>>,
        [trace, reference]: [&T; 2],
        enlarged: f64,
    ) -> Result<Self> {
        let (times_s, theirs) = (column(trace, "time_s")?, column(reference, "time_s")?);
        let last = theirs.len().saturating_sub(1);
        let rows: Vec<usize> =
            times_s.iter().map(|t| theirs.partition_point(|other| *other < t - 1e-9).min(last)).collect();
        let at = |name: &str| -> Result<Vec<f64>> {
            let all = column(reference, name)?;
            Ok(rows.iter().map(|&row| all.get(row).copied().unwrap_or(f64::NAN)).collect())
        };
        let mut columns = BTreeMap::new();
        for name in of.columns() {
            let own = column(trace, name)?;
            let enlarge =
                |(own, other): (f64, f64)| if name.ends_with("_n") { own } else { other + enlarged * (own - other) };
            columns.insert(name, own.into_iter().zip(at(name)?).map(enlarge).collect());
        }
        let follow = of.follow.map_or_else(|| Ok(vec![0.0; times_s.len()]), at)?;
        Ok(Motion { times_s, columns, follow })
    }

    /// The row nearest to an instant; none where the run had ended before.
    pub fn row_at(&self, t: f64) -> Option<usize> {
        let far = |row: &usize| (self.times_s[*row] - t).abs();
        let nearest = (0..self.times_s.len()).min_by(|one, other| far(one).total_cmp(&far(other)))?;
        let spacing = self.times_s.windows(2).last().map_or(0.0, |pair| pair[1] - pair[0]);
        (far(&nearest) <= spacing.max(1e-9)).then_some(nearest)
    }

    /// The values of the columns in a row.
    pub fn row(&self, row: usize) -> impl Fn(&str) -> f64 + '_ {
        move |column| self.columns.get(column).map_or(f64::NAN, |values| values[row])
    }
}

/// Where a frame is: x, y, cosine and sine of its angle.
pub type Pose = [f64; 4];

/// The pose of the ground.
pub const AT_REST: Pose = [0.0, 0.0, 1.0, 0.0];

/// Finds where the frames of a drawing are, given the value of each column.
pub fn poses(of: &CaseDrawing, value: &dyn Fn(&str) -> f64) -> BTreeMap<&'static str, Pose> {
    let channel = |channel| number(channel, value);
    let mut poses: BTreeMap<&str, Pose> = BTreeMap::new();
    for frame in &of.frames {
        let parent = frame.parent.map_or(AT_REST, |parent| poses[parent]);
        let [x, y] = within(parent, [channel(frame.pose[0]), channel(frame.pose[1])]);
        let (sin, cos) = channel(frame.pose[2]).sin_cos();
        poses.insert(frame.name, [x, y, cos, sin]);
    }
    poses
}

fn number(channel: Channel, value: &dyn Fn(&str) -> f64) -> f64 {
    match channel {
        Channel::Fixed(value) => value,
        Channel::Coordinate(index) => value(&coordinate_column(index)),
        Channel::Column(column, gain, plus) => gain * value(column) + plus,
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A piece of a scene that is seen: how near, its outline or its ball, and how light.
struct Face {
    near: f64,
    points: Vec<[f64; 3]>,
    radius: f64,
    fill: Fill,
    /// A foot, which its body may hide.
    foot: bool,
    off: bool,
    light: f64,
}

/// Finds the faces of bodies in space that look towards the eye, the farthest first, and their shadows.
fn faces(solids: &[Solid], value: &dyn Fn(&str) -> f64) -> (Vec<Face>, Vec<Vec<[f64; 3]>>) {
    let [across, up, towards] = camera();
    let (mut seen, mut shadows) = (Vec::new(), Vec::new());
    for Solid { pose, form, fill, gap } in solids {
        let [x, y, z, yaw, pitch, roll] = pose.map(|channel| number(channel, value));
        let [(sy, cy), (sp, cp), (sr, cr)] = [yaw, pitch, roll].map(f64::sin_cos);
        let rows = [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ];
        let place = |point: &[f64; 3]| [x + dot(rows[0], *point), y + dot(rows[1], *point), z + dot(rows[2], *point)];
        let off = gap.is_some_and(|gap| value(gap) > OFF);
        // Feet are below their body, so behind it.
        let under = if gap.is_some() { 1.0 } else { 0.0 };
        let face = |near: f64, points, radius, light| Face {
            near: near - under,
            points,
            radius,
            fill: *fill,
            foot: gap.is_some(),
            off,
            light,
        };
        match form {
            Form::Hull(corners, faces) => {
                let corners: Vec<_> = corners.iter().map(place).collect();
                let middle = |of: &mut dyn Iterator<Item = [f64; 3]>, n: usize| {
                    of.fold([0.0; 3], |sum: [f64; 3], p| std::array::from_fn(|k| sum[k] + p[k] / n as f64))
                };
                let inside = middle(&mut corners.iter().copied(), corners.len());
                for indices in faces {
                    let points: Vec<_> = indices.iter().map(|&corner| corners[corner]).collect();
                    let centre = middle(&mut points.iter().copied(), points.len());
                    let edge = |k: usize| [0, 1, 2].map(|axis| points[k][axis] - points[0][axis]);
                    let (a, b) = (edge(1), edge(2));
                    let mut normal = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
                    let outward = dot(normal, [0, 1, 2].map(|axis| centre[axis] - inside[axis])).signum();
                    let length = dot(normal, normal).sqrt().max(1e-12);
                    normal = normal.map(|entry| entry * outward / length);
                    // All the same way round, so that they are one area.
                    let mut shadow: Vec<_> = points.iter().map(|p| [p[0], p[1], 0.0]).collect();
                    let turned = normal[2] * outward;
                    if turned < 0.0 {
                        shadow.reverse();
                    }
                    if *fill != Fill::Ground && turned.abs() > 1e-9 {
                        shadows.push(shadow);
                    }
                    if dot(normal, towards) > 0.0 {
                        seen.push(face(
                            dot(centre, towards),
                            points,
                            0.0,
                            0.8 * normal[2].max(0.0) + 0.2 * normal[0].max(0.0),
                        ));
                    }
                }
            }
            Form::Ball(radius) => {
                let rim = (0..24).map(|k| f64::from(k) * std::f64::consts::TAU / 24.0).map(f64::sin_cos);
                shadows.push(rim.map(|(sin, cos)| [x + radius * cos, y + radius * sin, 0.0]).collect());
                seen.push(face(dot([x, y, z], towards), vec![[x, y, z]], *radius, 1.0));
            }
            Form::Rod(from, to, width) => {
                let to = place(to);
                let span = [0, 1, 2].map(|axis| to[axis] - from[axis]);
                let [right, high] = [dot(span, across), dot(span, up)];
                let half = 0.5 * width / right.hypot(high).max(1e-12);
                let beside = |p: [f64; 3], side: f64| {
                    [0, 1, 2].map(|axis| p[axis] + side * half * (right * up[axis] - high * across[axis]))
                };
                let points = vec![beside(*from, -1.0), beside(to, -1.0), beside(to, 1.0), beside(*from, 1.0)];
                seen.push(face(dot(to, towards), points, 0.0, 1.0));
            }
        }
    }
    seen.sort_by(|one, other| one.near.total_cmp(&other.near));
    (seen, shadows)
}

/// A point of a frame, in the world.
pub fn within([px, py, cos, sin]: Pose, [x, y]: [f64; 2]) -> [f64; 2] {
    [px + cos * x - sin * y, py + sin * x + cos * y]
}

/// The rectangles of a cylinder along its axis, rod and barrel: from, to, half a width.
pub fn rod_and_barrel(length: f64, barrel: f64, width: f64) -> [[f64; 3]; 2] {
    [[0.2 * (length - barrel).max(0.0), length, 0.15 * width], [0.0, barrel, 0.5 * width]]
}

/// What is seen of a case, and where on the page.
#[derive(Debug, Clone, Copy)]
pub struct View {
    /// Where on the page.
    pub place: Rect,
    /// Where in the world, along x.
    pub follow: f64,
}

impl View {
    /// Pixels per metre.
    pub fn scale(&self, of: &CaseDrawing) -> f64 {
        let [[left, right], [low, high]] = of.view;
        (self.place.width() / (right - left)).min(self.place.height() / (high - low))
    }

    /// Draws a case, its scheme in a colour; without one, thin outlines of what moves.
    pub fn draw(&self, drawing: &mut Drawing, of: &CaseDrawing, value: &dyn Fn(&str) -> f64, color: Option<Color>) {
        let poses = poses(of, value);
        let scale = self.scale(of);
        let [[left, right], [low, high]] = of.view;
        let middle = self.place.centre();
        let screen = |[x, y]: [f64; 2]| {
            (middle.0 + scale * (x - self.follow - 0.5 * (left + right)), middle.1 - scale * (y - 0.5 * (low + high)))
        };
        let at = |(point, frame): &CasePoint| within(frame.map_or(AT_REST, |frame| poses[frame]), *point);
        let stroke = if color.is_some() { OUTLINE } else { Stroke::solid(Color::INK, 0.7) };
        let fill = |fill: Fill| {
            color.map(|color| match fill {
                Fill::Scheme => color.mix(Color::WHITE, 0.6),
                Fill::Metal => METAL,
                Fill::Ground => GROUND,
            })
        };
        let open = |drawing: &mut Drawing, points: &[Point]| {
            for piece in clip::polyline(points, |_| self.place) {
                drawing.line(piece, stroke);
            }
        };
        // Filled where it is inside, outlined where its edge is.
        let solid = |drawing: &mut Drawing, corners: &[Point], fill: Option<Color>| {
            if corners.iter().all(|corner| self.place.contains(*corner)) {
                return drawing.area(corners.to_vec(), fill, Some(stroke));
            }
            if let Some(fill) = fill {
                drawing.area(clip::polygon(corners, &self.place), Some(fill), None);
            }
            open(drawing, &corners.iter().chain(corners.first()).copied().collect::<Vec<_>>());
        };
        // Along a line from one point to another, and to its left.
        let beside = |from: [f64; 2], to: [f64; 2]| {
            let [across, up] = [to[0] - from[0], to[1] - from[1]];
            let length = across.hypot(up).max(1e-12);
            let point = move |along: f64, aside: f64| {
                [from[0] + (along * across - aside * up) / length, from[1] + (along * up + aside * across) / length]
            };
            (length, point)
        };
        let round = |drawing: &mut Drawing, centre: Point, radius: f64, filling: Fill| {
            if self.place.inset(radius).contains(centre) {
                return drawing.disc(centre, radius, fill(filling), Some(stroke));
            }
            let rim = |k: i32| {
                let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 48.0).sin_cos();
                (centre.0 + radius * cos, centre.1 + radius * sin)
            };
            solid(drawing, &(0..48).map(rim).collect::<Vec<_>>(), fill(filling));
        };
        for shape in &of.shapes {
            if color.is_none()
                && !matches!(shape, Shape::Scene(_) | Shape::Discs(..))
                && shape.points().iter().all(|point| point.1.is_none())
            {
                continue;
            }
            match shape {
                Shape::Scene(solids) => {
                    let [across, up, _] = camera();
                    let project = |point: &[f64; 3]| screen([dot(across, *point), dot(up, *point)]);
                    let (faces, shadows) = faces(solids, value);
                    for shadow in shadows.iter().filter(|_| color.is_some()) {
                        let corners: Vec<Point> = shadow.iter().map(project).collect();
                        drawing.area(clip::polygon(&corners, &self.place), Some(SHADOW), None);
                    }
                    let is_drawn = |face: &Face| color.is_some() || !face.foot;
                    for Face { points, radius, fill: filling, off, light, .. } in faces.into_iter().filter(is_drawn) {
                        let shade =
                            |color: Color| if off { FORCE } else { color.mix(Color::INK, 0.25 * (1.0 - light)) };
                        let corners: Vec<Point> = points.iter().map(project).collect();
                        match *corners.as_slice() {
                            [centre] => drawing.disc(centre, scale * radius, fill(filling).map(shade), Some(stroke)),
                            _ => solid(drawing, &corners, fill(filling).map(shade)),
                        }
                    }
                }
                Shape::Polygon(points, filling) => {
                    let corners: Vec<Point> = points.iter().map(|point| screen(at(point))).collect();
                    solid(drawing, &corners, fill(*filling));
                }
                Shape::Line(points) => {
                    open(drawing, &points.iter().map(|point| screen(at(point))).collect::<Vec<_>>());
                }
                Shape::Disc { at: centre, radius, fill: filling, spoke } => {
                    let (centre, frame) = (screen(at(centre)), centre.1.map_or(AT_REST, |frame| poses[frame]));
                    let radius = scale * radius;
                    round(drawing, centre, radius, *filling);
                    if *spoke {
                        open(drawing, &[centre, (centre.0 + radius * frame[2], centre.1 - radius * frame[3])]);
                    }
                }
                Shape::Discs(centres, radius, filling) => {
                    for centre in centres {
                        round(drawing, screen(centre.map(|channel| number(channel, value))), scale * radius, *filling);
                    }
                }
                Shape::Spring(from, to, width) => {
                    let (length, point) = beside(at(from), at(to));
                    let turn = |k: u32| {
                        let side = if k.is_multiple_of(2) { 0.5 } else { -0.5 };
                        screen(point(length * (0.16 + 0.068 * f64::from(k)), side * width))
                    };
                    let mut zigzag = vec![screen(point(0.0, 0.0)), screen(point(0.12 * length, 0.0))];
                    zigzag.extend((0..11).map(turn));
                    zigzag.extend([screen(point(0.88 * length, 0.0)), screen(point(length, 0.0))]);
                    open(drawing, &zigzag);
                }
                Shape::Cylinder { from, to, barrel, width } => {
                    let (length, point) = beside(at(from), at(to));
                    for [start, end, half] in rod_and_barrel(length, *barrel, *width) {
                        let corners = [[start, -half], [end, -half], [end, half], [start, half]];
                        solid(drawing, &corners.map(|[along, aside]| screen(point(along, aside))), fill(Fill::Metal));
                    }
                }
                Shape::Arrow { column, at: foot, along, scale: per_newton } => {
                    let (longest, size) = (LONGEST * (high - low), value(column) * per_newton);
                    if color.is_some() && size > 0.01 {
                        let (foot, size, heads) = (at(foot), size.min(longest), if size > longest { 2 } else { 1 });
                        let tip = [foot[0] + size * along[0], foot[1] + size * along[1]];
                        if let Some((from, to)) = clip::segment(screen(foot), screen(tip), &self.place.inset(2.0)) {
                            arrow(drawing, from, to, heads);
                        }
                    }
                }
            }
        }
    }
}

/// Draws a force arrow with one or two heads, on a white rim.
pub fn arrow(drawing: &mut Drawing, from: Point, to: Point, heads: usize) {
    let length = (to.0 - from.0).hypot(to.1 - from.1);
    if length < 1.0 {
        return;
    }
    let (ux, uy) = ((to.0 - from.0) / length, (to.1 - from.1) / length);
    let at = |back: f64, side: f64| (to.0 - back * ux - side * uy, to.1 - back * uy + side * ux);
    let head = 7.0_f64.min(0.7 * length);
    drawing.line(vec![from, to], Stroke::solid(Color::WHITE, 4.4));
    drawing.line(vec![from, at(0.8 * head, 0.0)], Stroke::solid(FORCE, 2.0));
    for back in (0..heads).map(|k| k as f64 * 6.0) {
        let triangle = vec![at(back, 0.0), at(back + head, 0.45 * head), at(back + head, -0.45 * head)];
        drawing.area(triangle, Some(FORCE), Some(Stroke::solid(Color::WHITE, 0.6)));
    }
}
