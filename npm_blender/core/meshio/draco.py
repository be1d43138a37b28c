"""Google's Draco files (.drc), by the package DracoPy; read only."""
import numpy as np

from ..errors import DependencyError, FileError


def read_draco(data: bytes) -> tuple[np.ndarray, np.ndarray]:
    """V (n, 3) float64, F (m, 3) int64 of the bytes of a Draco file; F (0, 3) where it holds points alone.

    Raises DependencyError without DracoPy, FileError, without the file's name, if it cannot read the bytes.
    """
    try:
        import DracoPy
    except ImportError:
        raise DependencyError("Expected the package DracoPy to read .drc files, found none; "
                              "run pip install DracoPy, or convert the file to .ply") from None
    try:
        mesh = DracoPy.decode(data)
    except Exception as error:  # DracoPy raises its own and plain exceptions
        raise FileError("Expected a whole drc file, found damaged or foreign content; export it again") from error
    faces = getattr(mesh, "faces", None)
    V = np.asarray(mesh.points, np.float64).reshape(-1, 3)
    return V, np.zeros((0, 3), np.int64) if faces is None else np.asarray(faces, np.int64).reshape(-1, 3)
