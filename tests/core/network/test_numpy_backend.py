"""The matrix product is chosen by what NumPy was built on, never by a timing: the same mesh gives the same bytes."""
import numpy as np
import pytest

from npm_blender.core.network import numpy_backend


@pytest.fixture(autouse=True)
def asked_anew():
    numpy_backend.fast_product.cache_clear()
    yield
    numpy_backend.fast_product.cache_clear()


@pytest.mark.parametrize("name", ["openblas", "openblas64", "scipy-openblas", "mkl-sdl", "accelerate", "flexiblas"])
def test_an_optimised_library_multiplies_itself(monkeypatch, name):
    monkeypatch.setattr(np, "show_config", lambda mode: {"Build Dependencies": {"blas": {"name": name}}})
    assert numpy_backend.fast_product() is np.matmul


def test_the_reference_library_does_not(monkeypatch):
    monkeypatch.setattr(np, "show_config", lambda mode: {"Build Dependencies": {"blas": {"name": "blas"}}})
    x, w = np.arange(12, dtype=np.float32).reshape(4, 3), np.arange(6, dtype=np.float32).reshape(3, 2)
    product = numpy_backend.fast_product()
    assert product is not np.matmul and product(x, w).tolist() == (x @ w).tolist()


@pytest.mark.parametrize("answer", [None, {}, {"Build Dependencies": {}}])
def test_a_numpy_that_does_not_say_multiplies_itself(monkeypatch, answer):
    monkeypatch.setattr(np, "show_config", lambda mode: answer)
    assert numpy_backend.fast_product() is np.matmul


def test_a_numpy_of_before_modes_multiplies_itself(monkeypatch):
    monkeypatch.setattr(np, "show_config", lambda: None)
    assert numpy_backend.fast_product() is np.matmul


def test_no_clock_is_asked(monkeypatch):
    def no_clock(*_):
        raise AssertionError("a choice by timing differs from run to run")

    for clock in ("perf_counter", "process_time", "monotonic", "time"):
        monkeypatch.setattr(f"time.{clock}", no_clock)
    numpy_backend.fast_product()
