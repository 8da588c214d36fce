//! Whether claims are about runs of the plan.

use super::claim::{Claim, Statistic};
use super::planned_run::PlannedRun;
use rimbench_core::error::{Error, Result};
use rimbench_results::selection::{ALL, has_words};
use std::collections::BTreeSet;

/// Checks that each claim is about runs of the plan, and about one case and one set of parameters unless it says
/// otherwise.
///
/// # Errors
/// A claim about a scheme, case, set, metric or macro step that the plan does not have, one that pools without saying
/// so, one whose id is taken.
pub(super) fn check_claims_against_plan(claims: &[Claim], planned: &[PlannedRun]) -> Result<()> {
    for (index, claim) in claims.iter().enumerate() {
        if claims[..index].iter().any(|earlier| earlier.id == claim.id) {
            return Err(Error::Incompatible(format!("two claims have the id `{}`", claim.id)));
        }
        check_claim_id(&claim.id)?;
        if claim.relative_to.as_ref() == Some(&claim.scheme) {
            let Claim { id, scheme, .. } = claim;
            let message = format!("claim `{id}` is about `{scheme}` relative to itself; valid: another label");
            return Err(Error::Incompatible(message));
        }
        claim.check_equal_cost()?;
        claim.check_share()?;
        claim.check_ends()?;
        claim.check_within()?;
        claim.check_threshold()?;
        claim.check_witnesses()?;
        claim.check_variant(claims)?;
        for label in std::iter::once(&claim.scheme).chain(&claim.relative_to) {
            let of_label = || planned.iter().filter(|run| claim.names(label, &run.label));
            if of_label().next().is_none() {
                let mut valid: Vec<&str> = planned.iter().map(|run| run.label.as_str()).collect();
                valid.dedup();
                return Err(Error::unknown("scheme of a claim", label, valid));
            }
            claim.check_problems(of_label())?;
            claim.check_unit(of_label())?;
            if !of_label().any(|run| claim.is_about(run.spec.macro_step)) {
                let step = claim.macro_step_s.unwrap_or(f64::NAN);
                let message =
                    format!("claim `{}` is about macro_step_s = {step}, which `{label}` does not run", claim.id);
                return Err(Error::Incompatible(message));
            }
        }
        claim.check_steps(planned)?;
        claim.check_shares(planned)?;
    }
    Ok(())
}

/// Checks that an id can stand in a table, an address and a path of one, as in `fig2/smooth-unstable`.
///
/// # Errors
/// [`Error::InvalidValue`] for one that cannot.
pub(crate) fn check_claim_id(id: &str) -> Result<()> {
    let is_letter = |c: char| c.is_ascii_alphanumeric();
    if id.starts_with(is_letter) && id.len() <= LONGEST_ID && id.chars().all(|c| is_letter(c) || "-_.".contains(c)) {
        return Ok(());
    }
    let expected = format!("letters, digits, `-`, `_` and `.`, a letter or digit first, at most {LONGEST_ID}");
    Err(Error::invalid("id of a claim", format!("{id:?}"), expected))
}

/// A metric that machines have in common.
const OF_PEAK: &str = "force_error_rms_of_peak";

/// Longest id of a claim.
const LONGEST_ID: usize = 100;

impl Claim {
    /// Checks that what is compared at equal counts is something else than itself, at all its macro steps.
    fn check_equal_cost(&self) -> Result<()> {
        if let (Some(without), None) = (&self.without, self.budgets()) {
            let message = format!("claim `{}`: without = \"{without}\" needs budgets in at_equal", self.id);
            return Err(Error::Incompatible(message));
        }
        let Some(equal) = &self.at_equal else { return Ok(()) };
        if self.relative_to.is_some() && self.macro_step_s.is_none() && self.statistic != Statistic::Order {
            return Ok(());
        }
        Err(Error::Incompatible(format!(
            "claim `{}`: at_equal = \"{equal}\" needs relative_to, no macro_step_s, and a statistic other than order",
            self.id
        )))
    }

    /// Checks that how runs end is taken as shares and times only: of a share that completed more is better, and none
    /// has an order.
    fn check_ends(&self) -> Result<()> {
        let is_error = self.at_equal.is_some() || matches!(self.statistic, Statistic::Order | Statistic::ShareBetter);
        if !(self.is_about_ends() && is_error) {
            return Ok(());
        }
        let (id, metric) = (&self.id, self.metric.name());
        Err(Error::Incompatible(format!(
            "claim `{id}`: {metric} is no error, of which less is better: use statistic mean, median, min or max, without at_equal"
        )))
    }

