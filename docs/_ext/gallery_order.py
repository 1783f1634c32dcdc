"""Order of the gallery: the cases of the paper, measured structures, then one idea each."""

STORY = (
    "chain8_damage",
    "chain8_update",
    "exhaust_update",
    "exhaust_damage",
    "southampton_frame",
    "brake_reuss_beam",
    "transmissibility",
    "estimators",
    "stabilization",
    "data_check",
    "uncertainty",
    "what_is_not_seen",
    "two_objectives",
    "own_matrices",
    "frame_model",
    "optimizer",
)


class Story:
    """Key by which sphinx-gallery sorts; new examples come last."""

    def __init__(self, src_dir):
        pass

    def __call__(self, filename):
        """Place in the story, then the name."""
        name = filename.removeprefix("plot_").removesuffix(".py")
        return (STORY.index(name) if name in STORY else len(STORY), name)
