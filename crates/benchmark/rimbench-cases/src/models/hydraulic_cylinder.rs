//! A double-acting hydraulic cylinder fed through a proportional valve from a constant-pressure pump.

mod lines;

use self::lines::Lines;
use super::fluid::{Oil, TwoChambers};
use super::hydraulic_energy::{HydraulicEnergy, PressureStep};
use super::spring_actuator::force_ports;
use crate::parameter::parameters;
use rimbench_core::cosim::{
    Capabilities, EnergyAccount, NO_CONTACTS, OutputRates, Ports, SecondOrder, Subsystem, SubsystemCounters,
    TransmissionLines, subsystem_methods,
};
use rimbench_core::error::{Error, Failure, Result};
use rimbench_core::name::Name;
use wide::f64x2;

/// A command over time, linear between its points and held outside; or a sine whose amplitude is such a line, or grows
/// smoothly.
#[derive(Debug, Clone, PartialEq)]
pub struct Spool {
    points: Vec<(f64, f64)>,
    sine: Option<Sine>,
}

/// `κ = centre (1 − A(t) sin(2π f t))`, or `κ = centre − A s(t) sin(2π (f t + turns))` with the smooth step
/// `s = x² (3 − 2x)`, `x = t/ramp`.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Sine {
    Line { centre: f64, frequency: f64 },
    Smooth { centre: f64, amplitude: f64, frequency: f64, turns: f64, ramp: f64 },
}

impl Spool {
    /// Builds the command from points (time in s, κ) in order of time.
    pub fn new(points: Vec<(f64, f64)>) -> Self {
        debug_assert!(!points.is_empty() && points.windows(2).all(|pair| pair[0].0 <= pair[1].0));
        Spool { points, sine: None }
    }

    /// Builds the command `κ = centre (1 − A(t) sin(2π f t))` with frequency `f` (Hz) and an amplitude `A` that is
    /// linear between its points (time in s, A).
    pub fn sine(centre: f64, frequency: f64, amplitude: Vec<(f64, f64)>) -> Self {
        Spool { sine: Some(Sine::Line { centre, frequency }), ..Spool::new(amplitude) }
    }

    /// Builds the command `κ = centre − amplitude · s(t) sin(2π (f t + turns))` with frequency `f` (Hz), whose
    /// amplitude grows within `ramp` (s) without a jump of its rate.
    pub fn swing(centre: f64, amplitude: f64, frequency: f64, turns: f64, ramp: f64) -> Self {
        Spool {
            sine: Some(Sine::Smooth { centre, amplitude, frequency, turns, ramp }),
            ..Spool::new(vec![(0.0, centre)])
        }
    }

    /// Returns κ at time `t`.
    #[inline]
    pub fn at(&self, t: f64) -> f64 {
        match &self.sine {
            None => self.line_at(t),
            Some(sine) => self.sine_at(sine, t),
        }
    }

    #[inline(never)]
    fn sine_at(&self, sine: &Sine, t: f64) -> f64 {
        match sine {
            Sine::Line { centre, frequency } => {
                centre * (1.0 - self.line_at(t) * libm::sin(std::f64::consts::TAU * frequency * t))
            }
            Sine::Smooth { centre, amplitude, frequency, turns, ramp } => {
                let x = (t / ramp).clamp(0.0, 1.0);
                let swing = libm::sin(std::f64::consts::TAU * (frequency * t + turns));
                centre - amplitude * (x * x * (3.0 - 2.0 * x)) * swing
            }
        }
    }

    #[inline]
    fn line_at(&self, t: f64) -> f64 {
        match self.points.last() {
            Some(&(last_time, last)) if t >= last_time => last,
            _ => self.between_points(t),
        }
    }

    #[inline(never)]
    fn between_points(&self, t: f64) -> f64 {
        let after = self.points.partition_point(|&(time, _)| time <= t);
        if after == 0 {
            return self.points[0].1;
        }
        let ((t0, k0), (t1, k1)) = (self.points[after - 1], self.points[after]);
        k0 + (k1 - k0) * (t - t0) / (t1 - t0)
    }
}

#[doc = include_str!("hydraulic_cylinder.md")]
///
/// `F` depends directly on `w` through `c`. Instead of the explicit Euler rule it may step by the explicit midpoint
/// rule, with the inputs of the middle.
/// # Outcomes
/// [`Cause::OutOfRange`](rimbench_core::error::Cause::OutOfRange) when the piston reaches an end of its stroke, or a
/// pressure leaves `[0, p_max]` (a negative absolute pressure would be cavitation; above `p_max` the fluid law loses
/// its meaning).
/// # Source
/// Naya, Cuadrado, Dopico, Lugris 2011; Cardona and Geradin 1990.
#[derive(Debug, Clone, PartialEq)]
pub struct HydraulicCylinder {
    oil: TwoChambers,
    size: Cylinder,
    start_length: f64,
    /// `a_v c_d √(2/ρ)`, fixed by the parameters.
    valve_coefficient: f64,
    spool: Spool,
    highest_pressure: f64,
    /// Whether pressures move by their rates in the middle of a micro step.
    midpoint: bool,
    p: f64x2,
    /// Time of the state, s.
    time: f64,
    ports: Ports,
    counters: SubsystemCounters,
    energy: HydraulicEnergy,
    /// In the place of the chambers, where a scheme wants lines.
    lines: Option<Box<Lines>>,
}

