"""Neural Subdivision as a method of the comparison, with the weights that ship."""
import numpy as np
import pytest

from benchmarks.methods import neural_subdivision as method
from benchmarks.methods import qslim, schemes
from benchmarks.methods.case import Case
from npm_blender.core.errors import MeshError
from npm_blender.core.mesh.triangle_mesh import TriMesh
from tests.meshes.shapes import bumpy, grid


@pytest.fixture(scope="module")
def case():
    """A smooth closed mesh of 5,120 faces."""
    return Case.of("bumpy", bumpy(4, height=0.1), 4_000)


def test_numbers_buy_a_base_and_the_network_does_the_rest(case):
    count = 3 * 202
    (made,), (base,) = method.at_scalars(case, [count]), qslim.at_scalars(case, [count])
    assert len(base.V) == 202 and len(made.F) == len(base.F) * 4 ** schemes.steps(len(base.F))
    assert case.worse(made) < case.worse(base)


def test_bytes_are_kept_and_more_of_them_help(case):
    found = method.at_bytes(case, (10, 600, 1_500))
    assert found[0] is None
    assert [0 < coded.bytes <= budget for coded, budget in zip(found[1:], (600, 1_500), strict=True)] == [True, True]
    assert case.worse(found[2].mesh) < case.worse(found[1].mesh)


def test_open_meshes_work_and_too_few_numbers_give_none():
    case = Case.of("sheet", grid(24), 2_000)
    made, none = method.at_scalars(case, [300, 6])
    assert none is None and np.isfinite(made.V).all() and len(made.F) > 64 * 100


def test_what_is_no_manifold_is_an_error():
    fin = TriMesh(np.eye(5, 3), np.array([[0, 1, 2], [0, 1, 3], [0, 1, 4]], np.int32))
    with pytest.raises(MeshError):
        method.subdivided(fin)
