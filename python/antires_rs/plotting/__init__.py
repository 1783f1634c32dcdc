"""Pictures, with matplotlib (``pip install "antires-rs[plot]"``).

Every function draws into ``ax`` and returns it. Without ``ax`` it makes a new pyplot figure, so that
``plt.show()`` and notebooks display it as usual; no style, backend or rcParam is ever changed. Colours are
those of Okabe and Ito, and no curve, bar or mark is told from another by colour alone. :func:`data_of` gives
the numbers behind any of them. Uses the values that are drawn, and ``support``; nothing is computed here but
what a picture needs.
"""

from .canvas import data_of
from .chain import plot_chain
from .comparison import plot_comparison
from .convergence import plot_convergence
from .damage import plot_damage
from .damages import plot_damages
from .damping_clusters import plot_damping_clusters
from .detectability import plot_detectability
from .differences import plot_differences
from .frame import plot_frame
from .hypotheses import plot_hypotheses
from .identifiability import plot_identifiability
from .monitor import plot_monitor
from .plan import plot_plan
from .responses import plot_responses
from .spectra import plot_coherence, plot_singular_values
from .stabilization import plot_stabilization
from .tracks import plot_tracks
from .transmissibility import plot_transmissibility

__all__ = [
    "data_of",
    "plot_chain",
    "plot_coherence",
    "plot_comparison",
    "plot_convergence",
    "plot_damage",
    "plot_damages",
    "plot_damping_clusters",
    "plot_detectability",
    "plot_differences",
    "plot_singular_values",
    "plot_frame",
    "plot_hypotheses",
    "plot_identifiability",
    "plot_monitor",
    "plot_plan",
    "plot_stabilization",
    "plot_tracks",
    "plot_responses",
    "plot_transmissibility",
]
