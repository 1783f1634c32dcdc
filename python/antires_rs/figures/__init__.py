"""Pictures, with matplotlib (``pip install "antires-rs[plot]"``); the report and the page draw them by bokeh.

Every function draws into the matplotlib axes ``ax`` and returns them. Without them it makes a pyplot figure,
so that ``plt.show()`` and notebooks display it as usual; no style, backend or rcParam is ever changed. Where
matplotlib is missing ``MissingDependencyError`` says so. Colours are those of Okabe and Ito; no curve, bar
or mark is told from another by colour alone.
"""

from ..support.messages import names_left
from .damage import plot_damage, plot_hypotheses
from .identification import plot_singular_values, plot_stabilization
from .mesh import plot_mesh, write_mesh
from .planning import plot_detectability, plot_plan
from .responses import plot_responses
from .sets import plot_comparison, plot_monitor, plot_tracks
from .structure import plot_chain, plot_frame
from .updating import plot_convergence, plot_differences, plot_identifiability

__all__ = [
    "plot_chain", "plot_comparison", "plot_convergence", "plot_damage", "plot_detectability",
    "plot_differences", "plot_frame", "plot_hypotheses", "plot_identifiability", "plot_mesh", "plot_monitor",
    "plot_plan", "plot_responses", "plot_singular_values", "plot_stabilization", "plot_tracks", "write_mesh",
]  # fmt: skip

__getattr__ = names_left(
    __name__,
    {
        "data_of": "the numbers are attributes of what is drawn, such as result.severity",
        "plot_coherence": "the page of `antires look` draws the coherence, resp.coherence has it",
        "plot_damages": "each result draws its own, result.plot(ax=...)",
        "plot_damping_clusters": "diagram.plot() draws the poles, diagram.damping_ratio has their damping",
        "plot_transmissibility": "write plot_responses(..., dofs=[dof])",
    },
)