    /// Checks that a share of settings has something to be better than.
    fn check_share(&self) -> Result<()> {
        let Claim { id, statistic, .. } = self;
        let wrong = |apart: &f64| *statistic != Statistic::ShareBetter || !(*apart > 0.0 && *apart < 1.0);
        if let Some(apart) = self.apart.filter(wrong) {
            return Err(Error::Incompatible(format!(
                "claim `{id}`: apart = {apart} is not valid; valid: a share between 0 and 1, with statistic = \"share-better\""
            )));
        }
        if self.statistic != Statistic::ShareBetter || (self.relative_to.is_some() && self.at_equal.is_none()) {
            return Ok(());
        }
        let message = format!("claim `{}`: statistic = \"share-better\" needs relative_to, and no at_equal", self.id);
        Err(Error::Incompatible(message))
    }

    /// Checks that a threshold is looked for among all the macro steps of one row.
    fn check_threshold(&self) -> Result<()> {
        let alone = self.relative_to.is_none() && self.at_equal.is_none() && self.macro_step_s.is_none();
        if !self.statistic.is_threshold() || (alone && self.above.is_none() && self.within.is_none()) {
            return Ok(());
        }
        let id = &self.id;
        Err(Error::Incompatible(format!(
            "claim `{id}`: a threshold takes no relative_to, at_equal, macro_step_s, above or within"
        )))
    }

    /// Checks that runs are not chosen by how they end where these ends are counted.
    fn check_witnesses(&self) -> Result<()> {
        if self.witnesses.is_none() || !self.counts_ends() {
            return Ok(());
        }
        Err(Error::Incompatible(format!(
            "claim `{}`: witnesses chooses runs by how they end, which {}, within and thresholds count: leave it out",
            self.id,
            self.metric.name()
        )))
    }

    /// Checks that usable runs are counted by a metric, within a bound that can be met.
    fn check_within(&self) -> Result<()> {
        if let Some(above) = self.above.filter(|above| !above.is_finite()) {
            let key = format!("claim `{}`: above", self.id);
            return Err(Error::invalid(key, format!("{above:?}"), "a finite number"));
        }
        let Some(within) = self.within else { return Ok(()) };
        let is_count = self.metric.metric().is_some()
            && self.above.is_none()
            && self.at_equal.as_ref().is_none_or(|equal| equal.counter().is_none())
            && self.statistic == Statistic::Mean;
        if is_count && within.is_finite() && within >= 0.0 {
            return Ok(());
        }
        Err(Error::Incompatible(format!(
            "claim `{}`: within = {within:?} needs a number from 0, statistic = \"mean\" and a metric, and no above or counter in at_equal",
            self.id
        )))
    }

    /// Checks that what it is a variant of is a statement of the same claimant in the same file; those of other files
    /// have no ids here.
    fn check_variant(&self, claims: &[Claim]) -> Result<()> {
        if self.variant_of.is_empty() || self.variant_of.contains('/') {
            return Ok(());
        }
        let statements = || claims.iter().filter(|other| other.variant_of.is_empty() && other.by == self.by);
        match statements().any(|other| other.id == self.variant_of) {
            true => Ok(()),
            false => Err(Error::unknown(
                "statement in variant_of",
                &self.variant_of,
                statements().map(|other| other.id.as_str()),
            )),
        }
    }

