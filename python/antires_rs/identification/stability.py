r"""Stability selection: which zeros come back when the data and the fit are perturbed.

A *look* is the direction of the responses in one resolution, as measured and several times perturbed: over
the band from segments of one length, or after impacts in an exponential window of one length over the
frequencies of which it holds 20 to 320 periods (with 1 % of damping a free vibration falls to a hundredth in
73). Perturbed it is from random halves of the segments or of the impacts, in complementary pairs, or, where
there are too few, with its own noise added once more; in every second one channel is left out. Zeros of
local fits (:mod:`~antires_rs.identification.local_fits`) to the unperturbed directions are candidates. The
*share* of a candidate is how often perturbed fits see it, within 1.5 %, over stretches of the best of three
widths, averaged over looks at the same frequencies, of the best of windows. The candidate moves to the middle
of what they see, which the fits it came from need not know. What noise puts into one fit others do not see.
Accepted is a zero with a share of ``min_share``, or more as more of the other responses
have one in its place, that is

- a dip of the response beside the others, 6 dB deep, on both sides of which the response rises 10 dB over
  what the fits leave: what lies between two lines of noise is no antiresonance, and what all responses have,
  a line of the force or a mode that it hardly excites, makes none;
- or in more fits, and off the axis by more than its scatter; of decays in fewer the further off it is. A zero
  beside a resonance or on a slope hardly dips, but turns the phase; roots of the noise of a line do not. Nor
  do those of a mode that the force hardly excites, in many responses of one decay at once: off the axis they
  confirm one another, unless they lie at twice the frequency of a strong vibration, as its harmonic.

Two values between which the response does not rise are one, unless most fits must have both; its frequency is
the median by share, which neither a split dip nor a stray neighbour moves far.

How many accepted values are false is bounded from the shares (``expected_false``, :func:`false_values`).

The standard deviation is the scatter of the perturbed fits (complementary halves scatter about the whole as
the whole does about the truth), with half of the difference between the looks.

References: N. Meinshausen and P. Buehlmann, J. R. Stat. Soc. B 72 (2010) 417-473; R. D. Shah and R. J.
Samworth, J. R. Stat. Soc. B 75 (2013) 55-80 (complementary pairs).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ..measured.response_table import ResponseTable
from ..signals.averaging import Averages, Event, beside, find_events, lowest_hz, tail_noise, without_drift
from ..signals.hum import Hum
from ..signals.recording import Recording, parts_of, shortest
from ..signals.spectra import (
    CrossSpectra,
    Segments,
    channel_noise,
    cross_spectra,
    dominant,
    lines_in,
    running_mean,
)
from ..support.checks import ComplexArray, FloatArray
from ..support.progress import step
from .lines import SNR_CAP, Lines
from .local_fits import LEAST_LINES, MOST_LINES, SCALES, LocalFits, Stretch, fits, stretches
from .options import FitOptions, IdentificationOptions
from .scores import WEAK_DEPTH_DB, scored, window_grades
from .stabilization import StabilizationDiagram, of_zeros

# -- The looks of a record


VIEWS, GROUPS = 24, 24  # perturbed views of a look: halves of groups of segments in complementary pairs
#: With fewer groups halves tell little, and noise is added instead; averages that the longer segments leave.
LEAST_GROUPS, LEAST_AVERAGES = 6, 11.0
LEAST_DRAWS = 4  # from so many records of one test on they are the groups
#: Periods of the frequencies that a window over a decay is for, and by how much one is shorter than the one
#: before; the shortest suits frequencies up to this share of the band's end at least.
PERIODS, SHORTER, ENOUGH = (20.0, 320.0), 4.0, 0.7
LEAD = 4.0  # periods of the highest frequency before an impact
#: Amplitude to which an exponential window brings a decay down, and lines of it that are independent.
WINDOWED_END, INDEPENDENT = 1e-2, 3
STRONG = 0.1  # power at a frequency over that at the strongest, from which its harmonic is looked for
SEED = 28  # seed of halves and of added noise: the same record gives the same values


@dataclass(frozen=True)
class Look:
    """Directions of one resolution.

    ``vectors`` (n_views, n_freq, n_rows) are of unit norm at every line, the first as measured; in the others
    a row may be zero, that of a channel left out. Where the first is alone, noise as large as what the fits
    leave perturbs it. ``noise`` (n_freq, n_rows) is the least noise power of the first. Looks at
    ``n_hits`` decays are for different frequencies; ``strong_hz`` are those at which they are strongest.
    """

    freq_hz: FloatArray
    vectors: ComplexArray
    weights: FloatArray
    noise: FloatArray
    decay_per_s: float = 0.0
    n_hits: int = 0
    strong_hz: FloatArray = field(default_factory=lambda: np.empty(0))


#: Of spectra and the scale of the channels: largest eigenvalue, mean of the others and direction, by line.
Directions = Callable[[ComplexArray, FloatArray], tuple[FloatArray, FloatArray, ComplexArray]]


def looks_of(
    averages: Averages, band_hz: tuple[float, float], directions: Directions = dominant, *, one: bool = False
) -> list[Look]:
    """Looks at a record, or ``one`` for all of the band, but for those of too few lines; none may be left."""
    rng, rec = np.random.default_rng(SEED), averages.rec
    if averages.nperseg is None:
        return _of_impacts(rec, band_hz, averages.hum, directions, rng, one=one)
    given = averages.options.window
    window = given if isinstance(given, str | tuple) else "hann"
    longest = averages.options.nperseg or look_samples(rec, band_hz)
    made = [
        _of_segments(
            beside(cross_spectra(rec, nperseg=n, window=window, band_hz=band_hz), averages.hum),
            directions,
            rng,
        )
        for n in (longest, longest // 2, longest // 4)[: 1 if one else None]
        if n * (band_hz[1] - band_hz[0]) >= 2 * LEAST_LINES * rec.fs_hz
    ]
    return [look for look in made if look.freq_hz.size >= 2 * LEAST_LINES]


def look_samples(rec: Recording, band_hz: tuple[float, float]) -> int:
    """Samples of the longer segments: as many lines as a stretch in the middle of the band holds are fitted,
    but no fewer averages than perturbed fits need."""
    middle = np.sqrt(max(band_hz[0], 0.02 * band_hz[1]) * band_hz[1])
    ratio = SCALES[1][0]
    wanted = MOST_LINES * rec.fs_hz / (middle * (np.sqrt(ratio) - 1.0 / np.sqrt(ratio)))
    most = min(2.0 * rec.n_samples / LEAST_AVERAGES, float(shortest(rec)))
    return max(16, 1 << int(np.log2(max(min(wanted * np.sqrt(2.0), most), 16.0))))


def _of_segments(spectra: CrossSpectra, directions: Directions, rng: np.random.Generator) -> Look:
    assert spectra.segments is not None
    scale = channel_noise(spectra.matrix, spectra.noise_power)
    largest, rest, first = directions(spectra.matrix, scale)
    snr = largest / np.maximum(rest, 1e-12 * largest)
    vectors = [first]
    parts = np.array_split(np.arange(spectra.n_averages), min(spectra.n_averages, GROUPS))
    if spectra.draws is not None and (n_draws := int(spectra.draws.max()) + 1) >= LEAST_DRAWS:
        # Halves of the records of one test, so that what differs between these perturbs the fits.
        parts = [np.flatnonzero(spectra.draws == draw) for draw in range(n_draws)]
    count = len(parts)
    if count >= LEAST_DRAWS and spectra.n_averages >= LEAST_GROUPS:
        x = spectra.segments.at(slice(None))
        sums = [x[:, :, part].conj() @ x[:, :, part].transpose(0, 2, 1) for part in parts]
        for _ in range(VIEWS // 2):
            drawn = rng.permutation(count)
            for half in (drawn[: count // 2], drawn[count // 2 :]):
                vectors.append(directions(np.sum([sums[g] for g in half], axis=0), scale)[2])
    stacked = np.array(vectors)
    stacked[1:] = leave_out(stacked[1:])
    return Look(spectra.freq_hz, stacked, snr / (1.0 + snr / SNR_CAP), np.zeros(first.shape))


def _of_impacts(
    rec: Recording,
    band_hz: tuple[float, float],
    hum: Hum | None,
    directions: Directions,
    rng: np.random.Generator,
    *,
    one: bool,
) -> list[Look]:
    """Decays from the impact on in exponential windows, each over the frequencies that its length suits.

    Long ones resolve sharp zeros at low frequencies, short ones leave the noise after a decay out at high
    ones. ``one`` is a window for the whole band.
    """
    low_hz = lowest_hz(band_hz)
    cut, floors = [], []
    for part in parts_of(rec):
        events = find_events(part, low_hz)
        floors.append(tail_noise(part, low_hz)[1])
        cut += [(part.responses, event) for event in events]
    longest = max(event.stop - event.hit for _, event in cut) / rec.fs_hz
    least, most = PERIODS
    if one:
        middle = float(np.sqrt(low_hz * band_hz[1]))
        windows = [(min(longest, most / middle), (low_hz, band_hz[1]))]
    else:
        lengths = [min(longest, most / low_hz)]
        while least / (lengths[-1] / SHORTER) < ENOUGH * band_hz[1]:
            lengths.append(lengths[-1] / SHORTER)
        windows = [
            (own, (low_hz if own == longest else least / own, min(band_hz[1], most / own))) for own in lengths
        ]
    looks = [
        _of_decays(rec.fs_hz, cut, floors, own, (max(low, low_hz), high), hum, band_hz[1], directions, rng)
        for own, (low, high) in windows
    ]
    return [look for look in looks if look is not None]


def _of_decays(
    fs_hz: float,
    cut: list[tuple[FloatArray, Event]],
    floors: list[FloatArray],
    length_s: float,
    band_hz: tuple[float, float],
    hum: Hum | None,
    highest_hz: float,
    directions: Directions,
    rng: np.random.Generator,
) -> Look | None:
    """One window from before the impacts on, as far as the mean taken off reaches; None of too few lines."""
    lead = int(np.ceil(LEAD * fs_hz / highest_hz + 0.5 * fs_hz / band_hz[0]))
    length = lead + int(length_s * fs_hz)
    decay = -np.log(WINDOWED_END) * fs_hz / length
    taper = np.exp(-decay / fs_hz * np.arange(length))
    freq = np.asarray(np.fft.rfftfreq(length, 1.0 / fs_hz), dtype=np.float64)
    inside = lines_in(freq, band_hz)
    some = np.arange(inside.start, inside.stop)[::INDEPENDENT]
    if hum is not None:
        some = some[hum.outside(freq[some], length / fs_hz)]
    if some.size < 2 * LEAST_LINES:
        return None
    each = []
    for x, event in cut:
        start = max(0, event.hit - lead)
        own = without_drift(x[:, start : min(start + length, event.stop)], fs_hz, band_hz[0])
        each.append(np.fft.rfft(own * taper[: own.shape[1]], length)[:, some])
    spectra = np.stack(each, axis=2).transpose(1, 0, 2)
    at = freq[some] / (0.5 * fs_hz)
    noise = np.mean(
        [[np.interp(at, np.linspace(0.0, 1.0, row.size), row) for row in one] for one in floors], 0
    )
    noise = (noise * np.sum(taper**2)).T
    scale = np.median(noise, axis=0)
    largest, _, first = directions(Segments.of(spectra).matrix, scale)
    vectors = [first]
    if len(each) >= LEAST_GROUPS:
        for _ in range(VIEWS // 2):
            drawn = rng.permutation(len(each))
            for half in (drawn[: len(each) // 2], drawn[len(each) // 2 :]):
                vectors.append(directions(Segments.of(spectra[:, :, half]).matrix, scale)[2])
    own_noise = noise / scale / len(each)
    if directions is not dominant:  # that of minors is even over them
        own_noise = np.repeat(own_noise.mean(axis=1, keepdims=True), first.shape[1], axis=1)
    snr = largest / np.maximum(own_noise.mean(axis=1), 1e-300)
    stacked = np.array(vectors)
    stacked[1:] = leave_out(stacked[1:])
    floor = own_noise / np.maximum(largest, 1e-300)[:, None]
    weights = snr / (1.0 + snr / SNR_CAP)
    strong = freq[some][largest >= STRONG * largest.max()]
    return Look(freq[some], stacked, weights, floor, decay, n_hits=len(each), strong_hz=strong)


# -- Candidates and their shares

MOST_DAMPING = 0.06  # zeros with more damping shape a trend
#: Zeros of several fits this close are one candidate, and a perturbed fit sees it within the second share.
ONE_CANDIDATE, SEEN_WITHIN = 0.007, 0.015
#: Share of the unperturbed fits from which a zero is a candidate, and distance of two that are accepted.
LEAST_SIGHTINGS, APART = 0.25, 0.015
MOVES, STILL = 3, 1e-5  # steps of a candidate to the middle of what perturbed fits see, and the least one
MARGIN = 0.08  # margin of a stretch at either end in which its zeros do not count
#: A candidate is judged by this many stretches of each scale, in whose middle part it lies.
JUDGES, MIDDLE = 2, 0.42
#: Flanks of a zero as shares of its frequency, on one side, and how far the response must rise there in dB.
FLANKS, RISE_DB = ((0.015, 0.07), (0.07, 0.15), (0.15, 0.25)), 10.0
MENTIONED_DB = 7.0  # what rises less is not even mentioned
#: How far above ``min_share`` a share must be without a dip: of decays ``OFF_AXIS`` and so many scatters off
#: the axis; of segments, which leak off it; and where all others have it too, as a harmonic, within the last.
WITHOUT_DIP, FAR_OFF, OF_SEGMENTS, IN_COMPANY, BESIDE = (0.3, 0.1), 4.0, 0.25, 0.3, 0.01
#: Of one decay: scatters off the axis from which, and from where wholly, values of several responses in one
#: place are a mode that the force hardly excites, no line; more than half of the others confirm them.
CLEAR, CONFIRMED = (1.0, 1.5), (0.5, 0.6)
#: A root in an exponential window no further from the axis of that than the window's own decay may follow the
#: noise of a line: standard deviations by which one in a dip may be nearer, one without must be further.
OFF_AXIS = 0.6
#: Half the width about a value, as a share of it, in which its dip is looked for, and how many times
#: ``min_depth_db`` deep it must be: zeros of noise and of lines of the force have up to 4 dB.
AT_VALUE, DEPTH = 0.007, 2.0
BETWEEN_DB = 8.0  # how far a response must rise between two values for them to be two
#: Of several values in one dip those count between which it rises less than the first number, with at least
#: the second part of the largest share.
SPLIT_DB, COUNTS_IN_DIP = 4.0, 0.7
ONE_DIP_WITHIN = 0.06  # values further apart are never one
#: In a window of a decay an order votes whose fits leave at most so many times what those of the highest do:
#: one too low for the zeros there misses those close together. Of segments, whose averages leak, all vote.
UNDERFIT = 8.0
#: Values from this far apart that most fits must have both are two: no zero that wanders stands for both.
TWO_FROM = 0.04
NOISE_LINES = 31  # lines over which what the fits leave is averaged


@dataclass(frozen=True)
class _Surveyed:
    """A look with the fits to its unperturbed vectors, by scale, and the noise that they leave."""

    look: Look
    fits: list[list[LocalFits]]
    noise: FloatArray


#: Reasons for which a candidate is not accepted.
IN_TOO_FEW, IN_NOISE = "in too few perturbed fits", "beside noise"
NO_DIP, TOO_DAMPED = "no dip beside the other responses", "damped too much"
AT_A_LINE = "on the axis, as noise of a line"
#: A candidate: response, frequency, damping ratio, standard deviation in Hz, share, rise in dB, fits, whether
#: it lies at twice a frequency of strong vibration.
CANDIDATE = np.dtype(
    [
        ("row", np.intp),
        *((name, np.float64) for name in ("freq_hz", "damping_ratio", "std_hz", "off_axis")),
        *((name, np.float64) for name in ("share", "rise_db", "depth_db")),
        ("fits", np.intp),
        ("harmonic", np.bool_),
    ]
)


def direction_diagrams(
    looks: Sequence[Look],
    lines: Lines,
    n_responses: int,
    band_hz: tuple[float, float],
    options: IdentificationOptions,
) -> list[StabilizationDiagram]:
    """One diagram for each response: zeros of all unperturbed fits, and what perturbed ones confirm."""
    surveyed = []
    for number, look in enumerate(looks):
        step(f"resolution {number + 1} of {len(looks)}")
        surveyed.append(_survey(look))
    sightings = [_sightings(one, band_hz) for one in surveyed]
    step("perturbed fits")
    judged = _judged(surveyed, sightings, n_responses)
    why = reasons(judged, options.rule, n_responses, n_hits=looks[0].n_hits)
    found, refused = _apart(judged[why == ""], surveyed, options.rule.min_share), judged[why != ""]
    why = why[why != ""]
    seen = np.concatenate([one.zeros for one in sightings])
    places = float(np.log(band_hz[1] / lines.freq_hz[0])) / (2.0 * SEEN_WITHIN)
    diagrams = []
    for row in range(n_responses):
        own, out = found["row"] == row, refused["row"] == row
        quotients = lines.quotients(row)[0]
        background = np.abs(quotients.sum(axis=0))
        accepted, left_out = _table(found[own]), _table(refused[out])
        on_average = float(judged["share"][judged["row"] == row].sum())
        accepted = accepted.with_scores(
            expected_false=false_values(accepted.scores["share"], on_average, places)
        )
        accepted = scored(accepted, lines.freq_hz, background, quotients, quotients)
        tables = accepted, left_out.with_scores(why=why[out])
        _, freq, order, damping = seen[seen[:, 0] == row].T
        zeros, least = (order, freq, damping), SCALES[0][2][0]
        diagrams.append(of_zeros(zeros, least, *tables, ONE_CANDIDATE, lines.freq_hz, background, band_hz))
    return diagrams


def _table(found: NDArray[np.void]) -> ResponseTable:
    spread = found["std_hz"] / found["freq_hz"]
    table = ResponseTable.of_sweep(
        found["freq_hz"],
        found["damping_ratio"],
        found["std_hz"],
        rows=found["fits"],
        spread=spread,
        dominance=np.full(found.size, np.nan),
        how="directions",
    )
    return table.with_scores(
        share=found["share"],
        depth_db=found["depth_db"],
        own_depth_db=found["rise_db"],
        grade=window_grades(found["share"], spread, np.maximum(found["depth_db"], WEAK_DEPTH_DB)),
    )


def _judged(surveyed: list[_Surveyed], sightings: list[_Sightings], n_rows: int) -> NDArray[np.void]:
    """All candidates, by response and frequency."""
    rng = np.random.default_rng(SEED)
    places = [
        (row, value)
        for row in range(n_rows)
        for value in _candidates(sightings, row)
        if max(_rise_db(one, row, value) for one in surveyed) >= MENTIONED_DB
    ]
    zeros = [_perturbed(one, places, rng) for one in surveyed]
    own_range = surveyed[0].look.n_hits > 0
    strong_hz = np.concatenate([one.look.strong_hz for one in surveyed])
    rows = []
    for i, (row, value) in enumerate(places):
        for _ in range(1 + MOVES):
            every = [part for own in zeros if (part := _seen(own[i], value)) is not None]
            # Looks at the same frequencies together; of windows the one that suits it best.
            parts = [max(every, key=lambda part: part.share)] if own_range and every else every
            if not parts:
                break
            weights = np.array([part.share for part in parts])
            before, value = value, float(np.average([part.freq_hz for part in parts], weights=weights))
            if abs(value / before - 1.0) < STILL:
                break
        if not parts:
            continue
        scatter = [part.scatter for part in parts]
        rows.append(
            (
                row,
                value,
                float(np.median([part.damping_ratio for part in parts])),
                float(
                    np.hypot(min(std for std, _ in scatter), 0.5 * np.ptp([part.freq_hz for part in parts]))
                ),
                max(part.off_axis for part in every if part.share >= COUNTS_IN_DIP * weights.max()),
                float(weights.sum()) / (1 if own_range else len(surveyed)),
                max(_rise_db(one, row, value) for one in surveyed),
                max(_depth_db(one, row, value) for one in surveyed),
                sum(part.fits for part in parts),
                bool(np.any(np.abs(2.0 * strong_hz / value - 1.0) < BESIDE)),
            )
        )
    return _once(np.array(rows, dtype=CANDIDATE))


def _once(found: NDArray[np.void]) -> NDArray[np.void]:
    """Candidates without those that have moved to the place of another with a larger share."""
    kept: list[int] = []
    for i in np.argsort(-found["share"], kind="stable").tolist():
        same = [k for k in kept if found["row"][k] == found["row"][i]]
        if np.all(np.abs(found["freq_hz"][same] / found["freq_hz"][i] - 1.0) > ONE_CANDIDATE):
            kept.append(i)
    return found[sorted(kept)]


def false_values(share: FloatArray, on_average: float, places: float) -> FloatArray:
    """Bound on how many values of a response with at least this share are false, on average, (n,).

    A perturbed fit sees a value at ``on_average`` of so many ``places``, q of p: at most
    q^2 / p / (2 share - 1) false values reach a share (Meinshausen and Buehlmann 2010, theorem 1), at most
    q / share in any case. What is wrong in every half, as by leakage, is not in it. The smaller bound of Shah
    and Samworth held on 36 of 40 simulated hits, this one on 39 (``benchmarks/simulated_reality.py``).
    """
    chance = on_average**2 / places / np.maximum(2.0 * share - 1.0, 1e-9)
    return np.asarray(np.minimum(chance, on_average / share))


def reasons(found: NDArray[np.void], rule: FitOptions, n_rows: int, *, n_hits: int) -> NDArray[np.str_]:
    """Why candidates, of so many decays or of segments, are not accepted, (n,); empty for those that are."""
    share, off = found["share"], found["off_axis"]
    more = np.interp(off, (OFF_AXIS, FAR_OFF), WITHOUT_DIP) if n_hits else np.full(off.shape, OF_SEGMENTS)
    company = _company(found[found["share"] >= rule.min_share], found, n_rows)
    # Off the axis as well are the harmonic of a strong vibration, by what a sensor or its amplifier does, and
    # what differs between hits in different places.
    clear = np.interp(off, CLEAR, (0.0, 1.0)) * ~found["harmonic"] if n_hits == 1 else np.zeros(off.shape)
    needed = rule.min_share + IN_COMPANY * company * (1.0 - clear)
    more *= 1.0 - clear * np.interp(company, CONFIRMED, (0.0, 1.0))
    return np.select(
        [
            share < needed,
            np.abs(found["damping_ratio"]) > rule.max_damping,
            off < -OFF_AXIS,
            (share >= needed + more) & (off > OFF_AXIS),
            found["rise_db"] < RISE_DB,
            found["depth_db"] < DEPTH * rule.min_depth_db,
        ],
        [IN_TOO_FEW, TOO_DAMPED, AT_A_LINE, "", IN_NOISE, NO_DIP],
        "",
    )


def _company(strong: NDArray[np.void], found: NDArray[np.void], n_rows: int) -> FloatArray:
    """Which part of the other responses has one of the strong candidates where each of those found is."""
    near = np.abs(strong["freq_hz"][:, None] / found["freq_hz"] - 1.0) <= BESIDE
    have = [near[strong["row"] == row].any(axis=0) & (found["row"] != row) for row in range(n_rows)]
    return np.asarray(np.sum(have, axis=0) / max(n_rows - 1, 1))


def _survey(look: Look) -> _Surveyed:
    """Fits to the unperturbed vectors, and what they leave of each response at each line."""
    left = np.zeros(look.vectors.shape[1:])
    count = np.zeros(look.freq_hz.size)
    found = []
    for ratio, least, orders in SCALES:
        over = stretches(look.freq_hz, ratio, least)
        own = fits(over, look.freq_hz, [look.vectors[:1, one.lines] for one in over], look.weights, orders)
        for one in own:
            lines = one.stretch.lines
            v = look.vectors[0, lines]
            along = np.sum(one.fitted.conj() * v, axis=1, keepdims=True)
            left[lines] += np.abs(v - one.fitted * along) ** 2
            count[lines] += 1
        found.append(own)
    some = count > 0
    noise = np.stack(
        [np.interp(look.freq_hz, look.freq_hz[some], row[some] / count[some]) for row in left.T], axis=1
    )
    width = min(NOISE_LINES, look.freq_hz.size // 8)
    kernel = np.ones(width)
    share = np.convolve(np.ones(len(noise)), kernel, "same")
    noise = np.stack([np.convolve(row, kernel, "same") / share for row in np.maximum(noise, look.noise).T], 1)
    return _Surveyed(look, found, noise)


def moved(zeros: ComplexArray, decay_per_s: float) -> tuple[FloatArray, FloatArray]:
    """Frequencies and damping ratios of zeros in Hz, less the decay of an exponential window."""
    z = zeros - 1j * decay_per_s / (2.0 * np.pi)
    size = np.abs(z)
    return np.where(z.real > 0.0, size, -1.0), z.imag / np.maximum(size, 1e-300)


def interior(stretch: Stretch, freq_hz: FloatArray) -> tuple[float, float]:
    """The part of a stretch in which its zeros count; at the ends of the band all of it."""
    margin = MARGIN * (stretch.high_hz - stretch.low_hz)
    low = stretch.low_hz if stretch.low_hz <= freq_hz[0] else stretch.low_hz + margin
    high = stretch.high_hz if stretch.high_hz >= freq_hz[-1] else stretch.high_hz - margin
    return low, high


@dataclass(frozen=True)
class _Sightings:
    """Zeros of the unperturbed fits: (row, frequency, order, damping), and the interior of every fit."""

    zeros: FloatArray
    interiors: FloatArray


def _sightings(one: _Surveyed, band_hz: tuple[float, float]) -> _Sightings:
    found, interiors = [], []
    n_rows = one.look.vectors.shape[2]
    for own, (_, _, orders) in zip(one.fits, SCALES, strict=True):
        for local in own:
            low, high = interior(local.stretch, one.look.freq_hz)
            for order in orders:
                freq, damping = moved(local.zeros(order, list(range(n_rows)))[0], one.look.decay_per_s)
                row, which = np.nonzero(
                    (np.abs(damping) < MOST_DAMPING)
                    & (freq >= max(low, band_hz[0]))
                    & (freq <= min(high, band_hz[1]))
                )
                columns = (row, freq[row, which], np.full(row.size, order), damping[row, which])
                found.append(np.stack(columns, axis=1))
                interiors.append((low, high))
    return _Sightings(np.concatenate(found), np.array(interiors))


def _candidates(sightings: list[_Sightings], row: int) -> list[float]:
    """Frequencies that enough of the fits of one look have; the most frequent claims its neighbours."""
    values: list[float] = []
    for one in sightings:
        freq = np.sort(one.zeros[one.zeros[:, 0] == row, 1])
        free = np.ones(freq.size, dtype=bool)
        first = np.searchsorted(freq, freq * (1.0 - ONE_CANDIDATE))
        last = np.searchsorted(freq, freq * (1.0 + ONE_CANDIDATE), side="right")
        for i in np.argsort(first - last, kind="stable"):
            group = slice(first[i], last[i])
            if not free[i]:
                continue
            near = freq[group][free[group]]
            free[group] = False
            could = np.sum((one.interiors[:, 0] <= freq[i]) & (one.interiors[:, 1] >= freq[i]))
            if near.size >= LEAST_SIGHTINGS * max(int(could), 1):
                values.append(float(np.median(near)))
    merged: list[float] = []
    for value in sorted(values):
        if not merged or value / merged[-1] - 1.0 > ONE_CANDIDATE:
            merged.append(value)
    return merged


@dataclass(frozen=True)
class _Zeros:
    """Zeros of one response in the perturbed fits of one scale around a place.

    ``both`` (2, n_fits, n_zeros) are frequencies, infinite where damped too much, and damping ratios;
    ``parts`` the fits of one stretch and order; ``decay_per_s`` is of the window.
    """

    both: FloatArray
    parts: list[slice]
    decay_per_s: float


@dataclass(frozen=True)
class _Seen:
    """What the perturbed fits of one look see of a candidate: its frequency over all scales that see it well,
    and the nearest zero of every fit of the best, (2, n_fits), NaN where none is near."""

    share: float
    freq_hz: float
    nearest: FloatArray
    zeros: _Zeros

    @property
    def fits(self) -> int:
        """How many fits see it."""
        return int(np.isfinite(self.nearest[0]).sum())

    @property
    def damping_ratio(self) -> float:
        """Of the median fit."""
        return float(np.nanmedian(self.nearest[1]))

    @property
    def scatter(self) -> FloatArray:
        """Of frequency and damping within one stretch and order: halves scatter about the whole as the whole
        about the truth."""
        own = [self.nearest[:, part] for part in self.zeros.parts]
        each = [np.nanstd(part, axis=1) for part in own if np.isfinite(part[0]).sum() > 1]
        return np.asarray(np.median(each, axis=0)) if each else np.zeros(2)

    @property
    def off_axis(self) -> float:
        """Standard deviations by which it is further from the axis of its window than the window's decay."""
        window = self.zeros.decay_per_s / (2.0 * np.pi * self.freq_hz)
        return float((abs(self.damping_ratio + window) - window) / max(self.scatter[1], 1e-9))


