"""Problems of every kind of model, parameter and measurement, for tests that copy, save and send them."""

import numpy as np

import antires_rs as ar

QUICK = ar.IslandGA(max_evaluations=600)
CHAIN = ar.MassSpringChain([1.0, 2.0, 1.5], [500.0, 400.0], ground_first_n_per_m=100.0)
SPRING = np.array([[500.0, -500.0, 0.0], [-500.0, 500.0, 0.0], [0.0, 0.0, 0.0]])


def zeros(model, responses, excitation, scale=1.02, **options):
    found = {i: scale * model.antiresonances(i, excitation, **options) for i in responses}
    return ar.AntiresonanceSet(excitation, found, std_hz={i: 0.01 * f for i, f in found.items()})


PIPE, BAR = (
    ar.Tube(0.03, 0.002, 2.1e11, 7850.0),
    ar.Rectangle(0.03, 0.01, 7e10, 2700.0, shear_coefficient="cowper"),
)
ALONG, BEAMS = [0.25 * i for i in range(5)], [(i, i + 1) for i in range(4)]
CARRIED = {"point_masses": [(4, 0.3, 0.001)], "ground_springs": [(2, "v", 1e4)]}
NAMED = [(i, j, "pipe" if i < 2 else "bar") for i, j in BEAMS]
PLANE = ar.FrameModel([(x, 0.0) for x in ALONG], NAMED, {"pipe": PIPE, "bar": BAR}, fixed=[0], **CARRIED)
SOLID = ar.Section(1e-4, 8e-10, 2.1e11, 7850.0, inertia_y_m4=6e-10, torsion_m4=1e-9)
CARRIED = {"node_springs": [ar.NodeSpring(1, 3, 2e4)], "orientation": [1.0, 0.2, 0.0]}
CARRIED |= {"point_masses": [ar.PointMass(4, 0.2, (1e-3, 2e-3, 3e-3))], "fixed": [0, (4, "w")]}
SPACE = ar.FrameModel([(0.0, 0.0, z) for z in ALONG], BEAMS, [SOLID, SOLID, PIPE, PIPE], **CARRIED)
MATRICES = ar.MatrixModel(CHAIN.stiffness(), CHAIN.mass(), stiffness_terms=[SPRING], mass_terms=[np.eye(3)])
SHAPES = CHAIN.modes()
MODES = ar.ModalSet(1.02 * SHAPES.freq_hz, SHAPES.shapes[:, :2], [0, 1], damping_ratio=[0.01, 0.02, 0.03])
NEAR = {"bounds": (0.8, 1.2)}
OF_PLANE = [
    ar.thickness("pipe", bounds=(0.0015, 0.0025)),
    ar.point_mass(0, bounds=(0.2, 0.4)),
    ar.angle([2, 3], 2, bounds_deg=(-3, 3)),
    ar.support_stiffness(0, bounds=(0.5, 2), relative=True),
]
OF_SPACE = [ar.youngs_modulus(0, bounds=(1.9e11, 2.3e11)), ar.stiffness_factor([1, 2], **NEAR, together=True)]
PROBLEMS = {
    "chain": ar.UpdatingProblem(
        CHAIN, ar.stiffness_factor([0, 2], **NEAR), zeros(CHAIN, [0, 1], 0), weights=np.linspace(0.5, 1.0, 3)
    ),
    "matrices": ar.UpdatingProblem(
        MATRICES,
        [ar.stiffness_reduction(0), ar.mass_factor(0, bounds=(0.9, 1.1))],
        [zeros(MATRICES, [0, 1], 0), zeros(MATRICES, [1], 2)],
        penalty=(0.02, 0.01),
        misfit="squared",
        weights="std",
    ),
    "modes": ar.UpdatingProblem(CHAIN, ar.stiffness_factor([0, 1, 2], **NEAR), MODES),
    "plane frame": ar.UpdatingProblem(PLANE, OF_PLANE, zeros(PLANE, [1, 4], 1, f_max_hz=400.0)),
    "space frame": ar.UpdatingProblem(SPACE, OF_SPACE, zeros(SPACE, [0, 6], 1, f_max_hz=400.0)),
}
