//! How the actuators of a mechanics are divided among bonds, and what bonds know of each other.

use crate::cosim::force_return::ForceReturn;
use crate::error::{Error, Result};
use crate::name::by_name;
use std::fmt;
use std::num::NonZeroU32;
use std::str::FromStr;

/// Plausibility bound of rates, far beyond any use.
const MOST: u32 = 10_000;

/// What a bond knows of the actuators of other bonds, between the times at which it is told of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Known {
    /// No force.
    Nothing,
    /// Their forces at the communication point.
    Held,
    /// Their mean forces over their last steps.
    #[default]
    Mean,
    /// Their forces by their output rates, moving with the bond's own model.
    Law,
}

impl Known {
    const NAMES: [(&'static str, Known); 4] =
        [("nothing", Known::Nothing), ("held", Known::Held), ("mean", Known::Mean), ("law", Known::Law)];
}

by_name!(Known, NAMES, "knowledge of other bonds");

/// What a bond that has stepped ahead tells those that follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Tells {
    /// Its force in each of its micro steps, as far as it has come.
    #[default]
    Profile,
    /// Nothing but what is known of it anyway: fresh, where that is a mean.
    Mean,
}

impl Tells {
    const NAMES: [(&'static str, Tells); 2] = [("profile", Tells::Profile), ("mean", Tells::Mean)];
}

by_name!(Tells, NAMES, "way to tell");

/// The share of the mechanics that each bond's model moves: its own forces act on it `Λ` = 1/share times as strongly.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Share {
    /// All of it.
    #[default]
    Whole,
    /// One over the number of bonds.
    Equal,
    /// `Λ_i = Σ_j |H_ij|/√(H_ii H_jj)` over row `i` and those of other bonds.
    Rows,
    /// The largest with which blind bonds create no energy at their rates 1 : m, `Λ_i = 1 + Σ_{j ≠ i} √B(m_ij)` with
    /// `B(m) = (m + 1)(2m + 1)/(6m)`.
    Bound,
    /// A number above 0, at most 1.
    Number(f64),
}

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Share::Whole => f.write_str("whole"),
            Share::Equal => f.write_str("equal"),
            Share::Rows => f.write_str("rows"),
            Share::Bound => f.write_str("bound"),
            Share::Number(share) => share.fmt(f),
        }
    }
}

impl FromStr for Share {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let named = [Share::Whole, Share::Equal, Share::Rows, Share::Bound];
        let number = || text.parse().ok().filter(|share| *share > 0.0 && *share <= 1.0).map(Share::Number);
        let found = named.into_iter().find(|share| share.to_string() == text).or_else(number);
        found.ok_or_else(|| Error::invalid("share", text, "whole, equal, rows, bound, or a number above 0, at most 1"))
    }
}

/// The rows of each bond.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Partition {
    /// One bond for each row.
    #[default]
    Each,
    /// Rows from 0, as `1+2|3`.
    Of(Vec<Vec<usize>>),
}

impl Partition {
    /// The rows of each bond of an interface with `n` rows.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] unless each row is in one bond.
    pub fn rows(&self, n: usize) -> Result<Vec<Vec<usize>>> {
        let Partition::Of(bonds) = self else { return Ok((0..n).map(|row| vec![row]).collect()) };
        let mut found: Vec<usize> = bonds.iter().flatten().copied().collect();
        found.sort_unstable();
        if found.iter().copied().eq(0..n) {
            return Ok(bonds.clone());
        }
        let expected = format!("each of the {n} rows of the interface once, as `{}`, or `each`", numbers(0..n, "|"));
        Err(Error::invalid("partition", self, expected))
    }
}

impl fmt::Display for Partition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Partition::Each => f.write_str("each"),
            Partition::Of(bonds) => {
                let bonds: Vec<String> = bonds.iter().map(|rows| numbers(rows.iter().copied(), "+")).collect();
                f.write_str(&bonds.join("|"))
            }
        }
    }
}

