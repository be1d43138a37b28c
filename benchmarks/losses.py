"""The paragraph that says where we lose, from the measured rows."""

import numpy as np

from .methods import REFERENCE, REFERENCE_SCALARS
from .methods.case import BUDGETS, FEATURES
from .results import Results
from .tables import MODEL, OURS, SIZED, kilo

LEAST_SHARE = 0.25  # of the meshes, that a method must have to be named


def percent(part: int, total: int) -> str:
    """A share of meshes."""
    return f"{100 * part / max(total, 1):.0f} %"


def losses_in_bytes(results: Results) -> str:
    """Where other methods are better at equal bytes."""
    parts, better = [], []
    for budget in BUDGETS:
        both, found = results.pairs(OURS, REFERENCE, "bytes", budget)
        if not both:
            continue
        ratio, n = results.ratio(OURS, REFERENCE, "bytes", budget)
        normals = results.wins(OURS, REFERENCE, "bytes", budget, "d_normal")[1]
        lost = results.wins(OURS, REFERENCE, "bytes", budget)[1]
        parts.append(f"{kilo(budget)} {percent(lost, n)} and {percent(normals, n)} (our error is {ratio:.2f} of its)")
        ahead = []
        for method, name in results.names.items():
            other, m = results.ratio(OURS, method, "bytes", budget)
            if method not in (OURS, SIZED, REFERENCE) and m >= n * LEAST_SHARE and other > 1:
                ahead.append(f"{name} ({other:.2f}{f', {m} meshes' if m < n else ''})")
        if ahead:
            better.append(f"{kilo(budget)}: {', '.join(ahead)}")
    text = (
        "At equal bytes QSlim + Draco has the smaller error the worse way, or the better normals, on this share of the "
        f"meshes: {'; '.join(parts)}."
    )
    if better:
        text += f" Others that are nearer on the geometric mean, with our error over theirs: {'; '.join(better)}."
    return text + sized(results)


def sized(results: Results) -> str:
    """How a file that is made for its size compares, as one sentence, '' if that was not measured."""
    parts = []
    for budget in BUDGETS:
        ratio, n = results.ratio(SIZED, REFERENCE, "bytes", budget)
        cut, both = results.ratio(SIZED, OURS, "bytes", budget)
        if n:
            lost = results.wins(SIZED, REFERENCE, "bytes", budget)[1]
            beside = f", {cut:.2f} of the cut stream's" if both else ""
            parts.append(f"{kilo(budget)} {ratio:.2f} of QSlim + Draco's{beside}, farther on {percent(lost, n)} of {n}")
    return f" A file made for its size (`--bytes`) has an error of: {'; '.join(parts)} meshes." if parts else ""


def losses_in_numbers(results: Results) -> str:
    """Where QSlim is better with the same count of numbers: by latents, and the meshes where it is so most."""
    parts = []
    for method in (OURS, MODEL):
        shares = [f"{k} latents {share}" for k in FEATURES if (share := _share(results, method, k))]
        if shares:
            parts.append(f"than {results.names[method]} {'; '.join(shares)}")
    if not parts:
        return ""
    both, first = results.pairs(MODEL, REFERENCE_SCALARS, "scalars", 0, "d_pm")
    share = first[:, 0] / np.maximum(first[:, 1], 1e-9)
    worst = [i for i in np.argsort(-share)[:4] if share[i] > 1]
    named = ", ".join(f"{both[i].split('/')[-1]} ({first[i, 0]:.1f} against {first[i, 1]:.1f})" for i in worst)
    where = f" Without latents the paper's model compares worst with QSlim on {named}." if named else ""
    return (
        "QSlim with as many numbers as the paper's model has with so many latents (0: 400 faces) is better, in d_pm and in "
        f"normals, on this share of the meshes: {', and '.join(parts)}.{where}"
    )


def _share(results: Results, method: str, latents: int) -> str:
    """On what share of the meshes QSlim is better in d_pm and in normals; '' where none has both."""
    count = len(results.pairs(method, REFERENCE_SCALARS, "scalars", latents, "d_pm")[0])
    lost = (results.wins(method, REFERENCE_SCALARS, "scalars", latents, key)[1] for key in ("d_pm", "d_normal"))
    return " and ".join(percent(n, count) for n in lost) if count else ""


def losses_in_time(results: Results) -> str:
    """What we take longer for."""
    stages = [line.get("stages") for line in results.about.get(OURS, {}).values()]
    total = [sum(s.values()) for s in stages if s]
    peer = [line["seconds"] for line in results.about.get(REFERENCE, {}).values()]
    if not peer or not total:
        return ""
    return (
        f"Compressing takes us {np.median(total):.0f} s a mesh (median, one core); QSlim + Draco with the search for the best "
        f"setting of six budgets, and measuring, takes {np.median(peer):.0f} s."
    )


def paragraph(results: Results) -> str:
    """The paragraph at the top of the page."""
    if OURS not in results.rows:
        return "Our own codec was not measured in this run."
    parts = []
    if REFERENCE in results.rows:
        parts.append(losses_in_bytes(results))
    if REFERENCE_SCALARS in results.rows:
        parts.append(losses_in_numbers(results))
    return " ".join(["**Where we lose.**", *parts, losses_in_time(results)]).strip()
