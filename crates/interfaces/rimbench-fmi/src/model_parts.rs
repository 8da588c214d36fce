//! The parts of a reduced interface model as variables of an FMU: one list for whoever writes, looks up or reads them.

use self::Extent::{Contacts, Interface, Rows};
use self::Needs::{Always, WithContacts, WithFriction, WithPlastic};
use self::PartType::{Number, Truth, Whole};
use rimbench_core::contact_law::ContactSpring;
use rimbench_core::friction::{ContactState, Stiction};
use rimbench_core::interface_model::ReducedInterfaceModel;
use serde::{Deserialize, Serialize};

/// A part of the reduced interface model, for `n = n_u + n_i` rows, contacts first; with friction `n = 2 n_u + n_i`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelPart {
    /// `H`, n×n, 1/kg.
    H,
    /// Free accelerations, n, m/s².
    A,
    /// Velocities, n, m/s.
    W,
    /// Interface coordinates, n_i, m.
    Position,
    /// Gaps, n_u, m.
    Gap,
    /// Approaches that the mechanics' steps make by themselves, n_u, m/s.
    DiscretisationApproach,
    /// Whether a contact was at its bound in the last step, n_u.
    AtBound,
    /// Which contacts are plastic while others rebound, n_u.
    Plastic,
    /// γ.
    Stabilisation,
    /// e.
    Restitution,
    /// k of compliant contacts, N/m; 0: rigid.
    Stiffness,
    /// c of compliant contacts, N·s/m.
    Damping,
    /// Coefficients of friction of the next step, n_u.
    Friction,
    /// Coefficient of a contact at rest, where that is another; else 0.
    FrictionAtRest,
    /// Likewise of one that slides.
    FrictionInMotion,
    /// Restitution along the surface.
    TangentialRestitution,
    /// What contacts did in the last step, n_u: [`ContactState`](rimbench_core::friction::ContactState) by its number.
    State,
    /// From which the next contact problem starts, likewise.
    SolvedState,
}

/// Type of a part, in the words of FMI: Float64, Boolean, Int32.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PartType {
    /// Float64.
    Number,
    /// Boolean.
    Truth,
    /// Int32.
    Whole,
}

/// An extent of an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Extent {
    Rows,
    Contacts,
    Interface,
}

/// What a model must have for a part to be there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Needs {
    Always,
    WithContacts,
    WithPlastic,
    WithFriction,
}

/// A part as a variable.
#[derive(Debug, PartialEq, Eq)]
pub struct PartVariable {
    /// Which part it is.
    pub part: ModelPart,
    /// The name of the variable.
    pub name: &'static str,
    /// Its type.
    pub part_type: PartType,
    /// Its unit; empty where it has none.
    pub unit: &'static str,
    /// One line.
    pub about: &'static str,
    extents: &'static [Extent],
    needs: Needs,
}

const fn part(
    part: ModelPart,
    (name, part_type, unit): (&'static str, PartType, &'static str),
    extents: &'static [Extent],
    needs: Needs,
    about: &'static str,
) -> PartVariable {
    PartVariable { part, name, part_type, unit, about, extents, needs }
}

