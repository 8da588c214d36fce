//! Energy: the impulse–energy identity in every step, contacts that only take, and work across the interface.

use crate::support::*;
use rimbench::models::WedgeBox;
use std::sync::Arc;

/// Of the actuator, s.
const MICRO_STEP: f64 = 5e-5;

/// The mechanics of the wedge box, with an account of its own kept from states and impulses.
struct Audited {
    inner: NonSmoothMechanics<WedgeBox>,
    before: Vec<f64>,
    /// Largest energy that took part in a step, J.
    scale: f64,
    /// Work of contacts and interface, J.
    contact: f64,
    interface: f64,
    /// `Ȧ_u v` of the step before.
    convective_before: [f64; 4],
    /// Deepest penetration so far, m.
    sunk: [f64; 4],
    /// Largest work that one contact did in one step, J; and what of it is neither convective nor rounding.
    largest_gift: f64,
    unexplained: f64,
    kinetic_start: f64,
    worst: f64,
    worst_joint: f64,
}

fn kinetic(mass: &MassMatrix, v: &[f64]) -> f64 {
    0.5 * mass.product(v, v)
}

impl Audited {
    fn new(law: ContactLaw) -> Self {
        let inner = wedge_box_mechanics(law);
        Audited {
            before: inner.velocity().to_vec(),
            kinetic_start: kinetic(&inner.linearisation().mass, inner.velocity()),
            inner,
            scale: 0.0,
            contact: 0.0,
            interface: 0.0,
            largest_gift: 0.0,
            unexplained: f64::NEG_INFINITY,
            convective_before: [0.0; 4],
            sunk: [0.0; 4],
            worst: 0.0,
            worst_joint: 0.0,
        }
    }
}

impl Subsystem for Audited {
    subsystem_methods!(capabilities_of_inner ports_of_inner outputs_of_inner counters_of_inner no_clone);
    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        let eq3 = self.inner.linearisation().clone();
        let residual_before = self.inner.ledger().identity_residual;
        self.before.copy_from_slice(self.inner.velocity());
        self.inner.step(t, u, h)?;
        let (v, p_u) = (self.inner.velocity(), self.inner.contact_impulses());
        let mean: Vec<f64> = v.iter().zip(&self.before).map(|(after, before)| 0.5 * (after + before)).collect();
        let works: Vec<f64> = p_u.iter().enumerate().map(|(c, p)| p * eq3.unilateral.velocity(c, &mean)).collect();
        let contact: f64 = works.iter().sum();
        let interface = h * u[0] * eq3.interface.velocity(0, &mean);
        let applied: f64 = h * eq3.force.iter().zip(&mean).map(|(f, v)| f * v).sum::<f64>();
        self.contact += contact;
        self.interface += interface;

        // What M (v⁺ − v⁻) leaves after forces and contacts is the joints' impulse: equal and opposite on box and disc.
        let MassMatrix::Diagonal(mass) = &eq3.mass else { unreachable!() };
        let mut left: Vec<f64> = (0..6).map(|i| mass[i] * (v[i] - self.before[i]) - h * eq3.force[i]).collect();
        let mut exchanged = 0.0_f64;
        for (i, left) in left.iter_mut().enumerate() {
            let from_contacts: f64 = p_u.iter().enumerate().map(|(c, p)| p * eq3.unilateral.row(c)[i]).sum();
            let from_interface = h * u[0] * eq3.interface.row(0)[i];
            *left -= from_contacts + from_interface;
            exchanged = exchanged.max(from_contacts.abs()).max(from_interface.abs()).max(mass[i] * v[i].abs());
        }
        let pin = [-eq3.bilateral.row(1)[2], eq3.bilateral.row(0)[2]];
        let moment = -(pin[0] * left[4] - pin[1] * left[3]);
        let joint = (left[0] + left[3]).abs().max((left[1] + left[4]).abs());
        let joint = joint.max((left[2] - moment).abs()).max(left[5].abs());
        self.worst_joint = self.worst_joint.max(joint / exchanged.max(f64::MIN_POSITIVE));

