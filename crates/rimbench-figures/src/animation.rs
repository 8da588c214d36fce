//! The wedge box in motion, as an SVG that a page embeds like any image: movement by CSS alone, no script, one file for light and
//! one for dark pages. Readers who ask for less motion get the decisive instant as a still.

use super::drawing::Color;
use super::manoeuvre::{Pose, WedgeBoxGeometry};
use super::ticks::signed;
use super::vector::escaped;
use std::fmt::Write;

/// Page that the picture stands on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Page {
    /// White.
    Light,
    /// Nearly black.
    Dark,
}

/// Colours of a page.
struct Palette {
    paper: Color,
    ink: Color,
    soft: Color,
    ground: Color,
    ledge: Color,
    metal: Color,
    force: Color,
}

impl Page {
    /// What its file name ends in.
    pub fn name(self) -> &'static str {
        match self {
            Page::Light => "light",
            Page::Dark => "dark",
        }
    }

    fn palette(self) -> Palette {
        match self {
            Page::Light => Palette {
                paper: Color::WHITE,
                ink: Color::INK,
                soft: Color::SOFT_INK,
                ground: Color(0xEE, 0xF0, 0xF2),
                ledge: Color(0xD3, 0xD8, 0xDD),
                metal: Color(0xF4, 0xF6, 0xF8),
                force: Color(0x7A, 0x1F, 0x7A),
            },
            Page::Dark => Palette {
                paper: Color(0x0D, 0x11, 0x17),
                ink: Color(0xE6, 0xE9, 0xED),
                soft: Color(0xA3, 0xAA, 0xB3),
                ground: Color(0x1C, 0x21, 0x29),
                ledge: Color(0x36, 0x3D, 0x47),
                metal: Color(0x26, 0x2C, 0x35),
                force: Color(0xE3, 0x8F, 0xE3),
            },
        }
    }

    /// A scheme's colour on it.
    fn of(self, color: Color) -> Color {
        match self {
            Page::Light => color,
            Page::Dark => color.mix(Color::WHITE, 0.35),
        }
    }
}

/// One scheme in motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Moving {
    /// What stands above it.
    pub label: String,
    /// Its colour.
    pub color: Color,
    /// Its poses over time, ascending; each with the same contacts in the same order, those that are open with no force.
    pub poses: Vec<Pose>,
}

/// A curve below the drawings.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Its colour; none is that of the page's ink.
    pub color: Option<Color>,
    /// Time, s, and force, N.
    pub points: Vec<(f64, f64)>,
}

/// The whole picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Animation {
    /// What a screen reader says.
    pub title: String,
    /// Lengths.
    pub geometry: WedgeBoxGeometry,
    /// From when to when, s.
    pub shown_s: [f64; 2],
    /// The part of it that plays slowly, s.
    pub slow_s: [f64; 2],
    /// The instant of the still, s.
    pub still_s: f64,
    /// Schemes, side by side.
    pub schemes: Vec<Moving>,
    /// Curves, the first at the back.
    pub curves: Vec<Curve>,
    /// Interval of the force shown, N.
    pub force_n: [f64; 2],
}

const WIDTH: f64 = 760.0;
const MARGIN: f64 = 8.0;
const HEADER: f64 = 24.0;
/// What of the world a drawing shows around the box, m.
const BEHIND_M: f64 = 1.32;
const AHEAD_M: f64 = 0.72;
const BELOW_M: f64 = 0.12;
const ABOVE_M: f64 = 0.96;
/// Radius of a magnifier, px.
const LENS: f64 = 25.0;
/// How many times larger a magnifier shows heights than they are, m to m.
const MAGNIFIED: f64 = 25.0;
/// Height of the curves, px.
const CHART: f64 = 92.0;
/// Height of the key below them, px.
const KEY: f64 = 20.0;
/// Seconds of playing per second outside and inside the slow part, and the rest at the end.
const PACE: [f64; 2] = [1.6, 14.0];
const REST_S: f64 = 1.2;
/// Contact force of an arrow of its full size, N.
const FULL_FORCE_N: f64 = 4000.0;
/// Positions closer than this to the line between keyframes need none of their own, px or degrees.
const SLACK: f64 = 0.06;

/// State of one moving part: translation, px, and a turn, degrees, or a scale.
type State = [f64; 3];

