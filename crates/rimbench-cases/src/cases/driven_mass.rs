//! What the cases of one mass between stops share: both sides, and their solution from impact to impact.

use super::carriage;
use super::case::CoupledSystem;
use super::contact_parameters;
use super::event_driven::{DrivenMass, EventDriven, Stop};
use super::parameters::Parameters;
use super::reference_method::ExactSolution;
use crate::models::{LineContact, LineDescription, LineMass, LineMasses};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::{Error, Result};
use rimbench_core::interface_model::TOUCHING;
use rimbench_core::name::Name;
use std::sync::{Mutex, PoisonError};

/// Names of the contacts.
pub(super) struct StopNames {
    pub(super) gaps: Vec<Name>,
    pub(super) forces: Vec<Name>,
}

/// Both sides.
pub(super) fn system(
    mass: DrivenMass,
    names: &StopNames,
    parameters: &Parameters,
    solver: &SolverEntry,
) -> Result<CoupledSystem> {
    let contact = |stop: &Stop| LineContact {
        below: (stop.side < 0.0).then_some(0),
        above: (stop.side > 0.0).then_some(0),
        distance: stop.side * stop.position,
    };
    let model = LineMasses::new(LineDescription {
        masses: vec![LineMass {
            mass: mass.mass,
            stiffness: mass.stiffness,
            damping: mass.damping,
            anchor: 0.0,
            load: mass.load,
            start: mass.start,
        }],
        springs: Vec::new(),
        joints: Vec::new(),
        contacts: mass.stops.iter().map(contact).collect(),
        driven: 0,
        state_names: Vec::new(),
        gap_names: names.gaps.clone(),
        contact_force_names: names.forces.clone(),
    })?;
    contact_parameters::coupled(model, carriage::actuator(parameters)?, parameters, solver)
}

/// The solution: rows of time, interface position and velocity, force of the actuator, force received, carriage position and
/// velocity, effective mass, gaps, number of closed contacts.
///
/// What the mechanics received is the force itself, and the effective mass is infinite while a stop holds the mass.
pub(super) fn solution(mass: DrivenMass) -> ExactSolution {
    let solved = Mutex::new(EventDriven::new(mass.clone()));
    let stops = mass.stops.len();
    Box::new(move |t, row| {
        let (z, stuck) = solved.lock().unwrap_or_else(PoisonError::into_inner).at(t);
        let force = mass.force(&z);
        let effective_mass = if stuck { f64::INFINITY } else { mass.mass };
        row[..8].copy_from_slice(&[t, z[0], z[1], force, force, z[2], z[3], effective_mass]);
        let (gaps, closed) = row[8..].split_at_mut(stops);
        for (gap, stop) in gaps.iter_mut().zip(&mass.stops) {
            *gap = stop.gap(z[0]);
        }
        closed[0] = gaps.iter().filter(|gap| **gap <= TOUCHING).count() as f64;
    })
}

/// Refuses a start outside the stops, by the name of its parameter.
pub(super) fn check_start(mass: &DrivenMass, key: &str) -> Result<()> {
    for stop in &mass.stops {
        let gap = stop.gap(mass.start[0]);
        if gap < 0.0 {
            let bound = if stop.side > 0.0 { "at least" } else { "at most" };
            return Err(Error::invalid(
                key,
                mass.start[0],
                format!("{bound} {} m, where the stop is; it would start {} m inside", stop.position, -gap),
            ));
        }
    }
    Ok(())
}
