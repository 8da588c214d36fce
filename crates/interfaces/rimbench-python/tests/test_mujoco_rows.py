"""The engine's constraint rows as an exact interface model: its answer against `mj_step`, several steps of the engine, and a quadruped."""

import copy
import csv
from pathlib import Path

import numpy as np
import pytest

import rimbench
from rimbench.mujoco import Mechanics

mujoco = pytest.importorskip("mujoco")

BOX = """<mujoco><option {option}/><default><joint damping="{damping}"/><geom friction=".6 .01 .001" condim="{condim}"/></default><worldbody>
<geom type="plane" size="0 0 1"/><body pos="0 0 .0999"><joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/>
<joint name="z" type="slide" axis="0 0 1"/><joint name="r" type="hinge" axis="0 0 1"/><geom type="box" size=".1 .1 .1" mass="2"/></body></worldbody>
{more}</mujoco>"""
EQUALITY = '<equality><joint joint1="x" joint2="y" polycoef="0 .5 0 0 0"/></equality>'
#: A ball joint with a limit, a closed loop, a tendon with a limit, a position actuator, contacts of friction and without.
CHAIN = """<mujoco><option {option}/><worldbody><geom type="plane" size="0 0 1" condim="1"/><body pos="0 0 .35">
<joint name="z" type="slide" axis="0 0 1"/><geom size=".05"/><body name="arm"><joint name="b" type="ball" limited="true" range="0 .3"/>
<geom type="capsule" fromto="0 0 0 .2 0 0" size=".03"/><site name="s" pos=".2 0 0"/><body pos=".2 0 0">
<joint name="h" axis="0 1 0" range="-.2 .2" limited="true" damping=".3"/><geom type="capsule" fromto="0 0 0 .2 0 0" size=".03" condim="4"/></body>
</body></body><body name="other" pos=".2 .2 .1"><freejoint/><geom size=".05" condim="1"/></body></worldbody>
<tendon><fixed name="t" limited="true" range="-.3 .1"><joint joint="z" coef="1"/><joint joint="h" coef=".5"/></fixed></tendon>
<equality><connect body1="arm" body2="other" anchor=".2 0 0"/></equality>
<actuator><position joint="h" kp="20" kv="1"/></actuator></mujoco>"""
CHAIN_ROWS = [("joint", "z"), ("joint", "h"), ("tendon", "t")]
#: The engine's step is solved to the last digit, where a scene does not say otherwise.
OPTION = 'timestep="{h}" iterations="200" tolerance="0" ls_iterations="100" ls_tolerance="1e-12" {more}'


def complementary(H, b):
    """P of 0 <= H P + b, P >= 0, complementary, of a positive definite H: all that are wrong change sides, or the last one."""
    on, least, patience = np.zeros(len(b), bool), len(b) + 1, 10
    for _ in range(100 + 20 * len(b)):
        P = np.zeros(len(b))
        P[on] = np.linalg.solve(H[np.ix_(on, on)], -b[on])
        wrong = np.where(on, P < 0.0, H @ P + b < -1e-12 * max(1.0, np.abs(b).max(initial=0.0)))
        if not wrong.any():
            return P
        patience = 10 if wrong.sum() < least else patience - 1
        least = min(least, wrong.sum())
        on ^= wrong if patience > 0 else np.arange(len(b)) == np.flatnonzero(wrong)[-1]
    raise AssertionError("no active set")


def answer(model, h, force):
    """Velocities of the interface after one step h of the engine under a force, by the law of the rows, and which of them push."""
    H, a, w, n = model["H"], model["a"], model["w"], len(model["gap"])
    wanted = -(1.0 - h * model["damping"]) * w[:n] + h * model["stiffness"] * model["gap"]
    free = w + h * (a + H[:, n:] @ force)
    P = complementary(H[:n, :n] + np.diag(model["compliance"]), free[:n] + wanted)
    return free[n:] + H[n:, :n] @ P, P > 0.0


