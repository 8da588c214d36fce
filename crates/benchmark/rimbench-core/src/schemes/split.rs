//! The assumption of each of several actuators about the others, as an option.

use crate::name::by_name;

/// The part of the others in the model of one actuator, and its mass.
///
/// ```text
/// mean    G = mean forces over the last macro step            blind   G = 0
/// shares  Λ_i = N    rows    Λ_i = Σ_j |H_ij|/√(H_ii H_jj)    body    Λ_i = 1
/// law     G_j follows the motion of the model by the actuator's output rates, Λ_i = 1        joint   one model
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Split {
    /// The last means, an equal share of the body each.
    #[default]
    MeanShares,
    /// The last means, row sums.
    MeanRows,
    /// The last means, the whole body each.
    MeanBody,
    /// Nothing, row sums.
    BlindRows,
    /// Nothing, an equal share of the body each.
    BlindShares,
    /// Nothing, the whole body each.
    BlindBody,
    /// The others' linear laws, the whole body each.
    Law,
    /// One model for all.
    Joint,
}

impl Split {
    const NAMES: [(&'static str, Split); 8] = [
        ("mean:shares", Split::MeanShares),
        ("mean:rows", Split::MeanRows),
        ("mean:body", Split::MeanBody),
        ("blind:rows", Split::BlindRows),
        ("blind:shares", Split::BlindShares),
        ("blind:body", Split::BlindBody),
        ("law", Split::Law),
        ("joint", Split::Joint),
    ];
}

by_name!(Split, NAMES, "split");
