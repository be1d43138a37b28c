import json

import numpy as np
import pytest

from npm_blender.core.errors import WeightsError
from npm_blender.core.network import weights
from npm_blender.core.network.parameters import NetworkConfig, flatten_tree, folded, initial_parameters


def test_weights_survive_saving(tmp_path):
    config = NetworkConfig((4, 4), (4,))
    params = folded(initial_parameters(config))
    weights.save_weights(tmp_path / "small.npz", params, config)
    read = weights.load_weights("small", tmp_path)
    assert read.config == config and read.digest == weights.weights_digest(params) and len(read.digest) == 8
    pairs = zip(flatten_tree(read.params).values(), flatten_tree(params).values(), strict=True)
    assert all((a == b).all() for a, b in pairs)


def test_one_changed_number_changes_the_digest():
    params = initial_parameters(NetworkConfig((4,), (4,)))
    before = weights.weights_digest(params)
    params["decoder"][0]["skip"][0, 0] += 1e-3
    assert weights.weights_digest(params) != before


def test_missing_weights(tmp_path):
    with pytest.raises(WeightsError, match="found none; reinstall"):
        weights.load_weights("absent", tmp_path)


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 not really", b"\x80\x04pickle"], ids=["empty", "torn zip", "pickle"])
def test_damaged_weights(tmp_path, content):
    (tmp_path / "bad.npz").write_bytes(content)
    with pytest.raises(WeightsError, match="damaged"):
        weights.load_weights("bad", tmp_path)


def test_weights_with_changed_bytes_never_end_in_a_traceback(tmp_path):
    whole = (weights.FOLDER / f"{weights.DEFAULT}.npz").read_bytes()
    random = np.random.default_rng(0)
    for k, at in enumerate(random.integers(0, len(whole) - 64, 40)):
        (tmp_path / f"bad{k}.npz").write_bytes(whole[:at] + random.bytes(64) + whole[at + 64:])
        try:
            read = weights.load_weights(f"bad{k}", tmp_path)
        except WeightsError:
            continue
        assert read.digest == weights.load_weights().digest  # the bytes did not matter


def test_weights_of_another_shape(tmp_path):
    np.savez(tmp_path / "odd.npz", config=np.array(json.dumps({"unknown": [1]})))
    with pytest.raises(WeightsError, match="damaged"):
        weights.load_weights("odd", tmp_path)


def test_shipped_weights_are_finite_and_small():
    shipped = weights.load_weights()
    assert all(np.isfinite(v).all() for v in flatten_tree(shipped.params).values())
    assert (weights.FOLDER / f"{weights.DEFAULT}.npz").stat().st_size < 2_000_000
