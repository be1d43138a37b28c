"""Enabling and disabling: everything comes, everything goes, nothing heavy is loaded."""
import subprocess
import sys
import tomllib
from pathlib import Path

import addon_utils
import bpy

from .source_addon import ROOT, enable

OPERATORS = ("object.npmesh_compress", "object.npmesh_preview", "object.npmesh_apply", "object.npmesh_discard",
             "object.npmesh_cancel", "object.npmesh_stop", "object.npmesh_play", "object.npmesh_stop_playing",
             "object.npmesh_lod_set", "object.npmesh_link", "object.npmesh_pack", "object.npmesh_reload",
             "export_scene.npmesh", "export_scene.npmesh_gltf", "import_scene.npmesh")


def registered(name: str) -> bool:
    group, _, operator = name.partition(".")
    return operator in dir(getattr(bpy.ops, group))


def test_disabling_takes_everything_away_and_enabling_brings_it_back(package, opened):
    handlers = len(bpy.app.handlers.undo_post)
    features = opened.npmesh.features
    addon_utils.disable(package)
    try:
        assert not any(registered(name) for name in OPERATORS)
        assert not hasattr(bpy.types.Object, "npmesh") and not hasattr(bpy.types, "IO_FH_npmesh")
        assert len(bpy.app.handlers.undo_post) == handlers - 1
    finally:
        addon_utils.enable(package, default_set=True)
    assert all(registered(name) for name in OPERATORS)
    assert opened.npmesh.is_preview and opened.npmesh.features == features
    opened.npmesh.features = 3
    assert opened.data["npmesh_shown"].endswith(":3")


def test_disabling_ends_a_running_job(package, part):
    from .conftest import add_object
    from .test_compress import leftovers, start_job

    job = start_job(part, add_object(subdivisions=6))
    addon_utils.disable(package)
    try:
        assert job._process.poll() is not None and not leftovers()
    finally:
        addon_utils.enable(package, default_set=True)


def in_a_fresh_blender(code: str) -> str:
    """What `code` prints in another process that has bpy and knows where the package is."""
    code = f"import sys, bpy; sys.path.insert(0, sys.argv[-1])\n{code}"
    if bpy.app.binary_path:
        command = [bpy.app.binary_path, "-b", "--factory-startup", "--python-expr", code, "--", str(ROOT)]
    else:
        command = [sys.executable, "-c", code, str(ROOT)]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def test_registering_loads_nothing_heavy():
    said = in_a_fresh_blender("before = set(sys.modules); import npm_blender; npm_blender.register(); "
                              "npm_blender.unregister(); "
                              "print(sorted({'numpy', 'numba'} & (set(sys.modules) - before)))")
    assert "[]" in said.splitlines()


def test_registering_adds_little_to_blenders_start():
    """Counted in calls, which are the same on every machine: 17,000."""
    code = """
for attempt in range(2):  # the second one finds the standard library loaded
    calls = 0
    def count(frame, event, argument):
        global calls
        calls += event in ("call", "c_call")
    sys.setprofile(count)
    import npm_blender
    npm_blender.register()
    sys.setprofile(None)
    npm_blender.unregister()
    for name in [name for name in sys.modules if name.startswith("npm_blender")]:
        del sys.modules[name]
print("calls", calls)
"""
    calls = next(int(line.split()[1]) for line in in_a_fresh_blender(code).splitlines() if line.startswith("calls"))
    assert calls < 25_000


def test_importing_the_package_needs_no_bpy():
    code = ("import sys; sys.path.insert(0, sys.argv[-1]); import npm_blender, npm_blender.jobs.worker; "
            "sys.exit('bpy' in sys.modules)")
    assert subprocess.run([sys.executable, "-c", code, str(ROOT)]).returncode == 0


def test_the_manifest_names_what_blender_requires():
    manifest = tomllib.loads(Path(ROOT, "npm_blender", "blender_manifest.toml").read_text())
    assert manifest["id"] == "npm_blender" and manifest["license"] == ["SPDX:GPL-3.0-or-later"]
    assert len(manifest["tagline"]) <= 64 and manifest["tagline"][-1].isalnum()
    assert all(len(reason) <= 64 and reason[-1].isalnum() for reason in manifest["permissions"].values())


def test_every_property_has_a_tooltip_in_blenders_style():
    for cls in (bpy.types.Object.bl_rna.properties["npmesh"].fixed_type, bpy.ops.object.npmesh_compress.get_rna_type(),
                bpy.ops.export_scene.npmesh.get_rna_type()):
        for prop in cls.properties:
            if prop.identifier in ("rna_type", "name", "is_preview", "meshes") or prop.is_hidden:
                continue
            assert prop.description and not prop.description.endswith("."), prop.identifier


def test_the_command_is_registered_and_answers(package, part, capsys):
    assert part("registration").run_command(["--help"]) == 0
    assert "npmesh" in capsys.readouterr().out
    assert part("registration").run_command(["--version"]) == 0
    assert capsys.readouterr().out == f"npmesh {sys.modules[package].__version__}\n"


def test_enabling_twice_is_harmless(package):
    assert addon_utils.enable(package, default_set=True) is not None
    assert enable.__module__.endswith("source_addon")
