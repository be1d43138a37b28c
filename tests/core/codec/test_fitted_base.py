"""The base: as many faces as asked for, the scheme that is nearest, bits that its error deserves."""
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from npm_blender.core.bitstream import decode_connectivity, decode_positions, decode_sharp
from npm_blender.core.codec.fitted_base import (
    FINEST,
    LEAST_BITS,
    LEAST_ERROR,
    PLAIN,
    RATE,
    SCHEMES,
    FreeBase,
    Scheme,
    levels_for,
)
from npm_blender.core.errors import Cancelled
from tests.core.codec.senders import free, target, target_of
from tests.core.codec.streams import SHAPES, cylinder
from tests.meshes.thin_shapes import slab

NAMES = pytest.mark.parametrize("name", SHAPES)


@given(st.integers(4, 100_000), st.integers(4, 10**7))
def test_levels_end_before_the_finest_has_too_many_faces(faces, source):
    count = levels_for(faces, source)
    assert 1 <= count <= 4 and (count == 1 or faces * 4**count <= FINEST)
    assert levels_for(faces, source, 2) <= 2


def test_the_sheets_of_a_plate_that_is_thinner_than_coarse_steps_stay_apart():
    def middle(x, y):
        return 0.1 * np.sin(3 * x)

    plate = slab(16, 8, (1.0, 0.5), lambda x, y: middle(x, y) + 4e-4, lambda x, y: middle(x, y) - 4e-4)
    made = FreeBase(target_of(plate), 200, 1)
    base = made.rounded(0)
    assert 2.0**-base.bits < 8e-4 and base.error < 1.5 * max(made.error, LEAST_ERROR)


@NAMES
def test_what_is_coded_is_the_base(name):
    base = free(name).rounded(10)
    F0 = decode_connectivity(base.coded.connectivity)
    assert np.array_equal(F0, base.surface.F0) and len(F0) == 60
    assert np.array_equal(decode_positions(base.coded.positions, F0), base.grid)
    assert np.array_equal(base.V0, base.grid / 1024) and base.surface.n0 == len(base.grid)


@NAMES
def test_the_error_is_that_of_the_surface_on_its_lattice(name):
    base = free(name).rounded(9)
    none = np.zeros(int(base.surface.first[-1]))
    assert base.error == pytest.approx(target(name).error(base.surface, base.V0, none), rel=0.02)


def cost(base):
    """What bits are chosen by: error times bytes."""
    return max(base.error, LEAST_ERROR) * (len(base.coded.connectivity) + len(base.coded.positions)) ** RATE


@NAMES
def test_as_many_bits_as_pay(name):
    chosen = free(name).rounded(0)
    assert free(name).rounded(12).bits == 12
    for bits in (chosen.bits - 1, chosen.bits + 1):
        assert bits < LEAST_BITS or cost(free(name).rounded(bits)) >= cost(chosen)


def test_a_base_that_is_the_source_stays_as_it_is():
    whole = FreeBase(target("torus"), len(SHAPES["torus"].F), PLAIN)
    assert whole.error < 1e-7 and whole.scheme == Scheme(0) and whole.rounded(16).error < 2.0**-16


def test_the_scheme_that_is_nearest_is_taken():
    assert free("closed").scheme.smooth > 0 and free("closed").surface.smooth == free("closed").scheme.smooth
    alone = FreeBase(target("closed"), 60, 2, schemes=(Scheme(0),))
    assert alone.scheme.smooth == 0 and alone.surface.sharp is None and alone.error > free("closed").error


def test_what_is_round_beside_sharp_edges_gets_creases_and_they_are_coded():
    round_part = target_of(cylinder())
    found, plain = (FreeBase(round_part, 60, 2, schemes=schemes) for schemes in (SCHEMES, (Scheme(0), Scheme(4), Scheme(8))))
    assert found.scheme.angle > 0 and found.scheme.smooth > 0 and found.error < 0.8 * plain.error
    base = found.rounded(10)
    coded = decode_sharp(base.coded.sharp, base.grid, base.surface.hierarchy[0])
    assert np.array_equal(coded.edges, base.surface.sharp.edges) and np.array_equal(coded.corners, base.surface.sharp.corners)
    assert base.surface.sharp.edges.any() and not plain.rounded(10).coded.sharp


def test_it_can_be_cancelled():
    def cancel(fraction, message):
        assert message
        if fraction > 0.3:
            raise Cancelled("Cancelled")

    with pytest.raises(Cancelled):
        FreeBase(target("closed"), 60, 2, cancel)
