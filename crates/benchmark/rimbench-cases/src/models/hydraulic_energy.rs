//! The energy account of a hydraulic cylinder, micro step by micro step.

use super::fluid::Oil;
use rimbench_core::cosim::EnergyAccount;

/// One micro step, as the cylinder took it.
#[derive(Debug, Clone, Copy)]
pub(super) struct PressureStep {
    /// Micro step, s.
    pub h: f64,
    /// Pressures before and after, Pa.
    pub p: [[f64; 2]; 2],
    /// Chamber volumes at the length the step was taken with, m³.
    pub volumes: [f64; 2],
    /// Piston area, m².
    pub area: f64,
    /// Velocity the step was taken with, m/s.
    pub velocity: f64,
    /// Viscous friction, N·s/m.
    pub friction: f64,
    /// Flow from the pump into each chamber, m³/s at the chamber's density.
    pub inflow: [f64; 2],
    /// Flow from each chamber to the tank, m³/s at the chamber's density.
    pub outflow: [f64; 2],
}

/// Books the steps of a cylinder.
///
/// A chamber of volume `V` holds the mass `ρ₀ φ(p) V` and stores the elastic energy `V ε(p)` of its fluid (see [`Oil`]). For
/// an open chamber whose mass is conserved, `V ṗ = β (Q − V̇)`, this is exact:
///
/// ```text
/// d(V ε)/dt = −p V̇ + φ J(p) Q              work of the wall, and enthalpy of the fluid that flows in
/// pump      = φ J(p_P) Q_in                 enthalpy that this mass had at the pump; p_P Q_in to first order in 1/β
/// valve     = φ (J(p_P) − J(p)) Q_in + φ (J(p) − J(p_T)) Q_out          to first order the pressure drop times Q
/// tank      = φ J(p_T) Q_out
/// interface = −h (F(p_j, w) w),  viscous = h c w²                       w: the velocity given for the step
/// ```
/// Powers are taken at the pressure `p` at which the step takes its rates: that of its start `p_j` for explicit Euler, that of its middle
/// for the midpoint rule. What that leaves is booked where it arises:
///
/// ```text
/// curvature   V (ε(p_{j+1}) − ε(p_j) − ε'(p)(p_{j+1} − p_j))            a straight line through a curved energy
/// volume      ε(p_j) (V_j − V_{j−1}) − ε(p) h V̇                         lengths given that do not follow velocities given
/// ```
/// The length given at the first step is where the account starts from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct HydraulicEnergy {
    account: EnergyAccount,
    started: bool,
    /// `V_1, V_2` of the last step, m³.
    volumes: [f64; 2],
    /// Elastic energy at the start and now, J.
    energy: [f64; 2],
    /// `J(p_i)`, `φ(p_i)` and `φ J − p_i` (Pa) of the present state: the next step starts with them.
    enthalpy: [f64; 2],
    density: [f64; 2],
    elastic: [f64; 2],
    /// `J(p_P), J(p_T)`, Pa.
    supply_and_tank: [f64; 2],
}

impl HydraulicEnergy {
    pub(super) fn new(oil: &Oil, p: [f64; 2]) -> Self {
        let (enthalpy, density) = (p.map(|p| oil.enthalpy(p)), p.map(|p| oil.relative_density(p)));
        HydraulicEnergy {
            account: EnergyAccount::default(),
            started: false,
            volumes: [0.0; 2],
            energy: [0.0; 2],
            enthalpy,
            density,
            elastic: [0, 1].map(|i| density[i] * enthalpy[i] - p[i]),
            supply_and_tank: [oil.enthalpy(oil.supply_pressure_pa), oil.enthalpy(oil.tank_pressure_pa)],
        }
    }

    #[inline]
    pub(super) fn book(&mut self, oil: &Oil, step: &PressureStep) {
        self.book_at(oil, step, None);
    }

    /// Does the same for a step whose forces and flows were taken at the pressures `middle`, Pa.
    #[inline(never)]
    pub(super) fn book_midpoint(&mut self, oil: &Oil, step: &PressureStep, middle: [f64; 2]) {
        self.book_at(oil, step, Some(middle));
    }

    #[inline(always)]
    fn book_at(&mut self, oil: &Oil, step: &PressureStep, middle: Option<[f64; 2]>) {
        let [before, after] = step.p;
        let [supply, tank] = self.supply_and_tank;
        let first = !self.started;
        if first {
            self.volumes = step.volumes;
            self.started = true;
        }
        let account = &mut self.account;
        let swept = step.h * step.velocity;
        let friction = step.friction * step.velocity * swept;
        account.viscous += friction;
        let acting = middle.unwrap_or(before);
        account.interface += friction - (acting[1] - acting[0]) * step.area * swept;
        let mut stored = 0.0;
        for i in 0..2 {
            let energy = self.elastic[i];
            let (density, own) = match middle {
                None => (self.density[i], self.enthalpy[i]),
                Some(_) => (oil.relative_density(acting[i]), oil.enthalpy(acting[i])),
            };
            let energy_acting = density * own - acting[i];
            let (inflow, outflow) = (step.h * density * step.inflow[i], step.h * density * step.outflow[i]);
            account.pump += supply * inflow;
            account.valve += (supply - own) * inflow + (own - tank) * outflow;
            account.tank += tank * outflow;

            if first {
                self.energy[0] += step.volumes[i] * energy;
            }
            self.enthalpy[i] = oil.enthalpy(after[i]);
            self.density[i] = oil.relative_density(after[i]);
            let energy_after = self.density[i] * self.enthalpy[i] - after[i];
            self.elastic[i] = energy_after;
            let slope = (oil.compressibility_a_1_pa + 2.0 * oil.compressibility_b_1_pa2 * acting[i]) * own;
            let curvature = step.volumes[i] * (energy_after - energy - slope * (after[i] - before[i]));
            // Chamber 1 shrinks as the piston moves out.
            let rate = if i == 0 { -step.area * swept } else { step.area * swept };
            let change = step.volumes[i] - self.volumes[i];
            let volume = match middle {
                None => energy * (change - rate),
                Some(_) => energy * change - energy_acting * rate,
            };
            account.integration += curvature + volume;
            stored += step.volumes[i] * energy_after;
        }
        self.volumes = step.volumes;
        self.energy[1] = stored;
    }

    pub(super) fn account(&self) -> EnergyAccount {
        EnergyAccount { stored: self.energy[1] - self.energy[0], ..self.account }
    }
}
