"""The figures of chapter 08, back propagation, in the order of the lecture."""

from mcdenoise.study.figures._ch08_capacity import capacity_denoise, capacity_plane
from mcdenoise.study.figures._ch08_checks import faults, kinks, step
from mcdenoise.study.figures._ch08_depth import dead, depth, precision
from mcdenoise.study.figures._ch08_graphs import neuron, patterns, slider_steps, twice
from mcdenoise.study.figures._ch08_losses import losses, relative, saturation
from mcdenoise.study.figures._ch08_matrices import batch_shapes, jacobians, never_built, two_layer
from mcdenoise.study.figures._ch08_training import optimizers, rates, slider_bowl, slider_curve

FIGURES = {
    "slider_steps": slider_steps,
    "patterns": patterns,
    "neuron": neuron,
    "twice": twice,
    "jacobians": jacobians,
    "never_built": never_built,
    "batch_shapes": batch_shapes,
    "two_layer": two_layer,
    "losses": losses,
    "relative": relative,
    "saturation": saturation,
    "step": step,
    "kinks": kinks,
    "faults": faults,
    "optimizers": optimizers,
    "slider_bowl": slider_bowl,
    "rates": rates,
    "slider_curve": slider_curve,
    "depth": depth,
    "dead": dead,
    "precision": precision,
    "capacity_plane": capacity_plane,
    "capacity_denoise": capacity_denoise,
}
