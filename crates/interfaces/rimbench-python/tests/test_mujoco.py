"""The wedge box in MuJoCo, held against the one of the case."""

import numpy as np
import pytest

import rimbench

# `mj_fullM` has another signature before.
pytest.importorskip("mujoco", minversion="4.0")


@pytest.fixture
def engine(example):
    return example("mujoco_wedge_box")


class FirstModel:
    """Keeps the first interface model, and holds."""

    def __init__(self, outputs):
        self.held = {}

    def receive(self, side, sample):
        if side == "mechanics" and FirstModel.seen is None:
            FirstModel.seen = sample.model
        self.held[side] = sample.y

    def input(self, side, at, own):
        return self.held["actuator" if side == "mechanics" else "mechanics"]


def test_two_engines_reduce_the_same_box_to_the_same_model(engine):
    models = []
    for case in ("wedge-box", engine.soft):
        FirstModel.seen = None
        rimbench.simulate(case, rimbench.Scheme("first-model", FirstModel, interface_model=True), 1e-3, duration_s=5e-3)
        models.append(FirstModel.seen)
    own, foreign = models
    # H in 1/kg, a in m/s², gaps and lengths in m: all of order 1 and below, computed by two programs in a few dozen operations.
    for key in ("H", "a", "w", "gap", "position"):
        np.testing.assert_allclose(foreign[key], own[key], rtol=1e-12, atol=1e-13, err_msg=key)


def test_gap_tracking_stays_with_the_reference_and_softness_is_what_remains(engine):
    own, soft, stiffer = (
        rimbench.simulate(case, "rim-nonsmooth-gap", 2e-3, mechanics_steps=4)
        for case in ("wedge-box", engine.soft, engine.stiffer)
    )
    assert own.completed and soft.completed and stiffer.completed
    error, deep = ([run.metrics[key] for run in (soft, stiffer)] for key in ("force_error_rms_n", "penetration_m"))
    # A tenth of the time constant: what is hit gives way a tenth as far.
    assert error[1] < 0.1 * error[0] and deep[1] < 0.2 * deep[0]
    assert error[1] < 2 * own.metrics["force_error_rms_n"]
    assert own.metrics["penetration_m"] < 1e-6 < deep[1]


def test_the_smooth_model_jumps_in_either_engine(engine):
    for case in ("wedge-box", engine.stiffer):
        run = rimbench.simulate(case, "rim-smooth", 5e-3, mechanics_steps=10, contact_detection="margin:1e-3")
        assert run.outcome == "diverged" and 1.6 < run.outcome_at_s < 1.7, run.reason