impl FromStr for Partition {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        if text == "each" {
            return Ok(Partition::Each);
        }
        let bonds: Option<Vec<Vec<usize>>> =
            text.split('|').map(|bond| bond.split('+').map(counted).collect()).collect();
        let expected = "`each`, or bonds of rows counted from 1, as `1+2|3`";
        bonds.map(Partition::Of).ok_or_else(|| Error::invalid("partition", text, expected))
    }
}

/// The order of bonds and hub in a macro step: stages one after the other, with bonds that step at once, or `each`, a
/// stage for each bond; none: all at once, and then the hub.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Order(Vec<Vec<Member>>);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Member {
    Hub,
    Bond(usize),
    /// All bonds, one after the other.
    Each,
}

impl fmt::Display for Order {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let member = |member: &Member| match member {
            Member::Hub => "hub".to_owned(),
            Member::Bond(bond) => (bond + 1).to_string(),
            Member::Each => "each".to_owned(),
        };
        let stages = self.0.iter().map(|stage| stage.iter().map(member).collect::<Vec<_>>().join(","));
        let stages: Vec<String> = stages.collect();
        f.write_str(if stages.is_empty() { "together".to_owned() } else { stages.join(";") }.as_str())
    }
}

impl FromStr for Order {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        if text == "together" {
            return Ok(Order::default());
        }
        let member = |text: &str| match text.trim() {
            "hub" => Some(Member::Hub),
            "each" => Some(Member::Each),
            text => counted(text).map(Member::Bond),
        };
        let stages: Option<Vec<Vec<Member>>> =
            text.split(';').map(|stage| stage.split(',').map(member).collect()).collect();
        let is_stage = |stage: &Vec<Member>| stage.len() == 1 || stage.iter().all(|of| matches!(of, Member::Bond(_)));
        let expected =
            "`together`, `each`, or stages of bonds counted from 1 with the hub anywhere as a stage, as `3;1,2;hub`";
        let found = stages.filter(|stages| stages.iter().all(is_stage)).map(Order);
        found.ok_or_else(|| Error::invalid("order", text, expected))
    }
}

/// Stages of bonds, and before which of them the hub steps.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Schedule {
    pub(super) stages: Vec<Vec<usize>>,
    pub(super) hub_at: usize,
}

impl Order {
    fn schedule(&self, bonds: usize) -> Result<Schedule> {
        if self.0.is_empty() {
            return Ok(Schedule { stages: vec![(0..bonds).collect()], hub_at: 1 });
        }
        let (mut stages, mut hubs) = (Vec::new(), Vec::new());
        for stage in &self.0 {
            match stage[..] {
                [Member::Hub] => hubs.push(stages.len()),
                [Member::Each] => stages.extend((0..bonds).map(|bond| vec![bond])),
                _ => stages.push(
                    stage
                        .iter()
                        .filter_map(|of| if let Member::Bond(bond) = of { Some(*bond) } else { None })
                        .collect(),
                ),
            }
        }
        let mut found: Vec<usize> = stages.iter().flatten().copied().collect();
        found.sort_unstable();
        if !found.into_iter().eq(0..bonds) || hubs.len() > 1 {
            let expected =
                format!("each of the {bonds} bonds once, as `{}`, and the hub at most once", numbers(0..bonds, ";"));
            return Err(Error::invalid("order", self, expected));
        }
        let hub_at = hubs.first().copied().unwrap_or(stages.len());
        Ok(Schedule { stages, hub_at })
    }
}

/// How often bonds exchange: every so many macro steps of the hub, or `1/n` to be told of the others n times within
/// one. Of one number it is that of all.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Every(Vec<Rate>);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Rate {
    Macro(NonZeroU32),
    Part(NonZeroU32),
}

impl fmt::Display for Every {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rate = |rate: &Rate| match rate {
            Rate::Macro(count) => count.to_string(),
            Rate::Part(count) => format!("1/{count}"),
        };
        let rates: Vec<String> = self.0.iter().map(rate).collect();
        f.write_str(if rates.is_empty() { "1".to_owned() } else { rates.join(",") }.as_str())
    }
}

