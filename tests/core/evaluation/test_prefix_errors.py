"""Errors at stops: what was measured is what the metrics say, and the text that keeps it is read with care."""
import json

import numpy as np
import pytest

from npm_blender.core.codec import compress, open_stream
from npm_blender.core.errors import Cancelled, StreamError
from npm_blender.core.evaluation import prefix_errors
from npm_blender.core.evaluation.metrics import Original
from npm_blender.core.mesh.triangle_mesh import TriMesh
from npm_blender.core.settings import CompressSettings, LodSettings
from tests.meshes.shapes import icosphere


@pytest.fixture(scope="module")
def original():
    mesh = icosphere(4)
    V = mesh.V * (1 + 0.2 * np.sin(5 * mesh.V[:, :1]) + 0.1 * np.sin(9 * mesh.V[:, 1:2]))
    return TriMesh(3 * V + 7, mesh.F)


@pytest.fixture(scope="module")
def stream(original):
    settings = CompressSettings(lod=LodSettings(base_faces=80, levels=2))
    return open_stream(compress(original, settings).data)


@pytest.fixture(scope="module")
def measured(original, stream):
    return prefix_errors.measure_prefixes(stream, original)


def test_every_stop_and_level_is_measured(measured, stream, original):
    assert measured.features == stream.stops and measured.features[-1] == stream.features
    assert measured.size == pytest.approx(np.ptp(original.V, axis=0).max())
    assert len(measured.errors) == 3 and all(len(stops) == len(measured.features) for stops in measured.errors)
    assert measured.bytes == tuple(stream.bytes_for(k) for k in measured.features)


@pytest.mark.parametrize("level", [0, 1, 2])
def test_a_stop_is_as_far_off_as_the_metrics_say(measured, stream, original, level):
    k = len(measured.features) // 2
    exact = Original(original, 200_000).evaluate(stream.decode(measured.features[k], level))
    assert measured.errors[level][k].d_pm == pytest.approx(exact.d_pm, rel=0.05)
    assert measured.errors[level][k].d_reverse == pytest.approx(exact.d_reverse, rel=0.05)


def test_how_far_off_a_stop_is_said_to_be_is_the_worse_way(measured):
    for stops in measured.errors:
        assert all(stop.worse == max(stop.d_pm, stop.d_reverse) for stop in stops)


@pytest.mark.parametrize("most", [2, 3, 16])
def test_many_stops_are_thinned_and_few_stay(most):
    stops = tuple(3**k for k in range(40))
    found = prefix_errors.thinned(stops, most)
    assert len(found) == most and found[0] == stops[0] and found[-1] == stops[-1] and found == tuple(sorted(set(found)))
    assert prefix_errors.thinned(stops[:most], most) == stops[:most] and prefix_errors.thinned((0,), most) == (0,)


def test_between_stops_nothing_is_claimed_but_what_was_measured_on_both_sides(measured):
    first, second = measured.features[1:3]
    assert measured.around(first, 2) == (measured.errors[2][1],)
    assert measured.around(first + 1, 2) == (measured.errors[2][1], measured.errors[2][2])
    assert measured.around(second, 1) == (measured.errors[1][2],)
    assert measured.around(10**6, 2) == (measured.errors[2][-1],)


def test_text_and_back(measured):
    again = prefix_errors.prefix_errors_from_text(measured.to_text())
    assert again.features == measured.features and again.bytes == measured.bytes
    assert again.errors[2][0].d_pm == pytest.approx(measured.errors[2][0].d_pm, rel=1e-3)
    assert again.to_text() == measured.to_text()


def damaged(**changes):
    return lambda said: json.dumps({**said, **changes})


DAMAGE = {
    "no JSON": lambda said: "{",
    "a list": lambda said: "[]",
    "a field is missing": lambda said: json.dumps({k: v for k, v in said.items() if k != "bytes"}),
    "not a number": lambda said: json.dumps(said).replace('"size":', '"size":"x","_":'),
    "NaN": damaged(size=float("nan")),
    "a negative size": damaged(size=-1.0),
    "stops that go down": lambda said: json.dumps({**said, "features": said["features"][::-1]}),
    "stops that are not whole": lambda said: json.dumps({**said, "features": [k + 0.5 for k in said["features"]]}),
    "too few errors": lambda said: json.dumps({**said, "errors": [stops[1:] for stops in said["errors"]]}),
    "no level": damaged(errors=[]),
    "endless": lambda said: json.dumps(said) + " " * 2_000_000,
}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE.keys())
def test_damaged_text_is_refused_in_one_line(measured, damage):
    with pytest.raises(StreamError, match="Expected measured errors as JSON, found damaged text"):
        prefix_errors.prefix_errors_from_text(damage(json.loads(measured.to_text())))


def test_measuring_can_be_cancelled(original, stream):
    def cancel(fraction, message):
        assert message == "Measuring"
        if fraction:
            raise Cancelled("Cancelled")

    with pytest.raises(Cancelled):
        prefix_errors.measure_prefixes(stream, original, cancel)