def _perturbed(
    one: _Surveyed, places: list[tuple[int, float]], rng: np.random.Generator
) -> list[list[_Zeros]]:
    """Zeros of the perturbed fits of one look around each of the places (row, frequency), by scale."""
    look = one.look
    views = look.vectors[1:] if len(look.vectors) > 1 else noisy(look.vectors[0], one.noise, rng)
    middles = [np.array([f.stretch.middle_hz for f in own]) for own in one.fits]
    widths = [np.array([f.stretch.high_hz - f.stretch.low_hz for f in own]) for own in one.fits]
    asked: dict[tuple[int, int], list[int]] = {}
    for i, (_, value) in enumerate(places):
        for scale, (middle, width) in enumerate(zip(middles, widths, strict=True)):
            off = np.abs(middle - value) / width
            for which in np.argsort(off, kind="stable")[:JUDGES]:
                if off[which] < MIDDLE or len(off) == 1:
                    asked.setdefault((scale, int(which)), []).append(i)
    found: list[list[list[FloatArray]]] = [[[] for _ in SCALES] for _ in places]
    vectors = np.concatenate([look.vectors[:1], views])
    there = np.any(views != 0.0, axis=1)
    for scale, (_, _, orders) in enumerate(SCALES):
        places_of = [which for at, which in asked if at == scale]
        over = [one.fits[scale][which].stretch for which in places_of]
        at_lines = [vectors[:, stretch.lines] for stretch in over]
        fitted = fits(over, look.freq_hz, at_lines, look.weights, orders) if over else []
        for which, local in zip(places_of, fitted, strict=True):
            some = asked[scale, which]
            rows = sorted({places[i][0] for i in some})
            left = [float(np.median(local.misfit[order])) for order in orders]
            most = UNDERFIT * left[-1] if look.n_hits else np.inf
            for order in (order for order, own in zip(orders, left, strict=True) if own <= most):
                freq, damping = moved(local.zeros(order, rows)[1:], look.decay_per_s)
                freq = np.where(np.abs(damping) < 1.5 * MOST_DAMPING, freq, np.inf)
                both = np.full((2, *freq.shape[:2], orders[-1]), np.inf)
                both[..., :order] = freq, damping
                for i in some:
                    row = places[i][0]
                    found[i][scale].append(both[:, there[:, row], rows.index(row)])
    return [
        [_Zeros(np.concatenate(parts, axis=1), _runs(parts), look.decay_per_s) for parts in by_scale if parts]
        for by_scale in found
    ]


