//! The hydraulic fluid, pump and valve as parameters, shared by the cases with a cylinder.

use super::parameters::{Parameter, Parameters, Range, number};
use crate::models::Fluid;

/// Source of the hydraulic constants.
pub(super) const NAYA: &str = "Naya et al. 2011";

const DISCHARGE_COEFFICIENT: Parameter =
    number("discharge_coefficient", "-", 0.67, Range::Positive, "discharge coefficient c_d", NAYA);
const DENSITY: Parameter = number("fluid_density_kg_m3", "kg/m³", 850.0, Range::Positive, "fluid density ρ", NAYA);
const SUPPLY_PRESSURE: Parameter =
    number("supply_pressure_pa", "Pa", 7.6e6, Range::Positive, "pump pressure p_P", NAYA);
const TANK_PRESSURE: Parameter = number("tank_pressure_pa", "Pa", 1e5, Range::NotNegative, "tank pressure p_T", NAYA);
const COMPRESSIBILITY_A: Parameter =
    number("compressibility_a_1_pa", "1/Pa", 6.53e-10, Range::Positive, "fluid compressibility a", NAYA);
const COMPRESSIBILITY_B: Parameter =
    number("compressibility_b_1_pa2", "1/Pa²", -1.19e-18, Range::Finite, "fluid compressibility b", NAYA);

/// All of them.
pub(super) const PARAMETERS: [Parameter; 6] =
    [DISCHARGE_COEFFICIENT, DENSITY, SUPPLY_PRESSURE, TANK_PRESSURE, COMPRESSIBILITY_A, COMPRESSIBILITY_B];

/// The fluid as the parameters say.
pub(super) fn of(parameters: &Parameters) -> Fluid {
    Fluid {
        discharge_coefficient: parameters.number(DISCHARGE_COEFFICIENT.name),
        density: parameters.number(DENSITY.name),
        supply_pressure: parameters.number(SUPPLY_PRESSURE.name),
        tank_pressure: parameters.number(TANK_PRESSURE.name),
        compressibility_a: parameters.number(COMPRESSIBILITY_A.name),
        compressibility_b: parameters.number(COMPRESSIBILITY_B.name),
    }
}
