//! One small drawing of the wedge box: ground, actuator, disc, box with wedges, contact forces.

use super::clip::{self, Rect};
use super::drawing::{Anchor, Color, Drawing, Point, Stroke, Text};
use super::hatch::diagonals;
use super::ticks::signed;

/// Lengths of the wedge box, m. Points of the box are in its frame: origin at the centre of mass, x forward, y up.
#[derive(Debug, Clone, PartialEq)]
pub struct WedgeBoxGeometry {
    /// Length of the box.
    pub box_width_m: f64,
    /// Height of the box.
    pub box_height_m: f64,
    /// Tips of the two wedges below the box.
    pub wedge_tips: [(f64, f64); 2],
    /// Radius of the disc.
    pub disc_radius_m: f64,
    /// Where the disc's centre is pinned to the box.
    pub disc_pin: (f64, f64),
    /// Height of the ledge above the floor, y = 0.
    pub ledge_height_m: f64,
    /// World x at which the ledge ends.
    pub ledge_corner_x_m: f64,
    /// Fall per run of the ramp behind the ledge's corner.
    pub ramp_slope: f64,
    /// Where the actuator is attached to the box.
    pub attachment: (f64, f64),
    /// The actuator's pin on the ground, world.
    pub ground_pin: (f64, f64),
}

/// A force on the box or the disc at a contact, world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactForce {
    /// Position of the contact.
    pub x_m: f64,
    /// Height of the contact.
    pub y_m: f64,
    /// Forward component.
    pub fx_n: f64,
    /// Upward component.
    pub fy_n: f64,
}

/// Where everything is at one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Pose {
    /// Time.
    pub time_s: f64,
    /// Centre of mass of the box, world.
    pub box_x_m: f64,
    /// Its height.
    pub box_y_m: f64,
    /// Rotation of the box, counter-clockwise.
    pub box_angle_rad: f64,
    /// Rotation of the disc, counter-clockwise; turns its spoke.
    pub disc_angle_rad: f64,
    /// Forces at the closed contacts.
    pub contact_forces: Vec<ContactForce>,
    /// Force of the actuator, positive if it extends.
    pub actuator_force_n: f64,
}

/// Length of the arrow of the reference force, m.
pub const ARROW_M: f64 = 0.3;
/// Longest arrow, in lengths of the arrow of the reference force.
pub const LONGEST_ARROW: f64 = 2.5;

const BEHIND_M: f64 = 1.32;
const AHEAD_M: f64 = 0.72;
const BELOW_M: f64 = 0.20;
const ABOVE_M: f64 = 1.04;
const CYLINDER_M: f64 = 2.0;
const INK: Stroke = Stroke { color: Color::INK, width: 1.0, dash: &[] };
const EDGE: Stroke = Stroke { color: Color(0xC9, 0xCE, 0xD3), width: 1.0, dash: &[] };
const GROUND: Color = Color(0xEE, 0xF0, 0xF2);
const LEDGE: Color = Color(0xD3, 0xD8, 0xDD);
const METAL: Color = Color(0xF4, 0xF6, 0xF8);
const FORCE: Color = Color(0x7A, 0x1F, 0x7A);

/// The part of the world a drawing shows, and where.
#[derive(Debug, Clone, Copy)]
pub struct View {
    frame: Rect,
    left_m: f64,
    scale: f64,
    /// Metres of arrow per newton.
    arrow_m_per_n: f64,
}

impl View {
    /// Height of a drawing per width.
    pub const ASPECT: f64 = (BELOW_M + ABOVE_M) / (BEHIND_M + AHEAD_M);

    /// Scale of a drawing of a given width.
    pub fn pixels_per_m(width: f64) -> f64 {
        width / (BEHIND_M + AHEAD_M)
    }

    /// Looks at the box of a pose.
    pub fn following(pose: &Pose, frame: Rect, arrow_force_n: f64) -> Self {
        View {
            frame,
            left_m: pose.box_x_m - BEHIND_M,
            scale: View::pixels_per_m(frame.width()),
            arrow_m_per_n: ARROW_M / arrow_force_n,
        }
    }