        // Energies that meet in the identity; the joints' is what the mean velocities of pin and disc differ by.
        let joints = (0..2).map(|b| (left[3 + b] * eq3.bilateral.velocity(b, &mean)).abs()).fold(0.0, f64::max);
        // Velocities are rounded relative to what is summed to them: at rest, to the free fall of a step.
        let fall = |i: usize| h * (eq3.force[i] / mass[i]).abs();
        let speed = |c: usize| (0..6).map(|i| eq3.unilateral.row(c)[i].abs() * (mean[i].abs() + fall(i))).sum::<f64>();
        let gross: f64 = p_u.iter().enumerate().map(|(c, p)| p * speed(c)).sum();
        let scale =
            kinetic(&eq3.mass, v) + kinetic(&eq3.mass, &self.before) + gross + joints + interface.abs() + applied.abs();
        self.scale = self.scale.max(scale);
        for (c, work) in works.into_iter().enumerate() {
            // Two gaps between the discrete law and A v⁺ ≤ 0 ≤ −A v⁻. A closed contact enters a step with what the rows
            // turned in the step before, h Ȧ v, where an impact ended the turning that the law counted on. And one that
            // sank (rows turn, γ = 0), opens and closes again stops at the floor: it was lifted by as much.
            self.sunk[c] = self.sunk[c].max(-eq3.unilateral.position[c]);
            let turned = 0.5 * p_u[c] * (h * self.convective_before[c].abs() + self.sunk[c] / h);
            self.largest_gift = self.largest_gift.max(work);
            self.unexplained = self.unexplained.max((work - turned) / (32.0 * f64::EPSILON * scale));
        }
        self.convective_before.copy_from_slice(&eq3.unilateral.convective);
        let residual = self.inner.ledger().identity_residual;
        if residual > residual_before {
            self.worst = self.worst.max(residual / scale);
        }
        Ok(())
    }
}

struct Account {
    audited: Audited,
    outcome: Outcome,
    sent: f64,
    middle: f64,
    received: f64,
    /// Σ |F w| H over the communication points: what passed to and fro.
    passed: f64,
}

/// Schemes that step the subsystem they are given: what steps copies cannot be listened to by [`Audited`].
fn on_the_original() -> impl Iterator<Item = &'static Arc<SchemeEntry>> {
    let on_copies = [Requirement::Copies, Requirement::Trials];
    schemes().iter().filter(move |scheme| !on_copies.iter().any(|need| scheme.needs.contains(need)))
}

fn account(
    scheme: &str,
    detection: Option<ContactDetection>,
    law: ContactLaw,
    macro_step: f64,
    mechanics_steps: MechanicsSteps,
    back: Option<ForceReturn>,
    duration: f64,
) -> Account {
    let entry = scheme_by_name(scheme);
    let (sequence, force_return) = entry.sequence_and_return(None, back).unwrap();
    let grid = CommunicationGrid::new(macro_step, 1.0, duration).unwrap();
    let mut setup = Setup::new(grid, MICRO_STEP, sequence, force_return);
    setup.mechanics_steps = mechanics_steps;
    let mut audited = Audited::new(law);
    let mut last = vec![0.0; 2];
    audited.outputs(&[], &mut last).unwrap();
    let mut meter = Metered { inner: wedge_box_cylinder(), last, middle: 0.0 };
    let options = ModelOptions { detection, ..ModelOptions::default() };
    let coupling = entry.couple(sides(&mut audited, &mut meter), Some(&options), None).unwrap();
    let mut passed = 0.0;
    let report = observed(&setup, sides(&mut audited, &mut meter), coupling, &mut |point| {
        passed += macro_step * (point.y.actuator[0] * point.y.mechanics[1]).abs();
    });
    let work = report.audit.work;
    let (sent, received) = (work.sent_j.unwrap(), work.received_j.unwrap());
    Account { audited, outcome: report.outcome, sent, middle: meter.middle, received, passed }
}

#[test]
fn the_impulse_energy_identity_must_close_in_every_step_of_every_scheme() {
    let (mut ended_early, mut wild) = (0, 0);
    for scheme in on_the_original() {
        for macro_step in [1e-3, 2e-2] {
            let law = ContactLaw { stabilisation: 0.2, ..PLASTIC };
            let Account { audited, outcome, received, .. } =
                account(&scheme.name, None, law, macro_step, ONE, None, 2.5);
            let name = format!("{} H={macro_step} ({outcome})", scheme.name);
            ended_early += usize::from(outcome != Outcome::Completed);
            // A box of 250 kg at the speed of the manoeuvre has 10 J.
            wild += usize::from(audited.scale > 1e3);
            // Some twenty products and sums, each rounding its share of the energies of that step.
            assert!(audited.worst <= 32.0 * f64::EPSILON, "{name}: {:.1} ε", audited.worst / f64::EPSILON);
            assert!(audited.worst_joint <= 64.0 * f64::EPSILON, "{name}: {:.1} ε", audited.worst_joint / f64::EPSILON);
            // The ledger adds up to the same as this test's own account, rounding once per step at most.
            let ledger = audited.inner.ledger();
            let steps = audited.inner.counters().micro_steps as f64;
            let slack = 32.0 * f64::EPSILON * steps * audited.scale;
            let now = kinetic(&audited.inner.linearisation().mass, audited.inner.velocity());
            for (booked, counted) in [
                (ledger.contact, audited.contact),
                (ledger.interface, audited.interface),
                (received, audited.interface),
                (ledger.kinetic, now - audited.kinetic_start),
                (ledger.applied + ledger.bilateral + ledger.contact + ledger.interface, now - audited.kinetic_start),
            ] {
                assert!((booked - counted).abs() <= slack, "{name}: {booked} is not {counted} ± {slack:e}");
            }
        }
    }
    assert!(ended_early > 0 && wild > 0, "no run went astray: the identity was only tested where it is easy");
}