/// All parts, in the order in which they are listed and told.
#[rustfmt::skip]
static PARTS: [PartVariable; 18] = [
    part(ModelPart::H, ("rim.H", Number, "1/kg"), &[Rows, Rows], Always,
        "[H_uu H_ui; H_iu H_ii], contacts first, with friction their tangential rows behind them"),
    part(ModelPart::A, ("rim.a", Number, "m/s²"), &[Rows], Always, "free accelerations [a_u; a_i]"),
    part(ModelPart::W, ("rim.w", Number, "m/s"), &[Rows], Always, "velocities [w_u; w_i]"),
    part(ModelPart::Position, ("rim.position", Number, "m"), &[Interface], Always, "coordinates"),
    part(ModelPart::Gap, ("rim.gap", Number, "m"), &[Contacts], WithContacts, "gaps, below zero in penetration"),
    part(ModelPart::DiscretisationApproach, ("rim.discretisation_approach", Number, "m/s"), &[Contacts], WithContacts,
        "approaches that the mechanics' steps make by themselves, of which nothing bounces back"),
    part(ModelPart::AtBound, ("rim.at_bound", Truth, ""), &[Contacts], WithContacts,
        "whether a contact was at its bound in the last step"),
    part(ModelPart::Plastic, ("rim.plastic", Truth, ""), &[Contacts], WithPlastic,
        "whether a contact never rebounds, also with a restitution above 0"),
    part(ModelPart::Stabilisation, ("rim.stabilisation", Number, ""), &[], Always,
        "fraction of a penetration that the mechanics removes in one step"),
    part(ModelPart::Restitution, ("rim.restitution", Number, ""), &[], Always, "restitution of closing contacts"),
    part(ModelPart::Stiffness, ("rim.contact_stiffness", Number, "N/m"), &[], Always,
        "stiffness of compliant contacts; 0: rigid"),
    part(ModelPart::Damping, ("rim.contact_damping", Number, "N·s/m"), &[], Always, "damping of compliant contacts"),
    part(ModelPart::Friction, ("rim.friction", Number, ""), &[Contacts], WithFriction,
        "coefficients of friction in the step that starts here"),
    part(ModelPart::FrictionAtRest, ("rim.friction_at_rest", Number, ""), &[], WithFriction,
        "coefficient of friction of a contact that stood still; 0: coefficients do not change"),
    part(ModelPart::FrictionInMotion, ("rim.friction_in_motion", Number, ""), &[], WithFriction,
        "coefficient of friction of any other contact; 0: coefficients do not change"),
    part(ModelPart::TangentialRestitution, ("rim.tangential_restitution", Number, ""), &[], WithFriction,
        "restitution of closing contacts along the surface"),
    part(ModelPart::State, ("rim.state", Whole, ""), &[Contacts], WithFriction,
        "what contacts did in the last step: 0 open, 1 sticking, 2 sliding forwards, 3 backwards"),
    part(ModelPart::SolvedState, ("rim.solved_state", Whole, ""), &[Contacts], WithFriction,
        "states from which the next contact problem starts, numbered likewise"),
];

impl PartVariable {
    /// Returns the extents of its array in a model of this size; empty: one value.
    pub fn dimensions(&self, size: ModelSize) -> Vec<usize> {
        self.extents.iter().map(|extent| size.extent(*extent)).collect()
    }

    /// Returns how many values it has in a model of this size.
    pub fn count(&self, size: ModelSize) -> usize {
        self.extents.iter().map(|extent| size.extent(*extent)).product()
    }
}

/// How large an interface model is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct ModelSize {
    /// Number of contacts n_u.
    pub contacts: usize,
    /// Number of interface rows n_i.
    pub interface: usize,
    /// Whether contacts have tangential rows.
    pub friction: bool,
    /// Whether some contacts are plastic while others rebound.
    pub plastic: bool,
    /// Whether contacts are rows of an engine, at most as many.
    pub engine: bool,
}

impl ModelSize {
    /// Reads the size of a model.
    pub fn of(model: &ReducedInterfaceModel) -> Self {
        ModelSize {
            contacts: model.contacts(),
            interface: model.interface(),
            friction: model.has_friction(),
            plastic: !model.plastic.is_empty(),
            engine: model.has_targets,
        }
    }

