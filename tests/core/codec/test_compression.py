"""Compress and open, both kinds of streams: topology, errors, settings, progress."""
import numpy as np
import pytest

from npm_blender.core.codec import compress, open_stream
from npm_blender.core.errors import Cancelled, MeshError, SettingsError
from npm_blender.core.evaluation import evaluate
from npm_blender.core.mesh import TriMesh, topology_of
from npm_blender.core.settings import PAPER, CompressSettings, LodSettings
from tests.core.codec.streams import SHAPES, SMALL, SMALL_PAPER, made, opened, silent

BOTH = {"displaced": SMALL, "paper": SMALL_PAPER}
ALL = pytest.mark.parametrize(("name", "settings"), [(name, kind) for name in SHAPES for kind in BOTH.values()],
                              ids=[f"{name}, {kind}" for name in SHAPES for kind in BOTH])


def worse(mesh, source):
    """The larger of both mean distances, 1e-4 of the longest side."""
    found = evaluate(mesh, source, 20_000)
    return max(found.d_pm, found.d_reverse)


@pytest.mark.slow
@ALL
def test_a_decoded_mesh_keeps_the_topology_and_is_nearer_than_its_base(name, settings):
    stream, source = opened(name, settings), topology_of(SHAPES[name].F)
    now = topology_of(stream.decode().F)
    assert (now.euler, now.border_loops, now.components) == (source.euler, source.border_loops, source.components)
    assert worse(stream.decode(), SHAPES[name]) < 0.6 * worse(stream.decode(0, 0), SHAPES[name])


@ALL
def test_all_features_are_better_than_none(name, settings):
    stream = opened(name, settings)
    assert worse(stream.decode(), SHAPES[name]) < 0.7 * worse(stream.decode(0), SHAPES[name])


@ALL
def test_the_report_is_true(name, settings):
    report, stream = made(name, settings).report, opened(name, settings)
    assert (report.bytes, report.features) == (stream.total_bytes, stream.features)
    assert (report.base_faces, report.levels) == (stream.base_faces, stream.levels) and report.faces == len(SHAPES[name].F)
    assert stream.model == settings.model and not stream.truncated and stream.corrupt is None
    assert min(report.seconds.values()) >= 0 and "clean" in report.seconds


@pytest.mark.parametrize("settings", BOTH.values(), ids=BOTH)
def test_the_same_input_gives_the_same_bytes(settings):
    assert compress(SHAPES["torus"], settings, silent).data == made("torus", settings).data


@pytest.mark.parametrize("levels", [1, 3])
def test_levels_and_base_faces_are_obeyed(levels):
    stream = open_stream(compress(SHAPES["open"], CompressSettings(LodSettings(base_faces=40, levels=levels)), silent).data)
    assert stream.levels <= levels and len(stream.decode(level=0).F) == stream.base_faces == 40
    assert worse(stream.decode(), SHAPES["open"]) < 60


@pytest.mark.parametrize("bits", [6, 15])
def test_position_bits_are_obeyed(bits):
    made_it = compress(SHAPES["torus"], CompressSettings(LodSettings(base_faces=60, levels=1), position_bits=bits), silent)
    assert open_stream(made_it.data).position_bits == bits


def test_object_space_is_kept():
    mesh = SHAPES["closed"]
    moved = TriMesh(mesh.V * 250 + [1e4, -30, 7], mesh.F)
    a, b = open_stream(compress(moved, SMALL, silent).data).decode(), opened("closed").decode()
    assert np.abs((a.V - [1e4, -30, 7]) / 250 - b.V).max() < 0.02


def test_latents_in_the_order_of_their_gain_save_no_less_at_first():
    by_size = opened("closed", CompressSettings(SMALL.lod, model=PAPER, order="magnitude"))
    by_gain = opened("closed", SMALL_PAPER)
    assert worse(by_gain.decode(40), SHAPES["closed"]) < 1.03 * worse(by_size.decode(40), SHAPES["closed"])


@pytest.mark.parametrize("settings", BOTH.values(), ids=BOTH)
def test_progress_grows_and_cancelling_ends_the_work(settings):
    seen = []

    def progress(fraction, message):
        assert 0 <= fraction <= 1 and message
        seen.append(fraction)
        if fraction > 0.5:
            raise Cancelled("Cancelled by the user")

    with pytest.raises(Cancelled):
        compress(SHAPES["closed"], settings, progress)
    assert all(a <= b + 1e-9 for a, b in zip(seen, seen[1:], strict=False))


BAD = {
    "one triangle": (np.eye(3), [[0, 1, 2]], "faces"),
    "no faces": (np.eye(3), np.zeros((0, 3), int), "found none"),
    "nan": (np.full((3, 3), np.nan), [[0, 1, 2]], "NaN"),
    "index": (np.eye(3), [[0, 1, 7]], "indices"),
    "quads": (np.zeros((4, 3)), [[0, 1, 2, 3]], "triangulate"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_meshes_by_name(name):
    V, F, message = BAD[name]
    with pytest.raises(MeshError, match=message):
        compress(TriMesh.from_arrays(np.asarray(V, float), np.asarray(F)), SMALL, silent)


def test_settings_out_of_range():
    for make in (lambda: LodSettings(base_faces=2), lambda: LodSettings(levels=7), lambda: LodSettings(clean="maybe"),
                 lambda: CompressSettings(position_bits=3), lambda: CompressSettings(order="random"),
                 lambda: LodSettings(levels=True), lambda: CompressSettings(model="other"),
                 lambda: CompressSettings(budget=True)):
        with pytest.raises(SettingsError, match="Expected"):
            make()
