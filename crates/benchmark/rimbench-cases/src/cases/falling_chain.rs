//! `falling-chain`: a chain let go above a scale, on which it piles up: a contact and a joint that can only pull per
//! link. Each row knows two velocities. A bead may be made of p pieces on rigid joints, with the same motion, so that
//! what joints cost and whether they hold can be seen. Shown in `docs/cases/falling-chain.md`; numbers *ours*.

use super::case::Purpose;
use super::prelude::*;

parameters! {
    /// A chain of many links, and the scale under it.
    pub struct Chain from "ours" {
        links: u32 = 20, 2..=2500, "number n of beads";
        chain_length_m: f64 = 1.0, Positive, "length L of the chain; a link is L/n";
        chain_mass_kg: f64 = 2.0, Positive, "mass M of the chain; a bead has M/n";
        bead_share: f64 = 0.2, Fraction, "diameter of a bead in lengths of a link, d/l";
        bead_pieces: u32 = 1, 1..=1000, "number p of pieces of a bead, on rigid joints: the same motion";
        drop_height_m: f64 = 0.0, NotNegative, "height h of the lower end above the scale at the start";
        platform_mass_kg: f64 = 1.0, Positive, "mass m_p of the platform";
        /// What holds the platform.
        scale: Carriage with |set| set
            .only(&["spring_stiffness_n_m", "spring_damping_n_s_m", "carriage_mass_kg", "base_stiffness_n_m", "base_damping_n_s_m"])
            .default("spring_stiffness_n_m", 4e4).within("spring_stiffness_n_m", Positive)
            .about("spring_stiffness_n_m", "stiffness k between carriage and platform")
            .default("spring_damping_n_s_m", 150.0)
            .about("spring_damping_n_s_m", "damping c between carriage and platform")
            .default("carriage_mass_kg", 0.5).within("carriage_mass_kg", Positive)
            .about("carriage_mass_kg", "mass m_a of the carriage").default("base_stiffness_n_m", 8e4)
            .within("base_stiffness_n_m", Positive).default("base_damping_n_s_m", 200.0);
        gravity_m_s2: f64 = 9.81, NotNegative, "gravity".from("standard");
        /// The contact law.
        contacts: Contacts with |set| set
            .only(&["stabilisation", "restitution"]).default("restitution", 0.0).source("restitution", "ours");
    }
}

pub(super) fn entry() -> Case {
    Case {
        purpose: Purpose::Speed,
        trace_columns: carriage::trace_columns(
            "carriage_position_m carriage_velocity_m_s effective_mass_kg lowest_bead_y_m gap_scale_m gap_lowest_link_m \
             contact_force_scale_n closed_contacts",
        ),
        interface_columns: carriage::interface(),
        constant_mechanics: true,
        drawing: drawn(|p: &Chain| {
            let (mut frames, mut shapes) = carriage::springs([0.0, 0.0], [0.0, -1.0], 0.25, Some(0.0));
            let link = p.chain_length_m / f64::from(p.links);
            let (radius, top) = (0.5 * p.bead_share * link, p.drop_height_m + p.chain_length_m);
            shapes.push(Shape::Polygon(rectangle("body", [0.0, -0.02], [0.5, 0.04]), Fill::Metal));
            // Behind the coordinate of the platform those of the pieces, of each bead the first.
            let bead = |index: u32| Channel::Coordinate(1 + (index * p.bead_pieces) as usize);
            let ends = [("lowest", 0), ("highest", p.links - 1)];
            frames.extend(ends.map(|(name, end)| frame(name, 0.0, bead(end), 0.0)));
            shapes.push(Shape::Line(ends.map(|(name, _)| ([0.0, 0.0], Some(name))).to_vec()));
            let beads = (0..p.links).map(|index| [Channel::Fixed(0.0), bead(index)]);
            shapes.push(Shape::Discs(beads.collect(), 1.6 * radius, Fill::Scheme));
            let title = ["Falling chain", "A chain let go above a scale piles up on it."];
            let view = [[-1.0, 1.0], [-0.6, top + 0.1]];
            Some(Drawing::of(title, view, frames, shapes))
        }),
        ..Case::new(
            "falling-chain",
            "A chain falls on a scale: three times the weight of what lies on it (39 contacts; thousands by its parameters)",
            times(0.8, 2e-3, 2e-4, [1e-4, 2e-4]),
            build,
        )
    }
}

/// Upper end of the chain at the start, m: positions are rounded to 1e-10 m there, and a step of 0.1 ms from rest goes
/// 1e-7 m.
const HIGHEST: f64 = 1e6;

impl Chain {
    /// Length of a link, m.
    fn link(&self) -> f64 {
        self.chain_length_m / f64::from(self.links)
    }

