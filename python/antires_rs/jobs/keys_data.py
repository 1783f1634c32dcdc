"""Keys of [data] and [identification]."""

from __future__ import annotations

from .formats import ARRAYS, COLUMNS, FOLDER, RECORDS, RESPONSES, SIGNALS
from .key import Key, Section

__all__ = ["DATA", "IDENTIFICATION"]

DATA = Section(
    "data",
    "What was measured. One [[data]] for each position of the force, or a single [data].",
    (
        Key(
            "file",
            "text",
            "The measurement: a file .uff, .unv, .mat, .h5, .csv, .tsv, .txt, .npz, .npy, .tdms, "
            ".lvm, .wav, .xlsx, .parquet or .mseed, a folder of "
            "files of one FRF each, or the .json of 'antires identify'. Relative to this job file.",
            required=True,
        ),
        Key(
            "repeats",
            "texts",
            "Further files of the same test, other impacts or runs, in the same format; * stands for "
            "anything. They are averaged with the first.",
            of=SIGNALS,
        ),
        Key(
            "format",
            "text",
            "One of uff, mat, hdf5, csv, npz, tdms, lvm, wav, excel, parquet, miniseed, "
            "antiresonances. By default the ending tells.",
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
            "drop",
            "texts",
            'Values to leave out, "DOF=HZ why", each the one within 1 % of it: "3=31.9 mains hum".',
        ),
        Key("add", "texts", "Values that are added, in the same way."),
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
            of=("mat", "hdf5", "npz", "csv", "tdms", "lvm", "excel", "parquet"),
        ),
        Key(
            "kind",
            "text",
            '"frf" or "transmissibility" (for UFF also "time" and "spectra"): what to read '
            "where a file does not tell or holds several.",
            of=RESPONSES,
        ),
        Key("reference", "dof", "Reference of transmissibilities.", of=RESPONSES),
        Key(
            "responses",
            "texts",
            "Arrays or channels of the responses; * stands for anything.",
            of=(*ARRAYS, *RECORDS, FOLDER),
        ),
        Key("time", "text", "Array of time in s.", of=ARRAYS),
        Key("freq", "text", "Array of frequencies in Hz.", of=(*ARRAYS, FOLDER)),
        Key(
            "df_hz",
            "number",
            "Spacing in Hz of FRFs from 0 Hz on, where the file has no axis.",
            of=(*ARRAYS, *COLUMNS, FOLDER),
        ),
        Key(
            "freq_hz",
            "numbers",
            "Frequencies in Hz of FRFs, in place of df_hz.",
            of=(*ARRAYS, *COLUMNS, FOLDER),
        ),
        Key(
            "roving",
            "text",
            'The sensor that stayed while the hammer roved, as "5+Z", of a universal file with the FRFs of '
            "all hits: by reciprocity they are those of a force at that sensor, the excitation then. "
            "Hits in files of their own are a [[data]] each.",
            of=("uff",),
        ),
        Key("pattern", "text", 'Which files of the folder, as "*.csv".', '"*"', of=(FOLDER,)),
        Key(
            "run",
            "whole",
            "Which run, from 1, where points were recorded several times; which segment of an .lvm.",
            of=("uff", "lvm", FOLDER),
        ),
        Key(
            "pairs",
            "text",
            '"real_imag", "magnitude_deg", "magnitude_rad", "db_deg" or "db_rad": what two neighbouring '
            "columns are, where their names do not tell.",
            of=(*COLUMNS, FOLDER),
        ),
        Key("first", "text", 'What the first column is: "time", "freq" or "channel".', of=(*COLUMNS, FOLDER)),
        Key("sheet", "text", "Sheet of an Excel workbook.", "the first", of=("excel", FOLDER)),
        Key("full_scale", "number", "What full scale of a WAV file stands for, in unit.", "1", of=("wav",)),
        Key("delimiter", "text", "What stands between columns.", of=("csv", FOLDER)),
        Key("decimal", "text", "Decimal sign.", of=("csv", FOLDER)),
        Key(
            "partial",
            "switch",
            "Whether to read what is whole of a file that was cut.",
            "false",
            of=("uff", "csv", "tdms", "lvm", FOLDER),
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
        Key(
            "formulation",
            "text",
            '"auto", "windows", "numerators", "joint", "power", "eq10" or "eq10_squared".',
            '"auto"',
        ),
        Key("estimator", "text", '"rank1", "h1", "h2" or "hv".', '"rank1"'),
        Key("method", "text", '"auto", "welch" for random records, "transient" for impacts.', '"auto"'),
        Key("nperseg", "whole", "Samples in a segment; by default chosen from the data."),
        Key("noverlap", "whole", "Samples shared by neighbouring segments; by default half."),
        Key("window", "text", "Window of the segments.", '"hann"'),
        Key("min_order", "whole", "Lowest order of the stabilization diagram.", "2"),
        Key(
            "max_order",
            "whole",
            "Highest order of the stabilization diagram; by default as the data want. Of fits over windows "
            "16 at most.",
        ),
        Key(
            "freq_tol",
            "number",
            "Relative change of frequency from order to order that counts as stable.",
            "0.01",
        ),
        Key("damping_tol", "number", "The same for damping; of the sweep over orders, as min_rows.", "0.1"),
        Key(
            "min_rows", "whole", "An antiresonance must be stable in more consecutive orders than this.", "10"
        ),
        Key("max_damping", "number", "Largest damping ratio of an antiresonance.", "0.1"),
        Key(
            "min_dominance",
            "number",
            "How much of the curve a value must own, in the sweep over orders.",
            "0.05",
        ),
        Key(
            "min_share",
            "number",
            "Share of the fits over windows (curves, single impacts) that must see a value.",
            "0.5",
        ),
        Key(
            "min_depth_db",
            "number",
            "Depth in dB of the dip that a value must make, in fits over windows.",
            "3.0",
        ),
        Key(
            "persistent",
            "switch",
            "Whether the sweep accepts values that are there at most orders without being stable.",
            "true",
        ),
        Key("keep_common", "switch", "Whether to keep values that all channels share.", "false"),
        Key("cross_check", "text", '"aaa" or "vector_fitting": another method that confirms or flags.'),
        Key("second_opinion", "text", "The older name of cross_check."),
        Key("check", "text", 'What to do about data that are not fit: "warn", "raise" or "off".', '"warn"'),
    ),
)
