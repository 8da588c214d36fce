"""`rimbench.servo` against its law at the end of the engine's own steps."""

import csv
import itertools
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco", minversion="3.3")
servo = pytest.importorskip("rimbench.servo")

#: A body that moves in a plane, on a leg of two joints with a foot of friction; a free body, a ball joint and a closed chain beside it.
LEG = """<mujoco><option timestep="{h}" integrator="{integrator}" cone="{cone}" tolerance="1e-14" iterations="200" ls_iterations="100"/>
<default><geom friction=".7" condim="{condim}"/><joint frictionloss="{loss}" damping="{damping}"/></default><worldbody>
<geom type="plane" size="9 9 1"/>
<body pos="0 0 .42"><joint type="slide" axis="1 0 0" frictionloss="0"/><joint type="slide" axis="0 0 1" frictionloss="0"/>
 <geom size=".06" mass="4" contype="0"/><body><joint name="hip" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -.22" size=".02"
 mass=".9"/><body pos="0 0 -.22"><joint name="knee" axis="0 1 0" range="-150 -5" limited="true"/>
 <geom type="capsule" fromto="0 0 0 0 0 -.22" size=".015" mass=".2"/><geom pos="0 0 -.22" size=".02" mass=".05"/></body></body></body>
{more}</worldbody>{after}</mujoco>"""
MORE = """<body pos="2 0 .1"><freejoint/><geom type="box" size=".1 .1 .1" mass="3"/><body pos="0 0 .3"><joint name="arm" axis="0 1 0"/>
 <geom type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass=".4"/><body pos=".3 0 0"><joint type="ball"/><geom size=".05" mass=".2"/></body>
 </body></body><body pos="4 0 1"><joint name="simple" type="slide" axis="0 0 1"/><geom size=".1" mass="2"/></body>
<body pos="6 0 1"><joint name="one" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -.3" size=".02" mass=".4"/></body>
<body pos="6.2 0 1"><joint name="two" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -.3" size=".02" mass=".4"/></body>"""
AFTER = '<equality><joint joint1="one" joint2="two"/></equality>'


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # the engine logs its warnings where it is


def made(names=("hip", "knee"), more="", after="", **how):
    how = {"h": 0.01, "integrator": "Euler", "cone": "pyramidal", "condim": 3, "loss": 0, "damping": 0, **how}
    model = mujoco.MjModel.from_xml_string(LEG.format(more=more, after=after, **how))
    data = mujoco.MjData(model)
    data.qpos[2:4] = 0.5, -1.0
    return model, data, np.array([model.joint(name).dofadr[0] for name in names])


def moved(step, data, K=2000.0, D=20.0, limit=np.inf, steps=200, again=0, write=None):
    """Largest miss of the law over the largest torque, largest torque, and how many steps had contacts, with targets that swing."""
    model, dofs, worst, most, touched = step.model, step.dofs, 0.0, 1.0, 0
    start = data.qpos[model.jnt_qposadr[model.dof_jntid[dofs]]].copy()
    for _ in range(steps):
        target = start + 0.4 * np.sin(9.0 * (data.time + model.opt.timestep)) * np.resize([0.7, 1.0], dofs.size)
        if write:
            write(target)
        else:
            data.qfrc_applied[dofs] = step.torque(data, K, D, target, limit, again)
        mujoco.mj_step(model, data)
        most = max(most, np.abs(step._last[2]).max())
        worst, touched = max(worst, step.miss(data)), touched + (data.ncon > 0)
    return worst / most, most, touched


@pytest.mark.parametrize("h", [0.002, 0.01, 0.02])
@pytest.mark.parametrize("how", [{}, {"integrator": "implicitfast"}, {"cone": "elliptic"}, {"loss": 2}, {"condim": 4}, {"condim": 1}])
def test_the_law_holds_at_the_end_of_the_step_with_one_call(h, how):
    model, data, dofs = made(h=h, **how)
    step = servo.ServoStep(model, dofs)
    miss, _, touched = moved(step, data)
    # The law itself is rounded: K times the last digit of q, some 2000 * 2e-16, amplified by little.
    assert miss < 1e-12 and touched > 20 and step.solves == 200