    /// Lists the parts that a model of this size has.
    pub fn parts(self) -> impl Iterator<Item = &'static PartVariable> {
        PARTS.iter().filter(move |variable| match variable.needs {
            Always => true,
            WithContacts => self.contacts > 0,
            WithPlastic => self.plastic,
            WithFriction => self.friction,
        })
    }

    fn extent(self, extent: Extent) -> usize {
        match extent {
            Rows => self.contacts * if self.friction { 2 } else { 1 } + self.interface,
            Contacts => self.contacts,
            Interface => self.interface,
        }
    }

    /// Takes rows of an engine: how many, how many steps it takes, whether H is symmetric; H, a, w, position, gap; R, b,
    /// k and the opposite edge of each row.
    fn read_rows(self, numbers: &[f64], model: &mut ReducedInterfaceModel) -> Result<(), String> {
        let few = || "its interface model has too few numbers".to_owned();
        let [rows, steps, symmetric, rest @ ..] = numbers else { return Err(few()) };
        let (rows, mut rest) = (*rows as usize, rest);
        if rows > self.contacts {
            let room = self.contacts;
            return Err(format!(
                "the engine has {rows} rows at once, and there is room for {room}; valid: engine_rows={rows} or more"
            ));
        }
        model.set_contacts(rows);
        let mut next = |count: usize| rest.split_off(..count).ok_or_else(few);
        for part in [&mut model.h, &mut model.a, &mut model.w, &mut model.position, &mut model.gap] {
            let told = next(part.len())?;
            part.copy_from_slice(told);
        }
        (model.own_steps, model.unsymmetric) = ((*steps as usize).max(1), *symmetric == 0.0);
        model.take_targets([next(rows)?, next(rows)?, next(rows)?, next(rows)?])
    }

    /// Takes the parts of a model that were told one after the other.
    ///
    /// # Errors
    /// Too few numbers, and numbers that say nothing.
    pub(crate) fn read(self, mut numbers: &[f64], model: &mut ReducedInterfaceModel) -> Result<(), String> {
        if self.engine {
            return self.read_rows(numbers, model);
        }
        let (mut spring, mut stiction) = ([0.0; 2], [0.0; 2]);
        for variable in self.parts() {
            let told = numbers.split_off(..variable.count(self));
            let told = told.ok_or_else(|| "its interface model has too few numbers".to_owned())?;
            match variable.part {
                ModelPart::H => model.h.copy_from_slice(told),
                ModelPart::A => model.a.copy_from_slice(told),
                ModelPart::W => model.w.copy_from_slice(told),
                ModelPart::Position => model.position.copy_from_slice(told),
                ModelPart::Gap => model.gap.copy_from_slice(told),
                // Without restitution nothing bounces back anyway, and there is no room for it.
                ModelPart::DiscretisationApproach if model.discretisation_approach.is_empty() => {}
                ModelPart::DiscretisationApproach => model.discretisation_approach.copy_from_slice(told),
                ModelPart::AtBound => truths(&mut model.at_bound, told),
                ModelPart::Plastic => truths(&mut model.plastic, told),
                ModelPart::Stabilisation => model.stabilisation = told[0],
                ModelPart::Restitution => model.restitution = told[0],
                ModelPart::Stiffness => spring[0] = told[0],
                ModelPart::Damping => spring[1] = told[0],
                ModelPart::Friction => model.friction.copy_from_slice(told),
                ModelPart::FrictionAtRest => stiction[0] = told[0],
                ModelPart::FrictionInMotion => stiction[1] = told[0],
                ModelPart::TangentialRestitution => model.tangential_restitution = told[0],
                ModelPart::State => states(&mut model.states, told)?,
                ModelPart::SolvedState => states(&mut model.solved_states, told)?,
            }
        }
        let [stiffness, damping] = spring;
        model.spring = (stiffness > 0.0).then_some(ContactSpring { stiffness, damping });
        let [at_rest, in_motion] = stiction;
        model.stiction = (at_rest > 0.0).then_some(Stiction { at_rest, in_motion });
        Ok(())
    }

    /// Makes a model of this size with nothing in it.
    pub(crate) fn empty(self) -> ReducedInterfaceModel {
        if self.friction {
            ReducedInterfaceModel::zeros_with_friction(&vec![0.0; self.contacts], self.interface)
        } else if self.engine {
            let mut empty = ReducedInterfaceModel::zeros_with_targets(self.contacts, self.interface);
            empty.inertia_varies = true;
            empty
        } else {
            ReducedInterfaceModel::zeros(self.contacts, self.interface)
        }
    }
}

fn truths(all: &mut [bool], told: &[f64]) {
    all.iter_mut().zip(told).for_each(|(truth, told)| *truth = *told != 0.0);
}

fn states(all: &mut [ContactState], told: &[f64]) -> Result<(), String> {
    let most = ContactState::ALL.len() - 1;
    for (state, number) in all.iter_mut().zip(told) {
        let known = ContactState::of_number(*number);
        *state =
            known.ok_or_else(|| format!("its interface model has a contact in state {number}; valid: 0 to {most}"))?;
    }
    Ok(())
}

