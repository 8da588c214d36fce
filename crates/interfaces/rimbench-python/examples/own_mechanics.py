"""A mechanics of one's own: mass 2 of the linear oscillator, run by the same loop and held against the same exact solution."""

import rimbench


class Mass:
    """A mass between a spring to the wall and the coupling: force in, position and velocity out."""

    def __init__(self, parameters):
        self.mass = parameters["mass_2_kg"]
        self.stiffness = parameters["stiffness_2_n_m"] / self.mass  # 1/s²
        self.x, self.v = parameters["x2_0_m"], parameters["v2_0_m_s"]

    def outputs(self, u):
        return self.x, self.v

    def step(self, t, u, h):
        self.v += h * (u[0] / self.mass - self.stiffness * self.x)  # semi-implicit Euler
        self.x += h * self.v
        return self.x, self.v  # spares the loop a call of `outputs`

    def interface_model(self, h):
        """The mass reduced to its interface: w⁺ = w + δ a + H δ λ."""
        a = -self.stiffness * self.x
        return {"H": [[1 / self.mass]], "a": [a], "w": [self.v], "position": [self.x]}


case = rimbench.Case("mass-in-python", like="linear-oscillator", mechanics=Mass, reference="original")

if __name__ == "__main__":
    for scheme in ("zero-order-hold", "first-order-hold", "rim-smooth"):
        print(rimbench.simulate(case, scheme, 1e-3, integrator="semi-implicit-euler", duration_s=1.0))
