"""Pictures of comparisons and tracks."""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.exceptions import InvalidInputError

pytest.importorskip("matplotlib")


def sets_of(*tests):
    return [ar.AntiresonanceSet(0, {0: values}) for values in tests]


@pytest.mark.parametrize("kind", ["change", "frequency"])
@pytest.mark.parametrize("conditions", [None, [0.0, 5.0, 20.0], ["intact", "cut", "repaired"]])
def test_pictures_of_tracks(kind, conditions):
    from matplotlib.figure import Figure

    from antires_rs import figures as plotting

    followed = ar.track(sets_of([10.0, 20.0], [10.1, 30.0], [10.2, 20.1]), conditions)
    ax = followed.plot(0, kind=kind, ax=Figure().subplots())
    assert ax.get_ylabel().endswith("(%)" if kind == "change" else "(Hz)")
    assert plotting.data_of(ax)["tracks"]["freq_hz"].size == 9
    names = [text.get_text() for text in ax.get_legend().get_texts()]
    assert {"10.00 Hz", "20.00 Hz", "30.00 Hz", "new", "lost"} <= set(names)
    with pytest.raises(InvalidInputError, match="^dof: got 7"):
        followed.plot(7)


def test_picture_of_a_comparison():
    from matplotlib.figure import Figure

    from antires_rs import figures as plotting

    std = {0: [0.01, 0.01], 1: [0.01]}
    a, b = (ar.AntiresonanceSet(0, {0: f, 1: [14.4]}, std_hz=std) for f in ([8.7, 23.9], [8.7, 23.5]))
    ax = ar.compare(a, b).plot(ax=Figure().subplots())
    drawn = plotting.data_of(ax)["pairs"]
    assert drawn["changed"].tolist() == [False, True, False]
    assert np.allclose(drawn["difference_percent"], [0.0, -1.674, 0.0], atol=1e-3)
    assert [text.get_text() for text in ax.texts] == ["dof 0", "1"]


def test_a_loss_is_marked_at_the_first_test_that_lacks_the_value():
    from matplotlib.figure import Figure

    followed = ar.track(sets_of([10.0, 20.0], [10.1, 20.2], [10.2], [10.3]), [0.0, 5.0, 20.0, 30.0])
    for kind, level in (("frequency", 20.2), ("change", 1.0)):
        ax = followed.plot(0, kind=kind, ax=Figure().subplots())
        (mark,) = [line for line in ax.get_lines() if line.get_label() == "lost"]
        assert (mark.get_xdata()[0], mark.get_ydata()[0]) == (20.0, pytest.approx(level))
