//! What the interface model of an audited run created, by origin: the parts add up to minus the interface residual. A
//! jump alone is an upper bound, because the model's own contacts take energy.

use super::evidence::metrics;

metrics! {
    BY_JUMP: "created_by_jump_j" in "J" (signed) of Audit,
    "Energy gained (above 0) or lost as the model's end was replaced by that of the mechanics: one part of what the model created, which is minus \
     the interface residual"
    => |evidence| evidence.report.audit.model.map(|model| model.jump);

    BY_FIRST_MOMENT: "created_by_first_moment_j" in "J" (signed) of Audit,
    "Energy created by the bias, because the mechanics received the force at other times than it acted"
    => |evidence| evidence.report.audit.model.map(|model| model.first_moment);

    BY_MASS: "created_by_mass_j" in "J" (signed) of Believed,
    "Energy created by the mass alone that the model has too much, contacts aside, where what is believed of the mechanics is wrong"
    => |evidence| evidence.report.audit.model.map(|model| model.mass).filter(|mass| *mass != 0.0);

    BY_CONTACTS: "created_by_contacts_j" in "J" (signed) of Audit,
    "Energy created because contacts lost less in the model, micro steps included, than in the mechanics"
    => |evidence| evidence.report.audit.model.map(|model| model.contacts);

    UNFROZEN: "created_unfrozen_j" in "J" (signed) of Audit,
    "Energy created because the mechanics' own steps were not those of the frozen model"
    => |evidence| evidence.report.audit.model.map(|model| model.unfrozen);

    BY_AGE: "created_by_age_j" in "J" (signed) of Late,
    "Energy created because the samples that the interface model was made of were late"
    => |evidence| evidence.report.audit.model.map(|model| model.age);

    LARGEST_JUMP: "largest_jump_j" in "J" of Audit,
    "Most energy gained in one jump, which bounds from above what was created there; 0 if no jump gained any"
    => |evidence| Some(evidence.report.audit.model?.largest.map_or(0.0, |jump| jump.energy));

    LEARNED_MASS: "learned_mass_factor" in "-" (ideal_one) of Claimed,
    "Factor on the mass that the receiver has learned at the end"
    => |evidence| evidence.report.learned_mass;

    LATE_ACCELERATION: "late_acceleration_correlation" in "-" (correlation) of Claimed,
    "Least correlation of the mechanics' free accelerations that are no farther apart than samples are old: below 0 they turn round meanwhile"
    => |evidence| evidence.report.late_acceleration_correlation;

    CATCH_UP: "catch_up_per_micro_step" in "-" of Claimed,
    "Micro steps of the model that catching up with late samples takes, for each micro step of the actuator"
    => |evidence| {
        let work = &evidence.report.work;
        (work.cosim.catch_up_steps > 0).then(|| work.cosim.catch_up_steps as f64 / work.sides.actuator.micro_steps as f64)
    };

    HEAVINESS: "heaviness_max" in "-" (signed) of Audit,
    "Largest eigenvalue of H_mech − H_model over the run, relative to H_ii: above 0 the model was heavier than the mechanics"
    => |evidence| {
        // NaN where the audit was asked for and failed; no cell where it was not asked for.
        evidence.report.audit.model.map(|model| model.heaviness).or(evidence.audited.then_some(f64::NAN))
    };
}