def misses(made, h, size, warm=40, trials=20):
    """Errors of the model's velocities, of the largest change of one, under random forces; and how many rows push at most."""
    random, errors, most, rows = np.random.default_rng(0), [], 0, len(made._interface)
    for k in range(warm + trials):
        if k >= warm:
            model = made.interface_model(h)
            for force in random.normal(size=(2, rows)) * size:
                told, push = answer(model, h, force)
                stepped = np.array(copy.deepcopy(made).step(0.0, tuple(force), h)[rows:])
                change = max(np.abs(stepped - model["w"][-rows:]).max(), 1e-3)
                errors.append(np.abs(told - stepped).max() / change)
                most = max(most, push.sum())
        made.step(0.0, tuple(random.normal(size=rows) * size), h)
    return errors, most


def box(condim=3, damping=0, more="", h=5e-3, **option):
    text = " ".join(f'{key}="{value}"' for key, value in option.items())
    return BOX.format(condim=condim, damping=damping, more=more, option=OPTION.format(h=h, more=text))


def chain(h=5e-3, **option):
    text = " ".join(f'{key}="{value}"' for key, value in option.items())
    return CHAIN.format(option=OPTION.format(h=h, more=text))


def joints(model):
    return [("joint", model.joint(at).name) for at in range(model.njnt) if model.jnt_type[at] >= 2]


SCENES = {
    **{f"box, condim {condim}": (box(condim), {}) for condim in (1, 3, 4, 6)},
    "box, equality": (box(more=EQUALITY), {}),
    "box, equality and damping": (box(more=EQUALITY, damping=3.0), {}),
    **{f"chain, {integrator}": (chain(integrator=integrator), {"rows": CHAIN_ROWS}) for integrator in ("Euler", "implicitfast")},
    **{f"quadruped, {integrator}": (None, {"integrator": kind}) for integrator, kind in (("Euler", 0), ("implicitfast", 3))},
    **{f"quadruped, {integrator}, undamped": (None, {"integrator": kind, "damping": 0.0}) for integrator, kind in (("Euler", 0), ("implicitfast", 3))},
    "quadruped, feet of condim 4": (None, {"condim": 4}),
    "quadruped, sparse": (None, {"jacobian": 1}),
    "quadruped, margins": (None, {"margin": 0.02}),
    **{f"quadruped, {name}": (None, {"solver": kind, "iterations": 3000}) for name, kind in (("PGS", 0), ("CG", 1))},
    "quadruped, default tolerance": (None, {"tolerance": 1e-8}),
}


@pytest.mark.parametrize("scene", SCENES)
def test_the_model_of_the_rows_answers_as_the_engine_steps(scene, example):
    text, how = SCENES[scene]
    how = dict(how)
    if text is None:
        model = example("quadruped").robot(how.pop("condim", 3), how.pop("damping", 0.1))
        margin = how.pop("margin", 0.0)
        model.geom_margin[:], model.jnt_margin[:] = margin, margin
        model.opt.timestep, model.opt.tolerance, model.opt.ls_tolerance = 5e-3, 0.0, 1e-12
        for option, value in how.items():
            setattr(model.opt, option, value)
        made = Mechanics(model, joints(model))
        made.data.qpos[7:] = example("quadruped").STAND
        made._see()
    else:
        model = mujoco.MjModel.from_xml_string(text)
        made = Mechanics(model, how.get("rows") or joints(model))
    errors, most = misses(made, 5e-3, 8.0)
    # Round-off of solves with a condition of some 1e2 to 1e3; that of the engine's own solver where it stops early.
    assert max(errors) < 1e-12 and most > 1, (max(errors), most)


def test_rows_that_turn_within_a_step_are_an_error_of_its_order():
    found = {h: np.median(misses(Mechanics(chain(h), [("joint", "z"), ("site", "s", (0, 0, 1))]), h, 8.0)[0]) for h in (5e-3, 5e-4)}
    assert 0.0 < 5 * found[5e-4] < found[5e-3] < 1e-2, found