impl FromStr for Every {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        // A file may give a number, which is written with a point.
        let count = |text: &str| {
            text.strip_suffix(".0").unwrap_or(text).parse().ok().filter(|count: &NonZeroU32| count.get() <= MOST)
        };
        let rate = |text: &str| match text.trim().strip_prefix("1/") {
            Some(part) => count(part).filter(|part| part.get() > 1).map(Rate::Part),
            None => count(text.trim()).map(Rate::Macro),
        };
        let rates: Option<Vec<Rate>> = text.split(',').map(rate).collect();
        let one = |rates: Vec<Rate>| match rates[..] {
            [Rate::Macro(NonZeroU32::MIN)] => Every::default(),
            _ => Every(rates),
        };
        rates.map(one).ok_or_else(|| {
            let expected =
                format!("whole numbers from 1 to {MOST}, one per bond or one for all, or `1/n`, as `1,4` or `1/8`");
            Error::invalid("every", text, expected)
        })
    }
}

impl Every {
    /// Parts of a macro step of the hub in which bonds are told of others, and these parts in the step of each bond.
    fn parts(&self, bonds: usize) -> Result<(usize, Vec<usize>)> {
        let rates = match self.0[..] {
            [] => vec![Rate::Macro(NonZeroU32::MIN); bonds],
            [rate] => vec![rate; bonds],
            _ => self.0.clone(),
        };
        if rates.len() != bonds {
            return Err(Error::invalid(
                "every",
                self,
                format!("one number for each of the {bonds} bonds, or one for all"),
            ));
        }
        let most = |most: usize, rate: &Rate| match rate {
            Rate::Part(parts) => most.max(parts.get() as usize),
            Rate::Macro(_) => most,
        };
        let told = rates.iter().fold(1, most);
        let of = |rate: &Rate| match rate {
            Rate::Macro(count) => Some(count.get() as usize * told),
            Rate::Part(parts) => told.is_multiple_of(parts.get() as usize).then(|| told / parts.get() as usize),
        };
        let parts: Option<Vec<usize>> = rates.iter().map(of).collect();
        let expected = "parts of a macro step of which each divides the smallest";
        parts.map(|parts| (told, parts)).ok_or_else(|| Error::invalid("every", self, expected))
    }
}

/// Longest micro steps, s, one for each bond; none: that of the run for all.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MicroSteps(pub(super) Vec<f64>);

impl fmt::Display for MicroSteps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.iter().map(f64::to_string).collect::<Vec<_>>().join(","))
    }
}

impl FromStr for MicroSteps {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let step = |text: &str| text.trim().parse().ok().filter(|step: &f64| step.is_finite() && *step > 0.0);
        let steps: Option<Vec<f64>> = text.split(',').map(step).collect();
        let expected = "times above 0 s, one for each bond, as `5e-5,1e-4`";
        steps.map(MicroSteps).ok_or_else(|| Error::invalid("bond_micro_steps", text, expected))
    }
}

impl MicroSteps {
    /// The longest and shortest of them, s; none where there are none.
    pub fn range(&self) -> Option<[f64; 2]> {
        let of = |choose: fn(f64, f64) -> f64| self.0.iter().copied().reduce(choose);
        Some([of(f64::min)?, of(f64::max)?])
    }
}

/// Counts from 1 in a text, from 0 here.
fn counted(text: &str) -> Option<usize> {
    text.trim().parse::<usize>().ok()?.checked_sub(1)
}

pub(super) fn numbers(from_0: impl Iterator<Item = usize>, between: &str) -> String {
    from_0.map(|number| (number + 1).to_string()).collect::<Vec<_>>().join(between)
}

/// How several bonds share one mechanics.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StarPlan {
    /// The rows of each bond.
    pub partition: Partition,
    /// The order in a macro step.
    pub order: Order,
    /// The rates.
    pub every: Every,
    /// What is known of other bonds.
    pub known: Known,
    /// What is told by bonds that are ahead.
    pub tells: Tells,
    /// The share of the mechanics in each model.
    pub share: Share,
    /// Longest micro step of each bond, s; that of the run where there are none.
    pub micro_steps: MicroSteps,
}

