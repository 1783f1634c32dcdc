"""Every section and key of a job file: what it holds, and the sentence that explains it.

The same sentences are the comments of ``antires init`` and the remedies of the messages.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import PurePath

__all__ = ["CHAIN", "FORMATS", "FRAME", "MATRICES", "RESULT", "SECTIONS", "Key", "Section", "format_of"]


@dataclass(frozen=True)
class Key:
    """One key.

    Attributes
    ----------
    name : str
    kind : str
        One of :data:`antires_rs.jobs.values.KINDS`.
    help : str
        A sentence: what belongs here.
    default : str
        As it would be written; '' where there is none.
    required : bool
    of : tuple of str
        Kinds of model or parameter, or formats, to which the key belongs; empty for all.
    """

    name: str
    kind: str
    help: str
    default: str = ""
    required: bool = False
    of: tuple[str, ...] = ()

    @property
    def explanation(self) -> str:
        """The sentence, and to what the key belongs."""
        if not self.of:
            return self.help
        first = self.help[0].lower() if self.help[1].islower() else self.help[0]
        return f"For {', '.join(self.of)}: {first}{self.help[1:]}"


@dataclass(frozen=True)
class Section:
    """One table of a job.

    Attributes
    ----------
    name : str
    help : str
    keys : tuple of Key
    several : {"no", "may", "must"}
        Whether it is an array of tables, [[name]].
    """

    name: str
    help: str
    keys: tuple[Key, ...]
    several: str = "no"

    def key(self, name: str) -> Key | None:
        """The key of that name."""
        return next((key for key in self.keys if key.name == name), None)


def format_of(name: str, given: str | None = None) -> str | None:
    """The format named, or that of the file's ending; None where neither is known."""
    if given is not None:
        return given if given in FORMATS else None
    suffix = PurePath(name).suffix.lower()
    return next((kind for kind, endings in FORMATS.items() if suffix in endings), None)


#: Endings of files by format.
FORMATS = {
    "uff": (".uff", ".unv", ".uf", ".u58"),
    "mat": (".mat",),
    "hdf5": (".h5", ".hdf5", ".hdf"),
    "csv": (".csv", ".tsv", ".txt"),
    "npz": (".npz",),
    "antiresonances": (".json",),
}

ARRAYS, SIGNALS = ("mat", "hdf5", "npz"), ("uff", "mat", "hdf5", "csv", "npz")

DATA = Section(
    "data",
    "What was measured. One [[data]] for each position of the force, or a single [data].",
    (
        Key(
            "file",
            "text",
            "The measurement: a file .uff, .unv, .mat, .h5, .csv, .tsv, .txt or .npz, or the "
            ".json of 'antires identify'. Relative to this job file.",
            required=True,
        ),
        Key(
            "format", "text", "One of uff, mat, hdf5, csv, npz, antiresonances. By default the ending tells."
        ),
        Key(
            "excitation",
            "dof",
            "Dof of the model at which the one force acts, or the name of its channel.",
            of=SIGNALS,
        ),
        Key(
            "band_hz",
            "pair",
            "Lowest and highest frequency in Hz: from above the rigid-body modes to beyond "
            "the highest antiresonance wanted.",
            of=SIGNALS,
        ),
        Key(
            "dofs",
            "dofs",
            "Dof of the model for each channel: a list in their order, or name = dof; false "
            'leaves a channel out. Dofs count from 0; those of frames may be named as in "3 v".',
        ),
        Key(
            "unit",
            "text",
            'Unit of the responses, where the file does not tell: "m/s2", "g", "g/N".',
            of=SIGNALS,
        ),
        Key(
            "force",
            "force",
            "Channel of the force; false leaves it out. Antiresonances do not need it.",
            '"auto"',
            of=SIGNALS,
        ),
        Key(
            "fs_hz",
            "number",
            "Sampling rate in Hz, where the file does not tell.",
            of=("mat", "hdf5", "npz", "csv"),
        ),
        Key(
            "kind",
            "text",
            '"frf" or "transmissibility" (for UFF also "time" and "spectra"): what to read '
            "where a file does not tell or holds several.",
            of=SIGNALS,
        ),
        Key("reference", "dof", "Reference of transmissibilities.", of=SIGNALS),
        Key("responses", "texts", "Arrays of the responses; * stands for anything.", of=ARRAYS),
        Key("time", "text", "Array of time in s.", of=ARRAYS),
        Key("freq", "text", "Array of frequencies in Hz.", of=ARRAYS),
        Key("first", "text", 'What the first column is: "time", "freq" or "channel".', of=("csv",)),
        Key("delimiter", "text", "What stands between columns.", of=("csv",)),
        Key("decimal", "text", "Decimal sign.", of=("csv",)),
        Key(
            "partial",
            "switch",
            "Whether to read what is whole of a file that was cut.",
            "false",
            of=("uff", "csv"),
        ),
    ),
    "may",
)

