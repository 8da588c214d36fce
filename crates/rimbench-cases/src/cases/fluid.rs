//! The hydraulic fluid, pump and valve as parameters, shared by the cases with a cylinder.

use super::parameters::{Parameter, Parameters, Range, number};
use crate::models::Fluid;

/// Source of the hydraulic constants.
pub(super) const NAYA: &str = "Naya et al. 2011";

const DISCHARGE_COEFFICIENT: &str = "discharge_coefficient";
const DENSITY: &str = "fluid_density_kg_m3";
const SUPPLY_PRESSURE: &str = "supply_pressure_pa";
const TANK_PRESSURE: &str = "tank_pressure_pa";
const COMPRESSIBILITY_A: &str = "compressibility_a_1_pa";
const COMPRESSIBILITY_B: &str = "compressibility_b_1_pa2";

/// All of them.
pub(super) fn parameters() -> Vec<Parameter> {
    vec![
        number(DISCHARGE_COEFFICIENT, "-", 0.67, Range::Positive, "discharge coefficient c_d", NAYA),
        number(DENSITY, "kg/m³", 850.0, Range::Positive, "fluid density ρ", NAYA),
        number(SUPPLY_PRESSURE, "Pa", 7.6e6, Range::Positive, "pump pressure p_P", NAYA),
        number(TANK_PRESSURE, "Pa", 1e5, Range::NotNegative, "tank pressure p_T", NAYA),
        number(COMPRESSIBILITY_A, "1/Pa", 6.53e-10, Range::Positive, "fluid compressibility a", NAYA),
        number(COMPRESSIBILITY_B, "1/Pa²", -1.19e-18, Range::Finite, "fluid compressibility b", NAYA),
    ]
}

/// The fluid as the parameters say.
pub(super) fn of(parameters: &Parameters) -> Fluid {
    Fluid {
        discharge_coefficient: parameters.number(DISCHARGE_COEFFICIENT),
        density: parameters.number(DENSITY),
        supply_pressure: parameters.number(SUPPLY_PRESSURE),
        tank_pressure: parameters.number(TANK_PRESSURE),
        compressibility_a: parameters.number(COMPRESSIBILITY_A),
        compressibility_b: parameters.number(COMPRESSIBILITY_B),
    }
}
