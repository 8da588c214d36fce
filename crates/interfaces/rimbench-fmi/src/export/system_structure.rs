//! Both sides of a case as a system of components (System Structure and Parameterization, version 1.0), for masters
//! that read one.

use super::{build_side, side_name};
use rimbench_core::cosim::Side;
use rimbench_core::error::Result;
use rimbench_runs::RunSpec;
use std::fmt::Write;

/// Writes `SystemStructure.ssd` of the case of a run: its sides as `resources/<side>.fmu`, each output connected to the
/// input of the other side.
///
/// # Errors
/// Those of building the case.
pub fn system_structure(spec: &RunSpec) -> Result<String> {
    let (mut components, mut connections) = (String::new(), String::new());
    let name = &spec.case.name;
    for side in Side::BOTH {
        let [own, other] = [side, side.other()].map(side_name);
        let ports = build_side(&spec.case, side, &spec.parameters)?.ports().clone();
        let of_other = build_side(&spec.case, side.other(), &spec.parameters)?.ports().clone();
        let mut connectors = String::new();
        for (kind, ports) in [("input", &ports.inputs), ("output", &ports.outputs)] {
            for port in ports {
                let _ = writeln!(
                    connectors,
                    "          <ssd:Connector name=\"{}\" kind=\"{kind}\"><ssc:Real/></ssd:Connector>",
                    port.name
                );
            }
        }
        for (output, input) in ports.outputs.iter().zip(&of_other.inputs) {
            let _ = writeln!(
                connections,
                "      <ssd:Connection startElement=\"{own}\" startConnector=\"{}\" endElement=\"{other}\" endConnector=\"{}\"/>",
                output.name, input.name
            );
        }
        let _ = writeln!(
            components,
            "      <ssd:Component name=\"{own}\" type=\"application/x-fmu-sharedlibrary\" source=\"resources/{own}.fmu\">\n        \
             <ssd:Connectors>\n{connectors}        </ssd:Connectors>\n      </ssd:Component>"
        );
    }
    Ok(format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<ssd:SystemStructureDescription version=\"1.0\" name=\"{name}\"\n    \
         xmlns:ssd=\"http://ssp-standard.org/SSP1/SystemStructureDescription\"\n    \
         xmlns:ssc=\"http://ssp-standard.org/SSP1/SystemStructureCommon\">\n  <ssd:System name=\"{name}\">\n    \
         <ssd:Elements>\n{components}    </ssd:Elements>\n    <ssd:Connections>\n{connections}    </ssd:Connections>\n  \
         </ssd:System>\n  <ssd:DefaultExperiment startTime=\"0\" stopTime=\"{:?}\"/>\n</ssd:SystemStructureDescription>\n",
        spec.duration
    ))
}