parameters! {
    /// A cylinder and its valve, by default those of the wedge box.
    pub struct Cylinder from "as in the wedge box" {
        piston_area_m2: f64 = 0.0065, Positive, "piston area A".from("Naya et al. 2011");
        cylinder_length_m: f64 = 2.0, Positive, "length l of both chambers together";
        viscous_friction_n_s_m: f64 = 1e4, NotNegative, "viscous friction c of the cylinder".study(3e3..3e4);
        valve_area_m2: f64 = 5e-5, Positive, "valve area a_v".study(2e-5..1e-4);
    }
}

impl Cylinder {
    /// Builds a cylinder that starts with its piston in the middle, at the actuator's start length (m).
    ///
    /// # Errors
    /// [`Error::InvalidValue`] if the actuator starts so short that its own stroke does not fit into it.
    pub fn starting_at(
        &self,
        start_length: f64,
        oil: &Oil,
        start_pressures: [f64; 2],
        spool: Spool,
    ) -> Result<HydraulicCylinder> {
        if 0.5 * self.cylinder_length_m >= start_length {
            let expected = format!(
                "below {:.6}: the actuator starts {start_length:.6} m long and moves by half of its stroke",
                2.0 * start_length
            );
            return Err(Error::invalid("cylinder_length_m", self.cylinder_length_m, expected));
        }
        Ok(HydraulicCylinder {
            highest_pressure: oil.highest_pressure(),
            valve_coefficient: self.valve_area_m2 * oil.orifice_coefficient(),
            energy: HydraulicEnergy::new(&oil.in_two_chambers(), f64x2::new(start_pressures)),
            oil: oil.in_two_chambers(),
            size: *self,
            start_length,
            midpoint: false,
            p: f64x2::new(start_pressures),
            time: 0.0,
            spool,
            ports: force_ports("actuator_length_m", "actuator_velocity_m_s"),
            counters: SubsystemCounters::default(),
            lines: None,
        })
    }

    /// Returns the pressures that hold a force (N) at rest, and the spool that keeps both.
    ///
    /// ```text
    /// p₁,₂ = ½(p_P + p_T) ∓ F/(2A)        κ₀ = √(p₁ − p_T) / (√(p_P − p₁) + √(p₁ − p_T))
    /// ```
    /// # Errors
    /// [`Error::Incompatible`] if that takes pressures outside those of tank and pump.
    pub fn equilibrium(&self, oil: &Oil, force: f64) -> Result<([f64; 2], f64)> {
        let (supply, tank) = (oil.supply_pressure_pa, oil.tank_pressure_pa);
        let (mean, half) = (0.5 * (supply + tank), 0.5 * force / self.piston_area_m2);
        let pressures = [mean - half, mean + half];
        if pressures.iter().any(|p| !(tank..=supply).contains(p)) {
            return Err(Error::Incompatible(format!(
                "holding {force:.0} N needs chamber pressures of {:.0} and {:.0} Pa, outside tank ({tank} Pa) and pump ({supply} Pa)",
                pressures[0], pressures[1]
            )));
        }
        let (rise, fall) = ((supply - pressures[0]).sqrt(), (pressures[0] - tank).sqrt());
        Ok((pressures, fall / (rise + fall)))
    }

    /// Returns `F` for pressures `p₁, p₂` and a velocity `ṡ`, N.
    #[inline]
    pub fn force(&self, p: [f64; 2], velocity: f64) -> f64 {
        (p[1] - p[0]) * self.piston_area_m2 - self.viscous_friction_n_s_m * velocity
    }
}

impl HydraulicCylinder {
    /// The names of the observables.
    pub const OBSERVABLES: [Name; 3] =
        [Name::Borrowed("pressure_1_pa"), Name::Borrowed("pressure_2_pa"), Name::Borrowed("spool")];

    /// Returns the length of both chambers together, m.
    pub fn length(&self) -> f64 {
        self.size.cylinder_length_m
    }

    /// Returns κ at time `t`.
    pub fn spool_at(&self, t: f64) -> f64 {
        self.spool.at(t)
    }

