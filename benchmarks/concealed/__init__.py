"""Can `allanfit explain` name what is concealed? A device simulator, a study and its scorer.

Nothing here shares a formula or code with `allanfit.physics`: devices are simulated in the time
domain, at four times the output rate where it matters, and expected spectra are written anew.
"""
