"""A stream that was read, kept as bytes: the same again, without compiled code; damage is named."""
import subprocess
import sys
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from npm_blender.core.bitstream.base_positions import quantize_positions
from npm_blender.core.bitstream.connectivity import canonical_order
from npm_blender.core.bitstream.container import read_stream, write_stream
from npm_blender.core.codec.progressive_mesh import open_stream
from npm_blender.core.codec.stored_stream import StoredStream, pack, receive, unpack
from npm_blender.core.errors import StreamError
from npm_blender.core.network import weights
from tests.core.bitstream.test_container import HEADER
from tests.meshes.base_meshes import some_features, sphere

ROOT = Path(__file__).resolve().parents[3]


def make_stream() -> bytes:
    """100 features on three levels of a small sphere, with the weights that ship."""
    V, F = sphere(3)
    order = canonical_order(F, len(V))
    ints, _ = quantize_positions(V[order.vertices], 12)
    level, face, value = some_features(len(F), 3, 100, np.random.default_rng(0))
    model = weights.load_weights()
    header = replace(HEADER, model_id=model.model_id, weights_hash=model.digest, total_features=len(level))
    return write_stream(header, ints, order.F, level, face, value)


DATA = make_stream()
READ = read_stream(DATA)


@pytest.mark.parametrize("end", [len(DATA), READ.base_bytes, (READ.base_bytes + len(DATA)) // 2])
def test_a_read_stream_comes_back_exactly(end):
    read = read_stream(DATA[:end])
    again = unpack(pack(read))
    for field in fields(read):
        mine, theirs = getattr(again, field.name), getattr(read, field.name)
        if isinstance(theirs, np.ndarray):
            assert mine.dtype == theirs.dtype and np.array_equal(mine, theirs), field.name
        elif field.name == "packet_ends":
            assert all(np.array_equal(a, b) and a.dtype == b.dtype for a, b in zip(mine, theirs))
        else:
            assert mine == theirs, field.name


def test_opens_to_the_same_mesh_as_the_stream():
    opened, direct = receive(DATA).open(), open_stream(DATA)
    assert (opened.total_bytes, opened.features) == (len(DATA), direct.features)
    for features, level in ((0, 0), (40, 2), (100, 3)):
        assert np.array_equal(opened.decode_positions(features, level), direct.decode_positions(features, level))


def test_the_receivers_way_loads_no_numba_and_no_torch(tmp_path):
    received = receive(DATA)
    (tmp_path / "data").write_bytes(received.data)
    (tmp_path / "arrays").write_bytes(received.arrays)
    code = ("import sys; sys.path.insert(0, sys.argv[1]); from pathlib import Path; "
            "from npm_blender.core.codec.stored_stream import StoredStream; "
            "mesh = StoredStream(*(Path(p).read_bytes() for p in ('data', 'arrays'))).open().decode(); "
            "sys.exit(any(m in sys.modules for m in ('numba', 'torch', 'trimesh')) or len(mesh.F) == 0)")
    assert subprocess.run([sys.executable, "-c", code, str(ROOT)], cwd=tmp_path).returncode == 0


def test_every_damaged_byte_is_named_or_harmless():
    good = receive(DATA)
    for at in range(0, len(good.arrays), 11):
        bad = good.arrays[:at] + bytes([good.arrays[at] ^ 0x55]) + good.arrays[at + 1:]
        try:
            StoredStream(DATA, bad).open().decode(0, 0)
        except StreamError as error:
            assert "open the file again" in str(error) and "\n" not in str(error)


@pytest.mark.parametrize("end", [0, 10, 400])
def test_cut_arrays_are_refused(end):
    with pytest.raises(StreamError, match="damaged arrays"):
        unpack(receive(DATA).arrays[:end])


DAMAGE = {
    "a vertex that is not there": {"F0": READ.F0 + 1},
    "a face that is not there": {"face": READ.face + 64 * len(READ.F0)},
    "a level that is not there": {"group": READ.group + 3},
    "features of another size": {"value": READ.value[:, :5]},
    "fewer values than faces": {"value": READ.value[1:]},
    "no faces": {"F0": READ.F0[:0]},
    "packets that end elsewhere": {"packet_ends": (READ.packet_ends[0] + 1, READ.packet_ends[1])},
}


@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE.keys())
def test_arrays_that_do_not_fit_together_are_refused(damage):
    with pytest.raises(StreamError, match="do not fit together"):
        unpack(pack(replace(READ, **damage)))
