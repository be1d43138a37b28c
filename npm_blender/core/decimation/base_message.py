"""The sentences that tell a user why a base has another number of faces than asked for."""
from .face_bounds import Cause, FaceAdvice

_PLAIN = {
    Cause.SMALL_INPUT: "the mesh has no more",
    Cause.EVEN: "a closed mesh has an even number",
    Cause.SINGLE_FACE: "no collapse removes a single face",
    Cause.NO_COLLAPSE: "no further collapse keeps topology and shape",
}


def base_message(faces: int, asked: int, advice: FaceAdvice) -> str:
    """'', or one line on why a base has so many faces and not as many as asked for, and what to do."""
    if advice.cause == Cause.NONE:
        return ""
    if advice.cause == Cause.PARTS:
        reason = _parts(advice, asked)
    elif advice.cause == Cause.HANDLES:
        reason = _handles(advice)
    else:
        reason = _PLAIN[advice.cause]
    return f"Reached {faces} of {asked} base faces: {reason}"


def _parts(advice: FaceAdvice, asked: int) -> str:
    what = (f"the {advice.parts:,} separate parts of the mesh need" if advice.parts > 1
            else "the handles and borders of the mesh need")
    return (f"{what} at least {advice.needed:,} base faces, more than the {asked:,} asked for; "
            "ask for more, or join or delete small parts")


def _handles(advice: FaceAdvice) -> str:
    got = f" and got {advice.recognizable:,} to be recognizable" if advice.recognizable else ""
    return (f"the handles of the mesh (holes through it: {advice.handles:,}) need at least {advice.needed:,} base faces{got}; "
            f"ask for {advice.needed:,} or more, or close holes")