    /// Mechanics of the chain and the platform. The centre of bead i starts at `h + (i − ½) l`; the scale is at 0.
    pub fn above_platform(&self) -> LineDescription {
        let link = self.link();
        let bead = self.bead_share * link;
        let of = |mass: f64, start: f64| LineMass {
            mass,
            load: -mass * self.gravity_m_s2,
            start: [start, 0.0],
            ..LineMass::default()
        };
        let place = |bead: u32| self.drop_height_m + (f64::from(bead) + 0.5) * link;
        let (pieces, of_piece) =
            (self.bead_pieces as usize, self.chain_mass_kg / f64::from(self.links * self.bead_pieces));
        let beads = (0..self.links).flat_map(|bead| (0..pieces).map(move |_| bead));
        let beads = beads.map(|bead| of(of_piece, place(bead)));
        // The first and the last piece of a bead; the platform is the one below the first bead.
        let first = |bead: usize| Some(1 + (bead - 1) * pieces);
        let last = |bead: usize| Some(bead * pieces);
        let on = |upper: usize, distance: f64| LineContact { below: last(upper - 1), above: first(upper), distance };
        // A link is a contact the other way round.
        let pulled = |upper: usize| LineContact { below: first(upper), above: last(upper - 1), distance: -link };
        let beside = |piece: usize| LineContact { below: Some(piece - 1), above: Some(piece), distance: 0.0 };
        let upper = 2..=self.links as usize;
        LineDescription {
            masses: std::iter::once(of(self.platform_mass_kg, 0.0)).chain(beads).collect(),
            joints: (2..=self.links as usize * pieces).filter(|piece| (piece - 1) % pieces != 0).map(beside).collect(),
            contacts: std::iter::once(on(1, 0.5 * bead))
                .chain(upper.flat_map(|upper| [pulled(upper), on(upper, bead)]))
                .collect(),
            state_names: words("platform_y_m lowest_bead_y_m platform_velocity_m_s lowest_bead_velocity_m_s"),
            contact_names: words("scale lowest_link"),
            ..LineDescription::default()
        }
    }

    /// What lies on the scale at a time (kg), and its force on the chain (N), for many links on a scale that does not
    /// give way.
    ///
    /// ```text
    /// x = (½ g t² − h)/(1 − d/l) in [0, L],  v = g t       F = ρ g x + ρ v²/(1 − d/l) = 3 ρ g x + 2 ρ g h/(1 − d/l)
    /// ```
    /// and `ρ g L` when all has landed. A chain of n links lands bead by bead, each within half a link of when its part
    /// of the continuous one does: the impulse handed on until t differs by at most `½ (M/n) g t`.
    /// # Source
    /// Momentum of what still falls, `ρ (L − x) g t`; Buquoy 1812.
    pub fn landed_and_force(&self, time: f64) -> [f64; 2] {
        let (density, room) = (self.chain_mass_kg / self.chain_length_m, 1.0 - self.bead_share);
        let speed = self.gravity_m_s2 * time;
        let landed = ((0.5 * speed * time - self.drop_height_m) / room).clamp(0.0, self.chain_length_m);
        let falling = landed > 0.0 && landed < self.chain_length_m;
        let momentum = if falling { density * speed * speed / room } else { 0.0 };
        [density * landed, density * self.gravity_m_s2 * landed + momentum]
    }
}

fn build(p: &Chain, assembly: &Assembly<'_>) -> Result<CoupledSystem> {
    if p.bead_share >= 1.0 {
        let expected = "below 1, or the chain is a rod: beads touch and links are taut at once";
        return Err(Error::invalid("bead_share", p.bead_share, expected));
    }
    let highest = p.drop_height_m + p.chain_length_m;
    if highest > HIGHEST {
        let parts = [named!(p.drop_height_m), named!(p.chain_length_m)];
        let (key, found) = parts[usize::from(p.drop_height_m <= p.chain_length_m)];
        let expected = format!(
            "a chain whose upper end starts at most {HIGHEST:e} m above the scale, not {highest:e} m: where positions are larger, what moves within a step is lost to rounding"
        );
        return Err(Error::invalid(key, found, expected));
    }
    let model = LineMasses::new(p.above_platform())?;
    // In equilibrium with the platform at 0.
    let weight = p.platform_mass_kg * p.gravity_m_s2;
    let carriage = weight / p.scale.spring_stiffness_n_m;
    let scale = SpringActuator::new(Carriage {
        base_position_m: carriage + weight / p.scale.base_stiffness_n_m,
        carriage_position_m: carriage,
        ..p.scale
    })?;
    assembly.couple(model, scale, &p.contacts)
}
