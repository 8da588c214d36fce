"""Models of MuJoCo as sides: the exact interface model against steps of the engine, contacts, copies, and what is refused."""

import copy
import inspect
import json
import math
import os
import subprocess
import sys

import numpy as np
import pytest

import rimbench
from rimbench.mujoco import Mechanics

mujoco = pytest.importorskip("mujoco")

FLOOR = """<mujoco><option timestep="1e-3" {more}/><default><geom condim="{condim}" solref="0.004 1"/></default><worldbody>
  <geom name="floor" type="plane" size="9 9 1"/><site name="pin" pos="0 0 1.5"/>
  <body pos="0.1 0 {height}">
    <joint name="x" type="slide" axis="1 0 0"/><joint name="z" type="slide" axis="0 0 1"/>
    <joint name="turn" type="hinge" axis="0 1 0" limited="true" range="-20 30" frictionloss="{loss}"/>
    <geom name="box" type="box" size=".5 .4 .5" mass="100"/><site name="hook" pos="0.2 0 .3"/>
    <body pos=".3 0 .6"><joint name="elbow" type="hinge" axis="0 1 0"/><joint name="ball" type="ball" pos="0.1 0 0"/>
      <geom name="arm" type="capsule" fromto="0 0 0 .5 0 .4" size=".05" mass="20" contype="0" conaffinity="0"/></body>
  </body></worldbody>
  <tendon><spatial name="rope"><site site="pin"/><site site="hook"/></spatial></tendon>
  <equality><joint joint1="elbow" polycoef="0.1 0 0 0 0" active="{held}"/></equality></mujoco>"""


def floor(condim=1, height=0.52, loss=0, held="false", more=""):
    return FLOOR.format(condim=condim, height=height, loss=loss, held=held, more=more)


def side(interface, moving=True, contacts=(("box", "floor"),), **how):
    made = Mechanics(floor(**how), interface, contacts=contacts)
    if moving:
        made.data.qvel[:] = [0.1, -0.2, 0.3, 0.5, 0.1, 0.2, -0.4]
        made._see()
    return made


ROWS = [
    [("tendon", "rope")],
    [("site", "hook", "pin")],
    [("site", "hook", (0, 1, 2))],
    [("joint", "z")],
    [("tendon", "rope"), ("joint", "elbow", 0.3)],
]


def answers(made, h, force):
    """H of the interface and its free acceleration, from steps of the engine by h (s)."""
    rows = len(made.outputs(()))  // 2

    def after(*u):
        return np.array(copy.deepcopy(made).step(0.0, u, h)[rows:])

    free = after(*[0.0] * rows)
    pushed = [after(*row) for row in force * np.eye(rows)]
    return np.array([(one - free) / (force * h) for one in pushed]).T, (free - made.outputs(())[rows:]) / h


@pytest.mark.parametrize("rows", ROWS, ids=str)
@pytest.mark.parametrize("h", [1e-5, 1e-3])
def test_the_exact_model_is_what_steps_of_the_engine_answer(rows, h):
    made = side(rows)
    model, first = made.interface_model(h), made.contacts
    probed, free = answers(made, h, 50.0)
    # Rows are those after the step, which turn by its length: differences are of the order of h times rates of some 1/s, and
    # accelerations of some 10 m/s².
    np.testing.assert_allclose(model["H"][first:, first:], probed, rtol=0, atol=3 * h * np.abs(probed).max())
    np.testing.assert_allclose(model["a"][first:], free, rtol=0, atol=50 * h)


def test_gaps_and_their_rates_are_those_of_the_motion():
    made, h = side([("tendon", "rope")]), 1e-6
    model = made.interface_model(h)
    later = copy.deepcopy(made)
    later.step(0.0, (0.0,), h)
    then = later.interface_model(h)
    # Four corners, both limits of the hinge; the engine's explicit Euler step leaves h a of the rate.
    assert made.contacts == 6 and (model["gap"] > 0.0).all()
    np.testing.assert_allclose((then["gap"] - model["gap"]) / h, model["w"][:6], rtol=0, atol=1e-4)
    np.testing.assert_allclose((then["w"] - model["w"]) / h, model["a"], rtol=0, atol=1e-3)


def test_contacts_are_found_as_far_as_they_reach():
    balls = "".join(f'<geom name="{name}" type="sphere" size="0.1" pos="{x} 0 0.16" mass="1"/>' for name, x in (("a", 0), ("b", 1)))
    text = f"""<mujoco><default><geom condim="1"/></default><worldbody><geom name="floor" type="plane" size="9 9 1"/>
      <geom name="step" type="box" size="1 1 1" pos="1 0 -0.98"/><geom name="wall" type="box" size="1 1 1" pos="-1.15 0 0.5"/>
      <body><joint name="z" type="slide" axis="0 0 1"/><joint name="x" type="slide" axis="1 0 0"/>{balls}</body></worldbody></mujoco>"""
    pairs = [("a", "floor"), ("b", "floor"), ("b", "step"), ("a", "wall")]
    model = Mechanics(text, [("joint", "z")], contacts=pairs).interface_model(1e-3)
    np.testing.assert_allclose(model["gap"], [0.06, 0.06, 0.04, 0.05], rtol=0, atol=1e-12)
    assert Mechanics(text, [("joint", "z")], contacts=pairs, reach=0.045).interface_model(1e-3)["gap"].tolist()[:2] == [1.0, 1.0]


