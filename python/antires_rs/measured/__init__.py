"""What a test gave: antiresonances by response, or resonances with their shapes.

The values in which the signal side and the models meet: identification makes them, updating takes them. A set
of antiresonances keeps edits by hand on record, and sets of several tests are compared, tracked and merged
here. No record is known here, and no structure.
"""
