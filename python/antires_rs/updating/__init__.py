"""Model updating: models, measured values and the search meet here.

``problem`` states it, ``update`` is the call; what the data tell about the parameters, and what not, stands
beside the result.

Reference: V. Meruane, J. Sound Vib. 332 (2013) 807-820, Eqs. 11-18.
"""
