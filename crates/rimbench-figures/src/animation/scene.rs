//! The box of one scheme, from the side, and magnifiers for its wedges' tips.

use super::palette::{Page, Palette, hex};
use super::path::polygon;
use super::timing::State;
use super::{Animation, Moving};
use crate::drawing::Color;
use crate::manoeuvre::Pose;
use crate::vector::escaped;
use std::fmt::Write;

/// What of the world a drawing shows around the box, m.
pub(super) const BEHIND_M: f64 = 1.32;
pub(super) const AHEAD_M: f64 = 0.72;
pub(super) const BELOW_M: f64 = 0.12;
pub(super) const ABOVE_M: f64 = 0.96;
/// Radius of a magnifier, px.
pub(super) const LENS: f64 = 25.0;
/// How many times larger a magnifier shows heights than they are, m to m.
const MAGNIFIED: f64 = 25.0;
/// Contact force of an arrow of its full size, N.
const FULL_FORCE_N: f64 = 4000.0;

/// Where one scheme is drawn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stage {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) cell: f64,
    pub(super) drawing: f64,
    pub(super) scale: f64,
    pub(super) lenses: f64,
    pub(super) page: Page,
    pub(super) index: usize,
}

impl Animation {
    /// Draws the box from the side, with its magnifiers.
    pub(super) fn scheme(
        &self,
        stage: &Stage,
        scheme: &Moving,
        palette: &Palette,
        style: &mut String,
        body: &mut String,
    ) {
        let Stage { left, top, cell, drawing, scale, page, index, .. } = *stage;
        let geometry = &self.geometry;
        let color = page.of(scheme.color);
        let (tint, dark) = (color.mix(palette.paper, 0.68), color.mix(palette.paper, 0.35));
        let (ink, soft) = (hex(palette.ink), hex(palette.soft));
        let poses: Vec<&Pose> = self.timing.shown(&scheme.poses).collect();
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
        let ground = self.timing.moved(
            &name("g"),
            &states(&|pose| [(first.box_x_m - pose.box_x_m) * scale, 0.0, 0.0]),
            true,
            style,
        );
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
        let moving = self.timing.moved(&name("r"), &states(&rod), true, style);
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
        let moving = self.timing.moved(&name("b"), &states(&at), true, style);
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
            let moving = self.timing.moved(&format!("f{index}{contact}"), &states(&arrow), false, style);
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
        let _ = writeln!(
            body,
            "<text x=\"{left}\" y=\"{:.1}\" font-size=\"15\" font-weight=\"600\" fill=\"{}\">{}</text>",
            stage.lenses + LENS + 6.0,
            hex(color),
            escaped(&scheme.verdict),
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
            let moving = self.timing.moved(&name, &states, true, style);
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
}
