//! A slightly compressible fluid behind a pump, and the energy it carries.

use crate::parameter::parameters;
use wide::f64x2;

parameters! {
    /// The fluid with its pump and tank.
    pub struct Oil from "Naya et al. 2011" {
        discharge_coefficient: f64 = 0.67, Positive, "discharge coefficient c_d";
        fluid_density_kg_m3: f64 = 850.0, Positive, "fluid density ρ";
        supply_pressure_pa: f64 = 7.6e6, Positive, "pump pressure p_P";
        tank_pressure_pa: f64 = 1e5, NotNegative, "tank pressure p_T";
        compressibility_a_1_pa: f64 = 6.53e-10, Positive, "fluid compressibility a".study(4e-10..1.5e-9);
        compressibility_b_1_pa2: f64 = -1.19e-18, Finite, "fluid compressibility b";
    }
}

/// The fluid in two chambers: each number twice, so that both go by the same operations in one register.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TwoChambers {
    /// Pressures of pump and tank, Pa.
    pub supply: f64x2,
    pub tank: f64x2,
    a: f64x2,
    b: f64x2,
    twice_b: f64x2,
    /// `a² − 4b`.
    discriminant: f64x2,
}

impl TwoChambers {
    /// Returns `β(p)/V` for volumes `V`, Pa/m³; with one division instead of two, because this is evaluated in each
    /// micro step.
    #[inline(always)]
    pub(super) fn stiffness(&self, p: f64x2, volumes: f64x2) -> f64x2 {
        (f64x2::splat(1.0) + self.a * p + self.b * p * p) / (self.softness(p) * volumes)
    }

    /// Returns `φ'(p) = a + 2 b p`, 1/Pa.
    #[inline(always)]
    pub(super) fn softness(&self, p: f64x2) -> f64x2 {
        self.a + self.twice_b * p
    }

    /// Returns [`Oil::relative_density`].
    #[inline(always)]
    pub(super) fn relative_density(&self, p: f64x2) -> f64x2 {
        f64x2::splat(1.0) + p * (self.a + self.b * p)
    }

    /// Returns [`Oil::enthalpy`].
    #[inline(always)]
    pub(super) fn enthalpy(&self, p: f64x2) -> f64x2 {
        let half = p / (f64x2::splat(2.0) + self.a * p);
        let z = self.discriminant * half * half;
        let [one, c1, c2, c3, c4, c5] = [1.0, 1.0 / 3.0, 1.0 / 5.0, 1.0 / 7.0, 1.0 / 9.0, 1.0 / 11.0].map(f64x2::splat);
        let series = (half + half) * (one + z * (c1 + z * (c2 + z * (c3 + z * (c4 + z * c5)))));
        // Up to some 40 MPa of oil the series is exact to round-off, and this is evaluated in each micro step.
        let is_exact = z.abs().simd_lt(f64x2::splat(2e-3));
        if is_exact.to_bitmask() == 3 { series } else { is_exact.select(series, closed_form(half, self.discriminant)) }
    }
}

impl Oil {
    /// Returns it in two chambers.
    pub(super) fn in_two_chambers(&self) -> TwoChambers {
        let (a, b) = (self.compressibility_a_1_pa, self.compressibility_b_1_pa2);
        let [supply, tank] = [self.supply_pressure_pa, self.tank_pressure_pa].map(f64x2::splat);
        let [twice_b, discriminant] = [2.0 * b, a * a - 4.0 * b].map(f64x2::splat);
        TwoChambers { supply, tank, a: f64x2::splat(a), b: f64x2::splat(b), twice_b, discriminant }
    }

    /// Returns the bulk modulus, Pa: `β(p) = (1 + a p + b p²)/(a + 2 b p)`.
    pub fn bulk_modulus(&self, p: f64) -> f64 {
        self.in_two_chambers().stiffness(f64x2::splat(p), f64x2::splat(1.0)).to_array()[0]
    }

    /// Returns the highest pressure for which the fluid law is used, Pa: half of where `a + 2 b p` vanishes and β blows
    /// up.
    pub fn highest_pressure(&self) -> f64 {
        let (a, b) = (self.compressibility_a_1_pa, self.compressibility_b_1_pa2);
        if b < 0.0 { -0.25 * a / b } else { f64::INFINITY }
    }

    /// `c_d √(2/ρ)`: an orifice of area `area` lets through `area · c_d √(2/ρ) · √drop`, m³/s.
    pub(super) fn orifice_coefficient(&self) -> f64 {
        self.discharge_coefficient * (2.0 / self.fluid_density_kg_m3).sqrt()
    }