    /// Returns `F` for a velocity `ṡ`, N.
    #[inline]
    pub fn force(&self, velocity: f64) -> f64 {
        if self.lines.is_none() { self.size.force(self.pressures(), velocity) } else { self.force_of_lines(velocity) }
    }

    /// Returns `p₁, p₂`, Pa.
    pub fn pressures(&self) -> [f64; 2] {
        self.p.to_array()
    }

    /// Returns `ṗ₁, ṗ₂` (Pa/s) at pressures `p`, length `s`, velocity `ṡ` and spool κ.
    pub fn pressure_rates(&self, p: [f64; 2], s: f64, velocity: f64, spool: f64) -> [f64; 2] {
        let p = f64x2::new(p);
        self.rates(p, self.volumes(self.chambers(s)), velocity, self.valve_flows(p, spool)).to_array()
    }

    /// Conductances from the pump into the chambers; those to the tank are the same in the other order.
    #[inline]
    fn openings(&self, spool: f64) -> [f64; 2] {
        [self.valve_coefficient * spool, self.valve_coefficient * (1.0 - spool)]
    }

    /// Flows from the pump into the chambers, and from the chambers to the tank, m³/s.
    #[inline(always)]
    fn valve_flows(&self, p: f64x2, spool: f64) -> [f64x2; 2] {
        let [first, second] = self.openings(spool);
        let root = |drop: f64x2| drop.fast_max(f64x2::ZERO).sqrt();
        [f64x2::new([first, second]) * root(self.oil.supply - p), f64x2::new([second, first]) * root(p - self.oil.tank)]
    }

    #[inline(always)]
    fn rates(&self, p: f64x2, volumes: f64x2, velocity: f64, [inflow, outflow]: [f64x2; 2]) -> f64x2 {
        let swept = self.size.piston_area_m2 * velocity;
        self.oil.stiffness(p, volumes) * (f64x2::new([swept, -swept]) + inflow - outflow)
    }

    /// Lengths `l₁, l₂` of the chambers, m.
    #[inline(always)]
    fn chambers(&self, s: f64) -> f64x2 {
        let half = f64x2::splat(0.5 * self.size.cylinder_length_m);
        half + f64x2::new([self.start_length, s]) - f64x2::new([s, self.start_length])
    }

    /// Volumes of the chambers with these lengths, m³.
    #[inline(always)]
    fn volumes(&self, chambers: f64x2) -> f64x2 {
        f64x2::splat(self.size.piston_area_m2) * chambers
    }

    /// Moves the pressures over `h` (s) by their rates at pressures `at`, in chambers of these lengths.
    #[inline(always)]
    fn advance(&mut self, at: f64x2, spool: f64, chambers: f64x2, velocity: f64, h: f64) -> PressureStep {
        let (before, volumes) = (self.p, self.volumes(chambers));
        let flows = self.valve_flows(at, spool);
        self.p = before + f64x2::splat(h) * self.rates(at, volumes, velocity, flows);
        PressureStep {
            h,
            p: [before, self.p],
            volumes,
            area: self.size.piston_area_m2,
            velocity,
            friction: self.size.viscous_friction_n_s_m,
            inflow: flows[0],
            outflow: flows[1],
            softness: self.oil.softness(at),
        }
    }

    #[inline]
    fn step_by_euler(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        let (s, velocity) = (u[0], u[1]);
        let chambers = self.check_stroke(s)?;
        if !self.energy.has_started() {
            // Later on they are those with which the last step ended.
            self.check_pressures(s)?;
        }
        let step = self.advance(self.p, self.spool.at(t), chambers, velocity, h);
        self.energy.book(&self.oil, &step);
        self.time = t + h;
        self.counters.micro_steps += 1;
        self.check_pressures(s)
    }

    /// A micro step of lines in the place of the chambers, or of the second order.
    #[inline(never)]
    fn step_otherwise(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        if self.lines.is_none() {
            return self.step_by_midpoint(t, u, h);
        }
        self.check_range(u[0])?;
        if !self.step_lines(self.spool.at(t), u[1], h) {
            return self.step_by_euler(t, u, h);
        }
        self.time = t + h;
        self.counters.micro_steps += 1;
        self.check_range(u[0])
    }

    /// A micro step with the inputs, the spool and the pressures of its middle.
    fn step_by_midpoint(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        self.check_range(u[0])?;
        let (spool, chambers) = (self.spool.at(t + 0.5 * h), self.chambers(u[0]));
        let rates = self.rates(self.p, self.volumes(chambers), u[1], self.valve_flows(self.p, spool));
        let middle = self.p + f64x2::splat(0.5 * h) * rates;
        let step = self.advance(middle, spool, chambers, u[1], h);
        self.energy.book_midpoint(&self.oil, &step, middle);
        self.time = t + h;
        self.counters.micro_steps += 1;
        self.check_pressures(u[0])
    }

