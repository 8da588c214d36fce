//! What a subsystem does not offer, written once.

/// Writes the bodies of the [`Abilities`](crate::cosim::Abilities) that a subsystem does not offer, by their names:
///
/// ```text
/// impl Abilities for Spring {
///     not_offered!(empty_interface_model, interface_model, joint_steps);
///     …
/// }
/// ```
/// A method of the trait that is neither named nor written is an error of the compiler, as it is meant to be. What is written is an
/// empty list, `None`, `false`, or for `use_second_order` the refusal
/// [`FIRST_ORDER_ONLY`](crate::cosim::FIRST_ORDER_ONLY).
#[macro_export]
macro_rules! not_offered {
    (@ empty_interface_model) => {
        fn empty_interface_model(&mut self) -> Option<$crate::interface_model::ReducedInterfaceModel> {
            None
        }
    };
    (@ interface_model) => {
        fn interface_model(
            &mut self,
            _h: f64,
            _model: &mut $crate::interface_model::ReducedInterfaceModel,
        ) -> Result<bool, $crate::error::Failure> {
            Ok(false)
        }
    };
    (@ output_rates) => {
        fn output_rates(
            &mut self,
            _t: f64,
            _u: &[f64],
            _rates: &mut $crate::cosim::OutputRates,
        ) -> Result<bool, $crate::error::Failure> {
            Ok(false)
        }
    };
    (@ input_polynomials) => {
        fn input_polynomials(&mut self) -> Option<&mut $crate::cosim::InputPolynomials> {
            None
        }
    };
    (@ use_second_order) => {
        fn use_second_order(&mut self, _rule: $crate::cosim::SecondOrder) -> Result<(), &'static str> {
            Err($crate::cosim::FIRST_ORDER_ONLY)
        }
    };
    (@ joint_steps) => {
        fn joint_steps(&mut self) -> Option<&mut dyn $crate::cosim::JointSteps> {
            None
        }
    };
    (@ oil_lines) => {
        fn oil_lines(&mut self) -> Option<&mut dyn $crate::cosim::OilLines> {
            None
        }
    };
    (@ observables) => {
        fn observables(&mut self) -> &[$crate::name::Name] {
            &[]
        }
    };
    (@ observe) => {
        fn observe(&mut self, _h: f64, _row: &mut [f64]) {}
    };
    (@ interface_work) => {
        fn interface_work(&mut self) -> Option<f64> {
            None
        }
    };
    (@ energy_identity_residual) => {
        fn energy_identity_residual(&mut self) -> Option<f64> {
            None
        }
    };
    (@ energy_account) => {
        fn energy_account(&mut self) -> Option<$crate::cosim::EnergyAccount> {
            None
        }
    };
    ($($ability:ident),+ $(,)?) => {
        $($crate::not_offered!(@ $ability);)+
    };
}