IDENTIFICATION = Section(
    "identification",
    "How antiresonances are identified. The defaults suit most records.",
    (
        Key("preset", "text", '"paper", "strict" or "sensitive": a named set of the options below.'),
        Key("dofs", "list", "Dofs whose antiresonances are used; by default all that were measured."),
        Key(
            "route",
            "text",
            '"transmissibility" reads responses only, "frf" uses a measured force.',
            '"transmissibility"',
        ),
        Key("formulation", "text", '"auto", "numerators", "joint", "power" or "eq10".', '"auto"'),
        Key("estimator", "text", '"rank1", "h1", "h2" or "hv".', '"rank1"'),
        Key("method", "text", '"auto", "welch" for random records, "transient" for single hits.', '"auto"'),
        Key("nperseg", "whole", "Samples in a segment; by default chosen from the data."),
        Key("noverlap", "whole", "Samples shared by neighbouring segments; by default half."),
        Key("window", "text", "Window of the segments.", '"hann"'),
        Key("min_order", "whole", "Lowest order of the stabilization diagram.", "2"),
        Key("max_order", "whole", "Highest order of the stabilization diagram.", "60"),
        Key(
            "freq_tol",
            "number",
            "Relative change of frequency from order to order that counts as stable.",
            "0.01",
        ),
        Key("damping_tol", "number", "The same for damping.", "0.1"),
        Key("min_rows", "whole", "Orders in which a value must be stable.", "10"),
        Key("max_damping", "number", "Largest damping ratio of an antiresonance.", "0.1"),
        Key("min_dominance", "number", "How much of the curve a value must own.", "0.05"),
        Key(
            "persistent",
            "switch",
            "Whether to accept values that are there at most orders without being stable.",
            "true",
        ),
        Key("keep_common", "switch", "Whether to keep values that all channels share.", "false"),
        Key("second_opinion", "text", '"aaa" or "vector_fitting": another method that confirms or flags.'),
        Key("check", "text", 'What to do about data that are not fit: "warn", "raise" or "off".', '"warn"'),
    ),
)

CHAIN, FRAME, MATRICES, RESULT = ("chain", "frame", "matrices", "result")