impl ModelPart {
    /// Appends this part of a model; a truth is 1 or 0.
    pub(crate) fn append(self, model: &ReducedInterfaceModel, to: &mut Vec<f64>) {
        let rows = model.interface_start() + model.interface();
        let contacts = 0..model.contacts();
        match self {
            ModelPart::H => to.extend((0..rows * rows).map(|at| model.entry(at / rows, at % rows))),
            ModelPart::A => to.extend_from_slice(&model.a),
            ModelPart::W => to.extend_from_slice(&model.w),
            ModelPart::Position => to.extend_from_slice(&model.position),
            ModelPart::Gap => to.extend_from_slice(&model.gap),
            ModelPart::DiscretisationApproach => {
                to.extend(contacts.map(|contact| model.discretisation_approach_of(contact).0));
            }
            ModelPart::AtBound => to.extend(model.at_bound.iter().map(|truth| f64::from(u8::from(*truth)))),
            ModelPart::Plastic => to.extend(contacts.map(|contact| f64::from(u8::from(model.is_plastic(contact))))),
            ModelPart::Stabilisation => to.push(model.stabilisation),
            ModelPart::Restitution => to.push(model.restitution),
            ModelPart::Stiffness => to.push(model.spring.map_or(0.0, |spring| spring.stiffness)),
            ModelPart::Damping => to.push(model.spring.map_or(0.0, |spring| spring.damping)),
            ModelPart::Friction => to.extend_from_slice(&model.friction),
            ModelPart::FrictionAtRest => to.push(model.stiction.map_or(0.0, |stiction| stiction.at_rest)),
            ModelPart::FrictionInMotion => to.push(model.stiction.map_or(0.0, |stiction| stiction.in_motion)),
            ModelPart::TangentialRestitution => to.push(model.tangential_restitution),
            ModelPart::State => to.extend(model.states.iter().map(|state| *state as i32 as f64)),
            ModelPart::SolvedState => to.extend(model.solved_states.iter().map(|state| *state as i32 as f64)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_told_part_by_part_is_the_model_again() {
        let size = ModelSize { contacts: 2, interface: 1, friction: true, plastic: true, engine: false };
        let mut model = size.empty();
        let mut next = 0.0;
        let mut fresh = || {
            next += 0.5;
            next
        };
        for list in [&mut model.h, &mut model.a, &mut model.w, &mut model.position, &mut model.gap] {
            list.iter_mut().for_each(|entry| *entry = fresh());
        }
        // An FMU hands over half of H, as it is symmetric.
        for (at, entry) in model.h.iter_mut().enumerate() {
            *entry = 1.0 + (at / 5 + at % 5) as f64;
        }
        (model.discretisation_approach, model.plastic) = (vec![0.0, 0.25], vec![true, false]);
        (model.at_bound, model.stabilisation, model.restitution) = (vec![false, true], 0.2, 0.6);
        model.spring = Some(ContactSpring { stiffness: 1e4, damping: 3.0 });
        model.friction = vec![0.3, 0.4];
        model.stiction = Some(Stiction { at_rest: 0.5, in_motion: 0.4 });
        model.tangential_restitution = 0.1;
        (model.states[1], model.solved_states[0]) = (ContactState::ALL[2], ContactState::ALL[3]);
        let told = |model: &ReducedInterfaceModel| {
            let mut numbers = Vec::new();
            size.parts().for_each(|variable| {
                let from = numbers.len();
                variable.part.append(model, &mut numbers);
                assert_eq!(numbers.len() - from, variable.count(size), "{}", variable.name);
            });
            numbers
        };
        let mut again = size.empty();
        (again.discretisation_approach, again.plastic) = (vec![0.0; 2], vec![false; 2]);
        size.read(&told(&model), &mut again).unwrap();
        assert_eq!(told(&again), told(&model));
        assert_eq!((&again.plastic, again.spring, again.stiction), (&model.plastic, model.spring, model.stiction));
        let few = size.read(&told(&model)[1..], &mut again).unwrap_err();
        assert!(few.contains("too few"), "{few}");
    }
}
