"""The plots of the report."""

from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from .methods import REFERENCE, REFERENCE_SCALARS
from .methods.case import BUDGETS, CURVE
from .results import FLOOR, MEASURES, Results
from .tables import OURS, geometric, kilo

DPI = 80
STYLE = {OURS: {"color": "black", "lw": 2.5}, REFERENCE: {"color": "tab:red", "lw": 2}}


def write(results: Results, folder: Path) -> list[str]:
    """Draw all plots into a folder; their file names."""
    made = {"bytes_ratio.png": bytes_ratio, "bytes.png": bytes_curve, "cr.png": cr_curve, "meshes.png": per_mesh}
    for name, draw in made.items():
        figure = draw(results)
        figure.tight_layout()
        figure.savefig(folder / name, dpi=DPI, metadata={"Software": None})
        plt.close(figure)
    return list(made)


def _lines(axes, results: Results, points: tuple, at: list[float], figure_of) -> None:
    """One line a method through figure_of(method, point) -> (value, meshes)."""
    for i, (method, name) in enumerate(results.names.items()):
        found = [figure_of(method, p) for p in points]
        on = [k for k, (_, n) in enumerate(found) if n]
        if on:
            style = {"color": f"C{i % 10}", "lw": 1.2} | STYLE.get(method, {})
            axes.plot([at[k] for k in on], [found[k][0] for k in on], marker="o", ms=3, label=name, **style)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.grid(True, which="both", alpha=0.2)


def _legend(axes) -> None:
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize=8)


def _in_kilobytes(axes) -> None:
    axes.set_xticks(BUDGETS, [kilo(b) for b in BUDGETS])
    axes.minorticks_off()


def _axes_of_measures():
    """A figure with a plot for each of MEASURES, two rows; the places that are left over stay empty."""
    columns = -(-len(MEASURES) // 2)
    figure, places = plt.subplots(2, columns, figsize=(6 * columns, 9))
    for axes in places.flat[len(MEASURES) :]:
        axes.set_axis_off()
    return figure, list(places.flat[: len(MEASURES)])


def bytes_ratio(results: Results):
    """Every measure over the reference's at each budget, geometric means."""
    figure, all_axes = _axes_of_measures()
    for axes, (key, title) in zip(all_axes, MEASURES.items(), strict=True):
        _lines(axes, results, BUDGETS, list(BUDGETS), lambda m, b, k=key: results.ratio(m, REFERENCE, "bytes", b, k))
        axes.set_title(f"{title} over QSlim + Draco's (below 1 is better)")
        _in_kilobytes(axes)
    _legend(all_axes[0])
    return figure


def bytes_curve(results: Results):
    """The reference's geometric mean, and every method at its ratio to it."""
    figure, all_axes = _axes_of_measures()
    for axes, (key, title) in zip(all_axes, MEASURES.items(), strict=True):

        def mean(method: str, budget: int, key=key) -> tuple[float, int]:
            ratio, n = results.ratio(method, REFERENCE, "bytes", budget, key)
            return ratio * geometric(list(results.values(REFERENCE, "bytes", budget, key).values())), n

        _lines(axes, results, BUDGETS, list(BUDGETS), mean)
        axes.set_title(f"{title}, " + ("degrees" if key == "d_normal" else "1e-4 of the longest side"))
        _in_kilobytes(axes)
    _legend(all_axes[0])
    return figure


def cr_curve(results: Results):
    """d_pm against the paper's compression ratio."""
    results = results.only(lambda row: row.get("cr", 2) > 1)
    figure, axes = plt.subplots(figsize=(8, 6))
    cr = [list(results.values(REFERENCE_SCALARS, "scalars", k, "cr").values()) for k in CURVE]

    def mean(method: str, k: int) -> tuple[float, int]:
        ratio, n = results.ratio(method, REFERENCE_SCALARS, "scalars", k, "d_pm")
        return ratio * geometric(list(results.values(REFERENCE_SCALARS, "scalars", k, "d_pm").values())), n

    _lines(axes, results, CURVE, [float(np.median(x)) if x else 1.0 for x in cr], mean)
    axes.invert_xaxis()
    axes.set_xlabel("compression ratio, median of the meshes (numbers of the input over numbers sent)")
    axes.set_ylabel("d_pm, 1e-4 of the longest side, geometric mean")
    _legend(axes)
    return figure


def per_mesh(results: Results):
    """Ours over the reference by mesh, sorted, a line for each budget."""
    figure, axes = plt.subplots(figsize=(8, 5))
    for i, budget in enumerate(BUDGETS):
        _, found = results.pairs(OURS, REFERENCE, "bytes", budget)
        found = np.maximum(found, FLOOR)
        ratio = np.sort(found[:, 0] / found[:, 1])
        if len(ratio):
            axes.plot(np.linspace(0, 100, len(ratio)), ratio, color=plt.cm.viridis(i / len(BUDGETS)), label=kilo(budget))
    axes.axhline(1, color="tab:red", lw=1)
    axes.set_yscale("log")
    axes.set_xlabel("meshes, %")
    axes.set_ylabel("our error over QSlim + Draco's, the worse way")
    axes.grid(True, which="both", alpha=0.2)
    _legend(axes)
    return figure