impl Animation {
    /// Writes the picture for one kind of page.
    pub fn svg(&self, page: Page) -> String {
        let palette = page.palette();
        let cell = (WIDTH - 2.0 * MARGIN - 12.0) / 2.0;
        let scale = cell / (BEHIND_M + AHEAD_M);
        let (top, drawing) = (HEADER, (BELOW_M + ABOVE_M) * scale);
        let lenses = top + drawing + 6.0;
        let chart = lenses + 2.0 * LENS + 26.0;
        let height = chart + CHART + 20.0 + KEY;
        let (mut style, mut body) = (String::new(), String::new());
        for (index, scheme) in self.schemes.iter().take(2).enumerate() {
            let left = MARGIN + index as f64 * (cell + 12.0);
            let stage = Stage { left, top, cell, drawing, scale, lenses, page, index };
            self.scheme(&stage, scheme, &palette, &mut style, &mut body);
        }
        self.chart(chart, page, &palette, &mut style, &mut body);
        self.key(chart + CHART + 20.0 + 0.4 * KEY, page, &palette, &mut body);
        let moving: String = style;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height:.0}\" viewBox=\"0 0 {WIDTH} {height:.0}\" role=\"img\" \
             font-family=\"sans-serif\" font-size=\"12\" stroke-linejoin=\"round\">\n<title>{}</title>\n<style>{moving}</style>\n\
             <rect width=\"{WIDTH}\" height=\"{height:.0}\" rx=\"6\" fill=\"{}\"/>\n{body}</svg>\n",
            escaped(&self.title),
            hex(palette.paper),
        )
    }

    /// What the curves and the arrows are, and what the strip leaves out.
    fn key(&self, y: f64, page: Page, palette: &Palette, body: &mut String) {
        let soft = hex(palette.soft);
        let mut x = MARGIN;
        let mut entry = |sample: String, words: &str| {
            let _ = writeln!(
                body,
                "{sample}<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"11\" fill=\"{soft}\">{}</text>",
                x + 22.0,
                y + 4.0,
                escaped(words),
            );
            // Some other typeface may be wider than ours.
            x += 22.0 + 1.1 * super::font::width(words, 11.0, super::drawing::Weight::Regular) + 14.0;
            x
        };
        let line = |x: f64, color: Color| {
            format!("<path stroke=\"{}\" stroke-width=\"1.6\" d=\"M{x:.1} {y:.1}h16\"/>", hex(color))
        };
        let mut at = MARGIN;
        if self.curves.iter().any(|curve| curve.color.is_none()) {
            at = entry(line(at, palette.ink), "reference");
        }
        for scheme in self.schemes.iter().take(2) {
            at = entry(line(at, page.of(scheme.color)), &scheme.label);
        }
        if self.schemes.iter().any(|scheme| self.shown(&scheme.poses).any(|pose| !pose.contact_forces.is_empty())) {
            let arrow = format!(
                "<path fill=\"{}\" d=\"M{:.1} {:.1}v-9h-2.5l4-7l4 7h-2.5v9z\"/>",
                hex(palette.force),
                at + 6.5,
                y + 7.0
            );
            at = entry(arrow, "contact force");
        }
        let [low, high] = self.force_n;
        let (from, to) = (self.shown_s[0], self.shown_s[1]);
        let largest = self.curves.iter().flat_map(|curve| &curve.points);
        let largest = largest.filter(|(t, force)| (from..=to).contains(t) && force.is_finite());
        let largest = largest
            .fold(0.0_f64, |most, (_, force)| if (low..=high).contains(force) { most } else { most.max(force.abs()) });
        if largest > 0.0 {
            let ends = match low == -high {
                true => format!("±{:.0}", high / 1000.0),
                false => format!(
                    "{} and {}",
                    signed(format!("{:.0}", low / 1000.0)),
                    signed(format!("{:.0}", high / 1000.0))
                ),
            };
            let words = format!("cut off at {ends} kN: the largest is {:.0} kN", largest / 1000.0);
            let _ = writeln!(
                body,
                "<text x=\"{at:.1}\" y=\"{:.1}\" font-size=\"11\" fill=\"{soft}\">{words}</text>",
                y + 4.0
            );
        }
    }

    /// Duration of one round, s.
    fn round_s(&self) -> f64 {
        self.played(self.shown_s[1]) + REST_S
    }

    /// When an instant is shown, s after the start of a round.
    fn played(&self, t: f64) -> f64 {
        let [from, to] = self.shown_s;
        let slow = self.slow_s.map(|end| end.clamp(from, to));
        let t = t.clamp(from, to);
        let inside = (t.min(slow[1]) - slow[0]).max(0.0);
        (t - from - inside) * PACE[0] + inside * PACE[1]
    }

    /// The poses that are shown.
    fn shown<'a>(&self, poses: &'a [Pose]) -> impl Iterator<Item = &'a Pose> {
        let [from, to] = self.shown_s;
        poses.iter().filter(move |pose| (from - 1e-9..=to + 1e-9).contains(&pose.time_s))
    }

    /// A rule that moves a class through its states, and the still that it starts from. Returns the attributes of what moves: its class,
    /// and the still for a reader that applies no style sheet.
    fn moved(&self, name: &str, states: &[(f64, State)], turns: bool, style: &mut String) -> String {
        let written = |state: &State, [px, deg]: [&str; 2]| {
            let [x, y, third] = state.map(|value| round(value, 100.0));
            match turns {
                true => format!("translate({x}{px},{y}{px}) rotate({third}{deg})"),
                false => format!("translate({x}{px},{y}{px}) scale({third})"),
            }
        };
        // An attribute takes numbers only, a style sheet wants units.
        let (bare, units) = (["", ""], ["px", "deg"]);
        let still = states.iter().min_by(|a, b| (a.0 - self.still_s).abs().total_cmp(&(b.0 - self.still_s).abs()));
        let Some((_, still)) = still else { return format!("class=\"{name}\"") };
        let round_s = self.round_s();
        let timed: Vec<(f64, State)> = states.iter().map(|(t, state)| (self.played(*t) / round_s, *state)).collect();
        let mut frames = String::new();
        let kept = thinned(&timed);
        for (index, (share, state)) in kept.iter().enumerate() {
            let share = round(100.0 * share, 100.0);
            let last = if index + 1 == kept.len() { ",100%" } else { "" };
            let _ = write!(frames, "{share}%{last}{{transform:{}}}", written(state, units));
        }
        let _ = writeln!(
            style,
            ".{name}{{transform:{}}}@keyframes {name}{{{frames}}}\
             @media(prefers-reduced-motion:no-preference){{.{name}{{animation:{name} {:.2}s linear infinite}}}}",
            written(still, units),
            round_s,
        );
        format!("class=\"{name}\" transform=\"{}\"", written(still, bare))
    }

    fn scheme(&self, stage: &Stage, scheme: &Moving, palette: &Palette, style: &mut String, body: &mut String) {
        let Stage { left, top, cell, drawing, scale, page, index, .. } = *stage;
        let geometry = &self.geometry;
        let color = page.of(scheme.color);
        let (tint, dark) = (color.mix(palette.paper, 0.68), color.mix(palette.paper, 0.35));
        let (ink, soft) = (hex(palette.ink), hex(palette.soft));
        let poses: Vec<&Pose> = self.shown(&scheme.poses).collect();
        let Some(first) = poses.first() else { return };
        let floor = top + drawing - BELOW_M * scale;
        // The camera follows the box: it stays where it is, and the ground passes below.
        let place = |pose: &Pose, (x, y): (f64, f64)| (left + (x - pose.box_x_m + BEHIND_M) * scale, floor - y * scale);
        let name = |part: &str| format!("{part}{index}");
        let states =
            |state: &dyn Fn(&Pose) -> State| poses.iter().map(|pose| (pose.time_s, state(pose))).collect::<Vec<_>>();

        let _ = write!(
            body,
            "<text x=\"{left}\" y=\"16\" font-size=\"13\" font-weight=\"600\" fill=\"{}\">{}</text>\n\
             <clipPath id=\"view{index}\"><rect x=\"{left}\" y=\"{top}\" width=\"{cell:.1}\" height=\"{drawing:.1}\"/></clipPath>\n\
             <g clip-path=\"url(#view{index})\" stroke=\"{ink}\" stroke-width=\"1\">\n",
            hex(color),
            escaped(&scheme.label),
        );
        // Ground and ledge in world coordinates of the first pose.
        let (corner, rise) = (geometry.ledge_corner_x_m, geometry.ledge_height_m);
        let toe = corner + rise / geometry.ramp_slope;
        let ledge = [(corner - 6.0, 0.0), (corner - 6.0, rise), (corner, rise), (toe, 0.0)];
        let ledge = ledge.map(|point| place(first, point));
        let hatch: String =
            (-90..90).map(|k| format!("M{:.1} {:.1}l-6 8", left + 0.5 * cell + 14.0 * f64::from(k), floor)).collect();
        let ground =
            self.moved(&name("g"), &states(&|pose| [(first.box_x_m - pose.box_x_m) * scale, 0.0, 0.0]), true, style);
        let _ = write!(
            body,
            "<path fill=\"{}\" stroke=\"none\" d=\"M{left} {floor:.1}h{cell:.1}v99h-{cell:.1}z\"/>\n\
             <g {ground}><path fill=\"{}\" d=\"{}\"/><path stroke=\"{soft}\" d=\"{hatch}\"/></g>\n\
             <path d=\"M{left} {floor:.1}h{cell:.1}\"/>\n",
            hex(palette.ground),
            hex(palette.ledge),
            polygon(&ledge),
        );
        // The rod goes on to its pin far behind the view.
        let rod = |pose: &Pose| {
            let (tip, pin) = (pose.world(geometry.attachment), geometry.ground_pin);
            let at = place(pose, tip);
            [at.0, at.1, -(tip.1 - pin.1).atan2(tip.0 - pin.0).to_degrees()]
        };
        let moving = self.moved(&name("r"), &states(&rod), true, style);
        let _ = writeln!(body, "<g {moving}><path fill=\"{}\" d=\"M-600-2.2H0v4.4H-600z\"/></g>", hex(palette.metal));
        // Box, wedges and disc in the frame of the box.
        let own = |(x, y): (f64, f64)| (x * scale, -y * scale);
        let (half_width, half_height) = (0.5 * geometry.box_width_m, 0.5 * geometry.box_height_m);
        let pin = geometry.disc_pin;
        let link =
            [(-half_width, pin.1 + 0.14), (pin.0, pin.1 + 0.03), (pin.0, pin.1 - 0.03), (-half_width, pin.1 - 0.05)];
        let wedges: String = geometry
            .wedge_tips
            .iter()
            .map(|tip| polygon(&[(tip.0 - 0.1, -half_height), *tip, (tip.0 + 0.1, -half_height)].map(own)))
            .collect();
        let corners = [
            (-half_width, -half_height),
            (half_width, -half_height),
            (half_width, half_height),
            (-half_width, half_height),
        ];
        let (disc, attachment) = (own(pin), own(geometry.attachment));
        let at = |pose: &Pose| {
            let (x, y) = place(pose, (pose.box_x_m, pose.box_y_m));
            [x, y, -pose.box_angle_rad.to_degrees()]
        };
        let moving = self.moved(&name("b"), &states(&at), true, style);
        let _ = writeln!(
            body,
            "<g {moving}><circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{:.1}\" fill=\"{}\"/><path fill=\"{}\" d=\"{}{wedges}\"/>\
             <path fill=\"{}\" d=\"{}\"/><g fill=\"{}\"><circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3\"/><circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3\"/></g></g>",
            disc.0,
            disc.1,
            geometry.disc_radius_m * scale,
            hex(palette.metal),
            hex(dark),
            polygon(&link.map(own)),
            hex(tint),
            polygon(&corners.map(own)),
            hex(palette.paper),
            disc.0,
            disc.1,
            attachment.0,
            attachment.1,
        );
        // Forces at the contacts: arrows whose size is the force.
        for contact in 0..first.contact_forces.len() {
            let arrow = |pose: &Pose| {
                let force = &pose.contact_forces[contact.min(pose.contact_forces.len() - 1)];
                let (x, y) = place(pose, (force.x_m, force.y_m));
                let size = force.fx_n.hypot(force.fy_n) / FULL_FORCE_N;
                [x, y, if size.is_finite() { size.min(1.6) } else { 0.0 }]
            };
            let moving = self.moved(&format!("f{index}{contact}"), &states(&arrow), false, style);
            let _ = writeln!(
                body,
                "<g {moving}><path fill=\"{}\" stroke=\"{}\" stroke-width=\".8\" d=\"M-3.5 0V-78H-12L0-108L12-78H3.5V0z\"/></g>",
                hex(palette.force),
                hex(palette.paper),
            );
        }
        let _ = writeln!(
            body,
            "</g><rect x=\"{left}\" y=\"{top}\" width=\"{cell:.1}\" height=\"{drawing:.1}\" fill=\"none\" stroke=\"{}\"/>",
            hex(palette.ledge)
        );
        self.lenses(stage, &poses, dark, palette, style, body);
    }

    /// A magnifier for each wedge's tip, with the height of 4 mm marked.
    fn lenses(
        &self,
        stage: &Stage,
        poses: &[&Pose],
        fill: Color,
        palette: &Palette,
        style: &mut String,
        body: &mut String,
    ) {
        let Stage { left, scale, lenses, index, .. } = *stage;
        let middle = lenses + LENS;
        let floor = middle + 0.45 * LENS;
        let mark = floor - 4e-3 * MAGNIFIED * scale;
        let (ink, soft) = (hex(palette.ink), hex(palette.soft));
        for (wedge, tip) in self.geometry.wedge_tips.iter().enumerate() {
            let across = left + (BEHIND_M + tip.0) * scale;
            let name = format!("t{index}{wedge}");
            let states: Vec<(f64, State)> = poses
                .iter()
                .map(|pose| {
                    // A tip that has left the magnifier upwards stays just outside.
                    let up = (pose.world(*tip).1 * MAGNIFIED * scale).clamp(-5.0, 3.0 * LENS);
                    (pose.time_s, [across, floor - up, 0.0])
                })
                .collect();
            let moving = self.moved(&name, &states, true, style);
            let id = format!("lens{index}{wedge}");
            let _ = write!(
                body,
                "<clipPath id=\"{id}\"><circle cx=\"{across:.1}\" cy=\"{middle:.1}\" r=\"{LENS}\"/></clipPath>\
                 <g clip-path=\"url(#{id})\"><circle cx=\"{across:.1}\" cy=\"{middle:.1}\" r=\"{LENS}\" fill=\"{}\"/>\
                 <path stroke=\"{soft}\" stroke-dasharray=\"2 2\" d=\"M{:.1} {mark:.1}h{}\"/>\
                 <g {moving}><path fill=\"{}\" stroke=\"{ink}\" d=\"M0 0L-30-64H30z\"/></g>\
                 <path stroke=\"{ink}\" d=\"M{:.1} {floor:.1}h{}\"/></g>\
                 <circle cx=\"{across:.1}\" cy=\"{middle:.1}\" r=\"{LENS}\" fill=\"none\" stroke=\"{}\"/>\n\
                 <text x=\"{:.1}\" y=\"{:.1}\" font-size=\"11\" fill=\"{soft}\">4 mm</text>\n",
                hex(palette.paper),
                across - LENS,
                2.0 * LENS,
                hex(fill),
                across - LENS,
                2.0 * LENS,
                hex(palette.ledge),
                across + LENS + 4.0,
                mark + 4.0,
            );
        }
    }

    /// The force over time with the cursor of the drawings.
    fn chart(&self, top: f64, page: Page, palette: &Palette, style: &mut String, body: &mut String) {
        let (left, right) = (MARGIN + 44.0, WIDTH - MARGIN - 4.0);
        let [from, to] = self.shown_s;
        let [low, high] = self.force_n;
        let across = |t: f64| left + (t - from) / (to - from) * (right - left);
        let up = |force: f64| top + CHART - (force - low) / (high - low) * CHART;
        let (ink, soft) = (hex(palette.ink), hex(palette.soft));
        let _ = write!(
            body,
            "<clipPath id=\"chart\"><rect x=\"{left}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{CHART}\"/></clipPath>\n\
             <text x=\"{MARGIN}\" y=\"{:.1}\" font-size=\"11\" fill=\"{soft}\">force of the actuator (kN) over time (s); slow motion around touch-down</text>\n",
            right - left,
            top - 7.0,
        );
        let body_of_ticks: String = [low, 0.0, high]
            .iter()
            .map(|&force| {
                let y = up(force);
                let label = signed(format!("{:.0}", force / 1000.0));
                format!(
                    "<path stroke=\"{}\" d=\"M{left} {y:.1}H{right}\"/><text x=\"{:.1}\" y=\"{:.1}\" font-size=\"11\" text-anchor=\"end\" fill=\"{soft}\">{label}</text>\n",
                    hex(palette.ledge),
                    left - 5.0,
                    y + 4.0
                )
            })
            .collect();
        body.push_str(&body_of_ticks);
        for k in 0..=((to - from) / 0.2 + 1e-9) as usize {
            let t = from + 0.2 * k as f64;
            let _ = writeln!(
                body,
                "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"11\" text-anchor=\"middle\" fill=\"{soft}\">{t:.1}</text>",
                across(t),
                top + CHART + 14.0
            );
        }
        let _ = writeln!(body, "<g clip-path=\"url(#chart)\" fill=\"none\" stroke-width=\"1.6\">");
        for curve in &self.curves {
            let color = curve.color.map_or(palette.ink, |color| page.of(color));
            let shown = curve.points.iter().filter(|(t, force)| (from..=to).contains(t) && force.is_finite());
            let points: Vec<(f64, f64)> =
                shown.map(|&(t, force)| (across(t), up(force).clamp(top - 50.0, top + CHART + 50.0))).collect();
            let _ = writeln!(body, "<path stroke=\"{}\" d=\"{}\"/>", hex(color), line(&thin_line(&points)));
        }
        body.push_str("</g>\n");
        let instants: Vec<f64> = self
            .schemes
            .first()
            .map_or_else(Vec::new, |scheme| self.shown(&scheme.poses).map(|pose| pose.time_s).collect());
        let states: Vec<(f64, State)> = instants.iter().map(|&t| (t, [across(t), 0.0, 0.0])).collect();
        let moving = self.moved("cursor", &states, true, style);
        let _ =
            writeln!(body, "<g {moving}><path stroke=\"{ink}\" stroke-width=\"1.4\" d=\"M0 {top:.1}v{CHART}\"/></g>");
    }
}