@pytest.mark.parametrize("h", [0.002, 0.01, 0.02])
def test_the_explicit_law_is_gone_where_this_one_holds(h):
    model, data, dofs = made(h=h)
    for _ in range(20):
        data.qfrc_applied[dofs] = 2000.0 * (np.array([0.7, -1.2]) - data.qpos[2:4]) - 200.0 * data.qvel[dofs]
        mujoco.mj_step(model, data)
    assert not np.abs(data.qvel).max() < 100 or data.warning.number.any()
    model, data, dofs = made(h=h)
    assert moved(servo.ServoStep(model, dofs), data, D=200.0)[0] < 1e-12 and np.abs(data.qvel).max() < 30


def test_free_and_ball_joints_closed_chains_simple_bodies_and_stiffness_of_all_sizes():
    model, data, dofs = made(("hip", "knee", "arm", "simple", "one"), MORE, AFTER)
    K, D = np.array([2000.0, 0.0, 1e4, 1e5, 0.0]), np.array([20.0, 5.0, 0.0, 10.0, 0.0])
    assert moved(servo.ServoStep(model, dofs), data, K, D)[0] < 1e-11  # K ten times that above


@pytest.mark.parametrize("limit", [0.0, 5.0, 20.0, np.array([30.0, 3.0])])
@pytest.mark.parametrize("h", [0.01, 0.02])
def test_torque_limits_are_those_of_the_right_rows(limit, h):
    model, data, dofs = made(h=h)
    miss, most, _ = moved(servo.ServoStep(model, dofs), data, K=1e4, limit=limit)
    assert miss < 1e-10 and most <= max(np.max(limit), 1.0)


def test_rows_at_limits_are_found_one_by_one_too_and_are_those_of_trying_all():
    model, data, dofs = made(("hip", "knee", "arm", "simple"), MORE, AFTER, h=0.02)
    step, rng = servo.ServoStep(model, dofs), np.random.default_rng(1)
    for _ in range(20):
        mujoco.mj_resetData(model, data)
        data.qpos[2:4], data.qvel[:] = (0.5, -1.0), rng.normal(size=model.nv)
        K, target, limit = 10 ** rng.uniform(2, 5, 4), rng.normal(size=4), 10 ** rng.uniform(0, 3, 4)
        torque = step.torque(data, K, 20.0, target, limit)
        h, q = 0.02, data.qpos[step._positions]
        slope, tau_0 = h * 20.0 + h * h * K, K * (target - q - h * data.qvel[dofs]) - 20.0 * data.qvel[dofs]
        found = []
        for at in itertools.product((-1.0, 0.0, 1.0), repeat=4):
            at = np.array(at)
            step._ask(np.where(at == 0, tau_0, at * limit), np.where(at == 0, slope, 0.0))
            wish = tau_0 - slope * step.data.qacc[dofs]
            if (np.where(np.abs(wish) > limit, np.sign(wish), 0.0) == at).all():
                found.append(np.clip(wish, -limit, limit))
        assert len(found) == 1
        np.testing.assert_allclose(torque, found[0], rtol=1e-9, atol=1e-9 * limit.max())


def test_asking_again_brings_the_engines_implicit_damping_closer():
    misses = []
    for again in (0, 1, 4):
        model, data, dofs = made(damping=0.5, h=0.002)
        misses.append(moved(servo.ServoStep(model, dofs), data, again=again)[0])
    assert misses[0] > 3 * misses[1] > 9 * misses[2]
    model, data, dofs = made(damping=0.5, h=0.002)
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
    assert moved(servo.ServoStep(model, dofs), data)[0] < 1e-12


PUSH = np.array([30.0, -7.0])


@pytest.mark.parametrize("habit", ["set", "clear", "push before", "push after", "push after, changing", "set twice", "other dofs", "xfrc"])
def test_the_last_torque_is_no_force_of_the_caller_and_those_of_the_caller_are(habit):
    model, data, dofs = made()
    step, misses, added = servo.ServoStep(model, dofs), [], [0.0 * PUSH]

    def write(target):
        if habit in ("clear", "push before"):
            data.qfrc_applied[dofs] = PUSH * np.sin(50 * data.time) if habit == "push before" else 0.0
            data.qfrc_applied[dofs] += step.torque(data, 2000.0, 20.0, target)
            return
        if habit == "other dofs":
            data.qfrc_applied[:2] = 20.0 * np.sin(50 * data.time), 5.0
        if habit == "xfrc":
            data.xfrc_applied[2] = 5.0, 0.0, 9.0, 0.0, 1.0, 0.0
        for _ in range(1 + (habit == "set twice")):
            data.qfrc_applied[dofs] = step.torque(data, 2000.0, 20.0, target)
        if "push after" in habit:
            # What is added after the call is known from the step after.
            np.testing.assert_allclose(step._last[1], added[-1], rtol=1e-6, atol=1e-9)
            added.append(PUSH * (np.sin(20 * data.time) if "changing" in habit else 1.0))
            data.qfrc_applied[dofs] += added[-1]

    for _ in range(4):
        misses.append(moved(step, data, steps=50, write=write)[0])
    # Of a push that changes after the call, the change is not in the law.
    bound = {"push after, changing": 10.0, "xfrc": 1e-11}.get(habit, 1e-12)
    assert max(misses[1:] if "after" in habit else misses) < bound, misses
    assert np.abs(data.qvel).max() < 30