def _runs(parts: list[FloatArray]) -> list[slice]:
    """Where each of the parts lies when they are joined along their second axis."""
    ends = np.cumsum([part.shape[1] for part in parts]).tolist()
    return [slice(low, high) for low, high in zip([0, *ends[:-1]], ends, strict=True)]


def _seen(by_scale: list[_Zeros], value: float) -> _Seen | None:
    """What the fits of one look see within reach of a frequency; None if nothing."""
    each = []
    for zeros in by_scale:
        freq, damping = zeros.both
        off = np.abs(freq / value - 1.0)
        at, best = np.arange(len(off)), np.argmin(off, axis=1)
        good = off[at, best] <= SEEN_WITHIN
        if good.any():
            nearest = np.where(good, [freq[at, best], damping[at, best]], np.nan)
            each.append(_Seen(float(good.mean()), float(np.nanmedian(nearest[0])), nearest, zeros))
    if not each:
        return None
    best_of = max(each, key=lambda one: one.share)
    freq_hz, share = np.array([(one.freq_hz, one.share) for one in each]).T
    well = share >= COUNTS_IN_DIP * best_of.share
    return replace(best_of, freq_hz=float(np.average(freq_hz[well], weights=share[well])))


def noisy(vectors: ComplexArray, noise: FloatArray, rng: np.random.Generator) -> ComplexArray:
    """Views with noise of this power added, in every second one a channel left out."""
    drawn = rng.standard_normal((2, VIEWS, *vectors.shape))
    return leave_out(vectors + (drawn[0] + 1j * drawn[1]) * np.sqrt(0.5 * noise))


