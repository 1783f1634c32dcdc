"""Keys of [updating], [damage], [search] and [output]."""

from __future__ import annotations

from .key import Key, Section

__all__ = ["DAMAGE", "OUTPUT", "SEARCH", "UPDATING"]

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
        Key(
            "baseline",
            "texts",
            "The intact structure: measurements as in [data], identified with the same options, or the .json "
            "of 'antires identify'; with several [[data]] one for each; * takes records of one test. With it "
            "changes are compared, and errors of the model do not count as damage.",
        ),
        Key("elements", "terms", 'Candidates: "all" or a list such as [0, 1, 2].', '"all"'),
        Key(
            "false_alarm_rate",
            "number",
            "With a baseline: share of intact tests in which damage may be declared, up to 0.5; by default "
            "damage is declared where it is more probable than none.",
        ),
        Key(
            "std_common",
            "number",
            "With a baseline: relative standard deviation of what moves all values alike between two tests, "
            "such as temperature; up to 0.1.",
            "0.0005",
        ),
        Key(
            "prior",
            "shares",
            "With a baseline: probabilities before the test that add up to one, { nothing = 0.5, one = 0.3, "
            "two = 0.1, three = 0.03, elsewhere = 0.05, unknown = 0.02 } by default.",
        ),
        Key(
            "gamma1",
            "number",
            "Without a baseline: price of a unit of stiffness loss; by default 0.1 for 28 values.",
        ),
        Key(
            "gamma2",
            "number",
            "Without a baseline: price of each damaged element; by default 0.1 for 28 values.",
        ),
        Key("snap", "number", "Without a baseline: losses below it are exactly 0.", "0.001"),
        Key("weights", "text", 'Without a baseline: "std", so that what is known badly counts less.'),
    ),
)

SEARCH = Section(
    "search",
    "The search. The same seed gives bit-identical results for any number of workers.",
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
            "Whether a local search polishes the islands' bests; false leaves it out.",
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