/// Where one scheme is drawn.
#[derive(Debug, Clone, Copy)]
struct Stage {
    left: f64,
    top: f64,
    cell: f64,
    drawing: f64,
    scale: f64,
    lenses: f64,
    page: Page,
    index: usize,
}

/// Drops the states that lie on the line between those kept.
fn thinned(states: &[(f64, State)]) -> Vec<(f64, State)> {
    let mut kept: Vec<(f64, State)> = Vec::new();
    let mut start = 0;
    for end in 2..=states.len() {
        let beyond = end == states.len();
        let straight = !beyond && {
            let ((t0, from), (t1, to)) = (states[start], states[end]);
            states[start + 1..end].iter().all(|(t, state)| {
                let share = if t1 > t0 { (t - t0) / (t1 - t0) } else { 0.0 };
                (0..3).all(|k| {
                    (from[k] + share * (to[k] - from[k]) - state[k]).abs() <= if k == 2 { SLACK * 0.2 } else { SLACK }
                })
            })
        };
        if start == 0 && kept.is_empty() {
            kept.extend(states.first());
        }
        if !straight {
            kept.push(states[end - 1]);
            start = end - 1;
        }
    }
    if states.len() < 2 {
        kept = states.to_vec();
    }
    kept
}

/// Drops points of a curve that nobody sees.
fn thin_line(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let states: Vec<(f64, State)> = points.iter().map(|&(x, y)| (x, [0.0, y, 0.0])).collect();
    thinned(&states).into_iter().map(|(x, [_, y, _])| (x, y)).collect()
}

