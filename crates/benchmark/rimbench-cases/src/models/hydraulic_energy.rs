//! The energy account of a hydraulic cylinder, micro step by micro step.

use super::fluid::TwoChambers;
use rimbench_core::cosim::EnergyAccount;
use wide::f64x2;

/// One micro step, as the cylinder took it.
#[derive(Debug, Clone, Copy)]
pub(super) struct PressureStep {
    /// Micro step, s.
    pub h: f64,
    /// Pressures before and after, Pa.
    pub p: [f64x2; 2],
    /// Chamber volumes at the length the step was taken with, m³.
    pub volumes: f64x2,
    /// Piston area, m².
    pub area: f64,
    /// Velocity the step was taken with, m/s.
    pub velocity: f64,
    /// Viscous friction, N·s/m.
    pub friction: f64,
    /// Flow from the pump into each chamber, m³/s at the chamber's density.
    pub inflow: f64x2,
    /// Flow from each chamber to the tank, m³/s at the chamber's density.
    pub outflow: f64x2,
    /// `φ'` at the pressures of the flows, 1/Pa.
    pub softness: f64x2,
}

/// Books the steps of a cylinder.
///
/// A chamber of volume `V` holds the mass `ρ₀ φ(p) V` and stores the elastic energy `V ε(p)` of its fluid (see
/// [`Oil`](super::fluid::Oil)). For an open chamber whose mass is conserved, `V ṗ = β (Q − V̇)`, this is exact:
///
/// ```text
/// d(V ε)/dt = −p V̇ + φ J(p) Q              work of the wall, and enthalpy of the fluid that flows in
/// pump      = φ J(p_P) Q_in                 enthalpy that this mass had at the pump; p_P Q_in to first order in 1/β
/// valve     = φ (J(p_P) − J(p)) Q_in + φ (J(p) − J(p_T)) Q_out          to first order the pressure drop times Q
/// tank      = φ J(p_T) Q_out
/// interface = −h (F(p_j, w) w),  viscous = h c w²                       w: the velocity given for the step
/// ```
/// Powers are taken at the pressure `p` at which the step takes its rates: that of its start `p_j` for explicit Euler,
/// that of its middle for the midpoint rule. What that leaves is booked where it arises:
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
    volumes: f64x2,
    /// Elastic energy at the start and now, J.
    energy: [f64; 2],
    /// `J(p_i)`, `φ(p_i)` and `φ J − p_i` (Pa) of the present state: the next step starts with them.
    enthalpy: f64x2,
    density: f64x2,
    elastic: f64x2,
    /// `J(p_P), J(p_T)`, Pa.
    supply_and_tank: [f64x2; 2],
}

impl HydraulicEnergy {
    pub(super) fn new(oil: &TwoChambers, p: f64x2) -> Self {
        let (enthalpy, density) = (oil.enthalpy(p), oil.relative_density(p));
        HydraulicEnergy {
            account: EnergyAccount::default(),
            started: false,
            volumes: f64x2::ZERO,
            energy: [0.0; 2],
            enthalpy,
            density,
            elastic: density * enthalpy - p,
            supply_and_tank: [oil.enthalpy(oil.supply), oil.enthalpy(oil.tank)],
        }
    }

    /// Tells whether a step was booked.
    #[inline]
    pub(super) fn has_started(&self) -> bool {
        self.started
    }

    #[inline]
    pub(super) fn book(&mut self, oil: &TwoChambers, step: &PressureStep) {
        self.book_at(oil, step, None);
    }

    /// Does the same for a step whose forces and flows were taken at the pressures `middle`, Pa.
    #[inline(never)]
    pub(super) fn book_midpoint(&mut self, oil: &TwoChambers, step: &PressureStep, middle: f64x2) {
        self.book_at(oil, step, Some(middle));
    }

    /// Both chambers at once; sums take one after the other.
    #[inline(always)]
    fn book_at(&mut self, oil: &TwoChambers, step: &PressureStep, middle: Option<f64x2>) {
        let PressureStep { h, p: [before, after], volumes, softness, .. } = *step;
        if !self.started {
            self.start(volumes);
        }
        let [supply, tank] = self.supply_and_tank;
        let swept = h * step.velocity;
        let friction = step.friction * step.velocity * swept;
        let acting = middle.unwrap_or(before);
        let energy = self.elastic;
        let (density, own) = match middle {
            None => (self.density, self.enthalpy),
            Some(_) => (oil.relative_density(acting), oil.enthalpy(acting)),
        };
        let mass = f64x2::splat(h) * density;
        let (inflow, outflow) = (mass * step.inflow, mass * step.outflow);

        self.enthalpy = oil.enthalpy(after);
        self.density = oil.relative_density(after);
        let energy_after = self.density * self.enthalpy - after;
        self.elastic = energy_after;
        let slope = softness * own;
        let curvature = volumes * (energy_after - energy - slope * (after - before));
        // Chamber 1 shrinks as the piston moves out.
        let rate = f64x2::new([-step.area * swept, step.area * swept]);
        let change = volumes - self.volumes;
        let volume = match middle {
            None => energy * (change - rate),
            Some(_) => energy * change - (density * own - acting) * rate,
        };
        let [first, second] = acting.to_array();
        let account = &mut self.account;
        account.viscous += friction;
        account.interface += friction - (second - first) * step.area * swept;
        add_each(&mut account.pump, supply * inflow);
        add_each(&mut account.valve, (supply - own) * inflow + (own - tank) * outflow);
        add_each(&mut account.tank, tank * outflow);
        add_each(&mut account.integration, curvature + volume);
        self.volumes = volumes;
        self.energy[1] = (volumes * energy_after).reduce_add();
    }

    #[cold]
    fn start(&mut self, volumes: f64x2) {
        (self.started, self.volumes) = (true, volumes);
        self.energy[0] = (volumes * self.elastic).reduce_add();
    }

    pub(super) fn account(&self) -> EnergyAccount {
        EnergyAccount { stored: self.energy[1] - self.energy[0], ..self.account }
    }
}

/// Adds what is of chamber 1, then what is of chamber 2.
#[inline(always)]
fn add_each(sum: &mut f64, of: f64x2) {
    let [first, second] = of.to_array();
    *sum = *sum + first + second;
}
