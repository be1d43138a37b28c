"""The Markdown tables of the report."""

import numpy as np

from corpus.meshes import Entry

from .methods import REFERENCE, REFERENCE_SCALARS
from .methods.case import BASE_FACES, BUDGETS, CURVE, FEATURES
from .results import MEASURES, Results

OURS, SIZED, MODEL = "ours", "ours_sized", "ours_paper"  # one stream; one for each size; the paper's model
LARGE = 20_000  # faces
# d_pm x 1e-4 and d_normal as the paper prints them (its table 1, 100 meshes of Thingi10K, which are not ours)
PAPER = {
    "qslim": (30.11, 13.21),
    "loop": (68.47, 14.98),
    "butterfly": (40.55, 16.99),
    "subdivfit": (27.33, 15.41),
    "neural_subdivision": (19.03, 11.21),
    "ours_paper": (4.12, 7.19),
}
PAPER_FEATURES = {0: (14.56, 12.36), 40: (6.81, 9.20), 400: (4.12, 7.19)}
PAPER_LEVELS = {1: (12.47, 11.23), 2: (4.36, 8.66), 3: (4.12, 7.19)}
# networks fitted to one mesh, as the paper quotes them: d_pm, d_normal, ratio of file sizes
QUOTED = {"NCS": (2.52, 4.73, 1.15), "ACORN": (2.80, 10.15, 1.15), "NGLOD": (2.91, 8.79, 1.15)}
NONE = "-"


def markdown(header: list[str], rows: list[list[str]]) -> list[str]:
    """Lines of a table."""
    lines = [header, ["---"] * len(header), *rows]
    return ["| " + " | ".join(cells) + " |" for cells in lines]


def kilo(budget: int) -> str:
    """A budget in kB of 1,000 bytes."""
    return f"{budget / 1000:g} kB"


def byte_ratios(results: Results, key: str) -> list[str]:
    """Methods by budgets: geometric mean of the ratio to the reference, and of how many meshes where not of all."""
    rows = []
    for method, name in results.names.items():
        if method == REFERENCE or not any(results.values(method, "bytes", b) for b in BUDGETS):
            continue
        cells = []
        for budget in BUDGETS:
            ratio, n = results.ratio(method, REFERENCE, "bytes", budget, key)
            few = f" ({n})" if n < len(results.values(REFERENCE, "bytes", budget)) else ""
            cells.append(f"{ratio:.3f}{few}" if n else NONE)
        rows.append([name, *cells])
    base = [results.values(REFERENCE, "bytes", b, key) for b in BUDGETS]
    cells = [f"{geometric(list(v.values())):.3g} ({len(v)})" if v else NONE for v in base]
    rows.append([f"{results.names.get(REFERENCE, REFERENCE)} itself (meshes)", *cells])
    return markdown([f"{MEASURES[key]}, ratio", *map(kilo, BUDGETS)], rows)


def by_kind(results: Results, entries: list[Entry]) -> list[str]:
    """Ours over the reference by the worse way: by kind of mesh, where the corpus has kinds, and for meshes of many faces."""
    groups: dict[str, set[str]] = {}
    for entry in entries:
        groups.setdefault(entry.kind, set()).add(entry.name)
    groups.pop("", None)
    groups[f"at least {LARGE:,} faces"] = {entry.name for entry in entries if entry.faces >= LARGE}
    rows = []
    for group, names in groups.items():
        some = results.of_meshes(names)
        found = [some.ratio(OURS, REFERENCE, "bytes", budget) for budget in BUDGETS]
        if any(n for _, n in found):
            rows.append([f"{group} ({len(some.meshes)})", *(f"{ratio:.3f}" if n else NONE for ratio, n in found)])
    return markdown(["ours, worse way, ratio, by kind (meshes)", *map(kilo, BUDGETS)], rows)


def wins(results: Results) -> list[str]:
    """Ours against every method: meshes won and lost by the worse way at each budget."""
    rows = []
    for method, name in results.names.items():
        cells = []
        for budget in BUDGETS:
            both, _ = results.pairs(OURS, method, "bytes", budget)
            won, lost = results.wins(OURS, method, "bytes", budget)
            cells.append(f"{won} : {lost}" if both else NONE)
        if method != OURS and any(cell != NONE for cell in cells):
            rows.append([name, *cells])
    return markdown(["ours won : lost against", *map(kilo, BUDGETS)], rows)


def geometric(values: list[float]) -> float:
    """Geometric mean; nan of nothing."""
    return float(np.exp(np.log(np.maximum(values, 1e-3)).mean())) if len(values) else float("nan")


def equal_cr(results: Results) -> list[str]:
    """Table 1: every method with as many numbers as the paper's model with 0, 40, 400 latents; means like the paper's."""
    rows = []
    for method, name in results.names.items():
        cells = []
        for k in FEATURES:
            for key in ("d_pm", "d_normal"):
                both, found = results.pairs(method, REFERENCE_SCALARS, "scalars", k, key)
                if not both:
                    cells.append(NONE)
                    continue
                mean = found.mean(0)
                few = f", {len(both)} meshes" if len(both) < len(results.values(REFERENCE_SCALARS, "scalars", k)) else ""
                share = f" ({mean[0] / max(mean[1], 1e-9):.2f}{few})" if key == "d_pm" else ""
                cells.append(f"{mean[0]:.2f}{share}")
        quoted = "{:.2f} / {:.2f}".format(*PAPER[method]) if method in PAPER else ""
        if any(cell != NONE for cell in cells):
            rows.append([name, *cells, quoted])
    for name, (d_pm, d_normal, cr) in QUOTED.items():
        rows.append([name, *[""] * 6, f"{d_pm:.2f} / {d_normal:.2f}, one mesh, file size over {cr}"])
    header = ["method"]
    for k in FEATURES:
        header += [f"{k} latents: d_pm (over QSlim's)", "d_normal"]
    return markdown([*header, "quoted from the paper"], rows)


