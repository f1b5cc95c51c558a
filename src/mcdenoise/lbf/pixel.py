"""Chapter 09: the chain rule at one pixel, term by term, in plain functions of arrays; and one epoch on one image.

    weights of the network -> z -> theta = softplus(z) -> c_hat -> E

    dE/dw = sum_m [ sum_q dE/dc_hat_q  dc_hat_q/dtheta_m ] dtheta_m/dz_m dz_m/dw

`FilterLayer` does the same for all pixels at once, and without keeping the weights.
"""

from __future__ import annotations

import numpy as np

from mcdenoise.lbf.layer import FilterLayer
from mcdenoise.nn import MLP, RPROP


def filter_pixel(theta: np.ndarray, distances: np.ndarray, colours: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """c_hat = sum_j w_j c_j / sum_j w_j,   w_j = exp(-sum_m theta_m E_mj), for one pixel.

    Parameters
    ----------
    theta : (m,), inverse bandwidths, >= 0
    distances : (m, n), E_mj of the pixel to each of its n neighbours; the pixel itself is one of them, at distance 0
    colours : (n, 3), noisy radiance of the neighbours

    Returns
    -------
    filtered : (3,)
    weights : (n,)

    Examples
    --------
    >>> filtered, weights = filter_pixel(np.array([0.5]), np.array([[0.0, 2.0]]), np.array([[0.0] * 3, [1.0] * 3]))
    >>> filtered.round(3), weights.round(3)
    (array([0.269, 0.269, 0.269]), array([1.   , 0.368]))
    """
    ### BEGIN SOLUTION
    weights = np.exp(-(theta @ distances))
    return weights @ colours / weights.sum(), weights
    ### END SOLUTION


def filtered_error_gradient(filtered: np.ndarray, reference: np.ndarray, spp: int, epsilon: float) -> np.ndarray:
    """dE/dc_hat_q of the error E = n/2 sum_q (c_hat_q - c_q)^2 / (c_q^2 + epsilon) of one pixel.

    Parameters
    ----------
    filtered, reference : (3,), c_hat and c. spp : n. epsilon : radiance squared, above 0.

    Returns
    -------
    gradient : (3,)

    Examples
    --------
    >>> filtered_error_gradient(np.array([0.5, 0.0, 0.1]), np.array([0.4, 0.0, 0.0]), spp=4, epsilon=0.01).round(3)
    array([ 2.353,  0.   , 40.   ])
    """
    ### BEGIN SOLUTION
    return spp * (filtered - reference) / (reference**2 + epsilon)
    ### END SOLUTION


def filtered_by_theta(theta: np.ndarray, distances: np.ndarray, colours: np.ndarray) -> np.ndarray:
    """dc_hat_q/dtheta_m: how each channel of the filtered colour changes with each theta; minus a weighted covariance.

    Parameters
    ----------
    theta, distances, colours : as for `filter_pixel`.

    Returns
    -------
    jacobian : (m, 3), a row for each theta

    Examples
    --------
    >>> filtered_by_theta(np.array([0.5]), np.array([[0.0, 2.0]]), np.array([[0.0] * 3, [1.0] * 3])).round(3)
    array([[-0.393, -0.393, -0.393]])
    """
    ### BEGIN SOLUTION
    weights = np.exp(-(theta @ distances))
    share = weights / weights.sum()
    filtered = share @ colours
    return -(share * distances) @ (colours - filtered)
    ### END SOLUTION


def softplus_link(d_theta: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """dE/dz from dE/dtheta, where theta = softplus(z) = log(1 + e^z) and z itself is no longer at hand.

    Parameters
    ----------
    d_theta, theta : of one shape; theta >= 0

    Returns
    -------
    d_z : same shape

    Examples
    --------
    >>> softplus_link(np.array([1.0, 1.0, 2.0]), np.array([0.0, np.log(2.0), 50.0])).round(3)
    array([0. , 0.5, 2. ])
    """
    ### BEGIN SOLUTION
    return d_theta * -np.expm1(-theta)
    ### END SOLUTION


def rprop_epoch(
    network: MLP, inputs: np.ndarray, layer: FilterLayer, reference: np.ndarray, optimizer: RPROP, state: dict
) -> tuple[MLP, dict, float]:
    """One epoch on one image: forward through network and filter, the error, back through both, one step of RPROP.

    E = mean over pixels of n/2 sum_q (c_hat_q - c_q)^2 / (c_q^2 + 0.01), n the spp of the image. The network puts out
    theta of everything that the filter compares, in the order of ``layer.names``.

    Parameters
    ----------
    network : (n, inputs) -> (n, names), ends in softplus
    inputs : (n, inputs), a row for each pixel of the layer's rows
    layer : the filter
    reference : (rows, w, 3)
    optimizer, state : from ``optimizer.start(network.parameters)``, or the epoch before

    Returns
    -------
    network : with the parameters after the step. state : for the next epoch. error : E before the step.

    Examples
    --------
    >>> from mcdenoise.lbf.primary import Primary
    >>> from mcdenoise.nn import Softplus
    >>> image = np.random.default_rng(0).random((4, 4, 3))
    >>> layer = FilterLayer(Primary(image, image, {}, {}, {}, spp=4), engine="numpy")
    >>> network = MLP.random([1, 2], output=Softplus(), rng=np.random.default_rng(0))
    >>> state = RPROP(0.1).start(network.parameters)
    >>> for _ in range(3):
    ...     network, state, error = rprop_epoch(network, np.ones((16, 1)), layer, 0 * image + 0.5, RPROP(0.1), state)
    ...     print(round(error, 2))
    0.54
    0.44
    0.34
    """
    theta, saved_by_network = network.forward(inputs)
    filtered, saved_by_layer = layer.forward(theta.reshape(layer.shape))
    spp, pixels, scale = layer.primary.spp, len(inputs), reference**2 + 0.01
    error = spp / 2 * np.sum((filtered - reference) ** 2 / scale) / pixels
    d_theta = layer.backward(spp * (filtered - reference) / scale / pixels, saved_by_layer)
    gradients = network.gradients(d_theta.reshape(theta.shape), saved_by_network)
    parameters, state = optimizer.step(network.parameters, gradients, state)
    return network.replace(parameters), state, float(error)