def test_an_equality_is_eliminated():
    free, held = side(ROWS[4], moving=False), side(ROWS[4], moving=False, held="true")
    held.data.qpos[made_at(held, "elbow")] = 0.1
    held._see()
    first = held.contacts
    model = held.interface_model(1e-3)
    assert np.abs(model["H"][first + 1]).max() < 1e-12 < free.interface_model(1e-3)["H"][first + 1, first + 1]
    assert abs(model["a"][first + 1]) < 1e-9


def made_at(made, joint):
    return made.model.jnt_qposadr[made.model.joint(joint).id]


class Spring:
    """A spring and a damper whose other end goes down to `depth_m` and back, once in 0.25 s."""

    direct_feedthrough = True

    def __init__(self, parameters):
        self.p, self.time = parameters, 0.0

    def outputs(self, u):
        end = 0.5 * self.p["depth_m"] * (1.0 - math.cos(2 * math.pi * self.time / 0.25))
        return (-self.p["stiffness_n_m"] * (u[0] + end) - self.p["damping_n_s_m"] * u[1],)

    def step(self, t, u, h):
        self.time = t + h


XML = """<mujoco><option timestep="1e-3"/><default><geom condim="1" solref="0.002 1"/></default><worldbody>
  <geom name="floor" type="plane" size="9 9 1"/>
  <body pos="0 0 0.12"><joint name="z" type="slide" axis="0 0 1"/><geom name="ball" type="sphere" size="0.1" mass="10"/></body>
  </worldbody></mujoco>"""


SPRING = {"stiffness_n_m": 1e6, "damping_n_s_m": 1e3, "depth_m": 0.021}


def hopping(text=XML, **how):
    def mechanics(parameters):
        return Mechanics(text, [("joint", "z")], **how)

    return rimbench.Case(
        "hopping", mechanics=mechanics, actuator=Spring, interface=[("z_m", "z_m_s", "force_n")],
        parameters=SPRING,
        duration_s="0.5s", macro_step_s="5ms", micro_step_s="0.1ms", reference_step_s="0.2ms",
    )


@pytest.mark.parametrize("scheme", ["rim-nonsmooth-gap", "rim-answers", "zero-order-hold"])
def test_a_contact_that_opens_and_closes_is_foreseen(scheme):
    run = rimbench.simulate(hopping(contacts=[("ball", "floor")]), scheme, "5ms")
    # It is put on the floor, 20 mm below, pressed by 900 N, and lifted again, twice. By a hold the spring is unstable.
    # What is left at any H is the engine's own step.
    assert run.completed == (scheme != "zero-order-hold"), run.reason
    if run.completed:
        assert run.metrics["force_error_rms_of_peak"] < 0.03
        assert run["z_m"].min() < -0.0195


@pytest.mark.parametrize(
    ("case", "words"),
    [
        (lambda: hopping(XML.replace("<option", '<option cone="elliptic"')), "elliptic cones"),
        (lambda: hopping(XML.replace('condim="1"', ""), contacts=[("ball", "floor")]), "`floor` and `ball` have friction (condim 3)"),
    ],
)
def test_a_side_without_a_model_says_why_and_is_asked(case, words):
    refused = rimbench.simulate(case(), "rim-nonsmooth-gap")
    assert refused.outcome == "skipped" and words in refused.reason
    assert rimbench.simulate(case(), "rim-answers").completed


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ({"condim": 3}, "friction (condim 3)"),
        ({"loss": 2}, "frictionloss"),
        ({"contacts": None, "loss": 2}, "bounds"),
        ({"contacts": "engine", "loss": 2}, "bounds"),
        ({"contacts": None, "more": 'cone="elliptic"'}, "elliptic cones"),
        ({"contacts": None, "more": 'noslip_iterations="3"'}, "noslip"),
        ({"contacts": None, "more": 'integrator="implicit"'}, "integrator implicit"),
    ],
)
def test_what_the_exact_model_has_not_is_refused_by_name_and_steps_all_the_same(how, words):
    made = side([("tendon", "rope")], **how)
    assert made.interface_model is None and words in made.no_interface_model
    assert "rim-answers" in made.no_interface_model
    made.step(0.0, (10.0,), 1e-3)
    nothing_touches = floor(condim=3, more='integrator="implicit" cone="elliptic"').replace("solref", 'contype="0" solref')
    assert Mechanics(nothing_touches, [("joint", "z")]).no_interface_model is None


