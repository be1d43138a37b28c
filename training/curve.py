"""Draw the validation curve of a run: `python -m training.curve OUT/log.csv OUT/curve.png`."""

import argparse
import csv
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402  the backend comes first, there may be no display


def main() -> None:
    """Read the log, write the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("log", type=Path)
    parser.add_argument("picture", type=Path)
    options = parser.parse_args()
    with options.log.open(newline="") as f:
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(f)]
    figure, axis = plt.subplots(figsize=(7, 4.2), layout="constrained")
    for key, label in (("0", "no features"), ("40", "40 features"), ("400", "400 features"), ("all", "all features")):
        axis.plot([r["step"] for r in rows], [r[key] / r["base"] for r in rows], label=label)
    axis.set(xlabel="step (one mesh each)", ylabel="validation error over that of the base mesh", ylim=(0, 1))
    axis.grid(alpha=0.3)
    axis.legend()
    figure.savefig(options.picture, dpi=120)


if __name__ == "__main__":
    main()