MODEL = Section(
    "model",
    "The model. Masses, springs, nodes, elements and dofs count from 0.",
    (
        Key(
            "kind",
            "text",
            '"chain" (masses and springs in a row), "frame" (beams), "matrices" (K and M of '
            "any finite-element program), \"result\" (the updated model of 'antires update').",
            required=True,
        ),
        Key("masses_kg", "numbers", "Masses in kg, from the first to the last.", of=(CHAIN,)),
        Key(
            "springs_n_per_m",
            "numbers",
            "Stiffness in N/m of the springs between neighbours, one fewer than masses.",
            of=(CHAIN,),
        ),
        Key(
            "ground_first_n_per_m",
            "number",
            "Spring from the first mass to ground; 0 is a free end. With n "
            'masses it is element n - 1, which "all" leaves out.',
            "0",
            of=(CHAIN,),
        ),
        Key(
            "ground_last_n_per_m",
            "number",
            "Spring from the last mass to ground: element n, left out likewise.",
            "0",
            of=(CHAIN,),
        ),
        Key("nodes_m", "list", "Coordinates of the nodes in m, [x, y] or [x, y, z].", of=(FRAME,)),
        Key("elements", "list", '[node, node, "section"] of each beam.', of=(FRAME,)),
        Key(
            "sections",
            "table",
            'Name = { shape = "tube", outer_diameter_m, thickness_m, youngs_modulus_pa, '
            'density_kg_per_m3 }, "rectangle" with width_m, height_m, or "general" with area_m2, inertia_m4.',
            of=(FRAME,),
        ),
        Key("point_masses", "list", "[node, kg] or [node, kg, inertia in kg m2] of each.", of=(FRAME,)),
        Key(
            "ground_springs",
            "list",
            '[node, "direction", N/m] of each; directions are u, v, theta in the '
            "plane, u, v, w, rx, ry, rz in space.",
            of=(FRAME,),
        ),
        Key(
            "node_springs",
            "list",
            '[node, node, N/m] or [node, node, N/m, "direction"] of each.',
            of=(FRAME,),
        ),
        Key("fixed", "list", 'Nodes, or [node, "direction"], that cannot move.', of=(FRAME,)),
        Key("orientation", "list", "Direction in which the height of the sections points.", of=(FRAME,)),
        Key(
            "file",
            "text",
            "The result.npz of 'antires update', or a file of write_matrices.",
            of=(MATRICES, RESULT),
        ),
        Key("stiffness", "text", "K, as Matrix Market (.mtx) or scipy.sparse (.npz).", of=(MATRICES,)),
        Key("mass", "text", "M, likewise.", of=(MATRICES,)),
        Key(
            "stiffness_terms",
            "texts",
            "The part of K that each element or group contributes.",
            of=(MATRICES,),
        ),
        Key("mass_terms", "texts", "The same for M.", of=(MATRICES,)),
        Key(
            "dof_map",
            "text",
            'Text file with node and direction of each row, so that channels such as "12+Z" find their dof.',
            of=(MATRICES,),
        ),
        Key("first_row", "whole", "Number of the first row in dof_map.", "1", of=(MATRICES,)),
    ),
)

ELEMENTS = ("stiffness_factor", "stiffness_reduction", "angle")
SECTIONED = ("youngs_modulus", "density", "thickness", "diameter")
LUMPED, SUPPORT = ("point_mass", "inertia"), ("support_stiffness",)

PARAMETERS = Section(
    "parameters",
    "What may change in the model: one [[parameters]] for each kind and its bounds.",
    (
        Key(
            "kind",
            "text",
            "stiffness_factor, stiffness_reduction (of elements), mass_factor (of terms); for "
            "frames also youngs_modulus, density, thickness, diameter (of sections), point_mass, inertia (of "
            "masses), support_stiffness (of springs), angle (of elements about a pivot).",
            required=True,
        ),
        Key(
            "bounds",
            "pair",
            "Lower and upper bound: a factor, or a value in SI (degrees for an angle).",
            required=True,
        ),
        Key("elements", "terms", '"all" or a list such as [0, 1, 2].', of=ELEMENTS),
        Key(
            "terms",
            "terms",
            '"all" or a list such as [0, 1, 2]; for a chain, the masses.',
            of=("mass_factor",),
        ),
        Key("sections", "terms", '"all" or a list of names.', of=SECTIONED),
        Key("masses", "terms", '"all" or positions in point_masses.', of=LUMPED),
        Key("springs", "terms", '"all" or positions in ground_springs.', of=SUPPORT),
        Key(
            "together",
            "switch",
            "Whether one parameter acts on all of them.",
            "false",
            of=(*ELEMENTS[:2], "mass_factor", *SECTIONED, *LUMPED, *SUPPORT),
        ),
        Key(
            "relative",
            "switch",
            "Whether bounds are factors on the model's value.",
            "false",
            of=(*SECTIONED, *LUMPED, *SUPPORT),
        ),
        Key("pivot", "whole", "The node about which the elements turn.", of=("angle",)),
        Key("axis", "numbers", "The axis, in space.", "[0, 0, 1]", of=("angle",)),
    ),
    "must",
)