def test_a_contact_beside_those_that_are_listed_is_a_reason():
    made = side([("tendon", "rope")], contacts=[], height=0.49)
    with pytest.raises(rimbench.RimbenchError, match="`floor` and `box`.*contacts does not list them"):
        made.interface_model(1e-3)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: side([("site", "hok", "pin")]), "no site `hok`; did you mean `hook`"),
        (lambda: side([("joint", "elbo")]), "no joint `elbo`; did you mean `elbow`"),
        (lambda: side([("tendon", "chain")]), "no tendon `chain`; valid: rope"),
        (lambda: side([("joint", "ball")]), "more than one coordinate"),
        (lambda: side([("joint", "elbow", 0)]), "lever 0.0 m"),
        (lambda: side([("site", "hook", (0, 0, 0))]), "direction"),
        (lambda: side([("muscle", "x")]), "valid: .*tendon"),
        (lambda: side([]), "interface is empty"),
        (lambda: side([("joint", "z")], contacts=[("box", "flor")]), "no geom `flor`; did you mean `floor`"),
        (lambda: side([("joint", "z")], contacts="engin"), "contacts is `engin`; valid: \"engine\""),
        (lambda: side([("joint", "z")], contacts=[("arm", "floor")]), "`arm` and `floor` of contacts never touch"),
        (lambda: Mechanics(floor().replace("1e-3", '1e-3" integrator="RK4'), [("joint", "z")]), "RK4"),
        (lambda: Mechanics("<mujoco><nothing/></mujoco>", [("joint", "z")]), "cannot be read"),
        (lambda: Mechanics("nowhere.xml", [("joint", "z")]), "cannot be read"),
        (lambda: Mechanics(3, [("joint", "z")]), "model is int"),
        (lambda: Mechanics(floor(), [("joint", "z")], keyframe="home"), "no key `home`; valid: none"),
    ],
)
def test_what_makes_no_side_is_refused(make, words):
    with pytest.raises(rimbench.RimbenchError, match=words):
        make()


def test_a_copy_goes_its_own_way_and_lends_its_room():
    made = side([("tendon", "rope")])
    before = made.outputs(())
    for _ in range(3):
        copied = copy.deepcopy(made)
        assert copied.outputs(()) == before and copied.step(0.0, (1e4,), 1e-3) != before
        del copied
    assert made.outputs(()) == before and len(made._spare) == 1


class Pump:
    """What a copy shares with what it is a copy of, such as a program elsewhere."""

    force = 0.0

    def __deepcopy__(self, memo):
        return self


class Pumped(Mechanics):
    def __init__(self, parameters):
        super().__init__(XML, [("joint", "z")])
        self.pump = Pump()

    def control(self, t):
        self.pump.force = 20.0 - self.pump.force
        self.data.xfrc_applied[1, 2] = self.pump.force


def test_a_state_that_is_not_the_engines_alone_does_not_come_back_and_no_step_is_tried():
    case = rimbench.Case(
        "pumped", mechanics=Pumped, actuator=Spring, interface=[("z_m", "z_m_s", "force_n")],
        parameters=SPRING, duration_s=0.1, macro_step_s=1e-3,
    )
    run = rimbench.simulate(case, "rim-answers")
    assert run.outcome == "skipped" and "state" in run.reason


def test_a_motion_that_is_no_number_any_more_is_told_and_not_reset():
    made = Mechanics(XML, [("joint", "z")])
    with pytest.raises(ArithmeticError, match="no numbers any more"):
        for _ in range(9):
            made.step(0.0, (1e150,), 1e-3)


def test_without_the_engine_one_line_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(rimbench.RimbenchError) as raised:
        Mechanics(XML, [("joint", "z")])
    assert str(raised.value).endswith("valid: pip install mujoco") and "\n" not in str(raised.value)


def test_an_engine_that_is_too_old_is_told_with_both_versions(monkeypatch):
    for version in ("3.3.0", "3.9.0"):
        monkeypatch.setattr(mujoco, "__version__", version)
        with pytest.raises(rimbench.RimbenchError, match=f"needs MuJoCo 3.10 or newer, and this is {version}; valid: .*mujoco>=3.10"):
            Mechanics(SLIDE.format(more=""), [("joint", "s")])
    monkeypatch.setattr(mujoco, "__version__", "3.10.0")
    assert Mechanics(SLIDE.format(more=""), [("joint", "s")]).outputs(()) == (0.0, 0.0)