def test_resets_older_states_other_data_and_callbacks_do_not_confuse_it():
    model, data, dofs = made()
    step, other = servo.ServoStep(model, dofs), mujoco.MjData(model)
    kind = mujoco.mjtState.mjSTATE_INTEGRATION
    state = np.zeros(mujoco.mj_stateSize(model, kind))
    assert moved(step, data, steps=20)[0] < 1e-12
    mujoco.mj_getState(model, data, state, kind)
    assert moved(step, data, steps=20)[0] < 1e-12
    mujoco.mj_setState(model, data, state, kind)
    assert moved(step, data, steps=20)[0] < 1e-12
    mujoco.mj_resetData(model, data)
    data.qpos[2:4] = other.qpos[2:4] = 0.5, -1.0
    for _ in range(20):
        assert moved(step, data, steps=1)[0] < 1e-12 and moved(step, other, steps=1)[0] < 1e-12

    def control(_, own):
        own.qfrc_applied[dofs] = step.torque(own, 2000.0, 20.0, [0.6, -1.1])

    mujoco.set_mjcb_control(control)
    try:
        for _ in range(50):
            mujoco.mj_step(model, data)
            assert step.miss(data) < 1e-9
    finally:
        mujoco.set_mjcb_control(None)


def test_a_call_changes_neither_data_nor_model_and_the_same_state_has_the_same_torque():
    model, data, dofs = made(more=MORE, after=AFTER)
    step = servo.ServoStep(model, dofs)
    moved(step, data, steps=30)
    kind = mujoco.mjtState.mjSTATE_INTEGRATION
    state, again = np.zeros((2, mujoco.mj_stateSize(model, kind)))
    mujoco.mj_getState(model, data, state, kind)
    seen = [data.qacc.copy(), data.efc_force.copy(), data.xpos.copy(), model.dof_armature.copy(), model.dof_M0.copy()]
    torque = step.torque(data, 1e4, 20.0, [0.2, -0.7], 25.0)
    mujoco.mj_getState(model, data, again, kind)
    assert (state == again).all() and (torque == step.torque(data, 1e4, 20.0, [0.2, -0.7], 25.0)).all()
    after = [data.qacc, data.efc_force, data.xpos, model.dof_armature, model.dof_M0]
    assert all((a == b).all() for a, b in zip(seen, after, strict=True))


def test_the_model_is_asked_as_it_is():
    model, data, dofs = made()
    step = servo.ServoStep(model, dofs)
    moved(step, data, steps=10)
    model.body_mass[:] *= 3.0
    model.opt.timestep, model.opt.gravity[2] = 0.005, -3.0
    assert moved(step, data, steps=50)[0] < 1e-12


@pytest.mark.parametrize("option", ["integrator RK4", "integrator IMPLICIT", "noslip", "SLEEP", "DIAGEXACT"])
def test_a_step_without_such_a_torque_is_refused_with_the_reason(option):
    model, data, dofs = made()
    if option.startswith("integrator"):
        model.opt.integrator = int(getattr(mujoco.mjtIntegrator, f"mjINT_{option.split()[1]}"))
    elif option == "noslip":
        model.opt.noslip_iterations = 3
    elif not hasattr(mujoco.mjtEnableBit, f"mjENBL_{option}"):
        pytest.skip(f"this MuJoCo has no {option}")
    else:
        model.opt.enableflags |= int(getattr(mujoco.mjtEnableBit, f"mjENBL_{option}"))
    with pytest.raises(ValueError, match=rf"(?i){option.split()[-1]} .*; valid: Euler, implicitfast"):
        servo.ServoStep(model, dofs).torque(data, 1.0, 1.0, 0.0)


