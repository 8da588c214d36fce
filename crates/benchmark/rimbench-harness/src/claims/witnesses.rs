//! What a run says of a claim: the one place in which its end decides.
//!
//! ```text
//! no answer                                       nothing, whatever is claimed
//! completed                                       its number
//! failed   the claim counts how runs end          how it ended: completed, failed, within, thresholds
//!          witnesses = "all"                      its number, before it failed
//!          witnesses = "completed"                nothing
//!          share-better, ratios of errors         that it is worse than every number
//!          a run without error meets the claim    that the claim does not hold
//!          else                                   nothing: it does not say how large an error is
//! ```

use crate::experiment::{Claim, Statistic, Verdict, Witnesses};

/// What a run that failed says of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OfFailed {
    /// How it ended is what is counted.
    ItsEnd,
    /// What it had come to by then.
    ItsNumber,
    /// Worse than every number.
    Infinite,
    /// That the claim does not hold.
    Against,
    /// Nothing.
    LeftOut,
}

impl Claim {
    /// Says what a run that failed says of it, a run of the row that it is about, or of the other one.
    pub(super) fn of_failed(&self, is_other: bool) -> OfFailed {
        match self.witnesses {
            _ if self.counts_ends() => OfFailed::ItsEnd,
            Some(Witnesses::All) => OfFailed::ItsNumber,
            Some(Witnesses::Completed) => OfFailed::LeftOut,
            None if self.statistic == Statistic::ShareBetter || self.charges_failures() => OfFailed::Infinite,
            None if self.praises(is_other) => OfFailed::Against,
            None => OfFailed::LeftOut,
        }
    }

    /// Whether it is about ratios in which a run that failed stands as infinite. At equal counts no infinite error has a
    /// place on a line, and of what is best at one a large value is not always bad.
    fn charges_failures(&self) -> bool {
        self.is_about_ratios() && self.at_equal.is_none() && self.metric.ideal() == 0.0
    }

    /// Whether it speaks well of a row: a run of it without error would meet the bound.
    fn praises(&self, is_other: bool) -> bool {
        let ideal = match self.metric.ideal() {
            _ if self.statistic == Statistic::Order => f64::INFINITY,
            ideal => self.above.map_or(ideal, |above| f64::from(ideal > above)),
        };
        match self.relative_to {
            None => self.expect.admits(ideal),
            // Of a ratio of errors a small one praises the one, a large one the other; of orders the reverse.
            Some(_) if ideal == 0.0 || ideal.is_infinite() => is_other == (self.expect.at_least != ideal.is_infinite()),
            // Of what is best at one no direction is good.
            Some(_) => true,
        }
    }

    /// Judges a value, none where nothing was measured, and whether a run that failed speaks against it.
    pub(super) fn verdict(&self, measured: Option<f64>, is_refuted: bool) -> Verdict {
        match measured {
            _ if is_refuted => Verdict::NotReproduced,
            None => Verdict::NotMeasured,
            Some(value) if self.expect.admits(value) => Verdict::Reproduced,
            Some(_) => Verdict::NotReproduced,
        }
    }

    /// Says whom it asks, to go behind what is measured.
    pub(super) fn witnesses_in_words(&self) -> &'static str {
        match self.witnesses {
            None => "",
            Some(Witnesses::Completed) => ", completed runs only",
            Some(Witnesses::All) => ", before it fails",
        }
    }
}
