//! The case with one scheme, and the reference as a thin outline: each shape in a group that moves as its frame does.

use super::palette::{Page, Palette};
use super::path::{line, polygon};
use super::timing::State;
use super::{Animation, Moving};
use crate::case_picture::{AT_REST, Motion, Pose, poses, rod_and_barrel, within};
use crate::drawing::Color;
use crate::vector::escaped;
use rimbench_cases::cases::{Fill, Point, Shape};
use rimbench_core::error::{Error, Result};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Where one scheme is drawn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stage {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) cell: f64,
    pub(super) drawing: f64,
    pub(super) scale: f64,
    pub(super) page: Page,
    pub(super) index: usize,
}

/// What moves through the shown rows of a run, in the frame of a stage.
struct Track<'a> {
    animation: &'a Animation,
    scale: f64,
    /// Name that its classes begin with.
    name: String,
    times_s: Vec<f64>,
    follow: Vec<f64>,
    poses: Vec<BTreeMap<&'static str, Pose>>,
    motion: &'a Motion,
    rows: Vec<usize>,
    style: &'a mut String,
    /// Attributes of the groups that have their rule.
    made: BTreeMap<String, String>,
}

impl<'a> Track<'a> {
    fn new(animation: &'a Animation, motion: &'a Motion, name: String, scale: f64, style: &'a mut String) -> Self {
        let rows = animation.timing.shown(motion);
        Track {
            times_s: rows.iter().map(|&row| motion.times_s[row]).collect(),
            follow: rows.iter().map(|&row| motion.follow[row]).collect(),
            poses: rows.iter().map(|&row| poses(&animation.of, &motion.row(row))).collect(),
            made: BTreeMap::new(),
            animation,
            scale,
            name,
            motion,
            rows,
            style,
        }
    }

    fn place(&self, k: usize, (point, frame): Point) -> [f64; 2] {
        let [[left, _], [_, high]] = self.animation.of.view;
        let [x, y] = within(frame.map_or(AT_REST, |frame| self.poses[k][frame]), point);
        [self.scale * (x - self.follow[k] - left), self.scale * (high - y)]
    }

    /// Attributes of a group with these states, the same for one part each time.
    fn moved(&mut self, part: &str, turns: bool, state: impl Fn(&Self, usize) -> State) -> String {
        if !self.made.contains_key(part) {
            let states: Vec<(f64, State)> =
                (0..self.times_s.len()).map(|k| (self.times_s[k], state(self, k))).collect();
            let class = format!("{}{}", self.name, part.replace(' ', "-"));
            let attributes = self.animation.timing.moved(&class, &states, turns, self.style);
            self.made.insert(part.to_owned(), attributes);
        }
        self.made[part].clone()
    }

    /// Attributes of what is fixed to a frame, or to the ground.
    fn fixed(&mut self, frame: Option<&'static str>) -> String {
        self.moved(frame.unwrap_or("ground"), true, |track, k| {
            let [x, y] = track.place(k, ([0.0, 0.0], frame));
            let [_, _, cos, sin] = frame.map_or(AT_REST, |frame| track.poses[k][frame]);
            [x, y, -sin.atan2(cos).to_degrees()]
        })
    }
}

impl Animation {
    /// Draws the case from the side.
    pub(super) fn scheme(
        &self,
        stage: &Stage,
        scheme: &Moving,
        palette: &Palette,
        style: &mut String,
        body: &mut String,
    ) -> Result<()> {
        let Stage { left, top, cell, drawing, scale, page, index } = *stage;
        let color = page.of(scheme.color);
        let (ink, soft) = (palette.ink.hex(), palette.soft.hex());
        let _ = write!(
            body,
            "<text x=\"{left}\" y=\"16\" font-size=\"13\" font-weight=\"600\" fill=\"{0}\">{1}</text>\n\
             <text x=\"{2}\" y=\"16\" font-size=\"13\" font-weight=\"600\" text-anchor=\"end\" fill=\"{0}\">{3}</text>\n\
             <clipPath id=\"view{index}\"><rect width=\"{cell:.1}\" height=\"{drawing:.1}\"/></clipPath>\n\
             <g transform=\"translate({left},{top})\"><g clip-path=\"url(#view{index})\" stroke=\"{ink}\" stroke-width=\"1\">\n",
            color.hex(),
            escaped(&scheme.label),
            left + cell,
            escaped(&scheme.verdict),
        );
        let mut track = Track::new(self, &scheme.motion, format!("{}-", ["a", "b"][index]), scale, style);
        self.shapes(&mut track, Some(color), palette, body)?;
        // The reference is the same for both, and its rules are made once.
        let mut unused = String::new();
        let rules = if index == 0 { style } else { &mut unused };
        let mut track = Track::new(self, &self.reference, "r-".to_owned(), scale, rules);
        body.push_str("<g fill=\"none\" stroke-width=\".8\">\n");
        self.shapes(&mut track, None, palette, body)?;
        let _ = writeln!(
            body,
            "</g></g><rect width=\"{cell:.1}\" height=\"{drawing:.1}\" fill=\"none\" stroke=\"{}\"/>\n\
             <text x=\"6\" y=\"{1:.1}\" font-size=\"11\" fill=\"{soft}\">thin outline: reference</text>",
            palette.ledge.hex(),
            drawing - 6.0,
        );
        if self.enlarged > 1.0 {
            let _ = writeln!(
                body,
                "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"11\" text-anchor=\"end\" fill=\"{soft}\">differences × {}</text>",
                cell - 6.0,
                drawing - 6.0,
                self.enlarged
            );
        }
        body.push_str("</g>\n");
        Ok(())
    }

