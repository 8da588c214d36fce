//! Bakes in a hash of the sources that the digits of contact problems depend on.

fn main() {
    rimbench_sources::bake("RIMBENCH_CONTACT_SOURCES", &[""]);
}