    fn page(&self, (x, y): (f64, f64)) -> Point {
        (self.frame.left + (x - self.left_m) * self.scale, self.frame.bottom - (y + BELOW_M) * self.scale)
    }

    fn right_m(&self) -> f64 {
        self.left_m + BEHIND_M + AHEAD_M
    }

    /// A filled and outlined polygon of world points, cut at the frame.
    fn solid(&self, drawing: &mut Drawing, world: &[(f64, f64)], fill: Color) {
        let corners: Vec<Point> = world.iter().map(|&point| self.page(point)).collect();
        drawing.area(clip::polygon(&corners, &self.frame), Some(fill), None);
        let ring: Vec<Point> = corners.iter().chain(corners.first()).copied().collect();
        self.outline(drawing, &ring, INK);
    }

    fn outline(&self, drawing: &mut Drawing, points: &[Point], stroke: Stroke) {
        for piece in clip::polyline(points, |_| self.frame) {
            let whole_ring = piece.len() > 3 && piece.first() == piece.last();
            if whole_ring {
                drawing.area(piece[1..].to_vec(), None, Some(stroke));
            } else {
                drawing.line(piece, stroke);
            }
        }
    }
}

/// Draws one pose into its view; `color` tints the box.
pub fn draw(drawing: &mut Drawing, view: &View, geometry: &WedgeBoxGeometry, pose: &Pose, color: Color) {
    if ![pose.box_x_m, pose.box_y_m, pose.box_angle_rad].iter().all(|value| value.is_finite()) {
        let text = Text::new("diverged", view.frame.centre(), 10.0).anchored(Anchor::Middle);
        drawing.text(text.colored(Color::SOFT_INK).centred());
        drawing.area(view.frame.corners(), None, Some(EDGE));
        return;
    }
    ground(drawing, view, geometry);
    actuator(drawing, view, geometry, pose);
    body(drawing, view, geometry, pose, color);
    for force in &pose.contact_forces {
        let newtons = force.fx_n.hypot(force.fy_n);
        let limit = LONGEST_ARROW * ARROW_M / view.arrow_m_per_n;
        if newtons.is_nan() || newtons * view.arrow_m_per_n < 0.01 {
            continue;
        }
        let metres = view.arrow_m_per_n * newtons.min(limit) / newtons;
        let tip = (force.x_m + metres * force.fx_n, force.y_m + metres * force.fy_n);
        let (from, to) = (view.page((force.x_m, force.y_m)), view.page(tip));
        if let Some((from, to)) = clip::segment(from, to, &view.frame.inset(2.0)) {
            arrow(drawing, from, to, if newtons > limit { 2 } else { 1 });
        }
    }
    magnifiers(drawing, view, geometry, pose, color);
    drawing.area(view.frame.corners(), None, Some(EDGE));
}

fn ground(drawing: &mut Drawing, view: &View, geometry: &WedgeBoxGeometry) {
    let (left, right) = (view.left_m, view.right_m());
    drawing.area(view.frame.corners(), Some(Color(0xFC, 0xFD, 0xFE)), None);
    let floor = view.page((left, 0.0)).1;
    let below = Rect { top: floor, ..view.frame };
    drawing.area(below.corners(), Some(GROUND), None);
    let strip = Rect { top: floor, bottom: floor + 6.0, ..view.frame };
    for (from, to) in diagonals(&strip, 6.0) {
        drawing.line(vec![from, to], Stroke::solid(Color(0xA8, 0xAF, 0xB6), 0.8));
    }
    let (corner, height) = (geometry.ledge_corner_x_m, geometry.ledge_height_m);
    let toe = corner + height / geometry.ramp_slope;
    let ledge = [(left - 1.0, 0.0), (left - 1.0, height), (corner, height), (toe, 0.0)];
    let corners: Vec<Point> = ledge.iter().map(|&point| view.page(point)).collect();
    drawing.area(clip::polygon(&corners, &view.frame), Some(LEDGE), None);
    let surface = [(left - 1.0, height), (corner, height), (toe.max(left), 0.0)].map(|point| view.page(point));
    if toe > left {
        view.outline(drawing, &surface, Stroke::solid(Color::SOFT_INK, 1.2));
    }
    view.outline(drawing, &[view.page((left, 0.0)), view.page((right, 0.0))], INK);
}

