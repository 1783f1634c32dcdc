"""Files that went wrong: bytes of a good one changed, lost, doubled or put in, at random."""

from __future__ import annotations

from hypothesis import strategies as st

#: What texts of numbers are made of; random bytes seldom form a line that a parser takes further.
TEXT = "0123456789.,;:eEijnaf+-#%\"'[]{}()= \t\n\\_abT/é\x00"

any_text = st.text(TEXT, max_size=300)
any_bytes = st.one_of(st.binary(max_size=300), any_text.map(lambda text: text.encode("utf-8")))


def _changed(whole: bytes, changes: list[tuple[str, float, int, bytes]]) -> bytes:
    for what, place, length, new in changes:
        at = int(place * len(whole))
        before, piece, after = whole[:at], whole[at : at + length], whole[at + length :]
        whole = {
            "replaced": before + new + after,
            "lost": before + after,
            "doubled": before + piece + piece + after,
            "cut": before,
            "put in": before + new + piece + after,
        }[what]
    return whole


def mutated(whole: bytes, *, most: int = 4) -> st.SearchStrategy[bytes]:
    """Strategy of ``whole`` after one to ``most`` changes."""
    change = st.tuples(
        st.sampled_from(["replaced", "lost", "doubled", "cut", "put in"]),
        st.floats(0.0, 1.0, exclude_max=True),
        st.integers(1, 40),
        st.one_of(st.binary(min_size=1, max_size=8), st.text(TEXT, min_size=1, max_size=8).map(str.encode)),
    )
    return st.lists(change, min_size=1, max_size=most).map(lambda changes: _changed(whole, changes))
