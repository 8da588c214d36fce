//! What determines a run, as one list: run id, tables, JSON and plans all read it.

use super::fact::{Fact, FactValue};
use super::options::facts_of;
use super::spec::RunSpec;
use crate::metrics::{METRICS, Only};
use rimbench_core::name::Name;
use rimbench_core::numerics_version::NUMERICS_VERSION;
use rimbench_core::schemes::Requirement;
use sha2::{Digest, Sha256};
use std::fmt::{self, Write};

/// Facts of what is not built in: digests of its code.
pub(super) const CODE: [&str; 3] = ["case_digest", "scheme_digest", "solver_digest"];

/// Finds the runs that a metric or a counter, by its column in tables, says something of; none where these are all.
pub fn only_of(column: &str) -> Option<Only> {
    let metric = METRICS.iter().find(|metric| metric.name == column);
    metric.map_or_else(|| (column == "catch_up_steps").then_some(Only::Late), |metric| metric.only)
}

impl RunSpec {
    /// Tells whether a table of this run has a column that is of `only` such runs; of what is claimed the claims tell.
    pub fn has_column(&self, column: &str, only: Only) -> bool {
        match only {
            Only::Split => self.star.is_some(),
            Only::Trials => self.scheme.needs.contains(&Requirement::Trials),
            Only::Audit => self.audit,
            Only::Divided => self.divide_error,
            Only::Believed => self.audit && self.belief.is_some(),
            Only::Late => self.delivery.is_some(),
            Only::Column => self.case.trace_columns.iter().any(|own| own == column),
            Only::Friction | Only::Claimed => true,
        }
    }

    /// Lists everything that determines the run: what options say, the parameters of the case behind the case, the
    /// audit, and the code of what is not built in.
    pub fn facts(&self) -> Vec<Fact> {
        let mut facts: Vec<Fact> = facts_of(self).collect();
        facts.insert(1, Fact::text("set", self.parameters.given()));
        facts.push(Fact::new("audit", self.audit.then_some(FactValue::Truth(true))).of_some_runs());
        let digests = [&self.case.digest, &self.scheme.digest, &self.solver.digest];
        let said = |digest: &Option<Name>| digest.as_ref().map(|digest| FactValue::Text(digest.to_string()));
        facts.extend(CODE.into_iter().zip(digests).map(|(name, of)| Fact::new(name, said(of)).of_some_runs()));
        facts
    }

    /// Hash of everything that determines the run, 16 hexadecimal digits: all facts, every parameter, and the version
    /// of the numerics. A parameter that is set to its default is as one that is not set.
    pub fn id(&self) -> String {
        let counted = self.in_one_form();
        if counted != self.mechanics_steps {
            return self.counting(counted).id();
        }
        self.id_of(self.facts().into_iter())
    }

    /// The hash of all parameters and of these facts.
    pub(super) fn id_of(&self, facts: impl Iterator<Item = Fact>) -> String {
        let mut text = format!("numerics {NUMERICS_VERSION}\n");
        let mut line = |name: &str, value: &dyn fmt::Display| {
            // Writing to memory cannot fail.
            let _ = writeln!(text, "{name} = {value}");
        };
        for fact in facts {
            match &fact.value {
                None if fact.of_some_runs => {}
                _ if fact.name == "set" => line(fact.name, &self.parameters.changed()),
                Some(value) => line(fact.name, value),
                None => line(fact.name, &""),
            }
        }
        text += self.parameters.text();
        let hash = Sha256::digest(text)[..8].iter().fold(0_u64, |hash, &byte| hash << 8 | u64::from(byte));
        format!("{hash:016x}")
    }
}