fn actuator(drawing: &mut Drawing, view: &View, geometry: &WedgeBoxGeometry, pose: &Pose) {
    let (from, to) = (geometry.ground_pin, pose.world(geometry.attachment));
    let length = (to.0 - from.0).hypot(to.1 - from.1);
    if length <= 0.0 || !length.is_finite() {
        return;
    }
    let (ux, uy) = ((to.0 - from.0) / length, (to.1 - from.1) / length);
    let along = |distance: f64, side: f64| (from.0 + distance * ux - side * uy, from.1 + distance * uy + side * ux);
    let bar = |start: f64, end: f64, half: f64| {
        [along(start, -half), along(end, -half), along(end, half), along(start, half)]
    };
    let cylinder = CYLINDER_M.min(0.9 * length);
    view.solid(drawing, &bar(cylinder, length, 0.012), METAL);
    view.solid(drawing, &bar(0.0, cylinder, 0.045), METAL);
    view.solid(drawing, &bar(cylinder - 0.03, cylinder, 0.052), LEDGE);

    // The ground pin is out of view: a zigzag at the edge says that the actuator goes on.
    let (x, y) = view.page(along((view.left_m - from.0) / ux, 0.0));
    let half = 0.085 * view.scale;
    let edge_in_view = (view.frame.top + half..view.frame.bottom - half).contains(&y);
    if from.0 < view.left_m && edge_in_view {
        let zigzag = |shift: f64| {
            let turns = [(0.0, -1.0), (3.5, -0.33), (0.0, 0.33), (3.5, 1.0)];
            turns.map(|(across, up)| (x + 4.0 + shift + across, y + up * half)).to_vec()
        };
        let (first, second) = (zigzag(0.0), zigzag(4.0));
        let gap = first.iter().chain(second.iter().rev()).copied().collect();
        drawing.area(gap, Some(Color::WHITE), None);
        drawing.line(first, Stroke::solid(Color::INK, 1.0));
        drawing.line(second, Stroke::solid(Color::INK, 1.0));
    }
    let above = view.page((view.left_m, to.1.max(from.1) + 0.115)).1.clamp(view.frame.top + 11.0, view.frame.bottom);
    let force = signed(format!("{:.2}", pose.actuator_force_n / 1000.0));
    let plus = if pose.actuator_force_n >= 5.0 { "+" } else { "" };
    drawing.text(Text::new(format!("F = {plus}{force} kN"), (view.frame.left + 5.0, above), 9.4));
}

fn body(drawing: &mut Drawing, view: &View, geometry: &WedgeBoxGeometry, pose: &Pose, color: Color) {
    let tint = color.mix(Color::WHITE, 0.72);
    let dark = color.mix(Color::WHITE, 0.45);
    let (half_width, half_height) = (0.5 * geometry.box_width_m, 0.5 * geometry.box_height_m);
    let on_box = |points: &[(f64, f64)]| points.iter().map(|&point| pose.world(point)).collect::<Vec<_>>();

    let pin = geometry.disc_pin;
    let link = on_box(&[
        (-half_width, pin.1 + 0.14),
        (pin.0, pin.1 + 0.03),
        (pin.0, pin.1 - 0.03),
        (-half_width, pin.1 - 0.05),
    ]);
    disc(drawing, view, pose.world(pin), geometry.disc_radius_m, pose.disc_angle_rad);
    view.solid(drawing, &link, dark);
    joint(drawing, view, pose.world(pin));

    for tip in geometry.wedge_tips {
        view.solid(drawing, &on_box(&[(tip.0 - 0.1, -half_height), tip, (tip.0 + 0.1, -half_height)]), dark);
    }
    let corners = [
        (-half_width, -half_height),
        (half_width, -half_height),
        (half_width, half_height),
        (-half_width, half_height),
    ];
    view.solid(drawing, &on_box(&corners), tint);
    centre_of_mass(drawing, view, pose);
    joint(drawing, view, pose.world(geometry.attachment));
}

