"""What a set of antiresonances was identified from: kept by edits, names and files."""

import json

import antires_rs as ar


def some(**options):
    return ar.AntiresonanceSet(0, {0: [8.7, 12.2], 1: [14.4]}, **options)


def test_by_default_nothing_is_known_and_the_dofs_are_the_channels():
    assert (some().sees, some().channels) == (None, (0, 1))


def test_it_survives_edits_and_their_undoing():
    edited = some(sees="transmissibility", channels=[0, 1, 5]).drop(0, 8.7).add(1, 20.0)
    for each in (edited, edited.original()):
        assert (each.sees, each.channels) == ("transmissibility", (0, 1, 5))


def test_it_survives_files_and_older_files_do_not_know(tmp_path):
    for sees, channels in (("frf", None), ("transmissibility", [1, 0, 7]), (None, None)):
        kept = some(sees=sees, channels=channels).drop(0, 8.7)
        kept.save(tmp_path / "set.json")
        for each in (back := ar.AntiresonanceSet.load(tmp_path / "set.json"), back.original()):
            assert (each.sees, each.channels) == (sees, tuple(channels or (0, 1)))
    data = json.loads(some(sees="frf").to_json())
    del data["sees"]
    assert ar.AntiresonanceSet.from_json(json.dumps(data)).sees is None


def test_new_names_are_the_channels_names_too_unless_one_has_none():
    known = some(sees="transmissibility", channels=[0, 1, 5])
    assert known.relabelled(3, {0: 3, 1: 4, 5: 9}).channels == (3, 4, 9)
    assert known.relabelled(3, {0: 3, 1: 4}).channels == ()
    assert known.relabelled(3, {0: 3, 1: 4}).sees == "transmissibility"


def test_identification_says_what_its_route_sees():
    chain = ar.MassSpringChain([1.0, 1.0, 2.0], [500.0, 700.0])
    record = chain.simulate(excitation=0, fs_hz=40.0, duration_s=400.0, damping_ratio=0.01, rng=0)
    for route in ("transmissibility", "frf"):
        found = ar.identify_antiresonances(
            record, excitation=0, band_hz=(1.0, 12.0), route=route, dofs=[0, 1], check="off"
        )
        assert (found.sees, found.channels, list(found)) == (route, (0, 1, 2), [0, 1])


def test_joined_setups_are_of_one_kind_or_of_none():
    sets = [some(sees="frf"), some(sees="frf", channels=[0, 1, 4])]
    merged = ar.merge_setups(sets, check="off")
    assert (merged.sees, merged.channels) == ("frf", (0, 1, 4))
    assert ar.merge_setups([sets[0], some(sees="transmissibility")], check="off").sees is None
    moved = [ar.AntiresonanceSet(k, {"tip": [f]}, sees="frf") for k, f in ((3, 20.1), (4, 25.3))]
    merged = ar.merge_setups(moved, excitation="tip", check="off")
    assert (merged.sees, merged.channels) == ("frf", ())