fn polygon(corners: &[(f64, f64)]) -> String {
    line(corners) + "z"
}

fn line(points: &[(f64, f64)]) -> String {
    let mut path = String::new();
    for (index, (x, y)) in points.iter().enumerate() {
        let _ = write!(path, "{}{} {}", if index == 0 { "M" } else { "L" }, round(*x, 10.0), round(*y, 10.0));
    }
    path
}

/// A number on a grid, without a negative zero.
fn round(value: f64, grid: f64) -> f64 {
    (value * grid).round() / grid + 0.0
}

fn hex(Color(red, green, blue): Color) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(t: f64) -> Pose {
        Pose {
            time_s: t,
            box_x_m: 0.3 * t,
            box_y_m: 0.4 + if t > 1.7 { 4e-3 } else { 0.0 },
            box_angle_rad: 0.0,
            disc_angle_rad: 0.0,
            contact_forces: Vec::new(),
            actuator_force_n: 100.0,
        }
    }

    fn animation() -> Animation {
        let poses: Vec<Pose> = (0..=400).map(|k| pose(f64::from(k) * 5e-3)).collect();
        let scheme = |label: &str| Moving { label: label.to_owned(), color: Color(200, 80, 0), poses: poses.clone() };
        Animation {
            title: "a < b".to_owned(),
            geometry: WedgeBoxGeometry::default(),
            shown_s: [1.0, 2.0],
            slow_s: [1.6, 1.8],
            still_s: 1.75,
            schemes: vec![scheme("one"), scheme("two")],
            curves: vec![Curve { color: None, points: poses.iter().map(|pose| (pose.time_s, 100.0)).collect() }],
            force_n: [-2000.0, 2000.0],
        }
    }

    #[test]
    fn it_moves_without_a_script_stands_still_for_those_who_ask_and_asks_for_no_other_file() {
        for page in [Page::Light, Page::Dark] {
            let svg = animation().svg(page);
            assert!(svg.contains("<title>a &lt; b</title>") && !svg.contains("<script") && !svg.contains("href"));
            assert!(!svg.contains("NaN") && !svg.contains("inf,"), "{svg}");
            // Nothing moves but where motion is welcome, and the still is the state that everything else starts from.
            let rules = svg.matches("@keyframes").count();
            assert!(
                rules > 6 && svg.matches("@media(prefers-reduced-motion:no-preference)").count() == rules,
                "{rules}"
            );
            assert_eq!(svg.matches("animation:").count(), rules);
        }
        assert_ne!(animation().svg(Page::Light), animation().svg(Page::Dark));
    }

    #[test]
    fn bodies_lie_where_they_belong_without_a_style_sheet_as_well() {
        let svg = animation().svg(Page::Light);
        let moving = svg.matches("<g class=").count();
        assert!(moving > 6 && svg.matches(" transform=\"translate(").count() == moving, "{moving}");
        // What an attribute does not understand is not drawn at all.
        let attributes = svg.split(" transform=\"").skip(1).filter_map(|rest| rest.split('"').next());
        assert!(attributes.into_iter().all(|value| !value.contains("px") && !value.contains("deg")));
    }

    #[test]
    fn a_key_says_what_curves_and_arrows_are_and_what_is_cut_off() {
        let mut animation = animation();
        let svg = animation.svg(Page::Light);
        assert!(svg.contains(">reference</text>") && svg.contains(">one</text>") && !svg.contains("cut off"));
        assert!(!svg.contains("contact force"));
        animation.curves[0].points[300].1 = -31_200.0;
        let force = super::super::manoeuvre::ContactForce { x_m: 0.0, y_m: 0.0, fx_n: 0.0, fy_n: 1e3 };
        animation.schemes[0].poses.iter_mut().for_each(|pose| pose.contact_forces.push(force));
        let svg = animation.svg(Page::Dark);
        assert!(svg.contains("cut off at ±2 kN: the largest is 31 kN") && svg.contains(">contact force</text>"));
    }

    #[test]
    fn straight_motion_needs_two_keyframes_and_a_jump_is_kept() {
        let straight: Vec<(f64, State)> = (0..50).map(|k| (f64::from(k), [f64::from(k), 0.0, 0.0])).collect();
        assert_eq!(thinned(&straight).len(), 2);
        let jump: Vec<(f64, State)> =
            (0..50).map(|k| (f64::from(k), [0.0, f64::from(u8::from(k > 20)), 0.0])).collect();
        let kept = thinned(&jump);
        assert!(kept.contains(&(20.0, [0.0; 3])) && kept.contains(&(21.0, [0.0, 1.0, 0.0])), "{kept:?}");
    }

    #[test]
    fn the_slow_part_takes_most_of_the_time() {
        let animation = animation();
        let slow = animation.played(1.8) - animation.played(1.6);
        assert!(slow > 0.5 * animation.round_s() && animation.played(1.0) == 0.0, "{slow}");
    }
}