fn disc(drawing: &mut Drawing, view: &View, centre: (f64, f64), radius: f64, angle: f64) {
    let rim = |k: i32| {
        let around = angle + f64::from(k) * std::f64::consts::TAU / 48.0;
        (centre.0 + radius * around.cos(), centre.1 + radius * around.sin())
    };
    view.solid(drawing, &(0..48).map(rim).collect::<Vec<_>>(), METAL);
    let spoke = [centre, rim(12)].map(|point| view.page(point));
    view.outline(drawing, &spoke, Stroke::solid(Color::SOFT_INK, 1.4));
}

fn joint(drawing: &mut Drawing, view: &View, world: (f64, f64)) {
    let at = view.page(world);
    if view.frame.inset(4.0).contains(at) {
        drawing.disc(at, 2.6, Some(Color::WHITE), Some(INK));
    }
}

/// The usual sign: a circle with two opposite quarters filled.
fn centre_of_mass(drawing: &mut Drawing, view: &View, pose: &Pose) {
    let at = view.page((pose.box_x_m, pose.box_y_m));
    let radius = 4.5;
    if !view.frame.inset(radius).contains(at) {
        return;
    }
    drawing.disc(at, radius, Some(Color::WHITE), None);
    for first in [0.0, 180.0] {
        let around = |k: i32| f64::to_radians(first + 15.0 * f64::from(k)) - pose.box_angle_rad;
        let arc = (0..=6).map(|k| (at.0 + radius * around(k).cos(), at.1 + radius * around(k).sin()));
        drawing.area(std::iter::once(at).chain(arc).collect(), Some(Color::INK), None);
    }
    drawing.disc(at, radius, None, Some(Stroke::solid(Color::INK, 1.0)));
}

/// Height of the strip with the magnifiers below a drawing, px.
pub const STRIP: f64 = 2.0 * LENS + 18.0;
/// Radius of a magnifier, px.
const LENS: f64 = 17.0;
/// How many times a magnifier magnifies.
pub const MAGNIFIED: f64 = 25.0;

/// Draws a magnifier for each wedge's tip below the drawing, with its height above the floor; a tip in the air stands out. A jump of
/// millimetres is invisible in the drawing itself.
fn magnifiers(drawing: &mut Drawing, view: &View, geometry: &WedgeBoxGeometry, pose: &Pose, color: Color) {
    let floor = view.frame.bottom + 4.0 + LENS + 8.0;
    for tip in geometry.wedge_tips {
        let (x, y) = pose.world(tip);
        let across = view.page((x, 0.0)).0.clamp(view.frame.left + LENS + 3.0, view.frame.right - LENS - 3.0);
        drawing.disc((across, floor - 8.0), LENS, Some(Color::WHITE), Some(EDGE));
        let height = (y * MAGNIFIED * view.scale).max(-5.0);
        // The lower part of the tip that is still inside.
        let inside = 20.0 - height;
        if inside > 0.0 {
            let half = 0.55 * inside.min(14.0);
            let top = floor - height - inside.min(14.0);
            let corners = vec![(across, floor - height), (across - half, top), (across + half, top)];
            drawing.area(corners, Some(color.mix(Color::WHITE, 0.45)), Some(Stroke::solid(Color::INK, 0.9)));
        }
        drawing.line(vec![(across - 14.0, floor), (across + 14.0, floor)], INK);
        let millimetres = 1000.0 * y;
        let plus = if millimetres >= 0.05 { "+" } else { "" };
        let at = (across, view.frame.bottom + STRIP - 3.0);
        let text = Text::new(format!("{plus}{} mm", signed(format!("{millimetres:.1}"))), at, 9.4);
        let text = text.anchored(Anchor::Middle);
        drawing.text(if millimetres.abs() >= 0.5 { text.bold() } else { text.colored(Color::SOFT_INK) });
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
    let shaft = vec![from, at(0.8 * head, 0.0)];
    drawing.line(vec![from, to], Stroke::solid(Color::WHITE, 4.4));
    drawing.line(shaft, Stroke::solid(FORCE, 2.0));
    for k in 0..heads {
        let back = k as f64 * 6.0;
        let triangle = vec![at(back, 0.0), at(back + head, 0.45 * head), at(back + head, -0.45 * head)];
        drawing.area(triangle, Some(FORCE), Some(Stroke::solid(Color::WHITE, 0.6)));
    }
}