UPDATING = Section(
    "updating",
    "The objective of the updating.",
    (
        Key(
            "misfit",
            "text",
            '"absolute" (a few wrong values do not move it), "squared" or "largest".',
            '"absolute"',
        ),
        Key("weights", "text", '"std": what is known badly counts less.'),
    ),
)

DAMAGE = Section(
    "damage",
    "Where damage is looked for.",
    (
        Key("elements", "terms", 'Candidates: "all" or a list such as [0, 1, 2].', '"all"'),
        Key("gamma1", "number", "Price of a unit of stiffness loss.", "0.1"),
        Key("gamma2", "number", "Price of each damaged element.", "0.1"),
        Key("snap", "number", "Losses below it are exactly 0.", "0.001"),
        Key("weights", "text", '"std": what is known badly counts less.'),
    ),
)

SEARCH = Section(
    "search",
    "The search. The same seed gives the same bits, for any number of workers.",
    (
        Key("seed", "whole", "A whole number of at least 0.", "0"),
        Key("workers", "whole", "Threads; by default all processors."),
        Key("max_seconds", "number", "Longest time; 'antires resume' goes on from there."),
        Key("checkpoint", "switch", "Whether the search is kept on disk while it runs.", "true"),
        Key("max_evaluations", "whole", "Budget of model evaluations.", "200000"),
        Key("max_generations", "whole", "Budget of generations."),
        Key("islands", "whole", "Number of populations.", "4"),
        Key("population", "whole", "Individuals of each.", "40"),
        Key(
            "polish",
            "switch",
            "Whether the islands' bests are polished; false is the paper's algorithm.",
            "true",
        ),
        Key(
            "crossovers",
            "texts",
            'Operators dealt out to the islands: "arithmetic", "heuristic", "blend", "uniform".',
        ),
        Key("crossover_probability", "number", "Of a pair, from 0 to 1.", "0.8"),
        Key("mutation_probability", "number", "Of a gene, from 0 to 1.", "0.02"),
        Key("selection_pressure", "number", "Probability of selecting the best individual.", "0.08"),
        Key("patience", "whole", "Generations without improvement before an island waits.", "40"),
        Key("improvement_tolerance", "number", "Relative gain that counts as improvement.", "1e-4"),
        Key("agreement", "text", '"genes-or-cost" or "genes".', '"genes-or-cost"'),
        Key("gene_tolerance", "number", "Spread of the bests that counts as agreement.", "1e-6"),
        Key("cost_tolerance", "number", "The same for costs, relative.", "1e-6"),
        Key("cost_floor", "number", "The same for costs, absolute.", "1e-12"),
        Key("cost_migrations", "whole", "Migrations in a row for which costs must agree.", "3"),
        Key("polish_interval", "whole", "Generations between two polishes.", "10"),
        Key("polish_evaluations", "whole", "Evaluations after which a polish begins nothing new.", "1000"),
    ),
)

OUTPUT = Section(
    "output",
    "What is written. Files are whole or not there.",
    (
        Key("folder", "text", "Folder of the results, made if need be. Relative to this job file."),
        Key("title", "text", "Heading of the report."),
        Key("report", "switch", "Whether to write report.html.", "true"),
        Key("pictures", "switch", "Whether to write the pictures as PNG too.", "true"),
    ),
)

#: In the order of a job file.
SECTIONS = {
    section.name: section
    for section in (DATA, IDENTIFICATION, MODEL, PARAMETERS, UPDATING, DAMAGE, SEARCH, OUTPUT)
}
