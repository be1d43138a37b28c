"""docs/manual.md says what is so: its script runs, its table has the presets' numbers, its pictures are there and small."""
import re

import bpy
import pytest

from .conftest import add_object
from .source_addon import ROOT

MANUAL = (ROOT / "docs" / "manual.md").read_text(encoding="utf-8")
MAX_BYTES = 200_000


def test_the_script_for_batches_runs(tmp_path):
    for k, name in enumerate(("A", "B")):
        add_object(name, subdivisions=4).location.x = 3 * k
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    code, = re.findall(r"```python\n(.*?)```", MANUAL, re.DOTALL)
    assert 'preset="STANDARD"' in code
    exec(code.replace('preset="STANDARD"', 'preset="DRAFT", base_faces=80, levels=1'), {})
    assert sorted(path.name for path in tmp_path.glob("*.npmesh")) == ["A.npmesh", "B.npmesh"]
    assert not any(obj.npmesh.is_preview for obj in bpy.data.objects)


def test_the_table_has_the_numbers_of_the_presets(part):
    for label, _, numbers in part("properties.compression").PRESETS.values():
        row, = (line for line in MANUAL.splitlines() if line.startswith(f"| {label} |"))
        model = {"displaced": "displaced surface", "paper": "the paper's"}[numbers["model"]]
        cells = [cell.strip() for cell in row.strip("|").split("|")][2:]
        assert cells == [model, *(str(numbers[name] or "automatic") for name in ("base_faces", "levels"))]


@pytest.mark.parametrize("name", sorted(set(re.findall(r"\]\((images/[^)]+)\)", MANUAL))))
def test_pictures_are_there_and_small(name):
    assert 0 < (ROOT / "docs" / name).stat().st_size <= MAX_BYTES


def test_the_commands_are_ones_that_exist(part, capsys):
    for verb in ("compress", "decompress", "info", "evaluate"):
        assert f"npmesh {verb}" in MANUAL or f"npm_blender {verb}" in MANUAL
        assert part("registration").run_command([verb, "--help"]) == 0
        usage = capsys.readouterr().out
        for line in MANUAL.splitlines():
            if re.match(rf"    .*(npmesh|npm_blender) {verb} ", line):
                assert all(option in usage for option in re.findall(r" (--[a-z-]+)", line.partition(verb)[2])), line