    /// Shapes from behind to the front, filled with their colours; without a colour those that move, as outlines.
    fn shapes(&self, track: &mut Track<'_>, color: Option<Color>, palette: &Palette, body: &mut String) -> Result<()> {
        let scale = track.scale;
        let fill = |fill: Fill| {
            let color = color.map(|color| match fill {
                Fill::Scheme => color.mix(palette.paper, 0.6),
                Fill::Metal => palette.metal,
                Fill::Ground => palette.ground,
            });
            color.map_or(String::new(), |color| format!(" fill=\"{}\"", color.hex()))
        };
        let own = |points: &[Point]| points.iter().map(|([x, y], _)| (x * scale, -y * scale)).collect::<Vec<_>>();
        for (number, shape) in self.of.shapes.iter().enumerate() {
            let points = shape.points();
            if color.is_none() && points.iter().all(|point| point.1.is_none()) {
                continue;
            }
            let frame = points[0].1;
            if let Shape::Cylinder { from, to, barrel, width } = shape {
                for (part, [start, end, half]) in
                    [("rod", *to), ("barrel", *from)].into_iter().zip(rod_and_barrel(0.0, *barrel, *width))
                {
                    let (name, at) = part;
                    if color.is_none() && name == "rod" {
                        continue;
                    }
                    let moving = track.moved(&format!("{name}{number}"), true, |track, k| {
                        let ([x, y], [x0, y0], [x1, y1]) =
                            (track.place(k, at), track.place(k, *from), track.place(k, *to));
                        [x, y, (y1 - y0).atan2(x1 - x0).to_degrees()]
                    });
                    // The rod goes back into its barrel.
                    let [start, end] = if name == "rod" { [-2.0 * barrel, 0.0] } else { [start, end] };
                    let corners = [(start, -half), (end, -half), (end, half), (start, half)];
                    let path = polygon(&corners.map(|(x, y)| (x * scale, y * scale)));
                    let _ = writeln!(body, "<g {moving}><path{} d=\"{path}\"/></g>", fill(Fill::Metal));
                }
                continue;
            }
            if points.iter().any(|point| point.1 != frame) || matches!(shape, Shape::Spring(..)) {
                let message = format!("{}: a shape between moving bodies cannot be shown in motion", self.of.title[0]);
                return Err(Error::Incompatible(message));
            }
            if let Shape::Arrow { column, at, along, scale: per_newton } = shape {
                if color.is_none() {
                    continue;
                }
                let longest = 0.35 * (self.of.view[1][1] - self.of.view[1][0]);
                let moving = track.moved(column, false, |track, k| {
                    let [x, y] = track.place(k, *at);
                    let size = (track.motion.row(track.rows[k])(column) * per_newton).clamp(0.0, longest);
                    [x, y, if size.is_finite() { scale * size / 100.0 } else { 0.0 }]
                });
                let turn = along[0].atan2(along[1]).to_degrees();
                let _ = writeln!(
                    body,
                    "<g {moving}><path transform=\"rotate({turn:.1})\" fill=\"{}\" stroke=\"{}\" stroke-width=\".8\" d=\"M-4 0V-72H-12L0-100L12-72H4V0z\"/></g>",
                    palette.force.hex(),
                    palette.paper.hex(),
                );
                continue;
            }
            let moving = track.fixed(frame);
            let _ = match shape {
                Shape::Disc { at, radius, spoke, fill: filling } => {
                    let ([x, y], radius) = (at.0.map(|value| value * scale), radius * scale);
                    let spoke =
                        if *spoke { format!("<path d=\"M{x:.1} {:.1}h{radius:.1}\"/>", -y) } else { String::new() };
                    writeln!(
                        body,
                        "<g {moving}><circle cx=\"{x:.1}\" cy=\"{:.1}\" r=\"{radius:.1}\"{}/>{spoke}</g>",
                        -y,
                        fill(*filling)
                    )
                }
                Shape::Polygon(points, filling) => {
                    writeln!(body, "<g {moving}><path{} d=\"{}\"/></g>", fill(*filling), polygon(&own(points)))
                }
                _ => writeln!(body, "<g {moving}><path fill=\"none\" d=\"{}\"/></g>", line(&own(&points))),
            };
        }
        Ok(())
    }
}
