"""Chapters 07 and 08: from the perceptron to a network with a backward pass of our own. No library takes a derivative here.

Use it by the front door:

>>> import mcdenoise as mcd
>>> import numpy as np
>>> x = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]])
>>> target = np.array([[0.0], [1.0], [1.0], [0.0]])
>>> start = mcd.nn.MLP.random([2, 3, 1], hidden=mcd.nn.Tanh(), rng=np.random.default_rng(0))
>>> done = mcd.nn.train(start, x, target, loss=mcd.nn.CrossEntropy(), optimizer=mcd.nn.RPROP(0.1), epochs=50)
>>> (done.network.forward(x)[0] > 0).ravel()
array([False,  True,  True, False])
"""

from mcdenoise.nn.datasets import checker, rings, two_moons, xor
from mcdenoise.nn.gradcheck import GradientError, Pair, check_gradient
from mcdenoise.nn.layers import Layer, Linear, ReLU, Sigmoid, Softplus, Step, Tanh
from mcdenoise.nn.losses import CrossEntropy, Loss, RelativeError, SquaredError
from mcdenoise.nn.network import MLP
from mcdenoise.nn.optimizers import RPROP, SGD, Adam
from mcdenoise.nn.perceptron import Perceptron, PerceptronTraining, all_of, any_of, half_planes, train_perceptron
from mcdenoise.nn.scalar import Scalar
from mcdenoise.nn.storage import load_network, save_network
from mcdenoise.nn.training import Diverged, Training, loss_and_gradients, train

__all__ = [
    "MLP",
    "RPROP",
    "SGD",
    "Adam",
    "CrossEntropy",
    "Diverged",
    "GradientError",
    "Layer",
    "Linear",
    "Loss",
    "Pair",
    "Perceptron",
    "PerceptronTraining",
    "ReLU",
    "RelativeError",
    "Scalar",
    "Sigmoid",
    "Softplus",
    "SquaredError",
    "Step",
    "Tanh",
    "Training",
    "all_of",
    "any_of",
    "check_gradient",
    "checker",
    "half_planes",
    "load_network",
    "loss_and_gradients",
    "rings",
    "save_network",
    "train",
    "train_perceptron",
    "two_moons",
    "xor",
]
