"""Every operator, property and choice of the extension has a tooltip in Blender's style: said, and without a full stop."""
import importlib
import pkgutil

import bpy
import pytest

# declared by Blender's own mix-ins, or the same for every class
FOREIGN = {"rna_type", "name", "bl_idname", "bl_label", "check_existing"}


@pytest.fixture
def classes(package):
    """All classes that the extension registers, found in its modules and not in a list."""
    root = importlib.import_module(package)
    found = {}
    for info in pkgutil.walk_packages(root.__path__, f"{package}."):
        if info.name.split(".")[3] in ("operators", "panels", "properties", "preferences"):
            for cls in getattr(importlib.import_module(info.name), "CLASSES", ()):
                found[cls.__name__] = cls
    assert len(found) > 10 and all(cls.is_registered for cls in found.values())
    return list(found.values())


def complaint(text: str) -> str:
    """What is wrong with a tooltip; empty if nothing is."""
    text = text or ""
    if not text.strip():
        return "has none"
    if text != text.strip() or "\n" in text:
        return f"has space at its ends or lines: {text!r}"
    if text.endswith((".", "!")):
        return f"ends with a full stop: {text!r}"
    return "" if text[0].isupper() else f"starts small: {text!r}"


def test_operators_have_tooltips(classes):
    operators = [cls for cls in classes if issubclass(cls, bpy.types.Operator)]
    wrong = {}
    for cls in operators:
        group, _, name = cls.bl_idname.partition(".")
        wrong[cls.__name__] = complaint(getattr(getattr(bpy.ops, group), name).get_rna_type().description)
    assert operators and not {k: v for k, v in wrong.items() if v}


def test_properties_and_their_choices_have_tooltips(classes):
    wrong = []
    for cls in classes:
        for name in {name for base in cls.__mro__ for name in getattr(base, "__annotations__", {})} - FOREIGN:
            prop = cls.bl_rna.properties.get(name)
            if prop is None:
                continue
            texts = {f"{cls.__name__}.{name}": prop.description}
            if prop.type == "ENUM":
                texts |= {f"{cls.__name__}.{name} {item.identifier}": item.description for item in prop.enum_items}
            wrong += [f"{where} {said}" for where, text in texts.items() if (said := complaint(text))]
    assert not wrong, "\n".join(sorted(wrong))


def test_the_check_finds_what_it_looks_for():
    assert [bool(complaint(text)) for text in ("", "Ends.", "two\nlines", " Space", "lower", "As Blender wants it")] == [
        True, True, True, True, True, False]
