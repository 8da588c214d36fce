//! Bakes in a hash of the sources that the digits of a simulation without a scheme depend on.

fn main() {
    rimbench_sources::bake("RIMBENCH_CORE_SOURCES", &["interface_model", "cosim", "mechanics"]);
}