FILE = """
name = "hopping"
duration_s = 0.2
macro_step_s = 5e-3
micro_step_s = 5e-4
[mechanics]
python = "hopping.py"
class = "Ball"
[actuator]
python = "hopping.py"
class = "Spring"
[[interface]]
mechanics = {{ position = "z", velocity = "v", force = "f" }}
actuator = {{ position = "z", velocity = "v", force = "f" }}
"""


def test_a_case_file_takes_it_too(program, tmp_path):
    text = f"import math\nfrom rimbench.mujoco import Mechanics\nSPRING = {SPRING!r}\nXML = {XML!r}\n{inspect.getsource(Spring)}"
    text = text.replace("self.p, self.time = parameters, 0.0", "self.p, self.time = SPRING, 0.0")
    for contacts in ([("ball", "floor")], None):
        ball = f"""
class Ball(Mechanics):
    def __init__(self, parameters):
        super().__init__(XML, [("joint", "z")], contacts={contacts!r})
"""
        (tmp_path / "hopping.py").write_text(text + ball)
        (tmp_path / "hopping.toml").write_text(FILE.format())
        typed = ["--case", "hopping.toml", "--scheme", "rim-nonsmooth-gap", "--format", "json", "--trace", "trace.csv"]
        done = subprocess.run(
            [program, "simulate", *typed], cwd=tmp_path, capture_output=True, text=True, check=False,
            env={**os.environ, "RIMBENCH_PYTHON": sys.executable},
        )
        said = json.loads(done.stdout)
        assert said["outcome"] == "completed", (said["reason"], done.stderr)
        # The same side as in this process.
        here = rimbench.simulate(hopping(contacts=contacts), "rim-nonsmooth-gap", duration_s=0.2, micro_step_s=5e-4)
        there = np.genfromtxt(tmp_path / "trace.csv", delimiter=",", names=True)
        np.testing.assert_allclose(there["interface_position_m"], here["z_m"], rtol=0, atol=1e-12)


SLIDE = """<mujoco><option timestep="1e-3" gravity="0 0 0"/><worldbody><body><joint name="s" type="slide" axis="1 0 0"/>
<geom type="sphere" size="0.01" mass="1" contype="0" conaffinity="0"/></body></worldbody>{more}</mujoco>"""


def test_forces_of_a_subclass_are_added_to_and_stay_its_own():
    class Pushed(Mechanics):
        def control(self, t):
            self.data.qfrc_applied[0] = 5.0

    made = Pushed(SLIDE.format(more=""), [("joint", "s")])
    for k in range(100):
        made.step(k * 1e-3, (2.0,), 1e-3)
    assert made.data.qvel[0] == pytest.approx(0.7) and made.data.qfrc_applied[0] == 5.0
    assert made.interface_model(1e-3)["a"][0] == pytest.approx(5.0)
    assert copy.deepcopy(made).data.qfrc_applied[0] == 5.0


@pytest.mark.parametrize("contacts", [[], "engine"])
def test_the_exact_model_is_of_the_model_as_it_is_now(contacts):
    made = Mechanics(SLIDE.format(more=""), [("joint", "s")], contacts=contacts)
    assert made.interface_model(1e-3)["H"][0, 0] == pytest.approx(1.0)
    made.model.body_mass[1] = 4.0
    mujoco.mj_setConst(made.model, mujoco.MjData(made.model))
    margins, flags = made.model.geom_margin.copy(), made.model.opt.disableflags
    if contacts == "engine":
        # The engine's next step still has the old mass.
        speed = made.step(0.0, (1.0,), 1e-3)[1]
        assert speed == pytest.approx(1e-3)
    assert made.interface_model(1e-3)["H"][0, 0] == pytest.approx(0.25)
    assert (made.model.geom_margin == margins).all() and made.model.opt.disableflags == flags


@pytest.mark.parametrize("more", [
    '<actuator><motor name="m" joint="s" delay="0.1" nsample="{room}"/></actuator>',
    '<sensor><jointpos name="m" joint="s" delay="0.1" nsample="{room}"/></sensor>',
])
def test_a_delay_that_is_counted_in_steps_must_fit_in_those_that_are_taken(more):
    if not hasattr(mujoco.MjModel, "actuator_delay"):
        pytest.skip("this version of MuJoCo has no delays")
    wide = Mechanics(SLIDE.format(more=more.format(room=1000)), [("joint", "s")])
    wide.step(0.0, (0.0,), 1e-4)
    narrow = Mechanics(SLIDE.format(more=more.format(room=200)), [("joint", "s")])
    narrow.step(0.0, (0.0,), 1e-3)
    with pytest.raises(rimbench.RimbenchError, match=r"`m` .* delay of 0.1 s and nsample = 200, .* valid: nsample of 1000 and more"):
        narrow.step(1e-3, (0.0,), 1e-4)
    with pytest.raises(rimbench.RimbenchError, match="nsample of 100 and more"):
        Mechanics(SLIDE.format(more=more.format(room=50)), [("joint", "s")])