#[test]
fn plastic_contacts_without_stabilisation_must_never_give_energy_whatever_pushes() {
    // With γ > 0 they may: pushing a penetration out is work. Runs that diverge are in on purpose.
    for scheme in on_the_original() {
        let mut with_one_step = None;
        for (macro_step, mechanics_steps) in [(2e-4, ONE), (5e-3, ONE), (5e-3, ALL)] {
            let Account { audited, outcome, .. } =
                account(&scheme.name, None, PLASTIC, macro_step, mechanics_steps, None, 2.5);
            let name = format!("{} H={macro_step} n_m={mechanics_steps} ({outcome})", scheme.name);
            // Runs that end before contacts took anything keep the rounding of their energies, as in the identity
            // above.
            let rounding = 32.0 * f64::EPSILON * audited.scale;
            assert!(audited.contact < rounding, "{name}: contacts gave {} J", audited.contact);
            assert!(audited.unexplained <= 1.0, "{name}: a contact gave {} J", audited.largest_gift);
            // And the two explanations are no excuse: all they allow is next to nothing of what contacts took.
            let least = 1e-6 * -audited.contact + rounding;
            // A run that has gone wild throws the bodies about until 2 s and more (true acceleration with one step of 5
            // ms), and what its rows turn in such a step is millijoules. That it is the turning is seen by what becomes
            // of it in shorter steps: P h |Ȧ v| falls with h at least, whatever the impulse, so a hundred steps leave a
            // hundredth.
            if outcome == Outcome::Completed {
                assert!(audited.largest_gift < least, "{name}: {} J in a step", audited.largest_gift);
            } else if mechanics_steps == ONE {
                with_one_step = Some(audited.largest_gift);
            }
            if let Some(gift) = with_one_step.filter(|_| mechanics_steps == ALL) {
                let most = gift / 100.0 + rounding;
                assert!(audited.largest_gift <= most, "{name}: {} J in a step", audited.largest_gift);
            }
        }
    }
}

/// Keeps account of the work an actuator sends, by the mean of the velocities at both ends of each micro step.
struct Metered {
    inner: Box<dyn Subsystem>,
    /// The input of the last micro step; at the start the mechanics' own outputs.
    last: Vec<f64>,
    /// `Σ δ F_j ½ (w_j + w_{j+1})`, J.
    middle: f64,
}

impl Subsystem for Metered {
    subsystem_methods!(capabilities_of_inner ports_of_inner outputs_of_inner counters_of_inner no_clone);
    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        let m = u.len() / 2;
        let mut force = vec![0.0; m];
        self.inner.outputs(&self.last, &mut force)?;
        for i in 0..m {
            self.middle += h * force[i] * 0.5 * (self.last[m + i] + u[m + i]);
        }
        self.last.copy_from_slice(u);
        self.inner.step(t, u, h)
    }
}

