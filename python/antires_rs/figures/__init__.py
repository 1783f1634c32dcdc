"""Pictures, with matplotlib (``pip install "antires-rs[plot]"``); the report and the page draw them by bokeh.

Every function draws into the matplotlib axes ``ax`` and returns them. Without them it makes a pyplot figure,
so that ``plt.show()`` and notebooks display it as usual; no style, backend or rcParam is ever changed. Where
matplotlib is missing ``MissingDependencyError`` says so. Colours are those of Okabe and Ito; no curve, bar
or mark is told from another by colour alone.
"""

from ..support.messages import names_left
from .damage import *
from .identification import *
from .mesh import *
from .planning import *
from .responses import *
from .sets import *
from .structure import *
from .updating import *

__all__ = sorted(name for name in globals() if name.startswith(("plot_", "write_")))

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
