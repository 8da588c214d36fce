"""A case of one's own, both sides of it: a weight on the floor under a spring whose upper end is shaken.

The weight reports its contact and its reduced interface model, so schemes that move a model run on it. Those that ask for derivatives of
the actuator's outputs do not: a side in Python has none to give.
"""

import math

import rimbench

GRAVITY = 9.81  # m/s²


class Weight:
    """A weight above the floor; the floor takes the impulse that keeps it from sinking in within a step."""

    contacts = 1
    observables = ("gap_floor_m",)

    def __init__(self, parameters):
        self.mass, self.height, self.speed, self.closed = parameters["mass_kg"], 0.0, 0.0, True

    def outputs(self, u):
        return self.height, self.speed

    def step(self, t, u, h):
        free = self.speed + h * (u[0] / self.mass - GRAVITY)
        self.speed = max(free, -self.height / h)
        self.closed = self.speed > free
        self.height += h * self.speed
        return self.height, self.speed

    def observe(self):
        return (self.height,)

    def interface_model(self, h):
        row, gap = 1 / self.mass, [self.height]  # contact and interface are the same row
        return {
            "H": [[row, row], [row, row]], "a": [-GRAVITY] * 2, "w": [self.speed] * 2,
            "gap": gap, "position": gap, "closed": [self.closed],
        }


class ShakenSpring:
    """Position and velocity in, force out at once."""

    direct_feedthrough = True

    def __init__(self, parameters):
        self.stiffness, self.amplitude, self.time = parameters["stiffness_n_m"], parameters["amplitude_m"], 0.0

    def outputs(self, u):
        top, speed = self.amplitude * math.sin(20 * self.time), self.amplitude * 20 * math.cos(20 * self.time)
        return (self.stiffness * (top - u[0]) + 5.0 * (speed - u[1]),)

    def step(self, t, u, h):
        self.time = t + h


case = rimbench.Case(
    "shaken-weight",
    mechanics=Weight,
    actuator=ShakenSpring,
    parameters={"mass_kg": 2.0, "stiffness_n_m": 1000.0, "amplitude_m": 0.03},
    interface=[("height_m", "speed_m_s", "spring_force_n")],
    duration_s=1.0,
    macro_step_s=2e-3,
    micro_step_s=1e-4,
)

if __name__ == "__main__":
    for scheme in ("zero-order-hold", "rim-smooth", "rim-nonsmooth-gap"):
        result = rimbench.simulate(case, scheme)
        print(scheme, result.outcome, f"highest {result['gap_floor_m'].max():.4f} m,",
              f"force error {result.metrics['force_error_rms_n']:.3f} N")