/// A plan for so many rows.
pub(super) struct Layout {
    pub(super) rows: Vec<Vec<usize>>,
    pub(super) schedule: Schedule,
    /// Parts of a macro step of the hub.
    pub(super) told: usize,
    /// These parts in the step of each bond.
    pub(super) every: Vec<usize>,
}

impl StarPlan {
    pub(super) fn layout(&self, n: usize) -> Result<Layout> {
        let rows = self.partition.rows(n)?;
        let schedule = self.order.schedule(rows.len())?;
        let (told, every) = self.every.parts(rows.len())?;
        Ok(Layout { rows, schedule, told, every })
    }

    /// Tells whether a bond steps after the hub, with what the hub then sends.
    pub fn follows_hub(&self) -> bool {
        self.order.0.iter().position(|stage| *stage == [Member::Hub]).is_some_and(|at| at + 1 < self.order.0.len())
    }

    /// Tells whether there is more than one bond.
    pub fn divides(&self) -> bool {
        !matches!(&self.partition, Partition::Of(bonds) if bonds.len() == 1)
    }

    /// Counts the bonds on `n` rows.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn bonds(&self, n: usize) -> Result<usize> {
        self.partition.rows(n).map(|rows| rows.len())
    }

    /// Checks the plan for an interface of `n` rows and a force return.
    ///
    /// # Errors
    /// [`Error::InvalidValue`] or [`Error::Incompatible`], naming what is wrong and what would be valid.
    pub fn check(&self, n: usize, (force_return, phase): (ForceReturn, f64)) -> Result<()> {
        let Layout { rows, schedule, told, every } = self.layout(n)?;
        let refused = |what: String, why: &str| Err(Error::Incompatible(format!("{what}: {why}")));
        let is_slow = every.iter().any(|every| *every > told);
        let between = schedule.hub_at < schedule.stages.len();
        if between && (told > 1 || is_slow) {
            return refused(
                format!("order = {}", self.order),
                "bonds that step after the hub step with it: use every 1",
            );
        }
        if is_slow && phase < 1.0 {
            return refused(
                format!("every = {}", self.every),
                "steps of several macro steps begin with a whole one: use phase 1",
            );
        }
        if !self.micro_steps.0.is_empty() && self.micro_steps.0.len() != rows.len() {
            let expected = format!("one number for each of the {} bonds", rows.len());
            return Err(Error::invalid("bond_micro_steps", &self.micro_steps, expected));
        }
        if self.share == Share::Bound {
            let what = "share = bound".to_owned();
            if self.known != Known::Nothing {
                return refused(what, "it is proved for bonds that know nothing of each other: use known `nothing`");
            }
            if is_slow && force_return != ForceReturn::Mean {
                return refused(
                    what,
                    "with unequal rates it is proved for means returned, and no share suffices for profiles: use force return `mean`",
                );
            }
            let divides = |a: usize, b: usize| a.max(b).is_multiple_of(a.min(b));
            if !every.iter().all(|a| every.iter().all(|b| divides((*a).max(told), (*b).max(told)))) {
                return refused(what, "it is proved for rates of which one divides the other");
            }
        }
        Ok(())
    }

    /// Returns `Λ` of a bond; 1 where it is found from the model.
    ///
    /// ```text
    /// bound    Λ_i = 1 + Σ_{j ≠ i} √B(m_ij)        B(m) = (m + 1)(2m + 1)/(6m),  1 : m the rates of i and j
    /// ```
    pub(super) fn factor(&self, bond: usize, layout: &Layout) -> f64 {
        let (told, every) = (layout.told, &layout.every);
        match self.share {
            Share::Whole | Share::Rows => 1.0,
            Share::Equal => every.len() as f64,
            Share::Number(share) => 1.0 / share,
            Share::Bound => {
                let own = every[bond].max(told);
                let others = every.iter().enumerate().filter(|(other, _)| *other != bond);
                others.fold(1.0, |sum, (_, &other)| {
                    let other = other.max(told);
                    let m = (own.max(other) / own.min(other)) as f64;
                    sum + ((m + 1.0) * (2.0 * m + 1.0) / (6.0 * m)).sqrt()
                })
            }
        }
    }
}