    #[inline]
    fn check_range(&self, s: f64) -> Result<(), Failure> {
        self.check_stroke(s)?;
        self.check_pressures(s)
    }

    /// Returns the lengths of the chambers.
    #[inline(always)]
    fn check_stroke(&self, s: f64) -> Result<f64x2, Failure> {
        let chambers = self.chambers(s);
        if chambers.simd_le(f64x2::ZERO).any() { Err(self.range_failure(true, s)) } else { Ok(chambers) }
    }

    #[inline(always)]
    fn check_pressures(&self, s: f64) -> Result<(), Failure> {
        let highest = f64x2::splat(self.highest_pressure);
        let valid = self.p.simd_ge(f64x2::ZERO) & self.p.simd_le(highest);
        if valid.to_bitmask() == 3 { Ok(()) } else { Err(self.range_failure(false, s)) }
    }

    fn is_valid(&self, p: f64) -> bool {
        (0.0..=self.highest_pressure).contains(&p)
    }

    #[cold]
    fn range_failure(&self, stroke_ended: bool, s: f64) -> Failure {
        if stroke_ended {
            return Failure::out_of_range("actuator_length_m", s);
        }
        let [first, second] = self.pressures();
        let of_first = !self.is_valid(first);
        let (quantity, value) = if of_first { ("pressure_1_pa", first) } else { ("pressure_2_pa", second) };
        if value.is_nan() { Failure::non_finite(quantity) } else { Failure::out_of_range(quantity, value) }
    }
}

impl Subsystem for HydraulicCylinder {
    subsystem_methods!(ports capabilities counters clone);

    #[inline]
    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        y[0] = self.force(u[1]);
        Ok(())
    }

    fn step(&mut self, t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        if self.midpoint || self.lines.is_some() {
            return self.step_otherwise(t, u, h);
        }
        self.step_by_euler(t, u, h)
    }
}

impl Capabilities for HydraulicCylinder {
    fn output_rates(&mut self, t: f64, u: &[f64], rates: &mut OutputRates) -> Result<bool, Failure> {
        let (area, chambers) = (self.size.piston_area_m2, self.chambers(u[0]));
        let [l1, l2] = chambers.to_array();
        let [p1_rate, p2_rate] = self.pressure_rates(self.pressures(), u[0], u[1], self.spool.at(t));
        rates.rate[0] = area * (p2_rate - p1_rate);
        rates.feedthrough.copy_from_slice(&[0.0, -self.size.viscous_friction_n_s_m]);
        // ∂l₁/∂s = −1 and ∂l₂/∂s = 1 in the denominators of ṗ₁ and ṗ₂.
        let by_length = -area * (p2_rate / l2 + p1_rate / l1);
        let [first, second] = self.oil.stiffness(self.p, self.volumes(chambers)).to_array();
        let by_velocity = -area * area * (first + second);
        rates.rate_gain.copy_from_slice(&[by_length, by_velocity]);
        Ok(true)
    }

    fn use_second_order(&mut self, rule: SecondOrder) -> Result<(), &'static str> {
        self.midpoint = rule == SecondOrder::Midpoint;
        if self.midpoint { Ok(()) } else { Err(NO_CONTACTS) }
    }

    fn oil_lines(&mut self) -> Option<&mut dyn TransmissionLines> {
        Some(self)
    }

    fn observables(&mut self) -> &[Name] {
        &Self::OBSERVABLES
    }

    fn observe(&mut self, _h: f64, row: &mut [f64]) {
        let [first, second] = self.pressures();
        row.copy_from_slice(&[first, second, self.spool.at(self.time)]);
    }

    fn energy_account(&mut self) -> Option<EnergyAccount> {
        Some(self.lines.as_ref().map_or_else(|| self.energy.account(), |lines| lines.account()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameter::ParameterSet;

    fn cylinder(spool: f64) -> HydraulicCylinder {
        let spool = Spool::new(vec![(0.0, spool)]);
        Cylinder::defaults().starting_at(2.5, &Oil::defaults(), [3.85e6; 2], spool).unwrap()
    }

    #[test]
    fn the_end_of_the_stroke_and_cavitation_are_outcomes() {
        let stroke = cylinder(0.5).step(0.0, &[3.6, 0.0], 1e-5);
        assert!(stroke.is_err_and(|failure| failure.to_string().starts_with("actuator_length_m =")));
        let mut pulled = cylinder(0.5);
        let cavitation = (0..1000).find_map(|_| pulled.step(0.0, &[2.5, -50.0], 1e-4).err());
        assert!(cavitation.is_some_and(|failure| failure.to_string().starts_with("pressure_1_pa =")));
    }
}
