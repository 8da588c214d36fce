//! The force over time below the drawings, and the key of everything.

use super::palette::{Page, Palette};
use super::path::{line, thin_line};
use super::timing::State;
use super::{Animation, MARGIN, WIDTH};
use crate::drawing::Color;
use crate::ticks::signed;
use crate::vector::escaped;
use rimbench_cases::cases::Shape;
use std::fmt::Write;

/// Height of the curves, px.
pub(super) const CHART: f64 = 92.0;
/// Height of the key below them, px.
pub(super) const KEY: f64 = 20.0;

impl Animation {
    /// The force over time with the cursor of the drawings.
    pub(super) fn chart(&self, top: f64, page: Page, palette: &Palette, style: &mut String, body: &mut String) {
        let (left, right) = (MARGIN + 44.0, WIDTH - MARGIN - 4.0);
        let [from, to] = self.timing.shown_s;
        let [low, high] = self.force_n;
        let across = |t: f64| left + (t - from) / (to - from) * (right - left);
        let up = |force: f64| top + CHART - (force - low) / (high - low) * CHART;
        let (ink, soft) = (palette.ink.hex(), palette.soft.hex());
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
                    palette.ledge.hex(),
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
            let _ = writeln!(body, "<path stroke=\"{}\" d=\"{}\"/>", color.hex(), line(&thin_line(&points)));
        }
        body.push_str("</g>\n");
        let instants: Vec<f64> = self.schemes.first().map_or_else(Vec::new, |scheme| {
            self.timing.shown(&scheme.motion).into_iter().map(|row| scheme.motion.times_s[row]).collect()
        });
        let states: Vec<(f64, State)> = instants.iter().map(|&t| (t, [across(t), 0.0, 0.0])).collect();
        let moving = self.timing.moved("cursor", &states, true, style);
        let _ =
            writeln!(body, "<g {moving}><path stroke=\"{ink}\" stroke-width=\"1.4\" d=\"M0 {top:.1}v{CHART}\"/></g>");
    }

    /// What the curves and the arrows are, and what the strip leaves out.
    pub(super) fn key(&self, y: f64, page: Page, palette: &Palette, body: &mut String) {
        let soft = palette.soft.hex();
        let mut x = MARGIN;
        let mut entry = |sample: String, words: &str| {
            let _ = writeln!(
                body,
                "{sample}<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"11\" fill=\"{soft}\">{}</text>",
                x + 22.0,
                y + 4.0,
                escaped(words),
            );
            x += 22.0 + crate::font::WIDER * crate::font::width(words, 11.0, crate::drawing::Weight::Regular) + 14.0;
            x
        };
        let line = |x: f64, color: Color| {
            format!("<path stroke=\"{}\" stroke-width=\"1.6\" d=\"M{x:.1} {y:.1}h16\"/>", color.hex())
        };
        let mut at = MARGIN;
        if self.curves.iter().any(|curve| curve.color.is_none()) {
            at = entry(line(at, palette.ink), "reference");
        }
        for scheme in self.schemes.iter().take(2) {
            at = entry(line(at, page.of(scheme.color)), &scheme.label);
        }
        if self.of.shapes.iter().any(|shape| matches!(shape, Shape::Arrow { .. })) {
            let arrow = format!(
                "<path fill=\"{}\" d=\"M{:.1} {:.1}v-9h-2.5l4-7l4 7h-2.5v9z\"/>",
                palette.force.hex(),
                at + 6.5,
                y + 7.0
            );
            at = entry(arrow, "contact force");
        }
        let [low, high] = self.force_n;
        let (from, to) = (self.timing.shown_s[0], self.timing.shown_s[1]);
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
}
