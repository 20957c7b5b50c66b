import io
from dataclasses import replace

import numpy as np
import pytest
import torch

from simsat.control.correction.network import Network
from simsat.control.ground.arrays import Array
from simsat.control.ground.errors import SettingsError
from simsat.learning.correction.fit import (
    FitSettings,
    PinnState,
    RoundData,
    best_network,
    build_round_data,
    held_out_loss,
    next_round,
    run_epoch,
    start,
    unpack,
)
from simsat.learning.correction.pinn import Pinn, as_network, build_pinn
from simsat.learning.correction.windows import shifted
from simsat.learning.progress import pack
from simsat.mjcf import Model
from tests.learning_cases import believed_of, made_up_windows

torch.set_num_threads(1)

SETTINGS = FitSettings(epochs=12, teacher_epochs=3, batch=64, hidden=(24, 24))


@pytest.fixture(scope="module")
def data(two_wheel: Model) -> RoundData:
    training, held_out = made_up_windows(two_wheel, 12, 30), made_up_windows(two_wheel, 3, 30, 1)
    return build_round_data(training, held_out, believed_of(two_wheel))


def inputs(data: RoundData) -> Array:
    x = data.training.features(shifted(data.training.residual), data.believed)
    return x.reshape(-1, x.shape[-1])


def fresh(data: RoundData, seed: int = 0) -> Pinn:
    return build_pinn(inputs(data), 2, SETTINGS.hidden, SETTINGS.bound, seed)


def trained(data: RoundData, epochs: int, state: PinnState | None = None) -> PinnState:
    state = state or start(fresh(data), SETTINGS)
    for _ in range(epochs):
        run_epoch(state, data, SETTINGS, seed=0)
    return state


def same(a: Network, b: Network) -> bool:
    return all(np.array_equal(p, q) for p, q in zip(a.weights + a.biases, b.weights + b.biases,
                                                    strict=True))  # fmt: skip


def test_training_learns_the_missed_torque(data: RoundData) -> None:
    state = trained(data, 12)
    assert held_out_loss(best_network(state), data) == state.best_loss < 0.04


def test_the_same_seed_gives_the_same_weights(data: RoundData) -> None:
    first, second = trained(data, 4), trained(data, 4)
    assert same(as_network(first.module), as_network(second.module))
    assert not same(as_network(fresh(data, 0)), as_network(fresh(data, 1)))


def test_a_restart_from_a_checkpoint_changes_nothing(data: RoundData) -> None:
    whole = trained(data, 6)
    buffer = io.BytesIO()
    torch.save(pack(trained(data, 4)), buffer)
    buffer.seek(0)
    state = unpack(torch.load(buffer, weights_only=True), fresh(data, 5), SETTINGS)
    resumed = trained(data, 2, state)
    assert same(as_network(whole.module), as_network(resumed.module))
    assert same(best_network(whole), best_network(resumed))
    assert resumed.curves == whole.curves


def test_a_round_ends_after_patience_or_the_last_epoch(data: RoundData) -> None:
    impatient = replace(SETTINGS, patience=2, learning_rate=1e-300)
    state = start(fresh(data), impatient)
    for _ in range(3):
        assert not state.finished
        run_epoch(state, data, impatient, seed=0)
    assert state.finished
    assert trained(data, 12).finished


def test_the_next_round_goes_on_from_the_best_weights(data: RoundData) -> None:
    state = trained(data, 4)
    best = best_network(state)
    next_round(state, SETTINGS)
    assert same(as_network(state.module), best)
    assert (state.round, state.epoch, state.finished) == (2, 0, False)


def test_numpy_and_torch_agree(data: RoundData) -> None:
    pinn = fresh(data)
    x = inputs(data)
    with torch.no_grad():
        answer = pinn(torch.as_tensor(x)).numpy()
    assert np.abs(as_network(pinn).estimate(x) - answer).max() < 1e-15  # Nm
    assert np.abs(as_network(pinn).estimate(1e6 * x)).max() <= SETTINGS.bound


def test_settings_that_cannot_train_are_refused() -> None:
    with pytest.raises(SettingsError, match=r"--fit.learning-rate is nan: .* above 0"):
        FitSettings(learning_rate=float("nan"))
    with pytest.raises(SettingsError, match=r"--fit.hidden is empty"):
        FitSettings(hidden=())
