"""The examples run, write meshes and pictures, and stay short enough to be read at one go."""
import ast

import numpy as np
import pytest

from examples import shapes
from examples.gallery import EXAMPLES, gallery
from npm_blender.core import open_stream, read_mesh
from tests.few_points import compare_by_few_points

MOST_LINES = 39


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The folder in which all examples have run, once, in this process, on a mesh of a quarter of the faces."""
    out, whole = tmp_path_factory.mktemp("examples"), shapes.bumpy_torus
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shapes, "bumpy_torus", lambda *size: whole(*(size or (56, 22))))
        compare_by_few_points(patch)
        gallery(out)
    return out


def test_each_stage_has_an_example_in_order():
    assert [int(path.name[:2]) for path in EXAMPLES] == list(range(9))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda p: p.stem)
def test_an_example_is_short_and_says_where_its_stage_lives(example):
    text = example.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= MOST_LINES
    assert "npm_blender/core/" in ast.get_docstring(ast.parse(text))
    assert "argparse" not in text


@pytest.mark.slow
@pytest.mark.parametrize("example", EXAMPLES, ids=lambda p: p.stem)
def test_an_example_writes_a_mesh_and_a_picture(made, example):
    number = example.name[:2]
    meshes, pictures = list(made.glob(f"{number}_*.ply")), list(made.glob(f"{number}_*.png"))
    assert meshes and pictures
    for path in meshes:
        mesh = read_mesh(path)
        assert len(mesh.F) >= 100 and np.ptp(mesh.V, axis=0).max() == pytest.approx(1, abs=0.1)
    for path in pictures:
        assert path.read_bytes().startswith(b"\x89PNG") and path.stat().st_size > 5_000


@pytest.mark.slow
def test_the_stream_of_the_first_example_opens(made):
    assert open_stream((made / "00_torus.npmesh").read_bytes()).decode(level=0).F.shape == (200, 3)


@pytest.mark.slow
def test_the_page_shows_every_example_with_its_picture(made):
    page = (made / "index.html").read_text(encoding="utf-8")
    for example in EXAMPLES:
        assert f"<h2>{example.stem.replace('_', ' ')}</h2>" in page
    for picture in made.glob("*.png"):
        assert f'src="{picture.name}"' in page
