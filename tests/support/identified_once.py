"""Each record identified once: for tests of what becomes of a result, not of how it is made."""

from antires_rs.identification.identify import identify_antiresonances
from antires_rs.watch.sources import fingerprint

_FOUND = {}


def identified_once(signal, **options):
    """As :func:`antires_rs.identify_antiresonances`; a result, or an exception, is remembered."""
    key = fingerprint(signal), repr(sorted(options.items()))
    if key not in _FOUND:
        try:
            _FOUND[key] = identify_antiresonances(signal, **options)
        except Exception as exc:
            _FOUND[key] = exc
    if isinstance(_FOUND[key], Exception):
        raise _FOUND[key]
    return _FOUND[key]