class Push:
    """A force that depends on time only; it notes the motion that it is told."""

    told: list = []

    def __init__(self, parameters):
        self.time = 0.0

    def outputs(self, u):
        return 15.0 * np.sin(33.0 * self.time), 9.0 * np.cos(27.0 * self.time)

    def step(self, t, u, h):
        self.time = t + h
        self.told.append((t + h, *u))


def pushed(text, h=0.01, scale=None, **how):
    return rimbench.Case(
        "push", mechanics=lambda p: Mechanics(text, [("joint", "x"), ("joint", "y")], **how), actuator=Push,
        interface=[(f"{row}_m", f"{row}_m_s", f"{row}_n") for row in "xy"], parameters={},
        duration_s=0.5, macro_step_s=h, micro_step_s=h / 20, reference_step_s=h / 20, scale=scale,
    )  # fmt: skip


@pytest.mark.parametrize("steps", [1, 2, 5])
@pytest.mark.parametrize("how", [{"contacts_act": "mechanics-step"}, {}], ids=["own-step", "micro-steps"])
def test_several_steps_of_the_engine_follow_targets_that_move(steps, how):
    """A box that rubs and chatters: rows by the dozen come and go. The model ends where the mechanics does, and without new targets
    in each of the engine's steps it would be a tenth of the largest change off."""
    h = 0.01
    case = pushed(box(h=h / steps), h)
    Push.told.clear()
    run = rimbench.simulate(case, "rim-nonsmooth", h, **how)
    assert run.completed, run.reason
    ends = np.array(Push.told[-1000:])[19::20]
    moves = np.array([run["x_m_s"], run["y_m_s"]]).T
    error, change = np.abs(ends[:, 3:] - moves[1:51]).max(axis=1), np.abs(np.diff(moves, axis=0)).max()
    # Of one step to the digit; of several the mechanics has one mean force, and impedances stand.
    assert np.median(error) < (1e-12 if steps == 1 else 0.02) * change, np.median(error) / change


def test_what_a_model_of_rows_cannot_have_ends_a_run_in_words():
    run = rimbench.simulate(pushed(box(h=0.01), engine_rows=15), "rim-nonsmooth")
    assert run.outcome != "completed" and "16 rows at once" in run.reason and "engine_rows=16" in run.reason
    run = rimbench.simulate(pushed(box(h=0.02)), "rim-nonsmooth")
    assert run.outcome == "skipped" and "its own step of 2e-2 s" in run.reason
    assert rimbench.simulate(pushed(box(h=0.02)), "zero-order-hold").completed
    with pytest.raises(rimbench.RimbenchError, match="scale = .*three numbers above 0"):
        pushed(box(h=0.01), scale=(1.0, 0.0, 1.0))


def test_a_cell_of_the_study_of_servos_comes_out_as_it_is_kept():
    root = Path(__file__).parents[4]
    case = rimbench.open_case(root / "experiments" / "study" / "servos" / "quadruped.toml")
    with open(root / "results" / "study" / "servos" / "summary.csv", newline="", encoding="utf-8") as file:
        wanted = ("feet_condim=4.0 kp_n_m_rad=1000.0 motion=1.0", "0.01")
        kept = [row for row in csv.DictReader(file) if (row["set"], row["macro_step_s"]) == wanted]
    for label, scheme, how in (
        ("rim-nonsmooth/own-step", "rim-nonsmooth", {"contacts_act": "mechanics-step"}), ("interface-mass", "interface-mass", {}),
    ):
        (row,) = (row for row in kept if row["label"] == label)
        run = rimbench.simulate(case, scheme, 0.01, kp_n_m_rad=1000, feet_condim=4, motion=1, divide_error=False, **how)
        assert run.completed and row["completed"] == row["runs"] == "1"
        # Other versions of the engine have other digits.
        assert run.metrics["position_error_rms_m"] == pytest.approx(float(row["position_error_rms_m_median"]), rel=0.1)
