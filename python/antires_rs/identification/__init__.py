r"""From records or measured curves to antiresonances, and to modes.

Under one force at k all responses are :math:`X_p = N_{pk} F / D`: the zeros of the numerators are the
antiresonances, and they are the poles of every :math:`T_{pj} = N_{pk} / N_{jk}`. ``identify`` is the call;
averaged records go through one fit of all numerators, impacts and given curves through fits over windows.

Reference: V. Meruane, J. Sound Vib. 332 (2013) 807-820, section 3.
"""