    /// Checks that the case and the set it names are there, and that it names them where there are several.
    fn check_problems<'a>(&self, runs: impl Iterator<Item = &'a PlannedRun>) -> Result<()> {
        let problems: BTreeSet<(&str, &str)> = runs.map(|run| (&*run.spec.case.name, &*run.set)).collect();
        let cases: BTreeSet<&str> = problems.iter().map(|(case, _)| *case).collect();
        let named = self.case.as_deref().filter(|case| *case != ALL);
        if let Some(case) = named.filter(|case| !cases.contains(case)) {
            return Err(Error::unknown("case of a claim", case, cases));
        }
        if self.case.is_none() && cases.len() > 1 {
            return Err(self.pools("case", cases));
        }
        let of_case = |case: &&(&str, &str)| named.is_none_or(|named| case.0 == named);
        let sets: BTreeSet<&str> = problems.iter().filter(of_case).map(|(_, set)| *set).collect();
        match self.set.as_deref() {
            Some(ALL) => Ok(()),
            Some(set) if !sets.contains(set) && !sets.iter().any(|own| has_words(own, set)) => {
                Err(Error::unknown("set of a claim", set, sets))
            }
            Some(_) => Ok(()),
            // Over several cases it is enough that none of them has several sets.
            None if problems.iter().filter(of_case).count() > cases.len().min(named.map_or(usize::MAX, |_| 1)) => {
                Err(self.pools("set", sets))
            }
            None => Ok(()),
        }
    }

    /// Whether a run is of the case and the set that it is about.
    fn is_of_problem(&self, run: &PlannedRun) -> bool {
        let case = self.case.as_deref().is_none_or(|case| case == ALL || run.spec.case.name == case);
        case && self.set.as_deref().is_none_or(|set| set == ALL || &*run.set == set || has_words(&run.set, set))
    }

    /// The runs of a label that it is about.
    fn runs_of<'a>(&self, label: &str, planned: &'a [PlannedRun]) -> impl Iterator<Item = &'a PlannedRun> {
        let is_about = |run: &PlannedRun| self.is_of_problem(run) && self.is_about(run.spec.macro_step);
        planned.iter().filter(move |run| run.label == *label && is_about(run))
    }

    /// Checks that what has a unit is not pooled over machines: a newton of one is not a newton of another. Machines
    /// are cases, and settings that were drawn.
    fn check_unit<'a>(&self, runs: impl Iterator<Item = &'a PlannedRun>) -> Result<()> {
        let Some(metric) = self.metric.metric().filter(|metric| metric.unit != "-") else { return Ok(()) };
        let within_budgets = self.budgets().is_some();
        let compares = self.is_about_ratios() || self.statistic == Statistic::ShareBetter || within_budgets;
        let machine = |run: &'a PlannedRun| (&run.spec.case.name, run.pooled_set.as_ref().map(|_| &run.set));
        let machines: BTreeSet<_> = runs.filter(|run| self.is_of_problem(run)).map(machine).collect();
        if compares || machines.len() < 2 {
            return Ok(());
        }
        let (id, count) = (&self.id, machines.len());
        Err(Error::Incompatible(format!(
            "claim `{id}`: metric = \"{}\" would pool {} of {count} machines, and none of one is worth as much as of \
             another; valid: a metric without a unit (as {OF_PEAK}), relative_to, or one machine in case and set",
            metric.name, metric.unit
        )))
    }

    /// Checks that of two rows that are compared there is a macro step in common, or one of each.
    fn check_steps(&self, planned: &[PlannedRun]) -> Result<()> {
        let Some(other) = self.relative_to.as_ref().filter(|_| self.is_about_ratios() && self.at_equal.is_none())
        else {
            return Ok(());
        };
        let [own, other] = [&self.scheme, other].map(|label| -> BTreeSet<u64> {
            self.runs_of(label, planned).map(|run| run.spec.macro_step.to_bits()).collect()
        });
        if !own.is_disjoint(&other) || (own.len() < 2 && other.len() < 2) {
            return Ok(());
        }
        Err(Error::Incompatible(format!(
            "claim `{}`: `{}` and relative_to = \"{}\" have no macro step in common; valid: rows with one, or with one step each",
            self.id,
            self.scheme,
            self.relative_to.as_deref().unwrap_or_default()
        )))
    }

    /// Checks that two shares whose ratio it is about are of the same runs.
    fn check_shares(&self, planned: &[PlannedRun]) -> Result<()> {
        let is_of_shares =
            !matches!(self.statistic, Statistic::Order | Statistic::ShareBetter) && !self.is_about_ratios();
        let Some(other) = self.relative_to.as_ref().filter(|_| is_of_shares && self.budgets().is_none()) else {
            return Ok(());
        };
        let [own, others] = [&self.scheme, other].map(|label| {
            let key = |run| {
                let PlannedRun { spec, set, .. }: &PlannedRun = run;
                (&spec.case.name, set, spec.macro_step.to_bits(), spec.phase.to_bits())
            };
            self.runs_of(label, planned).map(key).collect::<BTreeSet<_>>()
        });
        if own == others {
            return Ok(());
        }
        let (id, scheme, runs) = (&self.id, &self.scheme, [own.len(), others.len()]);
        Err(Error::Incompatible(format!(
            "claim `{id}`: relative_to = \"{other}\" holds a share of {} runs of `{scheme}` against one of {} other runs; \
             valid: rows with the same cases, sets, macro steps and phases",
            runs[0], runs[1]
        )))
    }

    fn pools(&self, key: &str, values: BTreeSet<&str>) -> Error {
        let values: Vec<String> = values.into_iter().map(|value| format!("\"{value}\"")).collect();
        Error::Incompatible(format!(
            "claim `{}` would pool several: say {key} = one of {}, or {key} = \"{ALL}\"",
            self.id,
            values.join(", ")
        ))
    }
}
