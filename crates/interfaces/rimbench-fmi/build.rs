//! Bakes in a hash of the sources that an FMU and the library in it must both be made from.

fn main() {
    rimbench_sources::bake("RIMBENCH_FMI_SOURCES", &[""]);
}