def leave_out(views: ComplexArray) -> ComplexArray:
    """Unit vectors, every second with one channel left out, where at least two remain."""
    views = np.where(left_out(len(views), views.shape[2])[:, None], 0.0, views)
    norm = np.linalg.norm(views, axis=2, keepdims=True)
    return np.asarray(views / np.maximum(norm, 1e-300))


def left_out(n_views: int, n_rows: int) -> NDArray[np.bool_]:
    """Which channel each view leaves out, (n_views, n_rows)."""
    view, channel = np.arange(n_views)[:, None], np.arange(n_rows)
    return np.asarray((n_rows > 2) & (view % 2 == 1) & ((view // 2) % n_rows == channel))


def _rise_db(one: _Surveyed, row: int, value: float) -> float:
    """How far a response rises over its noise on the lower of both sides of a value."""
    return _flank_db(one, row, value, one.noise[:, row])


def _depth_db(one: _Surveyed, row: int, value: float) -> float:
    """How far a response falls from the lower of both sides to a value, as a share of all responses."""
    power = np.abs(one.look.vectors[0, :, row]) ** 2
    smooth = running_mean(power, 3)
    near = np.abs(one.look.freq_hz - value) <= AT_VALUE * value
    near[np.argmin(np.abs(one.look.freq_hz - value))] = True
    return _flank_db(one, row, value, np.full(power.size, float(smooth[near].min())))


def _flank_db(one: _Surveyed, row: int, value: float, over: FloatArray) -> float:
    power = np.abs(one.look.vectors[0, :, row]) ** 2 / np.maximum(over, 1e-300)
    sides = []
    for sign in (-1.0, 1.0):
        rises = [0.0]
        for near, far in FLANKS:
            low, high = sorted((value * (1.0 + sign * near), value * (1.0 + sign * far)))
            inside = (one.look.freq_hz >= low) & (one.look.freq_hz <= high)
            if inside.sum() > 1:
                rises.append(float(np.median(power[inside])))
        sides.append(max(rises))
    return float(10.0 * np.log10(max(min(sides), 1e-30)))


def _apart(found: NDArray[np.void], surveyed: list[_Surveyed], min_share: float) -> NDArray[np.void]:
    """One entry a dip: where a response does not rise over its noise between values, noise has split one.

    It keeps the largest share; its frequency is the median by share, and its error holds their scatter.
    Values that one zero of a fit cannot stand for stay, if so many fits must have both (at least the sum of
    the shares less one).
    """
    dips: list[list[NDArray[np.void]]] = []
    for one in found[np.argsort(-found["share"], kind="stable")]:
        for dip in dips:
            first = dip[0]
            if first["row"] != one["row"]:
                continue
            ends = float(first["freq_hz"]), float(one["freq_hz"])
            both = first["share"] + one["share"] - 1.0
            if both >= min_share and abs(ends[1] / ends[0] - 1.0) > TWO_FROM:
                continue
            between = max(_between_db(each, int(one["row"]), *ends) for each in surveyed)
            if between < BETWEEN_DB:
                near = abs(ends[1] / ends[0] - 1.0) <= ONE_DIP_WITHIN
                counts = one["share"] >= COUNTS_IN_DIP * first["share"]
                if near and counts and between < SPLIT_DB:
                    dip.append(one)
                break
        else:
            dips.append([one])
    kept = np.array([dip[0] for dip in dips], dtype=CANDIDATE)
    for entry, dip in zip(kept, dips, strict=True):
        freq, share = np.array(sorted((one["freq_hz"], one["share"]) for one in dip)).T
        entry["freq_hz"] = np.interp(0.5 * share.sum(), np.cumsum(share) - 0.5 * share, freq)
        off = freq - entry["freq_hz"]
        entry["std_hz"] = max(entry["std_hz"], np.sqrt(np.average(off**2, weights=share)))
    return kept[np.lexsort((kept["freq_hz"], kept["row"]))]


def _between_db(one: _Surveyed, row: int, a_hz: float, b_hz: float) -> float:
    """How far a response rises over its noise between two values, two lines together."""
    low, high = sorted((a_hz, b_hz))
    if high / low - 1.0 < APART:
        return -np.inf  # too few lines to tell
    inside = np.flatnonzero((one.look.freq_hz > low) & (one.look.freq_hz < high))
    if inside.size < 3:
        return -np.inf  # too few lines to tell
    power = np.abs(one.look.vectors[0, inside, row]) ** 2 / np.maximum(one.noise[inside, row], 1e-300)
    return float(10.0 * np.log10(max(np.max(np.minimum(power[1:], power[:-1])), 1e-30)))
