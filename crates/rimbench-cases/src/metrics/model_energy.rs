//! What the interface model of an audited run created, by origin; the parts add up to minus the interface residual.

use super::evidence::Metric;

/// A metric of the account, in J.
macro_rules! of_model {
    ($name:literal, $about:literal, $of:expr) => {
        Metric {
            name: $name,
            unit: "J",
            floor: None,
            about: $about,
            compute: |evidence| evidence.report.audit.model.map($of),
        }
    };
}

pub(super) const BY_JUMP: Metric = of_model!(
    "created_by_jump_j",
    "Energy that the interface model created (above 0) or lost as its end was replaced by that of the mechanics",
    |model| model.jump
);
pub(super) const BY_FIRST_MOMENT: Metric = of_model!(
    "created_by_first_moment_j",
    "Energy created by the bias, because the mechanics received the force at other times than it acted",
    |model| model.first_moment
);
pub(super) const BY_CONTACTS: Metric = of_model!(
    "created_by_contacts_j",
    "Energy created because contacts lost less in the model, micro steps included, than in the mechanics",
    |model| model.contacts
);
pub(super) const UNFROZEN: Metric = of_model!(
    "created_unfrozen_j",
    "Energy created because the mechanics' own steps were not those of the frozen model",
    |model| model.unfrozen
);
pub(super) const LARGEST_JUMP: Metric = of_model!(
    "largest_jump_j",
    "Most energy that the interface model created at one communication point; 0 if it created none at any",
    |model| model.largest.map_or(0.0, |jump| jump.energy)
);
pub(super) const HEAVINESS: Metric = Metric {
    name: "heaviness_max",
    unit: "-",
    floor: None,
    about: "Largest eigenvalue of H_mech − H_model over the run, relative to H_ii: above 0 the model was heavier than the mechanics",
    // What was asked for and could not be found is no number, which is not the same as no cell.
    compute: |evidence| {
        let asked = evidence.run.index_of("heaviness").map(|_| f64::NAN);
        evidence.report.audit.model.map(|model| model.heaviness).or(asked)
    },
};