    /// Returns `φ(p) = ρ(p)/ρ₀ = 1 + a p + b p²`: the density that `β = ρ dp/dρ` implies, relative to that at zero
    /// pressure.
    pub fn relative_density(&self, p: f64) -> f64 {
        self.in_two_chambers().relative_density(f64x2::splat(p)).to_array()[0]
    }

    /// Returns the enthalpy of the fluid that fills 1 m³ at zero pressure, J/m³.
    ///
    /// ```text
    /// J(p) = ρ₀ (e + p/ρ) = ∫₀ᵖ dp'/φ(p') = 2 artanh(√D p/(2 + a p))/√D,    D = a² − 4b;    arctan for D < 0
    /// ```
    /// `e = ∫ p dρ/ρ²` is the elastic energy per mass of a fluid whose pressure depends on its density alone.
    pub fn enthalpy(&self, p: f64) -> f64 {
        self.in_two_chambers().enthalpy(f64x2::splat(p)).to_array()[0]
    }

    /// Returns the elastic energy of the fluid in 1 m³ of a chamber at pressure `p`, J/m³: `ε(p) = φ J − p ≈ ½ a p²`,
    /// `ε' = φ' J`.
    pub fn elastic_energy(&self, p: f64) -> f64 {
        self.relative_density(p) * self.enthalpy(p) - p
    }
}

/// The enthalpies for `p/(2 + a p)`.
#[cold]
fn closed_form(half: f64x2, discriminant: f64x2) -> f64x2 {
    let [discriminant, _] = discriminant.to_array();
    let root = discriminant.abs().sqrt();
    let angle = |half: f64| if discriminant > 0.0 { libm::atanh(root * half) } else { libm::atan(root * half) };
    f64x2::new(half.to_array().map(|half| 2.0 * angle(half) / root))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameter::ParameterSet;

    #[test]
    fn the_closed_form_of_the_enthalpy_is_the_integral_of_one_over_the_density() {
        let of = |a: f64, b: f64| Oil { compressibility_a_1_pa: a, compressibility_b_1_pa2: b, ..Oil::defaults() };
        // Discriminant above zero, zero, below zero; and no b at all, where J = ln(1 + a p)/a.
        for fluid in [of(6.53e-10, -1.19e-18), of(2e-9, 1e-18), of(1e-9, 1e-17), of(6.53e-10, 0.0)] {
            for p in [1e5, 3.85e6, 7.6e6, 1e8] {
                let n = 2000;
                let simpson: f64 = (0..=n)
                    .map(|i| {
                        let weight = if i == 0 || i == n { 1.0 } else { 2.0 + 2.0 * f64::from(i % 2) };
                        weight / fluid.relative_density(p * f64::from(i) / f64::from(n))
                    })
                    .sum::<f64>()
                    * p
                    / f64::from(3 * n);
                approx::assert_relative_eq!(fluid.enthalpy(p), simpson, max_relative = 1e-12);
            }
        }
        let linear = of(6.53e-10, 0.0);
        approx::assert_relative_eq!(
            linear.enthalpy(1e8),
            libm::log1p(6.53e-10 * 1e8_f64) / 6.53e-10,
            max_relative = 1e-13
        );
    }

    #[test]
    fn compressing_a_closed_chamber_stores_the_work_of_its_walls() {
        // V dp = −β dV, no flow: the mass φ V stays, and the elastic energy grows by −∫ p dV.
        let fluid = Oil::defaults();
        let (mass, n) = (0.5 * fluid.relative_density(1e5), 200_000);
        let volume = |p: f64| mass / fluid.relative_density(p);
        let pressure = |i: u32| 1e5 + 4e7 * f64::from(i) / f64::from(n);
        let work: f64 = (0..n)
            .map(|i| {
                let (p, next) = (pressure(i), pressure(i + 1));
                0.5 * (p + next) * (volume(p) - volume(next))
            })
            .sum();
        let stored = |p: f64| volume(p) * fluid.elastic_energy(p);
        approx::assert_relative_eq!(stored(4.01e7) - stored(1e5), work, max_relative = 1e-8);
        // And β is the modulus of that same process.
        let dp = 10.0;
        let slope = (volume(1e7 + dp) - volume(1e7 - dp)) / (2.0 * dp);
        approx::assert_relative_eq!(-volume(1e7) / slope, fluid.bulk_modulus(1e7), max_relative = 1e-7);
    }
}