def by_features(results: Results) -> list[str]:
    """Table 2: the paper's model by latents, QSlim with as many numbers in between."""
    slim = lambda k, key: np.mean(list(results.values(REFERENCE_SCALARS, "scalars", k, key).values()) or [np.nan])
    reference, rows, before = slim(0, "d_pm"), [], {}
    first = [f"QSlim, {BASE_FACES} faces", "", "", f"{reference:.2f}", "1.00"]
    rows.append([*first, f"{slim(0, 'd_normal'):.2f}", f"{slim(0, 'd_reverse'):.2f}", "", "1.00, 13.21"])
    for k in (*FEATURES, "all"):
        found = {key: results.values(MODEL, "features", k, key) for key in ("cr", "bytes", *MEASURES)}
        if not found["d_pm"]:
            continue
        mean = {key: np.mean(list(v.values())) for key, v in found.items()}
        better = [found["d_pm"][m] < before[m] for m in found["d_pm"] if m in before]
        quoted = PAPER_FEATURES.get(k)
        rows.append([
            f"the paper's model, {'no' if k == 0 else k} latents", f"{np.median(list(found['cr'].values())):.1f}",
            f"{mean['bytes']:,.0f}", f"{mean['d_pm']:.2f}", f"**{mean['d_pm'] / reference:.3f}**", f"{mean['d_normal']:.2f}",
            f"{mean['d_reverse']:.2f}", f"{100 * np.mean(better):.1f} % of meshes" if better else "",
            f"{quoted[0] / 30.11:.2f}, {quoted[1]:.2f}" if quoted else "",
        ])  # fmt: skip
        before = found["d_pm"]
        if k in FEATURES[1:]:
            d_pm, d_normal, d_reverse = (slim(k, key) for key in ("d_pm", "d_normal", "d_reverse"))
            cells = [f"{d_pm:.2f}", f"{d_pm / reference:.3f}", f"{d_normal:.2f}", f"{d_reverse:.2f}"]
            rows.append(["QSlim at that CR", "", "", *cells, "", ""])
    header = ["method", "CR", "bytes", "d_pm", "ratio to QSlim", "d_normal", "d_reverse", "better than the row before",
              "paper: ratio, d_normal"]
    return markdown(header, rows)


def by_level(results: Results) -> list[str]:
    """Table 3: levels of detail of the paper's model, with 400 latents and with all."""
    rows = []
    for level in (1, 2, 3):
        cells = []
        for features in (FEATURES[-1], "all"):
            place = ("features", features) if level == 3 else (f"levels, {features}", level)
            for key in ("d_pm", "d_normal"):
                found = list(results.values(MODEL, *place, key).values())
                cells.append(f"{np.mean(found):.2f}" if found else NONE)
        quoted = "{:.2f} / {:.2f}".format(*PAPER_LEVELS[level])
        rows.append([str(level), f"{BASE_FACES * 4**level:,}", *cells, quoted])
    return markdown(["level", "faces", "400 latents: d_pm", "d_normal", "all: d_pm", "d_normal", "paper, 400 latents"], rows)


def cr_curve(results: Results) -> list[str]:
    """Table 4: geometric mean of the ratio to QSlim's d_pm with as many numbers, where these are fewer than the input's."""
    results, ratios = results.only(lambda row: row.get("cr", 2) > 1), []
    for k in CURVE:
        found = [r.get(("scalars", k), {}).get("cr") for r in results.rows.get(REFERENCE_SCALARS, {}).values()]
        found = [x for x in found if x]
        ratios.append(f"CR {np.median(found):.3g}, {k:,}" if found else f"{k:,}")
    rows = []
    for method, name in results.names.items():
        found = [results.ratio(method, REFERENCE_SCALARS, "scalars", k, "d_pm") for k in CURVE]
        if any(n for _, n in found):
            rows.append([name, *(f"{ratio:.3f} ({n})" if n else NONE for ratio, n in found)])
    return markdown(["method", *(f"{r} latents" for r in ratios)], rows)


def whole(results: Results) -> list[str]:
    """Draco alone: every vertex of the input."""
    rows = []
    for bits in (8, 10, 12, 14):
        sizes = list(results.values("draco", "whole", bits, "bytes").values())
        if sizes:
            cells = [f"{geometric(list(results.values('draco', 'whole', bits, key).values())):.3g}" for key in MEASURES]
            rows.append([f"Draco alone, {bits} bits", f"{geometric(sizes):,.0f}", *cells])
    return markdown(["geometric means", "bytes", *MEASURES.values()], rows) if rows else []


def seconds(results: Results) -> list[str]:
    """Processor seconds that each method took for a mesh, its search and all measuring included."""
    rows = []
    for method, name in results.names.items():
        found = [line["seconds"] for line in results.about[method].values()]
        rows.append([name, f"{np.median(found):.1f}", f"{np.mean(found):.1f}", f"{np.max(found):.1f}"])
    return markdown(["processor seconds a mesh, searching and measuring included", "median", "mean", "most"], rows)