#[test]
fn work_sent_must_be_work_received_to_round_off_where_the_model_is_exact() {
    // A body of constant rows between two springs, on a joint and on the floor: the model of t_k stays true. The meter
    // keeps the velocity of its last micro step, which is then also the one at the communication point.
    for scheme in ["rim-smooth", "rim-nonsmooth", "rim-nonsmooth-gap"] {
        let rows: [(&[f64], f64); 2] = [(&[1.0, 0.0, -0.2], 1.0), (&[1.0, 0.0, 0.3], 2.0)];
        let bilateral = ConstantRows::new(&[(&[0.0, 1.0, 0.0], 0.0)]);
        let body = LinearModel::new(&[2.0, 2.0, 0.3], &[3.0, -19.62, 0.4], &rows).moving(&[0.5, 0.0, -1.0]);
        let model = LinearModel { bilateral, ..body };
        let mut mechanics = stepper(model, PLASTIC);
        let mut last = vec![0.0; 4];
        mechanics.outputs(&[], &mut last).unwrap();
        let springs = Springs::new(&[400.0, 900.0], &[3.0, 5.0]);
        let mut meter = Metered { inner: Box::new(springs), last, middle: 0.0 };
        let grid = CommunicationGrid::new(0.01, 0.7, 3.0).unwrap();
        let actuator_first = Sequence::GaussSeidel { first: Side::Actuator };
        let mut setup = Setup::new(grid, 1e-3, actuator_first, ForceReturn::Profile);
        setup.mechanics_steps = ALL;
        let entry = scheme_by_name(scheme);
        let coupling = coupled(entry, sides(&mut mechanics, &mut meter));
        let mut passed = 0.0;
        let report = observed(&setup, sides(&mut mechanics, &mut meter), coupling, &mut |point| {
            passed +=
                0.01 * point.y.actuator.iter().zip(&point.y.mechanics[2..]).map(|(f, w)| (f * w).abs()).sum::<f64>();
        });
        assert_eq!(report.outcome, Outcome::Completed);
        let work = report.audit.work;
        let (sent, received) = (work.sent_j.unwrap(), work.received_j.unwrap());
        // 3000 micro steps, each rounding its share a few times.
        let slack = 16.0 * f64::EPSILON * 3000.0_f64.sqrt() * passed;
        assert!((sent - meter.middle).abs() <= slack, "the loop counts {sent}, the meter {}", meter.middle);
        assert!((sent - received).abs() <= slack, "{sent} is not {received} ± {slack:e}");
    }
}

#[test]
fn work_across_the_interface_must_not_depend_on_the_model_where_the_profile_is_returned() {
    let law = ContactLaw { stabilisation: 0.2, ..PLASTIC };
    let measured = |scheme: &str, macro_step: f64, back: ForceReturn, duration: f64| {
        let account = account(scheme, None, law, macro_step, ALL, Some(back), duration);
        assert_eq!(account.outcome, Outcome::Completed, "{scheme} H={macro_step} {back}");
        account
    };
    for macro_step in [5e-3, 2.5e-3, 1.25e-3] {
        let Account { sent, middle, received, passed, .. } =
            measured("rim-nonsmooth-gap", macro_step, ForceReturn::Profile, 2.5);
        // Same forces over the same micro steps; only the velocities differ, by what the model of t_k has aged: rows
        // turn by ω H with ω ≤ 0.05 rad/s, once in w and once in H, and so does at most that share of what passed.
        assert!((middle - received).abs() <= 2.0 * 0.05 * macro_step * passed, "{middle} is not {received}");
        // The loop starts each macro step from the mechanics' velocity, the meter from the model's last: they differ by
        // what the model has aged, as above, in the first of the H/δ micro steps only.
        assert!((sent - middle).abs() <= 2.0 * 0.05 * MICRO_STEP * passed, "{sent} is not {middle}");
    }
    // The mean returns the impulse but not when it acted: what is lost besides is the covariance of F and w within a
    // macro step, H²/12 Ḟ ẇ, about (1 kN × 290 rad/s)(3 m/s²) while the force swings in for 20 ms. Until the
    // touch-down, that is: what an impact costs depends on its place in a macro step.
    for macro_step in [5e-3, 1.25e-3] {
        let Account { middle, received, passed, .. } =
            measured("rim-nonsmooth-gap", macro_step, ForceReturn::Mean, 1.6);
        let covariance = macro_step * macro_step / 12.0 * 1000.0 * 290.0 * 3.0 * 0.02;
        let bound = 2.0 * 0.05 * macro_step * passed + covariance;
        assert!((middle - received).abs() <= bound, "{middle} is not {received}");
    }
    // With contacts closed as far as a margin of 1 mm, the model stops the box that far above the floor in each macro
    // step, and the mechanics does not: no macro step, however small, brings the two accounts together. With what the
    // mechanics itself found closed it does.
    let off = |detection| {
        [5e-3, 1.25e-3].map(|macro_step| {
            let back = Some(ForceReturn::Profile);
            let account = account("rim-nonsmooth", Some(detection), law, macro_step, ALL, back, 2.5);
            assert_eq!(account.outcome, Outcome::Completed, "{detection} H={macro_step}");
            (account.middle - account.received).abs()
        })
    };
    let (margin, active) = (off(ContactDetection::Margin { width: 1e-3 }), off(ContactDetection::Active));
    assert!(margin[1] > 0.5 * margin[0], "the margin's error has vanished with H: {margin:?}");
    assert!(active[1] < 0.5 * active[0], "without a margin the error stays: {active:?}");
}
