"""A stream that was read, kept as bytes: the same again, without compiled code; damage is named."""
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from npm_blender.core.bitstream import read_stream
from npm_blender.core.codec import StoredStream, open_stream, receive
from npm_blender.core.codec.stored_stream import pack, unpack
from npm_blender.core.errors import StreamError
from tests.core.bitstream.samples import creased_sample, displaced_sample, ladder_sample
from tests.core.codec.streams import known_latents

ROOT = Path(__file__).resolve().parents[3]
DATA = {"displaced": displaced_sample().data, "creased": creased_sample(levels=1, stages=2).data, "ladder": ladder_sample().data,
        "latents": known_latents().data}
READ = {kind: read_stream(data) for kind, data in DATA.items()}
ALL = pytest.mark.parametrize("kind", DATA)


def same(a, b) -> bool:
    """Whether two arrays, or tuples of them, or anything else are equal, types included."""
    if isinstance(a, tuple):
        return all(map(same, a, b))
    return a.dtype == b.dtype and np.array_equal(a, b) if isinstance(a, np.ndarray) else a == b


@ALL
@pytest.mark.parametrize("share", [0, 0.4, 0.99, 1])
def test_a_read_stream_comes_back_exactly(kind, share):
    start = READ[kind].base_bytes
    read = read_stream(DATA[kind][:round(start + share * (len(DATA[kind]) - start))])
    again = unpack(pack(read))
    assert len(read.rungs) == len(again.rungs)
    for one, other in zip(read.rungs, again.rungs, strict=True):
        assert all(same(getattr(one, name), getattr(other, name)) for name in vars(one) if name not in ("details", "finer"))
        assert type(other.details) is type(one.details)
        assert all(same(value, getattr(other.details, name)) for name, value in vars(one.details).items())


@ALL
def test_opens_to_the_same_mesh_as_the_stream(kind):
    opened, direct = receive(DATA[kind]).open(), open_stream(DATA[kind])
    assert (opened.total_bytes, opened.features, opened.stops) == (len(DATA[kind]), direct.features, direct.stops)
    for features, level in ((0, 0), (40, direct.levels), (direct.features, direct.levels)):
        assert np.array_equal(opened.decode_positions(features, level), direct.decode_positions(features, level))


@ALL
def test_the_receivers_way_loads_no_numba_and_no_torch(tmp_path, kind):
    received = receive(DATA[kind])
    (tmp_path / "data").write_bytes(received.data)
    (tmp_path / "arrays").write_bytes(received.arrays)
    code = ("import sys; sys.path.insert(0, sys.argv[1]); from pathlib import Path; "
            "from npm_blender.core.codec.stored_stream import StoredStream; "
            "mesh = StoredStream(*(Path(p).read_bytes() for p in ('data', 'arrays'))).open().decode(); "
            "sys.exit(any(m in sys.modules for m in ('numba', 'torch', 'trimesh', 'scipy')) or len(mesh.F) == 0)")
    assert subprocess.run([sys.executable, "-c", code, str(ROOT)], cwd=tmp_path).returncode == 0


@ALL
def test_every_damaged_byte_is_named_or_harmless(kind):
    good = receive(DATA[kind])
    for at in range(0, len(good.arrays), 13):
        bad = good.arrays[:at] + bytes([good.arrays[at] ^ 0x55]) + good.arrays[at + 1:]
        try:
            opened = StoredStream(DATA[kind], bad).open()
            opened.decode(0, 0), opened.decode()
        except StreamError as error:
            assert "open the file again" in str(error) and "\n" not in str(error)


@ALL
@pytest.mark.parametrize("end", [0, 10, 400])
def test_cut_arrays_are_refused(kind, end):
    with pytest.raises(StreamError, match="damaged arrays"):
        unpack(receive(DATA[kind]).arrays[:end])


def details(kind, **changes):
    return {"details": replace(READ[kind].details, **changes)}


LATENTS, NUMBERS = READ["latents"].details, READ["displaced"].details
SHARP, LADDER = READ["creased"].sharp, READ["ladder"]
DAMAGE = {
    "a vertex that is not there": ("displaced", {"F0": READ["displaced"].F0 + 1}),
    "no faces": ("displaced", {"F0": READ["displaced"].F0[:0]}),
    "a base that ends elsewhere": ("displaced", {"base_bytes": READ["displaced"].base_bytes + 1}),
    "numbers of another size": ("displaced", details("displaced", table=NUMBERS.table[:, 1:])),
    "fewer stages": ("displaced", details("displaced", table=NUMBERS.table[1:])),
    "fewer levels": ("displaced", details("displaced", coded=NUMBERS.coded[:, 1:])),
    "numbers that were not sent": ("displaced", details("displaced", coded=NUMBERS.coded & False)),
    "creases of another base": ("creased", {"sharp": SHARP._replace(edges=SHARP.edges[1:])}),
    "corners of another base": ("creased", {"sharp": SHARP._replace(corners=SHARP.corners[1:])}),
    "a later rung without faces": ("ladder", {"finer": replace(LADDER.finer, F0=LADDER.finer.F0[:0])}),
    "a later rung that ends elsewhere": ("ladder", {"finer": replace(LADDER.finer, base_bytes=1)}),
    "numbers of another rung": ("ladder", {"finer": replace(LADDER.finer, details=LADDER.details)}),
    "a face that is not there": ("latents", details("latents", face=LATENTS.face + 64 * 10_000)),
    "a level that is not there": ("latents", details("latents", level=LATENTS.level + 3)),
    "features of another size": ("latents", details("latents", value=LATENTS.value[:, :5])),
    "fewer values than faces": ("latents", details("latents", value=LATENTS.value[1:])),
}


@pytest.mark.parametrize(("kind", "changes"), DAMAGE.values(), ids=DAMAGE.keys())
def test_arrays_that_do_not_fit_together_are_refused(kind, changes):
    with pytest.raises(StreamError, match="do not fit together"):
        unpack(pack(replace(READ[kind], **changes)))