def test_what_is_not_valid_is_named():
    model, data, dofs = made(more=MORE)
    for wrong in ([], [0.5], ["hip"], [2, 2], [-1], [99], [4], [True], [[2, 3]]):
        with pytest.raises(ValueError, match=r"dofs = .* is not valid; valid: .*hinges and slides"):
            servo.ServoStep(model, wrong)
    step = servo.ServoStep(model, dofs)
    good = {"K": 1.0, "D": 1.0, "target": 0.0, "limit": 1.0}
    bad = [("K", -1.0), ("K", [1.0, 2.0, 3.0]), ("D", np.nan), ("target", np.inf), ("limit", -1.0), ("limit", [np.nan, 1.0]), ("K", np.inf)]
    for name, value in bad:
        with pytest.raises(ValueError, match=f"^{name} = .* is not valid; valid: a number or an array of shape"):
            step.torque(data, **{**good, name: value})
    with pytest.raises(ValueError, match="another model"):
        step.torque(made()[1], **good)
    data.qpos[0] = np.nan
    with pytest.raises(ValueError, match="not finite"):
        step.torque(data, **good)


@pytest.mark.parametrize(("again", "damping", "median", "worst"), [(0, 0.1, 7.3e-3, 0.18), (1, 0.1, 2.3e-4, 5.7e-3), (0, 0.0, 1e-13, 1e-12)])
def test_a_quadruped_misses_the_law_by_what_the_guide_says(example, again, damping, median, worst):
    engine = example("quadruped")
    model = engine.robot(damping=damping)
    model.opt.timestep, model.opt.integrator = 0.01, int(mujoco.mjtIntegrator.mjINT_IMPLICITFAST)
    data, (K, D), misses = engine.begin(model), engine.gains(1000.0), []
    step = servo.ServoStep(model, np.arange(6, 18))
    for k in range(200):
        data.qfrc_applied[6:] = step.torque(data, K, D, engine.target((k + 1) * 0.01, 1.0, 2.0), again=again)
        mujoco.mj_step(model, data)
        misses.append(step.miss(data) / max(1.0, np.abs(step._last[2]).max()))
    # Other versions of the engine step otherwise: the guide rounds, and these are not its digits but their size.
    assert np.median(misses) < 2 * median and max(misses) < 2 * worst and step.solves == 200 * (1 + 2 * again)


def test_the_table_of_the_guide_has_the_runs_of_its_program(example):
    engine = example("quadruped")
    assert engine.run("explicit", 1000, 0.01, 1.0, 2.0) is None
    for condim in (3, 4):
        angles = engine.run("ServoStep, again 0", 1000, 0.01, 1.0, 2.0, condim=condim)
        reference = engine.run("ServoStep, again 0", 1000, 0.001, 1.0, 2.0, condim=condim)
        assert 1e3 * np.sqrt(np.mean((angles - reference) ** 2)) < 10.0  # mrad


def test_the_guide_counts_the_cells_of_its_table():
    root = Path(__file__).parents[4]
    with open(root / "results" / "perf" / "servo.csv", newline="", encoding="utf-8") as file:
        rows = {(row["feet"], row["kp"], row["servos"]): row for row in csv.DictReader(file)}
    cells = [(float(row[key]), float(rows[(*name[:2], "engine's, discrete")][key]))
             for name, row in rows.items() if name[2] == "ServoStep, again 0" for key in row if key.startswith("error_")]  # fmt: skip
    page = (root / "docs" / "guide" / "servo.md").read_text(encoding="utf-8").replace("\n", " ")
    assert f"servos in {sum(own < other for own, other in cells)} of {len(cells)} cells" in page


def test_it_needs_neither_the_compiled_part_nor_the_package(tmp_path):
    package = tmp_path / "package" / "rimbench"
    package.mkdir(parents=True)
    for file in Path(servo.__file__).parent.glob("*.py"):
        shutil.copy(file, package)
    shutil.copy(servo.__file__, tmp_path / "alone.py")
    program = "import sys; sys.path[:0] = ['package', '.']; import rimbench.servo, alone, rimbench\ntry: rimbench.simulate('wedge-box', 'nepce')"
    program += "\nexcept ImportError as error: print(error)"
    done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "`simulate` needs the compiled part of rimbench" in done.stdout
