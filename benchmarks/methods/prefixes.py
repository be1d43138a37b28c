"""What the streams of our codec share as methods: a budget, or a count of numbers, is a prefix of one stream."""

from npm_blender.core.codec import ProgressiveMesh, compress, open_stream
from npm_blender.core.mesh import TriMesh
from npm_blender.core.settings import CompressSettings

from .case import Case, Coded


def opened(case: Case, settings: CompressSettings) -> ProgressiveMesh:
    """The stream of a case, made once for each settings; the seconds of its making go to case.seconds."""

    def make() -> ProgressiveMesh:
        made = compress(case.mesh, settings)
        case.seconds.update(made.report.seconds)
        return open_stream(made.data)

    return case.once(("stream", settings), make)


def cut(progressive: ProgressiveMesh, budgets: tuple[int, ...], name: str) -> list[Coded | None]:
    """The features that a prefix of so many bytes holds, finest level; None for less than the base. name: of features."""
    out: list[Coded | None] = []
    for budget in budgets:
        if budget < progressive.base_bytes:
            out.append(None)
            continue
        k = progressive.features_for(min(budget, progressive.total_bytes))
        out.append(Coded(progressive.decode(k), progressive.bytes_for(k), f"{k} {name}"))
    return out


def of_numbers(progressive: ProgressiveMesh, counts: list[int]) -> list[TriMesh | None]:
    """As many features as have so few numbers, after those of the base mesh; None where the stream has not so many."""
    apart = progressive.numbers(progressive.features) // max(progressive.features, 1)  # numbers of a feature
    base, out = 3 * progressive.base_vertices, []
    for count in counts:
        k = (count - base) // max(apart, 1)
        out.append(progressive.decode(k) if 0 <= k <= progressive.features else None)
    return out
